"""Scenes of solids that several tests share, and the volume of a solid."""

import itertools
import math
from typing import Any

import numpy as np

import masonry_opt as mo
from masonry_opt.scene.solids import Polyhedron


def volume(solid: Polyhedron) -> float:
    """Return the volume of a solid from tetrahedra between a corner and triangles of the faces.

    The volume is positive if the faces are counter-clockwise as seen from outside.
    """
    corners = solid.vertices - solid.vertices[0]
    fans = [(face[0], *edge) for face in solid.faces for edge in itertools.pairwise(face[1:])]
    return float(sum(np.linalg.det(corners[list(fan)]) for fan in fans)) / 6


def box_on_floor(
    size: tuple[float, float, float] = (1.0, 2.0, 3.0), friction: float = 0.6, **keys: Any
) -> mo.Scene:
    """Return a box of weight 1 on a fixed floor, with a corner at the origin, pushed along x by 1."""
    a, b, h = size
    properties = {"weight": 1.0, "live": (1.0, 0.0, 0.0)} | keys
    return mo.Scene(
        joints=mo.JointDefaults(friction=friction),
        blocks=[
            mo.box("A", (0, a), (0, b), (0, h), **properties),
            mo.box("floor", (-5, 5 + a), (-5, 5 + b), (-1, 0), fixed=True),
        ],
    )


def pushed_box(size: tuple[float, float, float], friction: float, angle: float) -> mo.Scene:
    """Return a box pushed at its centroid by its weight, at an angle in degrees from x towards y."""
    direction = (math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0.0)
    return box_on_floor(size, friction, live=direction)


def corner_wall(along_x: int, along_y: int, courses: int, friction: float = 0.6) -> mo.Scene:
    """Return two walls of 2 × 1 × 1 blocks that meet in a toothed corner at the origin.

    One wall runs along x and its return along y, with ``along_x`` and ``along_y`` blocks in a course. Every
    other course has half blocks at the free ends. The live load is the weight along -y, away from the return.
    """
    axes = {"x": [(0.5, 0.5), (2 * along_x, 0.5)], "y": [(0.5, 0.5), (0.5, 2 * along_y)]}
    return _pushed_out(axes, courses, friction)


def facade(length: int, depth: int, courses: int, friction: float = 0.6) -> mo.Scene:
    """Return a facade of 2 × 1 × 1 blocks, U-shaped in plan.

    The front has an even length along x. Its toothed returns extend along +y to a depth from its face, and
    their free ends are flush. The live load is the weight, along -y, outwards.
    """
    axes = {"front": [(0.5, 0.5), (length - 0.5, 0.5)]}
    axes |= {f"return {x:g}": [(x, 0.5), (x, depth)] for x in (0.5, length - 0.5)}
    return _pushed_out(axes, courses, friction)


def _pushed_out(axes: dict[str, list[tuple[float, float]]], courses: int, friction: float) -> mo.Scene:
    walls = [mo.PlanWall(name=name, axis=axis) for name, axis in axes.items()]
    plan = mo.Plan(
        block=(2, 1), thickness=1, courses=courses, walls=walls, unit_weight=1, live_per_weight=(0, -1, 0)
    )
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=plan.blocks())

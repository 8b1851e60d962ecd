"""Scenes of solids that several tests share, and what a solid encloses."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

import masonry_opt as mo
from masonry_opt.scene.solids import Polyhedron


def volume(solid: Polyhedron) -> float:
    """By Gauss, from tetrahedra between a corner and triangles of the faces: positive if these are
    counter-clockwise seen from outside."""
    corners = solid.vertices - solid.vertices[0]
    fans = [(face[0], *edge) for face in solid.faces for edge in itertools.pairwise(face[1:])]
    return float(sum(np.linalg.det(corners[list(fan)]) for fan in fans)) / 6


def box_on_floor(
    size: tuple[float, float, float] = (1.0, 2.0, 3.0), friction: float = 0.6, **keys: Any
) -> mo.Scene:
    """A box of weight 1 with a corner at the origin, on a fixed floor, pushed along x by its weight."""
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
    """A box pushed at its centroid by its weight, at an angle in degrees from x towards y."""
    direction = (math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0.0)
    return box_on_floor(size, friction, live=direction)


def corner_wall(along_x: int, along_y: int, courses: int, friction: float = 0.6) -> mo.Scene:
    """Two walls of 2 × 1 × 1 blocks that meet in a toothed corner at the origin, one along x and its return
    along y, so many blocks a course, half blocks at the free ends of every other one; pushed away from
    the return, -y, by their weight."""
    blocks = []
    keys = {"unit_weight": 1, "live_per_weight": (0, -1, 0)}
    for course in range(courses):
        z = (course, course + 1)
        # Through the corner goes the wall in one course, its return in the next.
        for leg, count, start in (("x", along_x, course % 2), ("y", along_y, 1 - course % 2)):
            for number in range(count):
                along = (start + 2 * number, min(start + 2 * number + 2, 2 * count))
                x, y = (along, (0, 1)) if leg == "x" else ((0, 1), along)
                blocks.append(mo.box(f"{leg} {course + 1}-{number + 1}", x, y, z, **keys))
    ground = mo.box("ground", (-1, 2 * along_x + 1), (-1, 2 * along_y + 1), (-1, 0), fixed=True)
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[*blocks, ground])


def facade(length: int, depth: int, courses: int, friction: float = 0.6) -> mo.Scene:
    """A U of blocks 2 × 1 × 1: a front of a length along x, and toothed returns along +y to a depth from its
    face, free ends flush; pushed outwards, -y, by their weight."""
    blocks = []
    for z in range(courses):
        odd = z % 2
        spans = [((start, min(start + 2, length - odd)), (0, 1)) for start in range(odd, length - odd, 2)]
        for x in (0, length - 1):
            spans += [((x, x + 1), (start, min(start + 2, depth))) for start in range(1 - odd, depth, 2)]
        blocks += [
            mo.box(f"{z}-{index}", *span, (z, z + 1), unit_weight=1, live_per_weight=(0, -1, 0))
            for index, span in enumerate(spans)
        ]
    ground = mo.box("ground", (-1, length + 1), (-1, depth + 1), (-1, 0), fixed=True)
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[*blocks, ground])

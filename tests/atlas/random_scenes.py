"""Random scenes in the plane, generated from seeds: walls, arches, stacks and convex tessellations."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import shapely

from masonry_opt.scene.blocks import Block, rectangle
from masonry_opt.scene.joints import JointDefaults
from masonry_opt.scene.scene import Scene

Rng = np.random.Generator
Points = list[tuple[float, float]]


def random_scene(kind: str, seed: int) -> Scene:
    """Return the scene of a kind (a key of ``KINDS``) and a seed, which is the same in every release."""
    rng = np.random.default_rng([list(KINDS).index(kind), seed])
    scene = KINDS[kind](rng)
    return scene.model_copy(update={"title": f"{kind} {seed}"})


def assembled(rng: Rng, outlines: list[Points], fixed: dict[str, Points]) -> Scene:
    """Return blocks with a weight of 1 per area on supports, with a random live load.

    The live load pushes all blocks sideways in proportion to their weights, or a few blocks in any direction
    except upwards.
    """
    areas = [shapely.Polygon(outline).area for outline in outlines]
    live = np.zeros((len(outlines), 2))
    if rng.random() < 0.5:
        live[:, 0] = rng.choice([-1, 1]) * np.array(areas)
    else:
        for index in rng.integers(len(outlines), size=rng.integers(1, 4)):
            angle = rng.uniform(-math.pi, 0)
            live[index] = np.array([math.cos(angle), math.sin(angle)]) * sum(areas) / len(areas)
    at_corner = rng.random() < 0.3
    blocks = [
        Block(
            name=f"b{index}",
            vertices=outline,
            weight=area,
            live=tuple(force),
            live_at=outline[-1] if at_corner and any(force) else None,
        )
        for index, (outline, area, force) in enumerate(zip(outlines, areas, live.tolist(), strict=True))
    ]
    supports = [Block(name=name, vertices=outline, fixed=True) for name, outline in fixed.items()]
    friction = float(rng.uniform(0.3, 0.9))
    cohesion = float(rng.uniform(0, 0.1)) if rng.random() < 0.2 else 0.0
    return Scene(joints=JointDefaults(friction=friction, cohesion=cohesion), blocks=[*blocks, *supports])


def wall(rng: Rng) -> Scene:
    """Return a wall of courses of equal length, with random heights and random head joints."""
    length, bottom = float(rng.uniform(4, 8)), 0.0
    outlines: list[Points] = []
    for _ in range(rng.integers(2, 6)):
        top = bottom + float(rng.uniform(0.5, 1.2))
        parts = rng.uniform(0.7, 1.3, rng.integers(2, 5))
        cuts = np.concatenate([[0], np.cumsum(parts) / parts.sum() * length]).tolist()
        outlines += [rectangle(left, right, bottom, top) for left, right in pairwise(cuts)]
        bottom = top
    return assembled(rng, outlines, {"base": rectangle(-1, length + 1, -1, 0)})


def stack(rng: Rng) -> Scene:
    """Return a stack of trapezia with inclined sides, whose joints are tilted by up to 6°."""
    width, outlines = float(rng.uniform(0.8, 2)), []
    low_left, low_right = (0.0, 0.0), (width, 0.0)
    for _ in range(rng.integers(2, 8)):
        height, tilt = float(rng.uniform(0.4, 1.0)), float(rng.uniform(-0.1, 0.1))
        shift = rng.uniform(-0.08, 0.08, 2)
        left = (low_left[0] + float(shift[0]), low_left[1] + height)
        across = low_right[0] + float(shift[1]) - left[0]
        right = (left[0] + across, max(left[1] + tilt * across, low_right[1] + 0.2))
        outlines.append([low_left, low_right, right, left])
        low_left, low_right = left, right
    return assembled(rng, outlines, {"base": rectangle(-2, width + 2, -1, 0)})


def arch(rng: Rng, fewest: int = 4, most: int = 11) -> Scene:
    """Return an arch of random rise and thickness between skewbacks, with voussoirs of unequal length.

    The random number of voussoirs is at least ``fewest`` and at most ``most``.
    """
    count, half = int(rng.integers(fewest, most + 1)), float(rng.uniform(0.7, math.pi / 2))
    thickness = float(rng.uniform(0.16, 0.4))
    parts = np.concatenate([[0], np.cumsum(rng.uniform(0.7, 1.3, count))])
    angles = (math.pi / 2 - half + 2 * half * parts / parts[-1]).tolist()

    def voussoir(start: float, end: float) -> Points:
        ring = [(1, start), (1 + thickness, start), (1 + thickness, end), (1, end)]
        return [(r * math.cos(angle), r * math.sin(angle)) for r, angle in ring]

    outlines = [voussoir(start, end) for start, end in pairwise(angles)]
    feet = {"right": voussoir(angles[0] - 0.2, angles[0]), "left": voussoir(angles[-1], angles[-1] + 0.2)}
    return assembled(rng, outlines, feet)


def tessellation(rng: Rng) -> Scene:
    """Return Voronoi cells of random points, flattened by a random factor and clipped to a box on a base."""
    width, height = float(rng.uniform(2, 4)), float(rng.uniform(1, 2.5))
    box = shapely.box(0, 0, width, height)
    points = rng.uniform([0, 0], [width, height], size=(rng.integers(4, 22), 2))
    squash = float(rng.uniform(1, 3))  # makes cells longer than high, as masons lay stones
    cells = shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(points * [1, squash])))
    cells = shapely.transform(cells, lambda corners: corners / [1, squash])
    outlines = [
        [tuple(corner) for corner in shapely.get_coordinates(part)[:-1].tolist()]
        for part in shapely.intersection(cells, box)
        if part.area > 1e-3
    ]
    return assembled(rng, outlines, {"base": rectangle(-1, width + 1, -1, 0)})


KINDS: dict[str, Callable[[Rng], Scene]] = {of.__name__: of for of in (wall, stack, arch, tessellation)}

"""Random scenes in space, generated from seeds: leaves of boxes, rings of wedges, corners and piers."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from masonry_opt.scene.joints import JointDefaults
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import Solid

Rng = np.random.Generator
Vertices = np.ndarray

#: Faces of a solid with eight corners. The corners of the bottom come first, and both rings of corners are
#: counter-clockwise as seen from above.
_FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def random_scene_in_space(kind: str, seed: int) -> Scene:
    """Return the scene of a kind (a key of ``KINDS``) and a seed, with up to 60 blocks.

    The scene is the same in every release.
    """
    rng = np.random.default_rng([list(KINDS).index(kind), seed])
    scene = KINDS[kind](rng)
    return scene.model_copy(update={"title": f"{kind} {seed}"})


def assembled(rng: Rng, shapes: list[Vertices], fixed: list[Vertices]) -> Scene:
    """Return blocks with a weight of 1 per volume on supports, with a random live load.

    The live load pushes all blocks in one horizontal direction in proportion to their weights, or a few
    blocks in any direction except upwards. Some of these blocks have a live moment too.
    """
    live, moment = np.zeros((2, len(shapes), 3))
    everywhere = rng.random() < 0.5
    if everywhere:
        angle = rng.uniform(-math.pi, math.pi)
        live[:] = (math.cos(angle), math.sin(angle), 0)
    else:
        for index in rng.integers(len(shapes), size=rng.integers(1, 4)):
            force = rng.normal(size=3)
            live[index] = force / np.linalg.norm(force) * [1, 1, math.copysign(1, -force[2])]
            moment[index] = rng.normal(size=3) * 0.1 * (rng.random() < 0.3)
    size = 1.0 if everywhere else float(np.mean([_volume(shape) for shape in shapes]))
    blocks = [
        Solid(
            name=f"b{index}",
            vertices=shape.tolist(),
            faces=_FACES,
            unit_weight=1,
            live_moment=(size * moment[index]).tolist(),
            **{"live_per_weight" if everywhere else "live": (size * live[index]).tolist()},
        )
        for index, shape in enumerate(shapes)
    ]
    supports = [
        Solid(name=f"support {index}", vertices=shape.tolist(), faces=_FACES, fixed=True)
        for index, shape in enumerate(fixed)
    ]
    friction = float(rng.uniform(0.3, 0.9))
    cohesion = float(rng.uniform(0, 0.1)) if rng.random() < 0.2 else 0.0
    return Scene(joints=JointDefaults(friction=friction, cohesion=cohesion), blocks=[*blocks, *supports])


def _box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Vertices:
    ring = np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])])
    return np.concatenate([np.column_stack([ring, np.full(4, height)]) for height in z])


def _volume(shape: Vertices) -> float:
    """Return an estimate of the volume: that of the parallelepiped spanned by the edges at the first corner.

    The estimate is used to scale loads to about the weight of a block.
    """
    return abs(float(np.linalg.det(shape[[1, 3, 4]] - shape[0])))


def _cuts(rng: Rng, length: float, parts: int) -> list[tuple[float, float]]:
    ends = np.concatenate([[0], np.cumsum(rng.uniform(0.7, 1.3, parts))])
    return list(pairwise((length * ends / ends[-1]).tolist()))


def boxes(rng: Rng) -> Scene:
    """Return a wall whose courses have one or two leaves and random head joints.

    A course of one leaf ties two leaves together, as headers do.
    """
    length, depth, bottom = float(rng.uniform(3, 6)), float(rng.uniform(0.5, 1.5)), 0.0
    shapes = []
    for _ in range(rng.integers(2, 7)):
        top = bottom + float(rng.uniform(0.4, 1.0))
        for y in _cuts(rng, depth, int(rng.integers(1, 3))):
            shapes += [_box(x, y, (bottom, top)) for x in _cuts(rng, length, int(rng.integers(2, 6)))]
        bottom = top
    return assembled(rng, shapes, [_box((-1, length + 1), (-1, depth + 1), (-1, 0))])


def wedges(rng: Rng) -> Scene:
    """Return one to three arch rings next to each other, between skewbacks, with random voussoirs."""
    half, thickness = float(rng.uniform(0.7, math.pi / 2)), float(rng.uniform(0.2, 0.5))

    def voussoir(start: float, end: float, y: tuple[float, float]) -> Vertices:
        places = [*zip(np.repeat(y, 2), (end, start, start, end), strict=True)]
        radii = 1, 1 + thickness
        return np.array([(r * math.cos(a), at, r * math.sin(a)) for r in radii for at, a in places])

    rings = _cuts(rng, float(rng.uniform(0.3, 1.2)), int(rng.integers(1, 4)))
    low, high = math.pi / 2 - half, math.pi / 2 + half
    shapes = []
    for y in rings:
        for start, end in _cuts(rng, 2 * half, int(rng.integers(4, 10))):
            shapes.append(voussoir(low + start, low + end, y))
    across = (rings[0][0] - 0.1, rings[-1][1] + 0.1)
    feet = [voussoir(low - 0.2, low, across), voussoir(high, high + 0.2, across)]
    return assembled(rng, shapes, feet)


def corner(rng: Rng) -> Scene:
    """Return two walls that meet in a toothed corner, with random course heights and head joints."""
    thickness, lengths = float(rng.uniform(0.5, 1.2)), rng.uniform(2.5, 6, 2).tolist()
    shapes, bottom = [], 0.0
    for course in range(rng.integers(2, 7)):
        z = (bottom, bottom + float(rng.uniform(0.5, 1.0)))
        bottom = z[1]
        for leg, length in enumerate(lengths):
            # The two walls run through the corner in alternate courses.
            start = thickness if leg == course % 2 else 0.0
            for one, other in _cuts(rng, length - start, int(rng.integers(2, 5))):
                sides = ((start + one, start + other), (0.0, thickness))
                shapes.append(_box(*sides[:: 1 - 2 * leg], z))
    reach = max(lengths) + 1
    return assembled(rng, shapes, [_box((-1, reach), (-1, reach), (-1, 0))])


def piers(rng: Rng) -> Scene:
    """Return one to three piers of stones that are turned about the vertical, with beds inclined by up to 3°.

    A lintel connects each pier to the next, and a stone lies on one end of each lintel.
    """
    count, height = int(rng.integers(1, 4)), int(rng.integers(2, 7))
    shapes: list[Vertices] = []
    for pier in range(count):
        slope, level = np.zeros(2), 0.0
        for course in range(height):
            size, angle = rng.uniform(0.35, 0.55, 2), float(rng.uniform(-0.4, 0.4))
            turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
            ring = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * size @ turn.T
            ring += rng.uniform(-0.05, 0.05, 2)
            above = level + float(rng.uniform(0.5, 0.9)) if course < height - 1 else 0.8 * height
            next_slope = rng.uniform(-0.05, 0.05, 2) if course < height - 1 else np.zeros(2)
            beds = (level, slope), (above, next_slope)
            place = ring + np.array([2, 0]) * pier
            shapes.append(np.concatenate([np.column_stack([place, at + ring @ of]) for at, of in beds]))
            slope, level = next_slope, above
    rise = 0.8 * height
    for pier in range(count - 1):
        lintel = (rise, rise + 0.4)
        shapes.append(_box((2 * pier + 0.01, 2 * pier + 1.99), (-0.3, 0.3), lintel))
        on_top = (lintel[1], lintel[1] + float(rng.uniform(0.2, 0.5)))
        shapes.append(_box((2 * pier + 0.01, 2 * pier + 0.8), (-0.3, 0.3), on_top))
    return assembled(rng, shapes, [_box((-2, 2 * count + 1), (-2, 2), (-1, 0))])


KINDS: dict[str, Callable[[Rng], Scene]] = {of.__name__: of for of in (boxes, wedges, corner, piers)}

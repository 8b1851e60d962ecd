"""Small random scenes in space, stable or unstable under dead load, many near the limit of stability."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from masonry_opt.scene.joints import JointDefaults
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import Solid, box, prism

Rng = np.random.Generator

#: Unit weight and live load of each movable block.
WEIGHT: dict[str, Any] = {"unit_weight": 1.0, "live": (1, 0, 0)}


def small_scene_in_space(seed: int) -> Scene:
    """Return the scene of a seed, with one to six blocks on a floor; it is the same in every release.

    Friction is between 0.2 and 1.2. In every second scene the slope, the overhang or the tilt of gravity is
    near the limit of stability.
    """
    rng = np.random.default_rng([39, seed])
    kinds = list(KINDS)
    kind, friction = kinds[seed % len(kinds)], float(rng.uniform(0.2, 1.2))
    blocks, gravity = KINDS[kind](rng, friction), (0.0, 0.0, -1.0)
    if rng.random() < 0.3:
        slope, angle = friction * _share(rng), float(rng.uniform(-math.pi, math.pi))
        gravity = (slope * math.cos(angle), slope * math.sin(angle), -1.0)
    order = rng.permutation(len(blocks))
    return Scene(
        title=f"{kind} {seed}",
        joints=JointDefaults(friction=friction),
        blocks=[blocks[index] for index in order],
        gravity=gravity,
    )


def _share(rng: Rng) -> float:
    """Return a random fraction of the limit of stability.

    The fraction is 1 (10 % of calls), differs from 1 by a billionth to a hundredth (40 %), or lies anywhere
    between 0.2 and 1.4 (50 %).
    """
    near = 1 + float(rng.choice([-1, 1]) * 10 ** rng.uniform(-9, -2))
    return float(rng.choice([rng.uniform(0.2, 1.4), near, 1.0], p=[0.5, 0.4, 0.1]))


def _floor(reach: float = 9.0) -> Solid:
    return box("floor", (-9, reach), (-9, 9), (-1, 0), fixed=True)


def _block(name: str, x: list[float], y: list[float], z: list[float]) -> Solid:
    return box(name, tuple(x), tuple(y), tuple(z), **WEIGHT)


def fallen(rng: Rng, friction: float) -> list[Solid]:
    """Return boxes that are dropped one after another onto the boxes and the floor below, near its edge."""
    low, high, blocks = np.empty((0, 3)), np.empty((0, 3)), []
    for number in range(rng.integers(1, 7)):
        size, corner = rng.uniform(0.4, 2.0, 3), rng.uniform(-1.5, 0.8, 2)
        under = ((corner < high[:, :2]) & (corner + size[:2] > low[:, :2])).all(axis=1)
        start = np.append(corner, high[under, 2].max(initial=0.0))
        low, high = np.vstack([low, start]), np.vstack([high, start + size])
        blocks.append(_block(f"b{number}", *np.stack([start, start + size], axis=1).tolist()))
    return [*blocks, _floor(1.5)]


def table(rng: Rng, friction: float) -> list[Solid]:
    """Return a slab on three or four legs, with or without a box on it."""
    length, depth, height = rng.uniform([2, 1.5, 0.5], [4, 3, 2]).tolist()
    blocks = []
    for corner in rng.permutation(4)[: rng.integers(3, 5)].tolist():
        size, at = rng.uniform(0.25, 0.5, 2), rng.uniform(0, 0.2, 2)
        at = np.where([corner % 2, corner // 2], np.array([length, depth]) - size - at, at)
        x, y = np.stack([at, at + size], axis=1).tolist()
        blocks.append(_block(f"leg {corner}", x, y, [0, height]))
    top = height + float(rng.uniform(0.2, 0.5))
    blocks.append(_block("slab", [0, length], [0, depth], [height, top]))
    if rng.random() < 0.5:
        x, y = (float(rng.uniform(-0.3, most)) for most in (length - 0.5, depth - 0.5))
        blocks.append(_block("on it", [x, x + 0.8], [y, y + 0.8], [top, top + float(rng.uniform(0.3, 2))]))
    return [*blocks, _floor()]


def slope(rng: Rng, friction: float) -> list[Solid]:
    """Return one or two stones with inclined beds on a wedge, which is fixed or rests on a floor."""
    angle, steep = float(rng.uniform(-math.pi, math.pi)), friction * _share(rng)
    inclined = steep * np.array([math.cos(angle), math.sin(angle)])
    blocks, level, bed = [], 0.0, np.zeros(2)
    for number in range(rng.integers(2, 4)):
        size, turn = rng.uniform(0.4, 1.0, 2) + 0.8 * (number == 0), float(rng.uniform(0, math.pi / 2))
        c, s = math.cos(turn), math.sin(turn)
        ring = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * size @ np.array([[c, s], [-s, c]])
        above = level + float(rng.uniform(0.3, 1.0)) + np.abs(ring @ (inclined - bed)).max()
        front, back = (
            np.column_stack([ring, at + ring @ plane])[:: -1 if under else 1]
            for at, plane, under in ((level, bed, True), (above, inclined, False))
        )
        loads = {"fixed": True} if number == 0 and rng.random() < 0.5 else WEIGHT
        shape = prism(front.tolist(), back[::-1].tolist())
        blocks.append(Solid(name=f"b{number}", **shape, **loads))
        level, bed = above, inclined
    return [*blocks, _floor()]


def plug(rng: Rng, friction: float) -> list[Solid]:
    """Return a wedge between two stones, which are fixed or rest on a floor, with or without a box on it."""
    lean, height = float(rng.choice([1, -1])) * friction * _share(rng), float(rng.uniform(0.5, 1.5))
    other = float(rng.choice([lean, -0.1, rng.uniform(0, 1.0)]))
    foot, depth, wide = float(rng.choice([0.0, 0.3])), *rng.uniform(0.4, 2.0, 2).tolist()
    half = float(rng.uniform(0.2, 0.6)) + height * max(-lean, -other, 0.0)
    left, right = half + lean * height, half + other * height
    ends = -max(half, left) - wide, max(half, right) + wide

    def extruded(name: str, outline: list[tuple[float, float]], **keys: object) -> Solid:
        front, back = ([(x, y, z) for x, z in outline] for y in (0.0, depth))
        return Solid(name=name, **prism(front, back), **keys)

    loose = WEIGHT | {"unit_weight": float(rng.uniform(0.5, 4))}
    sides = {"fixed": True} if rng.random() < 0.6 else loose
    bottom = [(-half - lean * foot, foot), (half + other * foot, foot)]
    blocks = [
        extruded("plug", [*bottom, (right, height), (-left, height)], **WEIGHT),
        extruded("left", [(ends[0], 0), (-half, 0), (-left, height), (ends[0], height)], **sides),
        extruded("right", [(half, 0), (ends[1], 0), (ends[1], height), (right, height)], **sides),
    ]
    if rng.random() < 0.4:
        z = [height, height + float(rng.uniform(0.2, 2))]
        blocks.append(_block("on it", [-half, half], [0, depth], z))
    return [*blocks, _floor()]


def overhang(rng: Rng, friction: float) -> list[Solid]:
    """Return boxes of equal size, each of which overhangs the box below by a fraction of the limit."""
    count, reach = int(rng.integers(1, 6)), 0.0
    length, depth, height = rng.uniform(0.3, 2, 3).tolist()
    share, blocks = _share(rng), []
    for number in range(count):
        x = reach - length
        z = [number * height, (number + 1) * height]
        blocks.append(_block(f"b{number}", [x, x + length], [0, depth], z))
        # At the limit, the n-th box from the top overhangs by 1 / (2 n) of its length.
        reach += share * length / 2 / (count - 1 - number) if number < count - 1 else 0.0
    return [*blocks, _floor(float(rng.choice([0.0, -0.3 * length])))]


KINDS: dict[str, Callable[[Rng, float], list[Solid]]] = {
    kind.__name__: kind for kind in (fallen, table, slope, plug, overhang)
}

"""Changes of a scene that leave λ unchanged, such as translation, rotation, and other units."""

import math
from collections.abc import Callable

import numpy as np
import pytest

import masonry_opt as mo

Vector = Callable[[tuple[float, float]], tuple[float, float]]


def as_is(v):
    return v


def mapped(
    scene: mo.Scene,
    point: Vector = as_is,
    force: Vector = as_is,
    *,
    dead: float = 1.0,
    live: float = 1.0,
    length: float = 1.0,
    order: np.ndarray | None = None,
) -> mo.Scene:
    """Return the scene with mapped points and forces, scaled loads and lengths, and reordered blocks."""

    def moved(block: mo.Block) -> mo.Block:
        return block.replace(
            vertices=[point(v) for v in block.vertices],
            weight=block.weight and dead * block.weight,
            weight_at=block.weight_at and point(block.weight_at),
            unit_weight=block.unit_weight and dead / length**2 * block.unit_weight,
            live=tuple(live * f for f in force(block.live)),
            live_at=block.live_at and point(block.live_at),
            live_per_weight=tuple(live / dead * f for f in force(block.live_per_weight)),
            dead=tuple(dead * f for f in force(block.dead)),
            dead_at=block.dead_at and point(block.dead_at),
        )

    blocks = [moved(block) for block in scene.blocks]
    if order is not None:
        blocks = [blocks[index] for index in order]
    stresses = {name: getattr(scene.joints, name) for name in ("cohesion", "strength")}
    joints = scene.joints.model_copy(update={k: v and v * dead / length for k, v in stresses.items()})
    return mo.Scene(joints=joints, gravity=force(scene.gravity), blocks=blocks, exceptions=scene.exceptions)


def turned(angle: float) -> Vector:
    c, s = math.cos(angle), math.sin(angle)
    return lambda v: (c * v[0] - s * v[1], s * v[0] + c * v[1])


def mirrored(v):
    return (-v[0], v[1])


def shuffled(scene: mo.Scene) -> mo.Scene:
    return mapped(scene, order=np.random.default_rng(7).permutation(len(scene.blocks)))


def with_split_supports(scene: mo.Scene) -> mo.Scene:
    """Return the scene with each fixed block cut in two across its first edge.

    A block that rests on the cut has two joints instead of one, which together carry the same forces.
    """
    blocks: list[mo.Block] = []
    for block in scene.blocks:
        if not block.fixed:
            blocks.append(block)
            continue
        a, b, c, d = block.vertices
        e, f = (tuple(0.6 * p + 0.4 * q for p, q in zip(*ends, strict=True)) for ends in ((a, b), (d, c)))
        blocks.append(mo.Block(name=f"{block.name} 1", vertices=[a, e, f, d], fixed=True))
        blocks.append(mo.Block(name=f"{block.name} 2", vertices=[e, b, c, f], fixed=True))
    return scene.model_copy(update={"blocks": blocks})


#: Changes of a scene that leave λ unchanged.
SAME: dict[str, Callable[[mo.Scene], mo.Scene]] = {
    "moved": lambda scene: mapped(scene, lambda v: (v[0] + 31.7, v[1] - 12.9)),
    "moved far": lambda scene: mapped(scene, lambda v: (v[0] + 1e5, v[1] - 1e5)),
    "turned by 37°": lambda scene: mapped(scene, turned(math.radians(37)), turned(math.radians(37))),
    "turned by 90°": lambda scene: mapped(scene, turned(math.pi / 2), turned(math.pi / 2)),
    "mirrored": lambda scene: mapped(scene, mirrored, mirrored),
    "in millimetres": lambda scene: mapped(scene, lambda v: (1e3 * v[0], 1e3 * v[1]), length=1e3),
    "in newtons": lambda scene: mapped(scene, dead=2.3e4, live=2.3e4),
    "renumbered": shuffled,
    "supports split": with_split_supports,
}


def same(one: mo.Result, other: mo.Result, tolerance: float, factor: float = 1.0) -> None:
    """Assert that the other result has the same status, and ``factor`` times the load factor."""
    assert other.status == one.status
    if one.load_factor is None:
        assert other.load_factor is None
    else:
        expected = factor * one.load_factor
        assert other.load_factor == pytest.approx(expected, rel=tolerance, abs=tolerance)

"""Blocks that touch nothing or reach no support, and how far the nearest ones are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from masonry_opt.errors import CaseError, rounded_up
from masonry_opt.scene.extents import Extents
from masonry_opt.scene.geometry import raise_for
from masonry_opt.scene.rows import linked
from masonry_opt.scene.scene import Scene


def refuse_floating(
    scene: Scene,
    shapes: Extents,
    first: np.ndarray,
    second: np.ndarray,
    gaps: Mapping[tuple[int, int], float],
) -> None:
    """Raise CaseError if blocks touch nothing, or groups of blocks reach no support, given the two blocks of
    each joint, and the largest width of each small gap by the two blocks beside it. Ties and props hold
    blocks as joints do."""
    fixed = np.array([block.fixed for block in scene.blocks])
    count = len(fixed)
    joints, ground = len(first), int(fixed.argmax())  # which does not move, as a fixed block
    index = {block.name: number for number, block in enumerate(scene.blocks)}
    for strut in [*scene.ties, *scene.props]:
        ends = [index.get(name, ground) for name in strut.between]
        first, second = np.append(first, ends[0]), np.append(second, ends[1])
    touched = np.zeros(count, dtype=bool)
    touched[first] = touched[second] = True
    alone = np.flatnonzero(~touched & ~fixed)
    if len(alone):
        one = int(alone[0])
        faced = [(gap, sum(pair) - one) for pair, gap in gaps.items() if one in pair]
        gap, other = min(faced, default=(0.0, one))
        name = f"{scene.blocks[other].name!r}, which it faces, is up to"
        beside = _how_far(name, gap, _rounding(gap)) if faced else _nearest(scene, shapes, one)
        raise_for(alone, scene, f"touches no other block{beside}")
    group = linked(count, first, second)
    loose = np.flatnonzero(~np.isin(group, group[fixed]))
    raise_for(loose, scene, "reaches no fixed block, neither itself nor through others: support it")
    if not joints:
        raise CaseError(f"{scene.origin}: ties and props hold every block: one must stand on another")


def _nearest(scene: Scene, shapes: Extents, block: int) -> str:
    """How far from a block that touches nothing the nearest is, and what to do."""
    nearest, gap = shapes.nearest(block)
    name, both, remedy = repr(scene.blocks[nearest].name), [block, nearest], ""
    if gap <= shapes.tolerance:
        return f": it meets {name} {shapes.meeting} of either"
    if gap <= shapes.reach[both].min():
        remedy = _rounding(gap)
    elif gap <= shapes.mortar * shapes.width[both].min():
        remedy = f", or raise 'contact_tolerance' to {rounded_up(gap, 2)} if mortar was left out"
    return _how_far(f"{name}, the nearest, is", gap, remedy)


def _rounding(gap: float) -> str:
    """What to do about a gap that is so small that it may be rounding."""
    return f", or raise 'tolerance' to {rounded_up(gap, 2)} if coordinates were rounded"


def _how_far(neighbour: str, gap: float, remedy: str) -> str:
    """What to say of a block that touches nothing: which one is how far, and what to do about that."""
    return f": {neighbour} {gap:.3g} away: close the gap{remedy}, or take the block away"

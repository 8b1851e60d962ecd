"""Pairs of blocks that touch or nearly do, and those that overlap."""

from __future__ import annotations

import numpy as np
import shapely

from masonry_opt.errors import CaseError, counted, rounded_up
from masonry_opt.scene.contact import MOST_PAIRS, MOST_PAIRS_PER_BLOCK
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.parts import Common, combine, common, overlapping
from masonry_opt.scene.space.shapes import Shapes
from masonry_opt.scene.space.surfaces import place
from masonry_opt.scene.touching import reach as reach_of

#: Pairs that overlap, each a linear program, after which no more are looked for: the scene is refused anyway.
_ENOUGH = 100

#: Share of a block's volume that lies within another from which on it lies there wholly.
_INSIDE = 0.999


def boxes(shapes: Shapes) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest coordinates of each block, shape (blocks, 3) each."""
    first = np.searchsorted(shapes.parts.block, np.arange(len(shapes.volume)))
    return np.minimum.reduceat(shapes.parts.low, first), np.maximum.reduceat(shapes.parts.high, first)


def reach(shapes: Shapes) -> np.ndarray:
    """Gap up to which each block's neighbours were surely meant to touch it, shape (blocks,)."""
    return reach_of(shapes.contact_tolerance, np.cbrt(shapes.volume))


def near_pairs(scene: Scene, shapes: Shapes) -> np.ndarray:
    """Index pairs (i < j) of blocks whose boxes touch or nearly do, sorted, shape (pairs, 2).

    Raises CaseError if there are more than memory holds.
    """
    low, high = boxes(shapes)
    far = reach(shapes)
    # Seen along the axis where blocks hide one another least.
    extent = high - low
    whole = high.max(axis=0) - low.min(axis=0)
    depth = [np.prod(np.delete(extent / whole, axis, axis=1), axis=1).sum() for axis in range(3)]
    across = np.delete(np.arange(3), int(np.argmin(depth)))
    tree = shapely.STRtree(shapely.box(*low[:, across].T, *high[:, across].T))
    grown = shapely.box(*(low[:, across] - far[:, None]).T, *(high[:, across] + far[:, None]).T)
    count = len(low)
    found: list[np.ndarray] = []
    pairs = 0
    for first in range(0, count, 100):
        i, j = tree.query(grown[first : first + 100])
        i += first
        kept = i < j
        i, j = i[kept], j[kept]
        apart = np.maximum(low[i] - high[j], low[j] - high[i]).max(axis=1)
        near = apart <= np.minimum(far[i], far[j])
        found.append(np.column_stack([i[near], j[near]]))
        pairs += len(found[-1])
        if pairs > MOST_PAIRS + MOST_PAIRS_PER_BLOCK * count:
            raise CaseError(
                f"{scene.origin}: blocks lie on one another: the first {min(first + 100, count)} have "
                f"{pairs} neighbours; give each block a place of its own"
            )
    every = np.concatenate(found)
    return every[np.lexsort((every[:, 1], every[:, 0]))]


def refuse_overlaps(scene: Scene, shapes: Shapes, pairs: np.ndarray) -> None:
    """Raise CaseError if blocks of the pairs overlap by more than the contact tolerance."""
    parts, tolerance = shapes.parts, shapes.contact_tolerance
    count = np.bincount(parts.block, minlength=len(shapes.volume))
    first = np.cumsum(count) - count
    i, j = pairs.T
    number, one, other = combine(first[i], count[i], first[j], count[j])
    found: dict[int, list[Common]] = {}
    for index in overlapping(parts, one, other, tolerance):
        both = common(parts, int(one[index]), int(other[index]))
        if both.depth > tolerance:
            found.setdefault(int(number[index]), []).append(both)
        if len(found) == _ENOUGH:
            break
    if not found:
        return
    volume = {pair: sum(both.volume for both in several) for pair, several in found.items()}
    worst = max(volume, key=lambda pair: volume[pair])
    deepest = max(found[worst], key=lambda both: both.depth)
    names = [repr(scene.blocks[index].name) for index in pairs[worst]]
    # Rounding leaves slivers; what is deeper is no matter of tolerance.
    shallow = deepest.depth <= reach(shapes)[pairs[worst]].min()
    most = rounded_up(max(both.depth for several in found.values() for both in several), 2)
    if volume[worst] > _INSIDE * shapes.volume[pairs[worst]].min():
        remedy = "leave one out: one lies within the other"
    elif shallow:
        remedy = f"raise 'tolerance' to {most} if their coordinates were rounded"
    else:
        remedy = f"raise 'contact_tolerance' to {most} if they are meant to"
    others = len(found) - 1
    least = "at least " if len(found) == _ENOUGH else ""
    more = f" ({least}{counted(others, 'more pair')} overlap{'s' if others == 1 else ''})" if others else ""
    raise CaseError(
        f"{scene.origin}: blocks {names[0]} and {names[1]} overlap in a volume of {volume[worst]:.6g} round "
        f"{place(deepest.middle + shapes.origin, tolerance)}, {deepest.depth:.3g} deep: move them apart, "
        f"or {remedy}{more}"
    )

"""Small gaps and overlaps of sides that face each other, and the tolerance at which such sides touch."""

import numpy as np

from masonry_opt.scene.contacts.alignment import DEFAULT_SETTINGS
from masonry_opt.scene.contacts.sides import LEAN, Facing, Touches, nearest
from masonry_opt.scene.geometry import TOLERANCE_OVER_ERROR


def near_misses(touching: tuple[Facing | Touches, ...], apart: Facing, pairs: int) -> Facing:
    """Return the rows of ``apart`` that are small gaps, given where the same pairs of blocks touch.

    A gap that leans, that is a mere chamfer beside a joint of its pair, or that lies on such a joint is none.
    ``pairs`` is the number of pairs of blocks.
    """
    extent_touching = np.zeros(pairs)
    for found in touching:
        if isinstance(found, Facing):
            extent_touching += np.bincount(found.pair, found.extent, pairs)
    width = apart.extent ** (1 / (apart.middle.shape[1] - 1))
    is_gap = (apart.most <= LEAN * width) & (apart.extent > LEAN * extent_touching[apart.pair])
    apart = apart.where(is_gap)
    if not touching:
        return apart
    distance = [nearest(apart.pair, apart.middle, found, found.pair) for found in touching]
    return apart.where(np.min(distance, axis=0) > 2 * apart.most)


def joining_tolerance(apart: Facing) -> float:
    """Return the tolerance at which all of these sides touch and their joints align; 0 without sides.

    Sides that are not parallel, by an angle that the alignment may take away, are taken for the error of a
    corner. Then the tolerance is a multiple of that error.
    """
    error = np.where(apart.angle <= DEFAULT_SETTINGS.most_turn, apart.angle * apart.shorter, 0.0)
    return float(np.maximum(apart.most, TOLERANCE_OVER_ERROR * error).max(initial=0.0))

"""Find small gaps between sides that face each other, and the tolerance at which these sides touch."""

import numpy as np

from masonry_opt.scene.contacts.alignment import DEFAULT_SETTINGS
from masonry_opt.scene.contacts.sides import LEAN, Facing, Touches, nearest
from masonry_opt.scene.geometry import TOLERANCE_OVER_ERROR


def near_misses(touching: tuple[Facing | Touches, ...], apart: Facing, pairs: int) -> Facing:
    """Return those pairs of facing sides that are separated by a small, probably unintended gap.

    Three kinds of rows are left out:

    - sides whose distance is large relative to their width,
    - chamfers: sides that are small relative to the joints of their pair of blocks,
    - sides that lie on a joint of their pair of blocks.

    Parameters
    ----------
    touching : tuple of Facing or Touches
        Joints of the pairs of blocks.
    apart : Facing
        Sides that face each other and do not touch.
    pairs : int
        Number of pairs of blocks.
    """
    extent_touching = np.zeros(pairs)
    for joints in touching:
        if isinstance(joints, Facing):
            extent_touching += np.bincount(joints.pair, joints.extent, pairs)
    width = apart.extent ** (1 / (apart.middle.shape[1] - 1))
    is_gap = (apart.most <= LEAN * width) & (apart.extent > LEAN * extent_touching[apart.pair])
    apart = apart.where(is_gap)
    if not touching:
        return apart
    distance = [nearest(apart.pair, apart.middle, joints, joints.pair) for joints in touching]
    return apart.where(np.min(distance, axis=0) > 2 * apart.most)


def joining_tolerance(apart: Facing) -> float:
    """Return the tolerance at which all given sides touch and become parallel; 0 if there are no sides.

    If two sides are not parallel, by an angle that the alignment can remove, a corner is assumed to be in
    error. The tolerance is then at least a multiple of this error.
    """
    error = np.where(apart.angle <= DEFAULT_SETTINGS.most_turn, apart.angle * apart.shorter, 0.0)
    return float(np.maximum(apart.most, TOLERANCE_OVER_ERROR * error).max(initial=0.0))

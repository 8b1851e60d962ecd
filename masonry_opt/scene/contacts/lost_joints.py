"""Find pairs of blocks that face each other but have no joint, because the tolerance is too large."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from masonry_opt.scene.contacts.faces import NARROWEST
from masonry_opt.scene.contacts.gaps import Gaps
from masonry_opt.scene.contacts.mortar import (
    facing_across_mortar,
    fine_tolerance,
    has_large_tolerance,
    pair_codes,
)
from masonry_opt.scene.contacts.neighbours import facing_sides
from masonry_opt.scene.contacts.sides import SMALL_LENGTH_RATIO, Facing
from masonry_opt.scene.geometry import Extents
from masonry_opt.scene.scene import Scene

#: Contact strips up to this width, relative to the tolerance, count as errors of the drawing: each of the two
#: edges of a strip may be wrong by the tolerance. With a larger value, fewer lost joints are reported.
_WIDEST_ERROR = 2.0


class LostJoints(NamedTuple):
    """Pairs of blocks that have no joint, because their sides are narrow compared with the tolerance."""

    gaps: Gaps  #: width of the gap between the blocks of each pair, or 0 if their sides touch
    tolerance: float  #: upper limit of tolerances with which all pairs have joints; infinite without pairs

    def then(self, other: "LostJoints") -> "LostJoints":
        """Return the pairs of both records. For a pair in both, the gap of this record is used."""
        return LostJoints(other.gaps | self.gaps, min(self.tolerance, other.tolerance))


def find_lost_joints(scene: Scene, shapes: Extents, joint_ends: np.ndarray) -> LostJoints:
    """Return the pairs of blocks that have no joint because the option ``tolerance`` is large.

    The option is large if it exceeds 1 % of the width of the narrowest movable block. The blocks face each
    other with sides that are shorter than about ten times ``tolerance``, and longer than a tenth of a block's
    width. ``joint_ends`` lists the pairs of blocks with a joint, shape (joints, 2).
    """
    if not has_large_tolerance(scene, shapes):
        return LostJoints({}, np.inf)
    pairs, facing = facing_across_mortar(scene, shapes)
    ends = pairs[facing.pair]
    is_lost = (facing.largest_gap <= shapes.reach[ends].min(axis=1)) & ~np.isin(
        pair_codes(ends, scene), pair_codes(joint_ends, scene)
    )
    is_lost &= facing.width > SMALL_LENGTH_RATIO * shapes.width[ends].min(axis=1)
    return _lost(pairs, facing.where(is_lost), fine_tolerance(scene, shapes))


def find_narrow_joints(
    scene: Scene, shapes: Extents, pairs: np.ndarray, omitted: tuple[np.ndarray, ...]
) -> LostJoints:
    """Return the pairs of solids that touch along strips narrower than ten tolerances, without a joint.

    Strips up to two tolerances wide are left out. In the plane the result is empty, because the corners at
    the ends of a short contact have joints.

    Parameters
    ----------
    scene : Scene
        The scene.
    shapes : Extents
        Shapes of the blocks of the scene.
    pairs : ndarray, shape (pairs, 2)
        Pairs of blocks that are near each other.
    omitted : tuple of ndarray
        Indices of the pairs that are left out, such as pairs with a joint.
    """
    pairs = np.delete(pairs, np.concatenate(omitted), axis=0)
    if scene.dimension == 2 or not len(pairs):
        return LostJoints({}, np.inf)
    fine_shapes = replace(shapes, tolerance=shapes.tolerance * _WIDEST_ERROR / NARROWEST)
    strips = facing_sides(scene, fine_shapes, pairs, np.full(len(pairs), shapes.contact_tolerance))
    # Blocks at a gap below ``breadth / NARROWEST`` count as touching: a tolerance between the gap and this
    # value closes the gap and permits the joint.
    return _lost(pairs, strips, strips.breadth / NARROWEST)


def _lost(pairs: np.ndarray, sides: Facing, least_gap: float | np.ndarray) -> LostJoints:
    """Return the pairs of blocks with facing ``sides``. Gaps up to ``least_gap`` count as 0."""
    widths = np.where(sides.largest_gap > least_gap, sides.largest_gap, 0.0)
    gaps: Gaps = {}
    for (i, j), width in zip(pairs[sides.pair].tolist(), widths.tolist(), strict=True):
        gaps[i, j] = max(gaps.get((i, j), 0.0), width)
    return LostJoints(gaps, float(sides.breadth.min(initial=np.inf)) / NARROWEST)

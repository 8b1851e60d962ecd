"""Find small gaps between sides that face each other, and the tolerance at which these sides touch."""

from typing import Literal, NamedTuple

import numpy as np

from masonry_opt.scene.contacts.alignment import DEFAULT_SETTINGS
from masonry_opt.scene.contacts.faces import NARROWEST
from masonry_opt.scene.contacts.sides import SMALL_LENGTH_RATIO, Facing, Touches, nearest
from masonry_opt.scene.geometry import (
    NEAR_MISS,
    TOLERANCE_OVER_ERROR,
    Extents,
)
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tolerance_advice import set_contact_tolerance, set_tolerance

#: Ratio of the recommended ``tolerance`` to the median error of the gaps. The error of a gap is the
#: difference between its widths at its two ends. If corners have independent errors of at most e, the median
#: is about 0.8 e. The recommended tolerance is then about 3 e, as with ``TOLERANCE_OVER_ERROR``. A larger
#: ratio aligns more joints than necessary.
_TOLERANCE_OVER_DIFFERENCE = 4.0

#: Type of a dict of gaps, which maps the indices of two blocks to the largest width of the gap between them.
Gaps = dict[tuple[int, int], float]

#: Scene option that closes gaps: ``tolerance`` corrects errors of a drawing and aligns its joints;
#: ``contact_tolerance`` bridges intended gaps, such as undrawn mortar.
ClosingOption = Literal["tolerance", "contact_tolerance"]


def widest_gaps(pairs: np.ndarray, across: Facing) -> Gaps:
    """Return the largest width of the gaps between the two blocks of each pair that has gaps.

    ``across`` has the sides that face each other across the gaps.
    """
    gaps: Gaps = {}
    for (i, j), width in zip(pairs[across.pair].tolist(), across.largest_gap.tolist(), strict=True):
        gaps[i, j] = max(gaps.get((i, j), 0.0), width)
    return gaps


class Closing(NamedTuple):
    """Scene option that closes small gaps, and the smallest value of the option that closes all gaps."""

    option: ClosingOption = "tolerance"
    tolerance: float = 0.0  #: smallest value of the option that closes all small gaps; 0 if there are none

    @property
    def advice(self) -> str:
        """Return the part of a message that advises setting the option that closes the gaps."""
        is_tolerance = self.option == "tolerance"
        return set_tolerance(self.tolerance) if is_tolerance else set_contact_tolerance(self.tolerance)


def near_misses(
    touching: tuple[Facing | Touches, ...], gap_sides: Facing, pairs: int, *, drawn_apart: bool = False
) -> Facing:
    """Return the pairs of facing sides that are separated by a small, probably unintended gap.

    Three kinds of rows are left out:

    - sides whose distance is large relative to their width,
    - chamfers: sides that are small relative to the joints of their pair of blocks,
    - sides that lie on a joint of their pair of blocks.

    Parameters
    ----------
    touching : tuple of Facing or Touches
        Joints of the pairs of blocks.
    gap_sides : Facing
        Sides that face each other and do not touch.
    pairs : int
        Number of pairs of blocks.
    drawn_apart : bool
        True if blocks are drawn with gaps. Distances up to the breadth of the sides then count as small.
    """
    extent_touching = np.zeros(pairs)
    for joints in touching:
        if isinstance(joints, Facing):
            extent_touching += np.bincount(joints.pair, joints.extent, pairs)
    gap_limit = gap_sides.breadth if drawn_apart else SMALL_LENGTH_RATIO * gap_sides.width
    is_gap = (gap_sides.largest_gap <= gap_limit) & (
        gap_sides.extent > SMALL_LENGTH_RATIO * extent_touching[gap_sides.pair]
    )
    gap_sides = gap_sides.where(is_gap)
    if not touching:
        return gap_sides
    distance = [nearest(gap_sides.pair, gap_sides.middle, joints, joints.pair) for joints in touching]
    return gap_sides.where(np.min(distance, axis=0) > 2 * gap_sides.largest_gap)


def closing(scene: Scene, shapes: Extents, pairs: np.ndarray, gap_sides: Facing) -> Closing:
    """Return the scene option that closes all given gaps, and the smallest value that closes them.

    Gaps that are wide relative to a block, and gaps of a scene with a contact tolerance, are closed by the
    contact tolerance. A value of ``tolerance`` also makes the sides of the gaps parallel. ``pairs`` lists the
    blocks of each pair.
    """
    if not len(gap_sides.pair):
        return Closing()
    width = shapes.width[pairs[gap_sides.pair]].min(axis=1)
    if scene.contact_tolerance is not None or (gap_sides.largest_gap > NEAR_MISS * width).any():
        return Closing("contact_tolerance", float(gap_sides.largest_gap.max()))
    return Closing("tolerance", joining_tolerance(gap_sides))


def aligning_tolerance(facing: Facing) -> float:
    """Return the ``tolerance`` that makes nearly parallel sides parallel, or 0 if there are none.

    Two sides are nearly parallel if the alignment can remove the angle between them, which is then an error
    of the drawing. The tolerance is a multiple of the median error, because a drawing also contains sides of
    wedges. In space the result is also 0 if the tolerance would remove the narrowest joint.
    """
    is_error = facing.angle <= DEFAULT_SETTINGS.most_turn
    difference = (facing.angle * facing.shorter_side)[is_error]
    if not len(difference):
        return 0.0
    tolerance = _TOLERANCE_OVER_DIFFERENCE * float(np.median(difference))
    # A joint may be narrower than its faces by the tolerance, because errors of this size also move the edges
    # of the faces.
    narrowest = float(facing.shorter_side.min()) - tolerance
    in_space = facing.middle.shape[1] == 3
    return 0.0 if in_space and NARROWEST * tolerance > narrowest else tolerance


def joining_tolerance(gap_sides: Facing) -> float:
    """Return the least tolerance that closes all given gaps and makes their sides parallel.

    Without gaps the result is 0. If the angle between two sides is small enough to be removed by the
    alignment, one of their corners is assumed to be inexact. The tolerance is then at least a multiple of the
    error of this corner.
    """
    error = np.where(
        gap_sides.angle <= DEFAULT_SETTINGS.most_turn, gap_sides.angle * gap_sides.shorter_side, 0.0
    )
    return float(np.maximum(gap_sides.largest_gap, TOLERANCE_OVER_ERROR * error).max(initial=0.0))

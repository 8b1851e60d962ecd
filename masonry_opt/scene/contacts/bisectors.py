"""Find the directions of contacts between two blocks that meet at corners (in space, along edges).

Around such a point each block occupies a sector, and empty sectors lie between them.

- A line through the point that runs through both empty sectors separates the blocks. All these lines form a
  sector themselves, which is bounded by sides of the blocks that face each other. The contact lies on the
  bisector of these sides.
- If a side of one block and a side of the other lie in one line, the blocks would bear on each other along no
  length, or along less than the tolerance. Such a bearing is no contact.
- A corner in a notch cannot be separated by a line. If the corner were cut a little, it would touch both
  sides of the notch. It therefore has two contacts, one on each side.
"""

from typing import NamedTuple

import numpy as np

#: Largest angle in radians that counts as an error of the drawing. Sectors that overlap by a larger angle
#: have no contact. Two sides with a smaller angle between them count as one line.
_MOST_OVERLAP = 0.01


class Sectors(NamedTuple):
    """Angular sectors that blocks occupy around points.

    Each sector extends counter-clockwise from ``first`` to ``last``. Directions are angles in radians.
    """

    first: np.ndarray  #: direction of the side at which each sector begins, shape (points,)
    last: np.ndarray  #: direction of the side at which each sector ends, shape (points,)


def contact_normals(target: Sectors, opposite: Sectors) -> tuple[np.ndarray, np.ndarray]:
    """Return, for each contact, the index of its point and the angle of its normal in radians.

    Both arrays have the shape (contacts,). The normals point into the sectors ``target``. A point has no
    contact if the sectors overlap, or if two of their sides lie in one line.
    """
    widths = _turn(target.first, target.last), _turn(opposite.first, opposite.last)
    after_target, after_opposite = _turn(target.last, opposite.first), _turn(opposite.last, target.first)
    fits = np.abs(after_target + after_opposite + sum(widths) - 2 * np.pi) <= _MOST_OVERLAP
    # A line through the point separates the two blocks if it passes through both empty sectors between them.
    # Its angle, measured from the last side of the sector `target`, is then between `low` and `high`.
    shift = after_target + widths[1] - np.pi
    low, high = np.maximum(shift, 0.0), np.minimum(after_target, shift + after_opposite)
    in_line = np.minimum(np.abs(shift), np.abs(after_target - shift - after_opposite)) <= _MOST_OVERLAP
    separable_points = np.flatnonzero(fits & ~in_line & (high - low >= -_MOST_OVERLAP))
    points = [separable_points]
    normals = [(target.last + (low + high) / 2 - np.pi / 2)[separable_points]]
    for notch, width, sign in ((target, widths[0], 1.0), (opposite, widths[1], -1.0)):
        notch_points = np.flatnonzero(fits & (width > np.pi + _MOST_OVERLAP))
        points += [notch_points, notch_points]
        normals += [notch.first[notch_points] + sign * np.pi / 2, notch.last[notch_points] - sign * np.pi / 2]
    return np.concatenate(points), np.concatenate(normals)


def _turn(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the counter-clockwise angles from ``start`` to ``end``, between 0 and 2π.

    A clockwise angle of up to ``_MOST_OVERLAP`` is returned as a negative angle.
    """
    turn: np.ndarray = (end - start + _MOST_OVERLAP) % (2 * np.pi) - _MOST_OVERLAP
    return turn

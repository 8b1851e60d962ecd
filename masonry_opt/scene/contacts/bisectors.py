"""Find the plane that separates two blocks which meet at corners (in space, along edges).

Around such a point each block occupies a sector, and empty sectors lie between them. A line through the point
that runs through both empty sectors separates the blocks. All these lines form a sector themselves, which is
bounded by sides of the blocks that face each other. The contact lies on the bisector of these sides.
"""

from typing import NamedTuple

import numpy as np

#: Angle in radians up to which two sectors may overlap, because of errors of a drawing.
_MOST_OVERLAP = 0.01


class Sectors(NamedTuple):
    """Sectors that blocks occupy around points, as angles in radians. Sectors are counter-clockwise."""

    first: np.ndarray  #: direction of the side at which each sector begins, shape (points,)
    last: np.ndarray  #: direction of the side at which each sector ends, shape (points,)


def separating_normals(one: Sectors, other: Sectors) -> tuple[np.ndarray, np.ndarray]:
    """Return the normals of the lines that separate two sectors, and True where such a line exists.

    The normals are angles in radians, shape (points,), and point into the sectors ``one``. No line exists if
    a sector has an angle of more than 180°, or if the sectors overlap.
    """
    after_one, after_other = _turn(one.last, other.first), _turn(other.last, one.first)
    width = _turn(other.first, other.last)
    # Directions of the line in the empty sector after ``one``, measured from the last side of ``one``. The
    # opposite directions must be in the empty sector after ``other``.
    shift = after_one + width - np.pi
    least, most = np.maximum(shift, 0.0), np.minimum(after_one, shift + after_other)
    total = after_one + after_other + width + _turn(one.first, one.last)
    exists = (most - least >= -_MOST_OVERLAP) & (np.abs(total - 2 * np.pi) <= _MOST_OVERLAP)
    return one.last + (least + most) / 2 - np.pi / 2, exists


def _turn(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the counter-clockwise angle between directions; small clockwise angles are negative."""
    turn: np.ndarray = (end - start + _MOST_OVERLAP) % (2 * np.pi) - _MOST_OVERLAP
    return turn

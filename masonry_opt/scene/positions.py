"""Positions of points in the coordinates of a scene, and the rounding error of these coordinates."""

import numpy as np

from masonry_opt.scene.geometry import Extents

#: Largest difference of coordinates that counts as a rounding error, relative to the spacing of
#: floating-point numbers at the largest coordinate. With a larger value, small errors of a drawing count as
#: rounding errors and are not corrected.
_COORDINATE_ROUNDING = 64.0


def coordinate_rounding(shapes: Extents) -> float:
    """Return the largest difference of coordinates that counts as a rounding error, in the unit of length."""
    return _COORDINATE_ROUNDING * float(np.spacing(np.abs(shapes.boxes + shapes.origin).max()))


def in_scene(shapes: Extents, points: np.ndarray) -> np.ndarray:
    """Return points in the coordinates of the scene, for output.

    A coordinate that differs from zero only by a rounding error becomes zero.

    Parameters
    ----------
    shapes : Extents
        Shapes of the blocks of the scene.
    points : ndarray, shape (points, 2) or (points, 3)
        Points relative to the origin of the shapes. Unknown points are NaN.
    """
    positions = points + shapes.origin
    return np.where(np.abs(positions) <= coordinate_rounding(shapes), 0.0, positions)

"""Areas of fill and backing, drawn behind the blocks of a picture."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Patch

from masonry_opt.drawing.colours import FILL
from masonry_opt.problem.assembly import Assembly

#: Opacity of one layer of colour. Fill is drawn with one layer. Backing is drawn with a second layer over the
#: fill, and therefore looks darker.
_FILL_OPACITY = 0.22


def draw_fill(axes: Axes, assembly: Assembly) -> list[Patch]:
    """Draw the areas of fill and backing above the undisplaced blocks, and return their legend entries."""
    fills, backings = _areas(assembly)
    look: dict[str, Any] = {"facecolor": FILL, "alpha": _FILL_OPACITY, "linewidth": 0, "zorder": 0.2}
    handles = []
    for label, layers, areas in (("fill", 1, fills), ("backing", 2, backings)):
        if areas:
            axes.add_collection(PolyCollection(areas, **look), autolim=False)
            opacity = 1 - (1 - _FILL_OPACITY) ** layers
            handles.append(Patch(label=label, facecolor=FILL, alpha=opacity, linewidth=0))
    return handles


def _areas(assembly: Assembly) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the areas between block edges and the road, and between block edges and the line of backing.

    Each area is a polygon with four corners in the coordinates of the scene, shape (4, 2).
    """
    fills, backings = list[np.ndarray](), list[np.ndarray]()
    for piece in assembly.filled_pieces:
        foot = piece.ends + assembly.geometry.origin
        if not np.ptp(foot[:, 0]):  # there is no area above a vertical face
            continue
        fills.append(_above(foot, foot[:, 1] + piece.depth))
        if piece.zone:
            backing = assembly.scene.fills[piece.fill].zones[piece.zone]
            backings.append(_above(foot, np.interp(foot[:, 0], *np.array(backing.road).T)))
    return fills, backings


def _above(foot: np.ndarray, top: np.ndarray) -> np.ndarray:
    """Return the corners of the area between a segment ``foot`` and the line above it, shape (4, 2).

    ``top`` contains the heights of the two upper corners.
    """
    return np.array([*foot, (foot[1, 0], top[1]), (foot[0, 0], top[0])])

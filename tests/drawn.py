"""What is on the axes of a picture, by its colour."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_rgba
from matplotlib.quiver import Quiver


def same(drawn: np.ndarray, colour: str | tuple[float, ...]) -> bool:
    """Whether two colours are one, but for a step of a colour map."""
    return bool(np.allclose(drawn, to_rgba(colour), atol=0.02))


def lines(axes: Axes, colour: str | tuple[float, ...]) -> np.ndarray:
    """Ends of the joints or forces drawn as lines, shape (lines, 2, 2)."""
    found = [
        segment
        for drawn in axes.collections
        if isinstance(drawn, LineCollection)
        for segment, own in zip(
            drawn.get_segments(), np.resize(drawn.get_color(), (len(drawn.get_segments()), 4)), strict=True
        )
        if same(own, colour)
    ]
    return np.array(found).reshape(-1, 2, 2)


def marks(axes: Axes, colour: str) -> np.ndarray:
    """Where there are marks, shape (marks, 2)."""
    found = [
        np.ma.getdata(drawn.get_offsets())
        for drawn in axes.collections
        if isinstance(drawn, PathCollection) and len(drawn.get_offsets()) and drawn.get_sizes().size
        if same(drawn.get_facecolor()[0], colour)
    ]
    return np.concatenate([np.empty((0, 2)), *found])


def arrows(axes: Axes, colour: str) -> np.ndarray:
    """Tails and tips of the arrows of loads, shape (arrows, 2, 2)."""
    found = [
        np.stack([drawn.XY, drawn.XY + np.column_stack([drawn.U, drawn.V])], axis=1)
        for drawn in axes.collections
        if isinstance(drawn, Quiver) and same(drawn.get_facecolor()[0], colour)
    ]
    return np.concatenate([np.empty((0, 2, 2)), *found])


def legend(figure) -> list[str]:
    """What the legend says."""
    return [text.get_text() for text in figure.legends[0].get_texts()]

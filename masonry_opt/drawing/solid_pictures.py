"""Solids by matplotlib, seen from one side: faces as an image, lines and marks as vectors."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb

from masonry_opt.drawing.carried import round_below
from masonry_opt.drawing.colours import AT_REST, BLOCK, FIXED, HATCH
from masonry_opt.drawing.elements import INSIDE, Elements
from masonry_opt.drawing.figure import draw_marks, write_name
from masonry_opt.drawing.marks import Marks
from masonry_opt.drawing.solids import surface
from masonry_opt.drawing.view import ViewAngles, axes_of, raster

_PIXELS = 1400  #: Pixels along the longer side of the image of faces.
_LIGHT = np.array([-0.35, 0.55, 0.75])  #: Where light comes from, in the picture's axes.
_SHADE = 0.68  #: Share of it that reaches faces turned away.
_PALE = 0.55  #: How far faces are turned to white where joints show something else than their motion.
_MARGIN = 0.03  #: Free round what is shown, over the longer side.
_AXES = 0.1  #: Length of the axes shown, at most, over the longer side.
_LETTERS = 1.4  #: How far their letters are, over that.
_NAME, _LEAST_NAME = 8.0, 2.0  #: Size of the letters of block names in points, largest and smallest.
_LETTER = 0.62  #: Their width over their height.


class Solids:
    """Elements in space on axes of matplotlib, in the case's unit of length, with the marks shown, after a
    share of the full motion."""

    def __init__(
        self, axes: Axes, elements: Elements, marks: list[Marks], share: float, view: ViewAngles
    ) -> None:
        self.axes, self.elements, self.marks, self.share, self.view = axes, elements, marks, share, view
        self.turned = axes_of(view)
        self.surface = surface(elements)
        moved = self.surface.moved(share * elements.motion)
        self.triangles, self.edges = (each @ self.turned.T for each in moved)
        shown = [self.triangles, *(each.moved(share) @ self.turned.T for each in marks)]
        flat = np.concatenate([each.reshape(-1, 3)[:, :2] for each in shown])
        low, high = flat.min(axis=0), flat.max(axis=0)
        side = float((high - low).max())
        self.box = np.array([low - _MARGIN * side, high + _MARGIN * side])
        self.raster = raster(self.triangles, self.box, _PIXELS)
        self.unit = round_below(_AXES * side)
        # The axes stand in the lower left corner, or below it where something is drawn there.
        around = 2 * _LETTERS * self.unit
        corner = np.s_[: int(around / self.raster.pixel), : int(around / self.raster.pixel)]
        if (self.raster.triangle[corner] >= 0).any():
            self.box[0, 1] -= around
        self.foot = self.box[0] + around / 2

    @property
    def note(self) -> str:
        """How large the axes are, and from where the scene is seen."""
        azimuth, elevation = self.view
        seen = f"seen from azimuth {azimuth:g}°, elevation {elevation:g}°"
        return f"axes: {self.unit:g} long, in the length unit of the case; {seen}"

    def draw(self) -> None:
        """Draw faces, edges, and marks; what lies behind faces is left out, but what lies inside blocks."""
        axes = self.axes
        (left, bottom), (right, top) = self.box
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
        axes.set_axis_off()
        rows, columns = self.raster.depth.shape
        at = (self.raster.left, self.raster.bottom)
        reach = (at[0], at[0] + columns * self.raster.pixel, at[1], at[1] + rows * self.raster.pixel)
        axes.imshow(self._faces(), extent=reach, origin="lower", zorder=1, interpolation="antialiased")
        movable = np.isin(self.surface.of_edge, self.elements.assembly.movable)
        if self.share and self.elements.movement:
            self._lines(self._at_rest(movable), AT_REST, 0.5, 1.5)
        self._lines(self.surface.hatching @ self.turned.T, HATCH, 0.4, 2.0)
        width = self.elements.outline_width
        self._lines(self.edges[movable], "black", width, 2.2)
        self._lines(self.edges[~movable], HATCH, width, 2.1)
        for marks, points in self._seen():
            if len(points):
                draw_marks(axes, marks, points)

    def _faces(self) -> np.ndarray:
        """Colours of the pixels, shape (rows, columns, 4)."""
        sides = np.diff(self.triangles, axis=1)
        normal = np.cross(sides[:, 0], sides[:, 1])
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        light = np.clip(normal @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
        own = ~np.isin(self.surface.of_triangle, self.elements.supports)
        colours = np.where(own[:, None], to_rgb(BLOCK), to_rgb(FIXED))
        colours = colours * (_SHADE + (1 - _SHADE) * light)[:, None]
        if not self.share:
            colours = 1 - (1 - colours) * (1 - _PALE)
        # The last row, for pixels without a triangle (-1), is transparent.
        table = np.vstack([np.column_stack([colours, np.ones(len(colours))]), np.zeros(4)])
        return table[self.raster.triangle]

    def _lines(self, lines: np.ndarray, colour: str, width: float, order: float) -> None:
        pieces, _ = self.raster.visible(lines)
        self.axes.add_collection(LineCollection(list(pieces), color=colour, linewidth=width, zorder=order))

    def _at_rest(self, movable: np.ndarray) -> np.ndarray:
        """Edges of the movable blocks as they would be seen at rest."""
        at_rest = self.surface.triangles, self.surface.edges[movable]
        triangles, edges = (each @ self.turned.T for each in at_rest)
        pieces, line = raster(triangles, self.box, _PIXELS).visible(edges)
        start, run = edges[line, 0], edges[line, 1] - edges[line, 0]
        square = np.maximum((run[:, :2] ** 2).sum(axis=1), 1e-300)
        share = np.einsum("nki,ni->nk", pieces - start[:, None, :2], run[:, :2]) / square[:, None]
        return start[:, None] + share[..., None] * run[:, None]

    def _seen(self) -> Iterator[tuple[Marks, np.ndarray]]:
        """Marks, and what is seen of them, in the picture's plane."""
        for marks in self.marks:
            at = marks.moved(self.share) @ self.turned.T
            if marks.shape == "arrow" or marks.name in INSIDE:
                yield marks, at[..., :2]
            elif marks.shape == "line":
                yield marks, self.raster.visible(at)[0]
            else:
                yield marks, at[self.raster.sees(at[:, 0]), :, :2]

    def write(self, names: bool) -> None:
        """Write the letters of the axes, and names on blocks that are seen; the axes' size must be set."""
        arrow = {"arrowstyle": "->", "shrinkA": 0, "shrinkB": 0}
        for direction, letter in zip(self.turned.T, "xyz", strict=True):
            tip = self.foot + self.unit * direction[:2]
            self.axes.annotate("", tip, self.foot, arrowprops=arrow)
            at = self.foot + _LETTERS * self.unit * direction[:2]
            self.axes.text(at[0], at[1], letter, ha="center", va="center", fontsize=9)
        if names:
            self._write_names()

    def _write_names(self) -> None:
        seen = self.raster
        row, column = np.nonzero(seen.triangle >= 0)
        block = self.surface.of_triangle[seen.triangle[row, column]]
        blocks = self.elements.assembly.scene.blocks
        (left, _), (right, _) = self.box
        points_per_unit = 72 / self.axes.figure.dpi * self.axes.bbox.width / (right - left)
        for number in np.unique(block):
            own = block == number
            # The pixel nearest to the middle of those seen lies on the block.
            x, y = column[own], row[own]
            middle = int(np.argmin((x - x.mean()) ** 2 + (y - y.mean()) ** 2))
            at = np.array([seen.left, seen.bottom]) + (np.array([x[middle], y[middle]]) + 0.5) * seen.pixel
            wide, high = (np.ptp(side) * seen.pixel * points_per_unit for side in (x, y))
            name = blocks[number].name
            letters = min(0.8 * wide / (_LETTER * len(name)), 0.4 * high, _NAME)
            if letters >= _LEAST_NAME:
                write_name(self.axes, name, at, letters, 0.2, va="center")

"""Scenes and results in the plane as SVG, which the script of a page moves."""

from collections.abc import Iterable
from html import escape
from itertools import groupby

import numpy as np
import shapely

from masonry_opt.drawing.colours import AT_REST, BLOCK, HATCH, SUPPORT_COLOUR
from masonry_opt.drawing.elements import Elements, legend
from masonry_opt.drawing.marks import FEWEST_JOINTS_WITH_SMALL_MARKS, Marks, hatching, line_parts, outlines

#: Length of the longer side of an SVG picture, in units of the picture. Coordinates are rounded to whole
#: units, so a larger value makes coordinates more exact and files larger.
LONGER_SIDE = 10_000
#: Pixels on a page for each point (1/72 inch) of a mark's width. The value exceeds 1, because screens are
#: read from farther away than prints. A larger value makes marks thicker.
_PIXELS_PER_POINT = 1.5
#: Value of ``_PIXELS_PER_POINT`` for scenes with many joints. It is smaller, because thick marks on
#: neighbouring joints would overlap.
_PIXELS_PER_POINT_OF_MANY = 1.0
#: Smallest motion that is animated, in units of the picture. An element that moves less has no motion
#: attribute and stays at rest.
_LEAST_DRAWN_MOTION = 2.0
_CROSS_STROKE = 1.5  #: Width of the lines of crosses, in points.
_HATCH_STEP = 150  #: Distance between the hatching lines on supports, in units of the picture.
_LETTER_HEIGHT = 270  #: Height of letters, in units of the picture.
#: Path data of the legend sample of dots, points and squares: a line of zero length. The caps of the line are
#: drawn as a dot or a square.
_LEGEND_DOT = "M14 6h0"
_ARROW_HEAD = 0.24  #: Length of an arrow's head, relative to the length of the arrow.


class Canvas:
    """Coordinate system of an SVG picture that shows part of a scene.

    Coordinates of the picture are whole numbers, with y downwards. Coordinates of the scene are relative to
    the geometry's origin. Elements that move have the attribute ``data-motion``, which contains their full
    motion (see :func:`~.marks.moved`). The script of a page moves elements by this attribute.
    """

    def __init__(self, elements: Elements, marks: Iterable[Marks]) -> None:
        (self.left, bottom), (right, self.top) = elements.box(marks, 1.0).tolist()
        self.pixels = (
            _PIXELS_PER_POINT
            if len(elements.assembly.joints.extent) < FEWEST_JOINTS_WITH_SMALL_MARKS
            else _PIXELS_PER_POINT_OF_MANY
        )
        self.scale = LONGER_SIDE / max(right - self.left, self.top - bottom)
        self.width = round((right - self.left) * self.scale)
        self.height = round((self.top - bottom) * self.scale)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Convert points of the scene, shape (..., 2), to coordinates of the picture."""
        return np.rint((points - [self.left, self.top]) * [self.scale, -self.scale]).astype(int)

    def motions(self, motion: np.ndarray) -> np.ndarray:
        """Convert motions, shape (..., 3), from coordinates of the scene to coordinates of the picture."""
        vx, vy, omega = np.moveaxis(motion, -1, 0)
        right, down = self.scale * (vx - omega * self.top), -self.scale * (vy + omega * self.left)
        return np.stack([right, down, -omega], axis=-1)

    def moves(self, motion: np.ndarray) -> str:
        """Return the SVG attribute ``data-motion`` for a motion, shape (3,).

        "" if the motion is too small to see.
        """
        vx, vy, omega = self.motions(motion).tolist()
        if abs(vx) + abs(vy) + LONGER_SIDE * abs(omega) < _LEAST_DRAWN_MOTION:
            return ""
        return f' data-motion="{round(vx)} {round(vy)} {round(omega, 5) + 0.0:.5f}"'

    def line(self, points: np.ndarray, closed: bool = False) -> str:
        """Return a polyline as SVG path data, from points in the coordinates of the scene."""
        return _polyline(self.at(points), closed)

    def svg(self, title: str, elements: Iterable[str]) -> str:
        """Return the complete SVG picture, with a title for screen readers."""
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" role="img" '
            f'aria-label="{escape(title)}" class="picture" style="--ratio: {self.width / self.height:.4f}">'
            f"{''.join(elements)}</svg>"
        )


def _path(d: str, moves: str = "") -> str:
    """Return an SVG path element with path data ``d`` and a motion attribute.

    "" if the path data is empty.
    """
    return f'<path d="{d}"{moves}/>' if d else ""


def _attributes(values: dict[str, object]) -> str:
    """Return SVG attributes as text; underscores in their names become hyphens."""
    return "".join(f' {key.replace("_", "-")}="{value}"' for key, value in values.items())


def group(name: str, elements: Iterable[str], **attributes: object) -> str:
    """Return an SVG group of elements with common attributes, or "" if there are no elements."""
    inside = "".join(elements)
    return f'<g class="{name}"{_attributes(attributes)}>{inside}</g>' if inside else ""


def blocks_svg(elements: Elements, canvas: Canvas) -> str:
    """Return all blocks as SVG: outlines of undisplaced blocks, moved blocks, and hatched supports."""
    assembly, shapes = elements.assembly, elements.assembly.geometry.polygons
    drawn = ["".join(canvas.line(ring, closed=True) for ring in rings) for rings in outlines(shapes)]
    movable = np.isin(np.arange(len(shapes)), assembly.movable)
    rest = "".join(drawn[block] for block in assembly.movable) if elements.movement else ""
    moves = [canvas.moves(motion) for motion in elements.motion]
    groups = []
    # Consecutive blocks with equal motions form one SVG group, which moves as a whole.
    for (is_movable, motion), run in groupby(
        range(len(shapes)), lambda block: (movable[block], moves[block])
    ):
        paths = "".join(_path(drawn[block]) for block in run)
        support = f' fill="{SUPPORT_COLOUR}" stroke="none" class="fixed"'
        groups.append(f"<g{motion if is_movable else support}>{paths}</g>")
    width = f"{canvas.pixels * elements.outline_width:.2g}"
    blocks = {"fill": BLOCK, "fill_rule": "evenodd", "stroke": "#000", "stroke_width": width}
    return (
        group("rest", [_path(rest)], fill="none", stroke=AT_REST, stroke_width=0.75)
        + group("blocks", groups, stroke_linejoin="round", **blocks)
        + group("supports", [_hatching(shapes[~movable], canvas)], fill="none", stroke=HATCH, stroke_width=1)
    )


def _hatching(shapes: np.ndarray, canvas: Canvas) -> str:
    """Return hatching and edges of supports as one SVG path, limited to the visible part of the supports."""
    whole = shapely.union_all(shapes)
    wide, high = canvas.width / canvas.scale, canvas.height / canvas.scale
    box = canvas.left, canvas.top - high, canvas.left + wide, canvas.top
    shown = shapely.box(*box)
    edges = line_parts(shapely.intersection(shapely.boundary(whole), shown))
    parts = [*hatching(shapely.intersection(whole, shown), box, _HATCH_STEP / canvas.scale), *edges]
    return _path("".join(canvas.line(shapely.get_coordinates(part)) for part in parts))


def marks_svg(marks: Marks, canvas: Canvas) -> str:
    """Return marks of one kind as SVG. Marks with equal motions are combined into one path."""
    at = canvas.at(marks.points)
    no_motion = np.zeros((len(at), 3))
    paths: dict[str, str] = {}
    all_motions = no_motion if marks.motion is None else marks.motion
    for points, motion in zip(at, all_motions, strict=True):
        moves = canvas.moves(motion)
        paths[moves] = paths.get(moves, "") + _mark(marks, points)
    drawn = [_path(d, moves) for moves, d in paths.items()]
    rims, stroke = "", _stroke(marks, canvas.pixels)
    if marks.shape == "dot":
        rim_width = f"{canvas.pixels * marks.width + 2:.2g}"
        rims = group("rims", drawn, **stroke | {"stroke": "#fff", "stroke_width": rim_width})
    if marks.text:
        x, y = at[0, 1] + [_LETTER_HEIGHT // 2, _LETTER_HEIGHT // 3]
        look = f'x="{x}" y="{y}" font-size="{_LETTER_HEIGHT}" stroke="none"'
        drawn.append(f"<text {look}>{escape(marks.text)}</text>")
    return rims + group(marks.name, drawn, **stroke)


def _mark(marks: Marks, points: np.ndarray) -> str:
    """Return a mark as SVG path data. An arrow consists of a line and the outline of its head."""
    if marks.shape == "arrow":
        tail, tip = points
        head = _ARROW_HEAD * (tip - tail)
        base, across = tip - head, 0.4 * np.array([-head[1], head[0]])
        corners = np.rint([base + across, tip, base - across, base + across]).astype(int)
        return _polyline(points) + _polyline(corners, closed=True)
    if marks.shape == "bar":
        (left, y), (right, _) = points
        return f"M{left} {y}h{right - left}M{left} {y - 75}v150M{right} {y - 75}v150"
    if marks.shape == "cross":
        (x, y), half = points[0], LONGER_SIDE // 160
        return f"M{x - half} {y - half}l{2 * half} {2 * half}m0-{2 * half}l-{2 * half} {2 * half}"
    return _polyline(points[[0, -1]])


def _polyline(points: np.ndarray, closed: bool = False) -> str:
    """Return a polyline as SVG path data, from points in the coordinates of the picture."""
    start, steps = points[0], np.diff(points[:-1] if closed else points, axis=0).ravel()
    text = f"M{start[0]} {start[1]}l{' '.join(map(str, steps.tolist()))}{'z' if closed else ''}"
    return text.replace(" -", "-")


def _stroke(marks: Marks, pixels: float = _PIXELS_PER_POINT) -> dict[str, object]:
    """Return the SVG attributes of marks: the stroke of lines, and the fill of areas.

    ``pixels`` is the number of pixels for each point of the marks' width.
    """
    width = pixels * (_CROSS_STROKE if marks.shape == "cross" else marks.width)
    caps = {"dot": "round", "point": "round", "square": "square"}
    stroke: dict[str, object] = {
        "fill": marks.colour if marks.shape in ("arrow", "bar") else "none",
        "stroke": marks.colour,
        "stroke_width": f"{width:.2g}",
        "stroke_linecap": caps.get(marks.shape, "butt" if marks.dashes else "round"),
    }
    if marks.dashes:
        stroke["stroke_dasharray"] = " ".join(f"{width * dash:.2g}" for dash in marks.dashes)
    return stroke


def legend_svg(marks: Iterable[Marks]) -> list[str]:
    """Return the SVG entries of a legend: block, support, and one entry for each label of the marks."""
    block = f'<path fill="{BLOCK}" stroke="#000" d="M1 1h26v10h-26z"/>'
    support = f'<path fill="{SUPPORT_COLOUR}" d="M1 1h26v10h-26z"/>'
    hatching = f'<path stroke="{HATCH}" d="M3 11l10-10M11 11l10-10M19 11l8-8"/>'
    entries = [_entry(block, "block"), _entry(support + hatching, "support")]
    samples = {"line": "M3 6h22", "arrow": "M4 6h14M18 2.5L25 6l-7 3.5z", "cross": "M11 3l6 6m0-6l-6 6"}
    for label, alike in legend(marks).items():
        paths = (
            f'<path{_attributes(_stroke(mark_group))} d="{samples.get(mark_group.shape, _LEGEND_DOT)}"/>'
            for mark_group in alike
        )
        entries.append(_entry("".join(paths), label))
    return entries


def _entry(sample: str, words: str) -> str:
    """Return a legend entry: a small SVG sample, followed by its label."""
    return f'<svg width="28" height="12" fill="none" aria-hidden="true">{sample}</svg> {words}'

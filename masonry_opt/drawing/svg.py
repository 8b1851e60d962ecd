"""Scenes and results as SVG, moved by a script."""

from collections.abc import Iterable
from html import escape
from itertools import groupby

import numpy as np
import shapely

from masonry_opt.drawing.colours import AT_REST, BLOCK, FIXED, HATCH
from masonry_opt.drawing.elements import Elements, legend
from masonry_opt.drawing.marks import MANY, Marks, hatching, line_parts, outlines

SIDE = 10_000  #: The picture's longer side. Coordinates are whole numbers, which keeps large scenes short.
_PIXELS = 1.5  #: Pixels for a point of a printed picture: pages are read from further away.
_OF_MANY = 1.0  #: The same of many marks, which would hide each other.
_STILL = 2.0  #: Motions of less than these units of the picture are not seen, and not written.
_CROSS = 1.5  #: Width of the lines of crosses, in points.
_HATCH, _LETTERS = 150, 270  #: Distance of the lines that hatch supports, height of letters.
_DOT = "M14 6h0"  #: In a legend, of marks without ends.
_HEAD = 0.24  #: Length of an arrow's head over the arrow.


class Canvas:
    """A picture in SVG of part of a scene: whole numbers, y downwards; those of the scene are relative to the
    geometry's origin. A script moves it by ``data-motion``, the full motion as ``marks.moved`` takes it."""

    def __init__(self, elements: Elements, marks: Iterable[Marks]) -> None:
        (self.left, bottom), (right, self.top) = elements.box(marks, 1.0).tolist()
        self.pixels = _PIXELS if len(elements.assembly.joints.extent) < MANY else _OF_MANY
        self.scale = SIDE / max(right - self.left, self.top - bottom)
        self.width = round((right - self.left) * self.scale)
        self.height = round((self.top - bottom) * self.scale)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Where points of the scene are in the picture, shape (..., 2)."""
        return np.rint((points - [self.left, self.top]) * [self.scale, -self.scale]).astype(int)

    def motions(self, motion: np.ndarray) -> np.ndarray:
        """Full motions of the scene, shape (..., 3), as those of the picture."""
        vx, vy, omega = np.moveaxis(motion, -1, 0)
        right, down = self.scale * (vx - omega * self.top), -self.scale * (vy + omega * self.left)
        return np.stack([right, down, -omega], axis=-1)

    def moves(self, motion: np.ndarray) -> str:
        """The attribute that moves an element by a motion of the scene, shape (3,); "" where it stays."""
        vx, vy, omega = self.motions(motion).tolist()
        if abs(vx) + abs(vy) + SIDE * abs(omega) < _STILL:
            return ""
        return f' data-motion="{round(vx)} {round(vy)} {round(omega, 5) + 0.0:.5f}"'

    def line(self, points: np.ndarray, closed: bool = False) -> str:
        """A polyline through points of the scene, as ``d`` of a path: its first point, then steps."""
        return _polyline(self.at(points), closed)

    def svg(self, title: str, elements: Iterable[str]) -> str:
        """The whole picture, whose title is told to readers who cannot see it."""
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" role="img" '
            f'aria-label="{escape(title)}" class="picture" style="--ratio: {self.width / self.height:.4f}">'
            f"{''.join(elements)}</svg>"
        )


def _path(d: str, moves: str = "") -> str:
    """One path, with the attribute that moves it; nothing without lines."""
    return f'<path d="{d}"{moves}/>' if d else ""


def _attributes(given: dict[str, object]) -> str:
    return "".join(f' {key.replace("_", "-")}="{value}"' for key, value in given.items())


def group(name: str, elements: Iterable[str], **attributes: object) -> str:
    """Elements that share attributes; nothing where there is none."""
    inside = "".join(elements)
    return f'<g class="{name}"{_attributes(attributes)}>{inside}</g>' if inside else ""


def blocks_svg(elements: Elements, canvas: Canvas) -> str:
    """Supports, hatched; where movable blocks are at rest; and all blocks, in the order of the scene."""
    assembly, shapes = elements.assembly, elements.assembly.geometry.polygons
    drawn = ["".join(canvas.line(ring, closed=True) for ring in rings) for rings in outlines(shapes)]
    movable = np.isin(np.arange(len(shapes)), assembly.movable)
    rest = "".join(drawn[block] for block in assembly.movable) if elements.movement else ""
    moves = [canvas.moves(motion) for motion in elements.motion]
    groups = []
    # Blocks that move as one are one group.
    for (own, motion), run in groupby(range(len(shapes)), lambda block: (movable[block], moves[block])):
        paths = "".join(_path(drawn[block]) for block in run)
        support = f' fill="{FIXED}" stroke="none" class="fixed"'
        groups.append(f"<g{motion if own else support}>{paths}</g>")
    width = f"{canvas.pixels * elements.outline_width:.2g}"
    blocks = {"fill": BLOCK, "fill_rule": "evenodd", "stroke": "#000", "stroke_width": width}
    return (
        group("rest", [_path(rest)], fill="none", stroke=AT_REST, stroke_width=0.75)
        + group("blocks", groups, stroke_linejoin="round", **blocks)
        + group("supports", [_hatching(shapes[~movable], canvas)], fill="none", stroke=HATCH, stroke_width=1)
    )


def _hatching(shapes: np.ndarray, canvas: Canvas) -> str:
    """Lines at 45° on what the picture shows of supports, and their edges."""
    whole = shapely.union_all(shapes)
    wide, high = canvas.width / canvas.scale, canvas.height / canvas.scale
    box = canvas.left, canvas.top - high, canvas.left + wide, canvas.top
    shown = shapely.box(*box)
    edges = line_parts(shapely.intersection(shapely.boundary(whole), shown))
    parts = [*hatching(shapely.intersection(whole, shown), box, _HATCH / canvas.scale), *edges]
    return _path("".join(canvas.line(shapely.get_coordinates(part)) for part in parts))


def marks_svg(marks: Marks, canvas: Canvas) -> str:
    """Marks of one kind; those that move alike are one path."""
    at = canvas.at(marks.points)
    still = np.zeros((len(at), 3))
    paths: dict[str, str] = {}
    for points, motion in zip(at, still if marks.motion is None else marks.motion, strict=True):
        moves = canvas.moves(motion)
        paths[moves] = paths.get(moves, "") + _mark(marks, points)
    drawn = [_path(d, moves) for moves, d in paths.items()]
    rims, stroke = "", _stroke(marks, canvas.pixels)
    if marks.shape == "dot":
        wider = f"{canvas.pixels * marks.width + 2:.2g}"
        rims = group("rims", drawn, **stroke | {"stroke": "#fff", "stroke_width": wider})
    if marks.text:
        x, y = at[0, 1] + [_LETTERS // 2, _LETTERS // 3]
        look = f'x="{x}" y="{y}" font-size="{_LETTERS}" stroke="none"'
        drawn.append(f"<text {look}>{escape(marks.text)}</text>")
    return rims + group(marks.name, drawn, **stroke)


def _mark(marks: Marks, points: np.ndarray) -> str:
    """One mark as ``d`` of a path; an arrow is a line, and a head in outline."""
    if marks.shape == "arrow":
        tail, tip = points
        head = _HEAD * (tip - tail)
        base, across = tip - head, 0.4 * np.array([-head[1], head[0]])
        corners = np.rint([base + across, tip, base - across, base + across]).astype(int)
        return _polyline(points) + _polyline(corners, closed=True)
    if marks.shape == "bar":
        (left, y), (right, _) = points
        return f"M{left} {y}h{right - left}M{left} {y - 75}v150M{right} {y - 75}v150"
    if marks.shape == "cross":
        (x, y), half = points[0], SIDE // 160
        return f"M{x - half} {y - half}l{2 * half} {2 * half}m0-{2 * half}l-{2 * half} {2 * half}"
    return _polyline(points[[0, -1]])


def _polyline(points: np.ndarray, closed: bool = False) -> str:
    start, steps = points[0], np.diff(points[:-1] if closed else points, axis=0).ravel()
    text = f"M{start[0]} {start[1]}l{' '.join(map(str, steps.tolist()))}{'z' if closed else ''}"
    return text.replace(" -", "-")


def _stroke(marks: Marks, pixels: float = _PIXELS) -> dict[str, object]:
    """How the paths of marks are drawn, with so many pixels for a point."""
    width = pixels * (_CROSS if marks.shape == "cross" else marks.width)
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
    """Entries of a legend: blocks, supports, and marks by their labels."""
    block = f'<path fill="{BLOCK}" stroke="#000" d="M1 1h26v10h-26z"/>'
    support = f'<path fill="{FIXED}" d="M1 1h26v10h-26z"/>'
    hatching = f'<path stroke="{HATCH}" d="M3 11l10-10M11 11l10-10M19 11l8-8"/>'
    entries = [_entry(block, "block"), _entry(support + hatching, "support")]
    samples = {"line": "M3 6h22", "arrow": "M4 6h14M18 2.5L25 6l-7 3.5z", "cross": "M11 3l6 6m0-6l-6 6"}
    for label, alike in legend(marks).items():
        paths = (f'<path{_attributes(_stroke(each))} d="{samples.get(each.shape, _DOT)}"/>' for each in alike)
        entries.append(_entry("".join(paths), label))
    return entries


def _entry(drawn: str, words: str) -> str:
    return f'<svg width="28" height="12" fill="none" aria-hidden="true">{drawn}</svg> {words}'

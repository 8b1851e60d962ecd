"""A result drawn as SVG: supports, blocks, loads, and how joints move."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from itertools import groupby

import numpy as np
import shapely

from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.result import Result
from masonry_opt.report.colours import AT_REST, BLOCK, CRUSHES, FIXED, HATCH, HINGES, SEPARATES, SLIDES
from masonry_opt.report.page.view import SIDE, View

#: Motions of less than these units of the picture are not seen, and not written: nothing is counted by it.
_STILL = 2.0

#: Distance of the lines that hatch supports.
_HATCH = 150


class Pen:
    """Writes elements of SVG, which move with blocks.

    Parameters
    ----------
    view: of the scene.
    share: of the mechanism that is drawn; None for a picture that a script moves, by the attribute
        ``data-motion``: what a full motion adds, as in :class:`~.view.View`.
    """

    def __init__(self, view: View, share: float | None = None) -> None:
        self.view, self.share = view, share

    def path(self, d: str, motion: np.ndarray | None = None) -> str:
        """One path, with the motion of what it belongs to."""
        # A page says it once, in its style.
        width = "" if self.share is None else ' vector-effect="non-scaling-stroke"'
        return f'<path d="{d}"{width}{"" if motion is None else self.moves(motion)}/>'

    def moves(self, motion: np.ndarray) -> str:
        """The attribute that moves an element, shape (3,); nothing where it stays."""
        vx, vy, omega = motion.tolist()
        if abs(vx) + abs(vy) + SIDE * abs(omega) < _STILL:
            return ""
        if self.share is None:
            return f' data-motion="{round(vx)} {round(vy)} {round(omega, 5) + 0.0:.5f}"'
        t = self.share
        turn = round(t * omega, 5) + 0.0  # no minus before a zero
        return f' transform="matrix(1 {turn:.5f} {0.0 - turn:.5f} 1 {round(t * vx)} {round(t * vy)})"'

    def line(self, points: np.ndarray, closed: bool = False) -> str:
        """A polyline through points of the scene, as ``d`` of a path."""
        return outline(self.view.at(points), closed)

    def lines(self, start: np.ndarray, end: np.ndarray) -> list[str]:
        """Straight lines between points of the scene, shape (lines, 2) each, as ``d`` of paths."""
        ends = np.column_stack([self.view.at(start), self.view.at(end)]).tolist()
        return [f"M{x} {y}l{to_x - x} {to_y - y}".replace(" -", "-") for x, y, to_x, to_y in ends]


def outline(points: np.ndarray, closed: bool = False) -> str:
    """A polyline through points of the picture, as ``d`` of a path: its first point, then steps."""
    start, steps = points[0], np.diff(points[:-1] if closed else points, axis=0).ravel()
    text = f"M{start[0]} {start[1]}l{' '.join(map(str, steps))}{'z' if closed else ''}"
    return text.replace(" -", "-")


def group(name: str, elements: Iterable[str], **attributes: object) -> str:
    """Elements that share attributes; nothing where there is none."""
    inside = "".join(elements)
    if not inside:
        return ""
    given = "".join(f' {key.replace("_", "-")}="{value}"' for key, value in attributes.items())
    return f'<g class="{name}"{given}>{inside}</g>'


def svg(view: View, title: str, elements: Iterable[str], attributes: str) -> str:
    """A whole picture, whose title is told to whoever cannot see it."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {view.width} {view.height}" role="img" '
        f'aria-label="{escape(title)}" {attributes}>{"".join(elements)}</svg>'
    )


def draw_blocks(result: Result, pen: Pen) -> str:
    """Supports, hatched; where movable blocks are at rest; and all blocks, in the order of the scene."""
    assembly, motions = result.assembly, pen.view.motions
    shapes, count = assembly.geometry.polygons, len(assembly.geometry.polygons)
    outlines = _outlines(shapes, pen)
    movable = np.isin(np.arange(count), assembly.movable)
    moves = np.abs(motions).sum(axis=1) > 0
    rest = "".join(outlines[block] for block in np.flatnonzero(moves))
    drawn = []
    # Blocks that move as one are one group.
    for alike, run in groupby(range(count), lambda block: (movable[block], pen.moves(motions[block]))):
        paths = "".join(pen.path(outlines[block]) for block in run)
        of_run = alike[1] if alike[0] else f' fill="{FIXED}" stroke="none" class="fixed"'
        drawn.append(f"<g{of_run}>{paths}</g>")
    return (
        group("rest", [pen.path(rest)] if rest else [], fill="none", stroke=AT_REST, stroke_width=0.75)
        + group(
            "blocks",
            drawn,
            fill=BLOCK,
            fill_rule="evenodd",
            stroke="#000",
            stroke_width=1 if count < 300 else 0.4,
            stroke_linejoin="round",
        )
        + group("supports", _hatching(list(shapes[~movable]), pen), fill="none", stroke=HATCH, stroke_width=1)
    )


def _outlines(shapes: np.ndarray, pen: Pen) -> list[str]:
    """Of each block its outlines and those of its holes, as ``d`` of one path."""
    parts, block = shapely.get_parts(shapes, return_index=True)
    rings, part = shapely.get_rings(parts, return_index=True)
    corners, ring = shapely.get_coordinates(rings, return_index=True)
    pieces = np.split(pen.view.at(corners), np.flatnonzero(np.diff(ring)) + 1)
    drawn = [""] * len(shapes)
    for owner, points in zip(block[part], pieces, strict=True):
        drawn[owner] += outline(points, closed=True)
    return drawn


def _hatching(shapes: list[shapely.Geometry], pen: Pen) -> list[str]:
    """Lines at 45° on what the picture shows of supports, and their edges."""
    view = pen.view
    width, height = view.width / view.scale, view.height / view.scale
    shown = shapely.box(view.left, view.top - height, view.left + width, view.top)
    fixed = shapely.intersection(shapely.union_all(shapes), shown)
    step = _HATCH / view.scale
    starts = view.left - height + step * np.arange(int((width + height) / step) + 1)
    low, high = view.top - height, view.top
    lines = shapely.linestrings([[(x, low), (x + height, high)] for x in starts])
    hatched = shapely.get_parts(shapely.intersection(lines, fixed))
    edges = shapely.get_parts(shapely.intersection(shapely.boundary(shapely.union_all(shapes)), shown))
    drawn = [
        pen.line(shapely.get_coordinates(part))
        for part in np.concatenate([hatched, edges])
        if shapely.get_type_id(part) == shapely.GeometryType.LINESTRING and not part.is_empty
    ]
    return [pen.path("".join(drawn))] if drawn else []


#: Joints by how they move, in the names of :class:`~.motion.JointMotion`: colour, width and dashes of their
#: lines in pixels, words.
KINDS = {
    "separates": (SEPARATES, 3.5, "1 6", "separating joint"),
    "slides": (SLIDES, 4.0, "", "sliding joint"),
    "crushes": (CRUSHES, 6.0, "4 3", "crushing joint"),
    "hinges": (HINGES, 9.0, "", "hinge"),
}


def joints_by_kind(result: Result) -> dict[str, np.ndarray]:
    """Which joints have the mark of each kind that occurs."""
    moves = joint_motion(result.assembly, result.solution)
    marked = {kind: getattr(moves, kind) for kind in KINDS}
    return {kind: np.flatnonzero(which) for kind, which in marked.items() if which.any()}


def draw_mechanism(result: Result, pen: Pen) -> str:
    """Marks on the joints that move, which lie midway between their blocks."""
    joints, hinge = result.assembly.joints, joint_motion(result.assembly, result.solution).hinge
    motions = joint_motions(result, pen.view)
    size = mark_size(result)
    lines, dots = pen.lines(joints.start, joints.end), pen.lines(hinge, hinge)
    drawn = []
    for kind, numbers in joints_by_kind(result).items():
        colour, width, dashes, _ = KINDS[kind]
        # A hinge is a dot, with a white rim.
        dot = kind == "hinges"
        elements = [pen.path((dots if dot else lines)[joint], motions[joint]) for joint in numbers]
        stroke = {"fill": "none", "stroke_linecap": "butt" if kind == "crushes" else "round"}
        if dot:
            drawn.append(group("rims", elements, stroke="#fff", stroke_width=width * size + 2, **stroke))
        if dashes:
            stroke["stroke_dasharray"] = dashes
        drawn.append(group(kind, elements, stroke=colour, stroke_width=f"{width * size:.2g}", **stroke))
    return group("layer mechanism", drawn)


def joint_motions(result: Result, view: View) -> np.ndarray:
    """What moves each joint, midway between its blocks, shape (c, 3)."""
    joints = result.assembly.joints
    return (view.motions[joints.first] + view.motions[joints.second]) / 2


def mark_size(result: Result) -> float:
    """How large marks on joints are: less where there are many."""
    joints = result.size.joints
    return 1.0 if joints < 300 else 0.7 if joints < 2000 else 0.35

"""A scene, its mechanism drawn displaced, and the joints that slide or hinge."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Collection
from pathlib import Path as FilePath

import matplotlib as mpl
import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path

from masonry_opt.answer.result import Result
from masonry_opt.answer.status import Status
from masonry_opt.errors import OptionError, printable
from masonry_opt.explain.sentences import numeral
from masonry_opt.files import refuse_unwritable, write_whole
from masonry_opt.report.motion import Velocities, fastest, joint_motion

#: Okabe & Ito's colours, told apart by colour-blind readers and in grey.
_SLIDES, _HINGES, _MARKED, _CRUSHES = "#0072B2", "#D55E00", "#CC79A7", "#009E73"
_BLOCK, _FIXED, _OUTLINE = "#F2E2C4", "#9A9A9A", "#BBBBBB"

#: The fastest corner moves by this share of the scene's size.
_DISPLACEMENT = 0.06

#: Inches: widest and tallest axes, room above for the title, below for axis label and legend.
_WIDTH, _TALLEST, _ABOVE, _BELOW = 6.0, 6.5, 0.7, 0.95

FORMATS = ("png", "svg", "pdf")


def plot_mechanism(result: Result, path: str | FilePath) -> None:
    """Draw a result and write it whole to ``path`` (.png, .svg or .pdf).

    Raises
    ------
    OptionError
        If the file's name has another ending.
    OSError
        If the file cannot be written.
    """
    refuse_picture(path)
    kind = FilePath(path).suffix.lower().removeprefix(".")
    with mpl.rc_context({"svg.hashsalt": "masonry_opt", "font.size": 10}):
        figure = Figure()
        axes = figure.add_subplot()
        draw_mechanism(result, axes)
        _fit_figure(figure, axes)
        figure.legend(handles=legend_handles(result), loc="lower center", ncols=4, frameon=False)
        image = io.BytesIO()
        figure.savefig(image, format=kind, dpi=160, bbox_inches="tight")
    write_whole(path, image.getvalue())


def _fit_figure(figure: Figure, axes: Axes) -> None:
    """Size the figure so that the scene fills the axes in its own proportions, legend below."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    tall = min(_WIDTH * (top - bottom) / (right - left), _TALLEST)
    wide = tall * (right - left) / (top - bottom)
    width, height = _WIDTH + 1.0, tall + _ABOVE + _BELOW
    figure.set_size_inches(width, height)
    axes.set_position(((width - wide) / 2 / width, _BELOW / height, wide / width, tall / height))


def refuse_picture(path: str | FilePath) -> None:
    """Raise OptionError if a picture could not be written there: to be asked before long work."""
    path = FilePath(path)
    if path.suffix.lower().removeprefix(".") not in FORMATS:
        raise OptionError(f"{path}: a picture's name ends in {', '.join('.' + f for f in FORMATS)}")
    refuse_unwritable(path)


def draw_mechanism(result: Result, axes: Axes, marked: Collection[int] = ()) -> None:
    """Draw a result on given axes: displaced blocks, marked joints, the load factor as title.

    Joints ``marked``, by their numbers in ``result.joints``, stand out.
    """
    assembly = result.assembly
    shapes, origin = assembly.geometry, assembly.geometry.origin
    fixed = np.setdiff1d(np.arange(len(shapes.polygons)), assembly.movable)
    low, high = _extent(result)
    size = float((high - low).max())

    motion = Velocities(result)

    def drawn(blocks: np.ndarray, scale: float = 0.0) -> list[Path]:
        return [_outline(shapes.polygons[i], i, motion, scale, origin) for i in blocks]

    axes.add_collection(PathCollection(drawn(fixed), facecolor=_FIXED, edgecolor="none"))
    moves, scale = result.blocks["vx"].notna().all(), 0.0
    if moves:
        rest = drawn(assembly.movable)
        axes.add_collection(PathCollection(rest, facecolor="none", edgecolor=_OUTLINE, linewidth=0.5))
        scale = _DISPLACEMENT * size / fastest(result)
    blocks = drawn(assembly.movable, scale)
    width = 0.8 if len(blocks) < 300 else 0.3
    axes.add_collection(PathCollection(blocks, facecolor=_BLOCK, edgecolor="black", linewidth=width))
    if moves:
        _mark_joints(result, axes, scale, marked)

    margin = 1.5 * _DISPLACEMENT * size
    axes.set_xlim(low[0] + origin[0] - margin, high[0] + origin[0] + margin)
    axes.set_ylim(low[1] + origin[1] - margin, high[1] + origin[1] + margin)
    axes.set_aspect("equal")
    axes.set_xlabel("x, y in the length unit of the case")
    axes.set_ylabel("y")
    axes.set_title(_title(result), parse_math=False)  # a title may hold dollar signs


def _outline(
    shape: shapely.Geometry, block: int, motion: Velocities, scale: float, origin: np.ndarray
) -> Path:
    """The outlines of a moved block, its holes among them, as one path."""
    rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(shape))]
    moved = [points + scale * motion.at(block, points) + origin for points in rings]
    return Path.make_compound_path(*(Path(points, closed=True) for points in moved))


def _title(result: Result) -> str:
    name = printable(textwrap.fill(result.assembly.scene.title or FilePath(result.case).stem, 60))
    if result.load_factor is not None:
        return f"{name}\nload factor λ = {numeral(result.load_factor, '.5f')} ({result.method})"
    drawn = "" if result.status is Status.UNSTABLE else "; drawn: the last motion tried, no collapse"
    return f"{name}\nno load factor ({result.status}){drawn if result.solution.d is not None else ''}"


def _mark_joints(result: Result, axes: Axes, scale: float, marked: Collection[int]) -> None:
    joints, origin = result.assembly.joints, result.assembly.geometry.origin
    joint_moves, motion = joint_motion(result), Velocities(result)

    def displaced(joint: int, point: np.ndarray) -> np.ndarray:
        """Where a point of a joint is drawn: midway between its two blocks."""
        blocks = (joints.first[joint], joints.second[joint])
        velocity = sum(motion.at(block, point[None])[0] for block in blocks) / 2
        return point + scale * velocity + origin

    crushing = np.flatnonzero(joint_moves.crushes).tolist()
    sliding = sorted({*np.flatnonzero(joint_moves.slides).tolist(), *marked, *crushing})
    hinging = np.flatnonzero(joint_moves.hinges).tolist()
    slid = [[displaced(j, joints.start[j]), displaced(j, joints.end[j])] for j in sliding]
    colours = [_MARKED if j in marked else _CRUSHES if j in crushing else _SLIDES for j in sliding]
    widths = [4.0 if j in marked else 2.2 for j in sliding]
    axes.add_collection(LineCollection(slid, color=colours, linewidth=widths, capstyle="round", zorder=3))
    if hinging:
        x, y = np.array([displaced(j, joint_moves.hinge[j]) for j in hinging]).T
        size = 22 if len(joints.first) < 1000 else 8
        axes.scatter(x, y, s=size, color=_HINGES, edgecolor="white", linewidth=0.4, zorder=4)


def legend_handles(result: Result, marked: str = "") -> list[Line2D | Patch]:
    """What a legend shows of a drawn result; ``marked`` says what its marked joints are."""
    handles: list[Line2D | Patch] = [
        Patch(facecolor=_BLOCK, edgecolor="black", label="block"),
        Patch(facecolor=_FIXED, label="fixed"),
    ]
    if result.blocks["vx"].notna().all():
        motion = joint_motion(result)
        if motion.slides.any():
            handles.append(Line2D([], [], color=_SLIDES, linewidth=2.2, label="sliding joint"))
        if marked:
            handles.append(Line2D([], [], color=_MARKED, linewidth=4.0, label=marked))
        if motion.crushes.any():
            handles.append(Line2D([], [], color=_CRUSHES, linewidth=2.2, label="crushing joint"))
        if motion.hinges.any():
            handles.append(Line2D([], [], color=_HINGES, linestyle="none", marker="o", label="hinging joint"))
    return handles


def _extent(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right of the movable blocks, relative to the geometry's origin."""
    assembly = result.assembly
    corners = shapely.get_coordinates(assembly.geometry.polygons[assembly.movable])
    return corners.min(axis=0), corners.max(axis=0)

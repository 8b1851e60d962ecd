"""A picture of a scene before it is solved: what was found in it, and what looks unintended."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from masonry_opt.errors import CaseError, counted
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.report.colours import HINGES, MARKED, SLIDES
from masonry_opt.report.pictures.arrows import draw_loads
from masonry_opt.report.pictures.blocks import Handle, at_rest, draw_blocks, draw_names, frame, set_title
from masonry_opt.report.pictures.figure import Legend, Picture, finish, fit, refuse_picture, style
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.contact import refuse_floating
from masonry_opt.scene.scene import Scene
from masonry_opt.words.sense import warnings_of
from masonry_opt.words.sentences import sentences

#: Of small gaps.
_DASHES = (0, (1.6, 1.1))


def draw(
    scene: Scene | str | Path, path: str | Path | None = None, names: bool = False, force: bool = False
) -> Picture:
    """Draw a scene before it is solved, as a matplotlib figure without pyplot's state; a notebook shows it.

    Blocks, supports, loads, and the joints found; where blocks nearly touch, or meet corner on corner, which
    is no joint; below them what looks unintended. Nothing is solved, and the scene need not stand.

    Parameters
    ----------
    scene: a scene, or the path of a case file.
    path: file to write the picture to, whole or not at all (.png, .svg or .pdf).
    names: whether to write each block's name into it.
    force: whether to replace a file that was not written here.

    Raises
    ------
    CaseError
        If the case file or scene is wrong. Blocks that touch nothing are drawn all the same.
    OptionError
        If the file's name has another ending, its folder takes none, or it would replace a file that was
        not written here.
    OSError
        If the file cannot be written.
    """
    if path is not None:
        refuse_picture(path, force)
    made = scene_picture(assemble(as_scene(scene), floating=True), names)
    if path is not None:
        made.save(path, force)
    return made


def scene_picture(assembly: Assembly, names: bool = False) -> Picture:
    """Draw what was assembled of a scene; see :func:`draw`."""
    with style():
        made = Picture()
        axes = made.add_subplot()
        frame(axes, assembly)
        fit(made, axes)
        notes = tuple(f"warning: {sentence}" for sentence in doubts(assembly))
        finish(made, axes, Legend(_draw(axes, assembly, names), notes=notes))
    return made


def counts(assembly: Assembly) -> str:
    """Numbers of blocks, supports, joints, and pairs of blocks with a small gap between, in words."""
    movable = len(assembly.movable)
    numbers = {
        "block": movable,
        "support": len(assembly.scene.blocks) - movable,
        "joint": len(assembly.joints.length),
        "small gap": len(assembly.joints.near_misses),
    }
    told = [(noun, number) for noun, number in numbers.items() if number or noun == "joint"]
    return ", ".join(counted(number, noun) for noun, number in told)


def near_misses(assembly: Assembly) -> list[np.ndarray]:
    """The lengths of edge, in the case's coordinates, along which blocks face each other across a small gap;
    shape (points, 2) each."""
    shapes, found = assembly.geometry, []
    for pair, gap in zip(assembly.joints.near_misses, assembly.joints.gaps, strict=True):
        one, other = shapes.polygons[list(pair)]
        # A little more than the largest width, which keeps their ends.
        reach = 1.01 * gap
        facing = shapely.intersection(shapely.boundary(one), shapely.buffer(other, reach))
        lines = shapely.get_parts(shapely.line_merge(facing))
        # Without stubs round corners.
        lines = shapely.simplify(lines[shapely.length(lines) > 2 * reach], 2 * reach)
        found += [shapely.get_coordinates(line) + shapes.origin for line in lines]
    return found


def meeting_corners(assembly: Assembly) -> np.ndarray:
    """Where blocks meet corner on corner, off the joints of the two, in the case's coordinates, shape
    (points, 2)."""
    shapes, joints = assembly.geometry, assembly.joints
    found = [np.empty((0, 2))]
    for first, second in joints.corners:
        one, other = (np.unique(shapely.get_coordinates(shapes.polygons[i]), axis=0) for i in (first, second))
        apart = np.hypot(*(one[:, None] - other[None]).transpose(2, 0, 1))
        own = (joints.first == first) & (joints.second == second)
        shared = shapely.multilinestrings(np.stack([joints.start[own], joints.end[own]], axis=1))
        points = one[(apart <= 2 * shapes.tolerance).any(axis=1)]
        # The distance to no line at all is NaN.
        off = ~(shapely.distance(shared, shapely.points(points)) <= 2 * shapes.tolerance)
        found.append(points[off] + shapes.origin)
    return np.concatenate(found)


def _draw(axes: Axes, assembly: Assembly, names: bool) -> list[Handle]:
    place, joints = at_rest(assembly), assembly.joints
    handles = draw_blocks(axes, assembly, place)
    width, size = (2.0, 6) if len(joints.length) < 1000 else (1.0, 3)
    ends = np.stack([joints.start, joints.end], axis=1) + assembly.geometry.origin
    in_point = joints.length == 0
    if (~in_point).any():
        axes.add_collection(LineCollection(list(ends[~in_point]), color=SLIDES, linewidth=width, zorder=3))
        handles.append(Line2D([], [], color=SLIDES, linewidth=width, label="joint"))
    for points, colour, marker, label in (
        (ends[in_point, 0], SLIDES, "s", "joint of a corner on an edge"),
        (meeting_corners(assembly), MARKED, "X", "corner on corner: no joint"),
    ):
        if len(points):
            x, y = points.T
            handles += axes.plot(x, y, marker, color=colour, markersize=size, label=label, zorder=4)
    if gaps := near_misses(assembly):
        axes.add_collection(LineCollection(gaps, color=HINGES, linewidth=2.6, linestyle=_DASHES, zorder=4))
        label = "small gap: no joint"
        handles.append(Line2D([], [], color=HINGES, linewidth=2.6, linestyle=_DASHES, label=label))
    handles += draw_loads(axes, assembly, place)
    if names:
        draw_names(axes, assembly, place)
    set_title(axes, assembly.scene, counts(assembly))
    return handles


def doubts(assembly: Assembly) -> Iterator[str]:
    """What a scene is refused for that can be drawn all the same, and what looks unintended in it."""
    try:
        joints = assembly.joints
        gaps = dict(zip(joints.near_misses, joints.gaps, strict=True))
        refuse_floating(assembly.scene, assembly.geometry, joints.first, joints.second, gaps)
    except CaseError as error:
        yield str(error)
    yield from sentences(warnings_of(assembly, None))

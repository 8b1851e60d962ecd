"""A mechanism drawn displaced, and the joints that slide, hinge, separate or crush."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from masonry_opt.answer.motion import JointMotion, joint_motion
from masonry_opt.answer.result import Result
from masonry_opt.report.colours import CRUSHES, HINGES, SEPARATES, SLIDES
from masonry_opt.report.motion import Velocities, fastest, has_mechanism
from masonry_opt.report.pictures.arrows import draw_loads
from masonry_opt.report.pictures.blocks import (
    Handle,
    Place,
    at_rest,
    block_handles,
    draw_at_rest,
    draw_blocks,
    draw_names,
    frame,
    size_of,
    title_result,
)
from masonry_opt.report.pictures.figure import Legend

#: The fastest corner moves by this share of the scene's size.
_DISPLACEMENT = 0.06

#: Dashes of joints that separate.
_DASHES = (0, (1.6, 1.1))


def draw_kind(result: Result, axes: Axes, names: bool) -> Legend:
    """Draw a mechanism with its loads, and say what a legend shows of it."""
    draw_mechanism(result, axes)
    place = _displaced(result)
    handles = legend_handles(result)
    handles += draw_loads(axes, result.assembly, place, live=result.status.live_load_acts)
    if names:
        draw_names(axes, result.assembly, place)
    return Legend(handles)


def draw_mechanism(result: Result, axes: Axes) -> None:
    """Draw a result on given axes: displaced blocks, joints by how they move, the load factor as title."""
    frame(axes, result.assembly)
    if has_mechanism(result):
        draw_at_rest(axes, result.assembly)
    draw_blocks(axes, result.assembly, _displaced(result))
    if has_mechanism(result):
        _mark_joints(result, axes)
    title_result(axes, result)


def legend_handles(result: Result) -> list[Handle]:
    """What a legend shows of a drawn result."""
    handles = block_handles()
    if not has_mechanism(result):
        return handles
    motion = joint_motion(result.assembly, result.solution)
    if motion.slides.any():
        handles.append(Line2D([], [], color=SLIDES, linewidth=2.2, label="sliding joint"))
    if motion.separates.any():
        handles.append(
            Line2D([], [], color=SEPARATES, linewidth=2.2, linestyle=_DASHES, label="separating joint")
        )
    if motion.crushes.any():
        handles.append(
            Line2D([], [], color=CRUSHES, linewidth=2.2, marker="x", markersize=6, label="crushing joint")
        )
    if motion.hinges.any():
        handles.append(Line2D([], [], color=HINGES, linestyle="none", marker="o", label="hinging joint"))
    return handles


def _displaced(result: Result) -> Place:
    """Blocks moved by the mechanism, magnified."""
    if not has_mechanism(result):
        return at_rest(result.assembly)
    motion, origin = Velocities(result), result.assembly.geometry.origin
    scale = _DISPLACEMENT * size_of(result.assembly) / fastest(result)
    return lambda block, points: points + scale * motion.at(block, points) + origin


def _mark_joints(result: Result, axes: Axes) -> None:
    joints, place, motion = (
        result.assembly.joints,
        _displaced(result),
        joint_motion(result.assembly, result.solution),
    )

    def midway(joint: int, point: np.ndarray) -> np.ndarray:
        """Where a point of a joint is drawn: midway between its two blocks."""
        blocks = (joints.first[joint], joints.second[joint])
        return np.mean([place(block, point[None])[0] for block in blocks], axis=0)

    few = len(joints.first) < 1000
    for colour, which in _kinds(motion).items():
        numbers = np.flatnonzero(which).tolist()
        ends = [[midway(j, joints.start[j]), midway(j, joints.end[j])] for j in numbers]
        style = _DASHES if colour == SEPARATES else "solid"
        lines = LineCollection(ends, color=colour, linewidth=2.2, zorder=3)
        lines.set(linestyle=style, capstyle="butt" if colour == SEPARATES else "round")
        axes.add_collection(lines)
        # A corner on an edge has no line, and colour alone is not told apart in grey.
        in_points = [end[0] for j, end in zip(numbers, ends, strict=True) if joints.length[j] == 0]
        crossed = [np.mean(end, axis=0) for end in ends] if colour == CRUSHES else []
        if in_points:
            x, y = np.array(in_points).T
            axes.scatter(x, y, s=26 if few else 8, color=colour, marker="s", zorder=3)
        if crossed:
            x, y = np.array(crossed).T
            axes.scatter(x, y, s=36 if few else 12, color=colour, marker="x", zorder=3)
    hinging = np.flatnonzero(motion.hinges).tolist()
    if hinging:
        x, y = np.array([midway(j, motion.hinge[j]) for j in hinging]).T
        axes.scatter(x, y, s=22 if few else 8, color=HINGES, edgecolor="white", linewidth=0.4, zorder=4)


def _kinds(motion: JointMotion) -> dict[str, np.ndarray]:
    """Which joints have a line of each colour."""
    return {
        SEPARATES: motion.separates,
        SLIDES: motion.slides,
        CRUSHES: motion.crushes,
    }

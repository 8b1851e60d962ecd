"""What joints carry: resultants where they act, and the line of thrust through arches and columns."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from masonry_opt.answer.result import Result
from masonry_opt.problem.assembly import Assembly
from masonry_opt.report.colours import THRUST
from masonry_opt.report.pictures.blocks import (
    MARGIN,
    Handle,
    at_rest,
    draw_blocks,
    draw_names,
    extent,
    frame,
    say_no_forces,
    size_of,
    title_result,
)
from masonry_opt.report.pictures.figure import Legend
from masonry_opt.report.thrust import Thrust, chains, thrust

#: The longest resultant over the scene's size.
_LONGEST = 0.12


def draw_kind(result: Result, axes: Axes, names: bool) -> Legend:
    """Draw a result's blocks at rest and its resultants, and say what a legend shows of them.

    A result without forces is drawn without, and says so.
    """
    assembly, place = result.assembly, at_rest(result.assembly)
    frame(axes, assembly)
    handles = draw_blocks(axes, assembly, place)
    title_result(axes, result)
    handles += _draw_thrust(axes, assembly, thrust(result))
    if names:
        draw_names(axes, assembly, place)
    return Legend(handles)


def _draw_thrust(axes: Axes, assembly: Assembly, carried: Thrust) -> list[Handle]:
    acts = np.isfinite(carried.point[:, 0])
    if not acts.any():
        say_no_forces(axes)
        return []
    joints = assembly.joints
    handles: list[Handle] = []
    lines = chains(assembly, acts)
    polygon = [carried.point[pair] for pair in lines]
    axes.add_collection(LineCollection(polygon, color=THRUST, linewidth=1.8, capstyle="round", zorder=3))
    on_line = np.isin(np.arange(len(joints.first)), lines)
    if len(lines):
        x, y = carried.point[on_line].T
        axes.scatter(x, y, s=9, color=THRUST, zorder=4)
        handles.append(
            Line2D([], [], color=THRUST, linewidth=1.8, marker="o", markersize=3, label="line of thrust")
        )
    # On a line the resultants of its ends, on supports, say how large they are.
    on_support = ~(np.isin(joints.first, assembly.movable) & np.isin(joints.second, assembly.movable))
    shown = acts & (~on_line | on_support)
    if shown.any():
        half = _scale(assembly, carried) * carried.force[shown] / 2
        point = carried.point[shown]
        segments = np.stack([point - half, point + half], axis=1)
        width = float(np.clip(25 / np.sqrt(len(segments)), 0.6, 1.6))
        axes.add_collection(LineCollection(list(segments), color=THRUST, linewidth=width, zorder=4))
        if len(segments) < 1000:
            axes.scatter(point[:, 0], point[:, 1], s=(1.8 * width) ** 2, color=THRUST, linewidth=0, zorder=4)
        _draw_scale(axes, assembly, carried)
        who = "on a support" if len(lines) and on_support[shown].all() else "of a joint"
        label = f"resultant {who}, in the case's unit of force"
        handles.append(Line2D([], [], color=THRUST, linewidth=1.6, label=label))
    return handles


def _scale(assembly: Assembly, carried: Thrust) -> float:
    """Length in the picture of a unit of force."""
    return _LONGEST * size_of(assembly) / float(np.hypot(*carried.force.T).max())


def _draw_scale(axes: Axes, assembly: Assembly, carried: Thrust) -> None:
    """A round force to scale, in a strip of its own above the scene."""
    (left, _), (_, high) = extent(assembly)
    size, unit = size_of(assembly), _scale(assembly, carried)
    most = float(np.hypot(*carried.force.T).max())
    power = 10.0 ** np.floor(np.log10(most))
    force = max(digit * power for digit in (1, 2, 5) if digit * power <= most)
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.5 * MARGIN * size)
    y = high + MARGIN * size
    ends = np.array([[left, y], [left + force * unit, y]])
    # Beside a slender scene there is less room than it and its label take; outside no label is drawn.
    _, right = axes.get_xlim()
    axes.set_xlim(right=max(right, ends[1, 0] + 1.5 * MARGIN * size))
    axes.plot(*ends.T, color=THRUST, linewidth=1.6, marker="|", markersize=6, zorder=8)
    axes.annotate(
        f"= {force:g}",
        ends[1],
        xytext=(6, 0),
        textcoords="offset points",
        va="center",
        zorder=8,
    )

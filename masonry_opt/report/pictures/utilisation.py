"""How much of what each joint can carry it does carry."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D

from masonry_opt.answer.result import Result
from masonry_opt.report.colours import IDLE
from masonry_opt.report.pictures.blocks import (
    Handle,
    at_rest,
    draw_blocks,
    draw_names,
    frame,
    say_no_forces,
    title_result,
)
from masonry_opt.report.pictures.figure import Legend

#: From yellow to dark blue, told apart by colour-blind readers and in grey.
_COLOURS = "viridis_r"

_LABEL = "utilisation of joints (1: about to slide, hinge or crush)"


def draw_kind(result: Result, axes: Axes, names: bool) -> Legend:
    """Draw a result's blocks at rest and its joints in the colours of their utilisation, and say what a
    legend shows of them.

    A result without forces is drawn without, and says so.
    """
    assembly, place = result.assembly, at_rest(result.assembly)
    frame(axes, assembly)
    handles = draw_blocks(axes, assembly, place)
    title_result(axes, result)
    used = result.joints["utilisation"].to_numpy()
    idle = np.isnan(used)
    colours = None
    if idle.all():
        say_no_forces(axes)
    else:
        colours = ScalarMappable(Normalize(0, 1), colormaps[_COLOURS])
        handles += _draw_joints(axes, result, np.clip(used, 0, 1), colours)
    if names:
        draw_names(axes, assembly, place)
    return Legend(handles, colours, _LABEL)


def _draw_joints(axes: Axes, result: Result, used: np.ndarray, colours: ScalarMappable) -> list[Handle]:
    idle = np.isnan(used)
    joints, origin = result.assembly.joints, result.assembly.geometry.origin
    lines = np.stack([joints.start, joints.end], axis=1) + origin
    few = len(used) < 1000
    axes.add_collection(LineCollection(list(lines[idle]), color=IDLE, linewidth=1.6, zorder=3))
    order = np.flatnonzero(~idle)[np.argsort(used[~idle], kind="stable")]  # the most used on top
    # Wider too, for readers of grey prints.
    width = (2.0 + 1.6 * used[order]) * (1.0 if few else 0.6)
    axes.add_collection(
        LineCollection(list(lines[order]), color=colours.to_rgba(used[order]), linewidth=width, zorder=4)
    )
    points = order[joints.length[order] == 0]
    if len(points):
        at = joints.start[points] + origin
        axes.scatter(at[:, 0], at[:, 1], s=26, color=colours.to_rgba(used[points]), marker="s", zorder=4)
    if idle.any():
        return [Line2D([], [], color=IDLE, linewidth=1.6, label="idle joint")]
    return []

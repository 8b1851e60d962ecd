"""Pictures of a capacity curve: the curve itself, and the displaced blocks in one of its states."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_opt.drawing.colours import AT_REST, BLACK, HATCH, HINGING_COLOUR, JOINT, SEPARATING_COLOUR
from masonry_opt.drawing.elements import Elements
from masonry_opt.drawing.marks import Marks
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.displaced import displaced, placed
from masonry_opt.reporting.load_factors import named_factor
from masonry_opt.reporting.sentences import numeral
from masonry_opt.result import Result
from masonry_opt.solution.reasons import Code

if TYPE_CHECKING:
    import pandas as pd

    from masonry_opt.drawing.figure import Handle, Picture

#: Events that are marked in a plot of the capacity curve: legend entry, colour and marker of each event.
_MARKED_EVENTS = {
    Code.JOINT_OPENS: ("a joint opens", HINGING_COLOUR, "o"),
    Code.JOINT_CLOSES: ("a joint closes", JOINT, "s"),
}


def curve_picture(result: Result, table: "pd.DataFrame", mover: str, message: str) -> "Picture":
    """Plot λ over the displacement of the control point.

    Parameters
    ----------
    result: Result at the onset of collapse.
    table: States of the curve.
    mover: Name of the control point, such as "the live load".
    message: Reason why the curve ends.
    """
    # matplotlib is imported only for a plot, because its import takes longer than the computation of most
    # curves.
    from masonry_opt.drawing.figure import curve_axes, finish, style

    heading = f"after the onset at {named_factor(result)}"
    with style():
        scene = result.assembly.scene
        picture, axes = curve_axes(scene, heading, f"displacement of {mover}, in the length unit of the case")
        drawn = axes.plot(table["displacement"], table["load_factor"], color=BLACK, zorder=3)
        axes.axhline(0.0, color=HATCH, linewidth=0.6)
        axes.set_ylim(bottom=min(0.0, -0.02 * result.required()))
        handles: list[Handle] = []
        if len(table) == 1:  # a line of a single point would be invisible
            drawn[0].set(marker="o", linestyle="none", label="onset of collapse, without a curve")
            handles += drawn
        for code, (label, colour, marker) in _MARKED_EVENTS.items():
            rows = table[table["event"] == str(code)]
            if len(rows):
                x, y = rows["displacement"], rows["load_factor"]
                handles += axes.plot(x, y, marker, color=colour, label=label, zorder=4)
        finish(picture, axes, handles, (message,))
    return picture


def displaced_picture(
    assembly: Assembly, state: "pd.Series[Any]", joints: "pd.DataFrame", poses: np.ndarray
) -> "Picture":
    """Plot the displaced blocks to scale, in one state of a capacity curve.

    Parameters
    ----------
    assembly: Scene at rest.
    state: Row of the table of the capacity curve.
    joints: Table of the joints in this state.
    poses: Poses of all blocks in this state.
    """
    from masonry_opt.drawing.pictures import elements_picture

    plane, marks = assembly.scene.dimension == 2, list[Marks]()
    displaced_assembly = replace(assembly, geometry=displaced(assembly.geometry, poses))
    if plane:
        *ends, owner = assembly.geometry.edges
        sides = np.stack(ends, axis=1)[np.isin(owner, assembly.movable)]
        marks.append(Marks("rest", "at rest", "line", AT_REST, 0.5, sides))
    hinged = joints["state"] == "hinged"
    if hinged.any():
        place = joints.loc[hinged].filter(list("xyz")).to_numpy() - assembly.geometry.origin
        marks.append(Marks("hinges", "hinging joint", "dot", HINGING_COLOUR, 5.2, place[:, None]))
    separated = (joints["state"] == "separated").to_numpy()
    if plane and separated.any():
        ends = np.stack([assembly.joints.start, assembly.joints.end], axis=1)[separated]
        blocks = assembly.joints.first[separated], assembly.joints.second[separated]
        sides = np.concatenate([placed(ends, poses[block][:, None]) for block in blocks])
        marks.append(Marks("separates", "separated joint", "line", SEPARATING_COLOUR, 1.6, sides))
    at = numeral(state["displacement"], ".4g")
    heading = f"blocks to scale at λ = {numeral(state['load_factor'], '.6g')} and a displacement of {at}"
    return elements_picture(Elements(displaced_assembly, heading, "", 0 * poses, [], {"mechanism": marks}))

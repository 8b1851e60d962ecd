"""Pictures of a capacity curve, and of the blocks displaced."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.answer.reasons import Code
from masonry_opt.drawing.colours import AT_REST, BLACK, HATCH, HINGES, JOINT, SEPARATES
from masonry_opt.drawing.curve import curve_axes
from masonry_opt.drawing.elements import Elements
from masonry_opt.drawing.figure import Handle, Picture, finish, style
from masonry_opt.drawing.marks import Marks
from masonry_opt.drawing.pictures import elements_picture
from masonry_opt.finite_motion.moved_blocks import displaced, placed
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.scene import Scene
from masonry_opt.words.sentences import numeral

#: Events by code: what a legend says, colour and marker.
_EVENTS = {
    Code.JOINT_OPENS: ("a joint opens", HINGES, "o"),
    Code.JOINT_CLOSES: ("a joint closes", JOINT, "s"),
}


def capacity_picture(scene: Scene, table: pd.DataFrame, of: str, note: str) -> Picture:
    """Draw λ over displacement: rows of a capacity curve, whose displacement it is, and why it ends."""
    onset = float(table["load_factor"].iloc[0])
    heading, along = f"after the onset at λ = {numeral(onset, '.5f')}", f"displacement of {of}"
    with style():
        made, axes = curve_axes(scene, heading, f"{along}, in the length unit of the case")
        marker = "o" if len(table) == 1 else ""  # a line through one state is nothing to see
        axes.plot(table["displacement"], table["load_factor"], color=BLACK, marker=marker, zorder=3)
        axes.axhline(0.0, color=HATCH, linewidth=0.6)
        axes.set_ylim(bottom=min(0.0, -0.02 * onset))
        handles: list[Handle] = []
        for code, (label, colour, marker) in _EVENTS.items():
            rows = table[table["event"] == str(code)]
            look: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": "none"}
            if len(rows):
                handles += axes.plot(rows["displacement"], rows["load_factor"], zorder=4, label=label, **look)
        finish(made, axes, handles, (note,))
    return made


def displaced_picture(
    assembly: Assembly, state: "pd.Series[Any]", poses: np.ndarray, joints: pd.DataFrame
) -> Picture:
    """Draw the blocks where they are in a row of a capacity curve, to scale, with the hinges: poses of all
    blocks, shape (blocks, 3) or (blocks, 6), and the table of joints there."""
    geometry, marks, dimension = assembly.geometry, [], assembly.scene.dimension
    there = replace(assembly, geometry=displaced(geometry, poses))
    if dimension == 2:
        *ends, owner = geometry.edges
        sides = np.stack(ends, axis=1)[np.isin(owner, assembly.movable)]
        marks.append(Marks("rest", "at rest", "line", AT_REST, 0.5, sides))
    if (hinged := joints["state"] == "hinged").any():
        at = joints.loc[hinged, ["x", "y", "z"][:dimension]].to_numpy() - geometry.origin
        marks.append(Marks("hinges", "hinging joint", "dot", HINGES, 5.2, at[:, None]))
    if dimension == 2 and (apart := (joints["state"] == "separated").to_numpy()).any():
        ends = np.stack([assembly.joints.start, assembly.joints.end], axis=1)[apart]
        blocks = assembly.joints.first[apart], assembly.joints.second[apart]
        sides = np.concatenate([placed(ends, poses[own][:, None]) for own in blocks])
        marks.append(Marks("separates", "separated joint", "line", SEPARATES, 1.6, sides))
    load_factor, displacement = numeral(state["load_factor"], ".5f"), numeral(state["displacement"], ".4g")
    heading = f"λ = {load_factor} at a displacement of {displacement}, to scale"
    return elements_picture(Elements(there, heading, "", 0 * poses, [], {"mechanism": marks}))

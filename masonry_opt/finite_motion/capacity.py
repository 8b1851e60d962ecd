"""``capacity``: λ over displacement after the onset of collapse, and what codes check with it."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from masonry_opt.answer.reasons import Code, Reason
from masonry_opt.drawing.colours import AT_REST, BLACK, HATCH, HINGES, JOINT, SEPARATES
from masonry_opt.drawing.elements import Elements
from masonry_opt.drawing.marks import Marks
from masonry_opt.drawing.marks import moved as carried
from masonry_opt.errors import NoLoadFactorError, OptionError, printable
from masonry_opt.finite_motion.edge import EdgePath
from masonry_opt.finite_motion.kinematic_check import KinematicCheck, kinematic_check
from masonry_opt.finite_motion.moved_blocks import displaced, moved, placed, point_forces
from masonry_opt.finite_motion.path import HingingPath, Step
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.loads import Forces
from masonry_opt.result import Result
from masonry_opt.scene.rows import dots, lengths, sums
from masonry_opt.scene.solids import COORDINATES, coordinates
from masonry_opt.words.load_factors import certainty, named_factor, own_name
from masonry_opt.words.names import labelled, some, warning_lines
from masonry_opt.words.sentences import message, numeral

if TYPE_CHECKING:
    from masonry_opt.drawing.figure import Handle, Picture

_WHOLE, _LEVEL = 1e-2, 1e-6  #: Shares by which a check's live load may be off the weights, and off level.
_STILL = 1e-6  #: Share of the greatest rate below which a control point does not move along the live load.
#: Events that a picture marks, by code: what its legend says, colour and marker.
_SEEN = {Code.JOINT_OPENS: ("a joint opens", HINGES, "o"), Code.JOINT_CLOSES: ("a joint closes", JOINT, "s")}


def capacity(
    result: Result, *, block: str | None = None, point: tuple[float, ...] | None = None, steps: int = 40
) -> "Capacity":
    """Follow the mechanism of a result by finite rotations, down to λ = 0.

    Joints stay closed, hinge in a corner, open wholly or close again; λ is that of equilibrium of the
    displaced blocks, and at each state forces within the yield conditions are shown to exist. Loads keep
    their direction, and the points of blocks where they act. Where joints slide, or blocks meet, the curve
    stops. In space it is of one body that turns about an edge of what stays, with ties and props, which lead
    from end to end wherever these are; where another joint opens it stops.

    Raises OptionError of joints of limited strength, in the plane of ties and props, of loads whose points
    are not known; in space of joints that slide, and of blocks that move on each other or about a point; if
    the control point is wrong or does not move along the live load; NoLoadFactorError without a load factor.

    Parameters
    ----------
    result: Of :func:`~masonry_opt.analysis.solve`, by any method.
    block, point: Control point: a block's centroid, or a point ``(x, y)``, in space ``(x, y, z)``, of it at
        rest; its displacement along the resultant of the live load is told. Default: the mean displacement of
        the live loads, each along itself.
    steps: States between the onset and λ = 0, were the way straight: more where λ falls slower than at first.
    """
    if not isinstance(result, Result):
        raise OptionError("the capacity curve is of a result: give mo.capacity(mo.solve(scene))")
    result.required()
    assembly, dimension = result.assembly, result.assembly.scene.dimension
    if unknown := _not_followed(assembly):
        known = "the capacity curve follows joints that hinge, open and close, and nothing else"
        remedy = f"leave out {' and '.join(unknown)}, or find the load factor alone with 'solve'"
        raise OptionError(f"{result.case}: {known}: {remedy}")
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 2:
        raise OptionError(f"steps must be a number of states, 2 or more (found {steps!r})")
    dead, live = point_forces(assembly)
    control = _control(result, live, block, point)
    path = (HingingPath if dimension == 2 else EdgePath)(result, (dead, live), steps)
    found = Capacity(result, path.end, tuple(path.steps), path.motion, dead, live, control)
    _, rates, control_rate = found._onset
    if path.motion.any() and abs(control_rate) <= _STILL * rates.max():
        raise OptionError(f"block '{block}' does not move along the live load: name another block or point")
    return found


#: What is left out of a scene for its capacity curve, by the role of its limited forces.
_LEFT_OUT = {
    Role.TIE: "[[tie]]",
    Role.PROP: "[[prop]]",
    Role.EARTH: "[[fill]]",
    Role.SUPPORT: "the support that settles",
}


def _not_followed(assembly: Assembly) -> list[str]:
    """Return what a capacity curve does not follow in a scene; in space it follows ties and props."""
    roles = dict.fromkeys(force.role for force in assembly.limited)
    if assembly.scene.dimension == 3:
        roles = {role: None for role in roles if role not in (Role.TIE, Role.PROP)}
    crushing = ["'strength' of joints"] if len(assembly.problem.crushing) else []
    return [*(_LEFT_OUT[role] for role in roles), *crushing]


def _control(result: Result, live: Forces, block: str | None, point: tuple[float, ...] | None) -> Forces:
    """Forces whose mean displacement along themselves is told."""
    if block is None:
        if point is not None:
            raise OptionError("the control point belongs to a block: give 'block' (--block) too")
        return live
    assembly, names = result.assembly, result.assembly.names(result.assembly.movable)
    if block not in names:
        none = f"there is no movable block '{block}': choose from {some(names)}"
        raise OptionError(f"{result.case}: block: {none}")
    row, along = names.index(block), live.force.sum(axis=0)
    if not np.linalg.norm(along) > _STILL * lengths(live.force).sum():
        raise OptionError("the live load has no resultant to measure along: leave 'block' out")
    at = assembly.geometry.centroid[assembly.movable[row]]
    if point is not None:
        given = coordinates(point, len(at))
        if given is None:
            raise OptionError(f"the control point needs {COORDINATES[len(at)]} (found {point!r})")
        at = given - assembly.geometry.origin
    return Forces(np.array([row]), along[None], at[None], np.zeros(0))


@dataclass(frozen=True, eq=False)
class Capacity:
    """λ over displacement after the onset.

    Attributes
    ----------
    result: the onset.
    end: why the curve ends: the code "reaches zero" if at λ = 0.
    table: a row a state, the first at rest: ``displacement`` of the control point, ``rotation`` (of the
        block that turns most, rad), ``load_factor``, ``dead_work`` and ``live_work`` (that of the live load
        for λ = 1) done from rest, how many joints are ``hinged`` and ``separated``, and the ``event``, a
        code, with the ``pairs`` of blocks of the joints concerned. Displacement may go back where joints
        close and open: such states are in equilibrium, but a real fall passes by them.
    steps: the states, with the poses of all blocks.
    """

    result: Result
    end: Reason
    steps: tuple[Step, ...] = field(repr=False)
    motion: np.ndarray = field(repr=False)
    dead: Forces = field(repr=False)
    live: Forces = field(repr=False)
    control: Forces = field(repr=False)

    @property
    def load_factor(self) -> float:
        """λ at the onset."""
        return self.result.required()

    @property
    def reaches_zero(self) -> bool:
        """Whether the curve comes down to λ = 0."""
        return self.end.code is Code.REACHES_ZERO

    @property
    def message(self) -> str:
        """Why it ends, in words."""
        return message((self.end,))

    @property
    def displacement(self) -> float | None:
        """Displacement of the control point at λ = 0; None if the curve ends before."""
        return float(self.table["displacement"].iloc[-1]) if self.reaches_zero else None

    def poses(self, row: int) -> np.ndarray:
        """Where the movable blocks are in a row of the table: turned by θ about the geometry's origin, then
        shifted by (x, y), shape (b, 3), in the case's units."""
        return self.steps[row].poses[self.result.assembly.movable]

    @cached_property
    def table(self) -> pd.DataFrame:
        return pd.DataFrame([self._row(number) for number in range(len(self.steps))])

    def _row(self, number: int) -> dict[str, Any]:
        step, poses, states = self.steps[number], self.poses(number), self.joints(number)["state"]
        acting = self.control, self.dead, self.live
        control, dead, live = (_work(of, moved(of, poses).point) for of in acting)
        turned = float(lengths(poses[:, self.live.point.shape[1] :]).max())
        row: dict[str, Any] = {"displacement": control / _size(self.control), "rotation": turned}
        row |= {"load_factor": step.load_factor + 0.0, "dead_work": dead, "live_work": live}
        row |= {state: int((states == state).sum()) for state in ("hinged", "separated")}
        event, values = (str(step.event.code), step.event.values) if step.event else ("", {})
        return row | {"event": event, "pairs": values.get("pairs", [])}

    def joints(self, row: int = -1) -> pd.DataFrame:
        """Joints in a row of the table: ``first``, ``second``, ``state`` ("closed", "hinged", "separated"),
        where it hinges ``x``, ``y`` (``z``), displaced, and the ``angle`` by which it is open (rad)."""
        assembly, step = self.result.assembly, self.steps[row]
        joints, dimension = assembly.joints, assembly.scene.dimension
        count, full = np.bincount(joints.joint, step.touch), np.bincount(joints.joint)
        share = step.touch / np.maximum(count, 1)[joints.joint]
        at = sums(joints.joint, share[:, None] * joints.point, len(full))
        state = np.where(count == 0, "separated", np.where(count == full, "closed", "hinged"))
        # A corner that stands on an edge turns on it without closing.
        hinged = (state == "hinged") | ((count == 1) & (full == 1))
        place = placed(at, step.poses[joints.first]) + assembly.geometry.origin
        place[~hinged] = np.nan
        angle = lengths((step.poses[joints.first] - step.poses[joints.second])[:, dimension:])
        names = {of: assembly.names(getattr(joints, of)) for of in ("first", "second")}
        places = dict(zip("xyz", place.T, strict=False))
        angles = {"angle": np.where(count == full, 0.0, angle)}
        return pd.DataFrame(names | {"state": state} | places | angles)

    @property
    def _onset(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Sizes of the live forces, and at the onset their rates, shape (f,), and the control point's."""
        motion, sizes = self.motion[self.result.assembly.movable], lengths(self.live.force)
        live, control = (carried(of.point, motion[of.block]) for of in (self.live, self.control))
        rates = dots(self.live.force, live - self.live.point) / sizes
        return sizes, rates, _work(self.control, control) / _size(self.control)

    def check(
        self,
        spectrum: Sequence[tuple[float, float]],
        *,
        behaviour_factor: float = 2.0,
        confidence_factor: float = 1.35,
        gravity: float = 9.81,
        ultimate: float = 0.4,
        secant: float = 0.4,
    ) -> KinematicCheck:
        """Linear and non-linear kinematic check of an earthquake, after Circolare 617/2009, C8A.4.2.2 and
        C8A.4.2.3, to the Italian code.

        The live load must be that of 1 g: each force the weight of a mass that takes part.

        Raises OptionError if a value is wrong, the spectrum ends before the period asked for, or the live
        load is not that of 1 g: level, and as large as the weights that it pushes; NoLoadFactorError if no
        motion is known from the onset on.

        Parameters
        ----------
        spectrum: Elastic spectrum at the foot of the mechanism: periods (s), rising from 0, and accelerations
            (g), linear in between.
        behaviour_factor: q, of the linear check.
        confidence_factor: FC; 1.35, of the lowest level of knowledge, wherever the strength of masonry is
            left aside.
        gravity: In the case's unit of length per s².
        ultimate, secant: d*_u / d*_0 and d*_s / d*_u.
        """
        quake, case = self.result.assembly.scene.shaken_by, self.result.case
        if quake is not None and (quake.coefficient != 1 or quake.vertical):
            needed = "an earthquake of the whole weights, level: give it coefficient 1 and no vertical part"
            raise OptionError(f"{case}: the check needs {needed}")
        if len(self.steps) < 2:
            raise NoLoadFactorError(f"{case}: no curve to check: {self.message}")
        if quake is None and (share := self._share_of_weight()) is not None:
            needed = "a live load that pushes every mass with its weight"
            found = f"this one is {share:.3g} times the weight of the blocks that it pushes, or not level"
            ways = "'live_per_weight = [1, 0]', or a level [earthquake]"
            raise OptionError(f"{case}: the check needs {needed}: {found}: give {ways}")
        values = {"behaviour_factor": behaviour_factor, "confidence_factor": confidence_factor}
        values |= {"gravity": gravity, "ultimate": ultimate, "secant": secant}
        curve = self.table[["displacement", "load_factor"]].to_numpy()
        rests_on = f"{named_factor(self.result)}: {certainty(self.result)}"
        return kinematic_check(self._onset, curve, self.reaches_zero, spectrum, values, rests_on)

    def _share_of_weight(self) -> float | None:
        """The live load over the weight of the blocks that it pushes; None if it is that, and level."""
        problem, down = self.result.assembly.problem, self.result.assembly.scene.down
        live, dead = problem.forces(problem.live), problem.forces(problem.dead)
        size = lengths(live)
        weight = float((dead @ down)[size > 0].sum())
        share = float(size.sum()) / weight if weight > 0 else np.inf
        level = np.abs(live @ down).max() <= _LEVEL * size.max()
        return None if level and abs(share - 1) <= _WHOLE else share

    def plot(self, row: int | None = None) -> "Picture":
        """Draw the curve, or the blocks as they are in a row of the table, as a matplotlib figure. Raises
        OptionError if there is no such row."""
        if row is None:
            return self._curve()
        if not isinstance(row, int) or not -len(self.steps) <= row < len(self.steps):
            raise OptionError(f"there is no row {row!r}: the table has {len(self.steps)}, the first is 0")
        return self._displaced(row)

    def _curve(self) -> "Picture":
        """λ over displacement. Matplotlib takes longer to load than curves to follow."""
        from masonry_opt.drawing.figure import curve_axes, finish, style

        table, of = self.table, "the live load" if self.control is self.live else "the control point"
        heading, along = f"after the onset at {named_factor(self.result)}", f"displacement of {of}"
        with style():
            scene = self.result.assembly.scene
            made, axes = curve_axes(scene, heading, f"{along}, in the length unit of the case")
            marker = "o" if len(table) == 1 else ""  # a line through one state is nothing to see
            axes.plot(table["displacement"], table["load_factor"], color=BLACK, marker=marker, zorder=3)
            axes.axhline(0.0, color=HATCH, linewidth=0.6)
            axes.set_ylim(bottom=min(0.0, -0.02 * self.load_factor))
            handles: list[Handle] = []
            for code, (label, colour, marker) in _SEEN.items():
                rows = table[table["event"] == str(code)]
                if len(rows):
                    x, y = rows["displacement"], rows["load_factor"]
                    handles += axes.plot(x, y, marker, color=colour, label=label, zorder=4)
            finish(made, axes, handles, (self.message,))
        return made

    def _displaced(self, row: int) -> "Picture":
        """The blocks in a row of the table, to scale, with the hinges."""
        from masonry_opt.drawing.pictures import elements_picture

        assembly, state, joints = self.result.assembly, self.table.iloc[row], self.joints(row)
        poses, plane, marks = self.steps[row].poses, assembly.scene.dimension == 2, list[Marks]()
        there = replace(assembly, geometry=displaced(assembly.geometry, poses))
        if plane:
            *ends, owner = assembly.geometry.edges
            sides = np.stack(ends, axis=1)[np.isin(owner, assembly.movable)]
            marks.append(Marks("rest", "at rest", "line", AT_REST, 0.5, sides))
        if (hinged := joints["state"] == "hinged").any():
            place = joints.loc[hinged].filter(list("xyz")).to_numpy() - assembly.geometry.origin
            marks.append(Marks("hinges", "hinging joint", "dot", HINGES, 5.2, place[:, None]))
        if plane and (apart := (joints["state"] == "separated").to_numpy()).any():
            ends = np.stack([assembly.joints.start, assembly.joints.end], axis=1)[apart]
            blocks = assembly.joints.first[apart], assembly.joints.second[apart]
            sides = np.concatenate([placed(ends, poses[own][:, None]) for own in blocks])
            marks.append(Marks("separates", "separated joint", "line", SEPARATES, 1.6, sides))
        at = numeral(state["displacement"], ".4g")
        heading = f"λ = {numeral(state['load_factor'], '.5f')} at a displacement of {at}, to scale"
        return elements_picture(Elements(there, heading, "", 0 * poses, [], {"mechanism": marks}))

    def save(self, path: str | Path, row: int | None = None, force: bool = False) -> None:
        """Write such a picture (.png, .svg, .pdf), whole or not at all. Raises OptionError if the name has
        another ending, or the file cannot be replaced."""
        self.plot(row).save(path, force)

    @property
    def warning_sentences(self) -> tuple[str, ...]:
        """Warnings in words: what looks unintended in the scene."""
        return self.result.warning_sentences

    def __str__(self) -> str:
        return printable("\n".join([labelled(self.facts()), *warning_lines(self.warning_sentences)]))

    def facts(self) -> dict[str, str]:
        """What it found, in words by name."""
        events, last = self.table[self.table["event"] != ""], self.table.iloc[-1]
        ended, at_end = numeral(last["displacement"], ".6g"), numeral(last["load_factor"], ".4g")
        lines = {
            "case": self.result.case,
            "load factor": f"{numeral(self.load_factor, '.6g')} at the onset ({own_name(self.result)})",
            "known of it": certainty(self.result),
            "displacement": f"{ended} at the end, where λ = {at_end}",
            "end": self.message,
        }
        for _, row in events.iloc[: -1 if self.reaches_zero else None].iterrows():
            told = ", ".join(f"{one!r}–{other!r}" for one, other in row["pairs"][:3])
            at = f"{numeral(row['displacement'], '.4g')}, λ = {numeral(row['load_factor'], '.4g')}"
            lines[f"at {at}"] = f"{row['event']} {told}".strip()
        return lines

    def as_dict(self) -> dict[str, Any]:
        """The curve as plain numbers, strings and lists."""
        numbers = {key: getattr(self, key) for key in ("load_factor", "reaches_zero", "displacement")}
        told = {"end": self.end.as_dict(), "message": self.message, "curve": self.table.to_dict("records")}
        told["warnings"] = self.result.warning_records
        return {"case": self.result.case} | numbers | told

    def to_json(self) -> str:
        """``as_dict`` as one JSON object."""
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def _size(of: Forces) -> float:
    return float(lengths(of.force).sum())


def _work(of: Forces, points: np.ndarray) -> float:
    """Of forces whose points have come to others."""
    return float(dots(of.force, points - of.point).sum())

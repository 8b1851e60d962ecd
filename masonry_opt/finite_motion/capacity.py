"""Capacity curves (λ over displacement after the onset of collapse) and kinematic checks of codes."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from masonry_opt.brief import brief
from masonry_opt.drawing.marks import moved as carried
from masonry_opt.effort import ignore_progress
from masonry_opt.errors import NoLoadFactorError, OptionError, printable, rounded
from masonry_opt.finite_motion.capacity_pictures import curve_picture, displaced_picture
from masonry_opt.finite_motion.curve_input import CURVE_STEPS, curve_forces
from masonry_opt.finite_motion.edge import EdgePath
from masonry_opt.finite_motion.kinematic_check import (
    CONFIDENCE_FACTOR,
    CheckedCurve,
    KinematicCheck,
    kinematic_check,
)
from masonry_opt.finite_motion.moved_blocks import LEAST_RATE
from masonry_opt.finite_motion.path import HingingPath, PathProgress, PathState
from masonry_opt.finite_motion.struts import strut_paths
from masonry_opt.problem.displaced import moved, placed
from masonry_opt.problem.loads import Forces
from masonry_opt.reporting.load_factors import certainty, known_least, named_factor, own_name
from masonry_opt.reporting.names import labelled, warning_lines
from masonry_opt.reporting.sentences import message, numeral
from masonry_opt.result import Result
from masonry_opt.scene.mistakes import suggests_arguments
from masonry_opt.scene.positions import in_scene
from masonry_opt.scene.rows import dots, lengths, sums
from masonry_opt.scene.typical_sizes import GRAVITY
from masonry_opt.solution.reasons import Code, Reason
from masonry_opt.solution.thresholds import MOVES

if TYPE_CHECKING:
    from masonry_opt.drawing.figure import Picture

#: A kinematic check raises an error if the live load differs from the weight of the loaded blocks by more
#: than this fraction.
_WEIGHT_TOLERANCE = 1e-2
#: A kinematic check raises an error if the vertical part of a live force exceeds this fraction of the largest
#: live force.
_HORIZONTAL_LOAD_TOLERANCE = 1e-6
#: Remark on a kinematic check whose load factor is not proven to be the least.
_LOWER_MAY_FAIL = "if a collapse state with a lower λ exists, the linear or non-linear check may fail"


@suggests_arguments
def capacity(
    result: Result,
    *,
    block: str | None = None,
    point: tuple[float, ...] | None = None,
    steps: int = CURVE_STEPS,
    progress: PathProgress = ignore_progress,
) -> "Capacity":
    """Compute the capacity curve of a result, from the onset of collapse down to λ = 0.

    The curve is the load factor λ over the displacement of a control point.

    In the plane, joints stay closed, hinge about a corner, open completely or close again. The displaced
    blocks are in equilibrium at λ, and a linear program verifies for each state that admissible forces exist.
    Loads keep their direction, and their points of action move with the blocks. The curve ends when joints
    slide or blocks meet.

    In space, the mechanism must be one rigid body that rotates about an edge of the blocks at rest. Ties and
    props are included: their forces act along the line between their displaced ends. The curve also ends when
    another joint opens.

    Parameters
    ----------
    result: Result of :func:`~masonry_opt.solve`, by any method.
    block, point: Control point: the centroid of a block, or a point ``(x, y)``, in space ``(x, y, z)``, of
        the block at rest. The curve reports its displacement along the resultant of the live load. Default:
        the mean displacement of the live loads, each along its own direction.
    steps: Number of states between the onset of collapse and λ = 0 if λ decreases linearly. There are more
        states if λ decreases ever more slowly.
    progress: Function called at each new state of the curve, with the number of the state and its λ.

    Returns
    -------
    Capacity
        The curve with its states and its end. Its methods make plots and kinematic checks.

    Raises
    ------
    OptionError
        If joints have a limited strength; if the scene has fill or a support that settles, or in the plane
        ties or props; if the points of action of loads are not known; in space if joints slide or the
        mechanism is not one body that turns about an edge; if the control point is wrong or does not move
        along the live load; if no live load acts.
    NoLoadFactorError
        If the result has no load factor.
    """
    if not isinstance(result, Result):
        raise OptionError("a capacity curve needs a result of 'solve': call mo.capacity(mo.solve(scene))")
    if result.stability:
        needed = "a capacity curve needs a live load: add a live load, such as 'live' of a block"
        raise OptionError(f"{result.case}: the scene is stable and has no live load, but {needed}")
    result.required()
    dead, live, control = curve_forces(result.assembly, block, point, steps)
    follow = HingingPath if result.assembly.scene.dimension == 2 else EdgePath
    path = follow(result, (dead, live), steps, progress)
    curve = Capacity(result, path.end, tuple(path.steps), path.motion, dead, live, control)
    _, rates, control_rate = curve._onset
    if path.motion.any() and abs(control_rate) <= LEAST_RATE * rates.max():
        raise OptionError(
            f"the control point of block '{block}' does not move in the direction of the live load: choose "
            "another block or point"
        )
    return curve


@dataclass(frozen=True, eq=False)
class Capacity:
    """Capacity curve: λ over the displacement of a control point after the onset of collapse.

    Attributes
    ----------
    result: Result at the onset of collapse.
    end: Reason why the curve ends; its code is "reaches zero" if the curve ends at λ = 0.
    steps: States of the curve, with the poses of all blocks.
    motion: Rates of the poses of all blocks at the onset of collapse, shape (blocks, 3), in space
        (blocks, 6).
    dead, live: Forces of the dead and the live load at the points where they act.
    control: Forces that define the control displacement, which is the mean displacement of their points along
        the forces.
    """

    result: Result
    end: Reason
    steps: tuple[PathState, ...] = field(repr=False)
    motion: np.ndarray = field(repr=False)
    dead: Forces = field(repr=False)
    live: Forces = field(repr=False)
    control: Forces = field(repr=False)

    __repr__ = brief

    @property
    def load_factor(self) -> float:
        """Load factor λ at the onset of collapse."""
        return self.result.required()

    @property
    def reaches_zero(self) -> bool:
        """True if the capacity curve ends at λ = 0."""
        return self.end.code is Code.REACHES_ZERO

    @property
    def message(self) -> str:
        """Reason why the capacity curve ends, as a sentence."""
        return message((self.end,))

    @property
    def displacement(self) -> float | None:
        """Displacement of the control point at λ = 0; None if the curve ends before λ = 0."""
        return float(self.table["displacement"].iloc[-1]) if self.reaches_zero else None

    def poses(self, row: int) -> np.ndarray:
        """Return the poses of the movable blocks in one state of the curve.

        Parameters
        ----------
        row: Row of ``table``.

        Returns
        -------
        ndarray
            The poses, shape (b, 3), lengths in the unit of the case. A pose is a rotation by θ (rad) about
            the origin of the geometry, then a translation by (x, y). In space the shape is (b, 6): a
            translation and a rotation vector.

        Raises
        ------
        OptionError
            If ``table`` has no such row.
        """
        return self._step(row).poses[self.result.assembly.movable]

    @cached_property
    def table(self) -> pd.DataFrame:
        """Table of the capacity curve with one row for each state; the first row is the state at rest.

        - ``load_factor``: λ at which the displaced blocks are in equilibrium.
        - ``displacement``: displacement of the control point, in the case's unit of length.
        - ``rotation``: largest rotation of a block (rad).
        - ``dead_work``, ``live_work``: work of the loads from the state at rest. The live work is that of the
          live load for λ = 1.
        - ``hinged``, ``separated``: numbers of hinged and of separated joints.
        - ``event``: code of the event, with the ``pairs`` of blocks at the joints of the event.

        The displacement may decrease where joints close and open. Such states are in equilibrium, but a real
        collapse does not pass through them.
        """
        return pd.DataFrame([self._row(number) for number in range(len(self.steps))])

    def _row(self, number: int) -> dict[str, Any]:
        """Return the row of ``table`` for one state of the curve, as a dictionary."""
        step, poses, states = self.steps[number], self.poses(number), self.joints(number)["state"]
        acting = self.control, self.dead, self.live
        control, dead, live = (_work(forces, moved(forces, poses).point) for forces in acting)
        rotation = float(lengths(poses[:, self.live.point.shape[1] :]).max())
        row: dict[str, Any] = {"displacement": control / _size(self.control), "rotation": rotation}
        row |= {"load_factor": step.load_factor + 0.0, "dead_work": dead, "live_work": live}
        row |= {state: int((states == state).sum()) for state in ("hinged", "separated")}
        event, values = (str(step.event.code), step.event.values) if step.event else ("", {})
        return row | {"event": event, "pairs": values.get("pairs", [])}

    def joints(self, row: int = -1) -> pd.DataFrame:
        """Return a table with one row for each joint, in one state of the curve.

        Parameters
        ----------
        row: Row of ``table``; the default is the last.

        Returns
        -------
        DataFrame
            The table. Its columns are the names of the blocks (``first``, ``second``), ``state`` ("closed",
            "hinged" or "separated"), the displaced position of the hinge (``x``, ``y``, in space ``z``; NaN
            without a hinge) and the opening ``angle`` (rad).

        Raises
        ------
        OptionError
            If ``table`` has no row ``row``.
        """
        assembly, step = self.result.assembly, self._step(row)
        joints, dimension = assembly.joints, assembly.scene.dimension
        touching, points = np.bincount(joints.joint, step.touch), np.bincount(joints.joint)
        share = step.touch / np.maximum(touching, 1)[joints.joint]
        at = sums(joints.joint, share[:, None] * joints.point, len(points))
        state = np.full(len(points), "separated", dtype="<U9")
        state[touching > 0] = "hinged"
        state[(touching > 0) & (touching == points)] = "closed"
        # If a corner of a block touches an edge of another block, the joint has only one contact point. Such
        # a joint is a hinge as long as its point is closed.
        hinged = (state == "hinged") | ((touching == 1) & (points == 1))
        position = in_scene(assembly.geometry, placed(at, step.poses[joints.first]))
        position[~hinged] = np.nan
        angle = lengths((step.poses[joints.first] - step.poses[joints.second])[:, dimension:])
        table: dict[str, Any] = {
            "first": assembly.names(joints.first),
            "second": assembly.names(joints.second),
        }
        table["state"] = state
        table |= dict(zip("xyz", position.T, strict=False))
        table["angle"] = np.where(touching == points, 0.0, angle)
        return pd.DataFrame(table)

    @property
    def _onset(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Magnitude and rate of each live force, and rate of the control point, at the onset of collapse.

        The rate of a force is the velocity of its point of action in the direction of the force. Magnitudes
        and rates of the forces have shape (f,).
        """
        motion, sizes = self.motion[self.result.assembly.movable], lengths(self.live.force)
        live = carried(self.live.point, motion[self.live.block])
        control = carried(self.control.point, motion[self.control.block])
        rates = dots(self.live.force, live - self.live.point) / sizes
        return sizes, rates, _work(self.control, control) / _size(self.control)

    @property
    def _onset_of_moving(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Same values as ``_onset``, but only for the live forces that act on moving blocks.

        Blocks at rest do not belong to the kinematic chain, so their masses do not participate.
        """
        sizes, rates, control_rate = self._onset
        motion = self.motion[self.result.assembly.movable]
        speeds = lengths(carried(self.live.point, motion[self.live.block]) - self.live.point)
        moves = speeds > MOVES * speeds.max()
        return sizes[moves], rates[moves], control_rate

    @suggests_arguments
    def check(
        self,
        spectrum: Sequence[tuple[float, float]],
        *,
        code: str = "NTC 2008",
        behaviour_factor: float = 2.0,
        confidence_factor: float = CONFIDENCE_FACTOR,
        gravity: float = GRAVITY,
        ultimate: float | None = None,
        secant: float | None = None,
    ) -> KinematicCheck:
        """Make the linear and the non-linear kinematic check of the Italian building code for an earthquake.

        The checks are those of Circolare 617/2009, C8A.4.2.2 and C8A.4.2.3 (NTC 2008), or those of Circolare
        7/2019, C8.7.1.2.1.7 and C8.7.1.2.1.8 (NTC 2018). The live load must be that of 1 g: horizontal forces
        that equal the weights of the participating masses.

        Parameters
        ----------
        spectrum: Elastic spectrum at the base of the mechanism: increasing periods (s), from 0, with
            accelerations (g) that are interpolated linearly.
        code: Code and limit state: "NTC 2008", "NTC 2018 SLV" (life safety) or "NTC 2018 SLC" (collapse
            prevention). In NTC 2018 the spectrum is that of the limit state, with a damping of 8 % (SLV) or
            10 % (SLC).
        behaviour_factor: Behaviour factor q of the linear check.
        confidence_factor: Confidence factor FC. If the strength of masonry is neglected, the codes require
            1.35, the value of the lowest level of knowledge.
        gravity: Gravitational acceleration in the case's unit of length per s². The default is that for
            metres. For another unit, multiply the default by the number of units in a metre.
        ultimate, secant: Ratios d*_u / d*_0 and d*_s / d*_u. Default: the values of the code.

        Returns
        -------
        KinematicCheck
            Capacities, demands and the verdicts of both checks.

        Raises
        ------
        OptionError
            If a value is wrong, if the spectrum ends before the secant period, or if the live load is not
            horizontal or does not equal the weights of the loaded blocks.
        NoLoadFactorError
            If the curve has no state beyond the onset of collapse.
        """
        quake, case = self.result.assembly.scene.shaken_by, self.result.case
        if quake is not None and (quake.coefficient != 1 or quake.vertical):
            needed = (
                "the kinematic check needs a horizontal earthquake of 1 g: set 'coefficient' to 1 and omit "
                "'vertical'"
            )
            raise OptionError(f"{case}: {needed}")
        if len(self.steps) < 2:
            raise NoLoadFactorError(
                f"{case}: the capacity curve has no state after the onset of collapse, so the kinematic "
                f"check is not possible: {self.message}",
                self.result.warning_sentences,
            )
        share = self._share_of_weight() if quake is None else None
        if share is not None:
            needed = "the kinematic check needs a horizontal live load on each block, equal to its weight"
            mismatch = (
                "the live load is not horizontal, or differs from the weight of the loaded blocks "
                f"(live load / weight = {rounded(share)})"
            )
            ways = "specify 'live_per_weight = [1, 0]' or a horizontal [earthquake]"
            raise OptionError(f"{case}: {needed}: {mismatch}: {ways}")
        values: dict[str, Any] = {"code": code, "behaviour_factor": behaviour_factor}
        values |= {"confidence_factor": confidence_factor, "gravity": gravity}
        values |= {"ultimate": ultimate, "secant": secant}
        rests_on = f"{named_factor(self.result)}: {certainty(self.result)}"
        if not known_least(self.result):
            rests_on += f"; {_LOWER_MAY_FAIL}"
        assembly = self.result.assembly
        checked = CheckedCurve(
            *self._onset_of_moving,
            states=self.table[["displacement", "load_factor"]].to_numpy(),
            complete=self.reaches_zero,
            extent=float(assembly.geometry.extent_of(assembly.movable).max()),
            struts=strut_paths(assembly, [step.poses for step in self.steps]),
            rests_on=rests_on,
        )
        return kinematic_check(checked, spectrum, values)

    def _share_of_weight(self) -> float | None:
        """Return the ratio of the live load to the weight of the loaded blocks.

        The result is None if the live load is horizontal and the ratio is 1.
        """
        problem, down = self.result.assembly.problem, self.result.assembly.scene.down
        live, dead = problem.forces(problem.live), problem.forces(problem.dead)
        size = lengths(live)
        weight = float((dead @ down)[size > 0].sum())
        share = float(size.sum()) / weight if weight > 0 else np.inf
        level = np.abs(live @ down).max() <= _HORIZONTAL_LOAD_TOLERANCE * size.max()
        return None if level and abs(share - 1) <= _WEIGHT_TOLERANCE else share

    def plot(self, row: int | None = None) -> "Picture":
        """Return a matplotlib figure of the curve; if ``row`` is specified, a figure of the displaced blocks.

        Parameters
        ----------
        row: Row of ``table`` whose state is drawn; None for the curve.

        Returns
        -------
        Picture
            The figure, a subclass of matplotlib's ``Figure``.

        Raises
        ------
        OptionError
            If ``table`` has no row ``row``.
        """
        if row is None:
            mover = "the live load" if self.control is self.live else "the control point"
            return curve_picture(self.result, self.table, mover, self.message)
        step = self._step(row)
        state, joints = self.table.iloc[row], self.joints(row)
        return displaced_picture(self.result.assembly, state, joints, step.poses)

    def _step(self, row: Any) -> PathState:
        """Return the state in a row of ``table``. Raises OptionError if the table has no such row."""
        if not isinstance(row, int) or not -len(self.steps) <= row < len(self.steps):
            raise OptionError(
                f"there is no row {row!r}: the table has {len(self.steps)} rows, numbered from 0"
            )
        return self.steps[row]

    def save(self, path: str | Path, row: int | None = None, force: bool = False) -> None:
        """Save the plot of :meth:`plot` to a file (.png, .svg or .pdf).

        The file is written completely or not at all.

        Parameters
        ----------
        path: File to write.
        row: See ``plot``.
        force: True to replace a file that another program wrote.

        Raises
        ------
        OptionError
            If the name has another ending, or if the file exists and must not be replaced (see ``force``).
        """
        self.plot(row).save(path, force)

    @property
    def warning_sentences(self) -> tuple[str, ...]:
        """Sentences that warn of probable mistakes in the scene."""
        return self.result.warning_sentences

    def __str__(self) -> str:
        return printable("\n".join([labelled(self.facts()), *warning_lines(self.warning_sentences)]))

    def facts(self) -> dict[str, str]:
        """Return the lines that ``print`` shows, as a dictionary from the label of each line to its text."""
        events, last = self.table[self.table["event"] != ""], self.table.iloc[-1]
        ended, at_end = numeral(last["displacement"], ".6g"), numeral(last["load_factor"], ".4g")
        lines = {
            "case": self.result.case,
            "load factor": (
                f"{numeral(self.load_factor, '.6g')} at the onset of collapse ({own_name(self.result)})"
            ),
            "certainty": certainty(self.result),
            "displacement": (
                f"{ended} at the end of the curve (in the length unit of the case), where λ = {at_end}"
            ),
            "end": self.message,
        }
        texts = []
        for _, row in events.iloc[: -1 if self.reaches_zero else None].iterrows():
            pairs = ", ".join(f"{first!r}–{second!r}" for first, second in row["pairs"][:3])
            at, load_factor = (numeral(row[name], ".4g") for name in ("displacement", "load_factor"))
            texts.append(f"displacement {at}, λ = {load_factor}: {row['event']} {pairs}".strip())
        return lines | {"events": "\n".join(texts)}

    def as_dict(self) -> dict[str, Any]:
        """Return the curve as plain numbers, strings and lists.

        Returns
        -------
        dict
            The data by name. The list ``curve`` has a dictionary for each row of :attr:`table`.
        """
        return {
            "case": self.result.case,
            "load_factor": self.load_factor,
            "reaches_zero": self.reaches_zero,
            "displacement": self.displacement,
            "end": self.end.as_dict(),
            "message": self.message,
            "curve": self.table.to_dict("records"),
            "warnings": self.result.warning_records,
        }

    def to_json(self) -> str:
        """Return the dictionary of ``as_dict`` as one JSON object.

        Returns
        -------
        str
            One JSON object on one line.
        """
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def _size(forces: Forces) -> float:
    """Return the size of forces: the sum of their magnitudes."""
    return float(lengths(forces.force).sum())


def _work(forces: Forces, points: np.ndarray) -> float:
    """Return the work of constant forces whose points of action move to the rows of ``points``."""
    return float(dots(forces.force, points - forces.point).sum())

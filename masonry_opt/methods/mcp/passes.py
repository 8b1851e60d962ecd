"""Passes over one problem, its live load scaled to its dead load."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from masonry_opt.answer.thresholds import ZERO
from masonry_opt.effort import Effort
from masonry_opt.methods.mcp.edge_form import EdgeForm, Iterate
from masonry_opt.methods.mcp.interior_point import Outcome, run
from masonry_opt.methods.mcp.joints_alone import JointsAlone
from masonry_opt.methods.mcp.newton import Elimination
from masonry_opt.methods.mcp.schedule import BRAKES, NewtonStep
from masonry_opt.methods.task import Task
from masonry_opt.problem.faces import KINDS
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State
from masonry_opt.standing.weightless import weightless

#: Joints up to which the load to expect is told beside the answers of other methods.
PASSES_UP_TO = 8000

#: Compliance of contacts in passes of a search, which more often end than those with rigid ones, and in
#: space, where softer ones lead lower.
_OTHERS_GIVE, _OTHERS_GIVE_IN_SPACE = 1e-4, 1e-2

#: Share of the dead load from which on soft contacts carry it: those of an arch carry 0.2, those of a stone
#: that nothing presses against walls 2e-5.
_CARRIES = 1e-3

#: How often contacts of a scene with cohesion, strength or limits of forces are asked again what they carry
#: under its dead load, and the λ up to which they are settled. An arch under fill takes six.
_ASKED_AGAIN, _SETTLED = 12, 1e-7

#: From this gap on a pass that stalls may have forces that a mechanism goes with.
_NEAR = 1e-2


class Passes:
    """Passes over a problem and those that differ in law or compliance.

    Attributes
    ----------
    problem: with the law or the compliance of these passes.
    outcome: how the last one ended.
    inside: its last iterate inside all limits.
    """

    outcome: Outcome
    inside: Iterate

    def __init__(self, problem: Problem) -> None:
        self.problem, self._unit = problem, _unit_of_load(problem)
        self._alone = JointsAlone.of(replace(problem, live=self._unit * problem.live))
        self._elimination = Elimination(EdgeForm(self._alone.problem, self._alone.most))

    def again_for(self, problem: Problem, effort: Effort | None = None) -> Passes:
        """Passes over a problem that differs in friction, cohesion and dilatancy alone."""
        other = copy(self)
        other.problem = problem
        other._elimination = self._elimination.of(
            self._elimination.form.with_law(self._alone.law(problem.law))
        )
        return other

    def giving(self, give: float, settled: np.ndarray | None = None) -> Passes:
        """Passes over the same problem with contacts that give so much, from settled forces (3c,) on."""
        other = copy(self)
        form = self._elimination.form
        own = self._alone.held(give * unit_compliance(form.problem, form.least_forces))
        compliance = self._alone.compliance(own)
        other.problem = replace(self.problem, compliance=compliance, settled=settled)
        own_settled = None if settled is None else self._alone.joint_forces(settled)
        other._elimination = self._elimination.of(form.giving(own, own_settled))
        return other

    def settled_forces(self) -> np.ndarray | None:
        """Joint forces under the dead load alone of contacts that give, shape (3c,); None if no pass ends, or
        it ends where no load is left.

        A scene without cohesion, strength and limits of forces that carries λ times its dead load besides has
        1 + λ times these forces. One with them is asked again, of contacts that give 1 + λ times as much,
        until λ is about 0.
        """
        problem = self.problem
        if not problem.dead.any():
            return np.zeros(problem.B.shape[1])
        state = self._under_dead_load()
        give = 1.0
        for _ in range(_ASKED_AGAIN if problem.face_cohesion.any() else 0):
            if state is None or abs(state.load_factor) < _SETTLED:
                break
            give *= 1 + state.load_factor
            state = self._under_dead_load(give)
        return None if state is None or 1 + state.load_factor < ZERO else state.q / (1 + state.load_factor)

    def run(
        self,
        follow: Callable[[NewtonStep], None] = lambda _: None,
        brake: float = BRAKES[0],
        begun: Iterate | None = None,
        forces_alone: bool = False,
    ) -> State | None:
        """The state that a pass ends in, or the last iterate of one that stalls near a state; else None.

        Parameters
        ----------
        follow: called with every step, its λ that of the problem.
        brake: see :data:`~.schedule.BRAKES`.
        begun, forces_alone: see :func:`~.interior_point.run`.
        """

        def in_whole(step: NewtonStep) -> None:
            follow(replace(step, load_factor=self._unit * step.load_factor))

        end = run(self._elimination, brake, in_whole, begun, forces_alone)
        self.outcome, self.inside = end.outcome, end.inside
        if end.outcome is Outcome.LOST or (end.outcome is not Outcome.SOLVED and not end.gap < _NEAR):
            return None
        state = self._alone.state(self._elimination.form.state(end.iterate), self.problem)
        return replace(state, load_factor=self._unit * state.load_factor)

    def tells(self, load_factor: float, d: np.ndarray) -> bool:
        """Whether a mechanism (3b,) at a load factor tells of the load. One of blocks that weigh nothing
        there does so only where from rest these do not carry the dead load either."""
        return not weightless(self.problem, load_factor, d) or not self.carry_dead_load()

    def carry_dead_load(self) -> bool:
        """Whether contacts that give carry the dead load from rest; where friction alone holds blocks that
        nothing presses together they do not."""
        state = self._under_dead_load() if self.problem.dead.any() else None
        return state is None or 1 + state.load_factor > _CARRIES

    def _under_dead_load(self, give: float = 1.0) -> State | None:
        """The state of contacts that give, with the dead load as live load besides. A pass may end in one of
        blocks that slide and carry nothing, where one under another brake does not."""
        passes, state = Passes(replace(self.problem, live=self.problem.dead)).giving(give), None
        for brake in BRAKES[:3]:
            state = passes.run(brake=brake, forces_alone=True) or state
            if state is not None and 1 + state.load_factor > _CARRIES:
                break
        return state

    def over(self, problem: Problem, follow: Callable[[NewtonStep], None]) -> State | None:
        """The state that a pass over a problem of other loads or law ends in, with contacts that give."""
        same = problem.same_program(self.problem)
        give = _OTHERS_GIVE_IN_SPACE if problem.layout.round else _OTHERS_GIVE
        return (self.again_for(problem) if same else Passes(problem)).giving(give).run(follow)


def unit_compliance(problem: Problem, least_forces: np.ndarray) -> np.ndarray:
    """Compliance of each joint by kind of force, shape (3c,), as motion over force, in the problem's units: a
    joint of mean length, in space area, moves by one along its normal under the mean force of its points.

    Its stiffness, which its points share, grows with its area, in the plane its length; in shear it is half
    as stiff as along its normal, about as stone is.

    Parameters
    ----------
    least_forces: least forces that carry the dead load, by kind, shape (3, c).
    """
    points, extent = problem.layout.points, problem.matrices.extent
    force = float(np.abs(least_forces[:points]).mean()) or 1.0
    of_point = extent.mean() / extent / force
    return np.concatenate([*points * [of_point], *(KINDS - points) * [2 * of_point / points]])


def passes_of(task: Task) -> Passes:
    """Passes over a task's problem, their matrices kept."""
    return task.kept.of("passes", task.problem, task.effort, lambda: Passes(task.problem))


def prepared(task: Task) -> Passes:
    """The same, with the solver named and the time to build them counted."""
    task.effort.uses(task.solver.name, "complementarity problem")
    with task.effort.measure("build"):
        return passes_of(task)


def follow(
    task: Task,
    passes: Passes,
    history: list[Any],
    attempt: int,
    brake: float = BRAKES[0],
    begun: Iterate | None = None,
) -> State | None:
    """The state that a pass ends in (see :meth:`Passes.run`) if it tells of the load, its steps reported and
    recorded."""
    return _telling(passes, passes.run(_recorder(task, history, attempt), brake, begun))


def _telling(passes: Passes, state: State | None) -> State | None:
    if state is None or passes.tells(state.load_factor, state.d):
        return state
    passes.outcome = Outcome.WEIGHTLESS
    return None


def _recorder(task: Task, history: list[Any], attempt: int) -> Callable[[NewtonStep], None]:
    def record(step: NewtonStep) -> None:
        history.append(replace(step, attempt=attempt))
        task.effort.iterations += 1
        task.effort.add("solve", step.seconds)
        task.progress(history[-1])

    return record


def _unit_of_load(problem: Problem) -> float:
    """What makes live loads as large as the dead loads of the blocks that carry them: the gap is measured
    against the live load's work, at some least λ."""
    dead, live = problem.force_sizes(problem.dead), problem.force_sizes(problem.live)
    weights = float(dead[live > 0].sum()), float(dead.sum())
    return next((weight / float(live.sum()) for weight in weights if weight and live.any()), 1.0)

"""The incremental load factor: the largest under which the blocks find equilibrium as the load is raised.

1. Preload: the blocks come to rest under the dead load, from contacts without forces.
2. The live load is raised by increments, and after each the blocks come to rest again. Without events (a
   contact that opens, closes, slips or sticks) the response is linear, and an increment grows until it
   meets one. After a damped motion the next increment is small.
3. At a collapse the exact state is solved for. If its load factor lies between the load that is carried and
   the one that is not, loads just below and above are tried next; else the load in the middle.
4. The search ends when both loads differ by ``smallest_increment`` and an exact state lies between them, or
   by ``tolerance``; or if the response stays linear while the load grows a thousandfold: the load has no
   limit.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from math import inf

import numpy as np

from masonry_opt.answer.answer import Answer
from masonry_opt.answer.load_history import LoadHistory, LoadStep
from masonry_opt.answer.motion import weightless
from masonry_opt.effort import Effort
from masonry_opt.methods.incremental.collapse_state import solve_collapse_state
from masonry_opt.methods.incremental.contact_law import mean_force_and_compliance
from masonry_opt.methods.incremental.equilibrium import Collapse, Equilibrium, EquilibriumSolver
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.incremental.stiffness import StiffnessMatrix
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem

#: Distance of the loads that are tried next from that of an exact state, relative to ``tolerance``. With a
#: third both loads together lie closer than the tolerance.
NEXT_TO_EXACT = 1 / 3

#: Relative rounding within which an exact state lies between two loads.
ROUNDING = 1e-9


class End(StrEnum):
    """End of a load history."""

    COLLAPSE = "equilibrium is lost"
    UNBOUNDED = "joints that press ever harder carry any multiple of the live load"
    UNSTABLE = "the dead load is not carried from rest"
    UNDECIDED = "neither a collapse nor a proof that the load has no limit was found"


@dataclass(frozen=True)
class IncrementalResult:
    """Result of the incremental analysis."""

    end: End
    history: LoadHistory
    carried: float = 0.0  #: largest load factor under which the blocks found equilibrium
    not_carried: float = inf  #: load factor under which they collapsed
    state: Answer | None = None  #: exact state at a load factor between both
    #: Exact state in which the blocks move on after the collapse, under a load factor below ``carried``.
    state_in_motion: Answer | None = None
    #: Motion under ``not_carried``, or under a dead load that is not carried.
    collapse: Collapse | None = None

    @property
    def load_factor(self) -> float | None:
        """Load factor of the exact state, else ``carried``; None if there was no collapse."""
        if self.end is not End.COLLAPSE:
            return None
        return self.carried if self.state is None else self.state.load_factor

    def with_state(self, state: Answer | None) -> "IncrementalResult":
        """Return the result with an exact state of the collapse, unless it has one or the state is higher.

        A state between both loads is that of the collapse. In a lower one the blocks move on after it.
        """
        if self.state is not None or state is None:
            return self
        if _is_between(state, self.carried, self.not_carried):
            return replace(self, state=state, state_in_motion=None)
        if self.state_in_motion is None and state.load_factor < self.carried:
            return replace(self, state_in_motion=state)
        return self


def _is_between(state: Answer, carried: float, not_carried: float) -> bool:
    """Return True if the load factor of a state lies between two load factors, up to rounding."""
    rounding = ROUNDING * not_carried
    return carried - rounding <= state.load_factor <= not_carried + rounding


class IncrementalAnalysis:
    """Quasi-static analysis with elastic contacts, from the dead load to collapse."""

    def __init__(
        self,
        problem: Problem,
        settings: IncrementalSettings | None = None,
        compliance: np.ndarray | None = None,
        matrix: StiffnessMatrix | None = None,
    ) -> None:
        """Set up the solver; compliance and matrix are those of :class:`EquilibriumSolver`."""
        self.problem = problem
        self.solver = EquilibriumSolver(problem, settings, compliance, matrix)

    @cached_property
    def preload(self) -> Equilibrium | Collapse:
        """Equilibrium under the dead load from rest, or the collapse under it."""
        return self.solver.equilibrate(self.solver.at_rest(self.problem.settled), self.problem.dead)

    def run(self, progress: Callable[[LoadStep], None] = lambda _: None) -> IncrementalResult:
        """Return the load history to its end. ``progress`` is called with each load step."""
        if isinstance(self.preload, Collapse):
            return IncrementalResult(End.UNSTABLE, LoadHistory(), collapse=self.preload)
        return _LoadRaising(self.solver, self.preload, progress).run()

    @property
    def preload_forces(self) -> np.ndarray | None:
        """Joint forces (3c + t,) under the dead load from rest; None if it is not carried."""
        if isinstance(self.preload, Collapse):
            return None
        return self.solver.law.of_problem(self.preload.response.forces)

    def again_for(self, problem: Problem, effort: Effort | None = None) -> "IncrementalAnalysis":
        """Return an analysis of a problem of the same joints, itself if the problem is its own.

        The order of the unknowns is kept if the elastic stiffness is the same.
        """
        if problem is self.problem:
            return self
        return IncrementalAnalysis(problem, self.solver.settings, matrix=self.solver.matrix)

    def with_random_stiffness(self, deviation: float, rng: np.random.Generator) -> "IncrementalAnalysis":
        """Return an analysis with each contact's stiffness changed by a random factor.

        ``deviation`` is the standard deviation of the logarithm of the factors.
        """
        joints = self.problem.joints
        _, compliance = mean_force_and_compliance(self.problem)
        factors = np.exp(deviation * rng.standard_normal(self.problem.B.shape[1] - 2 * joints))
        factors = np.concatenate([factors[:joints], factors[:joints], factors])
        return IncrementalAnalysis(self.problem, self.solver.settings, factors * compliance)


def analysis_of(task: Task, settings: IncrementalSettings | None = None) -> IncrementalAnalysis:
    """Return the incremental analysis of a task's problem, which is kept for the task."""
    problem, settings = task.problem, settings or IncrementalSettings()

    def build() -> IncrementalAnalysis:
        return IncrementalAnalysis(problem, settings)

    return task.kept.of(("incremental", settings), problem, task.effort, build, own=True)


def is_meaningful(analysis: IncrementalAnalysis, load_factor: float, d: np.ndarray) -> bool:
    """Return True if a collapse mechanism (3b,) at a load factor says something about the live load.

    If the net load of all blocks that move vanishes at this load factor, the mechanism counts only if the
    scene does not carry its dead load from rest.
    """
    return not weightless(analysis.problem, load_factor, d) or analysis.preload_forces is None


class _LoadRaising:
    """Raises the live load from the preload, and brackets the collapse."""

    def __init__(
        self, solver: EquilibriumSolver, preload: Equilibrium, progress: Callable[[LoadStep], None]
    ) -> None:
        self.solver, self.problem, self.settings = solver, solver.problem, solver.settings
        self.progress = progress
        self.reached, self.carried = preload, 0.0
        self.not_carried = inf
        self.collapse: Collapse | None = None
        self.state: Answer | None = None
        self.state_in_motion: Answer | None = None
        self.start = preload.state.d
        self.steps: list[LoadStep] = []
        #: Load factor at which the live load is as large as the mean contact force.
        self.unit = 1 / solver.size(self.problem.live)
        self.last_increment = inf
        self._record(preload)

    def run(self) -> IncrementalResult:
        """Return the result."""
        for _ in range(self.settings.increments):
            if self._is_bracketed():
                return self._result(End.COLLAPSE)
            if self.carried > self.settings.largest_load * self.unit:
                return self._result(End.UNDECIDED)
            rate = self.solver.solve_linear(self.reached.response.tangent, 0.0, self.problem.live)
            increment = self._choose_increment(rate)
            if self.not_carried == inf:
                increment = self._extend_linearly(increment, rate)
                if increment == inf:
                    return self._result(End.UNBOUNDED)
            self._raise(increment, rate)
        return self._result(End.UNDECIDED)

    def _raise(self, increment: float, rate: np.ndarray) -> None:
        """Raise the load by an increment; the rate is the displacement (3b,) per load factor."""
        load_factor = self.carried + increment
        found = self.solver.equilibrate(self.reached.state, self._load(load_factor), increment * rate)
        if isinstance(found, Equilibrium):
            self.reached, self.carried, self.last_increment = found, load_factor, increment
            self._record(found)
            return
        self.not_carried, self.collapse = load_factor, found
        state = solve_collapse_state(self.solver, found, load_factor)
        is_between = state is not None and _is_between(state, self.carried, self.not_carried)
        self.state = state if is_between else None
        is_lower = state is not None and not is_between and state.load_factor < self.carried
        self.state_in_motion = state if is_lower else None

    def _choose_increment(self, rate: np.ndarray) -> float:
        """Return the next increment of the load factor."""
        if self.not_carried < inf:
            return self._choose_within_bracket()
        settings, solver = self.settings, self.solver
        load_factor = max(self.carried, settings.tolerance * self.unit)
        if self.reached.by_motion:
            # The contacts that slipped in the motion may stick now: a small increment finds out.
            return settings.tolerance * load_factor
        forces = max(1.0, solver.size(self.reached.response.forces))
        by_forces = settings.increment * forces / solver.size_of_motion(rate)
        largest = settings.largest_increment * max(self.carried, self.unit)
        least = settings.smallest_increment * load_factor
        return max(least, min(by_forces, largest, 2 * self.last_increment))

    def _choose_within_bracket(self) -> float:
        """Return the increment to just below or above an exact state, or to the middle of the bracket."""
        if self.state is not None:
            apart = NEXT_TO_EXACT * self.settings.tolerance * self.state.load_factor
            for load_factor in (self.state.load_factor - apart, self.state.load_factor + apart):
                if self.carried < load_factor < self.not_carried:
                    return load_factor - self.carried
        return (self.not_carried - self.carried) / 2

    def _extend_linearly(self, increment: float, rate: np.ndarray) -> float:
        """Return the increment, doubled as long as it meets no event; infinity if it never does."""
        limit = self.settings.unbounded * max(self.carried, self.unit, 1 / self.solver.size_of_motion(rate))
        longer = increment
        while self._is_linear_up_to(longer, rate):
            if longer > limit:
                return inf
            increment, longer = longer, 2 * longer
        return increment

    def _is_linear_up_to(self, increment: float, rate: np.ndarray) -> bool:
        """Return True if the contacts balance the load after an increment at the rate of the tangent."""
        trial = self.reached.state.trial + increment * self.solver.trial_change(rate)
        load = self._load(self.carried + increment)
        return self.solver.is_balanced(self.solver.unbalanced(self.solver.law.respond(trial), load), load)

    def _is_bracketed(self) -> bool:
        """Return True if the collapse is known well enough."""
        gap = self.not_carried - self.carried
        if self.state is not None and gap <= self.settings.smallest_increment * self.not_carried:
            return True
        zero = self.settings.tolerance * self.settings.smallest_increment * self.unit
        return gap <= max(self.settings.tolerance * self.not_carried, zero) and self.not_carried < inf

    def _load(self, load_factor: float) -> np.ndarray:
        load: np.ndarray = self.problem.dead + load_factor * self.problem.live
        return load

    def _record(self, found: Equilibrium) -> None:
        response, law = found.response, self.solver.law
        d = found.state.d - self.start
        step = LoadStep(
            iteration=len(self.steps) + 1,
            load_factor=self.carried,
            displacement=float(self.problem.live @ d) / self.problem.live_norm,
            is_jump=found.by_motion,
            sliding=response.sliding,
            open=(response.forces[: law.points, : law.joints] == 0).any(axis=0),
            d=d,
            forces=law.of_problem(response.forces),
        )
        self.steps.append(step)
        self.progress(step)

    def _result(self, end: End) -> IncrementalResult:
        return IncrementalResult(
            end,
            LoadHistory(tuple(self.steps)),
            self.carried,
            self.not_carried,
            self.state,
            self.state_in_motion,
            self.collapse,
        )

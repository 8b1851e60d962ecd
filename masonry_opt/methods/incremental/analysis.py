"""The incremental load factor: the largest λ under which the blocks find equilibrium as the load is raised.

1. Preload: the blocks find equilibrium under the dead load, starting from contacts without forces.
2. The live load is raised by increments, and the blocks find equilibrium after each increment. The response
   is linear until a contact opens, closes, slips or sticks, and the increment grows until this happens. After
   a damped motion the next increment is small.
3. After a collapse the program computes the exact state of the motion. If its load factor is between a load
   with equilibrium and a load without, the search tests loads just below and just above the state's load. The
   search ends if the blocks find equilibrium only under the smaller load. The exact state is then computed
   again, starting from the last equilibrium.
4. Without an exact state the load is bisected, with Newton's method, until the loads with and without success
   differ by less than 1e-6. A damped motion then shows that there is no equilibrium if the load is larger by
   ``tolerance``. The load factor is known to be in the range between both loads.
5. If the response remains linear while the load grows by the factor ``unbounded``, the load has no limit.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from itertools import takewhile
from math import inf

import numpy as np

from masonry_opt.effort import Effort, ignore_progress
from masonry_opt.methods.incremental.collapse_state import solve_collapse_state
from masonry_opt.methods.incremental.contact_law import mean_force_and_compliance
from masonry_opt.methods.incremental.equilibrium import (
    Collapse,
    Equilibrium,
    EquilibriumSolver,
    SlowMotion,
    Step,
)
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.incremental.stiffness import StiffnessMatrix
from masonry_opt.methods.task import Task
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.answer import Answer
from masonry_opt.solution.load_history import LoadHistory, LoadStep
from masonry_opt.solution.motion import weightless


class End(StrEnum):
    """Ways in which a load history can end."""

    COLLAPSE = "equilibrium is lost"
    UNBOUNDED = (
        "the compression of joints grows with the live load, so joints carry any multiple of the live load"
    )
    UNSTABLE = "the scene does not come to equilibrium when its dead load is applied to the blocks at rest"
    #: If a load history ends in one of the three ways below, the load factor remains undecided. Each text
    #: names the setting that ended the analysis.
    SLOW = "the blocks still move after the solves that the setting 'motion_solves' permits"
    TOO_MANY_INCREMENTS = (
        "the load history did not end within the increments that the setting 'increments' permits"
    )
    TOO_LARGE_LOAD = "the blocks carry the largest live load that the setting 'unbounded' permits"


@dataclass(frozen=True)
class IncrementalResult:
    """Result of the incremental analysis."""

    end: End
    history: LoadHistory
    carried: float = 0.0  #: largest load factor at which equilibrium was found
    not_carried: float = inf  #: smallest load factor under which the blocks collapsed
    #: Exact state of the collapse, with a load factor between ``carried`` and ``not_carried``; None if no
    #: state was found.
    state: Answer | None = None
    #: Exact state in which the blocks continue to move after the collapse, at a load factor below
    #: ``carried``. None if no state was found.
    state_in_motion: Answer | None = None
    #: Motion of the blocks in the collapse: at the load factor ``not_carried``, or under the dead load if the
    #: scene is unstable.
    collapse: Collapse | None = None
    #: Remaining unbalanced forces under the load factor ``carried``, divided by the norm of the live load,
    #: shape (3b,). None if the scene is unstable.
    unbalanced: np.ndarray | None = None
    #: Largest amount by which ``carried`` may exceed the load factor at collapse, because the forces of the
    #: load history are not exactly balanced: a quarter of the setting ``tolerance``, times the load factor.
    #: An exact state whose load factor is below ``carried`` by more is not the state of the collapse.
    most_excess: float = 0.0

    @property
    def load_factor(self) -> float | None:
        """Load factor of the exact state if known, otherwise the largest λ at which equilibrium was found.

        None if the analysis did not end in a collapse.
        """
        if self.end is not End.COLLAPSE:
            return None
        return self.carried if self.state is None else self.state.load_factor

    def with_state(self, state: Answer | None) -> "IncrementalResult":
        """Return a copy with an exact state added, or the unchanged result if the state is ignored.

        A state with a load factor between ``carried`` and ``not_carried`` is stored as the state of the
        collapse. A state with a lower load factor is stored as the state in which the blocks continue to move
        after the collapse. A state with a higher load factor is ignored. A state of the collapse is never
        replaced, and a state in motion is replaced only by a state of the collapse.
        """
        if self.state is not None or state is None:
            return self
        excess = _excess(state, self.unbalanced, self.most_excess)
        if _is_between(state, self.carried - excess, self.not_carried, self.not_carried):
            return replace(self, state=state, state_in_motion=None)
        if self.state_in_motion is None and state.load_factor < self.carried:
            return replace(self, state_in_motion=state)
        return self


def _is_between(state: Answer, carried: float, not_carried: float, size: float) -> bool:
    """Return True if the load factor of a state is between two load factors, up to rounding errors."""
    rounding = EQUALITY_TOLERANCE * size
    return carried - rounding <= state.load_factor <= not_carried + rounding


def _excess(state: Answer, unbalanced: np.ndarray | None, most: float) -> float:
    """Return the largest amount by which ``carried`` can exceed the λ of an exact state.

    Unbalanced forces at ``carried`` cause the excess. If no joint slips, virtual work limits the excess to
    the work of the unbalanced forces in the motion of the state, divided by the work of the live load. The
    work of the live load equals the norm of the live load, by which ``unbalanced`` is already divided. The
    returned value is at most ``most``.
    """
    return 0.0 if unbalanced is None else min(max(0.0, float(unbalanced @ state.d)), most)


class IncrementalAnalysis:
    """Quasi-static analysis with elastic contacts, from the dead load to collapse."""

    def __init__(
        self,
        problem: Problem,
        settings: IncrementalSettings | None = None,
        compliance: np.ndarray | None = None,
        matrix: StiffnessMatrix | None = None,
    ) -> None:
        """Set up the analysis. :class:`EquilibriumSolver` explains the arguments."""
        self.problem = problem
        self.solver = EquilibriumSolver(problem, settings, compliance, matrix)

    @cached_property
    def preload(self) -> Equilibrium | Collapse | SlowMotion:
        """Equilibrium of the blocks under the dead load, or their motion if no equilibrium is found.

        The blocks start from rest.
        """
        return self.solver.equilibrate(self.solver.at_rest(self.problem.settled), self.problem.dead)

    def run(self, progress: Callable[[LoadStep], None] = ignore_progress) -> IncrementalResult:
        """Compute the load history up to collapse, and call ``progress`` with each load step."""
        if isinstance(self.preload, Collapse):
            return IncrementalResult(End.UNSTABLE, LoadHistory(), collapse=self.preload)
        if isinstance(self.preload, SlowMotion):
            return IncrementalResult(End.SLOW, LoadHistory())
        return _LoadRaising(self.solver, self.preload, progress).run()

    @property
    def preload_forces(self) -> np.ndarray | None:
        """Joint forces at rest under the dead load, shape (3c + t,), or None if no equilibrium is found."""
        if not isinstance(self.preload, Equilibrium):
            return None
        return self.solver.law.of_problem(self.preload.response.forces)

    def again_for(self, problem: Problem, effort: Effort | None = None) -> "IncrementalAnalysis":
        """Return an analysis of another problem with the settings of this analysis.

        The stiffness matrix of this analysis is reused if both problems have the same joints and the same
        elastic stiffness.
        """
        if problem is self.problem:
            return self
        return IncrementalAnalysis(problem, self.solver.settings, matrix=self.solver.matrix)

    def with_random_stiffness(self, deviation: float, rng: np.random.Generator) -> "IncrementalAnalysis":
        """Return an analysis with each contact's stiffness changed by a random factor.

        ``deviation`` is the standard deviation of the logarithm of the factors.
        """
        joints = self.problem.joints
        _, compliance = mean_force_and_compliance(self.problem, self.solver.settings)
        factors = np.exp(deviation * rng.standard_normal(self.problem.B.shape[1] - 2 * joints))
        factors = np.concatenate([factors[:joints], factors[:joints], factors])
        return IncrementalAnalysis(self.problem, self.solver.settings, factors * compliance)


def analysis_of(task: Task, settings: IncrementalSettings | None = None) -> IncrementalAnalysis:
    """Return the incremental analysis of a task's problem. Later calls return the same object."""
    problem, settings = task.problem, settings or IncrementalSettings()

    def build() -> IncrementalAnalysis:
        return IncrementalAnalysis(problem, settings)

    return task.cache.of(("incremental", settings), problem, task.effort, build, own=True)


def is_meaningful(analysis: IncrementalAnalysis, load_factor: float, d: np.ndarray) -> bool:
    """Return True if a mechanism d, shape (3b,), is a collapse, and not only a motion of weightless blocks.

    At a negative λ, the live load can cancel the weight of blocks. A mechanism that moves only such blocks
    counts as a collapse only if no equilibrium is found under the dead load from rest.
    """
    return not weightless(analysis.problem, load_factor, d) or analysis.preload_forces is None


class _LoadRaising:
    """Search for the collapse load: raise the live load in steps, starting from the preload."""

    def __init__(
        self, solver: EquilibriumSolver, preload: Equilibrium, progress: Callable[[LoadStep], None]
    ) -> None:
        self.solver, self.problem, self.settings = solver, solver.problem, solver.settings
        self.progress = progress
        self.reached, self.carried = preload, 0.0
        self.not_carried = self.unreached = inf
        # Load factors tried after the last equilibrium, at which the damped motion ended neither at rest nor
        # in collapse.
        self.slow: list[float] = []
        self.collapse: Collapse | None = None
        self.state: Answer | None = None
        self.state_in_motion: Answer | None = None
        self.start = preload.state.d
        self.steps: list[LoadStep] = []
        #: Load factor at which the root mean square of the live load equals the mean contact force.
        self.unit = 1 / solver.size(self.problem.live)
        self.last_increment = inf
        #: The two most recent predictions from the last equilibrium: pairs of a load factor and a step.
        self.predicted: list[tuple[float, Step]] = []
        self._record(preload)

    @cached_property
    def rate(self) -> np.ndarray:
        """Derivative of the block displacements with respect to the load factor, shape (3b,)."""
        return self.solver.solve_linear(self.reached.response.tangent, 0.0, self.problem.live)

    def run(self) -> IncrementalResult:
        """Raise the load until the end of the load history, and return the result."""
        for _ in range(self.settings.increments):
            if self._is_bracketed() or (self.slow and self.not_carried < inf):
                return self._result(End.COLLAPSE)
            if self.not_carried < inf:
                self._narrow()
                continue
            load_factor = self._extend_linearly(self._choose_increment())
            if load_factor == inf:
                return self._result(End.UNBOUNDED)
            if self.carried > self.settings.unbounded * self.unit:
                return self._result(End.TOO_LARGE_LOAD)
            self._raise_to(load_factor)
            if self.slow and not self._pass_slow_motion():
                return self._result(End.SLOW)
        return self._result(End.TOO_MANY_INCREMENTS)

    def _raise_to(self, load_factor: float) -> None:
        """Raise the load to a given load factor, and record the outcome.

        The blocks reach equilibrium, or collapse, or still move when the analysis of their motion stops.
        """
        if load_factor < self.unreached and self._reach(load_factor):
            return
        outcome = self.solver.move(self.reached.state, self._load(load_factor))
        if isinstance(outcome, Equilibrium):
            self._go_on_from(outcome, load_factor)
            self.unreached = self.not_carried
            return
        self.unreached = load_factor
        if isinstance(outcome, SlowMotion):
            self.slow.append(load_factor)
            return
        self.not_carried, self.collapse = load_factor, outcome
        state = solve_collapse_state(self.solver, outcome, load_factor)
        is_between = state is not None and self._is_in_bracket(state)
        self.state = state if is_between else None
        is_lower = state is not None and not is_between and state.load_factor < self.carried
        self.state_in_motion = state if is_lower else None

    def _pass_slow_motion(self) -> bool:
        """Try larger loads after a slow motion. Return True if a load leads to equilibrium or collapse."""
        slow, increment = self.slow[0], self.settings.smallest_increment
        while self.slow and self.not_carried == inf and increment < 1:
            self._raise_to(slow * (1 + increment))
            increment *= 2
        return not self.slow or self.not_carried < inf

    def _reach(self, load_factor: float) -> bool:
        """Try to reach equilibrium under a larger load by Newton's method. Return True if it converges."""
        first = self._predict(load_factor)
        equilibrium = self.solver.find_equilibrium(self.reached.state, self._load(load_factor), first)
        if equilibrium is None:
            self.unreached = load_factor
            return False
        self._go_on_from(equilibrium, load_factor)
        return True

    def _go_on_from(self, equilibrium: Equilibrium, load_factor: float) -> None:
        """Record an equilibrium under a larger load. The load history continues from this equilibrium."""
        last = self.carried
        self.reached, self.carried, self.last_increment = equilibrium, load_factor, load_factor - last
        self.__dict__.pop("rate", None)
        self.predicted = []
        self.slow = []
        self._record(equilibrium)
        if self.state is not None and not self._may_be_limit(self.state):
            self.state = None

    def _may_be_limit(self, state: Answer) -> bool:
        """Return True if an exact state can still be the state of the collapse.

        The state must be in the bracket of the collapse load. In addition, ``carried`` must be smaller than
        the load factor that is tested above the state (see :meth:`_around`).
        """
        return self._is_in_bracket(state) and self.carried < self._around(state)[1]

    def _is_in_bracket(self, state: Answer) -> bool:
        excess = _excess(state, self._unbalanced, self._most_excess)
        return _is_between(state, self.carried - excess, self.not_carried, self._size_of(self.not_carried))

    @property
    def _unbalanced(self) -> np.ndarray:
        """Unbalanced forces at the load factor ``carried``, divided by the live load's norm, shape (3b,)."""
        forces = self.solver.unbalanced(self.reached.response, self._load(self.carried))
        return forces / self.problem.live_norm

    @property
    def _most_excess(self) -> float:
        """Largest amount by which unbalanced forces may raise ``carried`` above the λ of an exact state.

        The search tests a load factor slightly above the λ of the exact state (see :meth:`_around`). The
        amount is half of the distance between both load factors. The tested load factor is therefore larger
        than ``carried``.
        """
        return self.settings.tolerance / 4 * self._size_of(self.carried)

    def _size_of(self, load_factor: float) -> float:
        """Return the divisor for relative differences of load factors: λ, but at least a positive minimum."""
        return max(load_factor, self.settings.smallest_increment * self.unit)

    def _choose_increment(self) -> float:
        """Return the next increment of the load factor."""
        settings, solver = self.settings, self.solver
        load_factor = self._size_of(self.carried)
        if self.reached.by_motion:
            # Use a small increment after a damped motion, to find out which contacts now stick. Double the
            # increment with each consecutive damped motion.
            motions = sum(1 for _ in takewhile(lambda step: step.is_jump, reversed(self.steps)))
            share = settings.tolerance * 2.0 ** min(motions - 1, 60)
            return min(share, settings.smallest_increment) * load_factor
        forces = max(1.0, solver.size(self.reached.response.forces))
        least = settings.smallest_increment * load_factor
        motion = solver.size_of_motion(self.rate)
        if motion == 0:
            # No elastic deformation can balance the live load, so the smallest increment already leads to
            # collapse.
            return least
        by_forces = settings.increment * forces / motion
        return max(least, min(by_forces, 2 * self.last_increment))

    def _narrow(self) -> None:
        """Narrow the bracket between the largest load with equilibrium and the smallest load with collapse.

        With an exact state the next loads are just below and just above the load of the state. For the load
        above, only Newton's method is used: if it succeeds, the state is not the limit. Without an exact
        state Newton's method bisects the load. When the bisection is narrow, a damped motion tests the load
        for which Newton's method fails.
        """
        if self.state is not None:
            below, above = self._around(self.state)
            if self.carried < below:
                self._raise_to(below)
            elif self.unreached > above:
                self._reach(above)
            else:
                further = self.settings.smallest_increment / 2 * self._size_of(self.state.load_factor)
                self._raise_to(self.state.load_factor + further)
            return
        is_reached = self._is_close(self.carried, self.unreached)
        if is_reached and not self._is_close(self.carried, self.not_carried):
            self._raise_to(self.unreached)
        else:
            self._reach((self.carried + self.unreached) / 2)

    def _is_close(self, load_factor: float, larger: float) -> bool:
        """Return True if two load factors differ by at most the setting ``tolerance``."""
        return larger - load_factor <= self.settings.tolerance * self._size_of(larger)

    def _around(self, state: Answer) -> tuple[float, float]:
        """Return two load factors, slightly below and slightly above the load factor of an exact state."""
        apart = self.settings.tolerance / 2 * self._size_of(state.load_factor)
        return state.load_factor - apart, min(state.load_factor + apart, self.not_carried)

    def _extend_linearly(self, increment: float) -> float:
        """Double a load increment as long as no contact changes its state, and return the new load factor.

        Return infinity if no contact changes its state, even during a very large increment.
        """
        motion = self.solver.size_of_motion(self.rate)
        if motion == 0:
            return self.carried + increment
        limit = self.settings.unbounded * max(self.carried, self.unit, 1 / motion)
        longer = increment
        while self._is_linear_up_to(self.carried + longer):
            if longer > limit:
                return inf
            increment, longer = longer, 2 * longer
        return self.carried + increment

    def _is_linear_up_to(self, load_factor: float) -> bool:
        """Return True if no contact changes its state while the load grows to a larger load factor."""
        return self.solver.is_balanced(self._predict(load_factor).unbalanced, self._load(load_factor))

    def _predict(self, load_factor: float) -> Step:
        """Return the step to a larger load factor along the derivative of the displacements.

        The two last steps are stored: the load is often raised to one of the load factors for which a linear
        response was tested.
        """
        for known, step in self.predicted:
            if known == load_factor:
                return step
        displacement = (load_factor - self.carried) * self.rate
        step = self.solver.evaluate(self.reached.state, self._load(load_factor), 0.0, displacement)
        self.predicted = [*self.predicted[-1:], (load_factor, step)]
        return step

    def _is_bracketed(self) -> bool:
        """Return True if the bracket of the collapse load is narrow enough."""
        if self.not_carried == inf:
            return False
        settings, size = self.settings, self._size_of(self.not_carried)
        if self._is_close(self.carried, self.not_carried):
            # If the live load is negligible compared with the dead load, do not bisect the load factor,
            # because rounding errors would determine the result.
            is_negligible = self.carried == 0
            is_fine = self.unreached - self.carried <= EQUALITY_TOLERANCE * size
            return self.state is not None or is_negligible or is_fine
        if self.state is None or self.not_carried - self.carried > settings.smallest_increment * size:
            return False
        below, above = self._around(self.state)
        return below <= self.carried and self.unreached <= above

    def _load(self, load_factor: float) -> np.ndarray:
        load: np.ndarray = self.problem.dead + load_factor * self.problem.live
        return load

    def _record(self, equilibrium: Equilibrium) -> None:
        response, law = equilibrium.response, self.solver.law
        d = equilibrium.state.d - self.start
        step = LoadStep(
            iteration=len(self.steps) + 1,
            load_factor=self.carried,
            displacement=float(self.problem.live @ d) / self.problem.live_norm,
            is_jump=equilibrium.by_motion,
            sliding=response.sliding,
            open=(response.forces[: law.points, : law.joints] == 0).any(axis=0),
            d=d,
            forces=law.of_problem(response.forces),
        )
        self.steps.append(step)
        self.progress(step)

    def _result(self, end: End) -> IncrementalResult:
        state = self._find_exact_state()
        return IncrementalResult(
            end,
            LoadHistory(tuple(self.steps)),
            self.carried,
            self.not_carried,
            state,
            None if state is not None else self.state_in_motion,
            self.collapse,
            self._unbalanced,
            self._most_excess,
        )

    def _find_exact_state(self) -> Answer | None:
        """Return the exact state of the collapse, or None if no exact state is in the bracket.

        The state is solved for again, starting from the last equilibrium. On the way from this equilibrium
        the contacts slip less than in the motion under a load that is too large, so that the state hardly
        depends on the increments.
        """
        narrow = self.settings.smallest_increment * self._size_of(self.not_carried)
        if self.collapse is None or self.not_carried - self.carried > narrow:
            return None
        start = Collapse(self.reached.state, self.collapse.motion)
        state = solve_collapse_state(self.solver, start, self.carried)
        return state if state is not None and self._is_in_bracket(state) else self.state

"""Run the loop once: record each sub-problem, decide when to stop, and find the exact state at the end."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.methods.exact.alternation import ExactPrograms
from masonry_opt.methods.loop.options import Attempt
from masonry_opt.methods.loop.steps import SubProblem, corrected, sub_problems
from masonry_opt.models.cvxpy_exact import CvxpyAtYield
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE
from masonry_opt.problem.problem import Problem, ShearLimits, State, in_units_of_live_load, in_units_of_load
from masonry_opt.solution.acceptance import LIMITS, MOST_ENERGY, Kind
from masonry_opt.solution.answer import Answer, FinalState, certified
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.cvxpy_engine import has_optimum
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import Solved, Solver, in_cvxpy

#: Limit of the energy error of sliding joints (``Iteration.mismatch``), relative to λ. Below this limit, a
#: run with rough sub-problems (large solver tolerance) looks for an exact state, in order to end early. A
#: smaller limit needs more sub-problems: on façades, 1e-3 needs two to three times as many as 5e-3.
_NEARLY_TRUE = 5e-3

#: If the search for an exact state fails in a run that may end early, the loop solves this number of
#: sub-problems before it searches again. With a smaller number, more searches fail.
_SUB_PROBLEMS_BETWEEN_TRIALS = 2

#: Number of successive doublings of λ, from one sub-problem to the next, after which the loop counts as
#: divergent. The run then ends.
_MOST_DOUBLINGS = 5

#: Smallest relative increase of λ from one sub-problem to the next that counts as steady growth of the loop.
_LEAST_STEADY_INCREASE = 1e-2

#: The loop counts as divergent after this number of successive increases of λ by at least the fraction
#: ``_LEAST_STEADY_INCREASE``, if λ then exceeds ``_DIVERGENCE_RATIO`` times its first value.
_MOST_STEADY_INCREASES = 30

#: If λ grows steadily and exceeds this multiple of its first value, the loop counts as divergent.
_DIVERGENCE_RATIO = 1e3

#: Length of the longest cycle that the loop detects, in sub-problems. A loop with a longer cycle runs until
#: its iteration limit.
LONGEST_PERIOD = 6

#: An oscillation of λ counts as a cycle, which ends the run, if λ changes by less than this fraction of its
#: range from one period to the next. With a larger value, slowly damped oscillations also count as cycles.
_LARGEST_CYCLE_DRIFT = 0.05

#: Two fractions of the largest rate, tried one after the other. Rates above the fraction count as nonzero.
#: The first fraction exceeds the rates that solvers return in place of zero. The second fraction is tried if
#: no exact state is found with the first fraction.
_MOVING_RATE_SHARES = (1e-6, 1e-4)

#: Key in ``result.solvers`` of the solvers that computed the exact state at the end of a run of the loop.
_EXACT_END_PURPOSE = "exact end"


@dataclass(frozen=True)
class Iteration:
    """Record of one sub-problem in the history of the loop.

    Work and energies are relative to the work of the live load at λ = 1.
    """

    iteration: int  #: number of the sub-problem in its run, from 1
    #: λ of the sub-problem. The small cohesion that the loop adds increases λ slightly; this contribution is
    #: subtracted only at the end of a run.
    load_factor: float
    #: Slope α of the shear limit, relative to μ; NaN for the first sub-problem, whose shear limit has no α.
    alpha: float
    #: Largest change of a normal force from the previous sub-problem, relative to the median dead load of a
    #: block.
    change: float
    #: Largest violation of the true Coulomb law, relative to the median dead load of a block.
    violation: float
    raising: float  #: work done against the dead load (paper, Fig. 12)
    sliding: float  #: energy dissipated by sliding in the sub-problem
    #: Energy that the slips of the sub-problem would dissipate with Coulomb's shear limits: the paper's
    #: corrected energy.
    coulomb_sliding: float
    #: Error of the dissipated energy: the sum over all joints of slip times the absolute difference between
    #: the sub-problem's shear limit and Coulomb's shear limit. The small cohesion that the loop adds is
    #: subtracted from the sub-problem's shear limit.
    mismatch: float
    seconds: float  #: time of the solver
    attempt: int  #: number of the run of the loop, from 1
    remedy: str  #: changed option of the run, such as "beta=0.3"; "" for the first run
    solved: SubProblem | None = field(default=None, repr=False)  #: the sub-problem; None in a history


def _recorded(problem: Problem, last: SubProblem, before: State | None, attempt: Attempt) -> Iteration:
    """Return the record of a sub-problem. ``before`` is the state of the previous sub-problem."""
    state, limits = last.state, last.limits
    n, slip = problem.normal_forces(state.q), problem.slip(state.p)
    coulomb = ShearLimits.true(problem).at(n[problem.sliding])
    limit = limits.at(n[problem.sliding]) - last.added_cohesion
    change = np.nan if before is None else np.abs(n - problem.normal_forces(before.q)).max()
    unit = problem.live_norm
    return Iteration(
        iteration=last.number,
        load_factor=state.load_factor,
        alpha=last.alpha,
        change=float(change),
        violation=max(-float(problem.slacks(state.q).min()), 0.0),
        raising=float(-problem.dead @ state.d) / unit,
        sliding=float(limits.cohesion @ slip) / unit,
        coulomb_sliding=float(coulomb @ slip) / unit,
        mismatch=float(np.abs(limit - coulomb) @ slip) / unit,
        seconds=last.solved.seconds,
        attempt=attempt.number,
        remedy=attempt.remedy,
        solved=last,
    )


class Run:
    """One run of the loop of linear programs.

    The driver solves a static model; from one sub-problem to the next only its shear limits change.
    """

    def __init__(self, problem: Problem, driver: Driver, attempt: Attempt) -> None:
        self.problem, self.driver, self.attempt = problem, driver, attempt
        self.parameters = attempt.parameters
        kind = Kind.LOOP if self.parameters.finish else Kind.BARE_LOOP
        self.ending = Solution(Status.ITERATION_LIMIT, kind)
        self.load_factors: list[float] = []
        self.states: deque[State] = deque(maxlen=LONGEST_PERIOD + 1)
        self.next_try = 0
        #: True if the run may end before λ converges, as soon as an exact state is found.
        self.early = self.parameters.finish and self.parameters.tolerance is not None
        #: True if the first load factor is reported as the associative load factor. With a large tolerance of
        #: sub-problems it is not reported, because it is wrong by up to 0.4 %.
        self.first_is_associative = self.parameters.start == "associative" and not self.parameters.tolerance

    def follow(self, progress: Callable[[Iteration], None]) -> Solution:
        """Solve sub-problems until the run ends, and return the solution of the run.

        ``progress`` is called with the record of each sub-problem.
        """
        problem, steps = self.problem, sub_problems(self.problem, self.driver, self.parameters)
        for last in islice(steps, self.parameters.max_iterations):
            if isinstance(last, Solved):
                return self._without_optimum(last)
            entry = _recorded(problem, last, self.states[-1] if self.states else None, self.attempt)
            state = last.state
            self.states.append(state)
            self.load_factors.append(state.load_factor)
            final_state = FinalState(q=state.q, d=state.d, slope=problem.dilatancy, forms=problem.forms)
            history = (*self.ending.history, replace(entry, solved=None))
            associative = self.load_factors[0] + 0.0 if self.first_is_associative else None
            self.ending = replace(self.ending, state=final_state, history=history, associative=associative)
            progress(entry)
            ended = self._nothing_to_do(last) if last.number == 1 else self._ended(last, entry)
            if ended:
                return ended
        latest = self.load_factors[-LONGEST_PERIOD:]
        values = {"count": len(self.load_factors), "lowest": min(latest), "highest": max(latest)}
        return self.ending.telling(reason(Code.STILL_CHANGES, **values))

    def _without_optimum(self, last: Solved) -> Solution:
        """Return the solution of a run whose last sub-problem has no optimum."""
        number, none = len(self.load_factors) + 1, replace(self.ending, state=FinalState())
        if number == 1 or last.failed:
            return none.ended(Status.SOLVER_FAILED, Code.SUB_PROBLEM_FAILED, number=number, word=last.status)
        return none.ended(Status.NO_STATE, Code.SUB_PROBLEM_EMPTY, number=number)

    def _nothing_to_do(self, last: SubProblem) -> Solution | None:
        """Return the associative answer if it also obeys the joints' own flow rule, otherwise None.

        If the answer obeys this flow rule, the loop has nothing to do. None is also returned for a cohesive
        start and with the option ``always``.
        """
        parameters, state = self.parameters, last.state
        if parameters.start != "associative" or parameters.always or not obeys_own_flow(self.problem, state):
            return None
        answer = certified(self.problem, state.load_factor, state.q, state.d)
        ended = replace(self.ending, state=answer, flow_rule_matters=False)
        return ended.ended(Status.CONVERGED, Code.FLOW_RULE_IDLE)

    def _ended(self, last: SubProblem, entry: Iteration) -> Solution | None:
        """Return the solution if the sub-problem that was just solved ends the run, otherwise None.

        A run ends in one of these cases:

        - λ has converged;
        - exact forces are found early;
        - λ diverges;
        - the sub-problems repeat in a cycle.
        """
        parameters = self.parameters
        if last.alpha <= parameters.alpha_min:
            is_nearly_true = self.early and entry.mismatch <= _NEARLY_TRUE * abs(entry.load_factor)
            # A run that may end early searches for an exact state before λ converges. If a search fails, it
            # solves a few sub-problems before the next search. Other runs search only when λ has converged.
            may_try = last.number >= self.next_try or not self.early
            if (is_nearly_true or last.stands_still) and may_try:
                exact = self._exact_end(last)
                if exact:
                    return exact
                self.next_try = last.number + _SUB_PROBLEMS_BETWEEN_TRIALS
            if last.stands_still and not self.early:
                return self._converged(last)
        if diverges(self.load_factors):
            values = {"load_factor": self.load_factors[-1], "count": len(self.load_factors)}
            return self.ending.ended(Status.JAMMED, Code.GROWS, **values)
        normal = [self.problem.normal_forces(state.q) for state in self.states]
        length = period(self.load_factors, normal)
        if not length:
            return None
        cycle = self.load_factors[-length:]
        exact = self._exact_end(last)
        cycle_values = {"lowest": min(cycle), "highest": max(cycle), "exact": exact is not None}
        ended = exact or replace(self.ending, status=Status.CYCLING)
        return ended.telling(reason(Code.REPEATS, period=length, **cycle_values))

    def _exact_end(self, last: SubProblem) -> Solution | None:
        """Return the solution with exact forces close to the forces of the last sub-problem.

        None is returned if no such forces are found, or if the option ``finish`` is off.
        """
        if not self.parameters.finish:
            return None
        problem, state, solver, effort = self.problem, last.state, self.attempt.solver, self.driver.effort
        effort.begins("exact forces")
        end: Answer | None = None
        is_rough = self.parameters.tolerance is not None or problem.layout.round
        if not is_rough:
            end = accurate_end(problem, state, corrected(problem, last), solver, effort)
        # If joints can crush, also try the method for rough sub-problems, which computes a new mechanism. The
        # mechanism of the sub-problem may be wrong: sliding joints contract, which can take the place of
        # crushing.
        if is_rough or (end is None and len(problem.crushing)):
            end = rough_end(problem, state, solver, effort)
        if end is None:
            return None
        return replace(self.ending, status=Status.CONVERGED, state=end, exact_end=True)

    def _converged(self, last: SubProblem) -> Solution:
        """Return the solution of a converged run.

        The small cohesion that the loop adds to the shear limits increases λ. Its contribution is subtracted.
        """
        state, ended, first = last.state, self.ending, self.load_factors[0]
        load_factor = corrected(self.problem, last)
        # Limit λ to the associative load factor, which is an upper bound on λ for any dilatancy smaller than
        # the friction.
        if self.first_is_associative and load_factor > first:
            ended = ended.telling(reason(Code.ABOVE_ASSOCIATIVE, by=load_factor - first))
            load_factor = first
        answer = certified(self.problem, load_factor, state.q, state.d)
        return replace(ended, status=Status.CONVERGED, state=answer)


def obeys_own_flow(problem: Problem, state: State) -> bool:
    """Return True if an associative state also obeys the flow rule with the joints' own dilatancy.

    This is so if sliding dissipates no energy, neither by cohesion nor by friction that exceeds dilatancy.
    Without dead load and cohesion λ is zero under any flow rule, and True is returned.
    """
    n = problem.normal_forces(state.q)
    limits = ShearLimits(problem.friction - problem.dilatancy_at(n), problem.cohesion)
    energy = float(limits.at(n[problem.sliding]) @ problem.slip(state.p))
    has_resistance = problem.dead.any() or problem.face_cohesion.any()
    return not has_resistance or energy <= EQUALITY_TOLERANCE * abs(state.load_factor) * problem.live_norm


def diverges(load_factors: Sequence[float]) -> bool:
    """Return True if the loop diverges: its load factor grows without bound.

    The load factor counts as unbounded if it more than doubles several times in a row, or if it rises
    steadily to many times its first value. See the constants of this module.
    """

    def has_risen(rise: float, times: int) -> bool:
        """Return True if λ has risen by more than the fraction ``rise`` in each of the last ``times`` steps.

        A step leads from one sub-problem to the next. All load factors must be positive.
        """
        last = np.array(load_factors[-times - 1 :])
        return len(last) > times and last[0] > 0 and bool((last[1:] > (1 + rise) * last[:-1]).all())

    if has_risen(1, _MOST_DOUBLINGS):
        return True
    return (
        has_risen(_LEAST_STEADY_INCREASE, _MOST_STEADY_INCREASES)
        and load_factors[-1] > _DIVERGENCE_RATIO * load_factors[0] > 0
    )


def period(load_factors: Sequence[float], normal: Sequence[np.ndarray]) -> int:
    """Return the number of sub-problems in a cycle of the loop, or 0 if the loop does not repeat itself.

    In a cycle the load factors repeat twice, the normal forces repeat once, and the range of λ hardly
    shrinks. ``normal`` are the normal forces of the last sub-problems, up to ``LONGEST_PERIOD`` + 1 of them.
    """
    values = np.array(load_factors)
    largest = float(np.abs(normal[-1]).max())
    for length in range(2, LONGEST_PERIOD + 1):
        if len(values) < 3 * length + 1:
            break
        earlier, before, now = values[-3 * length :].reshape(3, length)
        drift = max(np.abs(now - before).max(), np.abs(before - earlier).max())
        forces_return = np.abs(normal[-1] - normal[-1 - length]).max() < 1e-2 * largest
        if drift < _LARGEST_CYCLE_DRIFT * np.ptp(now) and forces_return:
            return length
    return 0


def accurate_end(
    problem: Problem, state: State, near: float, solver: Solver, effort: Effort
) -> Answer | None:
    """Return an exact state with the mechanism of ``state`` and the load factor nearest to ``near``.

    ``state`` is the solution of an accurate sub-problem. None is returned if no forces bring the faces with
    nonzero rates to yield. None is also returned if forces and mechanism do not form one collapse state.
    """
    scaled = in_units_of_live_load(problem)
    for share in _MOVING_RATE_SHARES:
        at_yield = state.p > share * state.p.max()
        model = CvxpyAtYield(scaled.problem, at_yield, near / scaled.load_factor)
        if has_optimum(model.program, in_cvxpy(solver), effort, _EXACT_END_PURPOSE):
            load_factor, q = model.statics.forces()
            end = _belonging(problem, scaled.load_factor * load_factor, q, state.d)
            if end:
                return end
    return None


def rough_end(problem: Problem, state: State, solver: Solver, effort: Effort) -> Answer | None:
    """Return an exact state near a sub-problem's inaccurate solution, or None if no state is found.

    None of the rates of this solution is exactly zero, so it is not known which faces yield. The first
    program finds forces of low λ that leave little energy z·p for the rates of the solution. The second
    program finds the mechanism of the true flow rule that leaves least energy for these forces. If the second
    program has no optimum, the mechanism of the sub-problem is used.
    """
    scaled = in_units_of_load(problem.by_cone)
    solver = in_cvxpy(solver, scaled.problem.by_friction.conic)
    programs = ExactPrograms(scaled, [solver], effort, _EXACT_END_PURPOSE, nearly=False)
    forces = programs.forces(state.p)
    if forces is None:
        return None
    load_factor, q = forces
    d = programs.motion(q)
    d = state.d if d is None else d
    return _belonging(problem, scaled.load_factor * load_factor, scaled.force * q, d)


def belong_together(problem: Problem, answer: Answer) -> bool:
    """Return True if the forces and the mechanism of an answer form one collapse state.

    For this, the energy z·p must not exceed ``MOST_ENERGY``, relative to λ, and the violation of the flow
    rule must be within the limit for answers of the loop.
    """
    largest_energy = MOST_ENERGY * problem.load_factor_scale.divisor(answer.load_factor)
    certificate = answer.certificate
    return certificate.complementarity <= largest_energy and certificate.flow <= LIMITS[Kind.LOOP].flow


def _belonging(problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray) -> Answer | None:
    """Return an answer from forces and velocities if they form one collapse state, otherwise None."""
    answer = certified(problem.by_cone, load_factor, q, d)
    return answer if belong_together(problem, answer) else None

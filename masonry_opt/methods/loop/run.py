"""One run of the loop, from its first sub-problem to its end: the record of each, and when it stops."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np

from masonry_opt.answer.acceptance import LIMITS, MOST_ENERGY, SMALLEST, Kind
from masonry_opt.answer.answer import Answer, Found, certified
from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import SAME
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.alternation import ExactPrograms
from masonry_opt.methods.loop.options import Attempt
from masonry_opt.methods.loop.steps import SubProblem, corrected, sub_problems
from masonry_opt.models.cvxpy_exact import CvxpyAtYield
from masonry_opt.problem.problem import Problem, ShearLimits, State, in_units_of_live_load, in_units_of_load
from masonry_opt.solvers.cvxpy_engine import has_optimum
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import Solved, Solver, in_cvxpy

#: Energy by which sliding joints are off the true law, over λ, below which an early end is tried (on façades
#: 1e-3 takes two to three times the sub-problems; what is found must leave no more than MOST_ENERGY), and so
#: many sub-problems pass before the next.
_NEARLY_TRUE, _PAUSE = 5e-3, 2

#: The loop diverges if λ more than doubles so often in a row; or rises by so much at a time, so often in a
#: row, to so many times where it began.
_DOUBLINGS = 5
_RISE, _RISES, _GROWN = 1e-2, 30, 1e3

#: Longest cycle looked for, and the drift from one to the next, over its swing, that still is one.
LONGEST_PERIOD = 6
_STEADY = 0.05

#: Share of the largest rate above which a face moves: the first is above what solvers leave of a zero; the
#: second is tried where that leads to no end, as in cycles of the atlas.
_SHARES = (1e-6, 1e-4)
_PURPOSE = "exact end"  #: What a solver does here, as a result tells it.


@dataclass(frozen=True)
class Iteration:
    """One sub-problem of the loop."""

    iteration: int
    load_factor: float  #: λ of the sub-problem, uncorrected
    alpha: float  #: slope of its shear limit over μ (NaN for the first)
    change: float  #: largest change of a normal force since the last one, in median block weights
    violation: float  #: largest violation of the true Coulomb law, in median block weights
    raising: float  #: work against the dead load, in units of λ (paper, Fig. 12)
    sliding: float  #: energy dissipated in the sub-problem's sliding, in units of λ
    #: The same slips against the true law's shear limit (the paper's corrected energy), in units of λ.
    coulomb_sliding: float
    #: Energy by which sliding joints are off the true law (the small cohesion apart), each counted for
    #: itself, in units of λ.
    mismatch: float
    seconds: float  #: the solver's time
    attempt: int  #: number of the run of the loop
    remedy: str  #: the option that was changed for it
    solved: SubProblem | None = field(default=None, repr=False)  #: the sub-problem; not kept in a history


def _recorded(problem: Problem, last: SubProblem, before: State | None, attempt: Attempt) -> Iteration:
    """The record of a sub-problem, given the state before it."""
    state, limits = last.state, last.limits
    n, slip = problem.normal_forces(state.q), problem.slip(state.p)
    coulomb = ShearLimits.true(problem).at(n[problem.sliding])
    limit = limits.at(n[problem.sliding]) - last.small_cohesion
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
    """A run of the loop; of its driver, of a static model, the shear limits alone are changed."""

    def __init__(self, problem: Problem, driver: Driver, attempt: Attempt) -> None:
        self.problem, self.driver, self.attempt = problem, driver, attempt
        self.parameters = attempt.parameters
        kind = Kind.LOOP if self.parameters.finish else Kind.BARE_LOOP
        self.ending = Solution(Status.ITERATION_LIMIT, kind)
        self.load_factors: list[float] = []
        self.states: deque[State] = deque(maxlen=LONGEST_PERIOD + 1)
        self.next_try = 0
        #: Whether it ends as soon as there is an exact state.
        self.early = self.parameters.finish and self.parameters.tolerance is not None
        #: Whether the first load factor is the associative one: rough sub-problems end up to .4 % from it.
        self.first_is_associative = self.parameters.start == "associative" and not self.parameters.tolerance

    def follow(self, progress: Callable[[Iteration], None]) -> Solution:
        """Follow the loop to its end."""
        problem, steps = self.problem, sub_problems(self.problem, self.driver, self.parameters)
        for last in islice(steps, self.parameters.max_iterations):
            if isinstance(last, Solved):
                return self._without_optimum(last)
            entry = _recorded(problem, last, self.states[-1] if self.states else None, self.attempt)
            state = last.state
            self.states.append(state)
            self.load_factors.append(state.load_factor)
            found = Found(q=state.q, d=state.d, slope=problem.dilatancy, forms=problem.forms)
            history = (*self.ending.history, replace(entry, solved=None))
            associative = self.load_factors[0] + 0.0 if self.first_is_associative else None
            self.ending = replace(self.ending, found=found, history=history, associative=associative)
            progress(entry)
            if ended := self._nothing_to_do(last) if last.number == 1 else self._ended(last, entry):
                return ended
        late = self.load_factors[-LONGEST_PERIOD:]
        told = {"count": len(self.load_factors), "lowest": min(late), "highest": max(late)}
        return self.ending.telling(reason(Code.STILL_CHANGES, **told))

    def _without_optimum(self, last: Solved) -> Solution:
        number, none = len(self.load_factors) + 1, replace(self.ending, found=Found())
        if number == 1 or last.failed:
            return none.ended(Status.SOLVER_FAILED, Code.SUB_PROBLEM_FAILED, number=number, word=last.status)
        return none.ended(Status.NO_STATE, Code.SUB_PROBLEM_EMPTY, number=number)

    def _nothing_to_do(self, last: SubProblem) -> Solution | None:
        """The first answer where it is the last: the associative one obeys the joints' own flow rule."""
        parameters, state = self.parameters, last.state
        if parameters.start != "associative" or parameters.always or not obeys_own_flow(self.problem, state):
            return None
        found = certified(self.problem, state.load_factor, state.q, state.d)
        ended = replace(self.ending, found=found, flow_rule_matters=False)
        return ended.ended(Status.CONVERGED, Code.FLOW_RULE_IDLE)

    def _ended(self, last: SubProblem, entry: Iteration) -> Solution | None:
        """Step 3, and the other ways in which a run ends; None while it goes on."""
        parameters = self.parameters
        if last.alpha <= parameters.alpha_min:
            nearly = self.early and entry.mismatch <= _NEARLY_TRUE * abs(entry.load_factor)
            # Only runs that may end early pause between their tries: the others end where λ stands still.
            if (nearly or last.stands_still) and (last.number >= self.next_try or not self.early):
                if exact := self._exact_end(last):
                    return exact
                self.next_try = last.number + _PAUSE
            if last.stands_still and not self.early:
                return self._converged(last)
        if diverges(self.load_factors):
            values = {"load_factor": self.load_factors[-1], "count": len(self.load_factors)}
            return self.ending.ended(Status.JAMMED, Code.GROWS, **values)
        normal = [self.problem.normal_forces(state.q) for state in self.states]
        if length := period(self.load_factors, normal):
            cycle, exact = self.load_factors[-length:], self._exact_end(last)
            told = {"lowest": min(cycle), "highest": max(cycle), "exact": exact is not None}
            ended = exact or replace(self.ending, status=Status.CYCLING)
            return ended.telling(reason(Code.REPEATS, period=length, **told))
        return None

    def _exact_end(self, last: SubProblem) -> Solution | None:
        """The end with exact forces on the mechanism, or on one near it."""
        if not self.parameters.finish:
            return None
        problem, state, solver, effort = self.problem, last.state, self.attempt.solver, self.driver.effort
        effort.begins("exact forces")
        end, roughly = None, self.parameters.tolerance is not None or problem.layout.round
        if not roughly:
            end = accurate_end(problem, state, corrected(problem, last), solver, effort)
        # Sliding of an accurate end contracts, which joints that crush explain by crushing.
        if roughly or (end is None and len(problem.crushing)):
            end = rough_end(problem, state, solver, effort)
        if end is None:
            return None
        return replace(self.ending, status=Status.CONVERGED, found=end, exact_end=True)

    def _converged(self, last: SubProblem) -> Solution:
        """The end where λ stood still, with step 6's correction."""
        state, ended, first = last.state, self.ending, self.load_factors[0]
        load_factor = corrected(self.problem, last)
        # No state with less dilatancy exceeds the associative load factor, where that is known.
        if self.first_is_associative and load_factor > first:
            ended = ended.telling(reason(Code.ABOVE_ASSOCIATIVE, by=load_factor - first))
            load_factor = first
        found = certified(self.problem, load_factor, state.q, state.d)
        return replace(ended, status=Status.CONVERGED, found=found)


def obeys_own_flow(problem: Problem, state: State) -> bool:
    """Whether an associative mechanism obeys the joints' own flow rule too: no energy goes into sliding."""
    n = problem.normal_forces(state.q)
    spared = ShearLimits(problem.friction - problem.dilatancy_at(n), problem.cohesion).at(n[problem.sliding])
    energy = float(spared @ problem.slip(state.p))
    # Where nothing weighs or coheres λ is zero by any flow, and both energies are rounding.
    weighs = problem.dead.any() or problem.face_cohesion.any()
    return not weighs or energy <= SAME * abs(state.load_factor) * problem.live_norm


def diverges(load_factors: Sequence[float]) -> bool:
    """Whether λ has more than doubled, or risen, time and again, to far beyond where it began."""

    def rose(by: float, times: int) -> bool:
        last = np.array(load_factors[-times - 1 :])
        return len(last) > times and last[0] > 0 and bool((last[1:] > (1 + by) * last[:-1]).all())

    return rose(1, _DOUBLINGS) or (rose(_RISE, _RISES) and load_factors[-1] > _GROWN * load_factors[0] > 0)


def period(load_factors: Sequence[float], normal: Sequence[np.ndarray]) -> int:
    """Length of the cycle that the loop is in, or 0: load factors came back twice, normal forces (of the last
    ``LONGEST_PERIOD`` + 1 sub-problems) once, and the swing hardly dies away."""
    values = np.array(load_factors)
    largest = float(np.abs(normal[-1]).max())
    for length in range(2, LONGEST_PERIOD + 1):
        if len(values) < 3 * length + 1:
            break
        earlier, before, now = values[-3 * length :].reshape(3, length)
        drift = max(np.abs(now - before).max(), np.abs(before - earlier).max())
        back = np.abs(normal[-1] - normal[-1 - length]).max() < 1e-2 * largest
        if drift < _STEADY * np.ptp(now) and back:
            return length
    return 0


def accurate_end(
    problem: Problem, state: State, near: float, solver: Solver, effort: Effort
) -> Answer | None:
    """The exact state of λ nearest to ``near`` on the mechanism of an accurate sub-problem, if any."""
    scaled = in_units_of_live_load(problem)
    for share in _SHARES:
        at_yield = state.p > share * state.p.max()
        model = CvxpyAtYield(scaled.problem, at_yield, near / scaled.load_factor)
        if has_optimum(model.program, in_cvxpy(solver), effort, _PURPOSE):
            load_factor, q = model.statics.forces()
            if end := _belonging(problem, scaled.load_factor * load_factor, q, state.d):
                return end
    return None


def rough_end(problem: Problem, state: State, solver: Solver, effort: Effort) -> Answer | None:
    """Forces of low λ that leave little energy z·p for the rates of a sub-problem solved roughly, none of
    which is zero; then the mechanism of the true flow rule that leaves least for them, or the
    sub-problem's."""
    scaled = in_units_of_load(problem.by_cone)
    solver = in_cvxpy(solver, scaled.problem.by_friction.conic)
    programs = ExactPrograms(scaled, [solver], effort, _PURPOSE, nearly=False)
    forces = programs.forces(state.p)
    if forces is None:
        return None
    load_factor, q = forces
    d = programs.motion(q)
    d = state.d if d is None else d
    return _belonging(problem, scaled.load_factor * load_factor, scaled.force * q, d)


def belong_together(answer: Answer) -> bool:
    """Whether the forces and the velocities of an answer belong together, but for MOST_ENERGY."""
    most = MOST_ENERGY * max(abs(answer.load_factor), SMALLEST)
    left = answer.certificate
    return left.complementarity <= most and left.flow <= LIMITS[Kind.LOOP].flow


def _belonging(problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray) -> Answer | None:
    answer = certified(problem.by_cone, load_factor, q, d)
    return answer if belong_together(answer) else None

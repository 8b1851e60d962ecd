"""One run of the loop of Gilbert, Casapulla & Ahmed (2006), section 4.2: linear programs whose shear
limits turn about the last normal forces until sliding neither dilates nor contracts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from masonry_opt.answer.acceptance import largest_acting, of_lesser_block
from masonry_opt.answer.solution import Finding, Iteration
from masonry_opt.answer.status import Status
from masonry_opt.methods.loop.exact_end import ExactForces, exact_finish, rough_finish
from masonry_opt.methods.loop.options import Parameters
from masonry_opt.problem.problem import Problem, ShearLimits, yield_slacks
from masonry_opt.problem.state import State
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.lp import Answer, Outcome

Progress = Callable[[Iteration], None]

#: Below this share of λ the energy of sliding cannot matter: the flow rule has no influence.
NO_INFLUENCE = 1e-6

#: How often a trial cohesion that carries no dead load is multiplied by four.
_TRIALS = 8

#: As often in a row must λ more than double for the loop to diverge.
_DOUBLINGS = 5

#: Or rises by so much at a time, as often in a row, to so many times where it began.
_RISE, _RISES, _GROWN = 1e-2, 30, 1e3

#: Longest cycle looked for, and the drift from one to the next, over its swing, that still is one.
_LONGEST_PERIOD = 6
_STEADY = 0.05

#: Energy by which sliding joints are off the true law, over λ, from which on an early end is tried (on
#: façades exact forces leave 3e-4 to 7e-4 of λ from there on, and 1e-3 takes two to three times the
#: sub-problems); after a failure so many sub-problems pass before the next.
_NEARLY_TRUE = 5e-3
_PAUSE = 2

#: Sub-problems for which a run goes on after λ stands still, while there is no exact state yet.
_PATIENCE = 30

#: So many times what acts on a block, forces elsewhere in its part are no measure for its joints.
_DWARFS = 1e3

#: Share of its limit from which on a joint counts as about to slide (section 6.4).
_ABOUT_TO_SLIDE = 1 - 1e-3


@dataclass(frozen=True)
class _Step:
    """A sub-problem's state, and what it was asked for."""

    state: State
    alpha: float
    slope: np.ndarray


def run_loop(
    problem: Problem, driver: Driver, parameters: Parameters, progress: Progress = lambda _: None
) -> tuple[Finding, Answer | None]:
    """Steps 1 to 6 on a static model declared with cohesion terms; only its shear limits are changed.

    ``progress`` is called after every sub-problem. The answer beside the finding is the one without an
    optimum that ended the run, if one did.
    """
    return _Run(problem, driver, parameters, progress).follow()


def first_limits(problem: Problem, parameters: Parameters) -> ShearLimits:
    """Step 1."""
    k = problem.sliding
    if parameters.start == "cohesive":
        return ShearLimits(np.zeros(len(k)), np.full(len(k), parameters.trial_cohesion))
    return ShearLimits(problem.friction[k], problem.cohesion[k])


class _Run:
    """The state of a run between its sub-problems."""

    def __init__(self, problem: Problem, driver: Driver, parameters: Parameters, progress: Progress) -> None:
        self.problem, self.driver, self.parameters, self.progress = problem, driver, parameters, progress
        self.finding = Finding(Status.ITERATION_LIMIT, slope=problem.dilatancy)
        self.limits = first_limits(problem, parameters)
        self.small_cohesion = np.zeros(len(problem.sliding))
        self.normal: list[np.ndarray] = []
        self.about: np.ndarray | None = None
        self.next_try = self.still_since = 0

    def follow(self) -> tuple[Finding, Answer | None]:
        parameters, finding = self.parameters, self.finding
        alpha, next_alpha = float("nan"), parameters.alpha
        for iteration in range(1, parameters.max_iterations + 1):
            answer = self._solve(iteration)
            if answer.state is None:
                return _without_optimum(finding, answer, iteration), answer
            step = self._record(answer.state, alpha, answer.seconds)
            if iteration == 1:
                largest = _largest_nearby(self.problem, answer.state)
                self.small_cohesion = parameters.c0 * largest[self.problem.sliding]
                if self._obeys_own_flow(answer.state):
                    return finding, None
            elif self._ended(step, iteration):
                return finding, None
            elif self._stands_still() and alpha > parameters.alpha_min:
                # Sliding would still contract by αμ: finish with the least slope.
                next_alpha = parameters.alpha_min

            # Steps 4 and 5: turn the shear limits about the (blended) normal forces.
            alpha = next_alpha
            above = alpha > parameters.alpha_min
            next_alpha = parameters.shrink * alpha if above else parameters.alpha_min
            self._turn(alpha)
        last = [entry.load_factor for entry in finding.history[-_LONGEST_PERIOD:]]
        finding.message = (
            f"λ still changes after {parameters.max_iterations} sub-problems, of late between "
            f"{min(last):.6g} and {max(last):.6g}: raise 'max_iterations', or lower 'beta'"
        )
        return finding, None

    def _solve(self, iteration: int) -> Answer:
        """Steps 2: the sub-problem with the present limits."""
        self.driver.set_shear_limits(self.limits)
        answer = self.driver.solve()
        if iteration == 1 and self.parameters.start == "cohesive":
            self.limits, answer = _raise_trial_cohesion(self.driver, self.limits, answer)
        self.finding.iterations += answer.iterations
        return answer

    def _record(self, state: State, alpha: float, seconds: float) -> _Step:
        self.finding.take(state)
        self.normal.append(state.q[0::3])
        entry = self._iteration(state, alpha, seconds)
        self.finding.history.append(entry)
        self.progress(replace(entry, state=state, limits=self.limits))
        return _Step(state, alpha, self.problem.dilatancy_at(self.normal[-1]))

    def _iteration(self, state: State, alpha: float, seconds: float) -> Iteration:
        problem, k, n = self.problem, self.problem.sliding, state.q[0::3]
        cohesion = np.zeros(len(k)) if self.limits.cohesion is None else self.limits.cohesion
        slip = (state.p[0] + state.p[1])[k]
        coulomb = problem.cohesion[k] + problem.friction[k] * n[k]
        at_yield = cohesion + self.limits.slope * n[k] - self.small_cohesion
        change = np.abs(self.normal[-1] - self.normal[-2]).max() if len(self.normal) > 1 else float("nan")
        return Iteration(
            iteration=len(self.normal),
            load_factor=state.load_factor,
            alpha=alpha,
            change=float(change),
            violation=float(max(-yield_slacks(problem, state.q).min(), 0.0)),
            raising=float(-problem.dead @ state.d) / problem.live_norm,
            sliding=float(cohesion @ slip) / problem.live_norm,
            coulomb_sliding=float(coulomb @ slip) / problem.live_norm,
            mismatch=float(np.abs(at_yield - coulomb) @ slip) / problem.live_norm,
            seconds=seconds,
        )

    def _obeys_own_flow(self, state: State) -> bool:
        """Whether the first answer is the last: the associative one obeys the joints' own flow rule."""
        if self.parameters.start != "associative" or self.parameters.always:
            return False
        if not _no_influence(self.problem, state):
            return False
        finding = self.finding
        finding.flow_rule_matters = False
        finding.status, finding.load_factor = Status.CONVERGED, state.load_factor
        finding.slope = self.problem.dilatancy_at(self.normal[-1])
        finding.message = (
            "the flow rule has no influence: the associative answer already obeys the joints' "
            "own (option 'always' looks for a lower one all the same)"
        )
        return True

    def _ended(self, step: _Step, iteration: int) -> bool:
        """Step 3, and the other ways in which a run ends; writes them to the finding."""
        parameters, finding = self.parameters, self.finding
        load_factors = [entry.load_factor for entry in finding.history]
        if step.alpha <= parameters.alpha_min:
            early = parameters.early and self._nearly_true()
            still = self._stands_still()
            # Only runs that may end early pause between their tries: the others stand still first.
            tried = (early or still) and (iteration >= self.next_try or not parameters.early)
            self.still_since = self.still_since or (iteration if still else 0)
            waited = self.still_since and iteration - self.still_since >= _PATIENCE
            if tried and self._finish(step):
                return True
            if (still and not parameters.finish) or (waited and not parameters.early):
                return self._converged(step)
            if tried:
                self.next_try = iteration + _PAUSE
        if _diverges(load_factors):
            finding.status = Status.JAMMED
            finding.message = (
                f"the load factor grows without end ({load_factors[-1]:.3g} after {iteration} "
                "sub-problems) as sliding ceases to contract: friction that grows with the load holds or "
                "wedges the blocks, and real ones would crush or break first; check the direction of "
                "'live', and supports and friction of the joints named"
            )
            return True
        if period := _period(load_factors, self.normal):
            cycle = load_factors[-period:]
            words = (
                f"the loop repeats itself every {period} iterations, between load factors "
                f"{min(cycle):.6g} and {max(cycle):.6g}"
            )
            if self._finish(step):
                finding.message += f"; {words}, and this state is exact"
                return True
            finding.status = Status.CYCLING
            finding.message = f"{words}: lower 'beta'"
            return True
        return False

    def _stands_still(self) -> bool:
        """Step 3: whether λ hardly changed."""
        if len(self.finding.history) < 2:
            return False
        before, now = (entry.load_factor for entry in self.finding.history[-2:])
        return abs(now - before) < self.parameters.tol * abs(now)

    def _nearly_true(self) -> bool:
        last = self.finding.history[-1]
        return last.mismatch <= _NEARLY_TRUE * abs(last.load_factor)

    def _corrected(self, state: State) -> float:
        """Step 6: λ less what the small cohesion dissipates."""
        slip = (state.p[0] + state.p[1])[self.problem.sliding]
        return state.load_factor - float(self._revised_cohesion() @ slip) / self.problem.live_norm

    def _revised_cohesion(self) -> np.ndarray:
        return np.where(self._revised(), self.small_cohesion, 0.0)

    def _revised(self) -> np.ndarray:
        """Joints that dilate at their friction angle are associative: their limits stay as they are."""
        k = self.problem.sliding
        return self.problem.dilatancy_at(self.normal[-1])[k] < self.problem.friction[k]

    def _finish(self, step: _Step) -> bool:
        """Whether exact forces on the mechanism, or on one near it, end the run."""
        if not self.parameters.finish:
            return False
        problem, state, watch = self.problem, step.state, self.driver.watch
        if self.parameters.tolerance is not None:
            exact, solves = rough_finish(problem, state, watch)
        else:
            exact, solves = exact_finish(problem, state, self._corrected(state), watch)
        self.finding.lp_solves += solves
        if exact is None:
            return False
        self._take_exact(exact)
        return True

    def _take_exact(self, exact: ExactForces) -> None:
        finding = self.finding
        finding.status, finding.load_factor = Status.CONVERGED, exact.load_factor
        finding.q, finding.d, finding.slope, finding.exact_end = exact.q, exact.d, exact.slope, True
        finding.message = f"in {len(finding.history)} sub-problems, with an exact state on their mechanism"

    def _converged(self, step: _Step) -> bool:
        finding, corrected = self.finding, self._corrected(step.state)
        finding.status, finding.load_factor, finding.slope = Status.CONVERGED, corrected, step.slope
        finding.message = f"in {len(finding.history)} sub-problems"
        if self.parameters.finish:
            finding.message += "; no state on their mechanism is exact: the certificate says what is left"
        if not self._stands_still():
            finding.message += "; λ stood still and changes again"
        bound = self._bound()
        if corrected > bound:
            finding.load_factor = bound
            finding.message += f"; ended {corrected - bound:.1e} above the associative bound, reported here"
        return True

    def _bound(self) -> float:
        """The associative load factor, which no state with less dilatancy exceeds; inf where unknown."""
        known = self.parameters.start == "associative" and self.parameters.tolerance is None
        return self.finding.history[0].load_factor if known else float("inf")

    def _turn(self, alpha: float) -> None:
        """Steps 4 and 5: the next shear limits."""
        problem, parameters, k = self.problem, self.parameters, self.problem.sliding
        before = self.normal[-2] if len(self.normal) > 1 else self.normal[-1]
        blend = parameters.beta * self.normal[-1] + (1 - parameters.beta) * before
        if parameters.move_limit is not None and self.about is not None:
            most = parameters.move_limit * (np.abs(self.about) + np.abs(self.about).mean())
            blend = np.clip(blend, self.about - most, self.about + most)
        self.about = blend
        mu, dilatancy = problem.friction[k], problem.dilatancy_at(blend)[k]
        revised = dilatancy < mu
        slope = np.where(revised, dilatancy - alpha * mu, mu)
        turned = problem.cohesion[k] + np.where(revised, self.small_cohesion + (mu - slope) * blend[k], 0.0)
        if parameters.only_at_yield and self.limits.cohesion is not None:
            q = self.finding.q
            assert q is not None  # a sub-problem was solved
            limit = self.limits.cohesion + self.limits.slope * q[0::3][k]
            keeps = np.abs(q[1::3][k]) < _ABOUT_TO_SLIDE * limit
            slope = np.where(keeps, self.limits.slope, slope)
            turned = np.where(keeps, self.limits.cohesion, turned)
        self.limits = ShearLimits(slope, turned)


def _raise_trial_cohesion(driver: Driver, limits: ShearLimits, answer: Answer) -> tuple[ShearLimits, Answer]:
    """The trial cohesion is arbitrary: raise it while it is too small to carry the dead load."""
    for _ in range(_TRIALS):
        if answer.outcome is not Outcome.NO_EQUILIBRIUM or limits.cohesion is None:
            break
        limits = ShearLimits(limits.slope, 4 * limits.cohesion)
        driver.set_shear_limits(limits)
        answer = driver.solve()
    return limits, answer


def _largest_of_part(problem: Problem, n: np.ndarray) -> np.ndarray:
    """Largest normal force of the part of the scene that each joint belongs to, shape (c,)."""
    largest = np.zeros(problem.part.max() + 1)
    np.maximum.at(largest, problem.part, n)
    return largest[problem.part]


def _largest_nearby(problem: Problem, state: State) -> np.ndarray:
    """The same, as far as it does not dwarf what acts on the joint's own blocks, shape (c,): the small
    cohesion must be small for each."""
    own = of_lesser_block(problem, largest_acting(problem, state.load_factor, state.q))
    return np.minimum(_largest_of_part(problem, state.q[0::3]), _DWARFS * own)


def _without_optimum(finding: Finding, answer: Answer, iteration: int) -> Finding:
    finding.q = finding.d = None
    if answer.outcome is Outcome.FAILED or iteration == 1:
        finding.status = Status.SOLVER_FAILED
        finding.message = f"sub-problem {iteration} ended with '{answer.word}': try another solver"
    else:
        finding.status = Status.NO_STATE
        finding.message = (
            f"sub-problem {iteration} has no equilibrium state: joints that lost their normal force "
            "have locked; use an interior-point solver, or lower 'alpha'"
        )
    return finding


def _no_influence(problem: Problem, state: State) -> bool:
    """Whether sliding takes no part in the energy of the associative mechanism."""
    k = problem.sliding
    slip = (state.p[0] + state.p[1])[k]
    n = state.q[0::3]
    spared = (problem.friction - problem.dilatancy_at(n))[k] * n[k] + problem.cohesion[k]
    return bool((spared * slip).sum() <= NO_INFLUENCE * abs(state.load_factor) * problem.live_norm)


def _diverges(load_factors: list[float]) -> bool:
    """Whether λ has more than doubled, or risen, time and again, to far beyond where it began."""

    def rose(by: float, times: int) -> bool:
        last = np.array(load_factors[-times - 1 :])
        return len(last) > times and last[0] > 0 and bool((last[1:] > (1 + by) * last[:-1]).all())

    return rose(1, _DOUBLINGS) or (rose(_RISE, _RISES) and load_factors[-1] > _GROWN * load_factors[0] > 0)


def _period(load_factors: list[float], normal: list[np.ndarray]) -> int:
    """Length of the cycle the loop is in, or 0: load factors and normal forces came back twice, and
    the swing hardly dies away."""
    values = np.array(load_factors)
    largest = float(np.abs(normal[-1]).max())
    for period in range(2, _LONGEST_PERIOD + 1):
        if len(values) < 3 * period + 1:
            break
        earlier, before, now = values[-3 * period :].reshape(3, period)
        drift = max(np.abs(now - before).max(), np.abs(before - earlier).max())
        back = np.abs(normal[-1] - normal[-1 - period]).max() < 1e-2 * largest
        if drift < _STEADY * np.ptp(now) and back:
            return period
    return 0

"""The loop of Gilbert, Casapulla & Ahmed (2006), section 4.2: linear programs whose shear limits
turn about the last normal forces until sliding neither dilates nor contracts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, Strict

from masonry_opt.analysis.diagnosis import explain_no_answer
from masonry_opt.analysis.finding import Finding, Iteration
from masonry_opt.analysis.status import Status
from masonry_opt.models.interface import State
from masonry_opt.problem.problem import Problem, ShearLimits, yield_slacks
from masonry_opt.scene.blocks import Number, Positive, Record
from masonry_opt.solvers.answer import Answer, Outcome
from masonry_opt.solvers.driver import Driver, declare
from masonry_opt.solvers.registry import Solver
from masonry_opt.timing import Stopwatch

Progress = Callable[[Iteration], None]

#: Below this share of λ the energy of sliding cannot matter: the flow rule has no influence.
NO_INFLUENCE = 1e-6

#: Share of α with which the loop begins again.
_LESS_SLOPE = 1 / 3

#: How often a trial cohesion that carries no dead load is multiplied by four.
_TRIALS = 8

#: As often in a row must λ more than double for the loop to diverge.
_DOUBLINGS = 5

#: Longest cycle looked for, and the drift from one to the next, over its swing, that still is one.
_LONGEST_PERIOD = 6
_STEADY = 0.05


class LoopOptions(Record):
    """Parameters of the loop, with the paper's defaults (section 5).

    Attributes
    ----------
    alpha: slope of the contracting shear limit over μ, at first; halved every iteration.
    alpha_min: from there on the slope stays at this value (the last halving may undershoot it once).
    beta: weight of the newest normal forces against those before, 0 < beta ≤ 1.
    tol: relative change of λ at which the loop stops.
    c0: small cohesion, as a fraction of the largest normal force of the first sub-problem (of each
        part of the scene that stands by itself).
    start: first sub-problem: "associative", or "cohesive" (|s| ≤ trial_cohesion).
    trial_cohesion: of the cohesive start, in median block weights; raised while no state exists.
    max_iterations: sub-problems before the loop gives up.
    always: run the loop even where the associative answer obeys the joints' own flow rule: a lower
        load factor may exist elsewhere in the scene.

    Raises
    ------
    pydantic.ValidationError
        If a parameter is of the wrong type or out of range.
    """

    alpha: Annotated[Number, Field(ge=0, le=10)] = 0.3
    alpha_min: Annotated[Number, Field(ge=0, le=10)] = 0.001
    beta: Annotated[Number, Field(gt=0, le=1)] = 0.6
    tol: Annotated[Number, Field(gt=0, lt=1)] = 1e-5
    c0: Annotated[Number, Field(ge=0, lt=1)] = 1e-5
    start: Literal["associative", "cohesive"] = "associative"
    trial_cohesion: Positive = 1.0
    max_iterations: Annotated[int, Strict(), Field(ge=1)] = 200
    always: Annotated[bool, Strict()] = False


def nonassociative(
    problem: Problem,
    solver: Solver,
    watch: Stopwatch,
    options: LoopOptions,
    progress: Progress = lambda _: None,
) -> Finding:
    """Load factor with the joints' own flow rule (Coulomb: no dilatancy), of a scene that stands.

    Steps 1 to 6 of section 4.2. Where dilatancy locks the associative start, the loop starts
    cohesive instead (section 6.3); where a sub-problem has no state, it begins again with less
    slope. The message says so. ``progress`` is called after every sub-problem.
    """
    # Cohesion terms are declared even where the joints have none: steps 4 and 5 need them.
    driver = declare(problem, "static", solver, watch, _first_limits(problem, options))
    finding, answer = run_loop(problem, driver, options, progress)
    notes: list[str] = []
    if not finding.history and answer is not None:
        finding.status, finding.message = explain_no_answer(problem, answer)
        if finding.status is Status.LOCKED and options.start == "associative":
            options = options.model_copy(update={"start": "cohesive"})
            finding, _ = run_loop(problem, driver, options, progress)
            notes.append("dilatancy locks the associative start, so the loop started cohesive")
    while finding.status is Status.NO_STATE and options.alpha > options.alpha_min:
        # A contracting limit |s| ≤ c - αμn also caps n at c / (αμ): less slope, less of a cap.
        options = options.model_copy(update={"alpha": options.alpha * _LESS_SLOPE})
        iterations = finding.iterations
        finding, _ = run_loop(problem, driver, options, progress)
        finding.iterations += iterations
        notes.append(f"a sub-problem had no state, so the loop began again with alpha = {options.alpha:.2g}")
    finding.message = "; ".join([*notes[-2:], finding.message])
    finding.lp_solves, finding.size = driver.solves, driver.size()
    return finding


def run_loop(
    problem: Problem, driver: Driver, options: LoopOptions, progress: Progress = lambda _: None
) -> tuple[Finding, Answer | None]:
    """The loop on a static model declared with cohesion terms; only its shear limits are changed.

    The answer beside the finding is the one without an optimum that ended the loop, if one did.
    """
    k = problem.sliding
    mu, dilatancy = problem.friction[k], problem.dilatancy[k]
    # Joints that dilate at their friction angle are associative: their limits stay as they are.
    revised = dilatancy < mu
    limits, small_cohesion = _first_limits(problem, options), np.zeros(len(k))
    finding = Finding(Status.ITERATION_LIMIT, slope=problem.dilatancy)
    normal: list[np.ndarray] = []
    alpha, next_alpha = float("nan"), options.alpha

    for iteration in range(1, options.max_iterations + 1):
        driver.set_shear_limits(limits)
        answer = driver.solve()
        if iteration == 1 and options.start == "cohesive":
            limits, answer = _raise_trial_cohesion(driver, limits, answer)
        finding.iterations += answer.iterations
        state = answer.state
        if state is None:
            return _without_optimum(finding, answer, iteration), answer
        finding.take(state)
        normal.append(state.q[0::3])
        step = _record(problem, state, limits, alpha, normal, answer.seconds)
        progress(replace(step, state=state, limits=limits))
        finding.history.append(step)

        load_factors = [entry.load_factor for entry in finding.history]
        if iteration == 1:
            small_cohesion = options.c0 * _largest_of_part(problem, normal[0])[k]
            associative = options.start == "associative"
            if associative and not options.always and _no_influence(problem, state):
                message = (
                    "the flow rule has no influence: the associative answer already obeys the joints' "
                    "own (option 'always' looks for a lower one all the same)"
                )
                finding.flow_rule_matters = False
                finding.status, finding.load_factor = Status.CONVERGED, state.load_factor
                finding.message = message
                return finding, None
        elif abs(load_factors[-1] - load_factors[-2]) < options.tol * abs(load_factors[-1]):
            if alpha > options.alpha_min:
                # Sliding would still contract by αμ: finish with the least slope.
                next_alpha = options.alpha_min
            else:
                return _converged(finding, options, state, problem, small_cohesion * revised), None
        elif _diverges(load_factors):
            finding.status = Status.JAMMED
            finding.message = (
                f"the load factor grows without end ({load_factors[-1]:.3g} after {iteration} "
                "sub-problems) as sliding ceases to contract: friction wedges the blocks"
            )
            return finding, None
        elif period := _period(load_factors, normal):
            cycle = load_factors[-period:]
            finding.status = Status.CYCLING
            finding.message = (
                f"the loop repeats itself every {period} iterations, between load factors "
                f"{min(cycle):.6g} and {max(cycle):.6g}: lower 'beta'"
            )
            return finding, None

        # Steps 4 and 5: turn the shear limits about the (blended) normal forces.
        alpha = next_alpha
        next_alpha = alpha / 2 if alpha > options.alpha_min else options.alpha_min
        before = normal[-2] if iteration > 1 else normal[-1]
        blend = options.beta * normal[-1] + (1 - options.beta) * before
        slope = np.where(revised, dilatancy - alpha * mu, mu)
        turned = small_cohesion + (mu - slope) * blend[k]
        limits = ShearLimits(slope, problem.cohesion[k] + np.where(revised, turned, 0.0))
    finding.message = (
        f"λ still changes after {options.max_iterations} sub-problems: raise 'max_iterations', or "
        "lower 'beta'"
    )
    return finding, None


def _first_limits(problem: Problem, options: LoopOptions) -> ShearLimits:
    """Step 1."""
    k = problem.sliding
    if options.start == "cohesive":
        return ShearLimits(np.zeros(len(k)), np.full(len(k), options.trial_cohesion))
    return ShearLimits(problem.friction[k], problem.cohesion[k])


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


def _converged(
    finding: Finding,
    options: LoopOptions,
    state: State,
    problem: Problem,
    small_cohesion: np.ndarray,
) -> Finding:
    """Step 6: take off what the small cohesion dissipates."""
    slip = (state.p[0] + state.p[1])[problem.sliding]
    corrected = state.load_factor - float(small_cohesion @ slip) / problem.live_norm
    finding.status, finding.load_factor = Status.CONVERGED, corrected
    finding.message = f"in {len(finding.history)} sub-problems"
    bound = finding.history[0].load_factor
    if options.start == "associative" and corrected > bound:
        # No state with less dilatancy exceeds the associative load factor.
        finding.load_factor = bound
        finding.message += f"; ended {corrected - bound:.1e} above the associative bound, which is reported"
    return finding


def _no_influence(problem: Problem, state: State) -> bool:
    """Whether sliding takes no part in the energy of the associative mechanism."""
    k = problem.sliding
    slip = (state.p[0] + state.p[1])[k]
    spared = (problem.friction - problem.dilatancy)[k] * state.q[0::3][k] + problem.cohesion[k]
    return bool((spared * slip).sum() <= NO_INFLUENCE * abs(state.load_factor) * problem.live_norm)


def _record(
    problem: Problem,
    state: State,
    limits: ShearLimits,
    alpha: float,
    normal: list[np.ndarray],
    seconds: float,
) -> Iteration:
    k = problem.sliding
    cohesion = np.zeros(len(k)) if limits.cohesion is None else limits.cohesion
    slip = (state.p[0] + state.p[1])[k]
    n = state.q[0::3]
    coulomb = problem.cohesion[k] + problem.friction[k] * n[k]
    change = np.abs(normal[-1] - normal[-2]).max() if len(normal) > 1 else float("nan")
    return Iteration(
        iteration=len(normal),
        load_factor=state.load_factor,
        alpha=alpha,
        change=float(change),
        violation=float(max(-yield_slacks(problem, state.q).min(), 0.0)),
        raising=float(-problem.dead @ state.d) / problem.live_norm,
        sliding=float(cohesion @ slip) / problem.live_norm,
        coulomb_sliding=float(coulomb @ slip) / problem.live_norm,
        seconds=seconds,
    )


def _diverges(load_factors: list[float]) -> bool:
    """Whether λ has more than doubled time and again, to far beyond where it began."""
    last = np.array(load_factors[-_DOUBLINGS - 1 :])
    if len(last) <= _DOUBLINGS or last[0] <= 0:
        return False
    return bool((last[1:] > 2 * last[:-1]).all())


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

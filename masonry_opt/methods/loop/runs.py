"""The non-associative load factor: runs of the loop, and what is tried where one fails."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

from masonry_opt.answer.acceptance import EXACT, FINISHED, IN_VAIN, failing_residuals, refused
from masonry_opt.answer.solution import Finding, Iteration
from masonry_opt.answer.status import Status
from masonry_opt.effort import Stopwatch
from masonry_opt.explain.diagnosis import explain_no_answer
from masonry_opt.methods.loop.exact_end import leaves_little
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.loop.remedies import REMEDIES, Attempt, Doubt, Remedy, less_slope
from masonry_opt.methods.loop.steps import Progress, first_limits, run_loop
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.driver import Driver, declare
from masonry_opt.solvers.load_units import DriverInUnitsOfLoad
from masonry_opt.solvers.registry import Solver, rougher

#: Runs of the loop after which a scene is given up.
_MOST_RUNS = 14


@dataclass(frozen=True)
class _Ran:
    """A run of the loop: what it worked with, what it found, and how it failed (None: it did not)."""

    attempt: Attempt
    finding: Finding
    failure: Status | Doubt | None


def nonassociative(
    problem: Problem,
    solver: Solver,
    watch: Stopwatch,
    options: LoopOptions,
    progress: Progress = lambda _: None,
) -> Finding:
    """Load factor with the joints' own flow rule (Coulomb: no dilatancy), of a scene that stands.

    Runs the loop; where a run fails, others follow with what ``REMEDIES`` lists for its failure, each
    recorded in the history and the message. ``progress`` is called after every sub-problem.
    """
    attempt = Attempt(options.parameters(problem.joints, solver.name), solver)
    runs: list[_Ran] = []
    left = {failure: list(remedies) for failure, remedies in REMEDIES.items()}
    driver: Driver | None = None
    solves = 0
    certified = _Certified(problem)

    def follow(step: Iteration) -> None:
        certified.see(step)
        progress(step)

    while True:
        if driver is None or _needs_another(attempt, runs[-1].attempt):
            solves += driver.solves if driver else 0
            driver = _declare(problem, attempt, watch)
        finding, answer = run_loop(
            problem, driver, attempt.parameters, _labelled(follow, attempt, len(runs) + 1)
        )
        if answer is not None and not finding.history:
            finding.status, finding.message = explain_no_answer(problem, answer)
        failure = _failure(problem, attempt, finding)
        if attempt.parameters.finish and (failing := failing_residuals(problem, finding, FINISHED)):
            finding, failure = refused(finding, failing), Doubt.INEXACT
        runs.append(_Ran(attempt, finding, failure))
        following = _next(runs, left, options)
        if following is None:
            break
        attempt = following
    for run in runs:
        if run.finding.status in (Status.CYCLING, Status.ITERATION_LIMIT):
            run.finding.message += f"; {certified}"
    finding = _gather(runs, options)
    if options.finish and (failing := failing_residuals(problem, finding, IN_VAIN)):
        finding = refused(finding, failing)
    finding.lp_solves += solves + driver.solves
    finding.size = driver.size()
    return finding


class _Certified:
    """The least load factor among the sub-problems' own that pass as exact answers."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.least = problem, inf

    def see(self, step: Iteration) -> None:
        """Certify a sub-problem's state under the joints' own flow rule."""
        state = step.state
        if state is None or state.load_factor >= self.least:
            return
        slope = self.problem.dilatancy_at(state.q[0::3])
        answer = Finding(Status.CONVERGED, "", state.load_factor, state.q, state.d, slope)
        if not failing_residuals(self.problem, answer, EXACT):
            self.least = state.load_factor

    def __str__(self) -> str:
        if self.least == inf:
            return "none of the load factors met is certified"
        return f"the lowest certified load factor met is {self.least:.6g}"


def _declare(problem: Problem, attempt: Attempt, watch: Stopwatch) -> Driver:
    tolerance = attempt.parameters.tolerance
    # Cohesion terms are declared even where the joints have none: steps 4 and 5 need them.
    limits = first_limits(problem, attempt.parameters)
    if tolerance is None:
        return declare(problem, "static", attempt.solver, watch, limits)
    return DriverInUnitsOfLoad(problem, "static", rougher(attempt.solver, tolerance), watch, limits)


def _needs_another(attempt: Attempt, last: Attempt) -> bool:
    return attempt.solver != last.solver or attempt.parameters.tolerance != last.parameters.tolerance


def _labelled(progress: Progress, attempt: Attempt, number: int) -> Progress:
    return lambda step: progress(replace(step, attempt=number, remedy=attempt.remedy))


def _gather(runs: list[_Ran], options: LoopOptions) -> Finding:
    """The finding of the last run if it decides the matter (or is the loop as it is, with less slope), else
    of the first with a load factor, else of the first; with the history of all."""
    answered = runs[-1].failure is None
    bare = options.remedies == "slope" and runs[-1].failure is not Status.NO_STATE
    kept = runs[-1] if answered or bare else next((run for run in runs if run.finding.status.usable), runs[0])
    finding, tried = kept.finding, [run.attempt.remedy for run in runs[1:]]
    if kept.failure is Status.LOCKED and tried:
        finding.message = (
            "sliding joints that dilate jam the blocks, so that they carry any multiple of the live load; "
            "without dilatancy they can move, but no run of the loop tells at which load"
        )
    if tried:
        words = f"the first run ended '{runs[0].failure}', so the loop began again {', then '.join(tried)}"
        finding.message = (
            f"{words}; {finding.message}" if answered or bare else f"{finding.message} ({words}: in vain)"
        )
    history = [
        replace(entry, attempt=number, remedy=run.attempt.remedy)
        for number, run in enumerate(runs, start=1)
        for entry in run.finding.history
    ]
    finding.iterations = sum(run.finding.iterations for run in runs)
    finding.lp_solves = sum(run.finding.lp_solves for run in runs)
    finding.history = history
    return finding


def _failure(problem: Problem, attempt: Attempt, finding: Finding) -> Status | Doubt | None:
    """How a run failed; None if what it found decides the matter."""
    if not finding.status.usable:
        return None if finding.status is Status.JAMMED else finding.status
    if not finding.flow_rule_matters:
        return None if attempt.parameters.tolerance is None else Doubt.ROUGH
    if attempt.parameters.finish and _far_from_exact(problem, finding, attempt.parameters.tol):
        return Doubt.INEXACT
    return None


def _far_from_exact(problem: Problem, finding: Finding, tol: float) -> bool:
    """Whether more is left than the exact end allows: of energy of what moves without being at yield, or of
    departure from the flow rule (blocks that pass into each other); or λ still changes, by more than ``tol``
    relative, and no exact state was found on the way."""
    load_factor, q, d, slope = finding.load_factor, finding.q, finding.d, finding.slope
    assert load_factor is not None  # the run converged
    assert q is not None
    assert d is not None
    assert slope is not None
    if not leaves_little(problem, load_factor, q, d, slope):
        return True
    last = [entry.load_factor for entry in finding.history[-2:]]
    return not finding.exact_end and abs(last[-1] - last[0]) > tol * abs(last[-1])


def _next(runs: list[_Ran], left: dict[Status | Doubt, list[Remedy]], options: LoopOptions) -> Attempt | None:
    """What to try after the last run, taken from what is left; None if nothing is, or need not."""
    last = runs[-1]
    if last.failure is None or len(runs) >= _MOST_RUNS:
        return None
    remedies = left.get(last.failure, [])
    while remedies:
        remedy = remedies.pop(0)
        asked_for = {"all": True, "slope": remedy is less_slope, "none": False}[options.remedies]
        following = remedy(last.attempt) if asked_for or last.failure is Doubt.ROUGH else None
        if following is not None:
            return following
    return None

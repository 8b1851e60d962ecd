"""Method "nonassociative": runs of the loop, and what is tried where one fails."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

from masonry_opt.answer.acceptance import BORNE_OUT, residuals
from masonry_opt.answer.reasons import Code, Reason, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.explain.diagnosis import no_optimum
from masonry_opt.methods.loop.exact_end import belong_together
from masonry_opt.methods.loop.history import Iteration
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.loop.remedies import REMEDIES, Attempt, Remedy, Shortfall, less_slope
from masonry_opt.methods.loop.run import run
from masonry_opt.methods.loop.steps import LimitUpdate, first_limits
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import rougher

Failure = Status | Shortfall


@dataclass(frozen=True)
class _Ran:
    """A run of the loop: what it worked with, what it found, and how it failed (None: it did not)."""

    attempt: Attempt
    solution: Solution
    failure: Failure | None


def nonassociative(task: Task) -> Solution:
    """Load factor with the joints' own flow rule (Coulomb: no dilatancy).

    Runs the loop; where a run fails, others follow with what ``REMEDIES`` lists for its failure, each
    recorded in the history and the reasons.
    """
    problem, options = task.problem, task.options or LoopOptions()
    attempt = Attempt(options.parameters(problem.joints, task.solver), task.solver)
    runs: list[_Ran] = []
    left = {failure: list(remedies) for failure, remedies in REMEDIES.items()}
    driver: Driver | None = None
    borne_out = _LeastBorneOut(problem)

    def follow(step: Iteration) -> None:
        borne_out.see(step)
        task.progress(replace(step, attempt=len(runs) + 1, remedy=attempt.remedy))

    while True:
        if driver is None or _needs_another(attempt, runs[-1].attempt):
            driver = _declare(task, attempt)
        revise = options.revise or LimitUpdate.limits
        solution = run(problem, driver, attempt.parameters, attempt.solver, follow, revise)
        if not solution.history:
            word = solution.reasons[0].values["word"]
            solution.status, why = no_optimum(problem, word, attempt.solver, task.effort)
            solution.reasons = [why]
        runs.append(_Ran(attempt, solution, _failure(problem, attempt, solution)))
        following = _next(runs, left, options)
        if following is None:
            break
        attempt = following
    for ran in runs:
        if ran.solution.status in (Status.CYCLING, Status.ITERATION_LIMIT):
            ran.solution.reasons.append(borne_out.reason)
    solution = _gathered(problem, runs, options)
    solution.size = driver.size()
    return solution


class _LeastBorneOut:
    """The least load factor of a sub-problem whose state bears it out under the true law."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.least = problem, inf

    def see(self, step: Iteration) -> None:
        """Look at a sub-problem's state under the joints' own flow rule."""
        state = step.solved.state if step.solved else None
        if state is None or state.load_factor >= self.least:
            return
        slope = self.problem.dilatancy_at(self.problem.normal_forces(state.q))
        left = residuals(self.problem, state.load_factor, state.q, state.d, slope)
        if max(left.values()) <= BORNE_OUT:
            self.least = state.load_factor

    @property
    def reason(self) -> Reason:
        """It, for a reader; None if there is none."""
        return reason(Code.LEAST_BORNE_OUT, load_factor=None if self.least == inf else self.least)


def _declare(task: Task, attempt: Attempt) -> Driver:
    rough = attempt.parameters.tolerance
    solver = attempt.solver if rough is None else rougher(attempt.solver, rough)
    limits = first_limits(task.problem, attempt.parameters)
    # What is solved roughly is equally rough at every size in units of the load.
    of_load = rough is not None
    return task.kept.of(
        ("sub-problems", solver.key, of_load),
        task.problem,
        lambda: Driver(
            task.problem,
            "static",
            solver,
            task.effort,
            limits,
            of_load=of_load,
            purpose="sub-problems",
            repeats=True,
        ),
        lambda before: before.renew(limits, task.effort),
    )


def _needs_another(attempt: Attempt, last: Attempt) -> bool:
    return attempt.solver != last.solver or attempt.parameters.tolerance != last.parameters.tolerance


def _failure(problem: Problem, attempt: Attempt, solution: Solution) -> Failure | None:
    """How a run failed; None if what it found decides the matter."""
    if not solution.status.usable:
        return None if solution.status is Status.JAMMED else solution.status
    finish = attempt.parameters.finish
    if finish and solution.failing(problem):
        return Shortfall.INEXACT
    if not solution.flow_rule_matters:
        return None if attempt.parameters.tolerance is None else Shortfall.ROUGH
    inexact = finish and _far_from_exact(problem, solution, attempt.parameters.tol)
    return Shortfall.INEXACT if inexact else None


def _far_from_exact(problem: Problem, solution: Solution, tol: float) -> bool:
    """Whether more is left than the exact end allows: of energy of what moves without being at yield, or of
    departure from the flow rule (blocks that pass into each other); or λ still changes, by more than ``tol``
    relative, and no exact state was found on the way."""
    load_factor, q, d, slope = solution.load_factor, solution.q, solution.d, solution.slope
    assert load_factor is not None  # the run converged
    assert q is not None
    assert d is not None
    assert slope is not None
    if not belong_together(problem, load_factor, q, d, slope):
        return True
    last = [entry.load_factor for entry in solution.history[-2:]]
    return not solution.exact_end and abs(last[-1] - last[0]) > tol * abs(last[-1])


def _next(runs: list[_Ran], left: dict[Failure, list[Remedy]], options: LoopOptions) -> Attempt | None:
    """What to try after the last run, taken from what is left; None if nothing is, or need not."""
    last = runs[-1]
    if last.failure is None:
        return None
    remedies = left.get(last.failure, [])
    while remedies:
        remedy = remedies.pop(0)
        wanted = {"all": True, "slope": remedy is less_slope, "none": False}[options.remedies]
        following = remedy(last.attempt) if wanted or last.failure is Shortfall.ROUGH else None
        if following is not None:
            return following
    return None


def _gathered(problem: Problem, runs: list[_Ran], options: LoopOptions) -> Solution:
    """The solution of the last run if it decides the matter (or is the loop as it is, with less slope), else
    of the first whose load factor passes, else of the first; with the history of all."""
    last = runs[-1]
    decided = last.failure is None or (options.remedies == "slope" and last.failure is not Status.NO_STATE)
    passing = [ran for ran in runs if ran.solution.status.usable and not ran.solution.failing(problem)]
    kept = last if decided else next(iter([*passing, runs[0]]))
    solution, remedies = kept.solution, [ran.attempt.remedy for ran in runs[1:]]
    if remedies:
        if kept.failure is Status.LOCKED:
            solution.reasons = [reason(Code.LOCKED_ALL_THE_SAME)]
        again = reason(Code.BEGAN_AGAIN, first=str(runs[0].failure), remedies=remedies, in_vain=not decided)
        solution.reasons.insert(0 if decided else len(solution.reasons), again)
    solution.history = [
        replace(entry, attempt=number, remedy=ran.attempt.remedy)
        for number, ran in enumerate(runs, start=1)
        for entry in ran.solution.history
    ]
    return solution

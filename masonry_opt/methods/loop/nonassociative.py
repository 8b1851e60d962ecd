"""Method "nonassociative": runs of the loop, and what is tried where one fails."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from masonry_opt.answer.acceptance import BORNE_OUT
from masonry_opt.answer.answer import certified
from masonry_opt.answer.reasons import Code, Reason, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.methods.loop.options import Attempt, LoopOptions
from masonry_opt.methods.loop.run import Iteration, Run, belong_together
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import Solver, find_solver, rougher
from masonry_opt.standing.diagnosis import no_optimum


class Shortfall(StrEnum):
    """Why a load factor that a run converged to is not taken, while something is left to try."""

    INEXACT = "converged to no exact state"
    ROUGH = "converged roughly where the flow rule has no influence"


Failure = Status | Shortfall

#: What to work with after a run that worked with this; None if that was tried.
Remedy = Callable[[Attempt], Attempt | None]

_Left = dict[Failure | None, Iterator[Remedy]]  #: What is left to try, by failure.


def _accurately(last: Attempt) -> Attempt | None:
    """Sub-problems solved as exactly as any program: a rough answer proves little."""
    if last.parameters.tolerance is None:
        return None
    parameters = last.parameters.model_copy(update={"tolerance": None})
    return replace(last, parameters=parameters, remedy="sub_problems=accurate")


def less_slope(last: Attempt) -> Attempt | None:
    """A contracting limit |s| ≤ c − αμn also caps n at c / (αμ): a smaller slope raises the cap."""
    if last.parameters.alpha <= last.parameters.alpha_min:
        return None
    return _with(last, "alpha", last.parameters.alpha / 3)


def _more_damping(last: Attempt) -> Attempt | None:
    return _with(last, "beta", last.parameters.beta / 2)


def _cohesive_start(last: Attempt) -> Attempt | None:
    """Section 6.3: a start that dilatancy cannot lock."""
    return None if last.parameters.start == "cohesive" else _with(last, "start", "cohesive")


def _another_solver(last: Attempt) -> Attempt | None:
    name = "clarabel" if last.solver.name != "clarabel" else "highs-ipm"
    return replace(last, solver=find_solver("cvxpy", name), remedy=f"solver={name}")


def _with(last: Attempt, option: str, value: float | str) -> Attempt:
    word = value if isinstance(value, str) else f"{value:.2g}"
    parameters = last.parameters.model_copy(update={option: value})
    return replace(last, parameters=parameters, remedy=f"{option}={word}")


#: What is tried after each way to fail, in this order, each entry once: what answers a scene of the failure
#: atlas. (More small cohesion, or less, answered 3 of 193 scenes, all of which method "coulomb" solves.)
REMEDIES: dict[Failure, tuple[Remedy, ...]] = {
    Status.LOCKED: (_cohesive_start,),
    Status.NO_STATE: (*(less_slope,) * 5, _accurately),
    Status.CYCLING: (_accurately, _more_damping, _more_damping, _another_solver),
    Status.ITERATION_LIMIT: (_accurately,),
    Shortfall.INEXACT: (_accurately, _another_solver),
    Status.SOLVER_FAILED: (_accurately, _another_solver),
    Shortfall.ROUGH: (_accurately,),
}


@dataclass(frozen=True)
class _Ran:
    """A run of the loop: what it worked with, and what it found."""

    attempt: Attempt
    solution: Solution

    @property
    def failure(self) -> Failure | None:
        """How it failed; None if what it found decides the matter."""
        parameters, solution = self.attempt.parameters, self.solution
        if solution.answer is None:
            return None if solution.status is Status.JAMMED else solution.status
        if parameters.finish and solution.failing():
            return Shortfall.INEXACT
        if not solution.flow_rule_matters:
            return None if parameters.tolerance is None else Shortfall.ROUGH
        return Shortfall.INEXACT if parameters.finish and not belong_together(solution.answer) else None


def nonassociative(task: Task) -> Solution:
    """Load factor with the joints' own flow rule (Coulomb: no dilatancy).

    Where a run of the loop fails, others follow with what ``REMEDIES`` lists for its failure, each recorded
    in the history and the reasons.
    """
    given, options = task.problem, task.options or LoopOptions()
    attempt: Attempt | None = Attempt(options.parameters(given.joints, task.solver), task.solver)
    runs: list[_Ran] = []
    declared: tuple[Solver, float | None] | None = None
    left: _Left = {failure: iter(remedies) for failure, remedies in REMEDIES.items()}
    least: float | None = None  # of a sub-problem whose state bears it out under the joints' own flow rule

    def follow(step: Iteration) -> None:
        nonlocal least
        state = step.solved.state if step.solved else None
        if state and (least is None or state.load_factor < least):
            answer = certified(problem, state.load_factor, state.q, state.d)
            least = state.load_factor if max(answer.residuals.values()) <= BORNE_OUT else least
        task.progress(step)

    while attempt is not None:
        if declared != (attempt.solver, attempt.parameters.tolerance):
            declared = attempt.solver, attempt.parameters.tolerance
            problem = given.by_cone if attempt.solver.entry.conic else given
            driver = _declared(task, problem, *declared)
        solution = Run(problem, driver, attempt).follow(follow)
        if not solution.history:
            word = solution.reasons[0].values["word"]
            status, why = no_optimum(given, word, attempt.solver, task.effort)
            solution = replace(solution, status=status, reasons=(why,))
        runs.append(_Ran(attempt, solution))
        attempt = _next(runs, left, options)
    solution = _gathered(runs, options, reason(Code.LEAST_BORNE_OUT, load_factor=least))
    return replace(solution, size=driver.size())


def _declared(task: Task, problem: Problem, solver: Solver, tolerance: float | None) -> Driver:
    # What is solved roughly is equally rough at every size in units of the load.
    of_load = tolerance is not None
    solver = solver if tolerance is None else rougher(solver, tolerance)
    how: dict[str, Any] = {"of_load": of_load, "purpose": "sub-problems", "repeats": True}
    return task.kept.driver(problem, "static", solver, task.effort, **how)


def _next(runs: list[_Ran], left: _Left, options: LoopOptions) -> Attempt | None:
    """What to try after the last run, taken from what is left; None if nothing is, or need not."""
    last = runs[-1]
    for remedy in left.get(last.failure, ()):
        wanted = {"all": True, "slope": remedy is less_slope, "none": False}[options.remedies]
        following = remedy(last.attempt) if wanted or last.failure is Shortfall.ROUGH else None
        if following is not None:
            return replace(following, number=len(runs) + 1)
    return None


def _gathered(runs: list[_Ran], options: LoopOptions, least: Reason) -> Solution:
    """The solution of the last run if it decides the matter (or less slope alone was wanted), else of the
    first whose load factor passes, else of the first; with the history of all, and the least load factor met
    where it did not come to an end."""
    last = runs[-1]
    decided = last.failure is None or (options.remedies == "slope" and last.failure is not Status.NO_STATE)
    passing = [ran for ran in runs if ran.solution.answer and not ran.solution.failing()]
    kept = last if decided else next(iter([*passing, runs[0]]))
    solution, remedies = kept.solution, [ran.attempt.remedy for ran in runs[1:]]
    if solution.status in (Status.CYCLING, Status.ITERATION_LIMIT):
        solution = solution.telling(least)
    if remedies:
        if kept.failure is Status.LOCKED:
            solution = replace(solution, reasons=(reason(Code.DILATANCY_LOCKS),))
        again = reason(Code.BEGAN_AGAIN, first=str(runs[0].failure), remedies=remedies, in_vain=not decided)
        solution = solution.telling_first(again) if decided else solution.telling(again)
    history = tuple(entry for ran in runs for entry in ran.solution.history)
    return replace(solution, solver=kept.attempt.solver, history=history)

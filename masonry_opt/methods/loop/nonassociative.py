"""Method "nonassociative": the loop of the paper (section 4.2), and the remedies for a run that fails."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from masonry_opt.methods.loop.options import Attempt, LoopOptions
from masonry_opt.methods.loop.run import Iteration, Run, belong_together
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.acceptance import BORNE_OUT
from masonry_opt.solution.answer import certified
from masonry_opt.solution.reasons import Code, Reason, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import Solver, find_solver, rougher
from masonry_opt.stability.diagnosis import no_optimum


class Shortfall(StrEnum):
    """Reason to reject the answer of a converged run of the loop, and to repeat the run in another way."""

    INEXACT = "converged to no exact state"
    ROUGH = "converged to the associative answer, but only within a large tolerance"


#: A run fails in one of two ways. Either it does not converge (a status), or it converges to a load factor
#: that is rejected (a shortfall).
Failure = Status | Shortfall

#: Function that takes the settings of a failed run of the loop and returns the settings of the next run, or
#: None if the remedy cannot change the settings further.
Remedy = Callable[[Attempt], Attempt | None]

#: Remedies that are still to be tried, for each kind of failure.
_RemainingRemedies = dict[Failure | None, Iterator[Remedy]]


def _accurately(last: Attempt) -> Attempt | None:
    """Return the settings of a further run that solves its sub-problems accurately.

    None is returned if the last run already solved its sub-problems accurately.
    """
    if last.parameters.tolerance is None:
        return None
    parameters = last.parameters.model_copy(update={"tolerance": None})
    return replace(last, parameters=parameters, remedy="sub_problems=accurate")


def less_slope(last: Attempt) -> Attempt | None:
    """Return the settings of a further run with α reduced to a third, or None if α is at its minimum.

    A shear limit |s| ≤ c − αμn with contracting flow also limits n to c / (αμ). A smaller slope α raises the
    limit on n.
    """
    if last.parameters.alpha <= last.parameters.alpha_min:
        return None
    return _with(last, "alpha", last.parameters.alpha / 3)


def _more_damping(last: Attempt) -> Attempt | None:
    """Return the settings of a further run in which the weight β of the latest normal forces is halved."""
    return _with(last, "beta", last.parameters.beta / 2)


def _cohesive_start(last: Attempt) -> Attempt | None:
    """Return the settings of a further run with the cohesive start, or None if the last run had this start.

    Section 6.3 of the paper describes the cohesive start: in the first sub-problem, joints have cohesion in
    place of friction, so that dilatancy cannot lock the blocks.
    """
    return None if last.parameters.start == "cohesive" else _with(last, "start", "cohesive")


def _another_solver(last: Attempt) -> Attempt | None:
    """Return the settings of a further run of the loop with another solver.

    The other solver is Clarabel, or HiGHS's interior-point method if the failed run used Clarabel.
    """
    name = "clarabel" if last.solver.name != "clarabel" else "highs-ipm"
    return replace(last, solver=find_solver("cvxpy", name), remedy=f"solver={name}")


def _with(last: Attempt, option: str, value: float | str) -> Attempt:
    """Return the settings of a further run in which one option is changed. ``remedy`` records the change."""
    text = value if isinstance(value, str) else f"{value:.2g}"
    parameters = last.parameters.model_copy(update={option: value})
    return replace(last, parameters=parameters, remedy=f"{option}={text}")


#: Remedies for each kind of failure, in the order in which they are tried. A remedy that is listed several
#: times is tried that many times. Each remedy solves at least one test scene on which a run of the loop
#: fails. A change of the option ``c0`` is not among the remedies: in tests it solved few scenes, and method
#: "coulomb" solves these scenes too.
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
    """Finished run of the loop of linear programs, with its parameters and its solution."""

    problem: Problem  #: problem that the run solved
    attempt: Attempt  #: parameters and solver of the run
    solution: Solution

    @property
    def failure(self) -> Failure | None:
        """Failure of the run, or None if the solution of the run is final."""
        parameters, solution = self.attempt.parameters, self.solution
        if solution.answer is None:
            return None if solution.status is Status.JAMMED else solution.status
        if parameters.finish and solution.failing():
            return Shortfall.INEXACT
        if not solution.flow_rule_matters:
            return None if parameters.tolerance is None else Shortfall.ROUGH
        belongs = belong_together(self.problem, solution.answer)
        return Shortfall.INEXACT if parameters.finish and not belongs else None


def nonassociative(task: Task) -> Solution:
    """Solve a problem with the joints' own flow rule, by the paper's loop of linear programs.

    If a run of the loop fails, further runs follow with the remedies that ``REMEDIES`` lists for the failure.
    The history and the reasons record each run.
    """
    original, options = task.problem, task.options or LoopOptions()
    attempt: Attempt | None = Attempt(options.parameters(original.joints, task.solver), task.solver)
    runs: list[_Ran] = []
    # Solver and tolerance of the current driver. A new driver is compiled only if the solver or the tolerance
    # changes.
    declared: tuple[Solver, float | None] | None = None
    remaining: _RemainingRemedies = {failure: iter(remedies) for failure, remedies in REMEDIES.items()}
    # Least verified load factor of the sub-problems so far, or None if no load factor is verified. A load
    # factor is verified if no residual under the joints' own flow rule is larger than ``BORNE_OUT``.
    least: float | None = None

    def follow(step: Iteration) -> None:
        """Update the least verified load factor with the state of a sub-problem, and report progress."""
        nonlocal least
        state = step.solved.state if step.solved else None
        if state and (least is None or state.load_factor < least):
            answer = certified(problem, state.load_factor, state.q, state.d)
            least = state.load_factor if max(answer.residuals.values()) <= BORNE_OUT else least
        task.progress(step)

    while attempt is not None:
        if declared != (attempt.solver, attempt.parameters.tolerance):
            declared = attempt.solver, attempt.parameters.tolerance
            problem = original.by_cone if attempt.solver.entry.conic else original
            driver = _declared(task, problem, *declared)
        solution = Run(problem, driver, attempt).follow(follow)
        if not solution.history:
            word = solution.reasons[0].values["word"]
            status, why = no_optimum(original, word, attempt.solver, task.effort)
            solution = replace(solution, status=status, reasons=(why,))
        runs.append(_Ran(problem, attempt, solution))
        attempt = _next(runs, remaining, options)
    solution = _gathered(runs, options, reason(Code.LEAST_BORNE_OUT, load_factor=least))
    return replace(solution, size=driver.size())


def _declared(task: Task, problem: Problem, solver: Solver, tolerance: float | None) -> Driver:
    """Return a driver that solves the linear programs of the loop with a given solver and tolerance."""
    # If sub-problems are solved to a large tolerance, divide forces by the dead load of the loaded blocks.
    # Otherwise the errors of the solver would grow with the size of the scene.
    of_load = tolerance is not None
    solver = solver if tolerance is None else rougher(solver, tolerance)
    how: dict[str, Any] = {"of_load": of_load, "purpose": "sub-problems", "repeats": True}
    return task.cache.driver(problem, "static", solver, task.effort, **how)


def _next(runs: list[_Ran], remaining: _RemainingRemedies, options: LoopOptions) -> Attempt | None:
    """Return the settings of the next run of the loop: those of the last run, changed by the next remedy.

    The remedy depends on the failure of the last run. None is returned if the last run did not fail, or if no
    remedy is left that the options permit.
    """
    last = runs[-1]
    for remedy in remaining.get(last.failure, ()):
        is_wanted = {"all": True, "slope": remedy is less_slope, "none": False}[options.remedies]
        following = remedy(last.attempt) if is_wanted or last.failure is Shortfall.ROUGH else None
        if following is not None:
            return replace(following, number=len(runs) + 1)
    return None


def _gathered(runs: list[_Ran], options: LoopOptions, least: Reason) -> Solution:
    """Return the solution of the run that determines the result, with the history of all runs.

    It is the solution of

    - the last run, if it did not fail;
    - the last run too, if option ``remedies`` is "slope" and every sub-problem of the run has an optimum;
    - otherwise the first run whose residuals are small enough for its load factor to be accepted;
    - otherwise the first run.

    ``least`` is a reason that states the least verified load factor of a sub-problem. It is added if the run
    did not converge.
    """
    last = runs[-1]
    decided = last.failure is None or (options.remedies == "slope" and last.failure is not Status.NO_STATE)
    passing = [ran for ran in runs if ran.solution.answer and not ran.solution.failing()]
    chosen = last if decided else next(iter([*passing, runs[0]]))
    solution, remedies = chosen.solution, [ran.attempt.remedy for ran in runs[1:]]
    if solution.status in (Status.CYCLING, Status.ITERATION_LIMIT):
        solution = solution.telling(least)
    if remedies:
        if chosen.failure is Status.LOCKED:
            solution = replace(solution, reasons=(reason(Code.DILATANCY_LOCKS),))
        restart = reason(Code.BEGAN_AGAIN, first=str(runs[0].failure), remedies=remedies, in_vain=not decided)
        solution = solution.telling_first(restart) if decided else solution.telling(restart)
    history = tuple(entry for ran in runs for entry in ran.solution.history)
    return replace(solution, solver=chosen.attempt.solver, history=history)

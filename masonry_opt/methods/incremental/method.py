"""Method "incremental": the incremental load factor, at which equilibrium is lost as the live load is raised.

Coulomb's problem has many collapse states. Elastic contacts and a load history from rest select one of them.
The analysis (:mod:`~masonry_opt.methods.incremental.analysis`) ends in one of four ways:

1. Collapse with an exact state: its load factor is between a load with equilibrium and a load without.
2. Collapse within a range: only these two loads are known. The answer is an exact state in which the blocks
   continue to move under a lower load, if such a state is found. Otherwise it is the largest load with
   equilibrium.
3. No limit: the response remains linear while the load grows without bound.
4. Undecided, for example because the blocks still move after many steps.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field, InstanceOf, Strict

from masonry_opt.methods.exact.self_stress import self_stress
from masonry_opt.methods.incremental.analysis import (
    End,
    IncrementalAnalysis,
    IncrementalResult,
    analysis_of,
    is_meaningful,
)
from masonry_opt.methods.incremental.collapse_state import find_collapse_state
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import Answer, FinalState, certified
from masonry_opt.solution.load_history import LoadStep
from masonry_opt.solution.reasons import Code, Reason, Status, reason
from masonry_opt.solution.solution import Solution


class IncrementalOptions(Options):
    """Options of the incremental analysis.

    Attributes
    ----------
    curve: True to return the load–displacement curve too, as ``result.curve``.
    spread: number of random draws of the contacts' stiffness, and of the self-stress under the dead load. The
        result then also has the least and the largest incremental load factor of the draws.
    settings: numbers that control the analysis, as :class:`~masonry_opt.IncrementalSettings`. Only Python can
        pass them.
    """

    curve: Annotated[bool, Strict()] = False
    spread: Annotated[int, Strict(), Field(ge=1, le=1000)] | None = None
    settings: InstanceOf[IncrementalSettings] | None = None


def incremental(task: Task) -> Solution:
    """Raise the live load from zero until equilibrium is lost, and return the collapse state."""
    options, effort = task.options or IncrementalOptions(), task.effort
    effort.begins("incremental analysis")
    effort.uses(task.solver.name, "incremental analysis")
    with effort.measure("build"):
        analysis = analysis_of(task, options.settings)

    def record(step: LoadStep) -> None:
        effort.iterations += 1
        task.progress(step)

    with effort.measure("solve"):
        result = analysis.run(record)
        if result.collapse is not None and result.end is End.COLLAPSE and result.state is None:
            result = result.with_state(find_collapse_state(analysis.solver, result.collapse, effort))
        solution = replace(_solution(analysis, result), solver=task.solver)
        if options.curve:
            solution = _with_curve(solution)
        if options.spread:
            solution = solution.telling(_spread(analysis, options.spread))
    return solution


def _solution(analysis: IncrementalAnalysis, result: IncrementalResult) -> Solution:
    """Convert the result of an analysis to a solution with a status and reasons."""
    steps = len(result.history.steps)
    solution = Solution(Status.SOLVER_FAILED, Kind.INCREMENTAL)
    if result.end is End.UNSTABLE:
        falling = _falling_state(analysis)
        if falling is None:
            return solution.ended(Status.SOLVER_FAILED, Code.UNDECIDED, **_undecided(result))
        state = FinalState(q=falling.q, d=falling.d, slope=falling.slope, forms=falling.forms)
        return replace(solution, state=state).withdrawn(Status.UNSTABLE, Code.WEDGED, blocks=[])
    if result.history.steps:
        solution = replace(solution, history=result.history.steps)
    if result.end is End.UNBOUNDED:
        return solution.ended(Status.SOLVER_FAILED, Code.UNBOUNDED, steps=steps)
    if result.end in (End.SLOW, End.TOO_MANY_INCREMENTS, End.TOO_LARGE_LOAD):
        return solution.ended(Status.SOLVER_FAILED, Code.UNDECIDED, **_undecided(result))
    return _at_collapse(analysis, result, solution)


def _at_collapse(analysis: IncrementalAnalysis, result: IncrementalResult, solution: Solution) -> Solution:
    """Return the solution after a collapse: an exact state, or a range of the load factor."""
    values: dict[str, Any] = {"steps": len(result.history.steps), "jumps": result.history.jumps}
    if result.state is not None:
        ended = replace(solution, state=result.state).ended(Status.CONVERGED, Code.COLLAPSE, **values)
        return replace(ended, followed_to_end=True)
    values |= {"carried": result.carried, "not_carried": result.not_carried}
    lower = result.state_in_motion
    if lower is not None and is_meaningful(analysis, lower.load_factor, lower.d):
        ended = replace(solution, state=lower).ended(Status.CONVERGED, Code.RANGE, **values)
        return replace(ended, followed_to_end=True, peak=result.carried)
    state = _last_state(analysis, result)
    return replace(solution, state=state).ended(Status.CONVERGED, Code.RANGE, **values)


def _last_state(analysis: IncrementalAnalysis, result: IncrementalResult) -> Answer:
    """Return the equilibrium under the largest carried load, together with the motion of the collapse."""
    problem, collapse = analysis.problem.by_cone, result.collapse
    assert collapse is not None
    work = float(problem.live @ collapse.motion)
    d = collapse.motion * (problem.live_norm / work if work > 0 else 1 / np.abs(collapse.motion).max())
    return certified(problem, result.carried, result.history.steps[-1].forces, d)


def _falling_state(analysis: IncrementalAnalysis) -> Answer | None:
    """Return an exact collapse state under a fraction λ ≤ 1 of the dead load, or None if none is found."""
    problem = analysis.problem
    raised = replace(problem, dead=np.zeros_like(problem.dead), live=problem.dead, settled=None)
    result = IncrementalAnalysis(raised, analysis.solver.settings).run()
    state = result.state or result.state_in_motion
    return state if state is not None and state.load_factor <= 1 + EQUALITY_TOLERANCE else None


def _undecided(result: IncrementalResult) -> dict[str, Any]:
    return {"word": str(result.end), "steps": len(result.history.steps), "looped": False, "searched": False}


def _with_curve(solution: Solution) -> Solution:
    """Return the solution, with a report of its load–displacement curve added if it has a load history."""
    history = solution.load_history
    if history is None:
        return solution
    why = reason(Code.CURVE, states=len(history.steps), jumps=history.jumps)
    return replace(solution, tells_curve=True).telling(why)


def _spread(analysis: IncrementalAnalysis, draws: int) -> Reason:
    """Return the ranges of the incremental load factor for random stiffness and random self-stress.

    A draw of self-stress is a vertex of the set of forces that balance the dead load, or a weighted mean of
    two vertices.
    """
    rng, deviation = np.random.default_rng(0), analysis.solver.settings.stiffness_deviation
    stiffness, by_stiffness = _range(analysis.with_random_stiffness(deviation, rng) for _ in range(draws))
    stress, by_stress = _range(_stressed(analysis, number, rng) for number in range(draws))
    without = 2 * draws - by_stiffness - by_stress
    return reason(Code.SPREAD, draws=draws, stiffness=stiffness, stress=stress, without=without)


def _stressed(
    analysis: IncrementalAnalysis, number: int, rng: np.random.Generator
) -> IncrementalAnalysis | None:

    first, second = (self_stress(analysis.problem, rng) for _ in range(2))
    if first is None or second is None:
        return None
    share = rng.uniform() if number % 2 else 1.0
    problem = replace(analysis.problem, settled=share * first + (1 - share) * second)
    return analysis.again_for(problem)


def _range(drawn: Iterable[IncrementalAnalysis | None]) -> tuple[tuple[float, float] | None, int]:
    """Return the least and the largest incremental load factor of several analyses.

    None replaces the two values if no analysis has a load factor. The second returned value is the number of
    analyses that have a load factor.
    """
    ends = (analysis.run().load_factor for analysis in drawn if analysis is not None)
    load_factors = [load_factor for load_factor in ends if load_factor is not None]
    return ((min(load_factors), max(load_factors)) if load_factors else None), len(load_factors)

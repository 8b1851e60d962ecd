"""Method "global": a bracket of the least Coulomb load factor, its lower end certified from the matrices."""

import time
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field, Strict

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Found
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.answer.solution import Solution
from masonry_opt.methods.associative import associative
from masonry_opt.methods.bracket.relaxation import Rising, StateBounds, a_little_above, assumed_rates, closed
from masonry_opt.methods.coulomb.method import CoulombOptions, coulomb
from masonry_opt.methods.coulomb.search import SearchLimits, search_lower
from masonry_opt.methods.exact.refiner import refiner_of
from masonry_opt.methods.exact.search import lower_of
from masonry_opt.methods.incremental.analysis import analysis_of, is_meaningful
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.registry import MATRICES, find_solver

#: On scenes of more joints a bracket seldom closes, and this share of the time looks for a lower state first:
#: it lowers the upper end, and with it what forces can be.
_MANY_JOINTS, _SEARCHING = 60, 0.05


class GlobalOptions(Options):
    """Parameters of the bracket.

    Attributes
    ----------
    time_limit: seconds for both ends (each program is given one at least).
    rate_bound: largest sum of slips and edge openings that is assumed where kinematics set no limit, in units
        of the live load's mean velocity; the bound then holds below it. By default ten times the sum in the
        lowest state known, 100 at least.
    """

    time_limit: Annotated[float, Strict(), Field(gt=0, le=1e6)] = 60.0
    rate_bound: Annotated[float, Strict(), Field(gt=0)] | None = None


def global_search(task: Task) -> Solution:
    """The least Coulomb load factor λ ≥ 0 known, and what is proven of the least."""
    problem, options = task.problem, task.options
    began = time.perf_counter()
    upper = associative(task.with_options(None, find_solver("cvxpy", None)))
    if upper.load_factor is None:
        upper = replace(upper, kind=Kind.EXACT)  # of what is asked here its status alone decides nothing
    if upper.load_factor is None and upper.status is not Status.LOCKED:
        return upper
    search = _SEARCHING * options.time_limit if problem.joints > _MANY_JOINTS else None
    start = coulomb(task.with_options(CoulombOptions(search=search), find_solver(MATRICES, None)))
    if search is None:
        # Forces of a scene that the dead load brings down may lead to an exact state too.
        start = search_lower(task, start, SearchLimits())
    if start.interrupted:
        raise KeyboardInterrupt
    exact = start.is_exact(problem)
    # Where dilatancy locks the associative flow, an exact state bounds λ instead.
    above = [upper.load_factor, start.load_factor if exact else None]
    if above == [None, None]:
        return upper
    best = min(load_factor for load_factor in above if load_factor is not None)
    if a_little_above(best) <= 0:
        return start  # there is no load factor λ ≥ 0
    found = start.found if exact else Found()
    solution = Solution(Status.SOLVER_FAILED, Kind.EXACT, (), found, bound=min(best, 0.0), solver=task.solver)
    solution = replace(solution, associative=upper.load_factor, flow_rule_matters=start.flow_rule_matters)
    rising = Rising(problem, best, options.rate_bound or assumed_rates(problem, solution.d), task.effort)
    if best > 0:
        solution = _raised(task, solution, rising, began)
    solution = _concluded(problem, solution, rising.of, options)
    solution = replace(solution, below_zero=start.below_zero)
    return solution.telling(*(said for said in start.reasons if said.code is Code.BELOW_ZERO))


def _raised(task: Task, solution: Solution, rising: Rising, began: float) -> Solution:
    """A solution with its bound raised, on scenes of few joints with the lowest state near the programs."""
    problem, refiner, ends = task.problem, refiner_of(task), began + task.options.time_limit
    for step, size, forces in rising.programs(ends, began):
        task.progress(step)
        solution = replace(solution, size=size)
        for q in forces if problem.joints <= _MANY_JOINTS else []:
            state = refiner.state_near(q) if time.perf_counter() < ends else None
            answer = state.answer if state else None
            if answer is None or lower_of(solution.answer, answer) is not answer:
                continue
            if is_meaningful(analysis_of(task), answer.load_factor, answer.d):
                rising.best = min(rising.best, answer.load_factor)
                solution = replace(solution, found=answer)
    return replace(solution, bound=rising.bound, history=tuple(rising.history))


def _concluded(problem: Problem, solution: Solution, of: StateBounds, options: GlobalOptions) -> Solution:
    """A solution with its status, and the reason."""
    answer = solution.answer
    if answer is None:
        return solution.ended(Status.SOLVER_FAILED, Code.NO_EXACT_STATE, time_limit=options.time_limit)
    bound = min(solution.bound or 0.0, answer.load_factor)
    derived = of.forces_derived and of.rates_derived
    solution = replace(solution, bound=bound, bound_derived=derived)
    said: dict[str, Any] = {"bound": bound, "load_factor": answer.load_factor}
    said |= {"rates": None if of.rates_derived else of.rates, "forces": not of.forces_derived}
    if not of.allow(problem, answer.q, answer.d):
        # What holds among some states only, and not this one, is no bound.
        return replace(solution, bound=0.0).ended(Status.CONVERGED, Code.TOUCHES_IMPOSED, **said)
    if not closed(bound, answer.load_factor):
        code = Code.OUT_OF_TIME if derived else Code.OUT_OF_TIME_WITHIN_IMPOSED
        return solution.ended(Status.CONVERGED, code, **said, time_limit=options.time_limit)
    if derived:
        return solution.ended(Status.OPTIMAL, Code.PROVEN, **said)
    return solution.ended(Status.CONVERGED, Code.WITHIN_IMPOSED, **said)

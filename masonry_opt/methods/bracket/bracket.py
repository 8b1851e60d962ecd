"""Method "global": bracket the least Coulomb load factor.

The lower end of the bracket is certified from the matrices.
"""

import time
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field, Strict

from masonry_opt.deadline import TimeLimitReached, limited, seconds_left, unlimited
from masonry_opt.methods.associative import associative
from masonry_opt.methods.bounds.products import a_little_above
from masonry_opt.methods.bounds.search import bound_below
from masonry_opt.methods.bounds.settings import SETTINGS
from masonry_opt.methods.bracket.relaxation import Rising, assumed_rates, closed
from masonry_opt.methods.coulomb.method import CoulombOptions, coulomb
from masonry_opt.methods.coulomb.search import SearchLimits, search_lower
from masonry_opt.methods.exact.refiner import refiner_of
from masonry_opt.methods.exact.search import lower_of
from masonry_opt.methods.incremental.analysis import analysis_of, is_meaningful
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import FinalState
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.stopped import without_answer
from masonry_opt.solvers.registry import MATRICES, find_solver

#: On scenes with more joints than this number, the bounds on the least λ seldom become equal. On such scenes,
#: method "global" first searches for states with a λ below the lowest known λ. These states reduce the upper
#: bound on λ and the limits on the forces.
_MANY_JOINTS = 60

#: On scenes with more than ``_MANY_JOINTS`` joints, method "global" spends at most this fraction of its time
#: limit on the search for states with a λ below the lowest known λ. With a larger fraction, less time remains
#: for the lower bound.
_SEARCH_TIME_SHARE = 0.05


class GlobalOptions(Options):
    """Options of method "global", which encloses the least load factor between two bounds.

    Attributes
    ----------
    time_limit: time for both bounds together, in seconds. The limit of a single program is at least 1 s.
    rate_bound: largest sum of slips and edge openings that is assumed in relaxations of more than 12,000
        products if kinematics imposes no limit, relative to the mean velocity of the live load. The lower
        bound on λ is then valid for states below this sum. The default is ten times the sum in the lowest
        known state, and at least 100. Smaller relaxations assume no limit.
    """

    time_limit: Annotated[float, Strict(), Field(gt=0, le=1e6)] = 60.0
    rate_bound: Annotated[float, Strict(), Field(gt=0)] | None = None


def global_search(task: Task) -> Solution:
    """Return the lowest Coulomb state found with λ ≥ 0, and a lower bound on the least load factor.

    Raises KeyboardInterrupt if the search for a lower state is interrupted. Raises TimeLimitReached if the
    time limit is over before an upper bound is known.
    """
    problem, options = task.problem, task.options
    began = time.perf_counter()
    with limited(options.time_limit):
        upper = associative(task.with_options(None, find_solver("cvxpy", None)))
    if upper.load_factor is None:
        # An unlimited load with associative flow does not prove that the load is unlimited with Coulomb
        # friction. ``Solution.carries_any_load`` would count it as a proof, so the kind is changed.
        upper = replace(upper, kind=Kind.EXACT)
    if upper.load_factor is None and upper.status is not Status.LOCKED:
        return upper
    search = _SEARCH_TIME_SHARE * options.time_limit if problem.joints > _MANY_JOINTS else None
    start = _lowest_state(task, search, began)
    if start.interrupted and not start.has(Code.TIME_LIMIT):
        raise KeyboardInterrupt
    if start.proof is not None:
        # The default method has already proven that no state has a lower load factor, so no relaxations are
        # needed.
        return replace(start, status=Status.OPTIMAL, associative=upper.load_factor)
    exact = start.is_exact(problem)
    # If associative flow sets no limit to λ, only an exact state yields an upper bound on the least λ.
    upper_bounds = [upper.load_factor, start.load_factor if exact else None]
    if upper_bounds == [None, None]:
        return upper
    best = min(load_factor for load_factor in upper_bounds if load_factor is not None)
    if a_little_above(best) <= 0:
        return start  # No load factor λ ≥ 0 exists.
    state = start.state if exact else FinalState()
    solution = Solution(Status.SOLVER_FAILED, Kind.EXACT, (), state, bound=min(best, 0.0), solver=task.solver)
    solution = replace(solution, associative=upper.load_factor, flow_rule_matters=start.flow_rule_matters)
    rising = Rising(problem, best, options.rate_bound or assumed_rates(problem, solution.d), task.effort)
    if best > 0:
        # Stop the sequence of programs at the time limit of this method or of the whole study, whichever is
        # earlier.
        ends = min(began + options.time_limit, time.perf_counter() + seconds_left())
        with unlimited():
            solution = _raised(task, solution, rising, began, ends)
    solution = _concluded(problem, solution, rising, options)
    solution = replace(solution, below_zero=start.below_zero)
    return solution.telling(*(entry for entry in start.reasons if entry.code is Code.BELOW_ZERO))


def _lowest_state(task: Task, search: float | None, began: float) -> Solution:
    """Return the state of lowest λ that the default method finds before the time limit of "global".

    ``search`` is the time of an additional search in seconds, or None. At the time limit the lowest state so
    far is returned, or a solution without an answer if no state is known.
    """
    remaining_time = max(began + task.options.time_limit - time.perf_counter(), 0.0)
    try:
        with limited(remaining_time):
            own = task.with_options(CoulombOptions(search=search), find_solver(MATRICES, None))
            start = coulomb(own)
            # Without a search, still look for an exact state near the forces of the solution. The default
            # method skips this step if the scene is unstable under its dead load.
            return start if search is not None else search_lower(task, start, SearchLimits())
    except TimeLimitReached as stop:
        return without_answer(Kind.EXACT, stop, task.effort)


def _raised(task: Task, solution: Solution, rising: Rising, began: float, ends: float) -> Solution:
    """Raise the lower bound on λ by relaxations of increasing size, and return the solution.

    The relaxations end when the bracket is closed, after the largest relaxation, or at the time ``ends``.
    Both ``began`` and ``ends`` are values of ``time.perf_counter``.

    On scenes with at most ``_MANY_JOINTS`` joints, the method also looks for exact states with a lower λ near
    the forces of the relaxations.
    """
    problem, refiner = task.problem, refiner_of(task)
    scale = problem.load_factor_scale
    for step, size, forces in rising.programs(ends, began):
        task.progress(step)
        solution = replace(solution, size=size)
        for q in forces if problem.joints <= _MANY_JOINTS else []:
            state = refiner.state_near(q) if time.perf_counter() < ends else None
            answer = state.answer if state else None
            if answer is None or lower_of(solution.answer, answer, scale) is not answer:
                continue
            if is_meaningful(analysis_of(task), answer.load_factor, answer.d):
                rising.best = min(rising.best, answer.load_factor)
                solution = replace(solution, state=answer)
    return replace(solution, bound=rising.bound, history=tuple(rising.history))


def _concluded(problem: Problem, solution: Solution, rising: Rising, options: GlobalOptions) -> Solution:
    """Set the status and the reason of a solution, depending on its lower bound."""
    answer = solution.answer
    if answer is None:
        return solution.ended(Status.SOLVER_FAILED, Code.NO_EXACT_STATE, time_limit=options.time_limit)
    bound = min(solution.bound or 0.0, answer.load_factor)
    limits = rising.limits
    forces_assumed = limits is not None and not limits.forces_derived
    rates = None if limits is None or limits.rates_derived else limits.rates
    derived = not forces_assumed and rates is None
    solution = replace(solution, bound=bound, bound_derived=derived)
    values: dict[str, Any] = {"bound": bound, "load_factor": answer.load_factor}
    values |= {"rates": rates, "forces": forces_assumed}
    if limits is not None and not limits.allow(problem, answer.q, answer.d):
        # The known state exceeds an assumed limit on forces or rates. The lower bound is therefore not valid
        # for all states.
        return replace(solution, bound=0.0).ended(Status.CONVERGED, Code.TOUCHES_IMPOSED, **values)
    if not closed(problem, bound, answer.load_factor):
        code = Code.OUT_OF_TIME if derived else Code.OUT_OF_TIME_WITHIN_IMPOSED
        return solution.ended(Status.CONVERGED, code, **values, time_limit=options.time_limit)
    if derived:
        if limits is None and rising.chain.steps:
            needed = bound_below(answer.load_factor, SETTINGS, problem.load_factor_scale)
            proof = rising.chain.proof(answer.load_factor, min(needed, rising.chain.bound))
            solution = replace(solution, proof=proof, bound=proof.bound)
            values["bound"] = proof.bound
        return solution.ended(Status.OPTIMAL, Code.PROVEN, **values)
    return solution.ended(Status.CONVERGED, Code.WITHIN_IMPOSED, **values)

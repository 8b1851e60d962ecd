"""Method "global": a bracket of the least Coulomb load factor, its lower end certified from the matrices."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field, Strict

from masonry_opt.answer.acceptance import CLOSED, SMALLEST, Kind
from masonry_opt.answer.answer import Found
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.methods.associative import associative
from masonry_opt.methods.bracket.bounds import StateBounds, bounds_of, tightened
from masonry_opt.methods.bracket.relaxation import LEAST_TIME, RADII, BoundStep, Distances, relaxed
from masonry_opt.methods.refined import RefinedOptions, refined
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.registry import find_solver

#: The programs take this share more than the best λ known, so that they have an interior.
_ABOVE = 1e-4

#: A program that closes more than this share of the gap is followed by another of the same products, with the
#: limits of forces that it leaves; else by one of more products, which takes three to ten times as long.
_WORTH_REPEATING = 0.5

#: No program keeps more products than this (memory).
_MOST_PRODUCTS = 400_000

#: What rates are assumed to sum to, at least, and over those of the state known (on walls 30 to 140).
_LEAST_RATES, _OVER_KNOWN = 100.0, 10.0

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
    problem, options, effort = task.problem, task.options, task.effort
    began = time.perf_counter()
    upper = associative(task.with_options(None, find_solver("cvxpy", None)))
    if upper.load_factor is None:
        upper = replace(upper, kind=Kind.EXACT)  # of what is asked here its status alone decides nothing
    if upper.load_factor is None and upper.status is not Status.LOCKED:
        return upper
    search = _SEARCHING * options.time_limit if problem.joints > _MANY_JOINTS else None
    start = refined(task.with_options(RefinedOptions(search=search)))
    if start.interrupted:
        raise KeyboardInterrupt
    exact = start.is_exact(problem)
    # Where dilatancy locks the associative flow, an exact state bounds λ instead.
    above = [upper.load_factor, start.load_factor if exact else None]
    if above == [None, None]:
        return upper
    best = min(load_factor for load_factor in above if load_factor is not None)
    highest = a_little_above(best)
    if highest <= 0:
        return start  # there is no load factor λ ≥ 0
    solution = Solution(
        Status.SOLVER_FAILED,
        Kind.EXACT,
        found=start.found if exact else Found(),
        flow_rule_matters=start.flow_rule_matters,
        associative=upper.load_factor,
        bound=min(best, 0.0),
        solver=task.solver,
    )
    of = bounds_of(problem, highest, options.rate_bound or assumed_rates(problem, solution.d), effort)
    if best > 0:
        solution = _raised(task, solution, best, highest, of, began)
    solution = _concluded(problem, solution, of, options)
    return solution.telling(*(said for said in start.reasons if said.code is Code.BELOW_ZERO))


def assumed_rates(problem: Problem, d: np.ndarray | None) -> float:
    """What slips and edge openings are assumed to sum to, from the velocities (3b,) of the lowest state."""
    return max(_LEAST_RATES, _OVER_KNOWN * (0.0 if d is None else _rates(problem, d)))


def _rates(problem: Problem, d: np.ndarray) -> float:
    """The sum of slips and edge openings under block velocities (3b,)."""
    return float(problem.rates(d, problem.dilatancy) @ problem.face_length)


def a_little_above(best: float) -> float:
    """Λ of the programs, from the best λ known."""
    return best + _ABOVE * max(abs(best), 1e-3)


def _raised(
    task: Task, solution: Solution, best: float, highest: float, of: StateBounds, began: float
) -> Solution:
    """A solution with its bound raised by programs of more and more products, until the bracket is closed or
    time is up.

    Below what one program proves there is no state: the next looks above only, where forces have less room,
    and the same products prove more. They are kept while that pays."""
    ends, bound = began + task.options.time_limit, 0.0
    distances, before = Distances(task.problem), 0
    history, size = list[BoundStep](), None

    def raised() -> Solution:
        return replace(solution, bound=bound, history=tuple(history), size=size)

    for radii in RADII:
        near, moves = distances.within(radii)
        products = 12 * int(near.sum()) + 9 * int(moves.sum())
        if products == before or products > _MOST_PRODUCTS:
            continue
        gains = True
        while gains:
            if before and ends - time.perf_counter() < LEAST_TIME:
                return raised()
            if bound > of.lowest:
                of = tightened(of, task.problem, bound, highest, task.effort)
            before, left, last = products, ends - time.perf_counter(), bound
            proven, size = relaxed(task.problem, highest, of, near, moves, left, task.effort)
            step = BoundStep(proven, of.lowest, best, *radii, products, time.perf_counter() - began)
            history.append(step)
            task.progress(step)
            bound = max(last, min(proven, best))
            if _closed(bound, best):
                return raised()
            gains = bound - last > _WORTH_REPEATING * (best - last)
    return raised()


def _closed(bound: float, load_factor: float) -> bool:
    return load_factor - bound <= CLOSED * max(abs(load_factor), SMALLEST)


def _concluded(problem: Problem, solution: Solution, of: StateBounds, options: GlobalOptions) -> Solution:
    """A solution with its status, and the reason, from what was found."""
    answer = solution.answer
    if answer is None:
        return solution.ended(Status.SOLVER_FAILED, Code.NO_EXACT_STATE, time_limit=options.time_limit)
    bound = min(solution.bound or 0.0, answer.load_factor)
    solution = replace(solution, bound=bound, bound_derived=of.derived)
    said: dict[str, Any] = {"bound": bound, "load_factor": answer.load_factor}
    said |= {"rates": None if of.rates_derived else of.rates, "forces": not of.forces_derived}
    if not of.allow(answer.q, _rates(problem, answer.d)):
        # What holds among some states only, and not this one, is no bound.
        return replace(solution, bound=0.0).ended(Status.CONVERGED, Code.TOUCHES_IMPOSED, **said)
    if not _closed(bound, answer.load_factor):
        code = Code.OUT_OF_TIME if of.derived else Code.OUT_OF_TIME_WITHIN_IMPOSED
        return solution.ended(Status.CONVERGED, code, **said, time_limit=options.time_limit)
    if of.derived:
        return solution.ended(Status.OPTIMAL, Code.PROVEN, **said)
    return solution.ended(Status.CONVERGED, Code.WITHIN_IMPOSED, **said)

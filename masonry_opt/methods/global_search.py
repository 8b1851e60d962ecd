"""Method "global": a bracket of the least Coulomb load factor, by mixed-integer programming."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from pydantic import Field, Strict
from pyomo.contrib.solver.common.results import Results, SolutionStatus, TerminationCondition
from pyomo.contrib.solver.solvers.highs import Highs

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.effort import Effort
from masonry_opt.methods.associative import associative
from masonry_opt.methods.refined.method import RefinedOptions, refined
from masonry_opt.methods.refined.programs import Refiner
from masonry_opt.methods.task import Method, Options, Task
from masonry_opt.models.pyomo_global import PyomoGlobal
from masonry_opt.models.pyomo_refinement import PyomoForces, PyomoMotion
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.highs_session import HighsSession
from masonry_opt.solvers.lp import LpSize, Verdict
from masonry_opt.solvers.registry import capable, find_solver

#: Relative gap at which a bracket counts as closed.
_CLOSED = 1e-6

#: Share of an imposed bound within which an answer touches it.
_TOUCHES = 1e-6

#: Seconds that the mixed-integer program is given at least.
_LEAST_TIME = 1.0

#: What HiGHS does here, as a result tells it.
_PURPOSE = "bounds"


class GlobalOptions(Options):
    """Parameters of the search.

    Attributes
    ----------
    time_limit: seconds for bounds and search together (the search is given one at least).
    rate_bound: bound of the rates that kinematics leave unbounded, in units of the live load's mean
        velocity. Where it is needed nothing is proven.
    """

    time_limit: Annotated[float, Strict(), Field(gt=0, le=1e6)] = 60.0
    rate_bound: Annotated[float, Strict(), Field(gt=0)] = 100.0


@dataclass(frozen=True)
class FaceBounds:
    """Finite bounds that make complementarity linear.

    Attributes
    ----------
    slack, rate: of each face, shape (faces,).
    slack_derived, rate_derived: whether statics and kinematics imply them; else some are imposed, and
        what the search finds holds below them only.
    """

    slack: np.ndarray
    rate: np.ndarray
    slack_derived: bool
    rate_derived: bool

    @property
    def derived(self) -> bool:
        """Whether every bound is implied, so that they cut nothing off."""
        return self.slack_derived and self.rate_derived


def face_bounds(problem: Problem, highest: float, imposed: float, effort: Effort) -> FaceBounds:
    """Bounds over all states with 0 ≤ λ ≤ ``highest``, by linear programs.

    Slacks: the largest normal force n̂ that statics allow each joint; a
    face of sliding has z ≤ 2 (c + μ n̂), one of rocking z ≤ L n̂. Rates: the largest that kinematics
    allow each face while the raising of the blocks takes no more than the live load gives; of sliding
    with the other sense at rest, which loses nothing unless dilatancy is negative (at yield in both
    senses a joint carries nothing and may rock open instead).
    """
    largest = _largest_normal_forces(problem, highest, effort)
    # Ten times all loads where statics set no limit (states of self-stress).
    loads = np.abs(problem.dead).sum() + highest * problem.live_norm
    bounded = np.isfinite(largest)
    n = np.where(bounded, largest, 10 * loads)
    shear, rocking = ShearLimits.true(problem).at(n[problem.sliding]), problem.half_length * n
    rate = _largest_rates(problem, highest, effort)
    finite = np.isfinite(rate)
    return FaceBounds(
        slack=2 * np.concatenate([shear, shear, rocking, rocking]),
        rate=np.where(finite, rate, imposed),
        slack_derived=bool(bounded.all()),
        rate_derived=bool(finite.all() and (problem.dilatancy >= 0).all()),
    )


def _largest_normal_forces(problem: Problem, highest: float, effort: Effort) -> np.ndarray:
    """Largest normal force of each joint over all states with 0 ≤ λ ≤ ``highest``, shape (c,);
    ``inf`` where the solver finds no largest."""
    program = PyomoForces(problem, within=(0.0, highest)).program
    session = HighsSession(program, effort, _PURPOSE, costs=[(program.q, program.force_cost)])
    largest = np.full(problem.joints, np.inf)
    for joint in range(problem.joints):
        session.set(program.force_cost, -_unit(3 * problem.joints, joint))
        if session.solve() is Verdict.OPTIMAL:
            largest[joint] = session.values(program.q)[joint]
    return largest


def _largest_rates(problem: Problem, highest: float, effort: Effort) -> np.ndarray:
    """Largest rate of each face over the mechanisms on which raising the blocks takes at most
    ``highest`` times the live load's work, shape (faces,); ``inf`` where the solver finds no largest.

    While a joint slides in one sense the other is held at rest. After the first face without a
    largest rate the others are not tried.
    """
    program = PyomoMotion(problem, raising=highest * problem.live_norm).program
    session = HighsSession(
        program, effort, _PURPOSE, costs=[(program.p, program.cost)], most=[(program.p, program.most)]
    )
    k = len(problem.sliding)
    largest = np.full(problem.faces, np.inf)
    for face in range(problem.faces):
        most = np.full(problem.faces, np.inf)
        if face < 2 * k:
            most[(face + k) % (2 * k)] = 0.0
        session.set(program.most, most)
        session.set(program.cost, -_unit(problem.faces, face))
        verdict = session.solve()
        if verdict is Verdict.OPTIMAL:
            largest[face] = session.values(program.p)[face]
        elif verdict is Verdict.INFEASIBLE:
            largest[face] = 0.0  # at rest in every such mechanism: there is none
        else:
            break
    return largest


def _unit(size: int, index: int) -> np.ndarray:
    return np.eye(1, size, index).ravel()


def global_search(task: Task) -> Solution:
    """The least Coulomb load factor λ ≥ 0, and what is proven of it."""
    problem, options, effort = task.problem, task.options, task.effort
    upper = associative(task.with_options(None, find_solver("cvxpy", None)))
    if upper.load_factor is None and upper.status is not Status.LOCKED:
        return upper
    start = refined(task.with_options(RefinedOptions()))
    exact = start.kind is Kind.EXACT and start.load_factor is not None
    # Where dilatancy locks the associative flow, an exact state bounds λ instead.
    known = [found.load_factor for found in (upper, *([start] if exact else []))]
    if not (bounds := [load_factor for load_factor in known if load_factor is not None]):
        return upper
    highest = min(bounds)
    # A trace above, so that rounding does not cut off the best state itself.
    highest += 1e-7 * max(abs(highest), 1.0)
    began = time.perf_counter()
    of_faces = face_bounds(problem, highest, options.rate_bound, effort)
    with effort.measure("build"):
        model = PyomoGlobal(problem, of_faces.slack, of_faces.rate, highest)
    time_left = options.time_limit - (time.perf_counter() - began)
    answer, size = _searched(model, max(time_left, _LEAST_TIME), task)
    solution = Solution(Status.SOLVER_FAILED, Kind.EXACT, slope=problem.dilatancy, size=size)
    solution.flow_rule_matters = start.flow_rule_matters
    if exact:
        solution.load_factor, solution.q, solution.d = start.load_factor, start.q, start.d
    if answer.solution_status in (SolutionStatus.optimal, SolutionStatus.feasible):
        answer.solution_loader.load_vars()
        found = Refiner(problem, effort).first(model.read().q)
        if found is not None and (solution.load_factor is None or found.load_factor < solution.load_factor):
            lower = replace(solution, load_factor=found.load_factor, q=found.q, d=found.d)
            solution = solution if lower.failing(problem) else lower
    solution.bound = 0.0
    if answer.termination_condition == TerminationCondition.provenInfeasible:
        # There is nothing below ``highest``, which lies a trace above the best state.
        solution.bound = highest
    elif answer.objective_bound is not None and np.isfinite(answer.objective_bound):
        solution.bound = max(0.0, answer.objective_bound / problem.live_norm)
    _conclude(problem, solution, of_faces, options)
    return solution


def _searched(model: PyomoGlobal, seconds: float, task: Task) -> tuple[Results, LpSize]:
    """What HiGHS finds within a time, and the size of the program."""
    effort = task.effort
    effort.uses(task.solver.name, "search")
    effort.lp_solves += 1
    highs = Highs()
    highs.config.load_solutions = False
    highs.config.raise_exception_on_nonoptimal_result = False
    highs.config.time_limit = seconds
    highs.config.solver_options = {
        "mip_rel_gap": _CLOSED / 10,
        "mip_feasibility_tolerance": 1e-9,
        "primal_feasibility_tolerance": 1e-9,
        "dual_feasibility_tolerance": 1e-9,
    }
    with effort.measure("solve"):
        answer = highs.solve(model.program)
    lp = highs._solver_model.getLp()
    return answer, LpSize(lp.num_row_, lp.num_col_, len(lp.a_matrix_.value_))


def _conclude(problem: Problem, solution: Solution, of_faces: FaceBounds, options: GlobalOptions) -> None:
    """Status, reason and bound from what was found."""
    load_factor, d = solution.load_factor, solution.d
    if load_factor is None or d is None:
        solution.end(Status.SOLVER_FAILED, Code.NO_EXACT_STATE, time_limit=options.time_limit)
        return
    bound = solution.bound = min(solution.bound or 0.0, load_factor)
    closed = load_factor - bound <= _CLOSED * max(abs(load_factor), 1e-3)
    bracket = {"bound": bound, "load_factor": load_factor}
    if of_faces.derived:
        if closed:
            largest = float(of_faces.rate.max())
            solution.end(Status.OPTIMAL, Code.PROVEN, **bracket, largest_rate=largest)
        else:
            solution.end(Status.CONVERGED, Code.OUT_OF_TIME, **bracket, time_limit=options.time_limit)
        return
    imposed = {
        "rate_bound": None if of_faces.rate_derived else options.rate_bound,
        "forces": not of_faces.slack_derived,
    }
    p = problem.rates(d, problem.dilatancy)
    beyond = bool((p >= options.rate_bound * (1 - _TOUCHES)).any()) and not of_faces.rate_derived
    code = (
        Code.TOUCHES_IMPOSED if beyond else Code.WITHIN_IMPOSED if closed else Code.OUT_OF_TIME_WITHIN_IMPOSED
    )
    solution.end(Status.CONVERGED, code, **bracket, **imposed, time_limit=options.time_limit)
    # What holds among some states only is no bound of all.
    solution.bound = 0.0


GLOBAL = Method(
    "global",
    global_search,
    GlobalOptions,
    {"pyomo": capable("pyomo", lambda solver: solver.integer)},
    own_tolerances=True,
    constant_dilatancy=True,
)

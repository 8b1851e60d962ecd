"""The complementarity program with binaries, which looks for a lower state where products leave a gap."""

from __future__ import annotations

import numpy as np
from pyomo.contrib.solver.common.results import Results, SolutionStatus, TerminationCondition

from masonry_opt.methods.bracket.limits import Limits
from masonry_opt.methods.bracket.relaxation import edge_lengths
from masonry_opt.methods.exact.refiner import ExactState, Refiner
from masonry_opt.methods.task import Task
from masonry_opt.models.pyomo_global import PyomoGlobal
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.pyomo_engine import highs_of_pyomo

#: Relative gap and feasibility asked of HiGHS.
_GAP, _FEASIBILITY = 1e-7, 1e-9


def lower_state(
    task: Task, highest: float, of: Limits, seconds: float
) -> tuple[ExactState | None, float | None]:
    """An exact state with λ ≤ ``highest`` within the limits, if one is found in that time, and the least λ on
    the solver's word; None where it has none to give."""
    problem, effort = task.problem, task.effort
    with effort.measure("build"):
        model = with_binaries(problem, highest, of)
    answer = _searched(model, seconds, task)
    found = None
    if answer.solution_status in (SolutionStatus.optimal, SolutionStatus.feasible):
        answer.solution_loader.load_vars()
        found = Refiner(problem, effort).first(model.read().q)
    if answer.termination_condition == TerminationCondition.provenInfeasible:
        return found, highest
    if answer.objective_bound is None or not np.isfinite(answer.objective_bound):
        return found, None
    return found, float(answer.objective_bound) / problem.live_norm


def with_binaries(problem: Problem, highest: float, of: Limits) -> PyomoGlobal:
    """The program over all states with 0 ≤ λ ≤ ``highest`` within the limits."""
    return PyomoGlobal(problem, _most_slack(problem, of), of.rates / edge_lengths(problem), highest)


def _most_slack(problem: Problem, of: Limits) -> np.ndarray:
    """A face of sliding has z ≤ 2 (c + μ n̂), one of rocking z ≤ L n̂."""
    shear = ShearLimits.true(problem).at(of.normal[problem.sliding])
    rocking = problem.half_length * of.normal
    most: np.ndarray = 2 * np.concatenate([shear, shear, rocking, rocking])
    return most


def _searched(model: PyomoGlobal, seconds: float, task: Task) -> Results:
    task.effort.uses(task.solver.name, "search")
    task.effort.lp_solves += 1
    # Asked for its simplex by name, HiGHS would leave the binaries out.
    tolerances = ("mip_feasibility_tolerance", "primal_feasibility_tolerance", "dual_feasibility_tolerance")
    highs = highs_of_pyomo({"mip_rel_gap": _GAP, **dict.fromkeys(tolerances, _FEASIBILITY)})
    highs.config.time_limit = seconds
    with task.effort.measure("solve"):
        return highs.solve(model.program)

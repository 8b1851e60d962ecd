"""A proven bracket of the least Coulomb load factor, by mixed-integer programming."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import highspy
import numpy as np
from pydantic import Field
from pyomo.contrib.solver.solvers.highs import Highs

from masonry_opt.analysis.finding import Finding
from masonry_opt.analysis.refinement import Refiner
from masonry_opt.analysis.status import Status
from masonry_opt.models.pyomo_global import PyomoGlobal
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.blocks import Number, Positive, Record
from masonry_opt.solvers.answer import LpSize
from masonry_opt.timing import Stopwatch

#: Relative gap at which a bracket counts as closed.
_CLOSED = 1e-6

#: Share of a bound within which an answer touches it.
_TOUCHES = 1e-6


class GlobalOptions(Record):
    """Parameters of the search.

    Attributes
    ----------
    time_limit: seconds for the mixed-integer program.
    rate_bound: bound of the rates where the kinematics do not bound them, in units of the live load's
        mean velocity.

    Raises
    ------
    pydantic.ValidationError
        If a parameter is of the wrong type or out of range.
    """

    time_limit: Annotated[Number, Field(gt=0, le=1e6)] = 60.0
    rate_bound: Positive = 100.0


@dataclass(frozen=True)
class Bounds:
    """Finite bounds that make complementarity linear.

    Attributes
    ----------
    slack: of each face, shape (4, c).
    rate: of every rate.
    slack_derived, rate_derived: whether statics and kinematics imply them; else they are imposed, and
        what is proven holds below them only.
    """

    slack: np.ndarray
    rate: float
    slack_derived: bool
    rate_derived: bool


def derive_bounds(problem: Problem, refiner: Refiner, highest: float, rate_bound: float) -> Bounds:
    """Bounds over all states with 0 ≤ λ ≤ ``highest``.

    Slacks: the largest normal force n̂ that statics allow a joint, by one linear program each; a face
    of sliding has z ≤ 2 (c + μ n̂), one of rocking z ≤ L n̂. Rates: the largest sum of rates that
    kinematics allow while the raising of the blocks takes no more than the live load gives.
    """
    largest, derived = refiner.largest_normal_forces(highest)
    if not derived:
        # Ten times all loads: beyond what any joint of a scene without self-stress carries.
        loads = np.abs(problem.dead).sum() + highest * problem.live_norm
        largest = np.where(np.isfinite(largest), largest, 10 * loads)
    k = problem.sliding
    shear = np.zeros(problem.joints)
    shear[k] = problem.cohesion[k] + problem.friction[k] * largest[k]
    rocking = problem.half_length * largest
    slack = 2 * np.stack([shear, shear, rocking, rocking])
    total = refiner.largest_sum_of_rates(highest)
    return Bounds(slack, rate_bound if total is None else total, derived, total is not None)


def global_bounds(
    problem: Problem,
    incumbent: Finding,
    highest: float,
    options: GlobalOptions,
    watch: Stopwatch,
    progress: Callable[[object], None] = lambda _: None,
) -> Finding:
    """The least Coulomb load factor of a scene that stands, and what is proven of it.

    Parameters
    ----------
    incumbent: an exact state to begin from (of the refinement); its λ cuts the search.
    highest: the associative load factor, an upper bound of λ.
    """
    del progress
    refiner = Refiner(problem)
    if incumbent.load_factor is not None:
        highest = min(highest, incumbent.load_factor)
    with watch.measure("compile"):
        bounds = derive_bounds(problem, refiner, highest, options.rate_bound)
    with watch.measure("build"):
        # A trace above, so that rounding does not cut off the incumbent itself.
        model = PyomoGlobal(problem, bounds.slack, bounds.rate, highest + 1e-7 * max(highest, 1.0))
    highs = Highs()
    highs.config.load_solutions = False
    highs.config.raise_exception_on_nonoptimal_result = False
    highs.config.time_limit = options.time_limit
    highs.config.solver_options = {
        "mip_rel_gap": _CLOSED / 10,
        "mip_feasibility_tolerance": 1e-9,
        "primal_feasibility_tolerance": 1e-9,
        "dual_feasibility_tolerance": 1e-9,
    }
    with watch.measure("solve"):
        answer = highs.solve(model.program)
    scale = problem.live_norm
    bound = answer.objective_bound
    lowest = max(0.0, bound / scale) if bound is not None and np.isfinite(bound) else 0.0

    finding = Finding(Status.CONVERGED, slope=problem.dilatancy)
    finding.lp_solves = refiner.solves + incumbent.lp_solves
    finding.iterations = refiner.iterations + incumbent.iterations
    finding.size = _size(highs)
    touched = False
    if incumbent.load_factor is not None:
        finding.load_factor, finding.q, finding.d = incumbent.load_factor, incumbent.q, incumbent.d
    if answer.incumbent_objective is not None and highs._sol.value_valid:
        answer.solution_loader.load_vars()
        state = model.read()
        touched = _touches(model, bounds)
        exact = refiner.first(state.q)
        better = exact is not None and (
            finding.load_factor is None or exact.load_factor <= finding.load_factor + _CLOSED
        )
        if better and exact is not None:
            finding.load_factor, finding.q, finding.d = exact.load_factor, exact.q, exact.d
        elif finding.load_factor is None:
            finding.load_factor, finding.q, finding.d = state.load_factor, state.q, state.d
    infeasible = highs._solver_model.getModelStatus() == highspy.HighsModelStatus.kInfeasible
    if infeasible and finding.load_factor is not None:
        # Nothing at or below the incumbent but itself, to the tolerances.
        lowest = finding.load_factor
    return _conclude(finding, lowest, bounds, touched, options)


def _conclude(
    finding: Finding, lowest: float, bounds: Bounds, touched: bool, options: GlobalOptions
) -> Finding:
    if finding.load_factor is None:
        finding.status = Status.SOLVER_FAILED
        finding.message = f"no state was found within {options.time_limit:g} s: raise 'time_limit'"
        return finding
    finding.bound = min(lowest, finding.load_factor)
    gap = finding.load_factor - finding.bound
    closed = gap <= _CLOSED * max(abs(finding.load_factor), 1e-3)
    bracket = f"{finding.bound:.6g} ≤ λ ≤ {finding.load_factor:.6g}"
    limits = f"rates up to {bounds.rate:.4g} ({'derived' if bounds.rate_derived else 'imposed'})"
    if not bounds.slack_derived:
        limits += ", normal forces up to ten times all loads (imposed)"
    if closed and not touched:
        finding.status = Status.OPTIMAL
        finding.message = f"proven least: {bracket}, {limits}"
    elif touched:
        finding.message = f"not proven: the answer touches a bound; {bracket}, {limits}"
    else:
        finding.message = f"not proven within {options.time_limit:g} s: {bracket}, {limits}"
    return finding


def _touches(model: PyomoGlobal, bounds: Bounds) -> bool:
    """Whether an imposed bound holds the answer."""
    program = model.program
    rates = [data.value for part in (program.slide, program.rock) for data in part.values()]
    if max(rates) >= bounds.rate * (1 - _TOUCHES):
        return True
    slacks = np.array(
        [data.value for part in (program.slide_slack, program.rock_slack) for data in part.values()]
    )
    k = model.problem.sliding
    limit = np.concatenate([bounds.slack[:2, k].ravel(), bounds.slack[2:].ravel()])
    return not bounds.slack_derived and bool((slacks >= limit * (1 - _TOUCHES)).any())


def _size(highs: Highs) -> LpSize:
    lp = highs._solver_model.getLp()
    return LpSize(lp.num_row_, lp.num_col_, len(lp.a_matrix_.value_))

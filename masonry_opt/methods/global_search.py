"""A bracket of the least Coulomb load factor, by mixed-integer programming, and when it is a proof."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy.sparse as sp
from pydantic import Field
from pyomo.contrib.solver.common.results import SolutionStatus, TerminationCondition
from pyomo.contrib.solver.solvers.highs import Highs
from pyomo.repn.plugins.standard_form import LinearStandardFormCompiler

from masonry_opt.answer.certificate import certify, rates
from masonry_opt.answer.solution import Finding
from masonry_opt.answer.status import Status
from masonry_opt.effort import Stopwatch
from masonry_opt.methods.refined.programs import EXACT, Refiner
from masonry_opt.models.pyomo_global import PyomoGlobal
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.blocks import Number, Positive, Record
from masonry_opt.solvers.lp import LpSize

#: Relative gap at which a bracket counts as closed.
_CLOSED = 1e-6

#: Share of an imposed bound within which an answer touches it.
_TOUCHES = 1e-6

#: Seconds that the mixed-integer program is given at least.
_LEAST_TIME = 1.0


class GlobalOptions(Record):
    """Parameters of the search.

    Attributes
    ----------
    time_limit: seconds for bounds and search together (the search is given one at least).
    rate_bound: bound of the rates that kinematics leave unbounded, in units of the live load's mean
        velocity. Where it is needed nothing is proven.

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
    highest: of λ, from 0.
    slack, rate: of each face, shape (4, c).
    slack_derived, rate_derived: whether statics and kinematics imply them; else some are imposed, and
        what the search finds holds below them only.
    """

    highest: float
    slack: np.ndarray
    rate: np.ndarray
    slack_derived: bool
    rate_derived: bool

    @property
    def derived(self) -> bool:
        """Whether every bound is implied, so that they cut nothing off."""
        return self.slack_derived and self.rate_derived


def derive_bounds(problem: Problem, refiner: Refiner, highest: float, imposed: float) -> Bounds:
    """Bounds over all states with 0 ≤ λ ≤ ``highest``, by linear programs.

    Slacks: the largest normal force n̂ that statics allow each joint; a
    face of sliding has z ≤ 2 (c + μ n̂), one of rocking z ≤ L n̂. Rates: the largest that kinematics
    allow each face while the raising of the blocks takes no more than the live load gives; of sliding
    with the other sense at rest, which loses nothing unless dilatancy is negative (at yield in both
    senses a joint carries nothing and may rock open instead).
    """
    largest = refiner.largest_normal_forces(highest)
    # Ten times all loads where statics set no limit (states of self-stress).
    loads = np.abs(problem.dead).sum() + highest * problem.live_norm
    bounded = np.isfinite(largest)
    largest = np.where(bounded, largest, 10 * loads)
    k = problem.sliding
    shear = np.zeros(problem.joints)
    shear[k] = problem.cohesion[k] + problem.friction[k] * largest[k]
    rocking = problem.half_length * largest
    rate = refiner.largest_rates(highest)
    finite = np.isfinite(rate)
    return Bounds(
        highest=highest,
        slack=2 * np.stack([shear, shear, rocking, rocking]),
        rate=np.where(finite, rate, imposed),
        slack_derived=bool(bounded.all()),
        rate_derived=bool(finite.all() and (problem.dilatancy[k] >= 0).all()),
    )


def global_bounds(
    problem: Problem, start: Finding, upper: float, options: GlobalOptions, watch: Stopwatch
) -> Finding:
    """The least Coulomb load factor λ ≥ 0 of a scene that stands, and what is proven of it.

    Parameters
    ----------
    start: the refinement's finding; if its state is exact, λ is searched no higher.
    upper: an upper bound of λ: the associative load factor, or that of an exact state.
    """
    began = time.perf_counter()
    refiner = Refiner(problem)
    best = start if _is_exact(problem, start) else None
    highest = upper
    if best is not None and best.load_factor is not None:
        highest = min(highest, best.load_factor)
    # A trace above, so that rounding does not cut off the best state itself.
    highest += 1e-7 * max(abs(highest), 1.0)
    with watch.measure("compile"):
        bounds = derive_bounds(problem, refiner, highest, options.rate_bound)
    with watch.measure("build"):
        model = PyomoGlobal(problem, bounds.slack, bounds.rate, bounds.highest)
    highs = Highs()
    highs.config.load_solutions = False
    highs.config.raise_exception_on_nonoptimal_result = False
    highs.config.time_limit = max(options.time_limit - (time.perf_counter() - began), _LEAST_TIME)
    highs.config.solver_options = {
        "mip_rel_gap": _CLOSED / 10,
        "mip_feasibility_tolerance": 1e-9,
        "primal_feasibility_tolerance": 1e-9,
        "dual_feasibility_tolerance": 1e-9,
    }
    with watch.measure("solve"):
        answer = highs.solve(model.program)

    finding = Finding(Status.SOLVER_FAILED, slope=problem.dilatancy, size=_size(model))
    if best is not None:
        finding.load_factor, finding.q, finding.d = best.load_factor, best.q, best.d
    if answer.solution_status in (SolutionStatus.optimal, SolutionStatus.feasible):
        answer.solution_loader.load_vars()
        exact = refiner.first(model.read().q)
        if exact is not None and (finding.load_factor is None or exact.load_factor < finding.load_factor):
            finding.load_factor, finding.q, finding.d = exact.load_factor, exact.q, exact.d
    bound = answer.objective_bound
    finding.bound = 0.0
    if answer.termination_condition == TerminationCondition.provenInfeasible:
        # There is nothing below ``highest``, which lies a trace above the best state.
        finding.bound = highest
    elif bound is not None and np.isfinite(bound):
        finding.bound = max(0.0, bound / problem.live_norm)
    finding.lp_solves = refiner.solves + start.lp_solves
    finding.iterations = refiner.iterations + start.iterations
    return _conclude(problem, finding, bounds, options)


def _is_exact(problem: Problem, finding: Finding) -> bool:
    if finding.load_factor is None or finding.q is None or finding.d is None:
        return False
    certificate = certify(problem, finding.load_factor, finding.q, finding.d, problem.dilatancy)
    return certificate.worst <= EXACT


def _conclude(problem: Problem, finding: Finding, bounds: Bounds, options: GlobalOptions) -> Finding:
    if finding.load_factor is None or finding.d is None:
        finding.message = f"no exact state was found within {options.time_limit:g} s: raise 'time_limit'"
        return finding
    finding.bound = min(finding.bound or 0.0, finding.load_factor)
    closed = finding.load_factor - finding.bound <= _CLOSED * max(abs(finding.load_factor), 1e-3)
    bracket = f"{finding.bound:.6g} ≤ λ ≤ {finding.load_factor:.6g}"
    largest = f"{bounds.rate.max():.4g}"
    finding.status = Status.CONVERGED
    if closed and bounds.derived:
        finding.status = Status.OPTIMAL
        finding.message = f"proven least: {bracket} (rates are at most {largest}, which kinematics imply)"
        return finding
    if bounds.derived:
        finding.message = f"not proven within {options.time_limit:g} s: {bracket}"
        return finding
    imposed = [] if bounds.rate_derived else [f"rates up to {options.rate_bound:g}"]
    imposed += [] if bounds.slack_derived else ["normal forces up to ten times all loads"]
    limits = f"{' and '.join(imposed)}, bounds that had to be imposed"
    p = rates(problem, finding.d, problem.dilatancy)
    beyond = p >= options.rate_bound * (1 - _TOUCHES)
    if beyond.any() and not bounds.rate_derived:
        finding.message = f"not proven: the answer touches or exceeds {limits}; {bracket}"
    elif closed:
        finding.message = f"not proven, but none lower was found among states with {limits}; {bracket}"
    else:
        finding.message = (
            f"not proven within {options.time_limit:g} s, and only for states with {limits}; {bracket}"
        )
    # What holds among some states only is no bound of all.
    finding.bound = 0.0
    return finding


def _size(model: PyomoGlobal) -> LpSize:
    form = LinearStandardFormCompiler().write(model.program, mixed_form=True, set_sense=None)
    matrix = sp.csr_array(form.A)
    return LpSize(matrix.shape[0], matrix.shape[1], matrix.nnz)

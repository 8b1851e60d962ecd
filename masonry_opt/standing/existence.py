"""Proof, where a method ended without a load factor, that there is none: certified from the matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_opt.answer.acceptance import PROOF
from masonry_opt.answer.infeasibility import Existence, InfeasibilityCertificate, ray_residuals
from masonry_opt.answer.thresholds import NAMED
from masonry_opt.effort import Effort
from masonry_opt.models.pyomo_alternatives import PyomoNoMotion
from masonry_opt.problem.load_units import in_units_of_load
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.highs_session import HighsSession
from masonry_opt.solvers.lp import Verdict
from masonry_opt.standing.combinatorial_cuts import Cuts, combinatorial_cuts

#: Joints up to which rays are looked for, and up to which mechanisms are excluded by branching; and the
#: linear programs times joints after which branching is given up (most random scenes that jam take 5 to 400
#: programs, some 1400 to 3300).
_RAYS_UP_TO, _CUTS_UP_TO = 2000, 100
_MOST_WORK = 120_000

#: What a solver does here, as a result tells it.
_PURPOSE = "existence"


def existence(problem: Problem, effort: Effort, of_mechanism: bool = True) -> InfeasibilityCertificate | None:
    """Proof for a scene that stands, as far as there is one; None if it has too many joints.

    Parameters
    ----------
    effort: is told the solver, and neither programs nor iterations.
    of_mechanism: whether the load factor depends on the joints' own flow rule, so that mechanisms are to be
        excluded. (An associative one depends on statics alone.)
    """
    if problem.joints > _RAYS_UP_TO:
        return None
    effort.begins("is there a load factor at all?")
    own = Effort()
    try:
        return _found(in_units_of_load(problem).problem, own, of_mechanism)
    finally:
        effort.credit(own)
        effort.add("solve", own.seconds["solve"])


def _found(problem: Problem, effort: Effort, of_mechanism: bool) -> InfeasibilityCertificate:
    # Dilatancy that falls with stress allows what less of it does.
    falls = problem.dilatancy_depends_on_stress
    own_flow = np.minimum(problem.dilatancy, 0.0) if falls else problem.dilatancy
    if against := _ray(problem, own_flow, effort):
        return InfeasibilityCertificate(Existence.NO_MECHANISM, *against[1])
    ray = _ray(problem, problem.friction, effort)
    if ray is None:
        # Statics are bounded: the method failed, and there is nothing to prove.
        return InfeasibilityCertificate(Existence.UNDECIDED)
    certificate = InfeasibilityCertificate(Existence.UNBOUNDED, *ray[1])
    if opposite := _ray(replace(problem, live=-problem.live), problem.friction, effort):
        n = problem.normal_forces(ray[0] + opposite[0])
        order = np.argsort(-n, kind="stable")
        stressed = tuple(order[n[order] > NAMED * n.max()].tolist())
        certificate = replace(certificate, clamped=stressed)
    cuts = Cuts()
    # Cuts are of faces, which in space are sides inside the cone: they would prove nothing of it.
    of_faces = of_mechanism and not falls and not problem.by_cone.by_friction.conic
    if of_faces and problem.joints <= _CUTS_UP_TO:
        cuts = combinatorial_cuts(problem, _MOST_WORK // problem.joints, effort, _PURPOSE)
    if not cuts.exclude:
        return certificate
    return replace(
        certificate,
        existence=Existence.NO_STATE,
        static_cuts=len(cuts.static),
        kinematic_cuts=len(cuts.kinematic),
        cut_residual=cuts.residual,
    )


def _ray(
    problem: Problem, slope: np.ndarray, effort: Effort
) -> tuple[np.ndarray, tuple[float, float]] | None:
    """Forces (3c,) that carry the live load alone with shear limits of a slope (k,) and without cohesion, and
    their residuals; None if none were found that their residuals bear out."""
    program = PyomoNoMotion(problem, slope).program
    session = HighsSession(program, effort, _PURPOSE)
    session.set_most(program.v, np.zeros(problem.faces))
    if session.solve() is not Verdict.OPTIMAL:
        return None
    q = session.values(program.q)
    left = ray_residuals(problem, q, slope)
    return (q, left) if max(left) <= PROOF else None

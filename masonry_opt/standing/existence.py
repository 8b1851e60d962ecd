"""Why an analysis ended without a load factor: proof that there is none, certified from the matrices, and
reasons with the names of blocks and joints."""

from dataclasses import replace

import numpy as np

from masonry_opt.answer.acceptance import PROOF
from masonry_opt.answer.infeasibility import Existence, InfeasibilityCertificate, ray_residuals
from masonry_opt.answer.motion import moving_names
from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import NAMED
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_exact import CvxpyNoMotion
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.load_units import in_units_of_load
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.highs import HighsSession
from masonry_opt.solvers.registry import Solver, Verdict
from masonry_opt.standing.combinatorial_cuts import combinatorial_cuts
from masonry_opt.standing.diagnosis import locking_joints

#: Joints up to which rays are looked for, and up to which mechanisms are excluded by branching; and the
#: linear programs times joints after which branching is given up (most random scenes that jam take 5 to 400
#: programs, some 1400 to 3300).
_RAYS_UP_TO, _CUTS_UP_TO = 2000, 100
_MOST_WORK = 120_000

_PURPOSE = "existence"  #: What a solver does here, as a result tells it.


def existence(problem: Problem, effort: Effort, of_mechanism: bool = True) -> InfeasibilityCertificate | None:
    """Proof for a scene that stands, as far as there is one; None if it has too many joints. Mechanisms are
    excluded too where the load factor depends on the joints' own flow rule. (An associative one depends on
    statics alone.) The effort is told the solver, and neither programs nor iterations."""
    if problem.joints > _RAYS_UP_TO:
        return None
    effort.begins("is there a load factor at all?")
    with effort.beside() as own:
        found = _found(in_units_of_load(problem).problem, own, of_mechanism)
    effort.add("solve", own.seconds["solve"])
    return found


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
    # Cuts are of faces, which in space are sides inside the cone: they would prove nothing of it.
    of_cone = problem.by_cone.by_friction.conic
    if not of_mechanism or falls or of_cone or problem.joints > _CUTS_UP_TO:
        return certificate
    cuts = combinatorial_cuts(problem, _MOST_WORK // problem.joints, effort, _PURPOSE)
    if not cuts.exclude:
        return certificate
    certificate = replace(certificate, existence=Existence.NO_STATE, cut_residual=cuts.residual)
    return replace(certificate, static_cuts=len(cuts.static), kinematic_cuts=len(cuts.kinematic))


def _ray(
    problem: Problem, slope: np.ndarray, effort: Effort
) -> tuple[np.ndarray, tuple[float, float]] | None:
    """Forces (3c,) that carry the live load alone with shear limits of a slope (k,) and without cohesion, and
    their residuals; None if none were found that their residuals bear out."""
    model = CvxpyNoMotion(problem, slope)
    session = HighsSession(model.program, effort, _PURPOSE)
    session.set_most(model.v, np.zeros(problem.faces))
    if session.solve() is not Verdict.OPTIMAL:
        return None
    q = session.values(model.q)
    left = ray_residuals(problem, q, slope)
    return (q, left) if max(left) <= PROOF else None


def explained(
    assembly: Assembly, solution: Solution, solver: Solver, effort: Effort, associative: bool
) -> Solution:
    """A solution without a load factor, with status and reasons: that none exists is proven as far as
    possible, and the joints that carry the load are named."""
    found = solution.infeasibility
    if found is None:
        if solution.associative is None or associative:
            found = existence(assembly.problem, effort, of_mechanism=not associative)
        else:  # statics are bounded
            found = InfeasibilityCertificate(Existence.UNDECIDED)
        solution = replace(solution, infeasibility=found)
    if not associative:
        if solution.status is not Status.UNSTABLE:
            solution = _as_proven(solution)
        if found and found.clamped:
            solution = solution.telling(reason(Code.CLAMPED, pairs=assembly.pairs(np.array(found.clamped))))
    locking = locking_joints(assembly.problem, solution.status, solution.q, solver, Effort())
    if not len(locking):
        return solution
    return solution.telling(reason(Code.JOINTS, status=str(solution.status), pairs=assembly.pairs(locking)))


def withdrawn(assembly: Assembly, solution: Solution, rests: bool) -> Solution:
    """A solution without its load factor, which is below zero, or of a scene that does not carry its dead
    load from rest: ``rests`` tells whether it does, and would fall with the forces found alone, or is held by
    wedging alone."""
    if rests:
        # The way to an end below zero may lead over a load that the scene carries.
        ends = (said for said in solution.reasons if said.code in (Code.RAY, Code.LEVEL))
        over = [said for said in ends if said.values["peak"]]
        return solution.withdrawn(Status.SOLVER_FAILED, Code.BELOW_ZERO).telling(*over)
    moving = [] if solution.d is None else moving_names(assembly, solution.d)
    return solution.withdrawn(Status.UNSTABLE, Code.WEDGED, blocks=moving)


def _as_proven(solution: Solution) -> Solution:
    """A solution with what is proven as status and reasons."""
    found = solution.infeasibility
    proven = found.existence if found else None
    if proven is Existence.NO_MECHANISM and solution.status is not Status.UNLIMITED:
        solution = replace(solution, status=Status.UNLIMITED).telling_first(reason(Code.NO_MECHANISM))
    elif found and proven is Existence.NO_STATE:
        counts = {"static_cuts": found.static_cuts, "kinematic_cuts": found.kinematic_cuts}
        status = solution.status if found.equilibrium is None else Status.JAMMED
        solution = replace(solution, status=status).telling_first(reason(Code.NO_COLLAPSE, **counts))
    elif proven is Existence.UNBOUNDED:
        solution = solution.telling(reason(Code.CARRIES_ANY))
    return solution

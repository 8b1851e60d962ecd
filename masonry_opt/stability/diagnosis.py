"""Decide if a scene is stable under its dead load, and explain why a program has no optimum.

For an unstable scene the friction or the strength that would hold it is found too. No solver's verdict is
trusted: forces and mechanisms count only if their residuals are small.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order

from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_cone import Senses
from masonry_opt.models.cvxpy_standing import CvxpyDriven, CvxpyFalling, CvxpyStanding, by_cones
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solution.acceptance import DEPARTS, ROUNDING, Kind
from masonry_opt.solution.answer import FinalState
from masonry_opt.solution.motion import joint_motion, moving_blocks, moving_names
from masonry_opt.solution.reasons import Code, Reason, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import DRIVES, LISTED_JOINT_SHARE, SLIDES
from masonry_opt.solvers.cvxpy_engine import CvxpyEngine, has_optimum
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.solvers.registry import Solver, find_solver, in_cvxpy
from masonry_opt.stability.dead_load import DEAD_LOAD, carries

DIAGNOSIS = "diagnosis"  #: Name in a result's ``solvers`` for programs that explain why a scene is unstable.

#: Largest number of programs that are solved to decide if a load drives a mechanism. If more are needed, the
#: question remains undecided. Small random scenes need at most 5 programs, or 14 if no cone program is
#: solved.
_MOST_PROGRAMS = 40

#: Largest number of joints for which the simplex method is tried. For this number a program takes half a
#: minute.
_SIMPLEX_UP_TO = 2000

#: Largest number of joints for which the smallest stabilising factor on friction is computed.
FACTOR_UP_TO = 2000

#: Largest number of friction factors that are tried in the search for the smallest stabilising one.
_MOST_FACTORS = 12

#: Relative difference of the smallest stable and the largest unstable friction factor at which the search
#: ends.
_NEAR = 1e-3

#: Largest friction coefficient after multiplication by a factor. With larger coefficients solvers lose
#: digits.
_LARGEST_FRICTION = 100.0

#: Cosine of the angle between a joint's normal and a block's dead load above which the joint supports the
#: block.
_BEARS = 1e-6


class DeadLoadUndecided(Exception):
    """Error: verification failed both for forces that carry the dead load and for a falling mechanism."""

    def __init__(self, problem: Problem, word: str) -> None:
        super().__init__(word)
        size = problem.force_sizes(problem.dead)
        #: Values of the reason: status of the last solver, and ratio of the largest to the smallest dead load
        #: of a block.
        self.values = {"word": word, "ratio": float(size.max() / size[size > 0].min(initial=np.inf))}


@dataclass
class _Standing:
    """Compiled program of eq. (9), the static formulation, without live load."""

    model: CvxpyStanding
    engine: CvxpyEngine
    forces: np.ndarray | None = None  #: last joint forces that carried the dead load, shape (3c,)

    def again_for(self, problem: Problem, effort: Effort) -> "_Standing":
        """Return this program with the shear limits of another problem, as ``ProgramCache`` needs it."""
        self.model.limits.set(ShearLimits.true(problem))
        self.engine.restart(effort)
        return self


def falling_mechanism(
    problem: Problem, solver: Solver, effort: Effort, kept: ProgramCache | None = None
) -> np.ndarray | None:
    """Return block velocities (3b,) of a fall under dead load alone; None if the scene is stable.

    See :func:`mechanism_or_forces`.
    """
    return mechanism_or_forces(problem, solver, effort, kept)[0]


def mechanism_or_forces(
    problem: Problem, solver: Solver, effort: Effort, kept: ProgramCache | None = None
) -> tuple[np.ndarray, None] | tuple[None, np.ndarray]:
    """Return a mechanism (3b,) that the dead load drives, or joint forces (3c + t,) that carry the dead load.

    The scene is stable if eq. (9) without live load has a state. Otherwise the mechanism is the bounded dual
    ray. Every analysis checks this first, since a largest λ may exist although λ = 0 is no equilibrium. A
    scene at its limit counts as stable, and a scene beyond it by at most ``DRIVES`` too.

    Raises DeadLoadUndecided if neither forces nor a mechanism are verified.
    """
    by_cone, kept = problem.by_cone, kept or ProgramCache()
    chosen = in_cvxpy(solver, by_cone.by_friction.conic)

    def declared() -> _Standing:
        """Declare the program in a modelling language, and return it."""
        model = CvxpyStanding(by_cone, ShearLimits.true(problem))
        engine = CvxpyEngine(model.program, chosen, effort, DEAD_LOAD, repeats=kept.keeps)
        return _Standing(model, engine)

    # The check does not depend on live loads, so problems with equal dead loads share one compiled program.
    unloaded = replace(problem, live=problem.dead)
    standing = kept.of((DEAD_LOAD, chosen.key), unloaded, effort, declared)
    if standing.forces is not None and carries(problem, standing.forces):
        return None, standing.forces
    standing.engine.solve()
    forces = standing.model.statics.q.value
    if forces is not None and carries(problem, forces):
        standing.forces = forces
        return None, forces
    return _decide(problem, solver, effort, DEAD_LOAD)


def _drives(problem: Problem, d: np.ndarray) -> bool:
    """Return True if the dead load drives d, shape (3b,), and d is a mechanism with associative flow.

    Power and departure from the flow rule are compared with limits above rounding.
    """
    problem = problem.by_cone
    p = problem.rates(d, problem.friction)
    resisted = problem.cohesion @ problem.slip(p) + problem.face_constant @ p
    power = float(problem.dead @ d - resisted)
    departure = float(np.abs(problem.departure(d, p, problem.friction)).max())
    return power > DRIVES and departure <= max(DEPARTS * power, ROUNDING)


def as_it_falls(assembly: Assembly, falling: np.ndarray, effort: Effort) -> np.ndarray:
    """Return the block velocities with which an unstable scene begins to fall, shape (3b,).

    If the solver fails, the velocities ``falling`` are returned. They have the largest power, but may lift
    blocks off corners about which the blocks turn.
    """
    problem = assembly.problem
    low, high = assembly.geometry.boxes
    square = np.pad((high - low)[assembly.movable] ** 2, ((0, 0), (0, 1)))[:, :3]
    # Radii of gyration of the blocks' bounding boxes. About each axis, the two extents perpendicular to the
    # axis count; in the plane the axis is z.
    across = (square.sum(axis=1)[:, None] - square)[:, problem.layout.dimension - problem.layout.rows :]
    gyration = np.sqrt(across / 12) / problem.length_unit
    inertia = float(problem.force_sizes(problem.dead) @ problem.by_block(falling**2).sum(axis=1))
    scale = min(max(inertia / float(problem.dead @ falling), 1.0), 1 / DRIVES)
    model = CvxpyFalling(problem.by_cone, ShearLimits.true(problem), gyration, scale)
    if not has_optimum(model.program, find_solver("cvxpy", None), effort, DEAD_LOAD):
        return falling
    return np.asarray(model.mechanism.d.value) / scale


def no_optimum(problem: Problem, solver_status: str, solver: Solver, effort: Effort) -> tuple[Status, Reason]:
    """Return the status and the reason of a stable scene for which eq. (9) or (10) has no optimum.

    - LOCKED: the live load drives a mechanism of the joints' own flow rule, but none of associative flow.
    - UNLIMITED: the live load drives neither.
    - SOLVER_FAILED: the live load drives a mechanism of associative flow, or no program decides.

    ``effort`` records the solver, but counts no programs.
    """
    effort.begins("reason why there is no load factor")
    with suppress(DeadLoadUndecided):
        own_flow, associative = (
            _driven(_of_live_load(problem, slope), solver, effort.beside(), DIAGNOSIS)
            for slope in (problem.dilatancy, problem.friction)
        )
        if associative is None and own_flow is not None:
            return Status.LOCKED, reason(Code.DILATANCY_LOCKS)
        if associative is None:
            return Status.UNLIMITED, reason(Code.NO_MECHANISM)
    return Status.SOLVER_FAILED, reason(Code.SOLVER_STOPPED, word=solver_status)


def locking_joints(
    problem: Problem, status: Status, q: np.ndarray | None, solver: Solver, effort: Effort
) -> np.ndarray:
    """Return the indices of joints that prevent collapse under the live load, most important first.

    - LOCKED: joints that slide in a mechanism of the joints' own flow rule, ordered by how far they cannot
      open as associative flow demands.
    - UNLIMITED: joints that carry the live load alone, with shear limited by dilatancy or else by friction,
      the largest normal force first.
    - JAMMED: joints that carry the live load alone, with shear limited by friction; without such forces, the
      joints that carry most in ``q``.

    No index is returned if the solver fails, or for other statuses.
    """
    none = np.array([], dtype=int)
    if status is Status.LOCKED:
        d = None
        with suppress(DeadLoadUndecided):
            d = _driven(_of_live_load(problem, problem.dilatancy), solver, effort, DIAGNOSIS)
        if d is None:
            return none
        departure = problem.departure(d, problem.rates(d, problem.friction), problem.friction)
        cannot_open = np.abs(problem.at_points(departure)).max(axis=0)
        amount = np.where(problem.slip_speed(d) > SLIDES * np.abs(d).max(), cannot_open, 0.0)
    elif status in (Status.UNLIMITED, Status.JAMMED):
        slopes = [problem.dilatancy, problem.friction] if status is Status.UNLIMITED else [problem.friction]
        carrying = (_carrying_live_load(problem, slope, solver, effort) for slope in slopes)
        forces = next((forces for forces in carrying if forces is not None), None)
        if forces is None and status is Status.JAMMED:
            forces = q
        if forces is None:
            return none
        amount = np.abs(problem.normal_forces(forces))
    else:
        return none
    order = np.argsort(-amount, kind="stable")
    return order[amount[order] > max(LISTED_JOINT_SHARE * amount.max(), DRIVES)]


def _carrying_live_load(
    problem: Problem, slope: np.ndarray, solver: Solver, effort: Effort
) -> np.ndarray | None:
    """Return joint forces, shape (3c,), that carry the live load alone; None if no such forces exist.

    The slope of the shear limits has shape (k,).
    """
    loaded = _of_live_load(problem.by_cone, slope)
    carrying = CvxpyStanding(loaded, ShearLimits.true(loaded))
    if not has_optimum(carrying.program, in_cvxpy(solver, loaded.by_friction.conic), effort, DIAGNOSIS):
        return None
    return carrying.statics.forces()[1]


def _of_live_load(problem: Problem, slope: np.ndarray) -> Problem:
    """Return a problem without live load, whose dead load is the live load scaled to Σ|f| = 1.

    Shear is limited by a slope, shape (k,), without cohesion. Strength and finite force limits are zero.
    """
    alone = problem.recession_cone
    return replace(alone, dead=problem.live / problem.live_norm, law=replace(alone.law, friction=slope))


def _driven(problem: Problem, solver: Solver, effort: Effort, purpose: str) -> np.ndarray | None:
    """Return a motion (3b,) that the dead load drives; None if joint forces carry the dead load.

    See :func:`_decide`.
    """
    return _decide(problem, solver, effort, purpose)[0]


def _decide(
    problem: Problem, solver: Solver, effort: Effort, purpose: str
) -> tuple[np.ndarray, None] | tuple[None, np.ndarray]:
    """Return a motion (3b,) that the dead load drives, or joint forces (3c + t,) that carry the dead load.

    The first program is solved by ``solver``, further ones by the simplex method. In space these replace the
    circles of friction by polygons, in turn:

    - polygons inside the circles, whose forces are within the cones;
    - polygons around the circles, whose mechanisms follow the cones.

    Each polygon gets corners or sides in the directions of the last slips and shears, so that the two kinds
    approach each other. Raises DeadLoadUndecided if neither forces nor a motion are verified.
    """
    problem, senses = problem.by_cone, None
    solver = in_cvxpy(solver, problem.by_friction.conic)
    for program in range(_MOST_PROGRAMS if problem.joints <= _SIMPLEX_UP_TO else 1):
        model = CvxpyDriven(problem, ShearLimits.true(problem), senses)
        solved = CvxpyEngine(model.program, solver, effort, purpose).solve()
        motion_and_forces = model.read()
        if motion_and_forces is not None:
            d, q = motion_and_forces
            if _drives(problem, d):
                return d, None
            if carries(problem, q):
                return None, q
        if program and senses is None:
            break
        solver = find_solver("cvxpy", "highs", 1e-10)
        senses = _finer(problem, motion_and_forces, senses) if by_cones(problem) else None
    raise DeadLoadUndecided(problem, solved.status)


def _finer(
    problem: Problem, motion_and_forces: tuple[np.ndarray, np.ndarray] | None, senses: Senses | None
) -> Senses:
    """Return the slip directions of the polygons that replace friction circles in the next program.

    Polygons inside the circles alternate with polygons around the circles. The first directions are evenly
    spaced. The directions of slip in a motion, shape (3b,), and the directions opposite to the shears in
    forces, shape (3c,), are added.
    """
    if senses is None:
        every, points = problem.layout.senses, np.arange(len(problem.sliding))
        senses = Senses(np.tile(points, len(every)), np.repeat(every.T, len(points), axis=1), inside=False)
    point, along, inside = senses
    if motion_and_forces is not None:
        d, q = motion_and_forces
        for vectors in (problem.B.T @ d, -q):
            shears = problem.shears(vectors)[:, problem.sliding]
            size = np.hypot(*shears)
            nonzero = np.flatnonzero(size > ROUNDING)
            point = np.append(point, nonzero)
            along = np.append(along, shears[:, nonzero] / size[nonzero], axis=1)
    return Senses(point, along, not inside)


def what_would_hold(assembly: Assembly, falling: np.ndarray, solver: Solver, effort: Effort) -> list[Reason]:
    """Return reasons that state whether larger friction or strength would stabilise an unstable scene.

    - HANGS, if a falling block is not supported from below.
    - STRENGTH_WOULD_HOLD, if the scene is unstable with any friction, but stable with unlimited strength.
    - NO_FRICTION_HOLDS, if the scene is unstable with any friction and with unlimited strength.
    - FRICTION_WOULD_HOLD, if the scene is stable with larger friction.

    The last three are omitted if the solver cannot decide. A scene counts as stable if eq. (9) without live
    load has a state, which may be a state of wedging. ``falling`` are block velocities, shape (3b,).
    """
    problem = assembly.problem
    hanging = _hanging(assembly, moving_blocks(assembly, falling))
    reasons = [reason(Code.HANGS, blocks=assembly.names(assembly.movable[hanging]))] if len(hanging) else []
    none, nothing = np.array([], dtype=int), np.array([])
    rough = replace(problem.law, sliding=none, friction=nothing, cohesion=nothing, dilatancy=nothing)
    rough = replace(rough, dilatancy_force=np.empty((0, 2)))
    without_sliding = replace(assembly, problem=replace(problem, law=rough))
    try:
        falling_without_sliding = falling_mechanism(without_sliding.problem, solver, effort)
    except DeadLoadUndecided:
        return reasons
    if falling_without_sliding is not None:
        strong = replace(problem, law=replace(problem.law, crushing=none, crushing_force=nothing))
        with suppress(DeadLoadUndecided):
            if len(problem.crushing) and falling_mechanism(strong, solver, effort) is None:
                return [*reasons, reason(Code.STRENGTH_WOULD_HOLD)]
        d = as_it_falls(without_sliding, falling_without_sliding, effort)
        return [*reasons, reason(Code.NO_FRICTION_HOLDS, blocks=moving_names(assembly, d))]
    factor, above = _least_factor(problem, solver, effort)
    values = {"factor": factor, "above": above, "hangs": bool(len(hanging))}
    unstable = Solution(Status.UNSTABLE, Kind.ASSOCIATIVE, found=FinalState(d=falling))
    slides = joint_motion(assembly, unstable).slides
    most_first = np.argsort(-assembly.most_of_joints(problem.slip_speed(falling)), kind="stable")
    pairs = assembly.pairs_of(most_first[slides[most_first]])
    return [*reasons, reason(Code.FRICTION_WOULD_HOLD, pairs=pairs, **values)]


def _least_factor(problem: Problem, solver: Solver, effort: Effort) -> tuple[float | None, float]:
    """Return the smallest factor on all friction coefficients that is stable, and the largest unstable one.

    The first is None if no stable factor is found. Factors are squared until the scene is stable, and then
    bisected on a logarithmic scale.
    """
    stands, falls = None, 1.0
    largest = float(problem.friction.max(initial=0.0))
    if not largest or problem.joints > FACTOR_UP_TO:
        return stands, falls
    largest_factor, kept = _LARGEST_FRICTION / largest, ProgramCache(keeps=True)
    for _ in range(_MOST_FACTORS):
        if stands is None and falls < largest_factor:
            factor = min(max(2.0, falls**2), largest_factor)
        elif stands is not None and stands > falls * (1 + _NEAR):
            factor = sqrt(stands * falls)
        else:
            break
        stronger = replace(problem, law=replace(problem.law, friction=factor * problem.friction))
        try:
            is_stable = falling_mechanism(stronger, solver, effort, kept) is None
        except DeadLoadUndecided:
            break
        if is_stable:
            stands = factor
        else:
            falls = factor
    return stands, falls


def _hanging(assembly: Assembly, blocks: np.ndarray) -> np.ndarray:
    """Return the given movable blocks that no joint or chain of blocks supports from below.

    No chain of supporting joints connects these blocks with a support. A joint supports a block if its
    normal pushes against the block's dead load.
    """
    scene, joints, movable = assembly.scene, assembly.joints, assembly.movable
    count, forces = len(scene.blocks), assembly.problem.forces(assembly.problem.dead)
    down = np.zeros((count, forces.shape[1]))
    down[movable] = forces
    size = np.hypot.reduce(down, axis=1)
    down = np.where(size[:, None] > 0, down / np.where(size > 0, size, 1.0)[:, None], scene.down)
    first_borne = (joints.normal * down[joints.first]).sum(axis=1) < -_BEARS
    second_borne = (joints.normal * down[joints.second]).sum(axis=1) > _BEARS
    # The edges of the graph lead from each supporting block to the block on it, and from an extra node
    # (number ``count``) to all supports. Blocks on supports that permit rotation count as supports.
    support_forces = [force for force in assembly.limited if force.role is Role.SUPPORT]
    supported = [action.block for force in support_forces for action in force.actions]
    supports = np.append(np.setdiff1d(np.arange(count), movable), supported).astype(int)
    bears = np.concatenate([joints.second[first_borne], joints.first[second_borne], 0 * supports + count])
    borne = np.concatenate([joints.first[first_borne], joints.second[second_borne], supports])
    chains = sp.csr_array((np.ones(len(bears)), (bears, borne)), shape=(count + 1, count + 1))
    reached = breadth_first_order(chains, count, return_predecessors=False)
    return blocks[~np.isin(movable[blocks], reached)]

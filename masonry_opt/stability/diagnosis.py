"""Decide if a scene is stable under its dead load, and explain why a program has no optimum.

For an unstable scene, the functions also find the friction or strength that would stabilise it. The verdict
of a solver is never trusted: forces and mechanisms are accepted only if their residuals are small.
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
from masonry_opt.solution.acceptance import LARGEST_FLOW_VIOLATION, ROUNDING, Kind
from masonry_opt.solution.answer import FinalState
from masonry_opt.solution.motion import joint_motion, moving_blocks, moving_names
from masonry_opt.solution.reasons import Code, Reason, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import DRIVING_POWER, LISTED_JOINT_SHARE, SLIDES
from masonry_opt.solvers.cvxpy_engine import CvxpyEngine, has_optimum
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.solvers.registry import Solver, find_solver, in_cvxpy
from masonry_opt.stability.dead_load import DEAD_LOAD, carries

#: Key of ``result.solvers`` for the optimisation programs that determine why there is no load factor.
DIAGNOSIS = "diagnosis"

#: Largest number of programs that are solved to decide if a load drives a mechanism. After this number, the
#: question remains undecided. Small random scenes need at most 5 programs, or 14 if the solver fails to solve
#: the cone programs.
_MOST_PROGRAMS = 40

#: If the first program does not decide whether a load drives a mechanism, further programs follow up to this
#: number of joints. They are solved by the simplex method, which is slow on larger scenes. With a smaller
#: value, more scenes remain undecided.
_SIMPLEX_UP_TO = 2000

#: The smallest multiplier of all friction coefficients with which a scene is stable is computed up to this
#: number of joints. For larger scenes, this multiplier remains unknown.
FACTOR_UP_TO = 2000

#: Messages about locking list the joints whose normal force is at least this fraction of the median block
#: weight. Solvers return up to 1e-9 for a force of zero.
_LEAST_LISTED_FORCE = 1e-7

#: The search for the smallest friction multiplier with which a scene is stable ends after this number of
#: trials. Its result is the smallest multiplier, of those tried, with which the scene is stable.
_MOST_FACTORS = 12

#: Relative accuracy of the search for the smallest friction multiplier with which a scene is stable. The
#: search ends if the smallest stable multiplier exceeds the largest unstable multiplier by at most this
#: fraction. A smaller value needs more programs.
_MULTIPLIER_ACCURACY = 1e-3

#: Largest friction coefficient in the search for the smallest friction multiplier with which a scene is
#: stable. Solvers are less accurate with larger coefficients.
_LARGEST_FRICTION = 100.0

#: A joint supports a block if the cosine of the angle between the joint's normal and the block's dead load
#: exceeds this value.
_LEAST_SUPPORT_COSINE = 1e-6


class DeadLoadUndecided(Exception):
    """Error for a scene whose stability under the dead load could not be decided.

    Neither forces that carry the dead load nor a falling mechanism could be verified.
    """

    def __init__(self, problem: Problem, word: str) -> None:
        super().__init__(word)
        size = problem.force_sizes(problem.dead)
        #: Values for the message that stability is undecided: the status of the last solver, and the ratio of
        #: the largest to the smallest nonzero dead load of a block.
        self.values = {"word": word, "ratio": float(size.max() / size[size > 0].min(initial=np.inf))}


@dataclass
class _Standing:
    """Compiled program that finds joint forces in equilibrium with the dead load.

    It is eq. (9), the static formulation, without live load.
    """

    model: CvxpyStanding
    engine: CvxpyEngine
    #: Joint forces, shape (3c + t,), that carried the dead load when this program last found a stable scene;
    #: None if it has found no stable scene yet.
    forces: np.ndarray | None = None

    def again_for(self, problem: Problem, effort: Effort) -> "_Standing":
        """Adapt this program to the shear limits of another problem, and return the program.

        :class:`~masonry_opt.solvers.driver.ProgramCache` calls this method.
        """
        self.model.limits.set(ShearLimits.true(problem))
        self.engine.restart(effort)
        return self


def falling_mechanism(
    problem: Problem, solver: Solver, effort: Effort, cache: ProgramCache | None = None
) -> np.ndarray | None:
    """Return block velocities, shape (3b,), of a fall under the dead load; None if the scene is stable.

    See :func:`mechanism_or_forces`.
    """
    return mechanism_or_forces(problem, solver, effort, cache)[0]


def mechanism_or_forces(
    problem: Problem, solver: Solver, effort: Effort, cache: ProgramCache | None = None
) -> tuple[np.ndarray, None] | tuple[None, np.ndarray]:
    """Return a mechanism that the dead load drives; if there is none, joint forces that carry the dead load.

    The mechanism has shape (3b,), the forces have shape (3c + t,).

    The scene is stable if eq. (9) without live load is feasible. Otherwise the mechanism is a bounded dual
    ray of the program. Every analysis checks this first, because a largest λ may exist although the scene is
    not in equilibrium at λ = 0. A scene counts as stable at its limit, and beyond its limit by up to
    ``DRIVING_POWER``.

    Raises DeadLoadUndecided if neither forces nor a mechanism are verified.
    """
    by_cone, cache = problem.by_cone, cache or ProgramCache()
    chosen = in_cvxpy(solver, by_cone.by_friction.conic)

    def declared() -> _Standing:
        """Declare the program in CVXPY, and return it with the :class:`CvxpyEngine` that solves it."""
        model = CvxpyStanding(by_cone, ShearLimits.true(problem))
        engine = CvxpyEngine(model.program, chosen, effort, DEAD_LOAD, repeats=cache.keeps)
        return _Standing(model, engine)

    # Replace the live load, which the check does not need, by the dead load. Scenes with equal dead loads
    # then share one compiled program.
    unloaded = replace(problem, live=problem.dead)
    standing = cache.of((DEAD_LOAD, chosen.key), unloaded, effort, declared)
    if standing.forces is not None and carries(problem, standing.forces):
        return None, standing.forces
    standing.engine.solve()
    forces = standing.model.statics.q.value
    if forces is not None and carries(problem, forces):
        standing.forces = forces
        return None, forces
    return _decide(problem, solver, effort, DEAD_LOAD)


def _drives(problem: Problem, d: np.ndarray) -> bool:
    """Return True if velocities d, shape (3b,), are an associative mechanism that the dead load drives.

    The net power must exceed ``DRIVING_POWER``, and the violation of the flow rule must be small compared
    with the net power.
    """
    problem = problem.by_cone
    p = problem.rates(d, problem.friction)
    resisted = problem.cohesion @ problem.slip(p) + problem.face_constant @ p
    # Subtract the power that cohesion, strength and limited forces dissipate from the power of the dead load.
    power = float(problem.dead @ d - resisted)
    departure = float(np.abs(problem.departure(d, p, problem.friction)).max())
    return power > DRIVING_POWER and departure <= max(LARGEST_FLOW_VIOLATION * power, ROUNDING)


def as_it_falls(assembly: Assembly, falling: np.ndarray, effort: Effort) -> np.ndarray:
    """Return the velocities, shape (3b,), with which the blocks of an unstable scene begin to fall.

    ``falling`` is the mechanism of largest power, which may lift blocks off corners about which they rotate
    in reality. It is returned if the solver fails.
    """
    problem = assembly.problem
    low, high = assembly.geometry.boxes
    square = np.pad((high - low)[assembly.movable] ** 2, ((0, 0), (0, 1)))[:, :3]
    # For the radius of gyration, add the squares of a bounding box's two extents perpendicular to each axis
    # of rotation. In the plane, the axis is z.
    across = (square.sum(axis=1)[:, None] - square)[:, problem.layout.dimension - problem.layout.rows :]
    gyration = np.sqrt(across / 12) / problem.length_unit
    inertia = float(problem.force_sizes(problem.dead) @ problem.by_block(falling**2).sum(axis=1))
    scale = min(max(inertia / float(problem.dead @ falling), 1.0), 1 / DRIVING_POWER)
    model = CvxpyFalling(problem.by_cone, ShearLimits.true(problem), gyration, scale)
    if not has_optimum(model.program, find_solver("cvxpy", None), effort, DEAD_LOAD):
        return falling
    return np.asarray(model.mechanism.d.value) / scale


def no_optimum(problem: Problem, solver_status: str, solver: Solver, effort: Effort) -> tuple[Status, Reason]:
    """Return the status and the reason if the program of eq. (9) or (10) has no optimum for a stable scene.

    - LOCKED: the live load drives a mechanism of the joints' own flow rule, but no mechanism of associative
      flow.
    - UNLIMITED: the live load drives no mechanism of either flow rule.
    - SOLVER_FAILED: the live load drives a mechanism of associative flow, or no program decides.

    ``effort`` records the solver, but counts no programs.
    """
    effort.begins("reason why there is no load factor")
    with suppress(DeadLoadUndecided):
        own_flow, associative = (
            _driven(_of_live_load(problem, slope), solver, effort.separate_counter(), DIAGNOSIS)
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
    """Return the indices of the joints that prevent a collapse under the live load.

    The order depends on the status, with the most important joint first:

    - LOCKED: joints that slide in a mechanism of the joints' own flow rule, ordered by the opening that
      associative flow demands and the mechanism does not have.
    - UNLIMITED: joints with normal forces that carry the live load alone, ordered by these forces. Shear is
      limited by dilatancy or, if no such forces exist, by friction.
    - JAMMED: joints with normal forces that carry the live load alone, with shear limited by friction. If no
      such forces exist, the normal forces of ``q`` are used.

    The result is empty if the solver fails, and for other statuses.
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
    return order[amount[order] > max(LISTED_JOINT_SHARE * amount.max(), _LEAST_LISTED_FORCE)]


def _carrying_live_load(
    problem: Problem, slope: np.ndarray, solver: Solver, effort: Effort
) -> np.ndarray | None:
    """Return joint forces, shape (3c + t,), that carry the live load alone; None if none are found.

    ``slope`` is the slope of the shear limits, shape (k,).
    """
    loaded = _of_live_load(problem.by_cone, slope)
    carrying = CvxpyStanding(loaded, ShearLimits.true(loaded))
    if not has_optimum(carrying.program, in_cvxpy(solver, loaded.by_friction.conic), effort, DIAGNOSIS):
        return None
    return carrying.statics.forces()[1]


def _of_live_load(problem: Problem, slope: np.ndarray) -> Problem:
    """Return a problem whose dead load is the live load of ``problem``, scaled to Σ|f| = 1.

    The dead load of ``problem`` is omitted.

    ``slope`` is the slope of the shear limits, shape (k,). Cohesion, strength and finite force limits are
    zero.
    """
    alone = problem.recession_cone
    return replace(alone, dead=problem.live / problem.live_norm, law=replace(alone.law, friction=slope))


def _driven(problem: Problem, solver: Solver, effort: Effort, purpose: str) -> np.ndarray | None:
    """Return a mechanism, shape (3b,), that the dead load drives; None if joint forces carry the dead load.

    See :func:`_decide`.
    """
    return _decide(problem, solver, effort, purpose)[0]


def _decide(
    problem: Problem, solver: Solver, effort: Effort, purpose: str
) -> tuple[np.ndarray, None] | tuple[None, np.ndarray]:
    """Return a mechanism that the dead load drives; if there is none, joint forces that carry the dead load.

    The mechanism has shape (3b,), the forces have shape (3c + t,).

    The first program is solved by ``solver``, further programs by the simplex method. In space, the further
    programs replace the friction circles alternately by two kinds of polygons:

    - inscribed polygons: every force within such a polygon is inside the friction cone;
    - circumscribed polygons: every mechanism satisfies the flow rule of the friction cone.

    Each polygon gets additional corners or sides in the directions of the last slips and shears, so the two
    kinds approach each other. Raises DeadLoadUndecided if neither forces nor a mechanism are verified.
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
    """Return the slip directions of finer polygons, which replace the friction circles in the next program.

    Inscribed polygons alternate with circumscribed polygons. The first directions are evenly
    spaced. If ``motion_and_forces`` is not None, directions from the last program are added: the slips of its
    velocities, shape (3b,), and the opposites of the shears in its forces, shape (3c + t,).
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
    """Check if more friction or strength would make an unstable scene stable, and return the conclusions.

    The conclusions are reasons with these codes:

    - HANGS, if a falling block is not supported from below.
    - TIES_WOULD_HOLD, if the scene is stable with ties and props of unlimited strength.
    - STRENGTH_WOULD_HOLD, if the scene is unstable with any friction, but stable with unlimited strength.
    - NO_FRICTION_HOLDS, if the scene is unstable with any friction and with unlimited strength.
    - FRICTION_WOULD_HOLD, if the scene is stable with larger friction.

    The last four reasons are omitted if the solver cannot decide. A scene counts as stable if eq. (9) without
    live load is feasible, even if only wedging carries the dead load. ``falling`` are block velocities, shape
    (3b,).
    """
    problem = assembly.problem
    hanging = _hanging(assembly, moving_blocks(assembly, falling))
    reasons = [reason(Code.HANGS, blocks=assembly.names(assembly.movable[hanging]))] if len(hanging) else []
    reasons += _ties_that_would_hold(assembly, falling, solver, effort)
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
    unstable = Solution(Status.UNSTABLE, Kind.ASSOCIATIVE, state=FinalState(d=falling))
    slides = joint_motion(assembly, unstable).slides
    most_first = np.argsort(-assembly.most_of_joints(problem.slip_speed(falling)), kind="stable")
    pairs = assembly.pairs_of(most_first[slides[most_first]])
    return [*reasons, reason(Code.FRICTION_WOULD_HOLD, pairs=pairs, **values)]


def _ties_that_would_hold(
    assembly: Assembly, falling: np.ndarray, solver: Solver, effort: Effort
) -> list[Reason]:
    """Check if ties and props of unlimited strength make a scene stable; return a list with the reason.

    The reason TIES_WOULD_HOLD names the ties and props that yield in the fall. The list is empty if no tie or
    prop yields, if the scene remains unstable, or if the solver cannot decide. ``falling`` are block
    velocities, shape (3b,).
    """
    problem = assembly.problem
    is_strut = np.array([force.role in (Role.TIE, Role.PROP) for force in assembly.limited], dtype=bool)
    rates = np.abs(problem.B.T @ falling)[problem.B.shape[1] - len(is_strut) :]
    yields = is_strut & np.isfinite(problem.highest) & (rates > SLIDES * np.abs(falling).max())
    if not yields.any():
        return []
    highest = np.where(is_strut, np.inf, problem.highest)
    strong = replace(problem, law=replace(problem.law, highest=highest))
    with suppress(DeadLoadUndecided):
        if falling_mechanism(strong, solver, effort) is None:
            named = [assembly.limited[number] for number in np.flatnonzero(yields)]
            names = [f"{force.role} '{force.name}'" for force in named]
            return [reason(Code.TIES_WOULD_HOLD, names=names)]
    return []


def _least_factor(problem: Problem, solver: Solver, effort: Effort) -> tuple[float | None, float]:
    """Search for the smallest multiplier of all friction coefficients that makes an unstable scene stable.

    Return the smallest stable and the largest unstable factor that were tried.

    The first factor is None if the scene is stable with no factor that was tried. The search squares the
    factor until the scene is stable, and then bisects on a logarithmic scale.
    """
    stands, falls = None, 1.0
    largest = float(problem.friction.max(initial=0.0))
    if not largest or problem.joints > FACTOR_UP_TO:
        return stands, falls
    largest_factor, cache = _LARGEST_FRICTION / largest, ProgramCache(keeps=True)
    for _ in range(_MOST_FACTORS):
        if stands is None and falls < largest_factor:
            factor = min(max(2.0, falls**2), largest_factor)
        elif stands is not None and stands > falls * (1 + _MULTIPLIER_ACCURACY):
            factor = sqrt(stands * falls)
        else:
            break
        stronger = replace(problem, law=replace(problem.law, friction=factor * problem.friction))
        try:
            is_stable = falling_mechanism(stronger, solver, effort, cache) is None
        except DeadLoadUndecided:
            break
        if is_stable:
            stands = factor
        else:
            falls = factor
    return stands, falls


def _hanging(assembly: Assembly, blocks: np.ndarray) -> np.ndarray:
    """Return the movable blocks among ``blocks`` that hang: no chain of joints supports them from below.

    A chain connects a block with a support through joints, each of which supports the next block. A joint
    supports a block if its normal force acts against the block's dead load.
    """
    scene, joints, movable = assembly.scene, assembly.joints, assembly.movable
    count, forces = len(scene.blocks), assembly.problem.forces(assembly.problem.dead)
    down = np.zeros((count, forces.shape[1]))
    down[movable] = forces
    size = np.hypot.reduce(down, axis=1)
    down = np.where(size[:, None] > 0, down / np.where(size > 0, size, 1.0)[:, None], scene.down)
    first_borne = (joints.normal * down[joints.first]).sum(axis=1) < -_LEAST_SUPPORT_COSINE
    second_borne = (joints.normal * down[joints.second]).sum(axis=1) > _LEAST_SUPPORT_COSINE
    # Supports are fixed blocks, and movable blocks with support forces, such as supports that can rotate.
    support_forces = [force for force in assembly.limited if force.role is Role.SUPPORT]
    supported = [action.block for force in support_forces for action in force.actions]
    supports = np.append(np.setdiff1d(np.arange(count), movable), supported).astype(int)
    # Each edge of the graph leads from a supporting block to the block above it. An extra node, ``count``,
    # has edges to all supports.
    bears = np.concatenate([joints.second[first_borne], joints.first[second_borne], 0 * supports + count])
    borne = np.concatenate([joints.first[first_borne], joints.second[second_borne], supports])
    chains = sp.csr_array((np.ones(len(bears)), (bears, borne)), shape=(count + 1, count + 1))
    reached = breadth_first_order(chains, count, return_predecessors=False)
    return blocks[~np.isin(movable[blocks], reached)]

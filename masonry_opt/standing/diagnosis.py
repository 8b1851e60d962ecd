"""Whether a scene stands under its dead load, why a program has no optimum, and what would hold what falls.

No solver's verdict counts: forces and mechanisms are borne out by what they leave of their conditions.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order

from masonry_opt.answer.acceptance import DEPARTS, ROUNDING, Kind
from masonry_opt.answer.answer import Found
from masonry_opt.answer.motion import joint_motion, moving_blocks, moving_names
from masonry_opt.answer.reasons import Code, Reason, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import DRIVES, NAMED, SLIDES
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_cone import Senses
from masonry_opt.models.cvxpy_standing import CvxpyDriven, CvxpyFalling, CvxpyStanding, by_cones
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.cvxpy_engine import CvxpyEngine, has_optimum
from masonry_opt.solvers.driver import Kept
from masonry_opt.solvers.registry import Solver, find_solver, in_cvxpy
from masonry_opt.standing.dead_load import DEAD_LOAD, carries

DIAGNOSIS = "diagnosis"  #: Name of the solver's use for the reasons why a scene falls.

#: Programs after which it is left open whether a load drives a mechanism. (Of small random scenes
#: each took 5 at most, 14 where no program of cones ended.)
_MOST_PROGRAMS = 40

#: Joints up to which simplex is tried, which takes half a minute for each program there.
_SIMPLEX_UP_TO = 2000

#: Joints up to which the least factor on friction is looked for, the factors tried, and how near to each
#: other, relative, the least at which the scene stands and the greatest at which it falls need be.
FACTOR_UP_TO, _MOST_FACTORS, _NEAR = 2000, 12, 1e-3

#: No factor is tried that makes any friction larger: the solver would lose its digits in these rows.
_LARGEST_FRICTION = 100.0

#: Cosine between a joint's normal and a block's dead load below which the joint does not bear the block.
_BEARS = 1e-6


class DeadLoadUndecided(Exception):
    """Neither forces that carry the dead load nor a mechanism that it drives were borne out."""

    def __init__(self, problem: Problem, word: str) -> None:
        super().__init__(word)
        size = problem.force_sizes(problem.dead)
        #: Of the reason: the last solver's status, and the largest dead load of a block over the least.
        self.values = {"word": word, "ratio": float(size.max() / size[size > 0].min(initial=np.inf))}


@dataclass
class _Standing:
    """Eq. (9) without live load, compiled, with the last forces (3c,) that carried the dead load."""

    model: CvxpyStanding
    engine: CvxpyEngine
    forces: np.ndarray | None = None

    def again_for(self, problem: Problem, effort: Effort) -> "_Standing":
        """The same in another scene (see :class:`~masonry_opt.solvers.driver.Kept`)."""
        self.model.limits.set(ShearLimits.true(problem))
        self.engine.restart(effort)
        return self


def falling_mechanism(
    problem: Problem, solver: Solver, effort: Effort, kept: Kept | None = None
) -> np.ndarray | None:
    """Block velocities with which blocks fall under dead load alone, shape (3b,); None if all stand.

    The scene stands if eq. (9) without live load has a state. Else the mechanism is the bounded dual ray.
    Every analysis asks first, since a largest λ may exist where λ = 0 is no equilibrium. A scene stands at
    its limit, and beyond it by as little as ``DRIVES``. Raises DeadLoadUndecided if neither is borne out.
    """
    by_cone, kept = problem.by_cone, kept or Kept()
    chosen = in_cvxpy(solver, by_cone.by_friction.conic)

    def declared() -> _Standing:
        model = CvxpyStanding(by_cone, ShearLimits.true(problem))
        engine = CvxpyEngine(model.program, chosen, effort, DEAD_LOAD, repeats=kept.keeps)
        return _Standing(model, engine)

    # Live loads do not matter here: programs of those that share the dead load are one.
    unloaded = replace(problem, live=problem.dead)
    standing = kept.of((DEAD_LOAD, chosen.key), unloaded, effort, declared)
    if standing.forces is not None and carries(problem, standing.forces):
        return None
    standing.engine.solve()
    forces = standing.model.statics.q.value
    if forces is not None and carries(problem, forces):
        standing.forces = forces
        return None
    return _driven(problem, solver, effort, DEAD_LOAD)


def _drives(problem: Problem, d: np.ndarray) -> bool:
    """Whether the dead load drives a motion (3b,) of associative flow, beside what is rounding of either."""
    problem = problem.by_cone
    p = problem.rates(d, problem.friction)
    resisted = problem.cohesion @ problem.slip(p) + problem.face_constant @ p
    power = float(problem.dead @ d - resisted)
    departure = float(np.abs(problem.departure(d, p, problem.friction)).max())
    return power > DRIVES and departure <= max(DEPARTS * power, ROUNDING)


def as_it_falls(assembly: Assembly, falling: np.ndarray, effort: Effort) -> np.ndarray:
    """Block velocities (3b,) with which a scene begins to fall; if the solver fails the given ones, of most
    power, which may lift blocks off corners that they turn about."""
    problem = assembly.problem
    low, high = assembly.geometry.boxes
    square = np.pad((high - low)[assembly.movable] ** 2, ((0, 0), (0, 1)))[:, :3]
    # About each axis by the two extents across it; in the plane about the third alone.
    across = (square.sum(axis=1)[:, None] - square)[:, problem.layout.dimension - problem.layout.rows :]
    gyration = np.sqrt(across / 12) / problem.length_unit
    inertia = float(problem.force_sizes(problem.dead) @ problem.by_block(falling**2).sum(axis=1))
    scale = min(max(inertia / float(problem.dead @ falling), 1.0), 1 / DRIVES)
    model = CvxpyFalling(problem.by_cone, ShearLimits.true(problem), gyration, scale)
    if not has_optimum(model.program, find_solver("cvxpy", None), effort, DEAD_LOAD):
        return falling
    return np.asarray(model.mechanism.d.value) / scale


def no_optimum(problem: Problem, solver_status: str, solver: Solver, effort: Effort) -> tuple[Status, Reason]:
    """Status and reason where eq. (9) or (10) has no optimum, of a scene that stands: unlimited if the live
    load drives no mechanism; else the solver failed. The effort is told the solver, and no programs."""
    effort.begins("why there is no load factor")
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
    """Return indices of the joints that keep the live load from causing collapse, most important first.

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
        forces = next((found for found in carrying if found is not None), None)
        if forces is None and status is Status.JAMMED:
            forces = q
        if forces is None:
            return none
        amount = np.abs(problem.normal_forces(forces))
    else:
        return none
    order = np.argsort(-amount, kind="stable")
    return order[amount[order] > max(NAMED * amount.max(), DRIVES)]


def _carrying_live_load(
    problem: Problem, slope: np.ndarray, solver: Solver, effort: Effort
) -> np.ndarray | None:
    """Return forces (3c,) that carry the live load alone, with shear limits of a slope (k,); None without."""
    loaded = _of_live_load(problem.by_cone, slope)
    carrying = CvxpyStanding(loaded, ShearLimits.true(loaded))
    if not has_optimum(carrying.program, in_cvxpy(solver, loaded.by_friction.conic), effort, DIAGNOSIS):
        return None
    return carrying.statics.forces()[1]


def _of_live_load(problem: Problem, slope: np.ndarray) -> Problem:
    """The live load, of unit sum, in place of the dead, on joints with shear limits of a slope (k,) alone."""
    alone = problem.recession_cone
    return replace(alone, dead=problem.live / problem.live_norm, law=replace(alone.law, friction=slope))


def _driven(problem: Problem, solver: Solver, effort: Effort, purpose: str) -> np.ndarray | None:
    """Motion (3b,) that the dead load drives; None if forces carry it. Raises DeadLoadUndecided if neither is
    shown.

    By the solver first, then by simplex, in space with polygons in place of the circles of friction: inside
    them, which bears out forces, and round them, which bears out mechanisms, in turn. Each gets corners and
    sides where the last slips and shears point to, so that the two meet.
    """
    problem, senses = problem.by_cone, None
    solver = in_cvxpy(solver, problem.by_friction.conic)
    for program in range(_MOST_PROGRAMS if problem.joints <= _SIMPLEX_UP_TO else 1):
        model = CvxpyDriven(problem, ShearLimits.true(problem), senses)
        solved = CvxpyEngine(model.program, solver, effort, purpose).solve()
        found = model.read()
        if found is not None and _drives(problem, found[0]):
            return found[0]
        if found is not None and carries(problem, found[1]):
            return None
        if program and senses is None:
            break
        solver = find_solver("cvxpy", "highs", 1e-10)
        senses = _finer(problem, found, senses) if by_cones(problem) else None
    raise DeadLoadUndecided(problem, solved.status)


def _finer(problem: Problem, found: tuple[np.ndarray, np.ndarray] | None, senses: Senses | None) -> Senses:
    """Senses all round by default, and of the slips in a motion (3b,) and against shears in forces (3c,)."""
    if senses is None:
        every, points = problem.layout.senses, np.arange(len(problem.sliding))
        senses = Senses(np.tile(points, len(every)), np.repeat(every.T, len(points), axis=1), inside=False)
    point, along, inside = senses
    if found is not None:
        for vectors in (problem.B.T @ found[0], -found[1]):
            shears = problem.shears(vectors)[:, problem.sliding]
            size = np.hypot(*shears)
            some = np.flatnonzero(size > ROUNDING)
            point, along = np.append(point, some), np.append(along, shears[:, some] / size[some], axis=1)
    return Senses(point, along, not inside)


def what_would_hold(assembly: Assembly, falling: np.ndarray, solver: Solver, effort: Effort) -> list[Reason]:
    """Reasons that tell what would hold a scene that falls with block velocities (3b,): HANGS, if any of the
    blocks does; then NO_FRICTION_HOLDS, FRICTION_WOULD_HOLD or STRENGTH_WOULD_HOLD, if the solver can tell.
    To hold means that eq. (9) without live load has a state, perhaps of wedging alone."""
    problem = assembly.problem
    hanging = _hanging(assembly, moving_blocks(assembly, falling))
    found = [reason(Code.HANGS, blocks=assembly.names(assembly.movable[hanging]))] if len(hanging) else []
    none, nothing = np.array([], dtype=int), np.array([])
    rough = replace(problem.law, sliding=none, friction=nothing, cohesion=nothing, dilatancy=nothing)
    rough = replace(rough, dilatancy_force=np.empty((0, 2)))
    stuck = replace(assembly, problem=replace(problem, law=rough))
    try:
        falls_all_the_same = falling_mechanism(stuck.problem, solver, effort)
    except DeadLoadUndecided:
        return found
    if falls_all_the_same is not None:
        strong = replace(problem, law=replace(problem.law, crushing=none, crushing_force=nothing))
        with suppress(DeadLoadUndecided):
            if len(problem.crushing) and falling_mechanism(strong, solver, effort) is None:
                return [*found, reason(Code.STRENGTH_WOULD_HOLD)]
        falls_all_the_same = as_it_falls(stuck, falls_all_the_same, effort)
        return [*found, reason(Code.NO_FRICTION_HOLDS, blocks=moving_names(assembly, falls_all_the_same))]
    factor, above = _least_factor(problem, solver, effort)
    values = {"factor": factor, "above": above, "hangs": bool(len(hanging))}
    falls = Solution(Status.UNSTABLE, Kind.ASSOCIATIVE, found=Found(d=falling))
    slides = joint_motion(assembly, falls).slides
    most_first = np.argsort(-assembly.most_of_joints(problem.slip_speed(falling)), kind="stable")
    pairs = assembly.pairs_of(most_first[slides[most_first]])
    return [*found, reason(Code.FRICTION_WOULD_HOLD, pairs=pairs, **values)]


def _least_factor(problem: Problem, solver: Solver, effort: Effort) -> tuple[float | None, float]:
    """The least factor on all friction at which the scene stands, None if none is found, and the greatest at
    which it falls: by squaring, then by bisection of their logarithms."""
    stands, falls = None, 1.0
    largest = float(problem.friction.max(initial=0.0))
    if not largest or problem.joints > FACTOR_UP_TO:
        return stands, falls
    most, kept = _LARGEST_FRICTION / largest, Kept(keeps=True)
    for _ in range(_MOST_FACTORS):
        if stands is None and falls < most:
            factor = min(max(2.0, falls**2), most)
        elif stands is not None and stands > falls * (1 + _NEAR):
            factor = sqrt(stands * falls)
        else:
            break
        stronger = replace(problem, law=replace(problem.law, friction=factor * problem.friction))
        try:
            holds = falling_mechanism(stronger, solver, effort, kept) is None
        except DeadLoadUndecided:
            break
        stands, falls = (factor, falls) if holds else (stands, factor)
    return stands, falls


def _hanging(assembly: Assembly, blocks: np.ndarray) -> np.ndarray:
    """Those of some of the problem's blocks that no chain of bearing joints leads to from a support. A joint
    bears a block if its normal pushes against the block's dead load."""
    scene, joints, movable = assembly.scene, assembly.joints, assembly.movable
    count, forces = len(scene.blocks), assembly.problem.forces(assembly.problem.dead)
    down = np.zeros((count, forces.shape[1]))
    down[movable] = forces
    size = np.hypot.reduce(down, axis=1)
    down = np.where(size[:, None] > 0, down / np.where(size > 0, size, 1.0)[:, None], scene.down)
    first_borne = (joints.normal * down[joints.first]).sum(axis=1) < -_BEARS
    second_borne = (joints.normal * down[joints.second]).sum(axis=1) > _BEARS
    # From what bears to what is borne, and from one node more to all supports; some may turn.
    held = [of.block for force in assembly.limited if force.role is Role.SUPPORT for of in force.actions]
    supports = np.append(np.setdiff1d(np.arange(count), movable), held).astype(int)
    bears = np.concatenate([joints.second[first_borne], joints.first[second_borne], 0 * supports + count])
    borne = np.concatenate([joints.first[first_borne], joints.second[second_borne], supports])
    chains = sp.csr_array((np.ones(len(bears)), (bears, borne)), shape=(count + 1, count + 1))
    reached = breadth_first_order(chains, count, return_predecessors=False)
    return blocks[~np.isin(movable[blocks], reached)]

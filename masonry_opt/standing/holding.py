"""Remedies for a scene that falls under its dead load: friction, and how much of it, strength, or support."""

from dataclasses import replace
from math import sqrt

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Found
from masonry_opt.answer.motion import joint_motion, moving_blocks, moving_names
from masonry_opt.answer.reasons import Code, Reason, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.driver import Kept
from masonry_opt.solvers.registry import Solver
from masonry_opt.standing.diagnosis import DeadLoadUndecided, as_it_falls, falling_mechanism

#: Joints up to which the least factor on friction is looked for, the factors tried, and how near to each
#: other, relative, the least at which the scene stands and the greatest at which it falls need be.
FACTOR_UP_TO, _MOST_FACTORS, _NEAR = 2000, 12, 1e-3

#: No factor is tried that makes any friction larger: the solver would lose its digits in these rows.
_LARGEST_FRICTION = 100.0

#: Cosine between a joint's normal and a block's dead load below which the joint does not bear the block.
_BEARS = 1e-6


def what_would_hold(assembly: Assembly, falling: np.ndarray, solver: Solver, effort: Effort) -> list[Reason]:
    """Reasons that tell what would hold a scene that falls under its dead load, with block velocities (3b,):
    HANGS, if any of the blocks that fall do; then NO_FRICTION_HOLDS, FRICTION_WOULD_HOLD or
    STRENGTH_WOULD_HOLD, if the solver, which decided that the scene falls, can tell. To hold means that
    eq. (9) without live load has a state, perhaps of wedging alone."""
    problem = assembly.problem
    hanging = _hanging(assembly, moving_blocks(assembly, falling))
    found = [reason(Code.HANGS, blocks=assembly.names(assembly.movable[hanging]))] if len(hanging) else []
    stuck = replace(assembly, problem=_that_cannot_slide(problem))
    try:
        falls_all_the_same = falling_mechanism(stuck.problem, solver, effort)
    except DeadLoadUndecided:
        return found
    if falls_all_the_same is not None:
        if len(problem.crushing) and _stands_uncrushed(problem, solver, effort):
            return [*found, reason(Code.STRENGTH_WOULD_HOLD)]
        falls_all_the_same = as_it_falls(stuck, falls_all_the_same, effort)
        return [*found, reason(Code.NO_FRICTION_HOLDS, blocks=moving_names(assembly, falls_all_the_same))]
    factor, above = _least_factor(problem, solver, effort)
    values = {"factor": factor, "above": above, "hangs": bool(len(hanging))}
    pairs = assembly.pairs_of(_sliding(assembly, falling))
    return [*found, reason(Code.FRICTION_WOULD_HOLD, pairs=pairs, **values)]


def _that_cannot_slide(problem: Problem) -> Problem:
    """The same problem with unlimited friction at all joints."""
    none, nothing = np.array([], dtype=int), np.array([])
    law = replace(problem.law, sliding=none, friction=nothing, cohesion=nothing, dilatancy=nothing)
    return replace(problem, law=replace(law, dilatancy_force=np.empty((0, 2))))


def _stands_uncrushed(problem: Problem, solver: Solver, effort: Effort) -> bool:
    """Whether a scene stands if its joints carry any pressure."""
    law = replace(problem.law, crushing=np.array([], dtype=int), crushing_force=np.array([]))
    try:
        return falling_mechanism(replace(problem, law=law), solver, effort) is None
    except DeadLoadUndecided:
        return False


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


def _sliding(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Joints that slide in a mechanism (3b,), those that slide most first."""
    slip = assembly.most_of_joints(assembly.problem.slip_speed(d))
    slides = joint_motion(assembly, Solution(Status.UNSTABLE, Kind.ASSOCIATIVE, found=Found(d=d))).slides
    order = np.argsort(-slip, kind="stable")
    return order[slides[order]]


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

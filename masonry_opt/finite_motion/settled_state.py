"""Compute the state of a scene after supports have moved by given amounts."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from masonry_opt.effort import Effort
from masonry_opt.errors import OptionError
from masonry_opt.finite_motion.freed_supports import (
    freed_along,
    reaction_at_rest,
    refuse_idle,
    refuse_overlapping,
    supports_of,
)
from masonry_opt.finite_motion.moved_blocks import overlapping
from masonry_opt.finite_motion.settled_contacts import Contacts, SettlementBlockedError
from masonry_opt.methods.associative import associative
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.settled import Movements, SettledState
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import MOVES
from masonry_opt.solvers.registry import MATRICES, find_solver

#: Part of error messages that shows how movements of supports are specified.
_FORM = "'settled' needs the movement of each support by name, such as {'pier': (0, -0.02)}"
#: An opened joint of limited strength is assumed to carry forces over at least this fraction of its length.
#: Without this minimum, a joint that carries no force before the settlement could carry none afterwards.
_LEAST_DEPTH = 0.01
#: If the blocks cannot follow a movement of the supports, the movement is halved up to this many times, to
#: find a movement that the blocks can follow.
_MOST_HALVINGS_OF_MOVEMENT = 5


def settled_scene(scene: Scene, settled: Movements | None) -> Scene:
    """Move the supports of a plane scene under its dead load, and return the displaced scene.

    The blocks move in the mechanism of the least reaction of the supports, which the default method of
    ``solve`` computes. The returned scene contains the new positions of the blocks, the contacts that stay
    closed, and the joint forces.

    Parameters
    ----------
    scene: The scene, in its load case.
    settled: Movement of each support by name, ``(x, y)`` or ``(x, y, rotation)``: a translation of its
        centroid in the unit of length, and a rotation in radians. If it is None, the scene itself is
        returned.

    Raises
    ------
    OptionError
        If a support does not exist, is a movable block, or touches no movable block; if supports overlap
        where a block rests on both, and turn or do not have the same translation; if a movement is not two or
        three numbers, or is so large that the mechanism changes; if blocks are solids; if the scene is
        unstable, or does not follow the supports.
    CaseError
        If the scene is wrong.
    """
    if settled is None:
        return scene
    scene.refuse_without_case()
    if scene.dimension == 3:
        raise OptionError(
            f"{scene.origin}: 'settled' needs a scene in the plane: omit 'settled', or model a plane section"
        )
    if scene.settled is not None:
        raise OptionError(f"{scene.origin}: the supports have settled already: specify all movements at once")
    movements = _movements(scene, settled)
    assembly = assemble(scene)
    if _falls(assembly.problem):
        raise OptionError(
            f"{scene.origin}: the scene is unstable under its dead load before its supports settle: run "
            "'solve' without 'settled' to see which blocks fall"
        )
    names = sorted(movements, key=[block.name for block in scene.blocks].index)
    supports = supports_of(scene, names)
    motions = np.array([movements[name] for name in names])
    refuse_overlapping(assembly, supports, motions[:, :2], motions[:, 2] != 0)
    units = np.array([1.0, 1.0, assembly.problem.length_unit])
    free = freed_along(assembly, supports, motions * units)
    refuse_idle(assembly, free, supports)
    solution = _mechanism(assembly, free)
    scale = _scale(free, supports, motions * units, solution)
    state = _state(assembly, free, solution, scale, movements)
    if isinstance(state, SettledState):
        return scene.settled_as(state)
    for halving in range(1, _MOST_HALVINGS_OF_MOVEMENT + 1):
        share = 0.5**halving
        if isinstance(_state(assembly, free, solution, share * scale, movements), SettledState):
            remedy = f"use a smaller movement, such as {share:g} times this movement"
            raise OptionError(f"{scene.origin}: 'settled' is not possible, because {state}: {remedy}")
    raise OptionError(
        f"{scene.origin}: 'settled' is not possible, because {state}: use a much smaller movement, or omit "
        "'settled'"
    )


def _movements(scene: Scene, settled: Movements) -> dict[str, tuple[float, float, float]]:
    """Return a dictionary from the name of each support to its movement (x, y, rotation).

    Raises OptionError if a name is not that of a support or occurs twice, or if a movement is wrong.
    """
    try:
        pairs = list(settled.items() if isinstance(settled, Mapping) else settled)
        names = [name for name, _ in pairs]
    except (TypeError, ValueError):
        raise OptionError(f"{scene.origin}: {_FORM} (found {settled!r})") from None
    if not names:
        raise OptionError(f"{scene.origin}: {_FORM} (found {settled!r})")
    supports_of(scene, names, "settled")
    movements: dict[str, tuple[float, float, float]] = {}
    for name, movement in pairs:
        try:
            numbers = tuple(float(part) for part in movement)
        except (TypeError, ValueError):
            numbers = ()
        if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)) or not any(numbers):
            needs = "the movement needs finite numbers (x, y) or (x, y, rotation), not all of them zero"
            raise OptionError(f"{scene.origin}: 'settled' of support '{name}': {needs} (found {movement!r})")
        movements[name] = (numbers[0], numbers[1], numbers[2] if len(numbers) == 3 else 0.0)
    return movements


def _falls(problem: Problem) -> bool:
    """Return True if a scene is unstable under its dead load; False if it is stable or undecided."""
    # The import is local, because it loads CVXPY, which takes a second. All studies import this module, but
    # few of them move supports.
    from masonry_opt.stability.diagnosis import DeadLoadUndecided, falling_mechanism

    try:
        return falling_mechanism(problem, find_solver("cvxpy", None), Effort()) is not None
    except DeadLoadUndecided:
        return False


def _mechanism(assembly: Assembly, free: Assembly) -> Solution:
    """Return the mechanism and the forces at the least reaction of the moving supports, as a solution.

    The default method of ``solve`` computes the solution. If the method finds no exact state of Coulomb
    friction, the solution has associative flow. Raises OptionError if the least reaction is not found.
    """
    rest = reaction_at_rest(assembly.problem, free.problem, assembly.problem.B.shape[1])
    problem = free.problem
    if rest is not None:
        reaction, forces = rest
        problem = replace(problem, dead=problem.dead - reaction * problem.live, settled=forces)
        solver = find_solver(MATRICES, None)
        pushed = METHODS["incremental"].run(Task(problem, solver))
        options = METHODS[DEFAULT].options
        task = Task(problem, solver, options=options and options(), incremental=pushed)
        solution = METHODS[DEFAULT].run(task).accepted()
        if solution.d is not None and solution.load_factor is not None:
            return solution
    solution = associative(Task(free.problem)).accepted()
    if solution.d is None or solution.load_factor is None:
        raise OptionError(
            f"{assembly.scene.origin}: option 'settled' needs the least reaction of the supports, which was "
            "not found: try another direction of movement, or see the reactions with the function 'settle'"
        )
    return solution


def _scale(free: Assembly, supports: np.ndarray, motions: np.ndarray, solution: Solution) -> float:
    """Return the factor by which the mechanism is multiplied to reach the given movements of the supports.

    ``motions`` are the movements in the units of the problem, shape (k, 3). Raises OptionError if the
    supports do not move in the mechanism.
    """
    assert solution.d is not None
    rates = free.problem.by_block(solution.d)
    of_supports = rates[np.searchsorted(free.movable, supports)]
    along = float((of_supports * motions).sum()) / float((motions**2).sum())
    if along * np.abs(motions).max() <= MOVES * np.abs(rates).max():
        raise OptionError(
            f"{free.scene.origin}: 'settled' is not possible, because blocks fall even if supports do not "
            "move: increase the friction, or move the supports in another direction"
        )
    return 1.0 / along


def _state(
    assembly: Assembly,
    free: Assembly,
    solution: Solution,
    scale: float,
    movements: Mapping[str, tuple[float, float, float]],
) -> SettledState | str:
    """Return the state after a settlement, or a sentence that says why the blocks cannot follow."""
    supports = np.setdiff1d(free.movable, assembly.movable)
    contacts = Contacts.of(free, solution, scale, supports)
    try:
        poses = contacts.poses()
        remaining, joints = contacts.displaced_joints(poses)
    except SettlementBlockedError as reason:
        return str(reason)
    meeting = overlapping(assembly.geometry, poses, contacts.bodies, contacts.crushed_overlaps(poses))
    if meeting:
        first, second = assembly.names(np.array(meeting))
        return f"blocks '{first}' and '{second}' collide before the supports reach their new positions"
    assert solution.q is not None
    forces = free.problem.by_kind(solution.q)[:, remaining].ravel()
    shown: dict[str, Any] = {name: _short(movement) for name, movement in movements.items()}
    count = len(assembly.joints.first)
    # The last limited forces of ``free`` restrain the moving supports, and do not exist in the assembly with
    # fixed supports. Omit them.
    limited = free.problem.of_forces(solution.q)[: len(assembly.limited)]
    state = SettledState(shown, poses, remaining, joints, count, forces, limited, assembly.problem.dead)
    problem = assemble(assembly.scene.settled_as(state)).problem
    if _falls(_opened(problem, contacts.carrying_depths(remaining), contacts.far_ends(remaining))):
        return "the masonry falls under its dead load before the supports reach their new positions"
    return state


def _opened(problem: Problem, depths: np.ndarray, first_is_far: np.ndarray) -> Problem:
    """Return a problem in which each opened joint carries forces over only a part of its length.

    The part begins at the near end of the joint, which touches. The force of the far end acts at the end of
    this part. A crushing joint has the strength of this part.

    Parameters
    ----------
    problem: The problem of the displaced blocks.
    depths: Depth of each joint that carries forces, relative to its length, shape (joints,).
    first_is_far: True where the first end of a joint is its far end, shape (joints,).
    """
    joints, columns = problem.joints, problem.B.shape[1]
    number = np.arange(joints)
    far = np.where(first_is_far, number, joints + number)
    near = np.where(first_is_far, joints + number, number)
    shares = sp.lil_array((columns, columns))
    shares.setdiag(1.0)
    shares[far, far] = depths
    shares[near, far] = 1.0 - depths
    B = sp.csr_array(problem.B @ sp.csr_array(shares))
    of_crushing = np.maximum(depths[problem.crushing], _LEAST_DEPTH)
    law = replace(problem.law, crushing_force=problem.law.crushing_force * of_crushing)
    return replace(problem, matrices=replace(problem.matrices, B=B), law=law, settled=None)


def _short(movement: tuple[float, float, float]) -> tuple[float, ...]:
    """Return the short form of a movement: (x, y) if its rotation is zero, otherwise (x, y, rotation)."""
    return movement if movement[2] else movement[:2]

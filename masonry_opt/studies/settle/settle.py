"""Function ``settle``: the least and the greatest reaction of supports with which a scene is stable.

The supports become blocks without weight that can move in one direction only. A live load pushes them along
this direction or against it, and the collapse load factor of this live load gives the limit reaction.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.analysis import prepare
from masonry_opt.effort import Effort, ignore_progress, phases_from
from masonry_opt.errors import OptionError, rounded
from masonry_opt.finite_motion.freed_supports import (
    freed,
    reaction_at_rest,
    refuse_idle,
    refuse_overlapping,
    supports_of,
)
from masonry_opt.methods.associative import associative
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import COORDINATES, coordinates
from masonry_opt.studies.settle.answer import Settlement
from masonry_opt.studies.settle.bound import Bound


def settle(
    scene: Scene | str | Path,
    support: str | Sequence[str],
    direction: Sequence[float],
    *,
    turns: bool = False,
    movement: float | None = None,
    load_case: str | None = None,
    method: str = DEFAULT,
    **options: Any,
) -> Settlement:
    """Find the least and the greatest reaction of supports with which a scene is stable under its dead load.

    The support moves in one direction (it settles), or against it (it is pushed back), and does not move or
    turn otherwise. Its reaction is the force of the ground against the direction of settlement, positive if
    the ground presses on the support. The reaction decreases to its least value as the support settles, and
    increases to its greatest value as the support is pushed back. Both values may be negative (the ground
    must pull), or unlimited.

    Live loads of the scene are ignored. The ground carries the weight and the loads of the supports.

    Parameters
    ----------
    scene: a scene, or the path of a case file.
    support: name of a fixed block. Several supports move at a common rate, and the reaction is their sum.
    direction: direction in which the support settles, ``(x, y)``, in space ``(x, y, z)``, of any length.
    turns: True if each support can also turn, also at rest; the reaction then passes through its centroid.
    movement: movement of the support in this direction, in the unit of length, at which openings are reported
        too.
    load_case: name of the load case whose dead loads are applied.
    method, options: as for :func:`~masonry_opt.solve`, including ``model``, ``solver``, ``phases``, ...

    Returns
    -------
    Settlement
        Both reactions, with the mechanisms, and openings of joints per unit of settlement.

    Raises
    ------
    CaseError
        If the case file or the scene is wrong.
    OptionError
        If a support does not exist, can move already, or touches no block that can move; if supports overlap
        where a block rests on both, and turn or do not settle together; if the direction is not a vector of
        the scene's dimension; if the movement is not above zero, or so large that openings of small motions
        are inaccurate; or for the reasons of :func:`~masonry_opt.solve`.
    """
    phases = phases_from(options)
    session = prepare(method, function=settle, **options)
    scene, effort = as_scene(scene, load_case), Effort(phases)
    scene.refuse_without_case()
    _refuse_movement(scene, movement)
    if not isinstance(turns, bool):
        raise OptionError(f"{scene.origin}: 'turns' must be True or False (found {turns!r})")
    supports = supports_of(scene, support)
    along = _unit_of(scene, direction)
    effort.begins("finding joints")
    assembly = assemble(scene)
    refuse_overlapping(assembly, supports, along, turns)
    problem = assembly.problem
    unit = problem.force_unit * (float(problem.force_sizes(problem.dead).sum()) or 1.0)
    settling = freed(assembly, supports, along, unit, turns)
    pushed_back = freed(assembly, supports, along, -unit, turns)
    refuse_idle(assembly, settling, supports)
    answer = partial(Settlement, case=scene.called, turns=turns, method=method, assembly=assembly)
    answer = partial(answer, supports=tuple(assembly.names(supports)), direction=tuple(along.tolist()))
    fixed = freed(assembly, supports, along, None, turns) if turns else assembly
    fallen = session.falls(fixed, effort)
    if fallen:
        return answer(fallen=fallen)
    effort.begins("reaction at rest")
    rest = reaction_at_rest(fixed.problem, settling.problem, problem.B.shape[1])
    if rest is None:
        # The incremental analysis cannot start, because the joint forces at rest are unknown.
        session = session.without_incremental()
        # Joint forces are known only at the least and at the greatest associative reaction. The least and the
        # greatest Coulomb reaction are between these two. The search for the least reaction decreases the
        # reaction, so it starts at the greatest associative reaction. The search for the greatest reaction
        # increases the reaction, so it starts at the least associative reaction.
        start_pushed_back, start_settling = _ends_by_statics(settling.problem, pushed_back.problem)
    else:
        start_settling = start_pushed_back = rest
    sessions = [session] if session.method.associative else [session, prepare("static")]

    def bound(assembly: Assembly, sign: float, start: float, settled: np.ndarray | None) -> Bound:
        """Return the least reaction (``sign`` 1) or the greatest reaction (``sign`` -1).

        The analysis begins at the reaction ``start``, relative to the live load. ``settled`` has the joint
        forces at this reaction, or is None.
        """
        dead = assembly.problem.dead - sign * start * assembly.problem.live
        preloaded = replace(assembly, problem=replace(assembly.problem, dead=dead, settled=settled))
        results = [method.push(preloaded, ignore_progress, Effort(phases)) for method in sessions]
        end = Bound(results[0], results[-1], unit * start, -sign * unit, movement)
        if movement is not None and movement > end.largest_movement:
            raise OptionError(
                f"{scene.origin}: 'movement' must be at most {rounded(end.largest_movement)}, because "
                f"openings are calculated for small rotations of the blocks (found {movement:g})"
            )
        return end

    at_rest = None if rest is None else unit * rest[0]
    least = bound(settling, 1.0, *start_settling)
    greatest = bound(pushed_back, -1.0, *start_pushed_back)
    return answer(at_rest=at_rest, least=least, greatest=greatest)


def _refuse_movement(scene: Scene, movement: float | None) -> None:
    """Raise OptionError if a movement is not a finite number above zero."""
    if movement is None:
        return
    is_number = isinstance(movement, int | float) and not isinstance(movement, bool)
    if not is_number or not 0 < movement < np.inf:
        raise OptionError(
            f"{scene.origin}: 'movement' must be a length above zero, such as 0.02 (found {movement!r}); use "
            "'direction' to set the direction of the movement"
        )


def _ends_by_statics(settling: Problem, pushed_back: Problem) -> list[tuple[float, np.ndarray | None]]:
    """Return the least and the greatest reaction with associative flow, each with its joint forces.

    The reactions are relative to the live load. An unlimited reaction is replaced by a number that differs
    from the other reaction by 1.
    """
    least, greatest = associative(Task(settling)), associative(Task(pushed_back))
    low = None if least.load_factor is None else -least.load_factor
    high = greatest.load_factor
    if low is None:
        low = 0.0 if high is None else high - 1.0
    if high is None:
        high = low + 1.0
    return [(low, least.q), (high, greatest.q)]


def _unit_of(scene: Scene, direction: Sequence[float]) -> np.ndarray:
    """Return the unit vector of a direction.

    Raises OptionError if the direction is not a vector of the scene's dimension.
    """
    vector = coordinates(direction, scene.dimension)
    if vector is None or not vector.any():
        needed = f"{COORDINATES[scene.dimension]}, not all of them zero"
        raise OptionError(f"{scene.origin}: 'direction' must be {needed} (found {direction!r})")
    vector = vector / np.abs(vector).max()
    return vector / np.linalg.norm(vector)

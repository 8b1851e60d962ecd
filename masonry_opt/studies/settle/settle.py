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
from pydantic import BaseModel

from masonry_opt.analysis import prepare
from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import OptionError
from masonry_opt.methods.associative import associative
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import Assembly, assemble, with_supports_freed
from masonry_opt.problem.limited_forces import Action, LimitedForce, Role
from masonry_opt.problem.loads import moments_in
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.mistakes import did_you_mean
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import COORDINATES, coordinates
from masonry_opt.solution.thresholds import ZERO
from masonry_opt.stability.dead_load import carries
from masonry_opt.studies.settle.answer import Bound, Settlement


def settle(
    scene: Scene | str | Path,
    support: str | Sequence[str],
    direction: Sequence[float],
    *,
    turns: bool = False,
    load_case: str | None = None,
    method: str = DEFAULT,
    phases: Phases = lambda _: None,
    **options: Any,
) -> Settlement:
    """Find the least and the greatest reaction of supports with which a scene is stable under its dead load.

    The support moves in one direction (it settles), or against it (it is pushed back), and does not move or
    turn otherwise. Its reaction is the force of the ground against the direction of settlement, positive if
    the ground presses on the support. The reaction falls to the least as the support settles, and grows to
    the greatest as it is pushed back. Both may be negative (the ground must pull), or unlimited.

    Live loads of the scene are ignored. The ground carries the weight and the loads of the supports.

    Parameters
    ----------
    scene: a scene, or the path of a case file.
    support: name of a fixed block. Several supports move at a common rate, and the reaction is their sum.
    direction: direction in which the support settles, ``(x, y)``, in space ``(x, y, z)``, of any length.
    turns: True if each support can also turn, also at rest; the reaction then passes through its centroid.
    load_case: name of the load case whose dead loads act.
    method, phases, options: as of :func:`~masonry_opt.solve`, its model, solver, ... too.

    Returns
    -------
    Settlement
        Both reactions, with the mechanisms, and openings of joints per unit of settlement.

    Raises
    ------
    CaseError
        If the case file or the scene is wrong.
    OptionError
        If a support does not exist, can move already, or touches no block that can move; if the direction is
        not a vector of the scene's dimension; or as :func:`~masonry_opt.solve`.
    """
    session = prepare(method, **options)
    scene, effort = as_scene(scene, load_case), Effort(phases)
    scene.refuse_without_case()
    supports = _supports_of(scene, support)
    along = _unit_of(scene, direction)
    effort.begins("finding joints")
    assembly = assemble(scene)
    problem = assembly.problem
    unit = problem.force_unit * (float(problem.force_sizes(problem.dead).sum()) or 1.0)
    settling = _freed(assembly, supports, along, unit, turns)
    pushed_back = _freed(assembly, supports, along, -unit, turns)
    _refuse_idle(assembly, settling, supports)
    answer = partial(Settlement, case=scene.called, turns=turns, method=method, assembly=assembly)
    answer = partial(answer, supports=tuple(assembly.names(supports)), direction=tuple(along.tolist()))
    held = _freed(assembly, supports, along, None, turns) if turns else assembly
    fallen = session.falls(held, effort)
    if fallen:
        return answer(fallen=fallen)
    effort.begins("reaction at rest")
    rest = _at_rest(held.problem, settling.problem, problem.B.shape[1])
    if rest is None:
        # No forces at rest are known, so the incremental analysis has no start. The search for one end of the
        # range starts at the other end with associative flow, where the forces are known.
        session = session.without_incremental()
        start_pushed_back, start_settling = _ends_by_statics(settling.problem, pushed_back.problem)
    else:
        start_settling = start_pushed_back = rest
    sessions = [session] if session.method.associative else [session, prepare("static")]

    def bound(freed: Assembly, sign: float, start: float, settled: np.ndarray | None) -> Bound:
        """Return the limit reaction for one sense of motion; the push starts at known joint forces."""
        dead = freed.problem.dead - sign * start * freed.problem.live
        preloaded = replace(freed, problem=replace(freed.problem, dead=dead, settled=settled))
        results = [method.push(preloaded, lambda _: None, Effort(phases)) for method in sessions]
        return Bound(results[0], results[-1], start=unit * start, per_load_factor=-sign * unit)

    at_rest = None if rest is None else unit * rest[0]
    least = bound(settling, 1.0, *start_settling)
    greatest = bound(pushed_back, -1.0, *start_pushed_back)
    return answer(at_rest=at_rest, least=least, greatest=greatest)


def _at_rest(held: Problem, settling: Problem, own: int) -> tuple[float, np.ndarray] | None:
    """Return the reaction at rest with elastic contacts (relative to the live load) and the joint forces.

    The forces are those of the problem with settling supports. The first ``own`` of them are those of the
    scene, the others hold the supports in the directions in which they do not move. Return None if the
    elastic contacts do not come to carry the dead load.
    """
    if held.joints > IncrementalSettings().most_joints or held.dilatancy_depends_on_stress:
        return None
    q = IncrementalAnalysis(held).preload_forces
    if q is None or not carries(held, q, ZERO):
        return None
    on_blocks = settling.B[:, :own] @ q[:own]
    reaction = float(on_blocks @ settling.live / (settling.live @ settling.live))
    left = on_blocks + settling.dead - reaction * settling.live
    q = np.append(q[:own], np.linalg.lstsq(settling.B[:, own:].toarray(), -left, rcond=None)[0])
    # A reaction of the size of rounding errors is set to zero, because solvers would scale the loads by it.
    return reaction if abs(reaction) > ZERO else 0.0, q


def _ends_by_statics(settling: Problem, pushed_back: Problem) -> list[tuple[float, np.ndarray | None]]:
    """Return the least and greatest associative reactions (relative to the live load), with joint forces.

    An unlimited reaction is replaced by a number that differs from the other reaction by 1.
    """
    least, greatest = associative(Task(settling)), associative(Task(pushed_back))
    low = None if least.load_factor is None else -least.load_factor
    high = greatest.load_factor
    if low is None:
        low = 0.0 if high is None else high - 1.0
    if high is None:
        high = low + 1.0
    return [(low, least.q), (high, greatest.q)]


def _supports_of(scene: Scene, support: str | Sequence[str]) -> np.ndarray:
    """Return the indices of supports by name.

    Raises OptionError if a name is unknown or occurs twice.
    """
    names: list[Any] = list(support) if isinstance(support, list | tuple) else [support]
    known = {block.name: number for number, block in enumerate(scene.blocks)}
    fixed = [block.name for block in scene.blocks if block.fixed]
    if not names or not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
        raise OptionError(f"{scene.origin}: 'support' must name each support once (found {support!r})")
    for name in names:
        if name not in known:
            instead = did_you_mean(name, fixed) or f"; supports: {', '.join(fixed)}"
            raise OptionError(f"{scene.origin}: support: no block '{name}'{instead}")
        if name not in fixed:
            choice = f"a block with 'fixed = true': {', '.join(fixed)}"
            raise OptionError(f"{scene.origin}: support '{name}' can move already: name {choice}")
    return np.array([known[name] for name in names])


def _unit_of(scene: Scene, direction: Sequence[float]) -> np.ndarray:
    """Return the unit vector of a direction.

    Raises OptionError if the direction is not a vector of the scene's dimension.
    """
    vector = coordinates(direction, scene.dimension)
    if vector is None or not vector.any():
        needed = f"{COORDINATES[scene.dimension]}, not all of them zero"
        raise OptionError(f"{scene.origin}: direction: needs {needed} (found {direction!r})")
    vector = vector / np.abs(vector).max()
    return vector / np.linalg.norm(vector)


def _refuse_idle(assembly: Assembly, freed_of: Assembly, supports: np.ndarray) -> None:
    """Raise OptionError if a support touches no block that can move."""
    scene, forces = assembly.scene, assembly.problem.B.shape[1]
    touched = freed_of.problem.by_block(np.abs(freed_of.problem.B[:, :forces]).sum(axis=1)).any(axis=1)
    for support in np.setdiff1d(supports, freed_of.movable[touched], assume_unique=True):
        idle = f"support '{scene.blocks[support].name}' touches no block that can move"
        raise OptionError(f"{scene.origin}: {idle}: its settlement changes nothing")


def _freed(
    assembly: Assembly, supports: np.ndarray, direction: np.ndarray, push: float | None, turns: bool
) -> Assembly:
    """Return an assembly whose chosen supports can move in one direction, at a common rate.

    The supports become blocks without weight. Forces without limits restrain them across the direction and
    against rotation, and couple several supports along the direction. The live load is a push along the
    direction, shared by the supports.

    Parameters
    ----------
    assembly: Assembly of the scene with fixed supports.
    supports: Indices of the supports, shape (k,).
    direction: Unit vector.
    push: Live load in the case's unit of force; without a push the supports cannot move along the direction.
    turns: True if the supports can turn about their centroids.
    """
    held = push is None
    across = np.linalg.svd(direction[None])[2][0 if held else 1 :]
    # Moments are written as couples with the length unit as lever arm, so that all restraints are forces of
    # similar size.
    couples = assembly.problem.length_unit * np.eye(moments_in(len(direction)))
    restraints: list[LimitedForce] = []
    previous = None
    for support in supports.tolist():
        name, point = assembly.scene.blocks[support].name, assembly.geometry.centroid[support]
        actions = [Action(support, point, unit) for unit in across]
        if not turns:
            actions += [Action(support, point, np.zeros(len(direction)), couple) for couple in couples]
        restraints += [LimitedForce(Role.SUPPORT, name, (action,)) for action in actions]
        if previous is not None and not held:
            restraints.append(LimitedForce(Role.SUPPORT, name, (previous, Action(support, point, direction))))
        previous = Action(support, point, -direction)
    force = (push or 0.0) / len(supports) * direction
    return with_supports_freed(assembly, _pushed(assembly.scene, supports, force), force, restraints)


def _pushed(scene: Scene, supports: np.ndarray, force: np.ndarray) -> Scene:
    """Return the scene with movable supports that are pushed by live forces, without other live loads."""
    zero = (0.0,) * scene.dimension
    live_keys = [key for key in scene.blocks[0].LOADS if key.startswith("live")]
    of_blocks: dict[str, Any] = dict.fromkeys(live_keys, zero) | {"live_at": None}
    of_supports = of_blocks | {"fixed": False, "weight": 0.0, "unit_weight": None}
    of_supports["live"] = tuple(force.tolist())
    blocks = [
        block.replace(**(of_supports if index in supports else of_blocks))
        for index, block in enumerate(scene.blocks)
    ]
    loads = [
        load.replace(**{key: zero for key in live_keys if getattr(load, key, ())}) for load in scene.loads
    ]
    no_push = {"pressure": None, "force": (0.0, 0.0)}
    edge_loads = [load if load.kind == "dead" else load.replace(**no_push) for load in scene.edge_loads]
    fields: dict[str, Any] = {"blocks": blocks, "loads": loads, "edge_loads": edge_loads}
    fields |= {"tilt": None, "earthquake": None, "load_cases": [], "axles": []}
    # Reference values are removed, because they belong to the scene's own live loads.
    fields["reference"] = {}
    # The copy is not validated: a valid scene has a fixed block, and here all blocks may be free to move.
    return BaseModel.model_copy(scene.with_load_case(None), update=fields)

"""``settle``: the least and the greatest reaction of supports with which a scene stands."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from masonry_opt.analysis import prepare
from masonry_opt.answer.thresholds import ZERO
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
from masonry_opt.standing.diagnosis import carries
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
    """Find the reactions of a support, or of several, with which a scene stands under its dead load.

    The support gives way in one direction, or is pushed back, and neither moves otherwise nor turns. Its
    reaction is the force of the ground on it against that direction, > 0 where it presses on the scene. As it
    settles that falls, to the least at which the scene stands; pushed back, it grows, to the greatest. Either
    may be below zero (the ground must pull), or unlimited.

    Live loads of the scene are left out. Weights and loads of the supports themselves are left to the ground.

    Raises CaseError if the case file or scene is wrong; OptionError if there is no such support, it can move
    already, or touches nothing that can, if the direction is none of the scene's, or as
    :func:`~masonry_opt.solve`.

    Parameters
    ----------
    scene: a scene, or the path of a case file.
    support: name of a fixed block; of several, these move at a common rate, and the reaction is their sum.
    direction: in which it settles, ``(x, y)``, in space ``(x, y, z)``; only the direction counts.
    turns: whether each support may turn too, also at rest; its reaction passes its centroid.
    load_case: name of one of the scene's, whose dead loads act.
    method, phases, options: as of :func:`~masonry_opt.solve`, its model, solver, ... too.
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
    settling, pushed_back = (_freed(assembly, supports, along, push, turns) for push in (unit, -unit))
    _refuse_idle(assembly, settling, supports)
    told = partial(Settlement, case=scene.called, turns=turns, method=method, assembly=assembly)
    told = partial(told, supports=tuple(assembly.names(supports)), direction=tuple(along.tolist()))
    held = _freed(assembly, supports, along, None, turns) if turns else assembly
    if fallen := session.falls(held, effort):
        return told(fallen=fallen)
    effort.begins("reaction at rest")
    rest = _at_rest(held.problem, settling.problem, problem.B.shape[1])
    if rest is None:
        session = session.without_incremental()
        begins = _ends_by_statics(settling.problem, pushed_back.problem)[::-1]
    else:
        begins = [rest, rest]
    sessions = [session] if session.method.associative else [session, prepare("static")]

    def bound(moved: Assembly, sign: float, start: float, settled: np.ndarray | None) -> Bound:
        """The end that a push leads to, from a reaction and the forces there, if known."""
        dead = moved.problem.dead - sign * start * moved.problem.live
        begun = replace(moved, problem=replace(moved.problem, dead=dead, settled=settled))
        results = [each.push(begun, lambda _: None, Effort(phases)) for each in sessions]
        return Bound(results[0], results[-1], start=unit * start, per_load_factor=-sign * unit)

    at_rest = None if rest is None else unit * rest[0]
    least, greatest = bound(settling, 1.0, *begins[0]), bound(pushed_back, -1.0, *begins[1])
    return told(at_rest=at_rest, least=least, greatest=greatest)


def _at_rest(held: Problem, settling: Problem, own: int) -> tuple[float, np.ndarray] | None:
    """Reaction, over the live load, and forces of contacts that give, as those of supports that settle, shape
    (3c + t,); None if these do not come to carry the dead load. The first, so many, are the scene's own."""
    if held.joints > IncrementalSettings().most_joints or held.dilatancy_depends_on_stress:
        return None
    q = IncrementalAnalysis(held).preload_forces
    if q is None or not carries(held, q, ZERO):
        return None
    q = np.append(q[:own], np.zeros(settling.B.shape[1] - own))
    reaction = float(settling.B @ q @ settling.live / (settling.live @ settling.live))
    # What is rounding counts as zero: solvers would measure loads by it.
    return reaction if abs(reaction) > ZERO else 0.0, q


def _ends_by_statics(settling: Problem, pushed_back: Problem) -> list[tuple[float, np.ndarray | None]]:
    """Least and greatest associative reaction, over the live load, and the forces there; one without limit is
    put 1 beyond the other."""
    least, greatest = (associative(Task(problem)) for problem in (settling, pushed_back))
    low, high = least.load_factor, greatest.load_factor
    low = -low if low is not None else 0.0 if high is None else high - 1.0
    return [(low, least.q), (low + 1.0 if high is None else high, greatest.q)]


def _supports_of(scene: Scene, support: str | Sequence[str]) -> np.ndarray:
    """Indices of the supports. Raises OptionError if one is none, or is named twice."""
    names: list[Any] = list(support) if isinstance(support, list | tuple) else [support]
    known = {block.name: number for number, block in enumerate(scene.blocks)}
    fixed = [block.name for block in scene.blocks if block.fixed]
    if not names or not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
        raise OptionError(f"{scene.origin}: support: name each support once (found {support!r})")
    for name in names:
        if name not in known:
            instead = did_you_mean(name, fixed) or f"; supports: {', '.join(fixed)}"
            raise OptionError(f"{scene.origin}: support: no block '{name}'{instead}")
        if name not in fixed:
            known_as = f"a block with 'fixed = true': {', '.join(fixed)}"
            raise OptionError(f"{scene.origin}: support '{name}' can move already: name {known_as}")
    return np.array([known[name] for name in names])


def _unit_of(scene: Scene, direction: Sequence[float]) -> np.ndarray:
    """Unit vector of a direction. Raises OptionError if it is none of the scene's."""
    vector = coordinates(direction, scene.dimension)
    if vector is None or not vector.any():
        needed = f"{COORDINATES[scene.dimension]}, not all of them zero"
        raise OptionError(f"{scene.origin}: direction: needs {needed} (found {direction!r})")
    vector = vector / np.abs(vector).max()
    return vector / np.linalg.norm(vector)


def _refuse_idle(assembly: Assembly, freed_of: Assembly, supports: np.ndarray) -> None:
    """Raise OptionError if nothing that can move presses or pulls a support."""
    scene, forces = assembly.scene, assembly.problem.B.shape[1]
    touched = freed_of.problem.by_block(np.abs(freed_of.problem.B[:, :forces]).sum(axis=1)).any(axis=1)
    for support in np.setdiff1d(supports, freed_of.movable[touched], assume_unique=True):
        idle = f"support '{scene.blocks[support].name}' touches no block that can move"
        raise OptionError(f"{scene.origin}: {idle}: nothing changes where it settles")


def _freed(
    assembly: Assembly, supports: np.ndarray, direction: np.ndarray, push: float | None, turns: bool
) -> Assembly:
    """Assembly in which supports, by their indices (k,), move in one direction (a unit vector) at a common
    rate, or turn about their centroids at most: blocks without weight, held by forces without limits across
    the direction, against rotation, and, of several, on each other along it. The live load is the push along
    it, shared by them, in the case's unit of force; without a push they are held along it too."""
    held = push is None
    across = np.linalg.svd(direction[None])[2][0 if held else 1 :]
    # Moments at a usual lever, so that all are forces of one size whatever the units.
    couples = assembly.problem.length_unit * np.eye(moments_in(len(direction)))
    restraints: list[LimitedForce] = []
    before = None
    for support in supports.tolist():
        name, point = assembly.scene.blocks[support].name, assembly.geometry.centroid[support]
        fixed = [Action(support, point, unit) for unit in across]
        if not turns:
            fixed += [Action(support, point, np.zeros(len(direction)), couple) for couple in couples]
        restraints += [LimitedForce(Role.SUPPORT, name, (each,)) for each in fixed]
        if before is not None and not held:
            restraints.append(LimitedForce(Role.SUPPORT, name, (before, Action(support, point, direction))))
        before = Action(support, point, -direction)
    force = (push or 0.0) / len(supports) * direction
    return with_supports_freed(assembly, _pushed(assembly.scene, supports, force), force, restraints)


def _pushed(scene: Scene, supports: np.ndarray, force: np.ndarray) -> Scene:
    """The scene with supports that can move, and no live loads but those on them."""
    none = (0.0,) * scene.dimension
    acting = [key for key in scene.blocks[0].LOADS if key.startswith("live")]
    still: dict[str, Any] = dict.fromkeys(acting, none) | {"live_at": None}
    moves = still | {"fixed": False, "weight": 0.0, "unit_weight": None, "live": tuple(force.tolist())}
    numbered = enumerate(scene.blocks)
    blocks = [block.replace(**(moves if number in supports else still)) for number, block in numbered]
    loads = [load.replace(**{key: none for key in acting if getattr(load, key, ())}) for load in scene.loads]
    no_push = {"pressure": None, "force": (0.0, 0.0)}
    edge_loads = [load if load.kind == "dead" else load.replace(**no_push) for load in scene.edge_loads]
    changes = {"blocks": blocks, "loads": loads, "edge_loads": edge_loads}
    none_else: dict[str, Any] = {"tilt": None, "earthquake": None, "load_cases": [], "axles": []}
    # Reference values are load factors of the scene's own live loads.
    none_else |= {"reference": {}}
    # Unchecked: a scene that is checked needs a fixed block, and here all may be free to move.
    return BaseModel.model_copy(scene.with_load_case(None), update=changes | none_else)

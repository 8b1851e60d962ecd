"""Formulate problems of scenes whose supports can move in one direction."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import BaseModel

from masonry_opt.errors import OptionError
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.problem.assembly import Assembly, with_supports_freed
from masonry_opt.problem.limited_forces import Action, LimitedForce, Role
from masonry_opt.problem.loads import moments_in
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.mistakes import did_you_mean
from masonry_opt.scene.scene import Scene
from masonry_opt.stability.dead_load import carries

#: While no support moves, blocks on elastic contacts count as in equilibrium if the sum of their unbalanced
#: forces is at most this value. The value is relative to the median dead load of a block.
_LARGEST_UNBALANCED_FORCE = 1e-6


def supports_of(scene: Scene, support: str | Sequence[str], argument: str = "support") -> np.ndarray:
    """Return the indices of the supports with the given names.

    Raises OptionError, which names the ``argument``, if a name is unknown or occurs twice.
    """
    names: list[Any] = list(support) if isinstance(support, list | tuple) else [support]
    known = {block.name: number for number, block in enumerate(scene.blocks)}
    fixed = [block.name for block in scene.blocks if block.fixed]
    if not names or not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
        raise OptionError(f"{scene.origin}: '{argument}' must name each support once (found {support!r})")
    for name in names:
        if name not in known:
            instead = did_you_mean(name, fixed) or f"; supports: {', '.join(fixed) or 'none'}"
            raise OptionError(f"{scene.origin}: {argument}: no block '{name}'{instead}")
        if name not in fixed:
            choice = f"a block with 'fixed = true': {', '.join(fixed) or 'the scene has none'}"
            raise OptionError(f"{scene.origin}: block '{name}' is not a support: choose {choice}")
    return np.array([known[name] for name in names])


def refuse_idle(assembly: Assembly, freed_of: Assembly, supports: np.ndarray) -> None:
    """Raise OptionError if one of the given supports touches no block that can move.

    A support touches a block too if another support has the joint, see :attr:`~.joints.Joints.overlaps`.
    """
    scene, forces = assembly.scene, assembly.problem.B.shape[1]
    touched = freed_of.problem.by_block(np.abs(freed_of.problem.B[:, :forces]).sum(axis=1)).any(axis=1)
    touching = np.append(freed_of.movable[touched], assembly.joints.overlaps[:, 1:])
    for support in np.setdiff1d(supports, touching):
        idle = f"support '{scene.blocks[support].name}' touches no block that can move"
        raise OptionError(f"{scene.origin}: {idle}, so its settlement has no effect: choose another support")


def refuse_overlapping(
    assembly: Assembly, supports: np.ndarray, translations: np.ndarray, turns: np.ndarray | bool
) -> None:
    """Raise OptionError if two supports overlap below a block and do not move together.

    Two supports move together if they have the same translation and do not turn. If they turned, each would
    turn about its own centroid.

    Parameters
    ----------
    assembly : Assembly
        Assembly of the scene with fixed supports.
    supports : ndarray, shape (k,)
        Indices of the supports that move. All other supports are at rest.
    translations : ndarray, shape (k, 2) or (k, 3)
        Translations of these supports. A single vector is the direction in which all of them move.
    turns : ndarray, shape (k,), or bool
        True for each support that turns, or True if all of them turn.
    """
    overlaps, count = assembly.joints.overlaps, len(assembly.scene.blocks)
    translation, does_turn = np.zeros((count, translations.shape[-1])), np.zeros(count, dtype=bool)
    translation[supports], does_turn[supports] = translations, turns
    first, second = overlaps[:, 1:].T
    moves_apart = (translation[first] != translation[second]).any(axis=1)
    rows = overlaps[moves_apart | does_turn[first] | does_turn[second]]
    if len(rows):
        block, *pair = assembly.names(rows[0])
        raise OptionError(
            f"{assembly.scene.origin}: supports '{pair[0]}' and '{pair[1]}' overlap where block '{block}' "
            "rests on both, so they can settle only together and without rotation: give both the same "
            "translation, draw them as one block, or remove their overlap"
        )


def reaction_at_rest(at_rest: Problem, settling: Problem, own: int) -> tuple[float, np.ndarray] | None:
    """Compute the reaction of supports at rest, and the joint forces, both with elastic contacts.

    The reaction is relative to the live load.

    The forces belong to the problem with settling supports. The first ``own`` forces are those of the scene.
    The remaining forces restrain the supports in the directions in which they do not move. The result is None
    if no equilibrium of the elastic contacts under the dead load is found.
    """
    if at_rest.joints > IncrementalSettings().most_joints or at_rest.dilatancy_depends_on_stress:
        return None
    q = IncrementalAnalysis(at_rest).preload_forces
    if q is None or not carries(at_rest, q, _LARGEST_UNBALANCED_FORCE):
        return None
    on_blocks = settling.B[:, :own] @ q[:own]
    reaction = float(on_blocks @ settling.live / (settling.live @ settling.live))
    unbalanced = on_blocks + settling.dead - reaction * settling.live
    q = np.append(q[:own], np.linalg.lstsq(settling.B[:, own:].toarray(), -unbalanced, rcond=None)[0])
    # Return zero if the reaction consists of rounding errors only. Otherwise solvers would scale the loads by
    # these rounding errors.
    return reaction if abs(reaction) > settling.load_factor_scale.zero else 0.0, q


def freed(
    assembly: Assembly, supports: np.ndarray, direction: np.ndarray, push: float | None, turns: bool
) -> Assembly:
    """Return an assembly whose chosen supports can move in one direction, all at the same rate.

    The supports become blocks without weight. Forces without limits prevent their rotation and their motion
    across the direction, and couple several supports along the direction. The live load is a push along the
    direction, distributed equally to the supports.

    Parameters
    ----------
    assembly: Assembly of the scene with fixed supports.
    supports: Indices of the supports, shape (k,).
    direction: Unit vector.
    push: Live load in the case's unit of force. If it is None, the supports cannot move along the direction.
    turns: True if the supports can rotate about their centroids.
    """
    is_fixed = push is None
    across = np.linalg.svd(direction[None])[2][0 if is_fixed else 1 :]
    # A moment restraint is a couple of forces whose lever arm is the length unit. Its entries in the matrix
    # then have magnitudes similar to those of a force restraint.
    couples = assembly.problem.length_unit * np.eye(moments_in(len(direction)))
    restraints: list[LimitedForce] = []
    previous = None
    for support in supports.tolist():
        name, point = assembly.scene.blocks[support].name, assembly.geometry.centroid[support]
        actions = [Action(support, point, unit) for unit in across]
        if not turns:
            actions += [Action(support, point, np.zeros(len(direction)), couple) for couple in couples]
        restraints += [LimitedForce(Role.SUPPORT, name, (action,)) for action in actions]
        if previous is not None and not is_fixed:
            restraints.append(LimitedForce(Role.SUPPORT, name, (previous, Action(support, point, direction))))
        previous = Action(support, point, -direction)
    force = (push or 0.0) / len(supports) * direction
    return with_supports_freed(assembly, _pushed(assembly.scene, supports, force), force, restraints)


def freed_along(assembly: Assembly, supports: np.ndarray, motions: np.ndarray) -> Assembly:
    """Return a plane assembly whose chosen supports can move, with a fixed ratio of their velocities.

    The supports become blocks without weight. Forces without limits prevent all other motions of the
    supports. The live load is a push along the motions, as large as the dead load.

    Parameters
    ----------
    assembly: Assembly of the scene with fixed supports.
    supports: Indices of the supports, shape (k,), in ascending order.
    motions: Translations of the supports, and their rotations times the problem's unit of length, shape
        (k, 3). No motion is zero.
    """
    unit, scene = assembly.problem.length_unit, assembly.scene
    restraints: list[LimitedForce] = []
    previous = None
    for support, motion in zip(supports.tolist(), motions, strict=True):
        name, point = scene.blocks[support].name, assembly.geometry.centroid[support]

        def action(along: np.ndarray, support: int = support, point: np.ndarray = point) -> Action:
            return Action(support, point, along[:2], unit * along[2:])

        for across in np.linalg.svd(motion[None])[2][1:]:
            restraints.append(LimitedForce(Role.SUPPORT, name, (action(across),)))
        link = motion / (motion @ motion)
        if previous is not None:
            restraints.append(LimitedForce(Role.SUPPORT, name, (previous, action(link))))
        previous = action(-link)
    none = np.zeros(2)
    free = with_supports_freed(assembly, _pushed(scene, supports, none), none, restraints)
    live = free.problem.by_block(np.zeros_like(free.problem.live))
    size = float(free.problem.force_sizes(free.problem.dead).sum()) or 1.0
    live[np.searchsorted(free.movable, supports)] = size * motions / np.linalg.norm(motions)
    return replace(free, problem=replace(free.problem, live=live.ravel()))


def _pushed(scene: Scene, supports: np.ndarray, force: np.ndarray) -> Scene:
    """Make supports of a scene movable, and replace all live loads of the scene by pushes on the supports."""
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
    # Reference values of the original scene are removed, because they belong to its live loads.
    fields["reference"] = {}
    # The copy is not validated, because validation requires a fixed block, but all blocks of the copy may be
    # movable.
    return BaseModel.model_copy(scene.with_load_case(None), update=fields)

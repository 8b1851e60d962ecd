"""A scene whose supports can move in one direction, pushed there by a live load on them alone."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydantic import BaseModel

from masonry_opt.errors import OptionError
from masonry_opt.problem.assembly import Assembly, with_supports_freed
from masonry_opt.problem.limited_forces import Action, LimitedForce, Role
from masonry_opt.problem.loads import moments_in
from masonry_opt.scene.mistakes import did_you_mean
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import COORDINATES, coordinates


def supports_of(scene: Scene, support: str | Sequence[str]) -> np.ndarray:
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
            raise OptionError(
                f"{scene.origin}: support '{name}' can move already: name a block with 'fixed = true': "
                f"{', '.join(fixed)}"
            )
    return np.array([known[name] for name in names])


def unit_of(scene: Scene, direction: Sequence[float]) -> np.ndarray:
    """Unit vector of a direction. Raises OptionError if it is none of the scene's."""
    vector, needed = coordinates(direction, scene.dimension), COORDINATES[scene.dimension]
    if vector is None or not vector.any():
        raise OptionError(
            f"{scene.origin}: direction: needs {needed}, not all of them zero (found {direction!r})"
        )
    vector = vector / np.abs(vector).max()
    return vector / np.linalg.norm(vector)


def refuse_idle(assembly: Assembly, freed_of: Assembly, supports: np.ndarray) -> None:
    """Raise OptionError if nothing that can move presses or pulls a support."""
    forces = assembly.problem.B.shape[1]
    touched = np.abs(freed_of.problem.B[:, :forces]).sum(axis=1)
    rows = freed_of.problem.by_block(touched).sum(axis=1)
    for support in supports:
        if not rows[freed_of.movable == support].any():
            raise OptionError(
                f"{assembly.scene.origin}: support '{assembly.scene.blocks[support].name}' touches no block "
                "that can move: nothing changes where it settles"
            )


def freed(
    assembly: Assembly, supports: np.ndarray, direction: np.ndarray, push: float | None, turns: bool
) -> Assembly:
    """Assembly in which supports, by their indices (k,), move in one direction (a unit vector) at a common
    rate, or turn about their centroids at most. The supports are blocks without weight, held by forces
    without limits: across the direction, against rotation, and, of several, on each other along it. The live
    load is the push, along the direction, shared by them, in the case's unit of force: the scene's own live
    loads are left out. Without a push they are held along the direction too."""
    force = (push or 0.0) / len(supports) * direction
    restraints = _restraints(assembly, supports, direction, turns, held=push is None)
    return with_supports_freed(assembly, _pushed(assembly.scene, supports, force), force, restraints)


def _pushed(scene: Scene, supports: np.ndarray, force: np.ndarray) -> Scene:
    """The scene with supports that can move, and no live loads but those on them."""
    none = (0.0,) * scene.dimension
    still: dict[str, Any] = {"live": none, "live_per_weight": none, "live_at": None}
    if scene.dimension == 3:
        still["live_moment"] = none
    moves = still | {"fixed": False, "weight": 0.0, "unit_weight": None, "live": tuple(force.tolist())}
    numbered, acting = enumerate(scene.blocks), ("live", "live_moment")
    blocks = [block.replace(**(moves if number in supports else still)) for number, block in numbered]
    loads = [load.replace(**{key: none for key in acting if getattr(load, key)}) for load in scene.loads]
    edge_loads = [
        load if load.kind == "dead" else load.replace(pressure=None, force=(0.0, 0.0))
        for load in scene.edge_loads
    ]
    changes = {"blocks": blocks, "loads": loads, "edge_loads": edge_loads}
    none_else: dict[str, Any] = {"tilt": None, "earthquake": None, "load_cases": [], "axles": []}
    # Unchecked: a scene that is checked needs a fixed block, and here all may be free to move.
    return BaseModel.model_copy(scene.with_load_case(None), update=changes | none_else)


def _restraints(
    assembly: Assembly, supports: np.ndarray, direction: np.ndarray, turns: bool, held: bool
) -> list[LimitedForce]:
    across = np.linalg.svd(direction[None])[2][0 if held else 1 :]
    # Moments at a usual lever, so that all are forces of one size whatever the units.
    couples = assembly.problem.length_unit * np.eye(moments_in(len(direction)))
    found: list[LimitedForce] = []
    before = None
    for support in supports.tolist():
        name, point = assembly.scene.blocks[support].name, assembly.geometry.centroid[support]
        fixed = [Action(support, point, unit) for unit in across]
        if not turns:
            fixed += [Action(support, point, np.zeros(len(direction)), couple) for couple in couples]
        found += [LimitedForce(Role.SUPPORT, name, (each,)) for each in fixed]
        if before is not None and not held:
            together = before, Action(support, point, direction)
            found.append(LimitedForce(Role.SUPPORT, name, together))
        before = Action(support, point, -direction)
    return found

"""Whether the keys of a scene go together: what is wrong, in one sentence."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from masonry_opt.errors import CaseError
from masonry_opt.scene.blocks import Block
from masonry_opt.scene.joints import Joint, JointDefaults
from masonry_opt.scene.keys import SceneKeys
from masonry_opt.scene.load_cases import Earthquake
from masonry_opt.scene.loads import GROUPS
from masonry_opt.scene.mistakes import did_you_mean
from masonry_opt.scene.solids import Solid
from masonry_opt.scene.ties import GROUND

#: Keys of a block that are live loads.
_LIVE = ("live", "live_per_weight", "live_moment")


def inconsistency(scene: SceneKeys) -> str | None:
    """What is wrong with a scene of these keys; None if nothing is."""
    if not any(scene.gravity):
        return "'gravity' needs a direction, such as [0, -1], of solids [0, 0, -1]"
    if not scene.blocks:
        return "the scene has no block: add [[block]] tables or a generator such as [wall]"
    numbers: dict[str, int] = {}
    for number, block in enumerate(scene.blocks, start=1):
        if (first := numbers.setdefault(block.name, number)) != number:
            return (
                f"blocks no. {first} and no. {number} are both named '{block.name}': rename one "
                "(a generator names its blocks itself: '1-1', ..., 'base'; give it a 'name' of its own)"
            )
    fixed = [block.fixed for block in scene.blocks]
    if not any(fixed):
        return "no block is fixed: mark the support with 'fixed = true'"
    if all(fixed):
        return "every block is fixed: nothing can move"
    known = {block.name: block for block in scene.blocks}
    return (
        _wrong_dimension(scene)
        or _wrong_exception(scene, known)
        or _wrong_load(scene, known)
        or _wrong_axles(scene)
        or _wrong_fill(scene)
        or _wrong_strut(scene)
        or _wrong_tilt(scene)
        or _wrong_cases(scene)
    )


def _wrong_dimension(scene: SceneKeys) -> str | None:
    """What is of the plane in a scene in space, or the other way round."""
    first, space = scene.blocks[0], scene.dimension == 3
    for block in scene.blocks:
        if isinstance(block, Solid) != space:
            solid, flat = (first, block) if space else (block, first)
            return (
                f"block '{solid.name}' is a solid and block '{flat.name}' lies in the plane: give all of "
                "a scene the one or the other ('extrude' makes solids of a scene in the plane)"
            )
    needed = "needs three numbers, [x, y, z]" if space else "needs two numbers, [x, y]"
    if len(scene.gravity) != scene.dimension:
        return f"'gravity' {needed}, as block '{first.name}' does"
    for number, load in enumerate(scene.loads, start=1):
        where = f"load no. {number} on block '{load.block}'"
        for key in ("live", "dead", "at"):
            if (value := getattr(load, key)) and len(value) != scene.dimension:
                return f"{where}: '{key}' {needed}"
        for key in ("live_moment", "dead_moment"):
            if getattr(load, key) and not space:
                return f"{where}: '{key}' is for solids: take it away"
    if scene.tilt and isinstance(scene.tilt, str) == space:
        return "'tilt' needs a direction, [x, y, z]" if space else '\'tilt\' needs "left" or "right"'
    if space and "thickness" in scene.model_fields_set:
        return f"'thickness' is for scenes in the plane: block '{first.name}' is a solid"
    if not space and scene.contact_tolerance is not None:
        return "'contact_tolerance' is for scenes in space: give 'tolerance'"
    return of_plane_alone(scene) if space else None


def of_plane_alone(scene: SceneKeys) -> str | None:
    """What the scene has, beside its thickness, that none in space can have, in one sentence."""
    if scene.edge_loads:
        return "an 'edge_load' is for scenes in the plane: give the resultants as 'load'"
    if scene.axles:
        return "'axles' move over scenes in the plane: take them away"
    if scene.fills:
        return "a 'fill' is for scenes in the plane: give what it weighs and presses as 'load'"
    properties: list[tuple[str, JointDefaults | Joint]] = [("'joints'", scene.joints)]
    properties += [(f"joint between {list(one.between)}", one) for one in scene.exceptions]
    for where, joint in properties:
        for key in ("strength", "dilatancy_stress"):
            if getattr(joint, key) is not None:
                return f"{where}: '{key}' is for joints in the plane: take it away"
    return None


def _wrong_exception(scene: SceneKeys, known: Mapping[str, Block | Solid]) -> str | None:
    pairs: set[frozenset[str]] = set()
    for exception in scene.exceptions:
        where, pair = f"joint between {list(exception.between)}", frozenset(exception.between)
        if unknown := [name for name in exception.between if name not in known]:
            return f"{where}: no block '{unknown[0]}'{did_you_mean(unknown[0], known)}"
        if len(pair) == 1:
            return f"{where}: needs two different blocks"
        if pair in pairs:
            return f"{where} is given twice"
        pairs.add(pair)
        try:
            exception.over(scene.joints)
        except CaseError as error:
            return f"{where}: {str(error).removeprefix('JointDefaults: ')}"
    return None


def _wrong_load(scene: SceneKeys, known: Mapping[str, Block | Solid]) -> str | None:
    weighed: set[str] = set()
    for number, load in enumerate(scene.loads, start=1):
        if load.block not in known:
            return f"load no. {number}: no block '{load.block}'{did_you_mean(load.block, known)}"
        if known[load.block].fixed:
            return f"load no. {number}: block '{load.block}' is fixed: load one that can move"
        if load.weight is not None:
            if load.block in weighed:
                return f"load no. {number}: gives block '{load.block}' a second 'weight'"
            weighed.add(load.block)
    return None


def _wrong_axles(scene: SceneKeys) -> str | None:
    names = [group.name for group in scene.axles]
    twice = [name for name in names if names.count(name) > 1]
    return f"two groups of axles are named '{twice[0]}': rename one" if twice else None


def _wrong_fill(scene: SceneKeys) -> str | None:
    if scene.fills and (scene.gravity[0] != 0 or scene.gravity[1] > 0):
        return "a 'fill' needs gravity straight down, [0, -1]"
    ends = sorted(
        (fill.road[0][0], fill.road[-1][0], number) for number, fill in enumerate(scene.fills, start=1)
    )
    for (_, end, one), (start, _, other) in itertools.pairwise(ends):
        if start < end:
            return f"fill no. {one} and no. {other} lie above each other: end one where the other begins"
    return None


def _wrong_tilt(scene: SceneKeys) -> str | None:
    if not scene.tilt:
        return None
    # Tilted by θ, weights are cos θ (W + tan θ W'), W' the weights turned a quarter: λ = tan θ if all
    # else grows with cos θ too. Other forces do not, nor does what joints resist without being pressed.
    why = [
        f"block '{block.name}' has a force '{force}', which does not tilt"
        for block in scene.blocks
        for force in block.LOADS
        if any(getattr(block, force))
    ]
    why += [
        f"a 'load' on block '{load.block}' is a force, which does not tilt"
        for load in scene.loads
        if load.is_force
    ]
    why += ["an 'edge_load' does not tilt"] * len(scene.edge_loads)
    why += ["'axles' do not tilt"] * len(scene.axles)
    why += ["a 'fill' does not tilt"] * len(scene.fills)
    why += ["a tie or prop does not grow with the weights"] * len([*scene.ties, *scene.props])
    properties: list[JointDefaults | Joint] = [scene.joints, *scene.exceptions]
    for joint in properties:
        resisting = {
            "cohesion": joint.cohesion,
            "strength": joint.strength,
            "dilatancy_stress": joint.dilatancy_stress and joint.dilatancy,
        }
        why += [f"'{key}' does not grow with the weights" for key, value in resisting.items() if value]
    if scene.tilt_direction is None:
        return "'tilt' needs a direction that is not that of gravity"
    return f"'tilt' needs a scene of weights and friction alone: {why[0]}: take it away" if why else None


def _wrong_strut(scene: SceneKeys) -> str | None:
    """What is wrong with the ends of a tie or prop of a scene, in one sentence; None if nothing is."""
    fixed = {block.name: block.fixed for block in scene.blocks}
    for kind, struts in (("tie", scene.ties), ("prop", scene.props)):
        for number, strut in enumerate(struts, start=1):
            where = f"{kind} no. {number} between {list(strut.between)}"
            if unknown := [name for name in strut.between if name not in fixed and name != GROUND]:
                near = did_you_mean(unknown[0], fixed)
                return f"{where}: no block '{unknown[0]}'{near} (\"{GROUND}\" is what does not move)"
            if all(fixed.get(name, True) for name in strut.between):
                return f"{where}: neither of the two can move: it does nothing"
            if len(strut.at[0]) != scene.dimension:
                needed = "three numbers, [x, y, z]" if scene.dimension == 3 else "two numbers, [x, y]"
                return f"{where}: 'at' needs points of {needed}"
    return None


def _wrong_cases(scene: SceneKeys) -> str | None:
    """What is wrong with the load cases of a scene, or with its earthquake."""
    groups = [load.group for load in scene.loads] + [load.group for load in scene.edge_loads]
    named = {group for group in groups if group is not None}
    known, seen = [*GROUPS, *sorted(named)], set[str]()
    quakes = [("'earthquake'", scene.earthquake)]
    for number, case in enumerate(scene.load_cases, start=1):
        where = f"load_case no. {number} ('{case.name}')"
        if case.name in seen:
            return f"{where}: the name is given twice: rename one"
        seen.add(case.name)
        for key in ("dead", "live"):
            if unknown := [group for group in getattr(case, key) if group not in known]:
                there = ", ".join(known)
                return f"{where}: '{key}' names group '{unknown[0]}', which no load has; there are: {there}"
        if "axles" in case.live and scene.dimension == 3:
            return f"{where}: 'live' names 'axles', which move over scenes in the plane: take them away"
        quakes.append((f"{where}: 'earthquake'", case.earthquake))
    for where, quake in quakes:
        if quake is not None and (mistake := wrong_direction(scene, quake)):
            return f"{where}: {mistake}"
    if scene.tilt and (scene.load_cases or scene.earthquake):
        return "'tilt' is a live load of its own: take it, or the load cases and the earthquake, away"
    if scene.earthquake and scene.load_cases:
        return "'earthquake' is of a scene without load cases: give it within a [[load_case]]"
    if scene.earthquake and (live := _first_live_load(scene)):
        return (
            f"'earthquake' is the live load, and {live} is live too: take that away, or give the earthquake "
            "in a [[load_case]], where other loads are live only if it says so"
        )
    return None


def wrong_direction(scene: SceneKeys, quake: Earthquake) -> str | None:
    """What is wrong with the direction of an earthquake in a scene."""
    if isinstance(quake.direction, str) == (scene.dimension == 3):
        needed = "an angle in plan or [x, y, z]" if scene.dimension == 3 else '"left" or "right"'
        return f"'direction' needs {needed}"
    if scene.sideways(quake.direction, quake.vector) is None:
        return "'direction' needs one that is not that of gravity"
    return None


def _first_live_load(scene: SceneKeys) -> str | None:
    own = [f"block '{one.name}'" for one in scene.blocks if any(any(getattr(one, key, ())) for key in _LIVE)]
    own += [f"load no. {number}" for number, one in enumerate(scene.loads, start=1) if one.gives("live")]
    lines = enumerate(scene.edge_loads, start=1)
    return next(iter(own + [f"edge_load no. {number}" for number, one in lines if one.kind == "live"]), None)

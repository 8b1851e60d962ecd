"""Typical mistakes of users, such as one quantity in another unit, that can be put into a scene.

A mistake changes the keys of a case file, in kN and m, and returns False if it does not apply to the scene.
"""

import copy
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from realistic_scenes import (
    KILOGRAM,
    RELATIVE,
    TONNE,
    Rng,
    Tables,
    built,
    in_units,
    movable,
    multiply,
    struts,
    times,
)

from masonry_opt.problem.assembly import assemble

Make = Callable[[Tables, Rng], bool]


class Mistake(NamedTuple):
    """Name of a mistake, and the function that puts it into a scene."""

    name: str
    make: Make


def _of_blocks(factor: float, all_blocks: bool) -> Make:
    """Return a mistake in the weights of one block or of all blocks."""

    def make(tables: Tables, rng: Rng) -> bool:
        blocks = movable(tables)
        blocks = blocks if all_blocks else [blocks[rng.integers(len(blocks))]]
        if not all_blocks and len(movable(tables)) < 2:
            return False
        for block in blocks:
            for key in ("weight", "unit_weight"):
                if block.get(key) is not None:
                    block[key] *= factor
        return not all_blocks or _has_comparison(tables)

    return make


def _has_comparison(tables: Tables) -> bool:
    """Return True if the scene has other forces or stresses, beside which weights can have another unit."""
    joints = tables["joints"]
    return bool(
        joints.get("strength")
        or joints.get("cohesion")
        or tables.get("fill")
        or any(strut.get("strength") for strut in struts(tables))
    )


def _of_joints(key: str, factor: float) -> Make:
    """Return a mistake in the strength or cohesion of all joints."""

    def make(tables: Tables, rng: Rng) -> bool:
        if not tables["joints"].get(key):
            return False
        tables["joints"][key] *= factor
        return True

    return make


def _of_struts(key: str, factor: float) -> Make:
    """Return a mistake in the strength or prestress of all ties and props."""

    def make(tables: Tables, rng: Rng) -> bool:
        has = [strut for strut in struts(tables) if strut.get(key)]
        for strut in has:
            strut[key] *= factor
            if key == "prestress" and strut.get("strength"):
                strut["strength"] = max(strut["strength"], strut[key])
        return bool(has)

    return make


def _of_forces(key: str, factor: float) -> Make:
    """Return a mistake in the live or dead forces on blocks."""

    def make(tables: Tables, rng: Rng) -> bool:
        has = [each for each in (*movable(tables), *tables.get("load", [])) if np.any(each.get(key) or 0)]
        for each in has:
            each[key] = times(each[key], factor)
        return bool(has)

    return make


def _of_edge_loads(factor: float) -> Make:
    """Return a mistake in the pressure of all edge loads."""

    def make(tables: Tables, rng: Rng) -> bool:
        loads = tables.get("edge_load", [])
        for load in loads:
            load["pressure"] = times(load["pressure"], factor)
        return bool(loads)

    return make


def _of_fill(key: str, value: Callable[[float], float], backing: bool = False) -> Make:
    """Return a mistake in a value of all fills or backings."""

    def make(tables: Tables, rng: Rng) -> bool:
        fills = [fill.get("backing") if backing else fill for fill in tables.get("fill", [])]
        fills = [fill for fill in fills if fill]
        for fill in fills:
            fill[key] = value(fill[key])
        return bool(fills)

    return make


def _of_axles(factor: float) -> Make:
    """Return a mistake in the loads of axles. Relative loads have no unit."""

    def make(tables: Tables, rng: Rng) -> bool:
        groups = [group for group in tables.get("axles", []) if max(group.get("loads", [0.0])) >= RELATIVE]
        for group in groups:
            group["loads"] = times(group["loads"], factor)
        return bool(groups)

    return make


def _set_beside(force: float, length: float = 1.0) -> Make:
    """Return the mistake of a common set of axles, in kN and m, in a scene of other units."""

    def make(tables: Tables, rng: Rng) -> bool:
        if "set" not in (tables.get("axles") or [{}])[0]:
            return False
        tables.update(in_units(tables, force, length))
        return True

    return make


def _beside_axles(force: float) -> Make:
    """Return the mistake of axles in kN in a scene with another unit of force."""

    def make(tables: Tables, rng: Rng) -> bool:
        loads = (tables.get("axles") or [{}])[0].get("loads", [0.0])
        tables.update(in_units(tables, force, 1.0))
        if max(loads) >= RELATIVE:
            tables["axles"][0]["loads"] = loads
        return max(loads) >= RELATIVE

    return make


def _lengths(factor: float) -> Make:
    """Return the mistake of all lengths in another unit than the weights, stresses and forces."""

    def make(tables: Tables, rng: Rng) -> bool:
        if not _has_comparison(tables) and not np.any([block.get("live", 0.0) for block in movable(tables)]):
            return False
        if all(block.get("unit_weight") is None for block in movable(tables)):
            return False
        multiply(tables, lambda powers: factor if powers == (0, 1) else 1.0)
        return True

    return make


def _thickness(factor: float) -> Make:
    """Return a mistake in the thickness of a plane scene, beside unit weights."""

    def make(tables: Tables, rng: Rng) -> bool:
        if "thickness" not in tables:
            return False
        tables["thickness"] *= factor
        return any(block.get("unit_weight") is not None for block in movable(tables))

    return make


def _joint_value(key: str, least: float, greatest: float) -> Make:
    """Return the mistake of a friction or dilatancy of all joints with a wrong value."""

    def make(tables: Tables, rng: Rng) -> bool:
        if "angle" in key:
            tables["joints"].pop("friction")
        tables["joints"][key] = round(float(rng.uniform(least, greatest)), 2)
        return True

    return make


def _joint_exception(tables: Tables, rng: Rng) -> bool:
    """Give one joint a friction in degrees."""
    pairs = assemble(built(tables)).joints
    number = rng.integers(len(pairs.first))
    names = [tables["block"][index]["name"] for index in (pairs.first[number], pairs.second[number])]
    tables["joint"] = [{"between": names, "friction": 30.0}]
    return not tables.get("tilt")


def _computed_angle(tables: Tables, rng: Rng) -> bool:
    """Compute the friction angle of all joints in radians from the friction coefficient."""
    tables["joints"]["friction_angle"] = math.atan(tables["joints"].pop("friction"))
    return True


def _negative_dilatancy(tables: Tables, rng: Rng) -> bool:
    """Give all joints a dilatancy of the wrong sign."""
    tables["joints"]["dilatancy"] = -float(rng.choice([0.3, 0.7, 1.0])) * tables["joints"]["friction"]
    return True


def _support_in_millimetres(tables: Tables, rng: Rng) -> bool:
    """Draw one of several supports in mm."""
    fixed = [block for block in tables["block"] if block.get("fixed")]
    support = fixed[rng.integers(len(fixed))]
    support["vertices"] = times(support["vertices"], 1000.0)
    return len(fixed) > 1


def _second_structure(factor: float, offset: float) -> Make:
    """Return the mistake of a copy of the whole scene in another unit of length, or at a wrong place.

    The offset is relative to the length of the scene.
    """

    def make(tables: Tables, rng: Rng) -> bool:
        if any(tables.get(key) for key in ("fill", "axles", "edge_load", "tie", "prop", "load", "joint")):
            return False
        corners = np.concatenate([block["vertices"] for block in tables["block"]])
        right = corners[:, 0].max()
        shift = np.eye(corners.shape[1])[0] * (1.2 + offset) * np.ptp(corners[:, 0])
        made = []
        for block in copy.deepcopy(tables["block"]):
            # The structure is drawn to the right of the origin, as the first structure.
            at = (np.array(block["vertices"]) - [right, *[0] * (len(shift) - 1)]) + shift
            block |= {"name": f"second {block['name']}", "vertices": (factor * at).tolist()}
            for key in ("live_at", "dead_at", "weight_at"):
                block.pop(key, None)
            made.append(block)
        tables["block"] += made
        return True

    return make


def _one_block_in_millimetres(tables: Tables, rng: Rng) -> bool:
    """Draw one movable block in mm."""
    block = movable(tables)[rng.integers(len(movable(tables)))]
    block["vertices"] = times(block["vertices"], 1000.0)
    return True


def _point(change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Make:
    """Return the mistake of points of application that are given wrongly."""

    def make(tables: Tables, rng: Rng) -> bool:
        middle = {block["name"]: np.mean(block["vertices"], axis=0) for block in tables["block"]}
        has = [(block, "live_at", block["name"]) for block in movable(tables) if block.get("live_at")]
        has += [(load, "at", load["block"]) for load in tables.get("load", []) if load.get("at")]
        for each, key, name in has:
            each[key] = tuple(change(np.array(each[key]), middle[name]).tolist())
        return bool(has)

    return make


def _constant(value: float) -> Callable[[float], float]:
    """Return a function that returns a constant."""
    return lambda _: value


def _by(factor: float) -> Callable[[float], float]:
    """Return a function that multiplies a number."""
    return lambda value: factor * value


MISTAKES: tuple[Mistake, ...] = (
    Mistake("one block's weight in N", _of_blocks(1000.0, all_blocks=False)),
    Mistake("one block's weight in kg", _of_blocks(1 / KILOGRAM, all_blocks=False)),
    Mistake("one block's weight in t", _of_blocks(1 / TONNE, all_blocks=False)),
    Mistake("all weights in N", _of_blocks(1000.0, all_blocks=True)),
    Mistake("all weights in kg", _of_blocks(1 / KILOGRAM, all_blocks=True)),
    Mistake("all weights in MN", _of_blocks(1e-3, all_blocks=True)),
    Mistake("fill's weight in N", _of_fill("unit_weight", _by(1000.0))),
    Mistake("fill's weight in kg", _of_fill("unit_weight", _by(1 / KILOGRAM))),
    Mistake("fill's weight in t", _of_fill("unit_weight", _by(1 / TONNE))),
    Mistake("backing's weight in kg", _of_fill("unit_weight", _by(1 / KILOGRAM), backing=True)),
    Mistake("fill's angle as a tangent", _of_fill("friction_angle", _constant(0.6))),
    Mistake("fill's angle in radians", _of_fill("friction_angle", _constant(0.54))),
    Mistake("backing's angle as a tangent", _of_fill("friction_angle", _constant(0.8), backing=True)),
    Mistake("strength in Pa", _of_joints("strength", 1000.0)),
    Mistake("strength in MPa", _of_joints("strength", 1e-3)),
    Mistake("cohesion in Pa", _of_joints("cohesion", 1000.0)),
    Mistake("cohesion in MPa", _of_joints("cohesion", 1e-3)),
    Mistake("strength of ties in N", _of_struts("strength", 1000.0)),
    Mistake("strength of ties in MN", _of_struts("strength", 1e-3)),
    Mistake("prestress in N", _of_struts("prestress", 1000.0)),
    Mistake("prestress in MN", _of_struts("prestress", 1e-3)),
    Mistake("live forces in N", _of_forces("live", 1000.0)),
    Mistake("dead forces in N", _of_forces("dead", 1000.0)),
    Mistake("dead forces in MN", _of_forces("dead", 1e-3)),
    Mistake("edge loads in Pa", _of_edge_loads(1000.0)),
    Mistake("edge loads in MPa", _of_edge_loads(1e-3)),
    Mistake("lengths in mm", _lengths(1000.0)),
    Mistake("lengths in cm", _lengths(100.0)),
    Mistake("thickness in mm", _thickness(1000.0)),
    Mistake("thickness in cm", _thickness(100.0)),
    Mistake("one block in mm", _one_block_in_millimetres),
    Mistake("one support in mm", _support_in_millimetres),
    Mistake("second structure in mm", _second_structure(1000.0, 0.0)),
    Mistake("second structure in m beside mm", _second_structure(1e-3, 0.0)),
    Mistake("second structure 100 lengths away", _second_structure(1.0, 100.0)),
    Mistake("friction in degrees", _joint_value("friction", 15, 45)),
    Mistake("friction of one joint in degrees", _joint_exception),
    Mistake("friction angle as a tangent", _joint_value("friction_angle", 0.3, 1.0)),
    Mistake("friction angle in radians", _joint_value("friction_angle", 0.26, 0.79)),
    Mistake("friction angle in radians, computed", _computed_angle),
    Mistake("dilatancy of the wrong sign", _negative_dilatancy),
    Mistake("dilatancy of the wrong sign, in degrees", _joint_value("dilatancy", -45, -3)),
    Mistake("point of a load in mm", _point(lambda at, middle: 1000 * at)),
    Mistake("point of a load from the centroid", _point(lambda at, middle: at - middle)),
    Mistake("axles in N", _of_axles(1000.0)),
    Mistake("axles in kg", _of_axles(1 / KILOGRAM)),
    Mistake("axles in t", _of_axles(1 / TONNE)),
    Mistake("axles in kN beside N", _beside_axles(1e-3)),
    Mistake("axles in kN beside kg", _beside_axles(KILOGRAM)),
    Mistake("common axles beside N", _set_beside(1e-3)),
    Mistake("common axles beside kg", _set_beside(KILOGRAM)),
    Mistake("common axles beside N and mm", _set_beside(1e-3, 1e-3)),
)

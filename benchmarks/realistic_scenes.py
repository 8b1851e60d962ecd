"""Random scenes of every kind with plausible materials, in any system of units.

A scene is a dict of the keys of a case file, so that a script can change any key. Forces are in kN and
lengths in m, until :func:`in_units` converts them.
"""

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from atlas.held_scenes import held
from atlas.loaded_scenes import loaded
from atlas.odd_stones import odd_scene
from second_program import random_of_any_kind

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

Rng = np.random.Generator
Tables = dict[str, Any]

#: Two scenes of this number have odd stones or fill; the others are of the kinds of ``random_of_any_kind``.
_EVERY = 6
#: Axles with smaller loads are relative loads, which have no unit.
RELATIVE = 10.0
#: Weight of a tonne, in kN.
TONNE = 9.81
#: Weight of a kilogram, in kN.
KILOGRAM = 9.81e-3
#: Consistent systems of units: the unit of force in kN and the unit of length in m.
SYSTEMS = {
    "kN, m": (1.0, 1.0),
    "N, m": (1e-3, 1.0),
    "N, mm": (1e-3, 1e-3),
    "kN, mm": (1.0, 1e-3),
    "kN, cm": (1.0, 1e-2),
    "MN, m": (1e3, 1.0),
    "t, m": (TONNE, 1.0),
    "kg, m": (KILOGRAM, 1.0),
    "kg, cm": (KILOGRAM, 1e-2),
    "lb, ft": (4.448e-3, 0.3048),
    "lb, in": (4.448e-3, 0.0254),
}
#: Powers of force and of length in the unit of each key. The unit weights and stresses of plane scenes
#: without a thickness refer to a strip of unit thickness.
_POWERS = dict.fromkeys(("weight", "live", "dead", "mass", "prestress", "loads"), (1, 0))
_POWERS |= dict.fromkeys(("live_moment", "dead_moment"), (1, 1))
_POWERS |= dict.fromkeys(("cohesion", "pressure", "force", "dilatancy_stress"), (1, -2))
_POWERS |= {"unit_weight": (1, -3)}
_LENGTHS = (
    "vertices",
    "parts",
    "holes",
    "weight_at",
    "live_at",
    "dead_at",
    "at",
    "from",
    "to",
    "road",
    "line",
)
_LENGTHS += ("tolerance", "contact_tolerance", "thickness", "distances", "width")
_POWERS |= dict.fromkeys(_LENGTHS, (0, 1))
#: Keys without a unit, although their records contain keys of the same names as quantities.
_WITHOUT_UNIT = ("load_case", "earthquake", "case", "gravity", "title", "reference")


def correct_scene(seed: int) -> Tables:
    """Return the tables of a random scene of any kind with plausible materials, in kN and m."""
    scene = _drawn(seed)
    tables = scene.model_dump(exclude_unset=True, by_alias=True)
    tables["case"] = scene.load_case and scene.load_case.name
    rng = np.random.default_rng([29, seed])
    size, density = log_uniform(rng, 0.4, 3), float(rng.uniform(16, 27))
    if tables.get("fill"):
        density /= 20.0  # stones under fill already have 20 kN/m³
    _scale(tables, density, size)
    plane = is_plane(tables)
    if plane and rng.random() < 0.5:
        _thicken(tables, float(rng.uniform(0.3, 5.0)))
    if plane and rng.random() < 0.5:
        _by_unit_weight(tables, size**2 * assemble(scene).geometry.size)
    _vary_materials(tables, rng)
    tables["joints"]["friction"] = round(tables["joints"]["friction"], 2)
    if not tables.get("tilt"):
        _add_stresses(tables, rng)
    for strut in struts(tables):
        if strut.get("strength") and rng.random() < 0.7:
            strut["strength"] = log_uniform(rng, 10, 300)
            strut |= {"prestress": 0.1 * strut["strength"]} if strut.get("prestress") else {}
    for fill in tables.get("fill", []):
        _add_to_fill(tables, fill, rng)
    return tables


def _drawn(seed: int) -> mo.Scene:
    """Return the random scene of a seed, before materials are chosen: in turn one with odd stones or fill."""
    if seed % _EVERY == 0:
        return odd_scene(seed)
    if seed % _EVERY == 1:
        return loaded(held("filled", seed), seed)
    return random_of_any_kind(seed)


def built(tables: Tables) -> mo.Scene:
    """Return the scene of tables, in its load case."""
    scene = mo.Scene(**{key: value for key, value in tables.items() if key != "case"})
    return scene.in_case(tables["case"]) if tables["case"] else scene


def in_units(tables: Tables, force: float, length: float) -> Tables:
    """Return the tables in other units of force and length, which are given in kN and m.

    A plane scene without a thickness receives the thickness of 1 m.
    """
    made = copy.deepcopy(tables)
    if is_plane(made) and length != 1:
        made.setdefault("thickness", 1.0)
    multiply(made, lambda powers: force ** -powers[0] * length ** -powers[1])
    return made


def is_plane(tables: Tables) -> bool:
    """Return True if the blocks have coordinates in the plane."""
    return len(np.ravel(tables["gravity"])) == 2 if "gravity" in tables else "faces" not in tables["block"][0]


def times(value: Any, factor: float) -> Any:
    """Return a number, or nested lists of numbers, multiplied by a factor."""
    if isinstance(value, list | tuple):
        return type(value)(times(each, factor) for each in value)
    return value * factor


def movable(tables: Tables) -> list[Tables]:
    """Return the movable blocks."""
    return [block for block in tables["block"] if not block.get("fixed")]


def struts(tables: Tables) -> list[Tables]:
    """Return the ties and props."""
    return [*tables.get("tie", []), *tables.get("prop", [])]


def multiply(record: Any, factor: Callable[[tuple[int, int]], float], of_strut: bool = False) -> None:
    """Multiply all quantities of a record, and of the records in it, by the factor of their units."""
    for key, value in record.items():
        powers = _POWERS.get(key)
        if key == "strength":
            powers = (1, 0) if of_strut else (1, -2)
        if key in _WITHOUT_UNIT or value is None or isinstance(value, bool | str):
            continue
        if isinstance(value, dict):
            multiply(value, factor)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for each in value:
                multiply(each, factor, key in ("tie", "prop"))
        elif powers and not (key == "loads" and max(value, default=0) < RELATIVE):
            record[key] = times(value, factor(powers))


def _scale(tables: Tables, density: float, size: float) -> None:
    """Multiply the unit weights and stresses by ``density`` and the lengths by ``size``.

    In the plane, forces refer to a strip of unit thickness.
    """
    strip = int(is_plane(tables))

    def factor(powers: tuple[int, int]) -> float:
        force, length = powers
        of_density = length + strip if force and length < 0 else length
        return (density * size ** (3 - strip)) ** force * size**of_density

    multiply(tables, factor)


def _thicken(tables: Tables, thickness: float) -> None:
    """Give a plane scene a thickness, and multiply its forces by the thickness."""
    multiply(tables, lambda powers: thickness if powers == (1, 0) else 1.0)
    tables["thickness"] = thickness


def _by_unit_weight(tables: Tables, sizes: np.ndarray) -> None:
    """Replace the weights of plane blocks by unit weights."""
    thickness = tables.get("thickness", 1.0)
    for block, size in zip(tables["block"], sizes, strict=True):
        if block.get("weight") is not None:
            block["unit_weight"] = block.pop("weight") / (size * thickness)


def _vary_materials(tables: Tables, rng: Rng) -> None:
    """Change the unit weight of each block by some per cent; rarely, make one block of timber or steel."""
    blocks = movable(tables)
    other = rng.integers(len(blocks)) if rng.random() < 0.1 else -1
    material = rng.choice([0.25, 3.5])
    for number, block in enumerate(blocks):
        factor = material if number == other else rng.uniform(0.85, 1.1)
        for key in ("weight", "unit_weight"):
            if block.get(key) is not None:
                block[key] *= factor


def _add_stresses(tables: Tables, rng: Rng) -> None:
    """Add a strength of 0.5 to 40 MPa, a cohesion of 20 to 500 kPa, or none of them."""
    plane = is_plane(tables)
    joints = tables["joints"]
    if plane and (joints.get("strength") or rng.random() < 0.4):
        joints["strength"] = log_uniform(rng, 0.5e3, 40e3)
    if joints.get("cohesion") or rng.random() < 0.25:
        joints["cohesion"] = log_uniform(rng, 20, 500)


def _add_to_fill(tables: Tables, fill: Tables, rng: Rng) -> None:
    """Add a backing and axles to a fill: a common set, real loads, or relative loads."""
    if rng.random() < 0.5:
        line = [(x, y - 2.0) for x, y in fill["road"]]
        fill["backing"] = {
            "line": line,
            "unit_weight": rng.uniform(18, 24),
            "friction_angle": rng.uniform(30, 45),
        }
    if rng.random() < 0.3:
        fill["mobilised"] = 1.0
    count = int(rng.integers(1, 4))
    group: Tables = {"name": "lorry", "distances": [1.5] * (count - 1)}
    kind = rng.integers(3)
    if kind == 0:
        group = {"name": "lorry", "set": "CS 454 double 1.3 m"}
    elif kind == 1:
        group["loads"] = [log_uniform(rng, 20, 300) for _ in range(count)]
    else:
        group["loads"] = [float(rng.choice([0.5, 1.0, 2.0])) for _ in range(count)]
    if rng.random() < 0.5:
        group["width"] = max(3.0, tables.get("thickness", 1.0))
    tables["axles"] = [group]


def log_uniform(rng: Rng, low: float, high: float) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))

"""Guess the unit of a unit weight from its value, to warn about input in different units.

The package accepts any consistent units, so it cannot know the unit of a single number. Two numbers are
probably in different units if each is typical of masonry, earth or concrete in another unit.
"""

import numpy as np

#: Range of the unit weights of stone, brick, concrete, mortar and earth, in each unit. A fill of foam glass
#: (2 kN/m³) is mistaken for a fill in t/m³.
_TYPICAL: dict[str, tuple[float, float]] = {
    "kN/m³": (10.0, 32.0),
    "N/m³": (10e3, 32e3),
    "kg/m³": (1200.0, 3300.0),
    "t/m³": (1.2, 3.3),
}

#: Value of 1 kN/m³ in each unit of unit weight. Each number is also the value of 1 kN in the corresponding
#: unit of force: N, kg or t.
PER_KILONEWTON: dict[str, float] = {"kN/m³": 1.0, "N/m³": 1000.0, "kg/m³": 102.0, "t/m³": 0.102}


def typical_unit(unit_weight: float) -> str:
    """Return the unit for which the value of a unit weight is plausible for masonry or earth.

    The result is an empty string if no unit makes the value plausible.
    """
    for unit, (light, heavy) in _TYPICAL.items():
        if light <= unit_weight <= heavy:
            return unit
    return ""


def in_other_unit(unit_weights: np.ndarray, other: float) -> np.ndarray:
    """Return a mask of the unit weights that seem to be in another unit than the unit weight ``other``.

    All entries are False if ``other`` is not a typical value in any unit.
    """
    own_unit = typical_unit(other)
    mixed = np.zeros(np.shape(unit_weights), dtype=bool)
    for unit, (light, heavy) in _TYPICAL.items():
        if own_unit and unit != own_unit:
            mixed |= (unit_weights >= light) & (unit_weights <= heavy)
    return mixed


def units_in_words(first: float, second: float) -> str:
    """Return a clause that names the units of two unit weights, or "" if the units do not seem to differ.

    The clause is also empty if one of the units cannot be guessed.
    """
    units = typical_unit(first), typical_unit(second)
    if "" in units or units[0] == units[1]:
        return ""
    kilonewtons = [f"{PER_KILONEWTON[unit]:g} {unit}" for unit in units if unit != "kN/m³"]
    return f"the values seem to be in {units[0]} and {units[1]} (1 kN/m³ is {' or '.join(kilonewtons)}); "

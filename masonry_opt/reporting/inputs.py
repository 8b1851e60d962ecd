"""Write sentences on inputs that look unintended, such as weights and forces in different units.

The functions take the values of a reason, as :mod:`~.words.sentences` does.
"""

from math import radians, tan
from typing import Any

from masonry_opt.errors import rounded_up
from masonry_opt.reporting.names import blocks, pairs
from masonry_opt.scene.geometry import set_contact_tolerance, set_tolerance
from masonry_opt.solution.typical_units import units_in_words


def _rounded(value: float) -> str:
    """Return a number rounded to three significant digits, such as 18000."""
    return f"{float(f'{value:.3g}'):g}"


def _place_of_property(v: dict[str, Any]) -> str:
    """Return the place of a joint property in a case file: one joint, or the table [joints]."""
    return f"joint {pairs(v)}" if v["pairs"] else "[joints]"


def weights_differ(v: dict[str, Any]) -> str:
    """State that the unit weight of blocks differs much from the median, with both values."""
    own, median = _rounded(v["ratio"] * v["median"]), _rounded(v["median"])
    quantity = "weight per area" if v["per_area"] else "unit weight"
    own_weight = f"the {quantity} of {blocks(v['blocks'])} is {own}"
    units = units_in_words(v["ratio"] * v["median"], v["median"])
    return f"{own_weight}, but the median of all blocks is {median}: {units}use the same units for all blocks"


def fill_weight_differs(v: dict[str, Any]) -> str:
    """State that the unit weight of a fill or backing differs much from another unit weight."""
    own, other = _rounded(v["unit_weight"]), _rounded(v["other"])
    fill = f"{'the backing of ' if v['backing'] else ''}fill no. {v['fill']}"
    compared = f"but that of the {v['beside']} is {other}"
    units = units_in_words(v["unit_weight"], v["other"])
    return f"the unit weight of {fill} is {own}, {compared}: {units}use the same units for both weights"


def strength_differs(v: dict[str, Any]) -> str:
    """State that a strength is very large or small compared with the weights, with both values."""
    own, weight = _rounded(v["value"]), _rounded(v["weight"])
    compared = "the sum of all dead loads" if v["value"] > v["weight"] else "the median weight of a block"
    strength = f"the {v['key']} of {v['kind']} '{v['name']}' is {own}, but {compared} is {weight}"
    return f"{strength}: use the same unit for forces and weights"


def friction_high(v: dict[str, Any]) -> str:
    """State that a friction coefficient is high, and convert it if an angle in degrees was meant."""
    friction = v["friction"]
    meant = f": is it in degrees? tan {friction:g}° = {tan(radians(friction)):.3f}" if friction < 90 else ""
    return f"friction {friction:g} of {_place_of_property(v)} is higher than in dry joints{meant}"


def dilatancy_low(v: dict[str, Any]) -> str:
    """State that the dilatancy of a joint is less than minus its friction, and advise to check the sign."""
    return (
        f"'dilatancy' {v['dilatancy']:g} of {_place_of_property(v)} is less than −{v['friction']:g}, "
        "minus its friction: sliding would release work instead of dissipating it; check the sign"
    )


def small_gaps(v: dict[str, Any]) -> str:
    """State that small gaps separate blocks, with the tolerance that closes the gaps."""
    wide = [f"up to {rounded_up(width, 2)} wide" for width in v["widths"]]
    if v["option"] == "tolerance":
        remedy = f"{set_tolerance(v['tolerance'])}, which closes the gaps and makes nearly parallel joints"
        remedy += " parallel"
    else:
        remedy = f"{set_contact_tolerance(v['tolerance'])}, which closes the gaps"
    return (
        "blocks face each other across a small gap, which carries no force and may change λ a lot: "
        f"{pairs(v, wide)}; if they should touch, {remedy}"
    )


def lost_joints(v: dict[str, Any]) -> str:
    """State that a large tolerance loses joints, with the contact tolerance that keeps them."""
    wide = [f"{rounded_up(width, 2)} apart" if width > 0 else "touching" for width in v["widths"]]
    remedy = "lower 'tolerance'"
    if max(v["widths"]) > 0:
        remedy = f"{set_contact_tolerance(max(v['widths']))} and remove 'tolerance'"
    return (
        "blocks face each other but have no joint, because their sides are too short for so large a "
        f"'tolerance': {pairs(v, wide)}; {remedy}"
    )

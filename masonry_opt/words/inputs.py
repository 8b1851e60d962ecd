"""Write sentences on inputs that look unintended, such as weights and forces in different units.

The functions take the values of a reason, as :mod:`~.words.sentences` does.
"""

from math import radians, tan
from typing import Any

from masonry_opt.errors import rounded_up
from masonry_opt.scene.geometry import set_tolerance
from masonry_opt.words.names import blocks, pairs


def _rounded(value: float) -> str:
    """Return a number rounded to three significant digits, such as 18000."""
    return f"{float(f'{value:.3g}'):g}"


def _place_of_property(v: dict[str, Any]) -> str:
    """Return the place of a joint property in a case file: a pair of blocks, or the table of all joints."""
    return f"joint {pairs(v)}" if v["pairs"] else "[joints]"


def weights_differ(v: dict[str, Any]) -> str:
    """State that the unit weight of some blocks is far from the median, with both numbers."""
    own, median = _rounded(v["ratio"] * v["median"]), _rounded(v["median"])
    quantity = "weight per area" if v["per_area"] else "unit weight"
    own_weight = f"the {quantity} of {blocks(v['blocks'])} is {own}"
    return f"{own_weight}, the median of all blocks is {median}: give weights and lengths in one unit each"


def fill_weight_differs(v: dict[str, Any]) -> str:
    """State that the unit weight of a fill or its backing is far from another one, with both numbers."""
    own, other = _rounded(v["unit_weight"]), _rounded(v["other"])
    fill = f"{'the backing of ' if v['backing'] else ''}fill no. {v['fill']}"
    return f"the unit weight of {fill} is {own}, that of the {v['beside']} {other}: give both in one unit"


def strength_differs(v: dict[str, Any]) -> str:
    """State that a strength is far from the weights of the scene, with both numbers."""
    own, weight = _rounded(v["value"]), _rounded(v["weight"])
    compared = "all dead loads together" if v["value"] > v["weight"] else "the median weight of a block"
    strength = f"the {v['key']} of {v['kind']} '{v['name']}' is {own}, {compared} {weight}"
    return f"{strength}: give forces and weights in one unit"


def friction_high(v: dict[str, Any]) -> str:
    """State that a friction coefficient is high, and its value if it was meant as an angle in degrees."""
    friction = v["friction"]
    meant = f": in degrees? tan {friction:g}° = {tan(radians(friction)):.3f}" if friction < 90 else ""
    return f"friction {friction:g} of {_place_of_property(v)} is more than dry joints have{meant}"


def dilatancy_low(v: dict[str, Any]) -> str:
    """State that the dilatancy of a joint is below minus its friction, and ask whether its sign is meant."""
    return (
        f"'dilatancy' {v['dilatancy']:g} of {_place_of_property(v)} is below minus its friction, "
        f"{v['friction']:g}: sliding would close the joint by more than friction resists; is its sign meant?"
    )


def small_gaps(v: dict[str, Any]) -> str:
    """State that blocks face each other across small gaps, with the tolerance that closes the gaps."""
    wide = [f"up to {rounded_up(width, 2)} wide" for width in v["widths"]]
    return (
        "blocks face each other across a small gap, which carries no force and may change λ a lot: "
        f"{pairs(v, wide)}; if they should touch, {set_tolerance(v['tolerance'])}, which closes the gaps and "
        "makes nearly parallel joints parallel"
    )

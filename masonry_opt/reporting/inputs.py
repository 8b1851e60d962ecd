"""Write sentences on inputs that look unintended, such as weights and forces in different units.

The functions take the values of a reason, as those of :mod:`~.reporting.sentences` do.
"""

from collections.abc import Callable
from math import atan, degrees, radians, tan
from typing import Any

from masonry_opt.errors import rounded, rounded_down, rounded_up
from masonry_opt.reporting.names import blocks, do, pairs, verb
from masonry_opt.scene.tolerance_advice import set_both, set_contact_tolerance, set_tolerance
from masonry_opt.scene.typical_sizes import GRAVITY_BY_UNIT
from masonry_opt.solution.reasons import Code
from masonry_opt.solution.typical_units import typical_unit, units_in_words

#: Smallest number of nearly parallel joints for which a warning names survey errors as the cause of the
#: angles. If the value is smaller, the warning also attributes a few intended wedges to survey errors.
_MANY_PAIRS = 10

#: Smallest spread of the wedge angles (upper divided by lower quartile) at which a warning names survey
#: errors as the cause. Survey errors have a spread of about 2.2 or more, voussoirs of equal width about 1.
_SCATTER_OF_SURVEY = 2.1


def _place_of_property(v: dict[str, Any]) -> str:
    """Return the place in a case file where a joint property is set: a joint, or the table [joints]."""
    return f"joint {pairs(v)}" if v["pairs"] else "[joints]"


def weights_differ(v: dict[str, Any]) -> str:
    """Return a warning that the unit weight of blocks differs much from the median of all blocks."""
    own, median = rounded(v["ratio"] * v["median"]), rounded(v["median"])
    quantity = "weight per area" if v["per_area"] else "unit weight"
    units = units_in_words(v["ratio"] * v["median"], v["median"])
    return (
        f"the {quantity} of {blocks(v['blocks'])} is {own}, but the median of all blocks is {median}: "
        f"{units}use the same units for all blocks"
    )


def fill_weight_differs(v: dict[str, Any]) -> str:
    """Return a warning that the unit weight of a fill or backing differs much from that of the blocks.

    If all blocks are weightless, the fills and backings are compared with each other.
    """
    own, other = rounded(v["unit_weight"]), rounded(v["other"])
    fill = f"{'the backing of ' if v['backing'] else ''}fill no. {v['fill']}"
    units = units_in_words(v["unit_weight"], v["other"])
    return (
        f"the unit weight of {fill} is {own}, but the unit weight of the {v['beside']} is {other}: "
        f"{units}use the same units for both weights"
    )


def strength_differs(v: dict[str, Any]) -> str:
    """Return a warning that the strength or prestress of a tie or prop probably has a wrong unit.

    The warning compares the force with the sum of all dead loads, or with the median weight of a block.
    """
    own, weight = rounded(v["value"]), rounded(v["weight"])
    compared = "the sum of all dead loads" if v["value"] > v["weight"] else "the median weight of a block"
    return (
        f"the {v['key']} of {v['kind']} '{v['name']}' is {own}, but {compared} is {weight}: use the same "
        "unit for forces and weights"
    )


def stress_differs(v: dict[str, Any]) -> str:
    """Return a warning that the strength or cohesion of joints probably has a wrong unit.

    The warning compares the value with the stress below a column of blocks, which is as high as the largest
    dimension of the scene.
    """
    own, weight = rounded(v["value"]), rounded(v["weight"])
    column = f"a column as high as the largest dimension of the scene presses with {weight} on its foot"
    return f"the {v['key']} of joints is {own}, but {column}: use the same units for stresses and weights"


def lengths_differ(v: dict[str, Any]) -> str:
    """Return a warning that the lengths of a scene do not fit the unit weight of its blocks."""
    own, unit = rounded(v["unit_weight"]), typical_unit(v["unit_weight"])
    return (
        f"the blocks extend over {rounded(v['extent'])}, but their median unit weight, {own}, looks like "
        f"{unit}: use metres for lengths, or the scene's unit of length for unit weights"
    )


def friction_high(v: dict[str, Any]) -> str:
    """Return a warning that a friction coefficient is high.

    If the value may be an angle in degrees, the warning contains the tangent of the angle.
    """
    friction = v["friction"]
    question = ": check the value"
    if friction < 90:
        question = f": is it in degrees? tan {friction:g}° = {tan(radians(friction)):.3f}"
    return (
        f"the friction coefficient {friction:g} of {_place_of_property(v)} is higher than in dry joints of "
        f"masonry{question}"
    )


def friction_low(v: dict[str, Any]) -> str:
    """Return a warning that a friction angle is small, and may be a tangent or an angle in radians."""
    angle = rounded(degrees(atan(v["friction"])))
    in_degrees = f"{degrees(degrees(atan(v['friction']))):.1f}"
    return (
        f"the friction angle of {_place_of_property(v)} is {angle}°, lower than in joints of masonry: if "
        f"tan φ = {angle} is meant, use 'friction' instead of 'friction_angle'; if {angle} rad is meant, set "
        f"'friction_angle' to {in_degrees}"
    )


def fill_angle_low(v: dict[str, Any]) -> str:
    """Return a warning that the friction angle of a fill may be a tangent or an angle in radians."""
    value = v["friction_angle"]
    fill = f"{'the backing of ' if v['backing'] else ''}fill no. {v['fill']}"
    return (
        f"the 'friction_angle' of {fill} is {value:g}°: if {value:g} is a tangent or an angle in radians, "
        f"set 'friction_angle' to {degrees(atan(value)):.1f} or {degrees(value):.1f}"
    )


def dilatancy_low(v: dict[str, Any]) -> str:
    """Return a warning that the dilatancy of a joint is less than minus its friction coefficient."""
    return (
        f"the dilatancy {v['dilatancy']:g} of {_place_of_property(v)} is less than minus the friction "
        f"coefficient, −{v['friction']:g}, so sliding would release energy: check the sign of 'dilatancy'"
    )


def _wide(width: float) -> str:
    """Return the width of a gap as text, rounded up to three significant digits.

    Messages round the contact tolerances that they advise in this way too.
    """
    # Round first, because the computed width of a gap of 0.01 may be 0.010000000000000231.
    return rounded_up(float(f"{width:.6g}"), 3)


def _joint_at_corners(v: dict[str, Any]) -> str:
    """Return a warning that blocks meet corner on corner.

    If wedges of mortar may fill the gaps at the corners, the warning advises a contact tolerance.
    """
    mortar = ""
    if v["wedge"] > 0:
        mortar = f"; if mortar fills the wedges between these blocks, {set_contact_tolerance(v['wedge'])}"
    return (
        f"{pairs(v)} meet corner on corner (in space, edge along edge): check the direction of the joints. A "
        "joint is on the bisector of the sides that face each other, but a corner that rests in a notch has "
        f"two joints, one on each side of the notch{mortar}"
    )


def small_gaps(v: dict[str, Any]) -> str:
    """Return a warning that small gaps separate blocks, and name a tolerance that closes the gaps."""
    wide = [f"up to {_wide(width)} wide" for width in v["widths"]]
    if v["option"] == "tolerance":
        set_option = set_tolerance(v["tolerance"])
        remedy = f"{set_option}, which closes the gaps and makes nearly parallel joints parallel"
    else:
        remedy = f"{set_contact_tolerance(v['tolerance'])}, which closes the gaps"
    return (
        "blocks face each other across a small gap, which carries no force and may change λ a lot: "
        f"{pairs(v, wide)}; if the blocks should touch, {remedy}"
    )


def lost_joints(v: dict[str, Any]) -> str:
    """Return a warning that a large tolerance removes joints, and name a remedy."""
    wide = [f"{_wide(width)} apart" if width > 0 else "touching" for width in v["widths"]]
    remedy = f"set 'tolerance' to less than {rounded_down(v['tolerance'])}"
    if max(v["widths"]) > 0:
        remedy = f"{set_contact_tolerance(max(v['widths']))} and remove 'tolerance'"
    return (
        "blocks face each other but have no joint, because their sides are too short compared with the "
        f"'tolerance': {pairs(v, wide)}; {remedy}"
    )


def bridged_by_tolerance(v: dict[str, Any]) -> str:
    """Return a warning that the tolerance closes gaps as wide as mortar joints, and name a remedy."""
    wide = [f"up to {_wide(width)} wide" for width in v["widths"]]
    remedy = f"{set_contact_tolerance(max(v['widths']))} and remove 'tolerance'"
    if v["aligning"]:
        remedy = set_both(max(v["widths"]), v["aligning"])
    return (
        "'tolerance' closes gaps as wide as mortar joints, but it also moves corners by similar distances, "
        f"which changes λ: {pairs(v, wide)}; if the gaps are mortar that is not drawn, {remedy}"
    )


def _gravity_differs(v: dict[str, Any]) -> str:
    """Return a warning that the unit of length of 'gravity' seems to differ from that of the scene."""
    evidence = (
        f"the secant period T_s of {v['period']:.4g} s does not fit blocks that extend over {v['extent']:.4g}"
    )
    *first, last = (f"{value:g} for {unit}" for unit, value in GRAVITY_BY_UNIT.items())
    return (
        f"gravity {v['gravity']:g} and the scene seem to use different units of length ({evidence}), so the "
        "result of the non-linear kinematic check may be wrong: set 'gravity' (--gravity) to "
        f"{', '.join(first)} or {last}"
    )


def nearly_parallel(v: dict[str, Any]) -> str:
    """Return a warning that joints are nearly parallel, and name a tolerance that makes them parallel."""
    remedy = f"if the joints should be parallel, {set_tolerance(v['tolerance'])}"
    if len(v["pairs"]) >= _MANY_PAIRS and v["scatter"] >= _SCATTER_OF_SURVEY:
        remedy = f"the angles scatter like errors of a survey: {remedy}"
    return (
        f"a block with almost parallel joints (the angle is at most {v['angle']:.2g} rad) is a wedge, which "
        f"can slide only if it lifts: {pairs(v)}; {remedy}"
    )


def _uneven_sides(v: dict[str, Any]) -> str:
    """Return a warning that blocks touch in several nearly parallel joints, and name a remedy."""
    return (
        "blocks touch in several nearly parallel joints (the angle is at most "
        f"{v['angle']:.2g} rad), so λ depends on small errors of the drawing: {pairs(v)}; if the sides of "
        f"these blocks should be flat, {set_tolerance(v['tolerance'])}"
    )


def _corners_bear(v: dict[str, Any]) -> str:
    """Return a warning that the strength does not limit forces at corners, and name the corners."""
    forces = [f"{force:.4g}" for force in v["normal_forces"]]
    where = f"crushing at {pairs(v)} may cause a collapse that this analysis does not find"
    if forces:
        where = f"the normal forces at collapse are {pairs(v, forces)}"
    return (
        "'strength' does not limit the force at a corner that rests on an edge, so check by hand that such "
        f"corners do not crush: {where}"
    )


#: Sentence for each reason code about inputs. A sentence is a format string for the values of the reason, or
#: a function of these values.
INPUT_SENTENCES: dict[Code, str | Callable[[dict[str, Any]], str]] = {
    Code.FRICTION_HIGH: friction_high,
    Code.FRICTION_LOW: friction_low,
    Code.DILATANCY_LOW: dilatancy_low,
    Code.IDLE_SUPPORTS: lambda v: (
        f"fixed {blocks(v['blocks'])} {verb(len(v['blocks']), 'touch')} no movable block, tie or prop: close "
        "the gap if blocks should rest on the support"
    ),
    Code.HELD_BY_CLAMPING: lambda v: (
        "some joints at supports resist by friction although no load presses their blocks together: "
        f"{pairs(v)}; add the load that clamps these joints, or set their friction to 0"
    ),
    Code.FAR_AWAY: lambda v: (
        f"{do(v, 'lie')} at least {rounded(v['distance'])} away from all other blocks, which extend over "
        f"{rounded(v['size'])}: are all coordinates in the same unit?"
    ),
    Code.SMALL_GAPS: small_gaps,
    Code.LOST_JOINTS: lost_joints,
    Code.BRIDGED_BY_TOLERANCE: bridged_by_tolerance,
    Code.ALIGNED: lambda v: (
        f"joints were turned by up to {v['turn']:.2g} rad to be parallel or perpendicular to other joints, "
        f"within the tolerance {rounded(v['tolerance'])}: {pairs(v)}; if the blocks should be wedges, lower "
        "'tolerance'"
    ),
    Code.NEARLY_PARALLEL: nearly_parallel,
    Code.UNEVEN_SIDES: _uneven_sides,
    Code.JOINT_AT_CORNERS: _joint_at_corners,
    Code.CORNERS_MEET: lambda v: (
        f"{pairs(v)} touch only at corners. No joint is made there, because it would have no length: let a "
        "corner of one block rest on an edge of the other"
    ),
    Code.WITHOUT_NORMAL: lambda v: (
        f"{pairs(v)} meet corner on corner, corner on edge or edge along edge. No joint is made there, "
        "because the contact has no normal: if the blocks press on each other, replace the corner or edge of "
        "one block by a narrow face"
    ),
    Code.FACES_TURNED: lambda v: (
        f"some faces of {blocks(v['blocks'])} list their corners clockwise, others counter-clockwise; all "
        "faces were turned outwards: check the order of the corners"
    ),
    Code.CORNERS_BEAR: _corners_bear,
    Code.BARE_EDGE_LOAD: (
        "edge_load no. {number} has no effect along a length of {length:.4g}, because no movable block has a "
        "free edge there: correct the ends of the load, or increase 'tolerance'"
    ),
    Code.AXLES_LEFT_OUT: lambda v: (
        f"this analysis ignores the axles {', '.join(map(repr, v['names']))}: only the analysis 'crossing' "
        "moves axles"
        if v["names"]
        else "this analysis ignores the axles of the load case: only the analysis 'crossing' moves axles"
    ),
    Code.WEIGHTS_DIFFER: weights_differ,
    Code.FILL_WEIGHT_DIFFERS: fill_weight_differs,
    Code.IDLE_BACKING: (
        "the backing of fill no. {fill} has no effect, because it touches no block: its 'line' is below all "
        "blocks, or blocks separate it from the road"
    ),
    Code.FILL_ANGLE_LOW: fill_angle_low,
    Code.STRENGTH_DIFFERS: strength_differs,
    Code.STRESS_DIFFERS: stress_differs,
    Code.LENGTHS_DIFFER: lengths_differ,
    Code.GRAVITY_DIFFERS: _gravity_differs,
    Code.ACTS_OUTSIDE: lambda v: (
        f"the {v['load']} force of {blocks(v['blocks'])} acts {rounded(v['distance'])} outside the block: "
        f"correct its point of application in scene coordinates ('{v['load']}_at' of the block, or 'at' of "
        "the load)"
    ),
    Code.FORCES_DIFFER: lambda v: (
        f"the {v['load']} force on {blocks(v['blocks'])} is {rounded(v['ratio'])} times the weight of the "
        "block, or of a typical block if that is larger: are forces and weights in the same unit?"
    ),
}

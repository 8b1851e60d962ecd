"""Warn about properties of a scene that are permitted but look unintended."""

import math
from collections.abc import Callable, Iterator

import numpy as np

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.fill import fill_forces
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.loads import weights
from masonry_opt.scene.contacts.gaps import Gaps
from masonry_opt.scene.contacts.mortar import wedge_at_corners
from masonry_opt.scene.joints import JointDefaults
from masonry_opt.scene.road import SMALL_FRICTION_ANGLE
from masonry_opt.scene.rows import linked
from masonry_opt.solution.force_units import (
    is_per_area,
    lower_median,
    unit_weights,
    unusual_lengths,
    unusual_stresses,
)
from masonry_opt.solution.reasons import Code, Reason, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import NEGLIGIBLE_SHARE
from masonry_opt.solution.typical_units import in_other_unit
from masonry_opt.solution.wedges import uneven_sides, wedges

#: A friction coefficient above this value (tan 72°) causes a warning: it may be an angle in degrees. With a
#: larger limit, warnings miss small angles in degrees.
_HIGH_FRICTION = 3.0

#: A friction angle of less than 1.1°, the arctangent of this value, causes a warning: it may be a tangent or
#: an angle in radians. With a smaller limit, warnings miss large angles in radians, such as 1.0 (57°).
_SMALL_FRICTION = 0.02


def _is_small_angle(friction: float) -> bool:
    """Return True if a small friction angle in degrees may be meant as a tangent or in radians.

    Joints store the tangent only. A coefficient with at most six significant digits was given as a
    coefficient, and is intended, such as that of a bearing. Otherwise, the coefficient was given as an angle
    if one of these values has at most six digits:

    - the angle in degrees;
    - the tangent of this number, as if an angle in radians had been computed from the tangent;
    - this number converted from radians to degrees, as if it had been computed from degrees.
    """

    def is_round(value: float) -> bool:
        return math.isclose(value, float(f"{value:.6g}"), rel_tol=1e-12)

    if not 0.0 < friction < _SMALL_FRICTION or is_round(friction):
        return False
    angle = math.degrees(math.atan(friction))
    return any(map(is_round, (angle, math.tan(angle), math.degrees(angle))))


#: Tests for unusual joint properties: code of the warning, names of the properties, and condition on the
#: properties.
_UNUSUAL: tuple[tuple[Code, tuple[str, ...], Callable[[JointDefaults], bool]], ...] = (
    (Code.FRICTION_HIGH, ("friction",), lambda joint: _HIGH_FRICTION < joint.friction < np.inf),
    (Code.FRICTION_LOW, ("friction",), lambda joint: _is_small_angle(joint.friction)),
    # If the dilatancy is below −friction, the normal force does more work in a slip than friction dissipates.
    (Code.DILATANCY_LOW, ("dilatancy", "friction"), lambda joint: joint.dilatancy < -joint.friction),
)

#: A warning says that a group of blocks is far away if its distance to all other blocks exceeds this ratio
#: times a size. The size is that of the group or that of all other blocks, whichever is larger.
_FAR_DISTANCE_RATIO = 10.0

#: Ratio of two unit weights, or of a force to a weight, above which a warning says that their units differ. A
#: mix of kN and N causes the ratio 1000. If the materials differ too, the ratio can fall to about 330.
#: With a smaller value, scenes of very different materials cause wrong warnings.
_OTHER_UNITS = 300.0

#: The specified weight of a plane block is checked for a wrong unit if its weight per area differs from the
#: median by more than this factor. Smaller differences can be due to the thickness.
_OTHER_THICKNESS = 50.0

#: If the strength or prestress of a tie or prop exceeds this multiple of the sum of all dead loads, a
#: warning asks the user to check that forces and weights are in the same unit. With a larger value, the
#: warning would miss a strength in N in a large scene with weights in kN.
_DEAD_LOADS_TO_STRENGTH = 20.0

#: If the strength of a tie or prop is below both of two limits, a warning asks the user to check that forces
#: and weights are in the same unit. The limits are the sum of all dead loads divided by this value, and a
#: fifth of the median block weight. With a larger value, fewer strengths cause the warning.
_SUM_TO_STRENGTH = 300.0

#: If a block weighs more than this multiple of a dead force on it, a warning asks the user to check that
#: forces and weights are in the same unit. The same warning is issued for a prestress below the median block
#: weight divided by this value. With a larger value, warnings miss forces in MN together with weights in kN.
_WEIGHT_TO_FORCE_RATIO = 1000.0

#: A force causes a warning if its distance from its block exceeds this fraction of the block's width (square
#: root of its area, cube root of its volume). Smaller distances count as rounding errors.
_LARGEST_FORCE_DISTANCE = 0.02

#: Fraction of a block's weight below which a difference of forces counts as a rounding error.
_FORCE_DIFFERENCE_TOLERANCE = 1e-9

#: Map from the dimension to the code of the warning about blocks that meet without a joint.
_MEETING_CODES = {2: Code.CORNERS_MEET, 3: Code.WITHOUT_NORMAL}


def warnings_of(assembly: Assembly, solution: Solution | None) -> tuple[Reason, ...]:
    """Return the warnings about a scene, as codes with values.

    Some warnings need a solution; they are omitted if it is None.
    """
    of_wedges, joints = tuple(wedges(assembly, solution)), assembly.joints
    return (
        *_joints(assembly),
        *_idle_supports(assembly),
        *_clamping(assembly, solution),
        *_small_gaps(assembly, of_wedges),
        *_gaps_of(assembly, Code.LOST_JOINTS, joints.lost.gaps, tolerance=joints.lost.tolerance),
        *_gaps_of(assembly, Code.BRIDGED_BY_TOLERANCE, joints.bridged, aligning=joints.aligning),
        *_blocks(assembly),
        *of_wedges,
        *uneven_sides(assembly),
        *_bearing_corners(assembly, solution),
        *_loads(assembly),
        *_far_away(assembly),
        *_acting_outside(assembly),
        *_weights(assembly),
        *_fill_weights(assembly),
        *_fill_angles(assembly),
        *_idle_backings(assembly),
        *_strengths(assembly),
        *unusual_stresses(assembly),
        *unusual_lengths(assembly),
    )


def _joints(assembly: Assembly) -> Iterator[Reason]:
    """Generate warnings about unusual friction or dilatancy of joints.

    One warning is about the defaults of the scene. A second warning names all joints with an unusual property
    of their own, and has the values of the first named joint.
    """
    scene, defaults = assembly.scene, assembly.scene.joints
    for code, names, unusual in _UNUSUAL:
        candidates = [
            exception
            for exception in scene.exceptions
            if any(getattr(exception, name) is not None for name in names)
        ]
        own = [exception for exception in candidates if unusual(exception.over(defaults))]
        pairs = [list(exception.between) for exception in own]
        for joint, named in (defaults, []), *((exception.over(defaults), pairs) for exception in own[:1]):
            if unusual(joint):
                yield reason(code, **{name: getattr(joint, name) for name in names}, pairs=named)


def _idle_supports(assembly: Assembly) -> list[Reason]:
    """Return a list with a warning that names the supports without function, or an empty list.

    A support has a function if it touches a movable block, if a fill touches it, or if a tie or prop ends at
    it.
    """
    idle = np.ones(len(assembly.scene.blocks), dtype=bool)
    idle[[piece.block for piece in assembly.filled_pieces]] = False
    ends = [action.block for force in assembly.limited for action in force.actions]
    idle[[block for block in ends if block >= 0]] = False
    idle[assembly.movable] = idle[assembly.joints.first] = idle[assembly.joints.second] = False
    idle[assembly.joints.overlaps] = False
    return [reason(Code.IDLE_SUPPORTS, blocks=assembly.names(np.flatnonzero(idle)))] if idle.any() else []


def _clamping(assembly: Assembly, solution: Solution | None) -> list[Reason]:
    """Return a warning about joints at supports that transfer friction only because of self-stress."""
    infeasibility = solution.infeasibility if solution and solution.load_factor is None else None
    clamped = assembly.joints_of(np.array(infeasibility.clamped if infeasibility else (), dtype=int))
    joints = assembly.joints
    supports = ~np.isin([joints.first[clamped], joints.second[clamped]], assembly.movable).all(axis=0)
    if not supports.any():
        return []
    return [reason(Code.HELD_BY_CLAMPING, pairs=assembly.pairs_of(clamped[supports]))]


def _small_gaps(assembly: Assembly, of_wedges: tuple[Reason, ...]) -> list[Reason]:
    """Return a warning that names the pairs of blocks with a small gap between them, widest gap first.

    The warning also names the option that closes all gaps. If the option is ``tolerance``, its value also
    aligns the joints in warnings about wedges.
    """
    joints = assembly.joints
    gaps = dict(sorted(joints.gaps.items(), key=lambda gap: -gap[1]))
    if not gaps:
        return []
    pairs = [assembly.names(np.array(pair)) for pair in gaps]
    aligning = [wedge.values["tolerance"] for wedge in of_wedges if wedge.code is Code.NEARLY_PARALLEL]
    option, tolerance = joints.closing
    if option == "tolerance":
        tolerance = max([tolerance, *aligning])
    values = {"widths": list(gaps.values()), "option": option, "tolerance": tolerance}
    return [reason(Code.SMALL_GAPS, pairs=pairs, **values)]


def _gaps_of(assembly: Assembly, code: Code, gaps: Gaps, **values: float) -> list[Reason]:
    """Return a warning that names the pairs of blocks that the given gaps separate, widest gap first.

    The list is empty if there are no gaps. ``code`` is the code of the warning, and ``values`` are further
    values of the warning.
    """
    widest_first = dict(sorted(gaps.items(), key=lambda gap: -gap[1]))
    if not widest_first:
        return []
    pairs = [assembly.names(np.array(pair)) for pair in widest_first]
    return [reason(code, pairs=pairs, widths=list(widest_first.values()), **values)]


def _blocks(assembly: Assembly) -> Iterator[Reason]:
    """Generate warnings about blocks that meet at corners, and about solids with inconsistent faces.

    The vertices of such a solid are clockwise in some of its faces and counter-clockwise in others.
    """
    pairs = assembly.joints.at_corners
    at_corners = [assembly.names(np.array(pair)) for pair in pairs]
    if at_corners:
        wedge = wedge_at_corners(assembly.scene, assembly.geometry, pairs)
        yield reason(Code.JOINT_AT_CORNERS, pairs=at_corners, wedge=wedge)
    meeting = [assembly.names(np.array(pair)) for pair in assembly.joints.without_normal]
    if meeting:
        yield reason(_MEETING_CODES[assembly.scene.dimension], pairs=meeting)
    mixed = assembly.geometry.mixed
    if len(mixed):
        yield reason(Code.FACES_TURNED, blocks=assembly.names(mixed))


def _bearing_corners(assembly: Assembly, solution: Solution | None) -> list[Reason]:
    """Return a warning about corners that press on edges of limited strength.

    The warning concerns plane scenes only, because joints in space have no strength. The strength
    does not limit the normal force on a corner, which has no area.
    """
    problem, joints = assembly.problem, assembly.joints
    limited = np.flatnonzero((joints.extent == 0) & np.isfinite(joints.strength))
    if solution is None or not len(limited):
        return []
    if solution.load_factor is None or solution.q is None:
        # If the analysis finds no limit of the live load, the real limit may be crushing at corners. No
        # normal forces are known in this case, so the warning names all joints of limited strength at
        # corners.
        pairs = assembly.pairs(limited)
        if solution.status.unlimited and pairs:
            return [reason(Code.CORNERS_BEAR, pairs=pairs, normal_forces=[])]
        return []
    n = problem.normal_forces(solution.q)
    pressed = limited[n[limited] > NEGLIGIBLE_SHARE * np.abs(n).max(initial=0.0)]
    order = pressed[np.argsort(-n[pressed], kind="stable")]
    forces = (n[order] * problem.force_unit).tolist()
    return [reason(Code.CORNERS_BEAR, pairs=assembly.pairs(order), normal_forces=forces)] if forces else []


def _loads(assembly: Assembly) -> Iterator[Reason]:
    """Generate warnings about edge loads that extend beyond edges, and about axles that are ignored."""
    scene = assembly.scene
    for number, length in enumerate(assembly.bare_edge_loads, start=1):
        if length > assembly.geometry.tolerance:
            yield reason(Code.BARE_EDGE_LOAD, number=number, length=length)
    names = [group.name for group in scene.axles]
    has_axles = names if scene.load_case is None else scene.factor_of_axles
    if has_axles:
        yield reason(Code.AXLES_LEFT_OUT, names=names)


def _far_away(assembly: Assembly) -> list[Reason]:
    """Return a warning that names groups of blocks that are far away from all other blocks.

    Blocks that joints connect form a group. The distance of a group is measured from the bounding box of all
    other groups.
    """
    group = linked(len(assembly.scene.blocks), assembly.joints.first, assembly.joints.second)
    groups = group.max() + 1
    if groups == 1:
        return []
    low, high = assembly.geometry.boxes
    # Negate the upper bounds of the boxes. The outermost bound of a group of blocks is then a minimum, for
    # lower and upper bounds alike.
    bounds, axes = np.column_stack([low, -high]), low.shape[1]
    lowest = np.full((groups, 2 * axes), np.inf)
    np.minimum.at(lowest, group, bounds)
    # For each group, compute the bounding box of all other groups. A bound of this box is the least bound of
    # all groups, or the second least bound if the least bound belongs to the group itself.
    least, second = np.sort(lowest, axis=0)[:2]
    other_boxes = np.where(lowest == least, second, least)
    size, other_sizes = (
        np.hypot.reduce(-box[:, axes:] - box[:, :axes], axis=1) for box in (lowest, other_boxes)
    )
    apart = np.maximum(lowest[:, :axes] + other_boxes[:, axes:], other_boxes[:, :axes] + lowest[:, axes:])
    distance = np.hypot.reduce(np.maximum(0.0, apart), axis=1)
    far = distance > _FAR_DISTANCE_RATIO * np.maximum(size, other_sizes)
    # The largest group counts as the structure itself, so the warning does not name it.
    far[np.bincount(group).argmax()] = False
    if not far.any():
        return []
    nearest = np.flatnonzero(far)[distance[far].argmin()]
    values = {"distance": float(distance[nearest]), "size": float(other_sizes[nearest])}
    return [reason(Code.FAR_AWAY, blocks=assembly.names(np.flatnonzero(far[group])), **values)]


def _acting_outside(assembly: Assembly) -> Iterator[Reason]:
    """Generate warnings about forces that act outside the convex hulls of their blocks.

    Forces at a block's own ``weight_at`` are not checked: the centroid of a curved stone may be outside of
    its straight edges. Points of loads refer to the blocks at rest, also if supports have settled.
    """
    at_rest = assembly.at_rest or assembly
    shapes, blocks = at_rest.geometry, assembly.scene.blocks
    index_of = {block.name: index for index, block in enumerate(blocks)}
    for load in ("live", "dead"):
        points = [(index, getattr(block, f"{load}_at")) for index, block in enumerate(blocks)]
        placed = [(index, at) for index, at in points if at is not None and at != blocks[index].weight_at]
        own = [force for force in assembly.scene.loads if force.at and getattr(force, load) is not None]
        placed += [(index_of[force.block], force.at) for force in own]
        if not placed:
            continue
        index = np.array([index for index, _ in placed])
        distance = shapes.outside(index, np.array([point for _, point in placed]) - shapes.origin)
        order = np.argsort(-distance, kind="stable")
        outside = order[(distance > _LARGEST_FORCE_DISTANCE * shapes.width[index])[order]]
        if len(outside):
            values = {"blocks": assembly.names(index[outside]), "distance": float(distance[outside[0]])}
            yield reason(Code.ACTS_OUTSIDE, load=load, **values)


def _weights(assembly: Assembly) -> list[Reason]:
    """Return warnings about unit weights and about ratios of force to weight that suggest mixed units."""
    problem, scene, movable = assembly.problem, assembly.scene, assembly.movable
    weight = weights(scene, assembly.geometry, movable)
    density = unit_weights(assembly)
    heavy = density > 0
    if not heavy.any():
        return []
    median = lower_median(density[heavy])
    ratio = np.where(heavy, density / median, 1.0)
    most = (_OTHER_UNITS, _OTHER_UNITS)
    per_area = is_per_area(scene)
    by_size = np.array([scene.blocks[index].unit_weight is not None for index in movable]) | (not per_area)
    differs = by_size | (np.maximum(ratio, 1 / ratio) > _OTHER_THICKNESS)
    mixed = heavy & differs & in_other_unit(density, median)
    values = {"median": median, "per_area": per_area}
    warnings = _differing(assembly, Code.WEIGHTS_DIFFER, ratio, most, mixed, **values)
    # A force on a light block, such as a jack's plate, may be much larger than the block's own weight. Such a
    # force is compared with the median weight.
    weight_near = np.maximum(weight, np.median(weight[heavy]))
    live, dead = (problem.forces(load) * problem.force_unit for load in (problem.live, problem.dead))
    # Weights and forces of fill are subtracted, so that only forces specified by the user are checked.
    of_fill = fill_forces(scene, assembly.geometry, assembly.filled_pieces)["dead"][movable, : dead.shape[1]]
    dead = dead - scene.factor("dead", "weight") * weight[:, None] * scene.down - of_fill
    # Small live forces cause no warning, because a live force is often a unit force.
    for name, force, least in (("live", live, np.inf), ("dead", dead, _WEIGHT_TO_FORCE_RATIO)):
        size = np.hypot.reduce(force, axis=1)
        acts = size > _FORCE_DIFFERENCE_TOLERANCE * weight
        ratio = np.divide(size, np.clip(size, weight, weight_near), out=np.ones_like(size), where=acts)
        none = np.zeros(len(ratio), dtype=bool)
        warnings += _differing(assembly, Code.FORCES_DIFFER, ratio, (_OTHER_UNITS, least), none, load=name)
    return warnings


def _fill_weights(assembly: Assembly) -> Iterator[Reason]:
    """Generate warnings about unit weights of fills and backings that seem to have a wrong unit.

    Fills and backings are compared with the blocks, or with each other if all blocks are weightless.
    """
    of_blocks = unit_weights(assembly)
    heavy = of_blocks[of_blocks > 0]
    fills = assembly.scene.fills
    kind = "blocks" if len(heavy) else "fill"
    zones = [zone.unit_weight for fill in fills for zone in fill.zones if zone.unit_weight > 0]
    compared = heavy if len(heavy) else np.array(zones)
    if not len(compared):
        return
    median = lower_median(compared)
    for number, fill in enumerate(fills, start=1):
        for zone, backing in zip(fill.zones, (False, True), strict=False):
            ratio = zone.unit_weight / median
            is_extreme = not 1 / _OTHER_UNITS <= ratio <= _OTHER_UNITS
            if is_extreme or in_other_unit(np.array(zone.unit_weight), median):
                values = {"unit_weight": zone.unit_weight, "beside": kind, "other": median}
                yield reason(Code.FILL_WEIGHT_DIFFERS, fill=number, backing=backing, **values)


def _fill_angles(assembly: Assembly) -> Iterator[Reason]:
    """Generate warnings if friction angles of fills or backings may be meant as tangents or in radians.

    An angle below ``SMALL_FRICTION_ANGLE``, in degrees, causes a warning if the fill exerts pressure. The
    angle 0 causes no warning, because it is that of a fluid.
    """
    for number, fill in enumerate(assembly.scene.fills, start=1):
        of_backing = fill.backing.friction_angle if fill.backing else None
        for backing, angle in ((False, fill.friction_angle), (True, of_backing)):
            if fill.pressure and angle and angle < SMALL_FRICTION_ANGLE:
                yield reason(Code.FILL_ANGLE_LOW, fill=number, backing=backing, friction_angle=angle)


def _idle_backings(assembly: Assembly) -> Iterator[Reason]:
    """Generate warnings about backings that touch no block."""
    backed = {piece.fill for piece in assembly.filled_pieces if piece.zone}
    for number, fill in enumerate(assembly.scene.fills):
        if fill.backing and number not in backed:
            yield reason(Code.IDLE_BACKING, fill=number + 1)


def _strengths(assembly: Assembly) -> Iterator[Reason]:
    """Generate warnings about strengths and prestresses of ties and props that seem to have a wrong unit."""
    problem = assembly.problem
    weight = weights(assembly.scene, assembly.geometry, assembly.movable)
    if not weight.any():
        return
    median = lower_median(weight[weight > 0])
    all_dead = float(np.hypot.reduce(problem.forces(problem.dead), axis=1).sum()) * problem.force_unit
    least_strength = min(all_dead / _SUM_TO_STRENGTH, median / 5)
    # Values below ``least`` cause a warning. The limit is lower for prestress than for strength, because a
    # tie that is tightened by hand has a small prestress.
    least = {"strength": least_strength, "prestress": median / _WEIGHT_TO_FORCE_RATIO}
    for force in assembly.limited:
        if force.role not in (Role.TIE, Role.PROP):
            continue
        named = {"kind": str(force.role), "name": force.name}
        for key, value in (("strength", force.highest), ("prestress", force.lowest)):
            if np.isfinite(value) and value > _DEAD_LOADS_TO_STRENGTH * all_dead:
                yield reason(Code.STRENGTH_DIFFERS, **named, key=key, value=value, weight=all_dead)
            elif 0 < value < least[key]:
                yield reason(Code.STRENGTH_DIFFERS, **named, key=key, value=value, weight=median)


def _differing(
    assembly: Assembly,
    code: Code,
    ratio: np.ndarray,
    most: tuple[float, float],
    included: np.ndarray,
    **values: object,
) -> list[Reason]:
    """Return a warning that names the blocks with extreme values of a ratio, the most extreme value first.

    A ratio is extreme if it exceeds ``most[0]``, or if its inverse exceeds ``most[1]``. Blocks for which
    ``included`` is True are named too.
    """
    above, below = most
    deviation = np.abs(np.log(ratio))
    order = np.argsort(-deviation, kind="stable")
    differ = order[((ratio > above) | (ratio < 1 / below) | included)[order]]
    names = assembly.names(assembly.movable[differ])
    return [reason(code, blocks=names, ratio=float(ratio[differ[0]]), **values)] if names else []

"""Find holes, copies and frames among the closed outlines of a drawing."""

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from itertools import compress
from typing import NamedTuple

import numpy as np
import shapely

from masonry_opt.errors import rounded
from masonry_opt.scene.drawings.defects import Defect, Defects, near
from masonry_opt.scene.drawings.outlines import Curve, Outline
from masonry_opt.scene.geometry import RELATIVE_TOLERANCE, least_width
from masonry_opt.scene.rows import linked
from masonry_opt.scene.tolerance_advice import lower_tolerance

#: Largest relative difference in area at which an outline inside another outline counts as a copy. With a
#: larger value, a hole that almost fills a block would count as a copy of the block's outline.
_EQUAL_AREA_TOLERANCE = 1e-9

#: The bisection for a tolerance ends when the ratio of its upper to its lower bound is below this value. With
#: a larger value, messages advise smaller tolerances than necessary.
_LIMIT_PRECISION = 1.01

#: An outline can be a frame around the drawing if it contains at least this many other outlines. With the
#: value 1, a block with one hole would count as a frame.
_FEWEST_IN_FRAME = 2

#: An outline inside another outline is read as a hole, unless it seems to be a smaller copy of the outer
#: outline. If both share a side, the inner outline counts as a copy if its area exceeds this fraction of the
#: outer area. With a larger value, small copies are read as holes. With a smaller value, large openings at
#: the edge of a wall are refused as copies.
_LARGEST_OPENING = 0.5

#: An inner outline also counts as a copy of the outer outline if the mean thickness of the ring between them
#: is below this fraction of the outer outline's width. With a larger value, thin pipes are refused.
_THINNEST_RING = 0.02

#: A hole shares a side with the outline of its block if the length that they share exceeds this multiple of
#: the tolerance. Where only a corner of the hole touches the outline, the shared length is shorter.
_SHORTEST_SIDE = 10.0


class OutlineTolerance(NamedTuple):
    """Length below which details of outlines are ignored."""

    option: str  #: option that sets the length: "tolerance" or "outline_tolerance"
    length: float  #: length below which details of outlines are ignored
    rounding: float  #: rounding error of the drawing, at most ``length``


class Nesting(NamedTuple):
    """Blocks of a drawing with their holes, and duplicate outlines that were left out."""

    blocks: list[Outline]
    copies: list[tuple[Curve, Curve]]  #: each copy that was left out, with its original


def outlines_with_holes(
    outlines: Sequence[Curve],
    is_support: Sequence[bool],
    tolerance: OutlineTolerance,
    overlap: float,
    defects: Defects,
) -> Nesting:
    """Separate outlines of blocks from outlines of holes, and leave out duplicate outlines.

    An outline inside another outline, apart from an overlap, is a hole in a block. An outline inside a hole
    is a block again. If the outline of a hole is drawn twice, the first outline is the hole, and the second
    outline is the block that fills it. All further copies of an outline are left out. If equal outlines are
    outside all holes, the first outline on a layer of supports is read, or else the first outline.

    Outlines that have no area or cross themselves are added to the defects and left out.
    """
    is_collapsed = [_is_collapsed(curve, tolerance) for curve in outlines]
    curve_polygons = [
        (curve, None if collapses else _polygon(curve, tolerance.length, defects))
        for curve, collapses in zip(outlines, is_collapsed, strict=True)
    ]
    if any(is_collapsed):
        # Stop if outlines have lost their area: without these outlines, other outlines would count as blocks
        # instead of holes.
        _add_collapsed(list(compress(outlines, is_collapsed)), outlines, tolerance, defects)
        return Nesting([], [])
    has_polygon = [polygon is not None for _, polygon in curve_polygons]
    curves = [curve for curve, polygon in curve_polygons if polygon is not None]
    polygons = np.array([polygon for _, polygon in curve_polygons if polygon is not None], dtype=object)
    supports = np.array(is_support, dtype=bool)[has_polygon]
    if not len(polygons):
        return Nesting([], [])
    area = shapely.area(polygons)
    inner, outer = shapely.STRtree(polygons).query(shapely.point_on_surface(polygons), predicate="within")
    area_outside = shapely.area(shapely.difference(polygons[inner], polygons[outer]))
    is_inside = (inner != outer) & (area_outside <= overlap * shapely.length(polygons[inner]))
    is_equal = is_inside & (np.abs(area[inner] - area[outer]) <= _EQUAL_AREA_TOLERANCE * area[outer])
    group = linked(len(polygons), inner[is_equal], outer[is_equal])
    is_within = is_inside & (group[inner] != group[outer]) & (area[inner] < area[outer])
    surrounding_groups: defaultdict[int, set[int]] = defaultdict(set)
    for inner_number, outer_number in zip(inner[is_within].tolist(), outer[is_within].tolist(), strict=True):
        surrounding_groups[int(group[inner_number])].add(int(group[outer_number]))
    members: defaultdict[int, list[int]] = defaultdict(list)
    for number, label in enumerate(group.tolist()):
        members[label].append(number)
    group_outlines: dict[int, list[int]] = {}
    depth: dict[int, int] = {}
    copies = []
    for label in sorted(members, key=lambda label: -area[members[label][0]]):
        equal_outlines = members[label]
        depth[label] = sum(len(group_outlines[outer_label]) for outer_label in surrounding_groups[label])
        # Keep two of several equal outlines inside a block: a hole and the block that fills it. Elsewhere,
        # keep a single outline.
        needed_outlines = (
            equal_outlines[:2]
            if depth[label] % 2
            else [min(equal_outlines, key=lambda number: not supports[number])]
        )
        group_outlines[label] = needed_outlines
        copies += [(number, needed_outlines[0]) for number in equal_outlines if number not in needed_outlines]
    return Nesting(
        _blocks(curves, polygons, group_outlines, depth, surrounding_groups),
        [(curves[number], curves[original]) for number, original in sorted(copies)],
    )


def _blocks(
    curves: Sequence[Curve],
    polygons: np.ndarray,
    group_outlines: dict[int, list[int]],
    depth: dict[int, int],
    surrounding_groups: dict[int, set[int]],
) -> list[Outline]:
    """Return the blocks with their holes, in the order of the drawing.

    Outlines are grouped by equal shape: ``group_outlines`` maps each group to its outlines, ``depth`` to the
    number of outlines around it, and ``surrounding_groups`` to the groups around it.
    """
    holes: defaultdict[int, list[int]] = defaultdict(list)
    blocks = []
    for label, numbers in group_outlines.items():
        if depth[label] % 2 == 0:
            blocks.append(numbers[0])
            continue
        parent = max(
            surrounding_groups[label],
            key=lambda outer_label: depth[outer_label] + len(group_outlines[outer_label]),
        )
        holes[group_outlines[parent][-1]].append(numbers[0])
        blocks += numbers[1:]
    outlines = []
    for block in sorted(blocks):
        rings = [polygons[hole].exterior for hole in sorted(holes[block])]
        shape = shapely.Polygon(polygons[block].exterior, rings)
        outlines.append(Outline(shape, curves[block], tuple(curves[hole] for hole in sorted(holes[block]))))
    return outlines


def _remove_details(curve: Curve, tolerance: float) -> shapely.Polygon:
    """Return the polygon of a closed curve without sides that are shorter than a tolerance.

    The end of a short side is removed. If the sides next to it are long, the removed end is the one that
    changes the area less, so that a gap in a side does not tilt the next side.
    """
    previous_points, next_points = (np.roll(curve.points, shift, axis=0) for shift in (1, -1))
    side = curve.points - previous_points
    is_short = np.hypot(*side.T) <= tolerance
    area = np.abs(np.linalg.det(np.stack([side, next_points - curve.points], axis=1)))
    is_alone = is_short & ~np.roll(is_short, 1) & ~np.roll(is_short, -1)
    begins = is_alone & (np.roll(area, 1) < (1 - _EQUAL_AREA_TOLERANCE) * area)
    is_removed = (is_short & ~begins) | np.roll(begins, -1)
    points = curve.points[~is_removed]
    return shapely.Polygon(points if len(points) > 2 else None)


def _has_area(curve: Curve, tolerance: float) -> bool:
    """Return True if a closed curve still encloses an area after details within the tolerance are removed."""
    return bool(_remove_details(curve, tolerance).convex_hull.area > tolerance**2)


def _is_collapsed(curve: Curve, tolerance: OutlineTolerance) -> bool:
    """Return True if a closed curve encloses an area as drawn, but not after small details are removed."""
    return not _has_area(curve, tolerance.length) and _has_area(curve, tolerance.rounding)


def _largest_tolerance(curve: Curve, tolerance: OutlineTolerance) -> float:
    """Return the largest tolerance at which a closed curve still encloses an area, found by bisection."""
    low, high = tolerance.rounding, tolerance.length
    while high > _LIMIT_PRECISION * low:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if _has_area(curve, middle) else (low, middle)
    return low


def _add_collapsed(
    collapsed_curves: Sequence[Curve],
    outlines: Sequence[Curve],
    tolerance: OutlineTolerance,
    defects: Defects,
) -> None:
    """Add a defect for each outline that encloses no area after details within the tolerance are removed.

    All of these defects have one remedy: a smaller tolerance, with which all outlines enclose an area.
    """
    limit = min(_largest_tolerance(curve, tolerance) for curve in collapsed_curves)
    widths = (least_width(shapely.Polygon(curve.points)) for curve in outlines if len(curve.points) > 2)
    thickness = min((width for width in widths if width > tolerance.rounding), default=limit)
    no_area = f"no area within '{tolerance.option}' {rounded(tolerance.length)}"
    advice = lower_tolerance(thickness, limit, tolerance.option)
    remedy = f"the thickness of the thinnest outline is {rounded(thickness)}, so {advice}"
    for curve in collapsed_curves:
        plural_mistake, place = f"outlines have {no_area}", near(*curve.points[0])
        defects.add(Defect(curve.label, f"has {no_area}", plural_mistake, remedy, place))


def _polygon(curve: Curve, tolerance: float, defects: Defects) -> shapely.Polygon | None:
    """Return the polygon of a closed curve.

    If the curve has no area or crosses itself, add a defect and return None.
    """
    polygon = _remove_details(curve, tolerance)
    if not _has_area(curve, tolerance):
        place = near(*curve.points[0])
        defect = Defect(
            curve.label, "has no area", "outlines have no area", "delete outlines without area", place
        )
        size = float(np.ptp(curve.points, axis=0).max())
        if _has_area(curve, RELATIVE_TOLERANCE * size):
            description = f"smaller than the tolerance {rounded(tolerance)}"
            remedy = (
                "delete outlines that are too small; if the tolerance is too large because some outlines are "
                "far away, delete the distant outlines instead"
            )
            defect = Defect(curve.label, f"is {description}", f"outlines are {description}", remedy, place)
        defects.add(defect)
        return None
    if polygon.is_valid:
        return shapely.orient_polygons(polygon)
    # GEOS writes the first crossing in square brackets, as in "Self-intersection[2 0.5]".
    crossing = re.search(r"\[(\S+) (\S+)\]", shapely.is_valid_reason(polygon))
    place = near(*map(float, crossing.groups())) if crossing else near(*curve.points[0])
    remedy = "draw the corners in order along the outline"
    defects.add(Defect(curve.label, "crosses itself", "outlines cross themselves", remedy, place))
    return None


def add_frames(
    block_outlines: Sequence[Outline],
    is_support: Callable[[Curve], bool],
    is_fixed: Sequence[bool],
    defects: Defects,
) -> None:
    """Add a defect for each outline that is a frame around the drawing.

    A frame is an outline that is not on a layer of supports. At least two holes or two blocks are inside it,
    and one of these conditions is satisfied:

    - An outline on a layer of supports is inside the frame.
    - Two holes of the frame share a side, so the holes are stones.
    - Most outlines of the drawing are holes of the frame, and the frame is a support by its height or no
      other block is a support.
    """
    on_layer = Counter(curve.layer for outline in block_outlines for curve in (outline.curve, *outline.holes))
    polygons = np.array([outline.polygon for outline in block_outlines], dtype=object)
    for number, outline in enumerate(block_outlines):
        if not outline.polygon.interiors or is_support(outline.curve):
            continue
        is_inside = shapely.within(polygons, shapely.Polygon(outline.polygon.exterior))
        is_inside[number] = False
        inside_curves = [block_outlines[index].curve for index in np.flatnonzero(is_inside).tolist()]
        contents = max((inside_curves, outline.holes), key=len)
        has_other_supports = any(flag for index, flag in enumerate(is_fixed) if index != number)
        is_frame = (
            any(map(is_support, (*inside_curves, *outline.holes)))
            or _share_side(outline.polygon)
            or (
                2 * len(outline.holes) > sum(on_layer.values())
                and (is_fixed[number] or not has_other_supports)
            )
        )
        if len(contents) < _FEWEST_IN_FRAME or not is_frame:
            continue
        layer = outline.curve.layer
        remedy = f"omit layer '{layer}' with 'without_layers' (--without-layer {layer})"
        if on_layer[layer] > 1:
            remedy = (
                f"{remedy} if none of its other outlines are stones; if some are, delete the frame, or move "
                "it to a separate layer"
            )
        mistake = f"is a frame around {len(contents)} outlines, which would become holes"
        plural_mistake = "frames are drawn around other outlines, which would become holes"
        defects.add(Defect(outline.curve.label, mistake, plural_mistake, remedy))


def add_smaller_copies(block_outlines: Sequence[Outline], tolerance: float, defects: Defects) -> None:
    """Add a defect for each hole that seems to be a smaller copy of its block.

    A hole seems to be a smaller copy of the block's outline in two cases:

    - The hole shares a side with the outline of the block, and has more than half of its area.
    - Only a thin ring remains of the block.
    """
    for outline in block_outlines:
        block = shapely.Polygon(outline.polygon.exterior)
        # Skip the cells of a network of joint lines, which have interior rings but no curves in ``holes``.
        for curve, ring in zip(outline.holes, outline.polygon.interiors, strict=False):
            hole = shapely.Polygon(ring)
            near_outline = block.exterior.buffer(tolerance)
            shares_side = ring.intersection(near_outline).length > _SHORTEST_SIDE * tolerance
            thickness = 2 * (block.area - hole.area) / (block.length + hole.length)
            is_copy = (shares_side and hole.area > _LARGEST_OPENING * block.area) or (
                thickness < _THINNEST_RING * least_width(block)
            )
            if is_copy:
                mistake = f"is a smaller copy of {outline.curve.label}"
                plural_mistake = "outlines are smaller copies of other outlines"
                remedy = (
                    "delete one of the two outlines, because the smaller outline would be read as a hole; if "
                    "a hole is intended, replace both outlines by one outline of the rest of the block"
                )
                defects.add(Defect(curve.label, mistake, plural_mistake, remedy, near(*curve.points[0])))


def _share_side(polygon: shapely.Polygon) -> bool:
    """Return True if two holes of a polygon overlap or share a side."""
    holes = shapely.polygons(list(polygon.interiors))
    union_area = shapely.area(shapely.union_all(holes))
    boundary_length = shapely.length(shapely.union_all(shapely.boundary(holes)))
    is_apart = np.isclose(union_area, shapely.area(holes).sum(), rtol=RELATIVE_TOLERANCE)
    return bool(
        not is_apart or not np.isclose(boundary_length, shapely.length(holes).sum(), rtol=RELATIVE_TOLERANCE)
    )

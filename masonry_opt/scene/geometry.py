"""Compute the shapes of the blocks of a scene: polygons, and their uppermost edges below a road."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
import shapely

from masonry_opt.brief import brief
from masonry_opt.errors import CaseError, rounded
from masonry_opt.scene.blocks import Block
from masonry_opt.scene.outlines import sides_of
from masonry_opt.scene.rows import bounds
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tolerance_advice import too_thin_for

#: Default tolerance of lengths, relative to the diagonal of the box around the movable blocks. Smaller
#: details are ignored.
RELATIVE_TOLERANCE = 1e-6

#: Largest gap or overlap of two blocks, relative to the width of the smaller block, that is probably an error
#: of the drawing. With a larger value, intended gaps would also cause warnings.
NEAR_MISS = 1e-2

#: A gap of up to this multiple of the contact tolerance is probably an error of the drawing, even if the gap
#: is wider than ``NEAR_MISS`` allows. With a larger value, intended gaps would also cause warnings.
_NEAR_TOLERANCES = 3

#: Largest gap, relative to the width of the smaller block, that may be undrawn mortar. With a larger value,
#: messages would also advise the user to close openings.
MORTAR = 0.35

#: Fraction by which the contact tolerance is increased for curved edges that are drawn as chords. The gap
#: between parallel arcs varies by the rise of their chords. With a smaller value, parts of curved joints are
#: lost.
_CHORD_ALLOWANCE = 0.05

#: Ratio of the recommended ``tolerance`` to the coordinate error of a drawing's corners. With a smaller
#: ratio, joints that are wedge-shaped because of this error may remain wedge-shaped. A larger ratio aligns
#: more joints than necessary.
TOLERANCE_OVER_ERROR = 3.0

#: A corner is removed if its distance from the line between the two neighbouring corners is at most this
#: value times the tolerance. A larger value removes more corners.
LARGEST_STRAIGHT_DISTANCE = 0.1


def frame_of(scene: Scene, corners: np.ndarray, block: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the origin of the shapes' coordinates, and the tolerance below which lengths are ignored.

    Both are computed from the movable blocks only, because supports may be much larger. ``block`` is the
    index of the block of each corner.
    """
    movable_corners = corners[~scene.fixed[block]]
    low, high = movable_corners.min(axis=0), movable_corners.max(axis=0)
    tolerance = scene.tolerance or RELATIVE_TOLERANCE * float(np.hypot.reduce(high - low))
    # The tolerance is at least eight times the rounding error of the largest coordinate.
    return (low + high) / 2, max(tolerance, 8 * float(np.spacing(np.abs(corners).max())))


def contact_tolerance_of(scene: Scene, tolerance: float) -> float:
    """Return the largest gap or overlap at which two facing sides count as in contact.

    The result is the tolerance of lengths, plus the contact tolerance if the scene has one, with an allowance
    for chords. The sum closes a gap that is exactly as wide as the contact tolerance in spite of rounding
    errors.
    """
    return tolerance + (1 + _CHORD_ALLOWANCE) * (scene.contact_tolerance or 0.0)


class Common(NamedTuple):
    """Region in which two blocks overlap."""

    depth: float  #: distance by which the blocks must be moved apart to remove the overlap
    middle: np.ndarray  #: centroid
    size: float  #: area in the plane, volume in space


@dataclass(frozen=True)
class Extents(ABC):
    """Shapes of the blocks of a scene, in the plane or in space.

    Coordinates are relative to the centre of the box around the movable blocks, because coordinates far from
    the origin have larger rounding errors.
    """

    #: Origin of the shapes, in scene coordinates: the centre of the box around the movable blocks, shape (2,)
    #: or (3,).
    origin: np.ndarray
    tolerance: float  #: length below which details of the scene are ignored
    contact_tolerance: float  #: largest gap or overlap at which facing sides are in contact
    size: np.ndarray  #: area or volume of each block, to which ``unit_weight`` refers, shape (blocks,)
    centroid: np.ndarray  #: centroid of each block, relative to ``origin``, shape (blocks, 2) or (blocks, 3)
    convex: np.ndarray  #: mask of convex blocks (in space: blocks of one convex part), shape (blocks,)
    mixed: np.ndarray  #: indices of blocks with inconsistently oriented faces (empty in the plane)

    #: Part of error messages about two overlapping blocks: "blocks A and B overlap over an area of ...".
    within: ClassVar[str] = "over an area"
    #: End of an error message about two blocks that touch but have no joint: "it meets 'A' only at ...".
    meeting: ClassVar[str] = "only at their corners, but a joint needs an edge of one of the blocks"
    #: Remedy in error messages about two blocks that touch but have no joint.
    bearing: ClassVar[str] = "let a corner rest on an edge"
    #: Number of overlapping pairs of blocks after which the search for overlaps ends.
    enough: ClassVar[float] = np.inf

    @property
    @abstractmethod
    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners of all blocks, block by block, and the index of each corner's block.

        The corners have shape (corners, 2) or (corners, 3).
        """

    @abstractmethod
    def outside(self, blocks: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return how far each point is outside the convex hull of its block, shape (points,).

        ``blocks`` has the index of the block for each point.
        """

    @abstractmethod
    def away(self, block: int, point: np.ndarray) -> float:
        """Return the distance of a point from a block, which is 0 if the point is inside the block."""

    @abstractmethod
    def nearest(self, block: int) -> tuple[int, float]:
        """Return the index of the block nearest to a given block, and the distance of the two blocks."""

    @abstractmethod
    def thickness(self) -> np.ndarray:
        """Return the thickness (least width) of each block, shape (blocks,).

        The least width is the smallest distance between two parallel lines (in space: planes) that enclose
        the block and are parallel to one of its sides.
        """

    @abstractmethod
    def overlaps(self, pairs: np.ndarray) -> Iterator[tuple[int, Common]]:
        """Yield the index in ``pairs`` of each pair of overlapping blocks, and the region of the overlap.

        Overlaps whose depth is within the contact tolerance are left out. The indices are in ascending order.
        """

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the smallest and the largest coordinates of each block, shape (blocks, dim) each."""
        points, block = self.corners
        return bounds(block, points, len(self.size))

    def extent_of(self, chosen: np.ndarray) -> np.ndarray:
        """Return the dimensions of the box around some blocks, shape (dim,).

        ``chosen`` is a mask or the indices of these blocks.
        """
        low, high = (corners[chosen] for corners in self.boxes)
        return np.asarray(high.max(axis=0) - low.min(axis=0))

    @property
    def width(self) -> np.ndarray:
        """Return the width of each block: the square root of its area (in space: cube root of its volume).

        The shape is (blocks,).
        """
        return self.size ** (1 / len(self.origin))

    @property
    def reach(self) -> np.ndarray:
        """Return, for each block, the largest gap that is probably a drawing error, shape (blocks,)."""
        return np.maximum(_NEAR_TOLERANCES * self.contact_tolerance, NEAR_MISS * self.width)


@dataclass(frozen=True)
class Geometry(Extents):
    """Shapes of the blocks of a plane scene: their polygons, areas and centroids."""

    #: Polygon or multipolygon of each block, counter-clockwise, without corners on straight sides.
    polygons: np.ndarray

    __repr__ = brief

    @property
    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners of all polygons, block by block, and the index of each corner's block."""
        return shapely.get_coordinates(self.polygons, return_index=True)

    def outside(self, blocks: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return how far each point is outside the convex hull of its block, shape (points,)."""
        hulls = shapely.convex_hull(self.polygons[blocks])
        return shapely.distance(hulls, shapely.points(points))

    def away(self, block: int, point: np.ndarray) -> float:
        """Return the distance of a point from a block, which is 0 if the point is inside the block."""
        return float(shapely.distance(self.polygons[block], shapely.Point(point)))

    def nearest(self, block: int) -> tuple[int, float]:
        """Return the index of the block nearest to a given block, and the distance of the two blocks."""
        distance = shapely.distance(self.polygons[block], self.polygons)
        distance[block] = np.inf
        return int(distance.argmin()), float(distance.min())

    def thickness(self) -> np.ndarray:
        """Return the thickness (least width) of each block, shape (blocks,)."""
        return np.array([least_width(polygon) for polygon in self.polygons])

    def overlaps(self, pairs: np.ndarray) -> Iterator[tuple[int, Common]]:
        """Yield the index in ``pairs`` of each pair of overlapping blocks, and the region of the overlap."""
        intersections = shapely.intersection(self.polygons[pairs[:, 0]], self.polygons[pairs[:, 1]])
        area, perimeter = shapely.area(intersections), shapely.length(intersections)
        # `mean` is the mean thickness of an overlap: its area divided by half its perimeter. The least width
        # of a convex region lies between `mean` and π times `mean`.
        mean = np.divide(2 * area, perimeter, out=np.zeros_like(area), where=area > 0)
        for number in np.flatnonzero(mean > self.contact_tolerance / np.pi):
            width = max(map(least_width, shapely.get_parts(intersections[number])))
            # Take the least width of the overlap as its depth. For a curved region, such as the region
            # between two arcs, the least width is much larger than the thickness. Therefore limit the depth
            # to π times the mean thickness.
            depth = min(width, np.pi * float(mean[number]))
            if depth > self.contact_tolerance:
                middle = shapely.get_coordinates(shapely.centroid(intersections[number]))[0]
                yield int(number), Common(depth, middle, float(area[number]))

    @cached_property
    def edges(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return both ends of each edge, shape (edges, 2) each, and the index of each edge's block.

        The edges are in the order of the blocks. The block is to the left of its edges.
        """
        parts, block = shapely.get_parts(self.polygons, return_index=True)
        tail, tip, part = sides_of(parts)
        return tail, tip, block[part]


def geometry(scene: Scene) -> Geometry:
    """Return the polygons, areas and centroids of the blocks of a scene.

    Clockwise polygons are reversed, parts are united and holes are cut out. Then a corner is removed if it
    lies within a tenth of the tolerance of the outline without this corner.

    Raises
    ------
    CaseError
        If a polygon has no area or crosses itself, or a hole is not inside. The message names the block.
    """
    blocks = scene.in_plane()
    corners_of = [block.corners() for block in blocks]
    corners, owner = np.concatenate(corners_of), np.repeat(np.arange(len(blocks)), list(map(len, corners_of)))
    origin, tolerance = frame_of(scene, corners, owner)
    outlines = shapely.polygons(shapely.linearrings(corners - origin, indices=owner))
    # A block with several parts or holes has several rings: replace its outline by a polygon of all rings.
    for index, block in enumerate(blocks):
        if len(block.rings) > 1 or block.holes:
            outlines[index] = _build_polygon(scene, block, index, origin, tolerance)
    hulls = shapely.convex_hull(outlines)
    thickness = mean_thickness(shapely.area(hulls), shapely.length(hulls))
    default = RELATIVE_TOLERANCE * float(np.hypot.reduce(np.ptp(corners, axis=0)))
    refuse_too_thin(
        scene, np.arange(len(blocks)), thickness, (LARGEST_STRAIGHT_DISTANCE * 2 * tolerance, default)
    )
    is_flat = shapely.area(hulls) <= LARGEST_STRAIGHT_DISTANCE * tolerance * shapely.length(hulls)
    # Exclude outlines that are completely covered by holes: they raise another error below.
    is_flat &= ~shapely.is_empty(outlines)
    # Compare the area with the square of the block's own perimeter. The default tolerance is relative to the
    # size of the scene, so a small block may be smaller than this tolerance although it has an area.
    has_area = shapely.area(hulls) > RELATIVE_TOLERANCE * shapely.length(hulls) ** 2
    raise_for(
        np.flatnonzero(is_flat & ~has_area), scene, "{} has no area: its corners are on one line or coincide"
    )
    raise_for(
        np.flatnonzero(is_flat | ((shapely.area(hulls) <= tolerance**2) & has_area)),
        scene,
        f"{{}} is too small for the tolerance {rounded(tolerance)}: use one unit for all coordinates, remove "
        "blocks that are far away from the others, or set 'tolerance'",
    )
    # The simplification never removes the first corner of an outline. Therefore begin at the lowest leftmost
    # corner, which is never on a straight side.
    polygons = shapely.simplify(shapely.normalize(outlines), LARGEST_STRAIGHT_DISTANCE * tolerance)
    crossed_blocks = np.flatnonzero(~shapely.is_valid(polygons))
    raise_for(
        crossed_blocks, scene, "the outline of {} crosses itself: list the corners in order along the outline"
    )
    area = shapely.area(outlines)
    raise_for(np.flatnonzero(area <= tolerance**2), scene, "{} has no area")
    hulls = shapely.convex_hull(polygons)
    convex = shapely.get_num_coordinates(hulls) == shapely.get_num_coordinates(polygons)
    polygons = shapely.orient_polygons(polygons)
    centroid = shapely.get_coordinates(shapely.centroid(outlines))
    contact_tolerance = contact_tolerance_of(scene, tolerance)
    return Geometry(
        origin, tolerance, contact_tolerance, area, centroid, convex, np.zeros(0, dtype=int), polygons
    )


def _build_polygon(
    scene: Scene, block: Block, index: int, origin: np.ndarray, tolerance: float
) -> shapely.Geometry:
    """Return the polygon or multipolygon of a block that has several parts or holes."""

    def ring(points: list[tuple[float, float]], kind: str) -> shapely.Polygon:
        polygon = shapely.Polygon(np.array(points) - origin)
        if polygon.area <= tolerance**2:
            raise_for([index], scene, f"{{}} has {kind} without area")
        if not polygon.is_valid:
            raise_for([index], scene, f"{{}} has {kind} that crosses itself: list its corners in order")
        return polygon

    block_polygon = shapely.union_all([ring(points, "a part") for points in block.rings])
    for points in block.holes:
        hole = ring(points, "a hole")
        if not block_polygon.buffer(tolerance).covers(hole):
            raise_for(
                [index],
                scene,
                "{} has a hole that is not inside the block: move the hole, or draw a notch in the outline",
            )
        block_polygon = block_polygon.difference(hole)
    return block_polygon


def least_width(piece: shapely.Geometry) -> float:
    """Return the smallest distance between two parallel lines that enclose a polygon."""
    corners = shapely.get_coordinates(shapely.convex_hull(piece))
    sides = np.diff(corners, axis=0)
    if len(sides) < 3:
        return 0.0
    normals = np.column_stack([-sides[:, 1], sides[:, 0]]) / np.hypot(*sides.T)[:, None]
    return float(np.ptp(corners @ normals.T, axis=0).min())


def raise_for(blocks: Sequence[int] | np.ndarray, scene: Scene, reason: str) -> None:
    """Raise CaseError about the given blocks, if there are any.

    In the message ``reason``, ``{}`` is replaced by the names of the blocks, of which at most four are
    listed.
    """
    if len(blocks) == 0:
        return
    names = [repr(scene.blocks[index].name) for index in blocks]
    addition = f" (likewise {len(names) - 1} more: {', '.join(names[1:4])})" if len(names) > 1 else ""
    raise CaseError(f"{scene.origin}: {reason.replace('{}', f'block {names[0]}{addition}', 1)}")


def mean_thickness(size: np.ndarray, boundary: np.ndarray) -> np.ndarray:
    """Return the mean thickness of each shape: twice its area divided by its perimeter.

    In space it is twice the volume divided by the surface area. A shape without a boundary has thickness 0.
    """
    return np.divide(2 * size, boundary, out=np.zeros_like(size), where=boundary > 0)


def refuse_too_thin(
    scene: Scene, block: np.ndarray, thickness: np.ndarray, limits: tuple[float, float]
) -> None:
    """Raise CaseError if blocks, or parts of blocks, are too thin for the ``tolerance`` of the scene.

    Blocks that are too thin even for the default tolerance are not reported here.

    Parameters
    ----------
    scene : Scene
        The scene.
    block : ndarray, shape (parts,)
        Index of the block of each part.
    thickness : ndarray, shape (parts,)
        Mean thickness of each part.
    limits : tuple of float
        Thickness up to which the tolerance of the scene ignores a part, and thickness up to which the default
        tolerance ignores it.
    """
    scene_limit, default_limit = limits
    thin_parts = np.flatnonzero((thickness <= scene_limit) & (thickness > default_limit))
    if scene.tolerance is None or not len(thin_parts):
        return
    thin_parts = thin_parts[np.argsort(thickness[thin_parts], kind="stable")]
    blocks = list(dict.fromkeys(block[thin_parts].tolist()))
    raise_for(blocks, scene, f"{{}} is {too_thin_for(scene.tolerance, float(thickness[thin_parts[0]]))}")


@dataclass(frozen=True)
class Profile:
    """Pieces of the uppermost block edges below a line (a polyline, such as a road), from left to right.

    Along each piece, the edge and the line are straight. Coordinates of the left and right ends are relative
    to the origin of the geometry.
    """

    x: np.ndarray  #: abscissae of both ends of each piece, shape (pieces, 2)
    #: Heights of the edge at both ends of each piece, shape (pieces, 2); NaN if there is no edge.
    y: np.ndarray
    line: np.ndarray  #: heights of the line (such as a road) at both ends of each piece, shape (pieces, 2)
    #: Index of the edge to which each piece belongs, shape (pieces,); -1 if there is no edge.
    edge: np.ndarray
    #: Index of the block to which the edge of each piece belongs, shape (pieces,); -1 if there is no edge.
    block: np.ndarray

    @property
    def depth(self) -> np.ndarray:
        """Return the depth of the block edge below ``line`` at both ends of each piece, shape (pieces, 2).

        The depth is 0 where the edge is above the line, and NaN where there is no edge.
        """
        return np.maximum(self.line - self.y, 0.0)


def profile_below(scene: Scene, shapes: Geometry, points: np.ndarray, line_name: str) -> Profile:
    """Return the uppermost block edges below a line.

    Parameters
    ----------
    scene : Scene
        The scene, in the plane.
    shapes : Geometry
        Shapes of the blocks of the scene.
    points : ndarray, shape (points, 2)
        Points of the line from left to right, relative to the geometry's origin.
    line_name : str
        Name of the line in errors.

    Raises
    ------
    CaseError
        If the line runs through a block.
    """
    line = shapely.linestrings(points)
    touched_blocks = np.flatnonzero(shapely.intersects(line, shapes.polygons))
    shrunken_polygons = shapely.buffer(shapes.polygons[touched_blocks], -2 * shapes.tolerance)
    for index in touched_blocks[shapely.intersects(line, shrunken_polygons)]:
        name = scene.blocks[index].name
        raise CaseError(
            f"{scene.origin}: {line_name} runs through block '{name}': move the line onto or above the blocks"
        )
    tail, tip, owner = shapes.edges
    # Select the upper edges, which run leftwards because a block lies to the left of its edges.
    upper_edges = np.flatnonzero(tip[:, 0] < tail[:, 0])
    tail, tip, owner = tail[upper_edges], tip[upper_edges], owner[upper_edges]
    if shapes.contact_tolerance > shapes.tolerance:
        tail, tip = with_closed_gaps(tail, tip, owner, shapes.contact_tolerance)
    abscissae = np.unique(np.concatenate([points[:, 0], tail[:, 0], tip[:, 0]]))
    abscissae = abscissae[(abscissae >= points[0, 0]) & (abscissae <= points[-1, 0])]
    # Merge pieces that are shorter than the tolerance with their neighbours.
    abscissae = abscissae[np.r_[True, np.diff(abscissae) > shapes.tolerance]]
    middle = (abscissae[1:] + abscissae[:-1]) / 2
    edge = _uppermost_edges(tail, tip, middle, np.interp(middle, *points.T) + 2 * shapes.tolerance)
    # Parts of the line (such as a road) are on one edge, and have one slope. A new part therefore begins at
    # each corner of the line, and where another edge begins.
    slope = np.searchsorted(points[1:-1, 0], middle)
    begins = np.r_[True, (edge[1:] != edge[:-1]) | (slope[1:] != slope[:-1])]
    edge, starts = edge[begins], abscissae[:-1][begins]
    x = np.column_stack([starts, np.r_[starts[1:], abscissae[-1]]])
    tail, tip = tail[edge], tip[edge]
    y = tail[:, 1:] + (x - tail[:, :1]) * ((tip - tail)[:, 1:] / (tip - tail)[:, :1])
    has_edge = edge >= 0
    edge_number = np.where(has_edge, upper_edges[edge], -1)
    block = np.where(has_edge, owner[edge], -1)
    return Profile(x, np.where(has_edge[:, None], y, np.nan), np.interp(x, *points.T), edge_number, block)


def with_closed_gaps(
    tail: np.ndarray, tip: np.ndarray, owner: np.ndarray, widest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return both ends of block edges after closing gaps: the two ends at a gap are moved to its middle.

    A gap lies between the start (``tail``) of an edge and the end (``tip``) of an edge of another block, if
    their distance is at most ``widest``. ``owner`` is the block of each edge.
    """
    start, end = shapely.STRtree(shapely.points(tip)).query(shapely.points(tail), "dwithin", widest)
    is_gap = owner[start] != owner[end]
    start, end = start[is_gap], end[is_gap]
    order = np.argsort(np.hypot(*(tail[start] - tip[end]).T), kind="stable")
    start, end = start[order], end[order]
    first = np.intersect1d(np.unique(start, return_index=True)[1], np.unique(end, return_index=True)[1])
    start, end = start[first], end[first]
    closed_tail, closed_tip = tail.copy(), tip.copy()
    closed_tail[start] = closed_tip[end] = (tail[start] + tip[end]) / 2
    return closed_tail, closed_tip


def _uppermost_edges(tail: np.ndarray, tip: np.ndarray, x: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the index of the highest edge below the height ``high`` at each abscissa ``x``.

    The index is -1 if there is no edge below this height.
    """
    low = np.full_like(high, min(tail[:, 1].min(), tip[:, 1].min()) - 1.0)
    plumb_lines = shapely.linestrings(
        np.stack([np.column_stack([x, x]), np.column_stack([low, high])], axis=2)
    )
    edges = shapely.linestrings(np.stack([tail, tip], axis=1))
    number, edge = shapely.STRtree(edges).query(plumb_lines, predicate="intersects")
    share = (x[number] - tail[edge, 0]) / (tip[edge, 0] - tail[edge, 0])
    order = np.argsort(tail[edge, 1] + share * (tip[edge, 1] - tail[edge, 1]), kind="stable")
    highest_edge = np.full(len(x), -1)
    # Assign the edges in ascending order of height, so that the highest edge is assigned last.
    highest_edge[number[order]] = edge[order]
    return highest_edge

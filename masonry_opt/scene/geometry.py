"""Where the blocks of a scene are; the polygons of the plane, and their uppermost edges below a road."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
import shapely

from masonry_opt.errors import CaseError, rounded_up
from masonry_opt.scene.blocks import Block
from masonry_opt.scene.outlines import sides_of
from masonry_opt.scene.rows import bounds
from masonry_opt.scene.scene import Scene

RELATIVE_TOLERANCE = 1e-6  #: Lengths below it, over the diagonal round the movable blocks, are nothing.
#: Neighbours nearer than this, over the smaller block's width, are meant to touch; overlaps no deeper are
#: rounding.
NEAR_MISS = 1e-2
_NEAR_TOLERANCES = 3  #: So are those within so many tolerances: coordinates are off by a little more.
#: Tolerance over the error of a corner from which on the alignment makes joints parallel. Two sides that meet
#: may each be off by the error. A smaller value leaves some wedges; a larger one aligns more than is needed.
TOLERANCE_OVER_ERROR = 3.0
STRAIGHT = 0.1  #: Share of the tolerance within which corners lie on the outline without them.


def set_tolerance(tolerance: float) -> str:
    """Return the advice of messages to set a tolerance, in two digits rounded up."""
    return f"set 'tolerance' to {rounded_up(tolerance, 2)}"


def frame_of(scene: Scene, corners: np.ndarray, block: np.ndarray) -> tuple[np.ndarray, float]:
    """Origin and tolerance of a scene's shapes, of its movable blocks: supports may reach far beyond them."""
    movable = corners[~scene.fixed[block]]
    low, high = movable.min(axis=0), movable.max(axis=0)
    tolerance = scene.tolerance or RELATIVE_TOLERANCE * float(np.hypot.reduce(high - low))
    # Digits already lost in the coordinates themselves bound what can be told apart.
    return (low + high) / 2, max(tolerance, 8 * float(np.spacing(np.abs(corners).max())))


class Common(NamedTuple):
    """A piece that two blocks have in common: how far they must be moved apart, its centroid and size."""

    depth: float
    middle: np.ndarray
    size: float


@dataclass(frozen=True)
class Extents(ABC):
    """Shapes of a scene, the middle of its movable blocks at the origin: far coordinates lose digits."""

    origin: np.ndarray  #: that middle in the scene's own coordinates, shape (2,) or (3,)
    tolerance: float  #: length below which the scene has no detail
    contact_tolerance: float  #: gap or overlap of sides that face each other up to which they touch
    size: np.ndarray  #: area of each block, or volume: what a ``unit_weight`` refers to, shape (blocks,)
    centroid: np.ndarray  #: of each block, relative to ``origin``, shape (blocks, 2) or (blocks, 3)
    convex: np.ndarray  #: whether each is convex, in space one convex part, shape (blocks,)
    mixed: np.ndarray  #: blocks whose faces were not all given turned one way; none in the plane

    # In errors:
    within: ClassVar[str] = "over an area"  #: where blocks overlap
    remedy: ClassVar[str] = ""  #: what they may do about that beside moving, given the depth
    meeting: ClassVar[str] = "corner on corner alone, where a joint needs an edge"  #: where there is no joint
    inside: ClassVar[float] = np.inf  #: share of the smaller block with which an overlap is all of it
    mortar: ClassVar[float] = 0.0  #: gap that may be mortar that was left out, over the width of a block
    enough: ClassVar[float] = np.inf  #: pairs that overlap, after which no more are looked for

    @property
    @abstractmethod
    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners of all blocks, shape (corners, 2) or (corners, 3), and the block of each, rising."""

    @abstractmethod
    def outside(self, blocks: np.ndarray, points: np.ndarray) -> np.ndarray:
        """How far points lie outside of the convex hulls of blocks, one each, shape (points,)."""

    @abstractmethod
    def away(self, block: int, point: np.ndarray) -> float:
        """How far a point lies outside of a block."""

    @abstractmethod
    def nearest(self, block: int) -> tuple[int, float]:
        """The block nearest to a block, and its distance."""

    @abstractmethod
    def overlaps(self, pairs: np.ndarray) -> Iterator[tuple[int, Common]]:
        """Numbers of pairs, rising, and what of their blocks overlaps by more than the contact tolerance."""

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest coordinates of each block, shape (blocks, 2) or (blocks, 3) each."""
        points, block = self.corners
        return bounds(block, points, len(self.size))

    @property
    def width(self) -> np.ndarray:
        """Side of a square, or cube, of the size of each block, shape (blocks,)."""
        return self.size ** (1 / len(self.origin))

    @property
    def reach(self) -> np.ndarray:
        """Gap up to which each block's neighbours were surely meant to touch it, shape (blocks,)."""
        return np.maximum(_NEAR_TOLERANCES * self.contact_tolerance, NEAR_MISS * self.width)


@dataclass(frozen=True)
class Geometry(Extents):
    """Shapes of a scene in the plane."""

    polygons: np.ndarray  #: one a block, or a multipolygon: counter-clockwise, without straight corners

    @property
    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        return shapely.get_coordinates(self.polygons, return_index=True)

    def outside(self, blocks: np.ndarray, points: np.ndarray) -> np.ndarray:
        hulls = shapely.convex_hull(self.polygons[blocks])
        return shapely.distance(hulls, shapely.points(points))

    def away(self, block: int, point: np.ndarray) -> float:
        return float(shapely.distance(self.polygons[block], shapely.Point(point)))

    def nearest(self, block: int) -> tuple[int, float]:
        distance = shapely.distance(self.polygons[block], self.polygons)
        distance[block] = np.inf
        return int(distance.argmin()), float(distance.min())

    def overlaps(self, pairs: np.ndarray) -> Iterator[tuple[int, Common]]:
        common = shapely.intersection(self.polygons[pairs[:, 0]], self.polygons[pairs[:, 1]])
        area, perimeter = shapely.area(common), shapely.length(common)
        # A convex piece is at least as deep as its area over half its perimeter, and at most π times that.
        mean = np.divide(2 * area, perimeter, out=np.zeros_like(area), where=area > 0)
        for number in np.flatnonzero(mean > self.contact_tolerance / np.pi):
            depth = max(map(_least_width, shapely.get_parts(common[number])))
            if depth > self.contact_tolerance:
                middle = shapely.get_coordinates(shapely.centroid(common[number]))[0]
                yield int(number), Common(depth, middle, float(area[number]))

    @cached_property
    def edges(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ends of edges, their block to the left, shape (edges, 2) each, and these blocks, rising."""
        parts, block = shapely.get_parts(self.polygons, return_index=True)
        tail, tip, part = sides_of(parts)
        return tail, tip, block[part]


def geometry(scene: Scene) -> Geometry:
    """Polygons, areas and centroids of the blocks. Clockwise polygons are turned round, parts united, holes
    cut out; then corners within a tenth of the tolerance of the outline without them are dropped. Raises
    CaseError naming the block if a polygon has no area or crosses itself, or a hole is not inside."""
    blocks = scene.in_plane()
    corners_of = [block.corners() for block in blocks]
    corners, owner = np.concatenate(corners_of), np.repeat(np.arange(len(blocks)), list(map(len, corners_of)))
    origin, tolerance = frame_of(scene, corners, owner)
    outlines = shapely.polygons(shapely.linearrings(corners - origin, indices=owner))
    # Those of several rings are built up.
    for index, block in enumerate(blocks):
        if len(block.rings) > 1 or block.holes:
            outlines[index] = _built_up(scene, block, index, origin, tolerance)
    hulls = shapely.convex_hull(outlines)
    flat = shapely.area(hulls) <= STRAIGHT * tolerance * shapely.length(hulls)
    flat &= ~shapely.is_empty(outlines)  # all holes
    raise_for(np.flatnonzero(flat), scene, "has no area: its corners lie on one line or in one point")
    # Normalised outlines begin at a leftmost, lowest corner, which no straight edge runs through.
    polygons = shapely.simplify(shapely.normalize(outlines), STRAIGHT * tolerance)
    crossed = np.flatnonzero(~shapely.is_valid(polygons))
    raise_for(crossed, scene, "crosses itself: give its corners in order round the block")
    area = shapely.area(outlines)
    raise_for(np.flatnonzero(area <= tolerance**2), scene, "has no area")
    hulls = shapely.convex_hull(polygons)
    convex = shapely.get_num_coordinates(hulls) == shapely.get_num_coordinates(polygons)
    polygons = shapely.orient_polygons(polygons)
    centroid = shapely.get_coordinates(shapely.centroid(outlines))
    return Geometry(origin, tolerance, tolerance, area, centroid, convex, np.zeros(0, dtype=int), polygons)


def _built_up(
    scene: Scene, block: Block, index: int, origin: np.ndarray, tolerance: float
) -> shapely.Geometry:
    """A block of several parts, or with holes, as one polygon or multipolygon."""

    def ring(points: list[tuple[float, float]], what: str) -> shapely.Polygon:
        polygon = shapely.Polygon(np.array(points) - origin)
        if polygon.area <= tolerance**2:
            raise_for([index], scene, f"has {what} without area")
        if not polygon.is_valid:
            raise_for([index], scene, f"has {what} that crosses itself: give its corners in order")
        return polygon

    whole = shapely.union_all([ring(points, "a part") for points in block.rings])
    for points in block.holes:
        hole = ring(points, "a hole")
        if not whole.buffer(tolerance).covers(hole):
            raise_for([index], scene, "has a hole that is not inside: move it, or give the outline as it is")
        whole = whole.difference(hole)
    return whole


def _least_width(piece: shapely.Geometry) -> float:
    """The least distance of parallel lines that enclose a piece."""
    corners = shapely.get_coordinates(shapely.convex_hull(piece))
    sides = np.diff(corners, axis=0)
    if len(sides) < 3:
        return 0.0
    across = np.column_stack([-sides[:, 1], sides[:, 0]]) / np.hypot(*sides.T)[:, None]
    return float(np.ptp(corners @ across.T, axis=0).min())


def raise_for(blocks: Sequence[int] | np.ndarray, scene: Scene, why: str) -> None:
    """Raise CaseError naming the blocks, at most three of them, if there are any."""
    if len(blocks) == 0:
        return
    names = [repr(scene.blocks[index].name) for index in blocks]
    more = f" (and {len(names) - 1} more like it: {', '.join(names[1:4])})" if len(names) > 1 else ""
    raise CaseError(f"{scene.origin}: block {names[0]} {why}{more}")


@dataclass(frozen=True)
class Profile:
    """Pieces of the uppermost edges below a line, from left to right; both are straight along a piece. Of the
    pieces' left and right ends, relative to the geometry's origin, shape (pieces, 2)."""

    x: np.ndarray  #: of the edges
    y: np.ndarray  #: of the edges; NaN where there is none
    line: np.ndarray  #: height of the line
    edge: np.ndarray  #: index of the edge, shape (pieces,); -1 where there is none
    block: np.ndarray  #: index of its block in the scene, shape (pieces,); -1 where there is none

    @property
    def depth(self) -> np.ndarray:
        """Of the edges below the line, at least 0."""
        return np.maximum(self.line - self.y, 0.0)


def profile_below(scene: Scene, shapes: Geometry, points: np.ndarray, where: str) -> Profile:
    """The uppermost edges of all blocks below a line through points from left to right, shape (points, 2),
    relative to the geometry's origin. Raises CaseError, which calls it ``where``, if it meets a block."""
    line = shapely.linestrings(points)
    met = np.flatnonzero(shapely.intersects(line, shapes.polygons))
    inner = shapely.buffer(shapes.polygons[met], -2 * shapes.tolerance)
    for index in met[shapely.intersects(line, inner)]:
        name = scene.blocks[index].name
        raise CaseError(f"{scene.origin}: {where} runs through block '{name}': lay it on or above blocks")
    tail, tip, owner = shapes.edges
    upper = np.flatnonzero(tip[:, 0] < tail[:, 0])  # of an edge with the block to its left
    tail, tip, owner = tail[upper], tip[upper], owner[upper]
    at = np.unique(np.concatenate([points[:, 0], tail[:, 0], tip[:, 0]]))
    at = at[(at >= points[0, 0]) & (at <= points[-1, 0])]
    # Pieces shorter than what is nothing belong to their neighbours.
    at = at[np.r_[True, np.diff(at) > shapes.tolerance]]
    middle = (at[1:] + at[:-1]) / 2
    edge = _uppermost(tail, tip, middle, np.interp(middle, *points.T) + 2 * shapes.tolerance)
    # A piece begins where the edge or the slope of the line changes.
    slope = np.searchsorted(points[1:-1, 0], middle)
    begins = np.r_[True, (edge[1:] != edge[:-1]) | (slope[1:] != slope[:-1])]
    edge, starts = edge[begins], at[:-1][begins]
    x = np.column_stack([starts, np.r_[starts[1:], at[-1]]])
    tail, tip = tail[edge], tip[edge]
    y = tail[:, 1:] + (x - tail[:, :1]) * ((tip - tail)[:, 1:] / (tip - tail)[:, :1])
    found = edge >= 0
    numbers = (np.where(found, of[edge], -1) for of in (upper, owner))
    return Profile(x, np.where(found[:, None], y, np.nan), np.interp(x, *points.T), *numbers)


def _uppermost(tail: np.ndarray, tip: np.ndarray, x: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The highest edge at each abscissa up to such a height, shape (x,); -1 without one."""
    low = np.full_like(high, min(tail[:, 1].min(), tip[:, 1].min()) - 1.0)
    plumb = shapely.linestrings(np.stack([np.column_stack([x, x]), np.column_stack([low, high])], axis=2))
    edges = shapely.linestrings(np.stack([tail, tip], axis=1))
    number, edge = shapely.STRtree(edges).query(plumb, predicate="intersects")
    share = (x[number] - tail[edge, 0]) / (tip[edge, 0] - tail[edge, 0])
    rising = np.argsort(tail[edge, 1] + share * (tip[edge, 1] - tail[edge, 1]), kind="stable")
    found = np.full(len(x), -1)
    found[number[rising]] = edge[rising]  # the highest is written last
    return found

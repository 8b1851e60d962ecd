"""Areas and centroids of a scene's blocks, and the checks that a polygon must pass."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from masonry_opt.errors import CaseError
from masonry_opt.scene.blocks import Block
from masonry_opt.scene.extents import Common, Extents, frame_of
from masonry_opt.scene.scene import Scene

#: Share of the tolerance within which corners lie on the outline without them: outlines off by so little are
#: near each other where the blocks are.
STRAIGHT = 0.1


@dataclass(frozen=True)
class Geometry(Extents):
    """Shapes of a scene in the plane.

    Attributes
    ----------
    polygons: shapely polygons, or multipolygons, counter-clockwise, straight corners removed, one a block;
        for finding joints and drawing.
    """

    polygons: np.ndarray

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
        """Edges of all outlines and holes, each with its block's interior to the left: their ends, shape
        (edges, 2) each, and their blocks, shape (edges,), rising."""
        parts, block = shapely.get_parts(self.polygons, return_index=True)
        tail, tip, part = sides_of(parts)
        return tail, tip, block[part]


def sides_of(polygons: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sides of all outlines and holes of polygons: their ends, shape (sides, 2) each, and the polygon of
    each, rising."""
    rings, polygon = shapely.get_rings(polygons, return_index=True)
    corners, ring = shapely.get_coordinates(rings, return_index=True)
    inside = ring[:-1] == ring[1:]
    return corners[:-1][inside], corners[1:][inside], polygon[ring[:-1][inside]]


def geometry(scene: Scene) -> Geometry:
    """Polygons, areas and centroids of the blocks.

    Clockwise polygons are turned round, parts of a block are united, holes cut out. Corners that lie within
    a tenth of the tolerance of the outline without them are dropped for finding joints; area and centroid are
    those of the polygons as given.

    Raises CaseError if a polygon has no area or crosses itself, or a hole is not inside; the message names
    the block.
    """
    blocks = scene.in_plane()
    corners_of = [block.corners() for block in blocks]
    count = [len(own) for own in corners_of]
    origin, tolerance = frame_of(scene, np.concatenate(corners_of), np.repeat(np.arange(len(blocks)), count))
    built_up = np.array([len(block.rings) > 1 or bool(block.holes) for block in blocks])
    outlines, polygons = (np.empty(len(blocks), dtype=object) for _ in range(2))
    convex = np.zeros(len(blocks), dtype=bool)
    simple = np.flatnonzero(~built_up)
    if len(simple):
        owner = np.repeat(np.arange(len(simple)), np.array(count)[simple])
        rings = shapely.linearrings(
            np.concatenate([corners_of[index] for index in simple]) - origin, indices=owner
        )
        outlines[simple] = shapely.polygons(rings)
        polygons[simple], convex[simple] = _plain(rings, tolerance, scene, simple)
    for index in np.flatnonzero(built_up):
        outlines[index] = _built_up(scene, blocks[index], int(index), origin, tolerance)
        plain = shapely.simplify(shapely.normalize(outlines[index]), STRAIGHT * tolerance)
        polygons[index] = shapely.orient_polygons(plain)
    area = shapely.area(outlines)
    raise_for(np.flatnonzero(area <= tolerance**2), scene, "has no area")
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


def _plain(
    rings: np.ndarray, tolerance: float, scene: Scene, blocks: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Counter-clockwise polygons of the blocks' rings, without the corners that make no difference, and which
    of them are convex."""
    # Normalised rings begin at a leftmost, lowest corner, which no straight edge runs through.
    corners, ring = shapely.get_coordinates(shapely.normalize(rings), return_index=True)
    lines = shapely.linestrings(corners, indices=ring)
    lines = shapely.simplify(lines, STRAIGHT * tolerance, preserve_topology=False)
    flat = shapely.get_num_coordinates(lines) < 4
    raise_for(blocks[flat], scene, "has no area: its corners lie on one line or in one point")
    corners, ring = shapely.get_coordinates(lines, return_index=True)
    polygons = shapely.polygons(shapely.linearrings(corners, indices=ring))
    crossed = ~shapely.is_valid(polygons)
    raise_for(blocks[crossed], scene, "crosses itself: give its corners in order round the block")
    hulls = shapely.convex_hull(polygons)
    convex = shapely.get_num_coordinates(hulls) == shapely.get_num_coordinates(polygons)
    return shapely.orient_polygons(polygons), convex


def _least_width(piece: shapely.Geometry) -> float:
    """The least distance of parallel lines that enclose a piece: how far apart its blocks must be moved."""
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

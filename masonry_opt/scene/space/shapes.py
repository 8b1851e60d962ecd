"""Compute the shapes of the blocks of a scene in space, with their convex parts, and check the solids."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.errors import rounded
from masonry_opt.scene.geometry import (
    RELATIVE_TOLERANCE,
    Common,
    Extents,
    contact_tolerance_of,
    frame_of,
    mean_thickness,
    raise_for,
    refuse_too_thin,
)
from masonry_opt.scene.rows import bounds, chunks, combine, dots, following, lengths, sums
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.faces import FacePlanes, OuterFaces, Surfaces, outer_faces, place, planes


@dataclass(frozen=True)
class ConvexParts:
    """Convex parts of all blocks, as sets of corners and as intersections of half-spaces.

    The half-spaces are normal · x ≤ offset.
    """

    block: np.ndarray  #: index of the block to which each part belongs, in ascending order, shape (parts,)
    points: np.ndarray  #: coordinates of the corners of all parts, shape (points, 3)
    #: Index of the part to which each corner belongs, in ascending order, shape (points,).
    of_point: np.ndarray
    normal: np.ndarray  #: unit normal of each half-space, pointing out of its part, shape (planes, 3)
    #: Distance of each half-space's plane from the origin along the normal, shape (planes,).
    offset: np.ndarray
    #: Index of the part that each half-space bounds, in ascending order, shape (planes,).
    of_plane: np.ndarray

    @classmethod
    def of(cls, surfaces: Surfaces, planes: FacePlanes) -> "ConvexParts":
        """Return the parts that are bounded by the given surfaces. The parts are assumed to be convex."""
        vertex, corner = np.unique(surfaces.vertex, return_index=True)
        # Vertices and faces are numbered part by part, so ``of_point`` is in ascending order.
        points, of_point = surfaces.points[vertex], surfaces.part[surfaces.face[corner]]
        has_area = planes.of_face >= 0
        key = np.column_stack([surfaces.part, planes.of_face, planes.outwards])[has_area]
        of_plane, plane, outwards = np.unique(key, axis=0).T
        normal = np.where(outwards, 1.0, -1.0)[:, None] * planes.frame.normal[plane]
        offset = dots(normal, planes.frame.base[plane])
        return cls(surfaces.block, points, of_point, normal, offset, of_plane)

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the bounding box of each part: smallest and largest coordinates, shape (parts, 3) each."""
        return bounds(self.of_point, self.points, len(self.block))

    def beyond(self, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return two distances of one part's corners from another part's planes: ``nearest``, ``farthest``.

        The two results have shape (pairs,). A distance is positive on the outer side of the plane.

        Parameters
        ----------
        first, second : ndarray, shape (pairs,)
            Pairs of parts. Distances of the corners of ``second`` are measured from the planes of ``first``.

        Returns
        -------
        nearest : ndarray
            Least distance of a corner from a plane, for the plane at which this distance is largest. If it is
            positive, the plane separates the two parts.
        farthest : ndarray
            Largest distance of a corner from a plane, for the plane at which this distance is largest.
        """
        parts = np.arange(len(self.block) + 1)
        first_plane, first_point = (np.searchsorted(part, parts) for part in (self.of_plane, self.of_point))
        nearest, farthest = np.empty(len(first)), np.empty(len(first))
        for pair, (plane_part, corner_part) in enumerate(zip(first, second, strict=True)):
            planes = slice(*first_plane[plane_part : plane_part + 2])
            points = self.points[slice(*first_point[corner_part : corner_part + 2])]
            low, high = np.full((2, planes.stop - planes.start), [[np.inf], [-np.inf]])
            for chunk in chunks(np.full(len(points), len(low))):
                height = self.normal[planes] @ points[chunk].T - self.offset[planes, None]
                low, high = np.minimum(low, height.min(axis=1)), np.maximum(high, height.max(axis=1))
            nearest[pair], farthest[pair] = low.max(), high.max()
        return nearest, farthest


def overlapping(
    parts: ConvexParts, first: np.ndarray, second: np.ndarray, tolerance: float
) -> Iterator[tuple[int, Common]]:
    """Yield the pairs of parts that overlap by more than the tolerance, with their overlaps.

    A pair is given by its index in ``first`` and ``second``. The indices are in ascending order.
    """
    low, high = parts.boxes
    common_extent = np.minimum(high[first], high[second]) - np.maximum(low[first], low[second])
    pairs = np.flatnonzero((common_extent > tolerance).all(axis=1))
    for plane_parts, corner_parts in ((first, second), (second, first)):
        # Leave out pairs of parts that do not overlap because a plane of one part separates them.
        pairs = pairs[parts.beyond(plane_parts[pairs], corner_parts[pairs])[0] < -tolerance]
    for pair in pairs:
        region = _common_region(parts, int(first[pair]), int(second[pair]))
        if region.depth > tolerance:
            yield int(pair), region


def _common_region(parts: ConvexParts, first: int, second: int) -> Common:
    """Return the common region of two convex parts.

    The depth of the region is zero if the parts do not overlap.

    The depth is the diameter of the largest ball inside the region, which is computed by a linear program.
    """
    # Imported here, because importing scipy.optimize and scipy.spatial takes half a second, and few scenes
    # need them.
    from scipy.optimize import linprog
    from scipy.spatial import ConvexHull, HalfspaceIntersection

    pair = [first, second]
    low, high = np.maximum(*parts.boxes[0][pair]), np.minimum(*parts.boxes[1][pair])
    middle, scale = (low + high) / 2, float(np.abs(high - low).max())
    is_of_pair = np.isin(parts.of_plane, pair)
    normal = parts.normal[is_of_pair]
    offset = (parts.offset[is_of_pair] - normal @ middle) / scale
    # The linear program maximises the radius of a ball inside both parts. The variables are the centre and
    # the radius.
    rows = np.column_stack([normal, np.ones(len(normal))])
    limits = [(None, None)] * 3 + [(0, None)]
    options = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    ball = linprog([0, 0, 0, -1], rows, offset, bounds=limits, options=options)
    if ball.x is None or ball.x[3] <= 1e-9:
        return Common(0.0, middle, 0.0)
    corners = HalfspaceIntersection(np.column_stack([normal, -offset]), ball.x[:3]).intersections
    a, b, c = np.moveaxis(corners[ConvexHull(corners).simplices] - ball.x[:3], 1, 0)
    pieces = np.abs(dots(a, np.cross(b, c))) / 6
    centroid = ball.x[:3] + pieces @ (a + b + c) / 4 / pieces.sum()
    return Common(2 * float(ball.x[3]) * scale, middle + scale * centroid, float(pieces.sum()) * scale**3)


#: Weight, in the least-squares problem, of the condition that the coefficients of a convex combination sum to
#: one. A larger value enforces the condition more exactly, but makes the distance less accurate.
_SUM_WEIGHT = 1e6


@dataclass(frozen=True)
class Shapes(Extents):
    """Shapes of a scene in space."""

    parts: ConvexParts  #: convex parts of the blocks
    faces: OuterFaces  #: outer faces of the blocks

    within = "in a volume"
    meeting = "only along edges or at corners, but a joint needs a face of one of the blocks"
    bearing = "cut a narrow face into one of the blocks at the contact"
    enough = 100  # end the search after 100 overlaps, because each overlap needs a linear program

    __repr__ = brief

    @property
    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners of all blocks, block by block, and the index of each corner's block."""
        return self.parts.points, self.parts.block[self.parts.of_point]

    def outside(self, blocks: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return how far each point is outside the convex hull of its block, shape (points,)."""
        corners, owner = self.corners
        distances = [
            _distance_from_hull(corners[owner == block] - point)
            for block, point in zip(blocks, points, strict=True)
        ]
        return np.array(distances, dtype=float)

    def away(self, block: int, point: np.ndarray) -> float:
        """Return a lower bound on the distance of a point from a block: 0 or less if the point is inside.

        The bound of a convex part is the largest height of the point above a plane of the part. The bound of
        the block is the smallest bound of its parts.
        """
        height = self.parts.normal @ point - self.parts.offset
        block_parts = np.flatnonzero(self.parts.block == block)
        return min(float(height[self.parts.of_plane == part].max()) for part in block_parts)

    def nearest(self, block: int) -> tuple[int, float]:
        """Return the index of the block nearest to a given block, and the distance between the two blocks.

        Blocks are examined in the order of the distances between bounding boxes, which are lower bounds on
        the distances between blocks.
        """
        low, high = self.boxes
        lower_bound = lengths(np.maximum(np.maximum(low - high[block], low[block] - high), 0))
        lower_bound[block] = np.inf
        nearest_block, gap = block, np.inf
        for candidate in np.argsort(lower_bound).tolist():
            if lower_bound[candidate] >= gap:
                break
            # The distance between two convex parts equals the distance between the origin and the convex hull
            # of all differences of their corners.
            distance = min(
                _distance_from_hull((first[:, None] - second[None]).reshape(-1, 3))
                for first, second in product(self._parts_of(block), self._parts_of(candidate))
            )
            if distance < gap:
                nearest_block, gap = candidate, distance
        return nearest_block, gap

    def _parts_of(self, block: int) -> list[np.ndarray]:
        """Return the corners of each part of a block, shape (corners, 3) each."""
        parts = np.flatnonzero(self.parts.block == block)
        return [self.parts.points[self.parts.of_point == part] for part in parts]

    def thickness(self) -> np.ndarray:
        """Return the thickness (least width) of each block, shape (blocks,).

        The least width of a block with several parts is the least width of its thickest part.
        """
        parts = self.parts
        thickness = np.zeros(len(self.size))
        first_plane, first_point = (
            np.searchsorted(part, np.arange(len(parts.block) + 1))
            for part in (parts.of_plane, parts.of_point)
        )
        for part, block in enumerate(parts.block):
            planes = slice(*first_plane[part : part + 2])
            points = parts.points[slice(*first_point[part : part + 2])]
            height = parts.normal[planes] @ points.T - parts.offset[planes, None]
            thickness[block] = max(thickness[block], float(-height.min(axis=1).max()))
        return thickness

    def overlaps(self, pairs: np.ndarray) -> Iterator[tuple[int, Common]]:
        """Yield each region in which convex parts of two blocks overlap, for the given pairs of blocks.

        Each region comes with the index of its pair of blocks in ``pairs``.
        """
        count = np.bincount(self.parts.block, minlength=len(self.size))
        start = np.cumsum(count) - count
        i, j = pairs.T
        number, first, second = combine(start[i], count[i], start[j], count[j])
        for pair_of_parts, region in overlapping(self.parts, first, second, self.contact_tolerance):
            yield int(number[pair_of_parts]), region


def _distance_from_hull(points: np.ndarray) -> float:
    """Return the distance of the origin from the convex hull of the given points.

    The points have shape (points, 3). Nonnegative least squares finds the convex combination of the points
    that is nearest to the origin.
    """
    # Imported here, because importing scipy.optimize takes a fifth of a second, and few scenes need it.
    from scipy.optimize import nnls

    size = float(np.abs(points).max()) or 1.0
    rows = np.vstack([points.T / size, np.full(len(points), _SUM_WEIGHT)])
    coefficients, _ = nnls(rows, np.append(np.zeros(points.shape[1]), _SUM_WEIGHT))
    return float(np.hypot.reduce(coefficients @ points))


def shapes(scene: Scene) -> Shapes:
    """Return volumes, centroids, convex parts and outer faces of the blocks of a scene.

    Faces that are oriented inwards are reversed. Coplanar pieces of a block become one outer face.

    Raises
    ------
    CaseError
        If the surface of a part is not closed; if a part is not convex or has no volume; if a face is
        not flat or crosses itself; or if parts of a block overlap. The message names the block.
    """
    surfaces = Surfaces.of(scene)
    origin, tolerance = frame_of(scene, surfaces.corners, surfaces.block[surfaces.part[surfaces.face]])
    surfaces = replace(surfaces, points=surfaces.points - origin)
    signed_volume, area, middle = _volumes(surfaces)
    volume = np.abs(signed_volume)
    diagonal = float(np.hypot.reduce(np.ptp(surfaces.points, axis=0)))
    refuse_too_thin(
        scene, surfaces.block, mean_thickness(volume, area), (tolerance, RELATIVE_TOLERANCE * diagonal)
    )
    block = surfaces.block[volume <= tolerance * area / 2]
    raise_for(
        np.unique(block),
        scene,
        f"{{}} has no volume (tolerance {rounded(tolerance)}): "
        "define the faces of a solid; if the tolerance is too large for the block, use one unit for all "
        "coordinates, and remove blocks that are far away from the others",
    )
    surfaces = surfaces.reversed(signed_volume[surfaces.part] < 0)
    face_planes = planes(surfaces, tolerance)
    parts = ConvexParts.of(surfaces, face_planes)
    _refuse_parts(scene, parts, origin, tolerance)
    blocks = len(scene.blocks)
    volume_of_block = np.bincount(surfaces.block, volume, blocks)
    centroid = sums(surfaces.block, volume[:, None] * middle, blocks) / volume_of_block[:, None]
    convex = np.bincount(surfaces.block, minlength=blocks) == 1
    faces = outer_faces(surfaces, face_planes, tolerance)
    contact_tolerance = contact_tolerance_of(scene, tolerance)
    return Shapes(
        origin, tolerance, contact_tolerance, volume_of_block, centroid, convex, surfaces.mixed, parts, faces
    )


def _volumes(surfaces: Surfaces) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return volume, surface area and centroid of each part, shapes (parts,), (parts,) and (parts, 3).

    The results are sums over tetrahedra between the middle of the part and the triangles of its faces. The
    volume is negative if the faces are oriented inwards.
    """
    count, corners, parts = surfaces.count, surfaces.corners, len(surfaces.block)
    part = surfaces.part[surfaces.face]
    middle = sums(part, corners, parts) / np.maximum(np.bincount(part, minlength=parts), 1)[:, None]
    first = (np.cumsum(count) - count)[surfaces.face]
    triangle = (first, np.arange(len(part)), following(count))
    a, b, c = (corners[corner] - middle[part] for corner in triangle)
    volume = dots(a, np.cross(b, c)) / 6
    volume_of_part = np.bincount(part, volume, parts)
    area = np.bincount(part, lengths(np.cross(b - a, c - a)) / 2, parts)
    moment = sums(part, volume[:, None] * (a + b + c) / 4, parts)
    divisor = np.where(volume_of_part == 0, 1.0, volume_of_part)[:, None]
    return volume_of_part, area, middle + moment / divisor


def _refuse_parts(scene: Scene, parts: ConvexParts, origin: np.ndarray, tolerance: float) -> None:
    """Raise CaseError if a part is not convex, or if parts of a block overlap."""
    number = np.arange(len(parts.block))
    _, height = parts.beyond(number, number)
    worst_part = int(height.argmax())
    if height[worst_part] > tolerance:
        block, wrong_blocks = parts.block[worst_part], np.unique(parts.block[height > tolerance])
        block_parts = np.flatnonzero(parts.block == block)
        subject = f"a part (no. {worst_part - block_parts[0] + 1})" if len(block_parts) > 1 else "a shape"
        blocks = [block, *wrong_blocks[wrong_blocks != block]]
        raise_for(
            blocks,
            scene,
            f"{{}} has {subject} that is not convex (a corner is {rounded(height[worst_part])} "
            "in front of the plane of a face): divide it into convex 'parts'",
        )
    count = np.bincount(parts.block)
    start = np.cumsum(count) - count
    _, first, second = combine(start, count, start, count)
    first, second = first[first < second], second[first < second]
    for pair, region in overlapping(parts, first, second, tolerance):
        block = parts.block[first[pair]]
        numbers = " and ".join(str(number - start[block] + 1) for number in (first[pair], second[pair]))
        location = place(region.middle + origin, tolerance)
        raise_for(
            [block],
            scene,
            f"the parts no. {numbers} of {{}} overlap in a volume of {region.size:.6g} "
            f"and by a depth of {rounded(region.depth)} near {location}: move the parts apart",
        )

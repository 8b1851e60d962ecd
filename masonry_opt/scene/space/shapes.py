"""Shapes of the blocks of a scene in space, their convex parts, and the checks that a solid must pass."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from masonry_opt.scene.geometry import Common, Extents, frame_of, raise_for
from masonry_opt.scene.rows import bounds, chunks, combine, dots, following, lengths, sums
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.faces import OuterFaces, Planes, Surfaces, outer_faces, place, planes


@dataclass(frozen=True)
class ConvexParts:
    """Convex parts of the blocks in turn."""

    block: np.ndarray  #: of each part, rising, shape (parts,)
    points: np.ndarray  #: corners, shape (points, 3)
    of_point: np.ndarray  #: the part of each, rising
    normal: np.ndarray  #: of half-spaces normal · x ≤ offset that bound the parts, shape (planes, 3)
    offset: np.ndarray  #: of them, shape (planes,)
    of_plane: np.ndarray  #: the part of each, rising

    @classmethod
    def of(cls, surfaces: Surfaces, planes: Planes) -> "ConvexParts":
        """The parts that the surfaces bound, if they are convex."""
        at, corner = np.unique(surfaces.vertex, return_index=True)
        # Vertices, like faces, are those of the parts in turn.
        points, of_point = surfaces.points[at], surfaces.part[surfaces.face[corner]]
        flat = planes.of_face >= 0
        key = np.column_stack([surfaces.part, planes.of_face, planes.outwards])[flat]
        of_plane, plane, outwards = np.unique(key, axis=0).T
        normal = np.where(outwards, 1.0, -1.0)[:, None] * planes.frame.normal[plane]
        offset = dots(normal, planes.frame.base[plane])
        return cls(surfaces.block, points, of_point, normal, offset, of_plane)

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest coordinates of each part, shape (parts, 3) each."""
        return bounds(self.of_point, self.points, len(self.block))

    def beyond(self, one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far the nearest and the farthest corner of the other parts lie outside, at the plane of the one
        parts where that is most; negative inside. Shape (pairs,) each."""
        parts = np.arange(len(self.block) + 1)
        plane, point = (np.searchsorted(of, parts) for of in (self.of_plane, self.of_point))
        nearest, farthest = np.empty(len(one)), np.empty(len(one))
        for pair, (a, b) in enumerate(zip(one, other, strict=True)):
            planes, points = slice(*plane[a : a + 2]), self.points[slice(*point[b : b + 2])]
            low, high = np.full((2, planes.stop - planes.start), [[np.inf], [-np.inf]])
            for some in chunks(np.full(len(points), len(low))):
                height = self.normal[planes] @ points[some].T - self.offset[planes, None]
                low, high = np.minimum(low, height.min(axis=1)), np.maximum(high, height.max(axis=1))
            nearest[pair], farthest[pair] = low.max(), high.max()
        return nearest, farthest


def overlapping(
    parts: ConvexParts, one: np.ndarray, other: np.ndarray, tolerance: float
) -> Iterator[tuple[int, Common]]:
    """Numbers of the pairs of parts that overlap by more than the tolerance, and what they have in common."""
    low, high = parts.boxes
    inside = np.minimum(high[one], high[other]) - np.maximum(low[one], low[other])
    found = np.flatnonzero((inside > tolerance).all(axis=1))
    for a, b in ((one, other), (other, one)):
        # No plane of either keeps them apart.
        found = found[parts.beyond(a[found], b[found])[0] < -tolerance]
    for pair in found:
        both = _common(parts, int(one[pair]), int(other[pair]))
        if both.depth > tolerance:
            yield int(pair), both


def _common(parts: ConvexParts, one: int, other: int) -> Common:
    """What two parts have in common, as deep as the largest ball in it is wide; 0 if they do not overlap."""
    # Few pairs come here, and half a second is much for the others to wait.
    from scipy.optimize import linprog
    from scipy.spatial import ConvexHull, HalfspaceIntersection

    both = [one, other]
    low, high = np.maximum(*parts.boxes[0][both]), np.minimum(*parts.boxes[1][both])
    middle, scale = (low + high) / 2, float(np.abs(high - low).max())
    own = np.isin(parts.of_plane, both)
    normal = parts.normal[own]
    offset = (parts.offset[own] - normal @ middle) / scale
    # The largest ball: its middle and radius.
    within, limits = np.column_stack([normal, np.ones(len(normal))]), [(None, None)] * 3 + [(0, None)]
    exact = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    ball = linprog([0, 0, 0, -1], within, offset, bounds=limits, options=exact)
    if ball.x is None or ball.x[3] <= 1e-9:
        return Common(0.0, middle, 0.0)
    corners = HalfspaceIntersection(np.column_stack([normal, -offset]), ball.x[:3]).intersections
    a, b, c = np.moveaxis(corners[ConvexHull(corners).simplices] - ball.x[:3], 1, 0)
    pieces = np.abs(dots(a, np.cross(b, c))) / 6
    centroid = ball.x[:3] + pieces @ (a + b + c) / 4 / pieces.sum()
    return Common(2 * float(ball.x[3]) * scale, middle + scale * centroid, float(pieces.sum()) * scale**3)


_WHOLE = 1e6  #: Weight of the condition that corners' shares in the nearest point of their hull sum to one.


@dataclass(frozen=True)
class Shapes(Extents):
    """Shapes of a scene in space."""

    parts: ConvexParts
    faces: OuterFaces

    within = "in a volume"
    remedy = ", or raise 'contact_tolerance' to {} if they are meant to"
    meeting = "along edges or at corners alone, where a joint needs a face"
    inside = 0.999
    mortar = 0.2
    enough = 100  # each a linear program

    @property
    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        return self.parts.points, self.parts.block[self.parts.of_point]

    def outside(self, blocks: np.ndarray, points: np.ndarray) -> np.ndarray:
        every, block = self.corners
        off = [_from_hull(every[block == one] - at) for one, at in zip(blocks, points, strict=True)]
        return np.array(off, dtype=float)

    def away(self, block: int, point: np.ndarray) -> float:
        over = self.parts.normal @ point - self.parts.offset
        own = np.flatnonzero(self.parts.block == block)
        return min(float(over[self.parts.of_plane == part].max()) for part in own)

    def nearest(self, block: int) -> tuple[int, float]:
        low, high = self.boxes
        at_least = lengths(np.maximum(np.maximum(low - high[block], low[block] - high), 0))
        at_least[block] = np.inf
        found, gap = block, np.inf
        for other in np.argsort(at_least).tolist():
            if at_least[other] >= gap:
                break
            both = product(*map(self._parts_of, (block, other)))
            apart = min(_from_hull((one[:, None] - own[None]).reshape(-1, 3)) for one, own in both)
            found, gap = (other, apart) if apart < gap else (found, gap)
        return found, gap

    def _parts_of(self, block: int) -> list[np.ndarray]:
        """Corners of each part of a block."""
        parts = np.flatnonzero(self.parts.block == block)
        return [self.parts.points[self.parts.of_point == part] for part in parts]

    def overlaps(self, pairs: np.ndarray) -> Iterator[tuple[int, Common]]:
        count = np.bincount(self.parts.block, minlength=len(self.size))
        first = np.cumsum(count) - count
        i, j = pairs.T
        number, one, other = combine(first[i], count[i], first[j], count[j])
        for at, piece in overlapping(self.parts, one, other, self.contact_tolerance):
            yield int(number[at]), piece


def _from_hull(beside: np.ndarray) -> float:
    """Return the distance of the origin from the convex hull of points.

    Nonnegative least squares finds the convex combination of the points that is nearest to the origin.
    """
    # Importing scipy.optimize takes a fifth of a second, and few scenes reach this function.
    from scipy.optimize import nnls

    size = float(np.abs(beside).max()) or 1.0
    rows = np.vstack([beside.T / size, np.full(len(beside), _WHOLE)])
    share, _ = nnls(rows, np.append(np.zeros(beside.shape[1]), _WHOLE))
    return float(np.hypot.reduce(share @ beside))


def shapes(scene: Scene) -> Shapes:
    """Volumes, centroids, convex parts and outer faces of the blocks. Parts inside out are turned, and faces
    against the others; coplanar pieces of a block are one outer face. Raises CaseError naming the block if a
    part is open, not convex, or has no volume, a face is not flat or crosses itself, or parts overlap."""
    given = Surfaces.of(scene)
    origin, tolerance = frame_of(scene, given.corners, given.block[given.part[given.face]])
    given = replace(given, points=given.points - origin)
    signed, surface, middle = _masses(given)
    volume = np.abs(signed)
    block = given.block[volume <= tolerance * surface / 2]
    none = f"has no volume (the tolerance is {tolerance:.3g})"
    raise_for(np.unique(block), scene, f"{none}: give the faces of a solid, and all coordinates in one unit")
    given = given.reversed(signed[given.part] < 0)
    flat = planes(given, tolerance)
    parts = ConvexParts.of(given, flat)
    _refuse_parts(scene, parts, origin, tolerance)
    blocks = len(scene.blocks)
    whole = np.bincount(given.block, volume, blocks)
    centroid = sums(given.block, volume[:, None] * middle, blocks) / whole[:, None]
    convex = np.bincount(given.block, minlength=blocks) == 1
    faces = outer_faces(given, flat, tolerance)
    touching = max(tolerance, scene.contact_tolerance or 0.0)
    return Shapes(origin, tolerance, touching, whole, centroid, convex, given.mixed, parts, faces)


def _masses(given: Surfaces) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Volume of each part, negative if inside out, surface, and centroid: by tetrahedra round a point."""
    count, corners, parts = given.count, given.corners, len(given.block)
    part = given.part[given.face]
    inside = sums(part, corners, parts) / np.maximum(np.bincount(part, minlength=parts), 1)[:, None]
    first = (np.cumsum(count) - count)[given.face]
    a, b, c = (corners[at] - inside[part] for at in (first, np.arange(len(part)), following(count)))
    volume = dots(a, np.cross(b, c)) / 6
    whole = np.bincount(part, volume, parts)
    surface = np.bincount(part, lengths(np.cross(b - a, c - a)) / 2, parts)
    moment = sums(part, volume[:, None] * (a + b + c) / 4, parts)
    safe = np.where(whole == 0, 1.0, whole)[:, None]
    return whole, surface, inside + moment / safe


def _refuse_parts(scene: Scene, parts: ConvexParts, origin: np.ndarray, tolerance: float) -> None:
    """Raise CaseError if a part is not convex, or parts of a block overlap."""
    number = np.arange(len(parts.block))
    _, farthest = parts.beyond(number, number)
    worst = int(farthest.argmax())
    if farthest[worst] > tolerance:
        block, hollow = parts.block[worst], np.unique(parts.block[farthest > tolerance])
        own = np.flatnonzero(parts.block == block)
        what = f"a part, no. {worst - own[0] + 1}," if len(own) > 1 else "a shape"
        off = f"a corner lies {farthest[worst]:.3g} in front of the plane of a face"
        every = [block, *hollow[hollow != block]]
        raise_for(every, scene, f"has {what} that is not convex ({off}): give 'parts', each convex")
    count = np.bincount(parts.block)
    first = np.cumsum(count) - count
    _, one, other = combine(first, count, first, count)
    one, other = one[one < other], other[one < other]
    for pair, found in overlapping(parts, one, other, tolerance):
        block = parts.block[one[pair]]
        numbers = " and ".join(str(number - first[block] + 1) for number in (one[pair], other[pair]))
        overlap = f"overlap in a volume of {found.size:.6g} round {place(found.middle + origin, tolerance)}"
        deep = f"{found.depth:.3g} deep: move them apart"
        raise_for([block], scene, f"has parts no. {numbers} that {overlap}, {deep}")

"""Convex parts of the blocks as points and half-spaces, and what two of them have in common."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from masonry_opt.scene.extents import Common
from masonry_opt.scene.rows import chunks, combine, dots, ranges
from masonry_opt.scene.space.faces import Planes
from masonry_opt.scene.space.surfaces import Surfaces


@dataclass(frozen=True)
class ConvexParts:
    """Convex parts of the blocks in turn.

    Attributes
    ----------
    block: of each part, rising, shape (parts,).
    points, of_point: corners, shape (points, 3), and the part of each, rising.
    normal, offset, of_plane: half-spaces normal · x ≤ offset that bound the parts, shape (planes, 3) and
        (planes,), and the part of each, rising.
    low, high: boxes round the parts, shape (parts, 3) each.
    """

    block: np.ndarray
    points: np.ndarray
    of_point: np.ndarray
    normal: np.ndarray
    offset: np.ndarray
    of_plane: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def of(cls, surfaces: Surfaces, planes: Planes) -> ConvexParts:
        """The parts that the surfaces bound, if they are convex."""
        at, corner = np.unique(surfaces.vertex, return_index=True)
        points, of_point = surfaces.points[at], surfaces.part[surfaces.face[corner]]
        order = np.argsort(of_point, kind="stable")
        points, of_point = points[order], of_point[order]
        start = np.searchsorted(of_point, np.arange(len(surfaces.block)))
        low, high = (bound.reduceat(points, start) for bound in (np.minimum, np.maximum))
        flat = planes.of_face >= 0
        key = np.column_stack([surfaces.part, planes.of_face, planes.outwards])[flat]
        of_plane, plane, outwards = np.unique(key, axis=0).T
        normal = np.where(outwards, 1.0, -1.0)[:, None] * planes.frame.normal[plane]
        offset = dots(normal, planes.frame.base[plane])
        return cls(surfaces.block, points, of_point, normal, offset, of_plane, low, high)

    def beyond(self, one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far the nearest and the farthest corner of the other parts lie outside, at the plane of the one
        parts where that is most; negative inside. Shape (pairs,) each."""
        planes, points = (np.bincount(of, minlength=len(self.block)) for of in (self.of_plane, self.of_point))
        first_plane, first_point = np.cumsum(planes) - planes, np.cumsum(points) - points
        nearest, farthest = np.empty(len(one)), np.empty(len(one))
        for some in chunks(planes[one] * points[other]):
            a, b = one[some], other[some]
            rows = np.repeat(np.arange(len(a)), planes[a])
            i, of_points = ranges(first_plane[a], planes[a]), b[rows]
            height = [np.empty(len(i)) for _ in range(2)]
            for part in chunks(points[of_points]):
                number, k, j = combine(
                    i[part], np.ones_like(i[part]), *(own[of_points[part]] for own in (first_point, points))
                )
                off = dots(self.normal[k], self.points[j]) - self.offset[k]
                start = np.searchsorted(number, np.arange(len(i[part])))
                for own, bound in zip(height, (np.minimum, np.maximum), strict=True):
                    own[part] = bound.reduceat(off, start)
            pair = np.cumsum(planes[a]) - planes[a]
            nearest[some], farthest[some] = (np.maximum.reduceat(own, pair) for own in height)
        return nearest, farthest


def overlapping(
    parts: ConvexParts, one: np.ndarray, other: np.ndarray, tolerance: float
) -> Iterator[tuple[int, Common]]:
    """Numbers of the pairs of parts that overlap by more than the tolerance, and what they have in common."""
    inside = np.minimum(parts.high[one], parts.high[other]) - np.maximum(parts.low[one], parts.low[other])
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

    low, high = np.maximum(*parts.low[[one, other]]), np.minimum(*parts.high[[one, other]])
    middle, scale = (low + high) / 2, float(np.abs(high - low).max())
    own = np.isin(parts.of_plane, (one, other))
    normal = parts.normal[own]
    offset = (parts.offset[own] - normal @ middle) / scale
    # The largest ball: its middle and radius.
    ball = linprog(
        [0, 0, 0, -1],
        A_ub=np.column_stack([normal, np.ones(len(normal))]),
        b_ub=offset,
        bounds=[(None, None)] * 3 + [(0, None)],
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if ball.x is None or ball.x[3] <= 1e-9:
        return Common(0.0, middle, 0.0)
    corners = HalfspaceIntersection(np.column_stack([normal, -offset]), ball.x[:3]).intersections
    a, b, c = np.moveaxis(corners[ConvexHull(corners).simplices] - ball.x[:3], 1, 0)
    pieces = np.abs(dots(a, np.cross(b, c))) / 6
    centroid = ball.x[:3] + pieces @ (a + b + c) / 4 / pieces.sum()
    return Common(2 * float(ball.x[3]) * scale, middle + scale * centroid, float(pieces.sum()) * scale**3)

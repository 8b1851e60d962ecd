"""Where the outlines of blocks in the plane touch: lengths of edge that two share, and corners on edges."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np
import shapely

from masonry_opt.errors import CaseError
from masonry_opt.scene.contacts import sides
from masonry_opt.scene.contacts.sides import LEAN, Items, Touches, near_items, to_line
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.scene import Scene

_ROUNDING = 1e-3  #: Share of the tolerance that is rounding.
_MOST_EDGES = 20_000_000  #: Most pairs of edges that are compared.


@dataclass(frozen=True)
class FacingEdges(sides.Facing):
    """Parts of bisectors onto which both edges project, from where to where as the first one runs."""

    start: np.ndarray
    end: np.ndarray

    @classmethod
    def between(
        cls,
        pair: np.ndarray,
        most: np.ndarray,
        ends: tuple[np.ndarray, np.ndarray],
        accuracy: np.ndarray,
        lean: tuple[np.ndarray, np.ndarray],
    ) -> Self:
        """Return the lengths between ends; ``lean`` is the angle between the edges and the shorter edge."""
        start, end = ends
        extent = np.hypot(*(end - start).T)
        # Counter-clockwise round the first block its interior lies to the left.
        normal = -_tangent((end - start) / extent[:, None])
        return cls(pair, most, extent, (start + end) / 2, normal, accuracy, *lean, start, end)

    @classmethod
    def of(cls, corners: "PlaneCorners", pair: np.ndarray, i: np.ndarray, j: np.ndarray) -> "FacingEdges":
        """Those of edges i of the pairs' first and j of their second blocks, longer than the tolerance."""
        tail, tip, shortest = corners.point, corners.tip, corners.shapes.tolerance
        one, other = (edge / np.hypot(*edge.T)[:, None] for edge in (tip[i] - tail[i], tail[j] - tip[j]))
        kept = (one * other).sum(axis=1) > 0
        pair, i, j, along = pair[kept], i[kept], j[kept], (one + other)[kept]
        along /= np.hypot(*along.T)[:, None]
        # Both edges run along the bisector; each end of what they share is a corner of the one or the other.
        lines = np.array([[tail[i], tip[i]], [tip[j], tail[j]]])
        x = ((lines - tail[i]) * along).sum(axis=-1)
        at = np.array([np.maximum(*x[:, 0]), np.minimum(*x[:, 1])])
        of_first = x[0] == at
        corner = np.where(of_first[..., None], *lines)
        # The other edge there, from start to stop.
        start, stop = (np.where(of_first[..., None], lines[1, end], lines[0, end]) for end in (0, 1))
        x0, x1 = (np.where(of_first, x[1, end], x[0, end]) for end in (0, 1))
        across = start + ((at - x0) / (x1 - x0))[..., None] * (stop - start) - corner
        width = np.hypot(*np.moveaxis(across, 2, 0))
        # Rounding moves no corner: what touches has the coordinates that were given.
        ends = corner + np.where(width > _ROUNDING * shortest, 0.5, 0.0)[..., None] * across
        long = at[1] - at[0] > shortest
        of_first, of_second = (_accuracy(tip[of] - tail[of], shortest)[long] for of in (i, j))
        sine = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
        lean = np.abs(sine[kept][long]), shortest / np.maximum(of_first, of_second)
        start, end = ends[:, long]
        accuracy = (of_first + of_second) / 2
        return cls.between(pair[long], width.max(axis=0)[long], (start, end), accuracy, lean)

    def outlines(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        points, number = np.stack([self.start, self.end], axis=1).reshape(-1, 2), np.arange(len(self.pair))
        return _tangent(self.normal), number, np.full(len(number), 2), points

    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        return to_line(points, self.start[number], self.end[number])


def facing(scene: Scene, shapes: Geometry, pairs: np.ndarray, far: np.ndarray) -> FacingEdges:
    """The lengths of edge that pairs of blocks share, and those across which they face each other, nowhere
    farther apart than ``far``, shape (pairs,).

    Edges share the part of their bisector onto which both project, if their largest distance there is within
    the tolerance. Parts that follow one another (an edge drawn in chords) are one length, or several where it
    bends by more than the tolerance. Raises CaseError if there are more edges than can be compared.
    """
    corners = PlaneCorners(shapes)
    near = [corners.edges.beside(shapes, both, far)[0] for both in (pairs, pairs[:, ::-1])]
    one, other = (np.bincount(pair, minlength=len(pairs)) for pair in near)
    if (one * other).sum() > _MOST_EDGES:
        of_each = np.bincount(corners.edges.block)
        most = f"block {scene.blocks[of_each.argmax()].name!r} has {of_each.max()} corners"
        fine = f"outlines are too fine to find joints ({most})"
        raise CaseError(f"{scene.origin}: {fine}: raise 'tolerance', or give fewer corners")
    parts = FacingEdges.of(corners, *near_items(shapes, pairs, far, 2 * (corners.edges,)))
    touch = parts.most <= shapes.tolerance
    across = parts.where(~touch & (parts.most <= far[parts.pair]))
    whole = _joined(parts.where(touch), shapes.tolerance).then(across)
    return whole.where(np.argsort(whole.pair, kind="stable"))


def _joined(parts: FacingEdges, tolerance: float) -> FacingEdges:
    """Parts, those that follow one another joined where straight, without those too short for their width."""
    pairs, number, count = np.unique(parts.pair, return_inverse=True, return_counts=True)
    found = [one for pair in pairs[count > 1] for one in _chains(parts.where(parts.pair == pair), tolerance)]
    whole = parts.where(count[number] == 1).then(*found)
    return whole.where(whole.most <= LEAN * whole.extent)


def _chains(parts: FacingEdges, tolerance: float) -> Iterator[FacingEdges]:
    """Parts of one pair, made one where one begins within two tolerances of where another ends."""
    apart = np.hypot(*np.moveaxis(parts.end[:, None] - parts.start[None], 2, 0))
    np.fill_diagonal(apart, np.inf)
    after = {int(k): int(apart[k].argmin()) for k in np.flatnonzero(apart.min(axis=1) <= 2 * tolerance)}
    left = set(range(len(parts.pair)))
    # Begin with those that follow none; what is left then is a ring.
    for first in [*sorted(left - set(after.values())), *sorted(left)]:
        chain, at = [], first
        while at in left:
            left.remove(at)
            chain.append(at)
            at = after.get(at, -1)
        if chain:
            yield _simplified(parts.where(np.array(chain)), tolerance)


def _simplified(chain: FacingEdges, tolerance: float) -> FacingEdges:
    """A chain's line without the corners that lie within half the tolerance of the line without them."""
    inner = (chain.end[:-1] + chain.start[1:]) / 2
    line = shapely.LineString(np.concatenate([chain.start[:1], inner, chain.end[-1:]]))
    corners = shapely.get_coordinates(shapely.simplify(line, tolerance / 2, preserve_topology=False))
    of_chain = chain.pair[0], chain.most.max(), chain.angle.max(), chain.shorter.min()
    pair, most, *lean = (np.full(len(corners) - 1, value) for value in of_chain)
    accuracy = _accuracy(np.diff(corners, axis=0), tolerance)
    return FacingEdges.between(pair, most, (corners[:-1], corners[1:]), accuracy, (lean[0], lean[1]))


class PlaneCorners(sides.BlockCorners):
    """Corners of all blocks; each begins an edge, which ends at ``tip``, shape (corners, 2)."""

    apart = 2.0

    def __init__(self, shapes: Geometry, blocks: np.ndarray | None = None) -> None:
        self.shapes = shapes
        self.point, self.tip, block = shapes.edges
        self.start = self.end = self.point
        self.corners = self.met = Items(block, self.point, self.point)
        self.edges = Items(block, np.minimum(self.point, self.tip), np.maximum(self.point, self.tip))

    def kinds(self, pairs: np.ndarray) -> list[Touches]:
        """Corners of the first blocks on edges of the second, then the other way round."""
        return [self._on_edges(pairs, -1.0), self._on_edges(pairs[:, ::-1], 1.0)]

    def _on_edges(self, pairs: np.ndarray, sign: float) -> Touches:
        """Corners of the first blocks that lie between the ends of an edge of the second."""
        tolerance = self.shapes.tolerance
        pair, corner, edge = near_items(self.shapes, pairs, tolerance, (self.corners, self.edges))
        point, tail = self.point[corner], self.point[edge]
        way = self.tip[edge] - tail
        length = np.hypot(way[:, 0], way[:, 1])
        direction = way / length[:, None]
        normal = np.column_stack([-direction[:, 1], direction[:, 0]])
        at, across = ((point - tail) * direction).sum(axis=1), ((point - tail) * normal).sum(axis=1)
        within = (np.abs(across) <= tolerance) & (at > tolerance) & (at < length - tolerance)
        # The normal of an edge points into its own block.
        point, normal = point[within], sign * normal[within]
        accuracy = _accuracy(way[within], tolerance)
        return Touches(pair[within], point, point, normal, _tangent(normal), accuracy)


def _accuracy(edges: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the angle in radians within which a drawing fixes the direction of each edge, shape (edges,)."""
    return tolerance / np.hypot(edges[:, 0], edges[:, 1])


def _tangent(normal: np.ndarray) -> np.ndarray:
    """A quarter turn clockwise of the normals."""
    return np.column_stack([normal[:, 1], -normal[:, 0]])

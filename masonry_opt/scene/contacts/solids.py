"""Where blocks in space touch beside the polygons they share: edges and corners on faces, crossing edges."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import shapely

from masonry_opt.scene.contacts import sides
from masonry_opt.scene.contacts.faces import NARROWEST
from masonry_opt.scene.contacts.sides import Items, Touches, near_items
from masonry_opt.scene.rows import dots, first_alike, lengths, sums
from masonry_opt.scene.space.faces import unit
from masonry_opt.scene.space.shapes import Shapes

#: Sine of the angle between faces below which they lie in one plane.
_FLAT = 1e-3


class SolidCorners(sides.BlockCorners):
    """Edges and corners of the outer faces of some blocks.

    Attributes
    ----------
    tail, tip: ends of each edge, shape (edges, 3) each.
    direction: unit vectors along them, shape (edges, 3).
    inwards: sum of the unit vectors from each edge into its faces, shape (edges, 3).
    edges, faces: the edges, and the blocks' faces, as items.
    """

    apart = NARROWEST

    def __init__(self, shapes: Shapes, blocks: np.ndarray) -> None:
        self.shapes, self.outer = shapes, shapes.faces
        outer = self.outer
        tail, tip, face = outer.sides()
        block = outer.block[face]
        asked = np.isin(block, blocks)
        tail, tip, face, block = tail[asked], tip[asked], face[asked], block[asked]
        # An edge is in two faces, a corner in three or more.
        grid, other = (np.round(ends / shapes.tolerance) for ends in (tail, tip))
        ends = np.column_stack([block, np.minimum(grid, other), np.maximum(grid, other)])
        own = first_alike(ends)
        one, number = np.unique(own, return_inverse=True)
        self.tail, self.tip = tail[one], tip[one]
        self.direction = unit(self.tip - self.tail)
        self.inwards = sums(number, np.cross(outer.frame.normal[face], unit(tip - tail)), len(one))
        self.edges = Items(block[one], np.minimum(self.tail, self.tip), np.maximum(self.tail, self.tip))
        self.met, self.start, self.end = self.edges, self.tail, self.tip
        one = np.unique(first_alike(np.column_stack([block, grid])))
        self.point = tail[one]
        self.corners = Items(block[one], self.point, self.point)
        self.faces = Items(outer.block, *outer.boxes)

    def kinds(self, pairs: np.ndarray) -> tuple[Iterable[Touches], ...]:
        """Edges in faces, corners on faces, and edges that cross."""
        return _edges_in_faces(self, pairs), _corners_on_faces(self, pairs), _crossings(self, pairs)


def _edges_in_faces(corners: SolidCorners, pairs: np.ndarray) -> Iterator[Touches]:
    """Where edges lie in faces of the other block and not along their outline."""
    tolerance, faces = corners.shapes.tolerance, corners.outer
    narrowest = NARROWEST * tolerance
    for side in (0, 1):
        for pair, i, j in near_items(corners.shapes, pairs, tolerance, (corners.edges, corners.faces), side):
            height = [faces.frame.above(ends[i], j) for ends in (corners.tail, corners.tip)]
            flat = [faces.frame.down(ends[i], j) for ends in (corners.tail, corners.tip)]
            kept = (np.minimum(*height) <= tolerance) & (np.maximum(*height) >= -tolerance)
            kept &= np.hypot(*(flat[1] - flat[0]).T) > narrowest
            pair, j, start, end, low, high = (column[kept] for column in (pair, j, *flat, *height))
            lines = shapely.linestrings(np.stack([start, end], axis=1))
            pieces, number = shapely.get_parts(
                shapely.intersection(lines, faces.polygon[j]), return_index=True
            )
            kept = shapely.length(pieces) > narrowest
            pieces, number = pieces[kept], number[kept]
            border = shapely.boundary(faces.polygon[j[number]])
            deep = np.zeros(len(pieces), dtype=bool)
            for share in (0.25, 0.5, 0.75):
                at = shapely.line_interpolate_point(pieces, share, normalized=True)
                deep |= shapely.distance(border, at) > narrowest
            points = []
            for end_no in (0, -1):
                at = shapely.get_coordinates(shapely.get_point(pieces, end_no))
                way = (end - start)[number]
                t = ((at - start[number]) * way).sum(axis=1) / (way**2).sum(axis=1)
                over = low[number] + t * (high - low)[number]
                deep &= np.abs(over) <= tolerance
                lift = over[:, None] / 2 * faces.frame.normal[j[number]]
                points.append(faces.frame.up(at, j[number]) + lift)
            one, other = points[0][deep], points[1][deep]
            number = number[deep]
            # Normals of faces point out of their block.
            normal = (1 if side == 0 else -1) * faces.frame.normal[j[number]]
            # Square to the normal, also where the edge leans within the tolerance.
            along = other - one
            yield Touches(
                pair[number], one, other, normal, unit(along - dots(along, normal)[:, None] * normal)
            )


def _corners_on_faces(corners: SolidCorners, pairs: np.ndarray) -> Iterator[Touches]:
    """Where corners stand on faces of the other block and not on their outline."""
    tolerance, faces = corners.shapes.tolerance, corners.outer
    kinds = corners.corners, corners.faces
    for side in (0, 1):
        for pair, i, j in near_items(corners.shapes, pairs, tolerance, kinds, side):
            flat, height = faces.frame.down(corners.point[i], j), faces.frame.above(corners.point[i], j)
            kept = np.abs(height) <= tolerance
            pair, j, flat, height = pair[kept], j[kept], flat[kept], height[kept]
            at = shapely.points(flat)
            kept = shapely.contains(faces.polygon[j], at)
            kept &= shapely.distance(shapely.boundary(faces.polygon[j]), at) > tolerance
            pair, j, flat, height = pair[kept], j[kept], flat[kept], height[kept]
            point = faces.frame.up(flat, j) + height[:, None] / 2 * faces.frame.normal[j]
            normal = (1 if side == 0 else -1) * faces.frame.normal[j]
            yield Touches(pair, point, point, normal, faces.frame.u[j])


def _crossings(corners: SolidCorners, pairs: np.ndarray) -> Iterator[Touches]:
    """Where edges cross between their ends."""
    tolerance = corners.shapes.tolerance
    for pair, i, j in near_items(corners.shapes, pairs, tolerance, (corners.edges, corners.edges)):
        long = [lengths(corners.tip[edge] - corners.tail[edge]) for edge in (i, j)]
        one, other = corners.direction[i], corners.direction[j]
        across = np.cross(one, other)
        sine = lengths(across)
        # Else they run along each other: moved by the tolerance, they would turn their normal.
        kept = sine * np.minimum(*long) > NARROWEST * tolerance
        pair, i, j, one, other, across, sine = (
            column[kept] for column in (pair, i, j, one, other, across, sine)
        )
        normal = across / sine[:, None]
        between = corners.tail[j] - corners.tail[i]
        at = [dots(np.cross(between, edge), normal) / sine for edge in (other, one)]
        gap = dots(between, normal)
        kept = np.abs(gap) <= tolerance
        for own, edge in zip(at, (i, j), strict=True):
            length = lengths(corners.tip[edge] - corners.tail[edge])
            kept &= (own > tolerance) & (own < length - tolerance)
        # Both blocks' faces there lie on their own sides of the plane of the edges.
        towards = dots(normal, corners.inwards[i] - corners.inwards[j])
        kept &= np.abs(towards) > _FLAT
        point = corners.tail[i] + at[0][:, None] * one + gap[:, None] / 2 * normal
        sign = np.sign(towards)[:, None]
        yield Touches(pair[kept], point[kept], point[kept], (sign * normal)[kept], one[kept])

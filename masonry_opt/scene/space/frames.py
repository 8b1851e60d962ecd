"""Planes in space with axes of their own, and what lies in them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import shapely

from masonry_opt.scene.rows import Rows, dots, lengths

#: Share of an area that is rounding.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Frames(Rows):
    """Planes: a point of each, two unit axes in it and its unit normal u × v, shape (frames, 3) each."""

    base: np.ndarray
    u: np.ndarray
    v: np.ndarray
    normal: np.ndarray

    @classmethod
    def of(cls, base: np.ndarray, normal: np.ndarray, along: np.ndarray) -> Self:
        """With these points and normals, the first axis as near as it can be to ``along``."""
        normal = unit(normal)
        u = unit(along - dots(along, normal)[:, None] * normal)
        return cls(base, u, np.cross(normal, u), normal)

    def down(self, points: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """Coordinates in the given frames of points in space, shape (points, 2)."""
        beside = points - self.base[frame]
        return np.column_stack([dots(beside, self.u[frame]), dots(beside, self.v[frame])])

    def above(self, points: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """Height of points in space over the given frames, shape (points,)."""
        return dots(points - self.base[frame], self.normal[frame])

    def up(self, points: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """Points in space with these coordinates in the given frames, shape (points, 3)."""
        return self.base[frame] + points[:, :1] * self.u[frame] + points[:, 1:] * self.v[frame]


@dataclass(frozen=True)
class OuterFaces(Rows):
    """Plane outer faces of the blocks in turn.

    Attributes
    ----------
    block: of each face, rising, shape (faces,).
    frame: their planes, normals outwards.
    polygon: shapely polygons in them, counter-clockwise, with holes, shape (faces,).
    """

    block: np.ndarray
    frame: Frames
    polygon: np.ndarray

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest coordinates of each face, shape (faces, 3) each."""
        flat, face = shapely.get_coordinates(self.polygon, return_index=True)
        corners = self.frame.up(flat, face)
        start = np.searchsorted(face, np.arange(len(self.block)))
        return np.minimum.reduceat(corners, start), np.maximum.reduceat(corners, start)

    @cached_property
    def convex(self) -> np.ndarray:
        """Whether each is convex but for rounding, shape (faces,)."""
        area = shapely.area(self.polygon)
        return shapely.area(shapely.convex_hull(self.polygon)) - area <= _ROUNDING * area

    def sides(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Sides of all outlines and holes, each with its face to the left seen from outside: their ends in
        space, shape (sides, 3) each, and their faces, rising."""
        rings, face = shapely.get_rings(self.polygon, return_index=True)
        flat, ring = shapely.get_coordinates(rings, return_index=True)
        points = self.frame.up(flat, face[ring])
        inside = ring[:-1] == ring[1:]
        return points[:-1][inside], points[1:][inside], face[ring[:-1][inside]]


def unit(vectors: np.ndarray) -> np.ndarray:
    """The rows over their lengths."""
    return vectors / lengths(vectors)[:, None]

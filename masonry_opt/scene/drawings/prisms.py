"""Prisms along one direction, seen along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from masonry_opt.scene.drawings.meshes import Mesh, Side, area_vector, polyhedron
from masonry_opt.scene.drawings.stones import naming

#: Lengths below this fraction of a solid's size are nothing: its corners may be in single precision.
_RELATIVE_TOLERANCE = 1e-5


@dataclass(frozen=True)
class SideView:
    """Outlines of solids in the plane across a direction, and where each begins and ends along it, shape
    (solids, 2)."""

    outlines: list[shapely.Polygon]
    reach: np.ndarray


def _axes(direction: np.ndarray) -> np.ndarray:
    """Axes of the plane across a direction, shape (2, 3): z upwards is its second, or along z itself y.

    Raises ValueError if the direction is neither level nor z, so that weights do not act in the plane.
    """
    unit = direction / np.linalg.norm(direction)
    if abs(abs(unit[2]) - 1) < 1e-9:
        return np.eye(3)[:2]
    if abs(unit[2]) > 1e-6:
        raise ValueError("is neither level nor upright: weights would not act in the plane")
    across = np.cross(unit, (0.0, 0.0, 1.0))
    across /= np.linalg.norm(across)
    # Seen from the side from which x (or else y) runs to the right.
    if across[0] < -1e-9 or (abs(across[0]) <= 1e-9 and across[1] < 0):
        across = -across
    return np.array([across + 0.0, [0.0, 0.0, 1.0]])


def prism_directions(solids: Sequence[Mesh]) -> list[np.ndarray]:
    """Directions along which the solids may be prisms: y, x, and level normals of the first one's faces; of
    polygons also z."""
    x, y, z = np.eye(3)
    found = [z, y, x] if all(solid.flat for solid in solids) else [y, x]
    for face in solids[0].faces[:100]:
        normal = area_vector(solids[0].points[face])
        size = float(np.linalg.norm(normal))
        new = all(np.linalg.norm(np.cross(normal, other)) > 1e-6 * size for other in found)
        if abs(normal[2]) < 1e-6 * size and new:
            found.append(normal / size)
    return found


@dataclass(frozen=True)
class Solid:
    """A block, and the length given that is nothing beside it."""

    mesh: Mesh
    given: float | None

    @cached_property
    def tolerance(self) -> float:
        return self.given or _RELATIVE_TOLERANCE * float(np.linalg.norm(np.ptp(self.mesh.points, axis=0)))

    @cached_property
    def sides(self) -> list[Side]:
        """Its plane sides, for all directions that it is looked at along."""
        return polyhedron(self.mesh, self.tolerance).sides


def seen_along(solids: Sequence[Solid], direction: np.ndarray) -> SideView:
    """The solids as prisms along a direction.

    Raises ValueError, naming the block, if one is no prism along it.
    """
    plane = _axes(direction)
    unit = direction / np.linalg.norm(direction)
    outlines, reach = [], []
    flat = all(solid.mesh.flat for solid in solids)
    for solid in solids:
        if solid.mesh.flat and not flat:
            raise ValueError(f"block '{solid.mesh.name}' is a single face among solids: give it a thickness")
        with naming(f"block '{solid.mesh.name}'"):
            outlines.append(_end(solid, plane, unit))
        along = solid.mesh.points @ unit
        reach.append((along.min(), along.max()))
    return SideView(outlines, np.array(reach))


def _end(solid: Solid, plane: np.ndarray, unit: np.ndarray) -> shapely.Polygon:
    """The outline of a prism's ends, which must be the same."""
    mesh, tolerance = solid.mesh, solid.tolerance
    along, seen = mesh.points @ unit, mesh.points @ plane.T
    thickness = np.ptp(along)
    if mesh.flat != (thickness <= tolerance):
        raise ValueError("does not lie across it" if mesh.flat else "has no thickness along it")
    ends = []
    for side in sorted(solid.sides, key=lambda side: side.base @ unit):
        if np.ptp(along[side.rings[0]]) <= tolerance:
            ends.append(shapely.Polygon(seen[side.rings[0]], [seen[ring] for ring in side.rings[1:]]))
        elif abs(side.normal @ unit) * thickness > tolerance:
            raise ValueError("has a face that is neither along it nor across: it is no prism")
    if len(ends) != 2 - mesh.flat:
        raise ValueError("has a step along it, or an end of several parts, or none: it is no prism")
    if not all(end.is_valid for end in ends):
        raise ValueError("has a face that crosses itself")
    if shapely.area(shapely.symmetric_difference(ends[0], ends[-1])) > tolerance * ends[0].length:
        raise ValueError("has two ends that differ: it is no prism")
    return shapely.orient_polygons(ends[0])

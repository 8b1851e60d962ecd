"""Meshes to a scene in space: blocks whole, supports, a tolerance for rounded coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ConfigDict

from masonry_opt.scene.drawings.convex_parts import convex_parts
from masonry_opt.scene.drawings.meshes import Mesh, MeshSolid, area_vector, polyhedron, used
from masonry_opt.scene.drawings.stones import Drawing, listed, naming, scene_of
from masonry_opt.scene.extents import NEAR_MISS, RELATIVE_TOLERANCE
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import Solid, Vector, prism

#: Most decimals of coordinates that were rounded; more are those of numbers as they are.
_MOST_DECIMALS = 7

#: Thickness of the slab that a flat support becomes, over the root of its area.
_SLAB = 0.1


class SolidDrawing(Drawing):
    """Values that a drawing of solids leaves open: see :func:`read_mesh` and :func:`read_compas`."""

    model_config = ConfigDict(title="solids as drawn")

    live: Vector = (0.0, 0.0, 0.0)

    def solid(self, mesh: Mesh, tolerance: float) -> Solid:
        """The solid of a closed mesh: a support, or one with this unit weight and live load.

        Raises ValueError if it cannot be cut into convex parts.
        """
        whole = polyhedron(mesh, tolerance)
        parts = [whole] if whole.convex(tolerance) else convex_parts(whole, tolerance)
        shape = _keys(parts[0]) if len(parts) == 1 else {"parts": [_keys(part) for part in parts]}
        loads: dict[str, Any] = {"unit_weight": self.unit_weight, "live_per_weight": self.live}
        return Solid(name=mesh.name, **shape, **({"fixed": True} if mesh.fixed else loads))


def _keys(shape: MeshSolid) -> dict[str, Any]:
    own = used("", shape.points, [side.rings[0] for side in shape.sides])
    return {"vertices": list(map(tuple, own.points.tolist())), "faces": own.faces}


def scene_in_space(meshes: Sequence[Mesh], drawing: SolidDrawing, path: Path) -> Scene:
    """The scene that closed meshes make; a support of one face is taken for the top of a slab.

    Raises ValueError if there is no support, a block is no solid, or they make no scene.
    """
    standing = [mesh.points for mesh in meshes if not mesh.fixed]
    if not standing:
        names = listed([mesh.name for mesh in meshes])
        raise ValueError(f"every block is a support: nothing can move (blocks: {names})")
    middle = np.concatenate(standing).mean(axis=0)
    solid = [_slab(mesh, middle) if mesh.flat and mesh.fixed else mesh for mesh in meshes]
    tolerance = drawing.tolerance or _tolerance(standing)
    blocks = [_told(mesh, drawing, tolerance) for mesh in solid]
    return scene_of(blocks, drawing.replace(tolerance=tolerance), path)


def _told(mesh: Mesh, drawing: SolidDrawing, tolerance: float) -> Solid:
    if mesh.flat:
        raise ValueError(f"block '{mesh.name}' is a single face: give it a thickness, or make it a support")
    with naming(f"block '{mesh.name}'"):
        return drawing.solid(mesh, tolerance)


def _slab(mesh: Mesh, standing: np.ndarray) -> Mesh:
    """A flat support with a thickness, on the other side than what stands on it."""
    (ring,) = mesh.faces
    top, area = mesh.points[ring], area_vector(mesh.points[ring])
    size = float(np.linalg.norm(area))
    if not size > 0:
        raise ValueError(f"block '{mesh.name}' is a face without area: take it away")
    towards = np.sign((standing - top.mean(axis=0)) @ area) or 1.0
    bottom = top - towards * _SLAB * area / np.sqrt(size)
    return replace(
        mesh, points=np.concatenate([top, bottom]), faces=prism(top.tolist(), bottom.tolist())["faces"]
    )


def _tolerance(standing: Sequence[np.ndarray]) -> float:
    """Twice the last decimal of the coordinates of blocks where these seem rounded: where all have a few
    decimals, and that is little beside the blocks. Else that of a scene."""
    points = np.concatenate(standing)
    usual = RELATIVE_TOLERANCE * float(np.linalg.norm(np.ptp(points, axis=0)))
    smallest = min(float(np.cbrt(np.prod(np.ptp(own, axis=0)))) for own in standing)
    for decimals in range(_MOST_DECIMALS + 1):
        unit = 10.0**-decimals
        if np.abs(points - np.round(points, decimals)).max() <= 1e-9 * np.abs(points).max():
            return max(usual, 2 * unit) if 2 * unit <= NEAR_MISS * smallest else usual
    return usual

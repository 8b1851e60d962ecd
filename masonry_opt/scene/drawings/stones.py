"""Blocks as they are drawn, which are supports, and the scene that they make, in the plane or in space."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
import shapely
from pydantic import ConfigDict

from masonry_opt.errors import CaseError, printable
from masonry_opt.scene.blocks import Block, Name, NonNegative, Number, Positive, Record
from masonry_opt.scene.drawings.convex_parts import convex_parts
from masonry_opt.scene.drawings.meshes import Mesh, MeshSolid, area_vector, polyhedron, refuse_holes, used
from masonry_opt.scene.geometry import NEAR_MISS, RELATIVE_TOLERANCE
from masonry_opt.scene.joints import Friction, JointDefaults
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import PlaneOrSpaceVector, Solid, Vector, prism

_LONGEST_NAME = 200  #: Characters of a block's name; a record takes no more.
FIXED = ("fixed", "support")  #: Supports have one of these words in the name of their layer or object.
_MOST_DECIMALS = 7  #: Most decimals of coordinates that were rounded; more are those of numbers as they are.
_SLAB = 0.1  #: Thickness of the slab that a flat support becomes, over the root of its area.


class Drawing(Record):
    """Values that a drawing leaves open, the same for all its blocks and joints."""

    friction: Friction
    unit_weight: NonNegative
    tolerance: Positive | None = None
    contact_tolerance: Positive | None = None

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Self:
        """With those of the arguments of a reader that are given, and are values of such a drawing."""
        return cls(**{key: given[key] for key in cls.model_fields if given.get(key) is not None})


class FlatDrawing(Drawing):
    """Beside them the live load of a drawing in the plane: see :func:`read_dxf` and :func:`read_compas`."""

    live: PlaneOrSpaceVector = (0.0, 0.0)

    def block(self, name: str, outline: shapely.Polygon, fixed: bool, **keys: Any) -> Block:
        """The block of an outline with holes: a support, or of this unit weight, which ``keys`` override."""
        rings = outline.exterior, *outline.interiors
        outer, *holes = (shapely.get_coordinates(ring)[:-1].tolist() for ring in rings)
        loads = {"unit_weight": self.unit_weight} | keys
        return Block(name=name, vertices=outer, holes=holes, **({"fixed": True} if fixed else loads))


def block_name(text: str) -> str:
    """The text as a block can be named: in one line, printable, not too long; empty if nothing is left."""
    return " ".join(printable(" ".join(text.split())).split())[:_LONGEST_NAME]


@contextmanager
def naming(what: str) -> Iterator[None]:
    """Makes what is wrong with a file or a block a CaseError that begins with it."""
    try:
        yield
    except ValueError as error:
        named = str(error).startswith(what)
        raise CaseError(error if named else f"{what} {error}") from None


def scene_of(blocks: Sequence[Block | Solid], drawing: Drawing, path: Path) -> Scene:
    """The scene of a drawing's blocks. Raises CaseError if they make none."""
    return Scene(
        source=f"drawn in {block_name(path.name)}",
        joints=JointDefaults(friction=drawing.friction),
        blocks=list(blocks),
        tolerance=drawing.tolerance,
        contact_tolerance=drawing.contact_tolerance,
    ).read_from(path)


class Supports(Record):
    """Which blocks are supports beside those drawn so: see :func:`read_mesh` and :func:`read_compas`."""

    fixed: list[Name] = []
    fixed_below: Number | None = None


class AsDrawn(Supports):
    """Which they are by name too, and how a mesh stands in its file: see :func:`read_mesh`."""

    fixed_layers: list[Name] = list(FIXED)
    up: Literal["x", "y", "z"] = "z"
    scale: Positive = 1.0


def listed(names: Sequence[str]) -> str:
    """The first ten names, as messages list them."""
    return ", ".join(names[:10]) + (", ..." if len(names) > 10 else "")


def with_supports(meshes: Sequence[Mesh], which: Supports, words: Sequence[str] = ()) -> list[Mesh]:
    """The blocks; supports too are those that are named, reach down to a height, or have one of the words in
    their names or layers. Raises ValueError if a name is none of theirs, or nothing is a support."""
    names = [mesh.name for mesh in meshes]
    if unknown := [name for name in which.fixed if name not in names]:
        raise ValueError(f"'fixed': no block '{unknown[0]}' (blocks: {listed(names)})")
    below = -np.inf if which.fixed_below is None else which.fixed_below
    lowest = [float(mesh.points[:, 2].min()) for mesh in meshes]
    found = []
    for mesh, low in zip(meshes, lowest, strict=True):
        called = f"{mesh.name} {mesh.layers}".casefold()
        asked = mesh.name in which.fixed or any(word.casefold() in called for word in words)
        found.append(replace(mesh, fixed=mesh.fixed or asked or low <= below))
    if not any(mesh.fixed for mesh in found):
        named = f"name them by 'fixed' (blocks: {listed(names)})"
        lower = f"by 'fixed_below' (the lowest corner is at z = {min(lowest):.6g})"
        raise ValueError(f"no block is a support: {named}, or take those that reach down to a height {lower}")
    return found


class SolidDrawing(Drawing):
    """Values that a drawing of solids leaves open: see :func:`read_mesh` and :func:`read_compas`."""

    model_config = ConfigDict(title="solids as drawn")

    live: Vector = (0.0, 0.0, 0.0)

    def solid(self, mesh: Mesh, tolerance: float) -> Solid:
        """Return the solid of a closed mesh. Raises ValueError if it is open or has too many convex parts."""
        refuse_holes(mesh, tolerance)
        whole = polyhedron(mesh, tolerance)
        parts = [whole] if whole.convex(tolerance) else convex_parts(whole, tolerance)
        shape = _keys(parts[0]) if len(parts) == 1 else {"parts": [_keys(part) for part in parts]}
        loads: dict[str, Any] = {"unit_weight": self.unit_weight, "live_per_weight": self.live}
        return Solid(name=mesh.name, **shape, **({"fixed": True} if mesh.fixed else loads))


def _keys(shape: MeshSolid) -> dict[str, Any]:
    own = used("", shape.points, [side.rings[0] for side in shape.sides])
    return {"vertices": list(map(tuple, own.points.tolist())), "faces": own.faces}


def scene_in_space(meshes: Sequence[Mesh], drawing: SolidDrawing, path: Path) -> Scene:
    """The scene of closed meshes; a support of one face is the top of a slab. Raises ValueError if nothing
    can move, nothing is a support, or a block is no solid."""
    standing = [mesh.points for mesh in meshes if not mesh.fixed]
    if not standing:
        names = listed([mesh.name for mesh in meshes])
        raise ValueError(f"every block is a support: nothing can move (blocks: {names})")
    middle = np.concatenate(standing).mean(axis=0)
    tolerance = drawing.tolerance or _tolerance(standing)
    blocks = []
    for mesh in meshes:
        with naming(f"block '{mesh.name}'"):
            if mesh.flat and not mesh.fixed:
                raise ValueError("is a single face: give it a thickness, or make it a support")
            blocks.append(drawing.solid(_slab(mesh, middle) if mesh.flat else mesh, tolerance))
    return scene_of(blocks, drawing.replace(tolerance=tolerance), path)


def _slab(mesh: Mesh, standing: np.ndarray) -> Mesh:
    """A flat support with a thickness, on the other side than what stands on it."""
    (ring,) = mesh.faces
    top, area = mesh.points[ring], area_vector(mesh.points[ring])
    size = float(np.linalg.norm(area))
    if not size > 0:
        raise ValueError("is a face without area: take it away")
    towards = np.sign((standing - top.mean(axis=0)) @ area) or 1.0
    bottom = top - towards * _SLAB * area / np.sqrt(size)
    faces = prism(top.tolist(), bottom.tolist())["faces"]
    return replace(mesh, points=np.concatenate([top, bottom]), faces=faces)


def _tolerance(standing: Sequence[np.ndarray]) -> float:
    """Twice the last decimal of rounded coordinates, if little beside the blocks; else that of a scene."""
    points = np.concatenate(standing)
    usual = RELATIVE_TOLERANCE * float(np.linalg.norm(np.ptp(points, axis=0)))
    smallest = min(float(np.cbrt(np.prod(np.ptp(own, axis=0)))) for own in standing)
    for decimals in range(_MOST_DECIMALS + 1):
        unit = 10.0**-decimals
        if np.abs(points - np.round(points, decimals)).max() <= 1e-9 * np.abs(points).max():
            return max(usual, 2 * unit) if 2 * unit <= NEAR_MISS * smallest else usual
    return usual

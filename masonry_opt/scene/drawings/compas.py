"""COMPAS JSON to a scene: in space, or in the plane of prisms along one direction, seen along it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import shapely
from pydantic import ConfigDict

from masonry_opt.errors import CaseError
from masonry_opt.scene.blocks import Block, Number
from masonry_opt.scene.drawings import compas_data, stones
from masonry_opt.scene.drawings.meshes import Mesh, Side, area_vector, polyhedron
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tables import as_path, parse_file

_ONE_PLANE = 1e-4  #: Solids lie in one plane if their middles differ by no more, over the thickest of them.
_RELATIVE_TOLERANCE = 1e-5  #: Lengths that are nothing over a solid's size: corners in single precision.

#: Outlines of solids in the plane across a direction, and where they begin and end along it, (solids, 2).
_SideView = tuple[list[shapely.Polygon], np.ndarray]

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class CompasDrawing(stones.FlatDrawing):
    """Values that COMPAS data leaves open: see :func:`read_compas`."""

    model_config = ConfigDict(title="COMPAS data")

    along: tuple[Number, Number, Number] | None = None


def read_compas(
    path: str | Path,
    *,
    friction: float,
    unit_weight: float,
    live: Sequence[float] | None = None,
    fixed: Iterable[str] = (),
    fixed_below: float | None = None,
    space: bool | None = None,
    along: str | Sequence[float] | None = None,
    tolerance: float | None = None,
    contact_tolerance: float | None = None,
) -> Scene:
    """Read a scene from COMPAS JSON: an assembly, a block model, or a list of meshes or polygons.

    In the plane, solids must be prisms along one common level direction; they are projected along it on the
    plane across, with z upwards. Polygons are taken as they are; those in the plane z = constant with y
    upwards. In space blocks are whole, of any shape; a support of one face is the top of a slab.

    Raises CaseError if the file cannot be read, a block is no prism, the blocks make no scene, or ``along``
    is given of a scene in space; the message names the file and the block.

    Parameters
    ----------
    path: A ``.json`` file written by COMPAS (compas_assembly, compas_cra, compas_dem; new or old).
    friction: Of every joint, μ = tan φ.
    unit_weight: Of solids, weight per unit volume: a block's ``weight`` is that times area times its own
        thickness; of polygons, per unit area.
    live: Live force on every movable block as a multiple of its weight, ``[fx, fy]`` in the plane, or ``[fx,
        fy, fz]`` in space, at the centroid.
    fixed: Names of blocks that are supports, beside those whose node or block says ``is_support``. Blocks are
        named by their node; those of models and lists by their number, from 0.
    fixed_below: Blocks that reach down to this height z, or below, are supports too.
    space: Whether the scene is in space (default: if ``live`` has three numbers; or if it is not given, nor
        ``along``, and the blocks are no prisms of one wall).
    along: The direction of the prisms: "x", "y", "z" (for solids that were drawn lying down: y is then
        upwards), or three numbers. Default: the only level one along which all blocks are prisms with their
        middles in one plane. Where it is named the middles may differ, as long as one plane cuts all blocks;
        that eccentricity across the plane is left aside.
    tolerance: Length below which faces are flat and gaps are nothing (default: 1e-5 of a block's size for
        faces, and of gaps as in :class:`Scene`).
    contact_tolerance: In space: gap or overlap of faces up to which blocks touch, as in :class:`Scene`.
    """
    path = as_path(path, "such a drawing", ".json")
    data = parse_file(path)
    if space is None and live is not None:
        space = np.size(live) == 3
    if space and along is not None:
        raise CaseError(f"{path}: 'along' is of scenes in the plane: leave it out, or give a 'live' of two")
    given = locals() | {"along": _AXES.get(along, along) if isinstance(along, str) else along}
    supports = stones.Supports(fixed=list(fixed), fixed_below=fixed_below)
    with stones.naming(f"{path}:"):
        meshes = stones.with_supports(compas_data.meshes(data), supports)
        if not space:
            flat = CompasDrawing.of(given)
            try:
                seen = _seen(meshes, flat)
            except ValueError as error:
                if space is False or along is not None:
                    raise ValueError(f"{error}. Or read blocks whole: a 'live' of three numbers") from None
            else:
                return stones.scene_of(_blocks(meshes, seen, flat), flat, path)
        return stones.scene_in_space(meshes, stones.SolidDrawing.of(given), path)


def _seen(meshes: Sequence[Mesh], drawing: CompasDrawing) -> _SideView:
    """The solids seen along the direction that is asked for, or along the only one there is."""
    flat = all(mesh.flat for mesh in meshes)
    asked = drawing.along is not None
    if asked and not any(drawing.along or ()):
        raise ValueError("'along' needs a direction, such as y")
    sizes = [float(np.linalg.norm(np.ptp(mesh.points, axis=0))) for mesh in meshes]
    tolerances = [drawing.tolerance or _RELATIVE_TOLERANCE * size for size in sizes]
    solids, views, whys = list(map(_Prism, meshes, tolerances)), {}, []
    for direction in [np.array(drawing.along)] if asked else _directions(meshes):
        name = _said(direction)
        try:
            view = _seen_along(solids, direction)
            if not flat:
                _refuse_apart(meshes, view, asked)
            views[name] = view
        except ValueError as error:
            if asked:
                raise ValueError(f"'along' {name}: {error}") from None
            whys.append(f"along {name} {error}")
    if not views:
        raise ValueError(
            f"the blocks are not prisms of one wall: {'; '.join(whys[:3])}. Name the direction by 'along' if "
            "it is another, or their middles need not lie in one plane"
        )
    if len(views) > 1:
        raise ValueError(f"all blocks are prisms along {' and along '.join(views)}: say by 'along' which")
    return next(iter(views.values()))


def _refuse_apart(meshes: Sequence[Mesh], view: _SideView, asked: bool) -> None:
    """Raise ValueError if no plane cuts all blocks seen as was asked for, or others have no middle plane."""
    begin, end = view[1].T
    last, first = int(begin.argmax()), int(end.argmin())
    if asked and begin[last] >= end[first]:
        behind, before = meshes[last].name, meshes[first].name
        raise ValueError(f"block '{behind}' lies behind block '{before}': no plane cuts both")
    middle = (begin + end) / 2
    off = np.abs(middle - np.median(middle)) > _ONE_PLANE * max((end - begin).max(), 1e-300)
    if not asked and off.any():
        raise ValueError(
            f"block '{meshes[int(off.argmax())].name}' has its middle in another plane than most"
        )


def _said(direction: np.ndarray) -> str:
    for name, axis in _AXES.items():
        if np.allclose(np.cross(direction, axis), 0.0, atol=1e-9):
            return name
    return "[" + ", ".join(f"{part + 0.0:.4g}" for part in direction) + "]"


def _blocks(meshes: Sequence[Mesh], view: _SideView, drawing: CompasDrawing) -> list[Block]:
    blocks = []
    for mesh, outline, (begin, end) in zip(meshes, *view, strict=True):
        weight = drawing.unit_weight * outline.area * float(end - begin)
        keys = {} if mesh.flat else {"weight": weight, "unit_weight": None}
        blocks.append(drawing.block(mesh.name, outline, mesh.fixed, live_per_weight=drawing.live, **keys))
    return blocks


def _axes(direction: np.ndarray) -> np.ndarray:
    """Axes of the plane across a direction, shape (2, 3): z upwards is its second, or along z itself y.
    Raises ValueError if the direction is neither level nor z, so that weights do not act in the plane."""
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


def _directions(solids: Sequence[Mesh]) -> list[np.ndarray]:
    """Directions along which solids may be prisms: y, x, level normals of one's faces; of polygons also z."""
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
class _Prism:
    """A block, and the length that is nothing beside it."""

    mesh: Mesh
    tolerance: float

    @cached_property
    def sides(self) -> list[Side]:
        """Its plane sides, for all directions that it is looked at along."""
        return polyhedron(self.mesh, self.tolerance).sides


def _seen_along(solids: Sequence[_Prism], direction: np.ndarray) -> _SideView:
    """The solids as prisms along a direction. Raises ValueError, naming the block, if one is no prism along
    it."""
    plane = _axes(direction)
    unit = direction / np.linalg.norm(direction)
    outlines, reach = [], []
    flat = all(solid.mesh.flat for solid in solids)
    for solid in solids:
        if solid.mesh.flat and not flat:
            raise ValueError(f"block '{solid.mesh.name}' is a single face among solids: give it a thickness")
        with stones.naming(f"block '{solid.mesh.name}'"):
            outlines.append(_end(solid, plane, unit))
        along = solid.mesh.points @ unit
        reach.append((along.min(), along.max()))
    return outlines, np.array(reach)


def _end(solid: _Prism, plane: np.ndarray, unit: np.ndarray) -> shapely.Polygon:
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

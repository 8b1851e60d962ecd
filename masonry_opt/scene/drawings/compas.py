"""Read COMPAS JSON as a scene, in space, or in the plane if the blocks are prisms along one direction."""

import ast
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pydantic import ConfigDict

from masonry_opt.errors import CaseError
from masonry_opt.files import is_written_by_package
from masonry_opt.scene.blocks import Block, Number
from masonry_opt.scene.drawings import stones
from masonry_opt.scene.drawings.holes import refuse_holes
from masonry_opt.scene.drawings.meshes import Mesh, area_vector, polyhedron
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import box
from masonry_opt.scene.tables import as_path, parse_file

#: Largest distance between the middle planes of prisms in a plane scene, relative to the largest thickness.
#: A larger distance raises an error.
_PLANE_TOLERANCE = 1e-4

#: Default tolerance of lengths, relative to the size of a solid, for coordinates in single precision.
_RELATIVE_TOLERANCE = 1e-5

#: Outlines of solids projected along a direction, and thicknesses of the solids in this direction, shape
#: (solids,).
_SideView = tuple[list[shapely.Polygon], np.ndarray]

#: Description of a block: its key, its shape, True for a support, and its transformation or None.
_DrawnBlock = tuple[object, Any, bool, Any]

#: Unit vectors of the axes by their names.
_UNIT_VECTORS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
#: Keys of tables with the content of a COMPAS object. A table without any of these keys is a wrapper: the
#: content is the value of its key "data" (in old files "value").
_CONTENT = ("node", "graph", "elements", "assembly", "blocks", "model", "vertex", "vertices", "points")


class CompasDrawing(stones.FlatDrawing):
    """Values that the user specifies for COMPAS data, such as friction; see :func:`read_compas`."""

    model_config = ConfigDict(title="COMPAS data")

    along: tuple[Number, Number, Number] | None = None


def read_compas(  # noqa: PLR0913 - options of the public API are keywords
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

    In the plane, solids must be prisms along one common horizontal direction. They are projected along this
    direction, with z upwards. Polygons are not projected. If they lie in a plane z = constant, y is upwards.
    In space, blocks can have any shape. A support with a single face is replaced by a slab behind this face.

    Parameters
    ----------
    path: A ``.json`` file written by COMPAS (compas_assembly, compas_cra or compas_dem, in a new or old
        version).
    friction: Friction coefficient μ = tan φ of every joint.
    unit_weight: Weight per unit volume for solids: in the plane, the weight of a block is the unit weight
        times its area and its thickness. Weight per unit area for polygons.
    live: Live force on every movable block as a multiple of its weight, ``[fx, fy]`` in the plane, or ``[fx,
        fy, fz]`` in space, at the centroid.
    fixed: Names of blocks that are supports, in addition to blocks whose node or block has ``is_support``.
        The name of a block is the key of its node, or, in models and lists, its number, from 0.
    fixed_below: Blocks that reach down to this height z, or below, are supports too.
    space: True for a scene in space, False for a scene in the plane. By default the scene is in space if
        ``live`` has three numbers. If neither ``live`` nor ``along`` is given, the scene is in space if the
        blocks are not prisms of one wall.
    along: Direction of the prisms: "x", "y", "z" (for walls that were drawn lying down, with y upwards in the
        scene), or three numbers. The default is the only horizontal direction along which all blocks are
        prisms whose middle planes coincide. If a direction is given, the middle planes may differ, as long as
        one plane cuts all blocks. The analysis ignores this eccentricity.
    tolerance: Length below which faces count as flat and gaps are ignored. The default is 1e-5 of the size of
        a block for faces, and the default of :class:`Scene` for gaps.
    contact_tolerance: Largest gap or overlap of edges (in space: faces) that are in contact, such as the
        width of mortar that is not drawn. :class:`Scene` explains it.

    Returns
    -------
    Scene
        The scene, in the plane or in space.

    Raises
    ------
    CaseError
        If the file cannot be read, if a block is not a prism, if the blocks do not form a valid scene, or if
        ``along`` is given for a scene in space. The message names the file and the block.
    """
    path = as_path(path, "a COMPAS file", ".json")
    data = parse_file(path)
    if space is None and live is not None:
        space = np.size(live) == 3
    if space and along is not None:
        raise CaseError(
            f"{path}: 'along' applies only to scenes in the plane: "
            "omit 'along', or give 'live' two components"
        )
    values = locals() | {"along": _UNIT_VECTORS.get(along, along) if isinstance(along, str) else along}
    supports = stones.Supports(fixed=list(fixed), fixed_below=fixed_below)
    with stones.naming(f"{path}:"):
        is_exported = is_written_by_package(path)
        unmarked_meshes = [replace(mesh, is_exported=is_exported) for mesh in _meshes(data)]
        meshes = stones.with_supports(unmarked_meshes, supports)
        if not space:
            flat_drawing = CompasDrawing.of(values)
            try:
                view = _side_view(meshes, flat_drawing)
            except ValueError as error:
                if space is False or along is not None:
                    raise ValueError(
                        f"{error}. To read the blocks as solids in space, give 'live' three components"
                    ) from None
            else:
                return stones.scene_of(_blocks(meshes, view, flat_drawing), flat_drawing, path)
        return stones.scene_in_space(meshes, stones.SolidDrawing.of(values), path)


def _side_view(meshes: Sequence[Mesh], drawing: CompasDrawing) -> _SideView:
    """Project the solids along ``drawing.along``, or else along the only direction in which all are prisms.

    Raises ValueError if the solids are not prisms along the direction. Also raises ValueError if no direction
    is given and the solids are prisms along several directions.
    """
    if drawing.along is not None:
        if not any(drawing.along):
            raise ValueError("'along' is a zero vector: give a direction, such as y")
        direction = np.array(drawing.along)
        with stones.naming(f"'along' {_direction_name(direction)}:"):
            return _view_along(meshes, direction / np.linalg.norm(direction), drawing)
    views = {}
    failures = []
    for unit in _directions(meshes):
        try:
            views[_direction_name(unit)] = _view_along(meshes, unit, drawing)
        except ValueError as error:
            failures.append(f"along {_direction_name(unit)} {error}")
    if not views:
        raise ValueError(
            f"the blocks are not prisms of one wall: {'; '.join(failures[:3])}. "
            "If the wall has another direction or eccentric blocks, give the direction as 'along'"
        )
    if len(views) > 1:
        choices = " and along ".join(views)
        raise ValueError(f"all blocks are prisms along {choices}: choose a direction with 'along'")
    return next(iter(views.values()))


def _direction_name(direction: np.ndarray) -> str:
    """Return a direction as text: the name of an axis, or else the components."""
    for name, axis in _UNIT_VECTORS.items():
        if np.allclose(np.cross(direction, axis), 0.0, atol=1e-9):
            return name
    return "[" + ", ".join(f"{part + 0.0:.4g}" for part in direction) + "]"


def _blocks(meshes: Sequence[Mesh], view: _SideView, drawing: CompasDrawing) -> list[Block]:
    """Return the plane blocks of projected solids, with their weights and live loads."""
    blocks = []
    for mesh, outline, thickness in zip(meshes, *view, strict=True):
        weight = drawing.unit_weight * outline.area * float(thickness)
        keys = {} if mesh.flat else {"weight": weight, "unit_weight": None}
        blocks.append(drawing.block(mesh.name, outline, mesh.fixed, live_per_weight=drawing.live, **keys))
    return blocks


def _axes(unit: np.ndarray) -> np.ndarray:
    """Return the axes of the plane perpendicular to a direction, shape (2, 3).

    The second axis is z upwards, or y if the direction is z. Raises ValueError if the direction is neither
    horizontal nor z, because weights would not act in the plane.
    """
    if abs(abs(unit[2]) - 1) < 1e-9:
        return np.eye(3)[:2]
    if abs(unit[2]) > 1e-6:
        raise ValueError(
            "the direction is neither horizontal nor vertical, so weights would not act in the plane"
        )
    x_axis = np.cross(unit, (0.0, 0.0, 1.0))
    x_axis /= np.linalg.norm(x_axis)
    # View the solids so that x increases to the right (or y, if the view is along x).
    if x_axis[0] < -1e-9 or (abs(x_axis[0]) <= 1e-9 and x_axis[1] < 0):
        x_axis = -x_axis
    return np.array([x_axis + 0.0, [0.0, 0.0, 1.0]])


def _directions(solids: Sequence[Mesh]) -> list[np.ndarray]:
    """Return the candidates for the direction along which all solids are prisms.

    The candidates are y, x and the horizontal normals of the faces of the first solid, and for polygons also
    z.
    """
    x, y, z = np.eye(3)
    directions = [z, y, x] if all(solid.flat for solid in solids) else [y, x]
    for face in solids[0].faces[:100]:
        normal = area_vector(solids[0].points[face])
        size = float(np.linalg.norm(normal))
        is_new = all(np.linalg.norm(np.cross(normal, direction)) > 1e-6 * size for direction in directions)
        if abs(normal[2]) < 1e-6 * size and is_new:
            directions.append(normal / size)
    return directions


def _view_along(meshes: Sequence[Mesh], unit: np.ndarray, drawing: CompasDrawing) -> _SideView:
    """Return the outlines and thicknesses of solids that are prisms along a direction.

    Raises ValueError, with the name of the block, if a block is not a prism or is not in the common plane.
    """
    plane = _axes(unit)
    outlines = []
    is_flat = all(mesh.flat for mesh in meshes)
    for mesh in meshes:
        if mesh.flat and not is_flat:
            raise ValueError(
                f"block '{mesh.name}' is a single face, but other blocks are solids: draw this block with a "
                "thickness"
            )
        with stones.naming(f"block '{mesh.name}'"):
            outlines.append(_end_outline(mesh, drawing.tolerance, plane, unit))
    positions = [mesh.points @ unit for mesh in meshes]
    begin, end = np.array([(block_positions.min(), block_positions.max()) for block_positions in positions]).T
    if not is_flat and drawing.along is not None:
        if begin.max() >= end.min():
            rear, front = meshes[begin.argmax()].name, meshes[end.argmin()].name
            raise ValueError(
                f"no plane perpendicular to 'along' cuts all blocks, because block '{rear}' is entirely "
                f"behind block '{front}'"
            )
    elif not is_flat:
        middle = (begin + end) / 2
        is_off_plane = np.abs(middle - np.median(middle)) > _PLANE_TOLERANCE * (end - begin).max()
        if is_off_plane.any():
            name = meshes[is_off_plane.argmax()].name
            raise ValueError(f"block '{name}' does not have the same middle plane as most other blocks")
    return outlines, end - begin


def _end_outline(mesh: Mesh, tolerance: float | None, plane: np.ndarray, unit: np.ndarray) -> shapely.Polygon:
    """Return the outline of one end of a prism. Raises ValueError if the mesh is not a prism.

    Both ends of a prism have the same outline.
    """
    tolerance = tolerance or _RELATIVE_TOLERANCE * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    positions = mesh.points @ unit
    projection = mesh.points @ plane.T
    thickness = np.ptp(positions)
    if mesh.flat != (thickness <= tolerance):
        raise ValueError(
            "the block is a single face that is not perpendicular to the direction of projection"
            if mesh.flat
            else "the block has no thickness in the direction of projection"
        )
    if not mesh.flat:
        refuse_holes(mesh, tolerance)
    ends = []
    for side in sorted(polyhedron(mesh, tolerance).sides, key=lambda side: side.base @ unit):
        if np.ptp(positions[side.rings[0]]) <= tolerance:
            ends.append(
                shapely.Polygon(projection[side.rings[0]], [projection[ring] for ring in side.rings[1:]])
            )
        elif abs(side.normal @ unit) * thickness > tolerance:
            raise ValueError(
                "the block is not a prism: one of its faces is neither parallel nor perpendicular to the "
                "direction of projection"
            )
    if len(ends) != 2 - mesh.flat:
        raise ValueError(
            "the block is not a prism in the direction of projection: it has a step, lacks an end face, "
            "or has an end face in several parts"
        )
    if not all(end.is_valid for end in ends):
        raise ValueError("the block has a face that crosses itself: list the corners of the face in order")
    if shapely.area(shapely.symmetric_difference(ends[0], ends[-1])) > tolerance * ends[0].length:
        raise ValueError("the block is not a prism: its two end faces differ")
    return shapely.orient_polygons(ends[0])


def _meshes(data: Any) -> list[Mesh]:
    """Return the blocks of COMPAS data as meshes.

    The data is an assembly of compas_assembly or compas_cra, a block model of compas_dem, a problem that
    contains a block model, or a list of meshes, polyhedra, boxes or polygons. Raises ValueError if the data
    is of another kind, or if a block cannot be read.
    """
    meshes: dict[str, Mesh] = {}
    for key, shape, is_fixed, matrix in _drawn_blocks(data):
        name = stones.block_name(_key_text(key)) or "block"
        if name in meshes:
            raise ValueError(f"two blocks are named '{name}': rename one of them")
        try:
            points, faces = _faces(shape)
            meshes[name] = Mesh(name, _transform(points, matrix), faces, is_fixed)
        except (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError) as error:
            reason = "the block is not a mesh, polyhedron, box or polygon"
            if isinstance(error, CaseError):
                reason = str(error)
            message = reason.replace("the block", f"block '{name}'", 1)
            raise ValueError(f"{message}: remove the block, or draw it as a mesh") from None
    if not meshes:
        raise ValueError("the file contains no blocks")
    return list(meshes.values())


def _key_text(key: object) -> str:
    """Return the key of a block as text, without the quotes that COMPAS may add."""
    text = str(key)
    try:
        return str(ast.literal_eval(text)) if text[:1] in ("'", '"') else text
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return text.strip("'\"")


def _content(value: Any) -> Any:
    """Return the content of a COMPAS object, without the tables in which the content is wrapped."""
    while isinstance(value, dict) and not any(key in value for key in _CONTENT):
        content = value.get("data", value.get("value"))
        if content is None:
            break
        value = content
    return value


def _table(value: Any) -> dict[str, Any]:
    """Return the value if it is a table (dict), and otherwise an empty table."""
    return value if isinstance(value, dict) else {}


def _drawn_blocks(data: Any) -> Iterator[_DrawnBlock]:
    """Yield the blocks of an assembly, a model or a list, each described as a ``_DrawnBlock``.

    The assembly, model or list may be inside another object.
    """
    content = _content(data)
    if isinstance(content, list):
        yield from _blocks_in_list(content)
        return
    table = _table(content)
    blocks = table.get("blocks", table.get("courses"))
    if "model" in table:
        yield from _drawn_blocks(table["model"])
    elif isinstance(table.get("elements"), dict | list):
        yield from _blocks_in_model(table)
    elif "graph" in table:
        yield from _drawn_blocks(table["graph"])
    elif isinstance(table.get("node"), dict):
        for key, node in _sorted_entries(table["node"]):
            yield key, _table(node).get("block"), _is_support(node), None
    elif isinstance(table.get("blocks"), dict):
        yield from _blocks_in_assembly(table)
    elif isinstance(blocks, list):
        yield from _drawn_blocks(blocks)
    else:
        raise ValueError(
            "the file is not COMPAS data: "
            "it must contain an assembly, a model, or a list of meshes or polygons"
        )


def _blocks_in_list(items: list[Any]) -> Iterator[_DrawnBlock]:
    """Yield the blocks of a list and of its nested lists; the key of a block is its number, from 0."""
    for number, item in enumerate(_flatten(items)):
        attributes = _table(_content(item)).get("attributes")
        yield number, item, _is_support(attributes), None


def _blocks_in_model(model: dict[str, Any]) -> Iterator[_DrawnBlock]:
    """Yield the blocks of a block model; the key of a block is its number among all elements, from 0."""
    if model.get("transformation"):
        raise ValueError("the whole model has a transformation: apply the transformation before export")
    elements = model["elements"]
    for number, element in enumerate(elements.values() if isinstance(elements, dict) else elements):
        keys = _table(_table(element).get("data"))
        yield number, keys.get("geometry", keys.get("shape")), _is_support(keys), keys.get("transformation")


def _blocks_in_assembly(table: dict[str, Any]) -> Iterator[_DrawnBlock]:
    """Yield the blocks of an assembly that stores its blocks outside its graph."""
    assembly = _table(table.get("assembly"))
    nodes = _table(assembly.get("node", assembly.get("vertex")))
    for key, block in _sorted_entries(table["blocks"]):
        yield key, block, _is_support(nodes.get(key)), None


def _flatten(items: list[Any]) -> Iterator[Any]:
    """Yield the blocks of a list and of its nested lists, such as courses.

    A list of points is a polygon.
    """
    for item in items:
        is_list_of_blocks = isinstance(item, list) and all(map(_may_be_block, item))
        yield from _flatten(item) if is_list_of_blocks else [item]


def _may_be_block(value: Any) -> bool:
    """Return True if a value can describe a block: a table, or a list that is not a point."""
    content = _content(value)
    is_point = isinstance(content, list) and all(isinstance(number, int | float) for number in content)
    return isinstance(value, dict | list) and not is_point


def _is_support(attributes: Any) -> bool:
    """Return True if the attributes of a block mark it as a support."""
    return _table(attributes).get("is_support") is True


def _sorted_entries(table: dict[str, Any]) -> list[tuple[str, Any]]:
    """Return the entries of a table, sorted by their keys if all keys are numbers."""
    if all(re.fullmatch(r"[0-9]{1,9}", key) for key in table):
        return sorted(table.items(), key=lambda entry: int(entry[0]))
    return list(table.items())


def _faces(shape: Any) -> tuple[np.ndarray, list[list[int]]]:
    """Return the points and faces of a mesh, polyhedron, box or polygon. A polygon has one face."""
    shape = _content(shape)
    if isinstance(shape, list):
        return _polygon(shape)
    if "xsize" in shape:
        return _box(shape)
    if isinstance(shape.get("vertex"), dict):
        table = shape["vertex"]
        index = {key.strip("'\""): number for number, key in enumerate(table)}
        default = shape.get("default_vertex_attributes", shape.get("dva")) or {}
        points = [[corner.get(axis, default.get(axis, 0.0)) for axis in "xyz"] for corner in table.values()]
        faces = [[index[str(key).strip("'\"")] for key in face] for face in shape["face"].values() if face]
    elif "vertices" in shape:
        points, faces = shape["vertices"], [list(face) for face in shape["faces"]]
    else:
        return _polygon(shape["points"])
    corners = _coordinates(points)
    if not faces or any(len(face) < 3 or not 0 <= min(face) <= max(face) < len(corners) for face in faces):
        raise CaseError("the block has no faces, or a face with fewer than three valid corners")
    if len(faces) == 1:
        return corners[faces[0]], [list(range(len(faces[0])))]
    return corners, faces


def _box(shape: dict[str, Any]) -> tuple[np.ndarray, list[list[int]]]:
    """Return the corners and faces of a box that is given by its frame (origin at the centre) and sizes."""
    frame = _table(_content(shape["frame"]))
    point, x, y = _coordinates([_content(frame[key]) for key in ("point", "xaxis", "yaxis")])
    z = np.cross(x, y)
    half = [_coordinate(shape[key]) / 2 for key in ("xsize", "ysize", "zsize")]
    if not (z.any() and min(half) > 0):
        raise CaseError("the block is a box with a size of zero, or its frame has parallel axes")
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    unit = box("box", *((-size, size) for size in half), fixed=True).polyhedra[0]
    return point + unit.vertices @ np.array([x, np.cross(z, x), z]), unit.faces


def _polygon(points: list[Any]) -> tuple[np.ndarray, list[list[int]]]:
    """Return the corners of a polygon, and its single face."""
    corners = _coordinates([_content(point) for point in points])
    if len(corners) > 1 and (corners[0] == corners[-1]).all():
        corners = corners[:-1]
    if len(corners) < 3:
        raise CaseError("the block is a polygon with fewer than three corners")
    return corners, [list(range(len(corners)))]


def _coordinates(points: list[Any]) -> np.ndarray:
    """Return the coordinates of points, shape (points, 3). Points with two coordinates have z = 0."""
    rows = [tuple(map(_coordinate, point)) for point in points]
    if any(len(row) not in (2, 3) for row in rows):
        raise CaseError("the block has a corner that has neither two nor three coordinates")
    return np.array([(*row, 0.0)[:3] for row in rows])


def _coordinate(value: Any) -> float:
    """Return a coordinate as a number. Raises CaseError if the value is not a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= 1e30:
        raise CaseError("the block has a coordinate that is not a number")
    return float(value)


def _transform(points: np.ndarray, transformation: Any) -> np.ndarray:
    """Return the points of a block after applying its transformation, if it has one."""
    if transformation is None:
        return points
    matrix = np.array([[_coordinate(value) for value in row] for row in transformation["data"]["matrix"]])
    if matrix.shape != (4, 4) or not np.allclose(matrix[3], (0.0, 0.0, 0.0, 1.0)):
        raise CaseError("the block has a transformation that is not a 4 × 4 matrix")
    return points @ matrix[:3, :3].T + matrix[:3, 3]

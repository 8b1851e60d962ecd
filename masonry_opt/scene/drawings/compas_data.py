"""Blocks in COMPAS data: assemblies, block models, and lists of meshes or polygons."""

import ast
import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.scene.drawings.meshes import Mesh
from masonry_opt.scene.drawings.stones import block_name
from masonry_opt.scene.solids import box

#: Keys that a COMPAS object's own content has; everything round it is wrapping ("data", older "value").
_CONTENT = ("node", "graph", "elements", "assembly", "blocks", "model", "vertex", "vertices", "points")

_NO_DATA = "is no COMPAS data: it must hold an assembly, a model, or a list of meshes or polygons"


def meshes(data: Any) -> list[Mesh]:
    """Blocks that the content of a file holds: an assembly (of compas_assembly or compas_cra, new or old), a
    block model of compas_dem or a problem that holds one, or a list of meshes, polyhedra, boxes or polygons.
    Raises ValueError if it is none of these, or a block cannot be read; the message names the block."""
    found, seen = [], set()
    for key, shape, fixed, matrix in _blocks(data):
        name = block_name(_text(key)) or "block"
        if name in seen:
            raise ValueError(f"has two blocks '{name}': rename one")
        seen.add(name)
        try:
            points, faces = _faces(shape)
            found.append(Mesh(name, _moved(points, matrix), faces, fixed))
        except (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError) as error:
            why = str(error) if isinstance(error, CaseError) else "has no mesh, polyhedron or polygon"
            raise ValueError(f"block '{name}' {why}: take it away, or give it as a mesh") from None
    if not found:
        raise ValueError("holds no blocks")
    return found


def _text(key: object) -> str:
    """The text of a key, which COMPAS writes as Python does: in quotes."""
    text = str(key)
    try:
        return str(ast.literal_eval(text)) if text[:1] in ("'", '"') else text
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return text.strip("'\"")


def _content(value: Any) -> Any:
    """The inside of the wrapping of a COMPAS object."""
    while isinstance(value, dict) and not any(key in value for key in _CONTENT):
        inner = value.get("data", value.get("value"))
        if inner is None:
            break
        value = inner
    return value


def _table(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _blocks(data: Any) -> Iterator[tuple[object, Any, bool, Any]]:
    """Key, shape, whether it is a support, and transformation, of each block."""
    data = _content(data)
    if isinstance(data, list):
        for number, one in enumerate(_flattened(data)):
            yield number, one, _is_support(_table(_content(one)).get("attributes")), None
    elif not isinstance(data, dict):
        raise ValueError(_NO_DATA)
    elif "model" in data:
        yield from _blocks(data["model"])
    elif isinstance(data.get("elements"), dict | list):
        if data.get("transformation"):
            raise ValueError("has a model that is transformed as a whole: apply the transformation first")
        elements = data["elements"]
        for number, element in enumerate(elements.values() if isinstance(elements, dict) else elements):
            own = _table(_table(element).get("data"))
            yield number, own.get("geometry", own.get("shape")), _is_support(own), own.get("transformation")
    elif "graph" in data:
        yield from _blocks(data["graph"])
    elif isinstance(data.get("node"), dict):
        for key, node in _sorted(data["node"]):
            yield key, _table(node).get("block"), _is_support(node), None
    elif isinstance(data.get("blocks"), dict):
        assembly = _table(data.get("assembly"))
        nodes = _table(assembly.get("node", assembly.get("vertex")))
        for key, block in _sorted(data["blocks"]):
            yield key, block, _is_support(nodes.get(key)), None
    elif isinstance(blocks := data.get("blocks", data.get("courses")), list):
        yield from _blocks(blocks)
    else:
        raise ValueError(_NO_DATA)


def _flattened(items: list[Any]) -> Iterator[Any]:
    """Blocks of a list, or of lists in it, as courses are; a list of points is a polygon."""
    for item in items:
        if isinstance(item, list) and all(
            isinstance(one, dict | list) and not _is_point(one) for one in item
        ):
            yield from _flattened(item)
        else:
            yield item


def _is_point(value: Any) -> bool:
    inside = _content(value)
    return isinstance(inside, list) and all(isinstance(number, int | float) for number in inside)


def _is_support(attributes: Any) -> bool:
    return _table(attributes).get("is_support") is True


def _sorted(table: dict[str, Any]) -> list[tuple[str, Any]]:
    """By number, where all keys are numbers; else as they stand."""
    if all(re.fullmatch(r"[0-9]{1,9}", key) for key in table):
        return sorted(table.items(), key=lambda entry: int(entry[0]))
    return list(table.items())


def _faces(shape: Any) -> tuple[np.ndarray, list[list[int]]]:
    """Points and faces of a mesh or polyhedron; of a polygon one face."""
    shape = _content(shape)
    if isinstance(shape, list):
        return _polygon(shape)
    if "xsize" in shape:
        return _box(shape)
    if isinstance(shape.get("vertex"), dict):
        table = shape["vertex"]
        index = {key.strip("'\""): number for number, key in enumerate(table)}
        usual = shape.get("default_vertex_attributes", shape.get("dva")) or {}
        points = [[corner.get(axis, usual.get(axis, 0.0)) for axis in "xyz"] for corner in table.values()]
        faces = [[index[str(key).strip("'\"")] for key in face] for face in shape["face"].values() if face]
    elif "vertices" in shape:
        points, faces = shape["vertices"], [list(face) for face in shape["faces"]]
    else:
        return _polygon(shape["points"])
    corners = _numbers(points)
    if not faces or any(len(face) < 3 or not 0 <= min(face) <= max(face) < len(corners) for face in faces):
        raise CaseError("has no faces, or faces without corners")
    if len(faces) == 1:
        used = faces[0]
        return corners[used], [list(range(len(used)))]
    return corners, faces


def _box(shape: dict[str, Any]) -> tuple[np.ndarray, list[list[int]]]:
    """Corners and faces of a box, whose frame stands in its middle."""
    frame = _table(_content(shape["frame"]))
    point, x, y = _numbers([_content(frame[key]) for key in ("point", "xaxis", "yaxis")])
    z, half = np.cross(x, y), [_number(shape[key]) / 2 for key in ("xsize", "ysize", "zsize")]
    if not (z.any() and min(half) > 0):
        raise CaseError("is a box without extent, or whose frame has no two axes")
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    unit = box("box", *((-size, size) for size in half), fixed=True).polyhedra[0]
    return point + unit.vertices @ np.array([x, np.cross(z, x), z]), unit.faces


def _polygon(points: list[Any]) -> tuple[np.ndarray, list[list[int]]]:
    corners = _numbers([_content(point) for point in points])
    if len(corners) > 1 and (corners[0] == corners[-1]).all():
        corners = corners[:-1]
    if len(corners) < 3:
        raise CaseError("is a polygon of less than three corners")
    return corners, [list(range(len(corners)))]


def _numbers(points: list[Any]) -> np.ndarray:
    """Points in space, shape (points, 3); those of a plane get z = 0."""
    rows = [tuple(map(_number, point)) for point in points]
    if any(len(row) not in (2, 3) for row in rows):
        raise CaseError("has a corner of neither two nor three coordinates")
    return np.array([(*row, 0.0)[:3] for row in rows])


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= 1e30:
        raise CaseError("has a coordinate that is no number")
    return float(value)


def _moved(points: np.ndarray, transformation: Any) -> np.ndarray:
    """The points where the transformation of their block puts them."""
    if transformation is None:
        return points
    matrix = np.array([[_number(value) for value in row] for row in transformation["data"]["matrix"]])
    if matrix.shape != (4, 4) or not np.allclose(matrix[3], (0.0, 0.0, 0.0, 1.0)):
        raise CaseError("has a transformation that is no 4 × 4 matrix")
    return points @ matrix[:3, :3].T + matrix[:3, 3]

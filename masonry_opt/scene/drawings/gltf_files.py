"""Read glTF 2.0 files, binary (.glb) or text (.gltf), as meshes; one mesh for each node with a mesh."""

import base64
import binascii
import json
import os
import struct
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PureWindowsPath
from typing import Any
from urllib.parse import unquote

import numpy as np

from masonry_opt.errors import DrawingWarning, counted, printable
from masonry_opt.scene.drawings import stones
from masonry_opt.scene.drawings.meshes import Mesh, used
from masonry_opt.scene.mistakes import one_line
from masonry_opt.scene.tables import read_bytes

#: First four bytes of a binary glTF file, and the only supported version of glTF.
_HEADER = (b"glTF", 2)

#: Numpy types of the numbers in accessors, by the code ``componentType`` (glTF 2.0, section 3.6.2.2).
_COMPONENT_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}

#: Code of a primitive whose corners form separate triangles. Primitives of points or lines have other codes,
#: and are ignored.
_TRIANGLES = 4
#: glTF code of a mesh primitive (list of corners) that is a strip of triangles.
_STRIP = 5
#: glTF code of a mesh primitive (list of corners) that is a fan of triangles.
_FAN = 6
#: Codes of all primitives with triangles.
_TRIANGLE_MODES = (_TRIANGLES, _STRIP, _FAN)

#: Beginnings of the names of glTF extensions that do not change shapes. A file that requires only
#: extensions with such names can be read.
_SHAPELESS_EXTENSIONS = (
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_mesh_quantization",
    "EXT_texture_",
)

#: Largest total number of corners of all nodes. A file with more corners raises an error. Even a small file
#: may have more corners, because many nodes can refer to one mesh.
_MOST_GLTF_CORNERS = 5_000_000

#: Tolerance for the range of coordinates that a glTF file states, relative to the largest coordinate. If the
#: range of the coordinates in a .bin file differs by more, the .bin file belongs to another export. The
#: tolerance is larger than 5e-6, the error of a range that is written with six digits.
_RANGE_ERROR = 1e-5


def read_gltf(data: bytes, path: Path, largest: int) -> list[Mesh]:
    """Return the nodes of a glTF file that have a mesh, with their transformations applied.

    The name of a mesh is empty if neither its node nor the mesh of the file has a name. Only the nodes of the
    default scene are read. A DrawingWarning reports the number of other nodes whose mesh has triangles.

    Raises ValueError if the file is not valid, is compressed, or refers to a .bin file that is missing, is
    outside the folder, or does not belong to the file.

    Parameters
    ----------
    data : bytes
        Content of the file.
    path : Path
        Path of the file. Files with the corners (.bin) are read in its folder.
    largest : int
        Largest total size of the .bin files, in bytes.
    """
    try:
        content = _Gltf.of(data, path.parent, largest)
        meshes, unread = content.meshes()
    except (KeyError, IndexError, TypeError, AttributeError, OverflowError, struct.error, RecursionError):
        raise ValueError("the file is not valid glTF: a part is missing; export the blocks again") from None
    if unread:
        verb = "was" if unread == 1 else "were"
        warning = (
            f"{path}: {counted(unread, 'mesh', 'meshes')} outside the default scene of the file {verb} left "
            "out; to read all meshes, export the blocks in one scene"
        )
        warnings.warn(printable(warning), DrawingWarning, stacklevel=5)
    return meshes


@dataclass(frozen=True)
class _Gltf:
    """Content of a glTF file."""

    tree: dict[str, Any]  #: the JSON part of the file
    binary: bytes  #: the binary part of the file; empty in text files
    folder: Path  #: folder of the file, and of .bin files to which it refers
    largest: int  #: largest total size of the buffers, in bytes
    buffers: dict[int, bytes] = field(default_factory=dict)  #: buffers that were read, by number

    @classmethod
    def of(cls, data: bytes, folder: Path, largest: int) -> "_Gltf":
        """Divide a file into its JSON part and its binary part."""
        text, binary = data, b""
        if data[:4] == _HEADER[0]:
            version = struct.unpack_from("<I", data, 4)[0]
            if version != _HEADER[1]:
                raise ValueError(
                    f"the file has glTF version {version}, but only version {_HEADER[1]} can be read: "
                    "export the file in this version"
                )
            length = struct.unpack_from("<I", data, 12)[0]
            text, binary = data[20 : 20 + length], data[28 + length :]
        try:
            tree = json.loads(text)
        except ValueError as error:
            reason = str(error)[:200]
            raise ValueError(f"the file is not valid glTF: {reason}; export the blocks again") from None
        if not isinstance(tree, dict):
            raise ValueError(
                "the file is not valid glTF: the JSON part is not an object; export the blocks again"
            )
        extensions = tree.get("extensionsRequired", [])
        _refuse_extensions([name for name in extensions if not name.startswith(_SHAPELESS_EXTENSIONS)])
        return cls(tree, binary, folder, largest)

    def _entry(self, key: str, number: Any) -> dict[str, Any]:
        """Return the entry with the given index of a list in the file, such as ``nodes``.

        Raises IndexError if the list has no entry with this index.
        """
        if number < 0:  # a negative number would count from the end of the list
            raise IndexError
        entry: dict[str, Any] = self.tree[key][number]
        return entry

    def meshes(self) -> tuple[list[Mesh], int]:
        """Return one mesh for each node of the scene with triangles, and the number of unread meshes.

        The names of the parent nodes are the layers of a mesh. A mesh is unread if it has triangles, and its
        node is not in the default scene.
        """
        meshes = []
        corners = 0
        read = set()
        for number, node, matrix, layers in self._nodes():
            read.add(number)
            if "mesh" not in node:
                continue
            _refuse_extensions([name for name in node.get("extensions", {}) if "instancing" in name])
            mesh = self._entry("meshes", node["mesh"])
            _refuse_morphing(node, mesh)
            points, faces = self._corners_and_triangles(mesh["primitives"])
            corners += len(points)
            if corners > _MOST_GLTF_CORNERS:
                raise ValueError(f"the file has more than {_MOST_GLTF_CORNERS} corners: simplify the blocks")
            if faces:
                placed_points = points @ matrix[:3, :3].T + matrix[:3, 3]
                mesh_name = stones.block_name(str(node.get("name", mesh.get("name", ""))))
                meshes.append(used(mesh_name, placed_points, faces, stones.block_name(layers)))
        nodes = self.tree.get("nodes", [])
        unread = [
            node for number, node in enumerate(nodes) if number not in read and self._has_triangles(node)
        ]
        return meshes, len(unread)

    def _has_triangles(self, node: dict[str, Any]) -> bool:
        """Return True if the mesh of a node has triangles, not only points or lines."""
        if "mesh" not in node:
            return False
        primitives = self._entry("meshes", node["mesh"])["primitives"]
        return any(primitive.get("mode", _TRIANGLES) in _TRIANGLE_MODES for primitive in primitives)

    def _nodes(self) -> Iterator[tuple[int, dict[str, Any], np.ndarray, str]]:
        """Yield the number, node and transformation of each node of the scene, and the names above it."""
        nodes = self.tree.get("nodes", [])
        scenes = self.tree.get("scenes", [])
        roots = scenes[self.tree.get("scene", 0)].get("nodes", []) if scenes else range(len(nodes))
        # Store the nodes in reverse order, because the last entry of the queue is processed first.
        queue = [(int(number), np.eye(4), "") for number in reversed(roots)]
        visited: set[int] = set()
        while queue:
            number, parent_matrix, layers = queue.pop()
            if number in visited:
                raise ValueError(
                    "the file is not valid glTF: a node has two parents; export the blocks again"
                )
            visited.add(number)
            node = self._entry("nodes", number)
            try:
                matrix = parent_matrix @ _transformation(node)
            except ValueError:
                raise ValueError(
                    "the file is not valid glTF: a node has a wrong transformation; export the blocks again"
                ) from None
            yield number, node, matrix, layers
            child_layers = f"{layers} {node.get('name', '')}"
            queue += [(int(child), matrix, child_layers) for child in reversed(node.get("children", []))]

    def _corners_and_triangles(self, primitives: list[dict[str, Any]]) -> tuple[np.ndarray, list[list[int]]]:
        """Return the corners and the triangles of all primitives of a mesh."""
        corners: list[np.ndarray] = []
        faces: list[list[int]] = []
        first = 0
        for primitive in primitives:
            _refuse_extensions([name for name in primitive.get("extensions", {}) if "compression" in name])
            points = self._accessor_values(primitive["attributes"]["POSITION"], 3)
            order = np.arange(len(points))
            if "indices" in primitive:
                order = self._accessor_values(primitive["indices"], 1).ravel().astype(np.int64)
            if len(order) and not order.max() < len(points):
                raise ValueError(
                    "the file is not valid glTF: a face refers to a missing corner; export the blocks again"
                )
            faces += (first + _triangles_of(order, primitive.get("mode", _TRIANGLES))).tolist()
            corners.append(points)
            first += len(points)
        return np.concatenate(corners), faces

    def _accessor_values(self, number: int, columns: int) -> np.ndarray:
        """Return the array that an accessor of the file describes, shape (count, columns)."""
        accessor = self._entry("accessors", number)
        if "sparse" in accessor or "bufferView" not in accessor:
            raise ValueError(
                "the file has a sparse accessor, which cannot be read: export the blocks without shape keys, "
                "because shape keys may be written as sparse accessors"
            )
        view = self._entry("bufferViews", accessor["bufferView"])
        _refuse_extensions([name for name in view.get("extensions", {}) if "compression" in name])
        kind = np.dtype(_COMPONENT_TYPES[accessor["componentType"]])
        row = columns * kind.itemsize
        stride = view.get("byteStride", row)
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        count = accessor["count"]
        buffer = self._buffer(view["buffer"])
        if min(start, count) < 0 or stride < row or start + stride * (count - 1) + row > len(buffer):
            raise ValueError(
                "the file is not valid glTF: it is cut off, so corners are missing; export the blocks again"
            )
        numbers = np.ndarray((count, columns), kind, buffer, start, (stride, kind.itemsize)).astype(float)
        uri = self._entry("buffers", view["buffer"]).get("uri")
        if _is_bin(uri) and _is_out_of_range(numbers, accessor):
            name = one_line(unquote(str(uri)))
            raise ValueError(
                f"'{name}' does not belong to the file, because its coordinates differ from the range that "
                "the file states: export the blocks again, with a different name for each .bin file"
            )
        if accessor.get("normalized"):
            numbers = np.maximum(numbers / np.iinfo(kind).max, -1.0)
        return numbers

    def _buffer(self, number: int) -> bytes:
        """Return the content of a buffer; the first call reads it, and later calls reuse it."""
        if number not in self.buffers:
            self.buffers[number] = self._read_buffer(self._entry("buffers", number))
        return self.buffers[number]

    def _read_buffer(self, buffer: dict[str, Any]) -> bytes:
        """Return the bytes of a buffer: from the binary part of the file, its JSON, or a .bin file."""
        uri = buffer.get("uri")
        if uri is None:
            return self.binary
        if _is_bin(uri):
            return self._read_bin(uri, buffer["byteLength"])
        head, _, content = uri.partition(",")
        try:
            if head.lower().endswith(";base64"):
                return base64.b64decode(content, validate=True)
        except binascii.Error:
            pass
        raise ValueError("the file is not valid glTF: a buffer is not base64 text; export the blocks again")

    def _read_bin(self, uri: str, size: int) -> bytes:
        """Return the content of a .bin file, which must be in the folder of the glTF file or in a subfolder.

        ``size`` is the least number of bytes of the file.
        """
        # PureWindowsPath recognises drive letters, and both / and \ as separators, on every system.
        place = PureWindowsPath(unquote(uri))
        name = one_line(unquote(uri))
        if "://" in uri or place.anchor or ".." in place.parts:
            raise ValueError(
                f"the file refers to '{name}', which is not in its folder and was not read: "
                "export one .glb file, or a .gltf file with the .bin file in the same folder"
            )
        path = self.folder.joinpath(*place.parts)
        if not os.path.isfile(path):  # isfile is also False for a path that the system rejects
            raise ValueError(
                f"the file needs '{name}', which is missing: copy it into the folder of the file, "
                "or export one .glb file"
            )
        if path.stat().st_size + sum(map(len, self.buffers.values())) > self.largest:
            raise ValueError(
                f"the file needs more than {self.largest // 1_000_000} MB of .bin files: simplify the blocks"
            )
        content = read_bytes(path, self.largest, "simplify the blocks")
        if len(content) < size:
            raise ValueError(
                f"'{name}' is cut off: it has {len(content)} bytes instead of {size}: copy it again, "
                "or export one .glb file"
            )
        return content


def _refuse_extensions(names: list[str]) -> None:
    """Raise ValueError for extensions of glTF that cannot be read; the message names the first of them."""
    if names and "compression" in names[0]:
        raise ValueError(f"the file is compressed ({names[0]}): export without compression")
    if names:
        name = one_line(names[0])
        raise ValueError(f"the file has the glTF extension {name}, which cannot be read: export without it")


def _refuse_morphing(node: dict[str, Any], mesh: dict[str, Any]) -> None:
    """Raise ValueError if morph targets move the corners of a mesh.

    The standard adds the targets of a mesh, multiplied by the weights of its node, to its corners.
    """
    weights = node.get("weights", mesh.get("weights", []))
    if any(weights) and any(primitive.get("targets") for primitive in mesh["primitives"]):
        name = stones.block_name(str(node.get("name", "")))
        raise ValueError(
            f"morph targets (shape keys) change the shape of mesh '{name}': apply them before the export"
        )


def _is_bin(uri: Any) -> bool:
    """Return True if a buffer is in another file, whose path is ``uri``."""
    return uri is not None and uri[:5].lower() != "data:"


def _is_out_of_range(numbers: np.ndarray, accessor: dict[str, Any]) -> bool:
    """Return True if an accessor states a range of its numbers that differs from their actual range."""
    if "min" not in accessor or "max" not in accessor or not len(numbers):
        return False
    actual_range = np.array([numbers.min(axis=0), numbers.max(axis=0)])
    try:
        stated_range = np.array([accessor["min"], accessor["max"]], dtype=float).reshape(actual_range.shape)
    except ValueError:
        raise ValueError(
            "the file is not valid glTF: 'min' and 'max' of an accessor do not have one number for each "
            "coordinate; export the blocks again"
        ) from None
    return not (np.abs(actual_range - stated_range) <= _RANGE_ERROR * np.abs(stated_range).max()).all()


def _triangles_of(order: np.ndarray, mode: int) -> np.ndarray:
    """Return the corner indices of the triangles of a primitive, shape (triangles, 3).

    ``order`` has the corner indices in the order of the file. ``mode`` is the code that states how the
    corners form triangles. A primitive with any other code has no triangles.
    """
    if mode == _TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    if len(order) < 3 or mode not in (_STRIP, _FAN):
        return np.zeros((0, 3), dtype=np.int64)
    if mode == _FAN:
        return np.column_stack([np.full(len(order) - 2, order[0]), order[1:-1], order[2:]])
    strip = np.column_stack([order[:-2], order[1:-1], order[2:]])
    # Every second triangle of a strip has the opposite orientation: exchange two of its corners.
    strip[1::2] = strip[1::2, [1, 0, 2]]
    return strip


def _transformation(node: dict[str, Any]) -> np.ndarray:
    """Return the transformation of a node relative to its parent node, shape (4, 4).

    Raises ValueError if the transformation is wrong.
    """
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    quaternion = _vector(node, "rotation", (0.0, 0.0, 0.0, 1.0))
    length = float(np.linalg.norm(quaternion))
    if not length > 0:
        raise ValueError
    # Normalise the quaternion: a rounded quaternion is not a unit vector and would change the block's size.
    x, y, z, w = quaternion / length
    rotation = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix = np.eye(4)
    matrix[:3, :3] = np.array(rotation) * _vector(node, "scale", (1.0, 1.0, 1.0))
    matrix[:3, 3] = _vector(node, "translation", (0.0, 0.0, 0.0))
    return matrix


def _vector(node: dict[str, Any], key: str, default: tuple[float, ...]) -> np.ndarray:
    """Return a vector of a node, such as its scale, or the default if the node does not have the vector.

    Raises ValueError if the vector and the default have different numbers of components.
    """
    vector = np.array(node.get(key, default), dtype=float)
    if vector.shape != (len(default),):
        raise ValueError
    return vector

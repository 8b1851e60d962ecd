"""Read PLY files, text or binary, as one mesh whose polygons are not divided.

Other readers divide polygons into triangles and change their order. Then stones that touch can no longer be
separated by the order of their faces.
"""

import re
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from masonry_opt.scene.drawings import stones
from masonry_opt.scene.drawings.meshes import Mesh, used

#: Numpy types by the names of the PLY format. Each type has an old and a new name.
_NUMBER_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip

#: Byte order of numbers in numpy's notation, by the name of the format. It is empty for text files.
_BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

#: Versions of the PLY format, as written in the header. Files of both versions are read in the same way.
_VERSIONS = ("1.0", "1.1")

#: Names of the property of a face that lists its corners.
_CORNERS = ("vertex_indices", "vertex_index")

#: Reason of an error if a file has fewer values than its header states.
_CUT_OFF = "it is cut off, so corners or faces are missing"

#: Upper limit of whole numbers. Larger whole numbers are not exact in double precision.
_LARGEST_INTEGER = 2**53

#: Smallest number of corners of a face. Points and edges are not faces.
_FEWEST_CORNERS = 3


class _Property(NamedTuple):
    """Property that the header declares for an element: a single value or a list of values."""

    name: str
    kind: str  #: numpy type of the values
    count_kind: str = ""  #: numpy type of the number of values of a list; empty for a single value


@dataclass(frozen=True)
class _Element:
    """Element that the header declares, such as ``vertex``: its name, number of entries and properties."""

    name: str
    count: int  #: number of entries
    properties: list[_Property]

    def number_of(self, *names: str, is_list: bool = False) -> int:
        """Return the index of the property with one of the names. Raises ValueError if there is none."""
        for number, item in enumerate(self.properties):
            if item.name in names and bool(item.count_kind) == is_list:
                return number
        raise ValueError(f"element '{self.name}' has no property '{names[0]}'")


#: Values of an element: for each property an array of shape (entries, values), or a list with one array for
#: each entry if lists have different lengths.
_Columns = list[np.ndarray | list[np.ndarray]]


def read_ply(data: bytes) -> list[Mesh]:
    """Return a list with the unnamed mesh of a PLY file, or an empty list if the file has no faces.

    Raises ValueError if the file is not valid.
    """
    try:
        points, faces = _corners_and_faces(data)
    except ValueError as error:
        raise ValueError(f"the file is not valid PLY: {error}; save the mesh again") from None
    return [used("", points, faces)] if faces else []


def _corners_and_faces(data: bytes) -> tuple[np.ndarray, list[list[int]]]:
    """Return the corners and faces of a file. Raises ValueError with the reason if the file is not valid."""
    byte_order, elements, content = _divide(data)
    body: _Body = _Bytes(content, byte_order) if byte_order else _Words(content.split())
    points = np.zeros((0, 3))
    faces: list[list[int]] = []
    for element in elements:
        columns = body.columns(element)
        if element.name == "vertex" and element.count:
            axes = [columns[element.number_of(axis)] for axis in "xyz"]
            points = np.column_stack([np.asarray(axis, dtype=float) for axis in axes])
        elif element.name == "face" and element.count:
            corners = columns[element.number_of(*_CORNERS, is_list=True)]
            rings = corners if isinstance(corners, list) else corners.astype(int).tolist()
            faces = [[*map(int, ring)] for ring in rings if len(ring) >= _FEWEST_CORNERS]
    if faces and not 0 <= min(map(min, faces)) <= max(map(max, faces)) < len(points):
        raise ValueError("a face refers to a corner that does not exist")
    return points, faces


def _divide(data: bytes) -> tuple[str, list[_Element], bytes]:
    """Divide a file into its header and body. Return the byte order, the elements and the body."""
    end = re.search(rb"[\r\n]end_header[ \t]*(?:\r\n|\n|\r)", data)
    if not re.match(rb"ply\s", data) or end is None:
        raise ValueError("its header is missing")
    byte_order = None
    elements: list[_Element] = []
    for line in data[: end.start()].decode("utf-8", "replace").splitlines()[1:]:
        match line.split():
            case ["format", name, version] if version in _VERSIONS and name in _BYTE_ORDERS:
                byte_order = _BYTE_ORDERS[name]
            case ["element", name, count] if count.isascii() and count.isdigit() and len(count) < 16:
                elements.append(_Element(name, int(count), []))
            case ["property", "list", count, kind, name] if (
                elements and {count, kind} <= _NUMBER_TYPES.keys()
            ):
                elements[-1].properties.append(_Property(name, _NUMBER_TYPES[kind], _NUMBER_TYPES[count]))
            case ["property", kind, name] if elements and kind in _NUMBER_TYPES:
                elements[-1].properties.append(_Property(name, _NUMBER_TYPES[kind]))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise ValueError(f"its header has the wrong line '{stones.block_name(line)[:60]}'")
    if byte_order is None:
        raise ValueError("its header names no format")
    return byte_order, elements, data[end.end() :]


class _Body(ABC):
    """Values of a file after its header. They are read from the beginning to the end."""

    position = 0  #: index of the next value

    def columns(self, element: _Element) -> _Columns:
        """Return the values of an element, and move on to the next element."""
        if not element.count or not element.properties:
            return []
        start = self.position
        lengths = [len(values) for values in self._entry(element)]
        self.position = start
        columns = self._equal_entries(element, lengths)
        if columns is not None:
            return [*columns]
        entries = [self._entry(element) for _ in range(element.count)]
        return [list(column) for column in zip(*entries, strict=True)]

    def _entry(self, element: _Element) -> list[np.ndarray]:
        """Return the values of the next entry of an element, as one array for each property."""
        entry = []
        for item in element.properties:
            count = int(self._next_values(item.count_kind, 1)[0]) if item.count_kind else 1
            if count < 0:
                raise ValueError(f"a list has {count} values")
            entry.append(self._next_values(item.kind, count))
        return entry

    @abstractmethod
    def _next_values(self, kind: str, count: int) -> np.ndarray:
        """Return the next values of the body, of a given type. Raises ValueError if fewer values remain."""

    @abstractmethod
    def _equal_entries(self, element: _Element, lengths: list[int]) -> list[np.ndarray] | None:
        """Return all values of an element if every entry has lists of the given lengths, or else None.

        ``lengths`` contains the number of values of each property in the first entry; a single value has the
        length 1. The result is also None if the body is too short. The position moves on only if values are
        returned.
        """


@dataclass
class _Words(_Body):
    """Body of a text file, as words."""

    words: list[bytes]

    def _next_values(self, kind: str, count: int) -> np.ndarray:
        words = self.words[self.position : self.position + count]
        if len(words) < count:
            raise ValueError(_CUT_OFF)
        self.position += count
        return _numbers(words, kind)

    def _equal_entries(self, element: _Element, lengths: list[int]) -> list[np.ndarray] | None:
        is_list = [bool(item.count_kind) for item in element.properties]
        width = sum(lengths) + sum(is_list)
        end = self.position + element.count * width
        if end > len(self.words):
            return None
        columns = []
        first = self.position
        for item, length in zip(element.properties, lengths, strict=True):
            if item.count_kind:
                if (_numbers(self.words[first:end:width], item.count_kind) != length).any():
                    return None
                first += 1
            values = [_numbers(self.words[first + index : end : width], item.kind) for index in range(length)]
            columns.append(np.column_stack(values) if values else np.zeros((element.count, 0)))
            first += length
        self.position = end
        return columns


def _numbers(words: list[bytes], kind: str) -> np.ndarray:
    """Convert words to floating-point numbers.

    Raises ValueError if a word is not a number, or if ``kind`` is an integer type of numpy and a word is not
    a whole number of absolute value below ``_LARGEST_INTEGER``.
    """
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        is_number = np.array([_is_number(word) for word in words])
        raise ValueError(f"'{_first_wrong(words, is_number)}' is not a number") from None
    if kind[0] == "f":
        return numbers
    is_whole = numbers == np.round(numbers)
    if not is_whole.all():
        raise ValueError(
            f"'{_first_wrong(words, is_whole)}' is not a whole number, but its property has integer type"
        )
    is_small = np.abs(numbers) < _LARGEST_INTEGER
    if not is_small.all():
        raise ValueError(f"'{_first_wrong(words, is_small)}' is too large for an integer property")
    return numbers


def _first_wrong(words: list[bytes], is_right: np.ndarray) -> str:
    """Return the first word that is not right, as text for a message; ``is_right`` is a mask of the words."""
    return stones.block_name(words[int(np.argmin(is_right))].decode("utf-8", "replace"))[:60]


def _is_number(word: bytes) -> bool:
    """Return True if a word is a number."""
    try:
        float(word)
    except ValueError:
        return False
    return True


@dataclass
class _Bytes(_Body):
    """Body of a binary file."""

    data: bytes
    byte_order: str  #: byte order of its numbers, "<" or ">"

    def _next_values(self, kind: str, count: int) -> np.ndarray:
        number_type = np.dtype(self.byte_order + kind)
        if count * number_type.itemsize > len(self.data) - self.position:
            raise ValueError(_CUT_OFF)
        values = np.frombuffer(self.data, number_type, count, self.position)
        self.position += count * number_type.itemsize
        return values

    def _equal_entries(self, element: _Element, lengths: list[int]) -> list[np.ndarray] | None:
        fields: list[tuple[str, str, tuple[int, ...]]] = []
        for number, (item, length) in enumerate(zip(element.properties, lengths, strict=True)):
            if item.count_kind:
                fields.append((f"count {number}", self.byte_order + item.count_kind, ()))
            fields.append((f"values {number}", self.byte_order + item.kind, (length,)))
        entry = np.dtype(fields)
        if element.count * entry.itemsize > len(self.data) - self.position:
            return None
        table = np.frombuffer(self.data, entry, element.count, self.position)
        for number, (item, length) in enumerate(zip(element.properties, lengths, strict=True)):
            if item.count_kind and (table[f"count {number}"] != length).any():
                return None
        self.position += element.count * entry.itemsize
        return [table[f"values {number}"] for number in range(len(lengths))]

"""Blocks in space: records that are the Python interface and the schema of the case file alike."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Strict, Tag

from masonry_opt.scene.blocks import SHAPES, Block, Body, Name, NonNegative, Number, Point, Record, YesNo


def _list_of(count: int, entries: str) -> BeforeValidator:
    """Refuses other lists in words of its own: pydantic's would be those of the plane."""

    def checked(value: Any) -> Any:
        if not isinstance(value, list | tuple) or len(value) != count:
            raise ValueError(f"needs {entries}")
        return value

    return BeforeValidator(checked)


#: Chooses between two types, each marked with its ``Tag``, so that errors name only the one that was meant.
ONE_OR_SEVERAL = Discriminator(lambda value: "<several>" if isinstance(value, (list, tuple)) else "<one>")
Vector = Annotated[tuple[Number, Number, Number], _list_of(3, "three numbers, [x, y, z]")]
#: In the plane or in space, as the blocks of a scene are.
PlaneOrSpaceVector = Annotated[
    Annotated[Point, Tag("<plane>")] | Annotated[Vector, Tag("<space>")],
    Discriminator(lambda value: "<space>" if len(_entries(value)) > 2 else "<plane>"),
]
COORDINATES = {2: "two numbers, x, y", 3: "three numbers, x, y, z"}  #: What a point needs, by dimension.


def coordinates(given: Any, dimension: int) -> np.ndarray | None:
    """A point or direction, shape (dimension,); None if what is given is none."""
    try:
        vector = np.array(given, dtype=float)
    except (TypeError, ValueError):
        return None
    return vector if vector.shape == (dimension,) and np.isfinite(vector).all() else None


Interval = Annotated[tuple[Number, Number], _list_of(2, "two numbers, [from, to]")]
Box = Annotated[
    tuple[Interval, Interval, Interval], _list_of(3, "three intervals, [[x0, x1], [y0, y1], [z0, z1]]")
]
Face = Annotated[list[Annotated[int, Strict(), Field(ge=0)]], Field(min_length=3)]
Corners = Annotated[list[Vector], Field(min_length=4)]  #: Fewer, or fewer faces, enclose no volume.
FaceLists = Annotated[list[Face], Field(min_length=4)]
_VECTORS = ("live", "live_per_weight", "dead", "weight_at", "live_at", "dead_at")  #: Keys of a block.
#: Faces of a box, counter-clockwise seen from outside: bottom, top, front, right, back, left. Its corners go
#: counter-clockwise seen from above, those of the bottom first.
_BOX_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


class Polyhedron(NamedTuple):
    """Corners, shape (v, 3), and faces as lists of their indices, in order round each face."""

    vertices: np.ndarray
    faces: list[list[int]]


class Part(Record):
    """One of several convex parts of a solid, by ``vertices`` and ``faces``, or by a ``box``, as there.

    Raises CaseError if the shape is missing, doubled, or no shape.
    """

    vertices: Corners | None = None
    faces: FaceLists | None = None
    box: Box | None = None

    def _mistakes(self) -> Iterator[str]:
        if (self.vertices is None) == (self.box is None):
            yield f"give {SHAPES}"
        yield from _wrong_faces(self)


class Solid(Body):
    """One rigid block in space, or a fixed support.

    Lengths and forces are in any consistent units.

    Raises CaseError if a key is unknown, a value is no finite number, shape or weight are missing or doubled,
    or a face names a corner twice or one that there is not.

    Parameters
    ----------
    name: Unique within the scene.
    vertices, faces: Corners ``[[x, y, z], ...]``, and faces as lists of their indices, from 0, in order round
        each: all counter-clockwise from outside, or all clockwise (else turned so, with a warning).
    box: In place of them, ``[[x0, x1], [y0, y1], [z0, z1]]``.
    parts: In place of them, several convex :class:`Part` records that are one rigid block.
    weight: Dead weight, acting along the scene's gravity.
    unit_weight: Weight per unit volume, in place of ``weight``.
    weight_at: The point where the weight acts (default: the centroid).
    live, live_at: Live force ``[fx, fy, fz]``, scaled by λ, and where it acts (default: the centroid).
    live_per_weight: Beside it, a live force ``[fx, fy, fz]`` as a multiple of the weight, acting where that
        does.
    live_moment: Live moment ``[mx, my, mz]`` beside what the forces have, right-handed about the axes.
    dead, dead_at, dead_moment: Further dead force, where it acts (default: the centroid), and a dead moment.
    fixed: A support: it does not move and needs no weight.
    """

    LOADS: ClassVar[tuple[str, ...]] = ("live", "live_per_weight", "live_moment", "dead", "dead_moment")
    dimension: ClassVar[Literal[2, 3]] = 3

    name: Name
    vertices: Corners | None = None
    faces: FaceLists | None = None
    box: Box | None = None
    parts: Annotated[list[Part], Field(min_length=1)] | None = None
    weight: NonNegative | None = None
    unit_weight: NonNegative | None = None
    weight_at: Vector | None = None
    live: Vector = (0.0, 0.0, 0.0)
    live_at: Vector | None = None
    live_per_weight: Vector = (0.0, 0.0, 0.0)
    live_moment: Vector = (0.0, 0.0, 0.0)
    dead: Vector = (0.0, 0.0, 0.0)
    dead_at: Vector | None = None
    dead_moment: Vector = (0.0, 0.0, 0.0)
    fixed: YesNo = False

    def _mistakes(self) -> Iterator[str]:
        given = [shape for shape in (self.vertices, self.box, self.parts) if shape is not None]
        if len(given) != 1:
            yield f"give {'one' if given else 'a'} shape: {SHAPES}, or 'parts', several convex ones"
        yield from _wrong_faces(self)
        yield from super()._mistakes()

    @property
    def polyhedra(self) -> list[Polyhedron]:
        """Its parts, one if it is given by corners and faces or as a box."""
        shapes: Sequence[Part | Solid] = self.parts or [self]
        return [_polyhedron(shape) for shape in shapes]

    def corners(self) -> np.ndarray:
        """Corners of its parts, shape (corners, 3)."""
        return np.concatenate([part.vertices for part in self.polyhedra])


def _is_solid(value: Any) -> bool:
    """Whether a record, or a table of keys, means a block in space."""
    if not isinstance(value, Mapping):
        return isinstance(value, Solid)
    if not value.keys().isdisjoint({"box", "faces", "live_moment", "dead_moment"}):
        return True
    shape = value.get("vertices", value.get("parts"))
    if shape is None:  # which is to be told of the kind that its forces and points are of
        return any(_numbers(value.get(key)) == 3 for key in _VECTORS)
    return any(isinstance(part, Part | Mapping) for part in _entries(shape)) or _numbers(shape) == 3


def _numbers(value: Any) -> int:
    """Entries of the first list of numbers in nested ones."""
    entries = _entries(value)
    for _ in range(2):
        entries = _entries(entries[0]) or entries if entries else entries
    return len(entries)


def _entries(value: Any) -> Sequence[Any]:
    return value if isinstance(value, list | tuple) else ()


#: A block of either kind, told apart by its keys, so that errors name only those of the kind that was meant.
AnyBlock = Annotated[
    Annotated[Block, Tag("<block>")] | Annotated[Solid, Tag("<solid>")],
    Discriminator(lambda value: "<solid>" if _is_solid(value) else "<block>"),
]


def box(
    name: str, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], **keys: Any
) -> Solid:
    """A block with faces square to the axes, between two values of each coordinate; ``keys`` are the other
    parameters of :class:`Solid`: weight, loads, ``fixed``. Raises CaseError if a value is wrong."""
    return Solid(name=name, box=(x, y, z), **keys)


def prism(front: Sequence[Sequence[float]], back: Sequence[Sequence[float]]) -> dict[str, Any]:
    """``vertices`` and ``faces`` between polygons in one order, the front counter-clockwise from outside."""
    count = len(front)
    sides = [[i, count + i, count + j, j] for i, j in ((i, (i + 1) % count) for i in range(count))]
    faces = [list(range(count)), list(range(2 * count - 1, count - 1, -1)), *sides]
    return {"vertices": [*front, *back], "faces": faces}


def _wrong_faces(shape: Part | Solid) -> Iterator[str]:
    """What is wrong with the faces or the box of a shape, of which there is one kind."""
    if shape.vertices is not None and shape.faces is None:
        yield "'vertices' of a solid need 'faces', lists of their numbers round each face (or give a 'box')"
    if shape.faces is not None and shape.vertices is None:
        yield "'faces' go with 'vertices' alone: take them away"
    for axis, (low, high) in zip("xyz", shape.box or (), strict=False):
        if not low < high:
            yield f"'box' has no extent along {axis}: give rising numbers (found [{low:g}, {high:g}])"
    count = len(shape.vertices or ())
    for number, face in enumerate(shape.faces or (), start=1):
        if beyond := [index for index in face if index >= count]:
            yield f"face no. {number} has a corner {beyond[0]}; there are 'vertices' 0 to {count - 1}"
        if len(set(face)) < len(face):
            yield f"face no. {number} has a corner twice: 'faces' have each once, in order round the face"


def _polyhedron(shape: Part | Solid) -> Polyhedron:
    if shape.box is None:
        return Polyhedron(np.array(shape.vertices, dtype=float), [list(face) for face in shape.faces or ()])
    (x0, x1), (y0, y1), (z0, z1) = shape.box
    corners = [(x, y, z) for z in (z0, z1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    return Polyhedron(np.array(corners, dtype=float), [list(face) for face in _BOX_FACES])

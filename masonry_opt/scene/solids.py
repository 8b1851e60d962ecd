"""Define blocks in space: records that are both the Python interface and the schema of case files."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Strict, Tag

from masonry_opt.scene.blocks import SHAPES, Block, Body, Name, NonNegative, Number, Point, Record, YesNo


def _as_list(value: Any) -> Any:
    """Return the entries of a NumPy array as a list of Python numbers or lists; return other values as is."""
    return value.tolist() if isinstance(value, np.ndarray) else value


def _list_of(count: int, entries: str) -> BeforeValidator:
    """Return a validator that accepts only lists and arrays of ``count`` entries.

    Its error message is ``needs {entries}``, because the default message for short lists describes vectors in
    the plane.
    """

    def checked(value: Any) -> Any:
        value = _as_list(value)
        if not isinstance(value, list | tuple) or len(value) != count:
            raise ValueError(f"needs {entries}")
        return value

    return BeforeValidator(checked)


#: Function by which pydantic decides if an input is a single value or a list of values. Error messages then
#: refer to only one of these two types.
ONE_OR_SEVERAL = Discriminator(lambda value: "<several>" if isinstance(value, (list, tuple)) else "<one>")
Vector = Annotated[tuple[Number, Number, Number], _list_of(3, "three numbers, [x, y, z]")]
#: A vector with two components in plane scenes and three components in space.
PlaneOrSpaceVector = Annotated[
    Annotated[Point, Tag("<plane>")] | Annotated[Vector, Tag("<space>")],
    Discriminator(lambda value: "<space>" if len(_entries(value)) > 2 else "<plane>"),
]
#: Map from the dimension to the description of a point's coordinates in error messages.
COORDINATES = {2: "two numbers, x, y", 3: "three numbers, x, y, z"}


def coordinates(value: Any, dimension: int) -> np.ndarray | None:
    """Convert a value to a vector of finite numbers, shape (dimension,), or return None if impossible."""
    try:
        vector = np.array(value, dtype=float)
    except (TypeError, ValueError):
        return None
    return vector if vector.shape == (dimension,) and np.isfinite(vector).all() else None


Interval = Annotated[tuple[Number, Number], _list_of(2, "two numbers, [from, to]")]
Box = Annotated[
    tuple[Interval, Interval, Interval], _list_of(3, "three intervals, [[x0, x1], [y0, y1], [z0, z1]]")
]
Face = Annotated[list[Annotated[int, Strict(), Field(ge=0)]], BeforeValidator(_as_list), Field(min_length=3)]
#: Corners of a solid: at least four, because fewer corners enclose no volume.
Corners = Annotated[list[Vector], Field(min_length=4)]
#: Faces of a solid: at least four, because fewer faces enclose no volume.
FaceLists = Annotated[list[Face], Field(min_length=4)]
#: Keys of a block whose values are vectors.
_VECTOR_KEYS = ("live", "live_per_weight", "dead", "weight_at", "live_at", "dead_at")
#: Corner indices of the faces of a box, counter-clockwise seen from outside: bottom, top, front, right, back,
#: left. Corners 0 to 3 are at the bottom and 4 to 7 at the top, counter-clockwise seen from above.
_BOX_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


class Polyhedron(NamedTuple):
    """Polyhedron: corners, shape (corners, 3), and for each face the corner indices along its outline."""

    vertices: np.ndarray
    faces: list[list[int]]


class Part(Record):
    """One convex part of a solid with several parts.

    Parameters
    ----------
    vertices, faces: Corners ``[[x, y, z], ...]``, and faces as lists of their indices, as in :class:`Solid`.
    box: In place of vertices and faces, intervals ``[[x0, x1], [y0, y1], [z0, z1]]``.

    Raises
    ------
    CaseError
        If the shape is missing, given twice or not valid.
    """

    vertices: Corners | None = None
    faces: FaceLists | None = None
    box: Box | None = None

    def _mistakes(self) -> Iterator[str]:
        if (self.vertices is None) == (self.box is None):
            yield f"a part needs exactly one shape: {SHAPES}"
        yield from _wrong_faces(self)


class Solid(Body):
    """Rigid block in space, or a fixed support.

    Lengths and forces are in any consistent units.

    Parameters
    ----------
    name: Name of the block, unique within the scene.
    vertices, faces: Corners ``[[x, y, z], ...]``, and faces as lists of their indices, from 0, in order round
        each face: all counter-clockwise seen from outside, or all clockwise. Faces in mixed directions are
        turned, with a warning.
    box: In place of vertices and faces, intervals ``[[x0, x1], [y0, y1], [z0, z1]]``.
    parts: In place of one shape, several convex :class:`Part` records that are one rigid block.
    weight: Weight of the block, a dead load along the scene's gravity.
    unit_weight: Weight per unit volume, in place of ``weight``.
    weight_at: Point of application of the weight (default: the centroid).
    live, live_at: Live force ``[fx, fy, fz]``, which the load factor multiplies, and its point of application
        (default: the centroid).
    live_per_weight: Further live force ``[fx, fy, fz]`` as a multiple of the weight, applied at the same
        point as the weight.
    live_moment: Live moment ``[mx, my, mz]`` in addition to the moments of the forces, right-handed about the
        axes.
    dead, dead_at, dead_moment: Further dead force, its point of application (default: the centroid), and a
        further dead moment.
    fixed: True for a support, which does not move and needs no weight.

    Raises
    ------
    CaseError
        If a key is unknown, a value is not a finite number, the shape or the weight is missing or given
        twice, or a face names a corner twice or a corner that does not exist.
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
        shapes = [shape for shape in (self.vertices, self.box, self.parts) if shape is not None]
        if len(shapes) != 1:
            yield f"a solid needs exactly one shape: {SHAPES}, or 'parts' for several convex shapes"
        yield from _wrong_faces(self)
        yield from super()._mistakes()

    @property
    def polyhedra(self) -> list[Polyhedron]:
        """Convex parts of the solid. A solid without ``parts`` is a single polyhedron."""
        shapes: Sequence[Part | Solid] = self.parts or [self]
        return [_polyhedron(shape) for shape in shapes]

    def corners(self) -> np.ndarray:
        """Return the corners of all parts of the solid, shape (corners, 3)."""
        return np.concatenate([part.vertices for part in self.polyhedra])


def _is_solid(value: Any) -> bool:
    """Return True if a block record, or the table of a block in a case file, describes a block in space."""
    if not isinstance(value, Mapping):
        return isinstance(value, Solid)
    if not value.keys().isdisjoint({"box", "faces", "live_moment", "dead_moment"}):
        return True
    shape = value.get("vertices", value.get("parts"))
    # Without a shape, vectors with three components show that a solid is intended.
    if shape is None:
        return any(_coordinate_count(value.get(key)) == 3 for key in _VECTOR_KEYS)
    return any(isinstance(part, Part | Mapping) for part in _entries(shape)) or _coordinate_count(shape) == 3


def _coordinate_count(value: Any) -> int:
    """Return the number of coordinates of a point, or of the first point in nested lists of points."""
    entries = _entries(value)
    for _ in range(2):
        inner_entries = _entries(entries[0]) if entries else ()
        entries = inner_entries or entries
    return len(entries)


def _entries(value: Any) -> Sequence[Any]:
    """Return a value if it is a list or tuple, and an empty tuple otherwise."""
    return value if isinstance(value, list | tuple) else ()


#: Block in the plane or in space. Its keys select one of the two types, so that error messages name only keys
#: of this type.
AnyBlock = Annotated[
    Annotated[Block, Tag("<block>")] | Annotated[Solid, Tag("<solid>")],
    Discriminator(lambda value: "<solid>" if _is_solid(value) else "<block>"),
]


def box(
    name: str, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], **keys: Any
) -> Solid:
    """Return a rectangular block with edges parallel to the axes, given by an interval on each axis.

    Parameters
    ----------
    name: Name of the block, unique within the scene.
    x, y, z: Smallest and largest coordinate of the block on each axis.
    **keys: Other parameters of :class:`Solid`, such as weight, loads and ``fixed``.

    Returns
    -------
    Solid
        The block.

    Raises
    ------
    CaseError
        If a value is not valid.
    """
    return Solid(name=name, box=(x, y, z), **keys)


def prism(front: Sequence[Sequence[float]], back: Sequence[Sequence[float]]) -> dict[str, Any]:
    """Return the keys ``vertices`` and ``faces`` of the prism between two polygons.

    Corresponding corners of the two polygons have equal indices. The corners of the front polygon are
    counter-clockwise, seen from outside.
    """
    count = len(front)
    sides = []
    for i in range(count):
        j = (i + 1) % count
        sides.append([i, count + i, count + j, j])
    faces = [list(range(count)), list(range(2 * count - 1, count - 1, -1)), *sides]
    return {"vertices": [*front, *back], "faces": faces}


def _wrong_faces(shape: Part | Solid) -> Iterator[str]:
    """Generate an error message for each mistake in the faces or the box of a solid."""
    if shape.vertices is not None and shape.faces is None:
        yield (
            "a solid with 'vertices' needs 'faces': list the corner indices of each face in order along its "
            "outline, or give a 'box'"
        )
    if shape.faces is not None and shape.vertices is None:
        yield "'faces' need 'vertices': remove 'faces', or add 'vertices'"
    for axis, (low, high) in zip("xyz", shape.box or (), strict=False):
        if not low < high:
            yield f"'box' has no extent along {axis}: give two increasing numbers (found [{low:g}, {high:g}])"
    count = len(shape.vertices or ())
    for number, face in enumerate(shape.faces or (), start=1):
        wrong_indices = [index for index in face if index >= count]
        if wrong_indices:
            yield (
                f"face no. {number} names corner {wrong_indices[0]}, "
                f"but the 'vertices' are numbered from 0 to {count - 1}"
            )
        if len(set(face)) < len(face):
            yield f"face no. {number} in 'faces' names a corner twice: list each corner once, in order"


def _polyhedron(shape: Part | Solid) -> Polyhedron:
    """Return the corners and faces of a solid's shape."""
    if shape.box is None:
        return Polyhedron(np.array(shape.vertices, dtype=float), [list(face) for face in shape.faces or ()])
    (x0, x1), (y0, y1), (z0, z1) = shape.box
    corners = [(x, y, z) for z in (z0, z1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    return Polyhedron(np.array(corners, dtype=float), [list(face) for face in _BOX_FACES])

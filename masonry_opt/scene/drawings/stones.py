"""Make scenes of drawn blocks: supports, weights and loads, in the plane or in space."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
import shapely
from pydantic import ConfigDict

from masonry_opt.errors import CaseError, DrawingWarning, listed, printable, shortened
from masonry_opt.scene.blocks import Block, Name, NonNegative, Number, Positive, Record
from masonry_opt.scene.drawings.convex_parts import convex_solids
from masonry_opt.scene.drawings.holes import least_width, refuse_holes
from masonry_opt.scene.drawings.meshes import Mesh, MeshSolid, area_vector, used, with_one_face
from masonry_opt.scene.drawings.surfaces import count_outer_surfaces, without_back_faces
from masonry_opt.scene.geometry import NEAR_MISS, RELATIVE_TOLERANCE
from masonry_opt.scene.joints import Friction, JointDefaults
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import PlaneOrSpaceVector, Solid, Vector, prism
from masonry_opt.scene.space.shapes import shapes
from masonry_opt.scene.tolerance_advice import too_thin_for

#: Largest number of characters in the name of a block. Longer names are shortened.
_LONGEST_NAME = 200

#: Largest number of mistakes of a drawing that one error message lists; further mistakes are only counted.
_MOST_LINES = 20

#: Largest number of names of blocks or layers that a message lists; the remaining names are only counted.
_MOST_NAMES = 10

#: Words that mark supports: a block is a support if the name of its layer or object contains one of these
#: words.
SUPPORT_WORDS = ("fixed", "support")

#: Largest number of decimal places that is tested to detect rounded coordinates. Coordinates with more
#: decimal places count as not rounded.
_MOST_DECIMALS = 7

#: Thickness of the slab that replaces a support that is drawn as a single face or line, relative to the
#: square root of the face's area or to the length of the line.
SLAB_THICKNESS = 0.1


class Drawing(Record):
    """Values for blocks and joints that the user specifies because a drawing does not contain them."""

    friction: Friction
    unit_weight: NonNegative
    tolerance: Positive | None = None
    contact_tolerance: Positive | None = None

    @classmethod
    def of(cls, arguments: Mapping[str, Any]) -> Self:
        """Create the record from the arguments of a read function, without None and unknown arguments."""
        return cls(**{key: arguments[key] for key in cls.model_fields if arguments.get(key) is not None})


class FlatDrawing(Drawing):
    """Values that the user specifies for a plane drawing; see :func:`read_dxf` and :func:`read_compas`."""

    live: PlaneOrSpaceVector = (0.0, 0.0)

    def block(self, name: str, outline: shapely.Polygon, fixed: bool, **keys: Any) -> Block:
        """Return a block with the outline and the holes of a polygon.

        A support has no loads. Any other block has the drawing's unit weight, which ``keys`` may override.
        """
        rings = outline.exterior, *outline.interiors
        outer_ring, *holes = (shapely.get_coordinates(ring)[:-1].tolist() for ring in rings)
        loads = {"unit_weight": self.unit_weight} | keys
        return Block(name=name, vertices=outer_ring, holes=holes, **({"fixed": True} if fixed else loads))


def block_name(text: str) -> str:
    """Convert a text to a block name: one line of printable characters, of limited length.

    The name is empty if the text has no printable characters.
    """
    return " ".join(printable(" ".join(text.split())).split())[:_LONGEST_NAME]


@contextmanager
def naming(prefix: str) -> Iterator[None]:
    """Convert a ValueError to a CaseError, and begin each line of its message with the ``prefix``.

    ``prefix`` replaces the words "the block" at the beginning of a line, as in "block 'A' is not closed".
    """
    try:
        yield
    except ValueError as error:
        lines = str(error).splitlines()
        raise CaseError(
            "\n".join(
                line if line.startswith(prefix) else f"{prefix} {line.removeprefix('the block ')}"
                for line in lines
            )
        ) from None


def refuse(mistakes: Sequence[str]) -> None:
    """Raise ValueError with a list of the first mistakes, one per line, if there are any mistakes."""
    if mistakes:
        raise ValueError("\n".join(shortened(mistakes, _MOST_LINES, "mistake")))


def scene_of(blocks: Sequence[Block | Solid], drawing: Drawing, path: Path) -> Scene:
    """Return the scene of a drawing's blocks. Raises CaseError if the scene is not valid."""
    return Scene(
        source=f"drawn in {block_name(path.name)}",
        joints=JointDefaults(friction=drawing.friction),
        blocks=list(blocks),
        tolerance=drawing.tolerance,
        contact_tolerance=drawing.contact_tolerance,
    ).read_from(path)


class Supports(Record):
    """Blocks that the user marks as supports; see :func:`read_mesh` and :func:`read_compas`."""

    fixed: list[Name] = []
    fixed_below: Number | None = None


class AsDrawn(Supports):
    """Layers of supports, upward axis and scale of a mesh file; see :func:`read_mesh`."""

    fixed_layers: list[Name] = list(SUPPORT_WORDS)
    up: Literal["x", "y", "z"] | None = None
    scale: Positive = 1.0


def listed_names(names: Sequence[str]) -> str:
    """Return a text for messages with the first names, and the number of the others."""
    return listed(names, _MOST_NAMES)


def with_supports(meshes: Sequence[Mesh], supports: Supports, words: Sequence[str] = ()) -> list[Mesh]:
    """Return the meshes after marking the blocks that are supports.

    A block is a support if it is drawn as a support, if ``supports`` has its name, if it reaches down to the
    height that ``supports`` gives, or if its name or layers contain one of the words. Raises ValueError if no
    block has a name in ``supports``, or if no block is a support.
    """
    names = [mesh.name for mesh in meshes]
    unknown_names = [name for name in supports.fixed if name not in names]
    if unknown_names:
        raise ValueError(f"'fixed': no block is named '{unknown_names[0]}' (blocks: {listed_names(names)})")
    height_limit = -np.inf if supports.fixed_below is None else supports.fixed_below
    lowest_points = [float(mesh.points[:, 2].min()) for mesh in meshes]
    marked_meshes = []
    for mesh, low in zip(meshes, lowest_points, strict=True):
        text = f"{mesh.name} {mesh.layers}".casefold()
        is_named = mesh.name in supports.fixed or any(word.casefold() in text for word in words)
        marked_meshes.append(replace(mesh, fixed=mesh.fixed or is_named or low <= height_limit))
    if not any(mesh.fixed for mesh in marked_meshes):
        raise ValueError(
            f"no block is a support: name the supports with 'fixed' (blocks: {listed_names(names)}), "
            "or set 'fixed_below' to a height, so that all blocks whose lowest corner is not above this "
            f"height become supports (the lowest corner of all blocks is at z = {min(lowest_points):.6g})"
        )
    return marked_meshes


class SolidDrawing(Drawing):
    """Values that the user specifies for drawn solids; see :func:`read_mesh` and :func:`read_compas`."""

    model_config = ConfigDict(title="solids as drawn")

    live: Vector = (0.0, 0.0, 0.0)

    def solid(self, mesh: Mesh, tolerance: float) -> Solid:
        """Return the solid of a mesh.

        Raises ValueError if the mesh is open or needs too many convex parts.
        """
        refuse_holes(mesh, tolerance)
        parts = convex_solids(mesh, tolerance)
        shape = _shape_keys(parts[0]) if len(parts) == 1 else {"parts": [_shape_keys(part) for part in parts]}
        loads: dict[str, Any] = {"unit_weight": self.unit_weight, "live_per_weight": self.live}
        return Solid(name=mesh.name, **shape, **({"fixed": True} if mesh.fixed else loads))


def _shape_keys(shape: MeshSolid) -> dict[str, Any]:
    """Return the case-file keys ``vertices`` and ``faces`` of a convex solid or part."""
    mesh = used("", shape.points, [side.rings[0] for side in shape.sides])
    return {"vertices": list(map(tuple, mesh.points.tolist())), "faces": mesh.faces}


def scene_in_space(meshes: Sequence[Mesh], drawing: SolidDrawing, path: Path) -> Scene:
    """Return a scene in space whose blocks are closed meshes.

    A DrawingWarning names movable blocks that consist of several closed surfaces.

    A support that is a flat polygon, as one face or divided, is replaced by a slab behind this polygon.
    Raises ValueError if no block can move, or, with one line for each wrong block, if blocks are not solids.
    """
    block_points = [mesh.points for mesh in meshes if not mesh.fixed]
    if not block_points:
        names = listed_names([mesh.name for mesh in meshes])
        raise ValueError(f"every block is a support: mark fewer blocks as supports (blocks: {names})")
    middle = np.concatenate(block_points).mean(axis=0)
    tolerance = drawing.tolerance or _precision_tolerance(block_points)
    meshes = [without_back_faces(with_one_face(mesh)) for mesh in meshes]
    blocks, mistakes = _solids(meshes, drawing, tolerance, middle)
    if mistakes and drawing.tolerance is not None:
        wrong_meshes = [meshes[number] for number in mistakes]
        _refuse_large_tolerance(wrong_meshes, drawing, _precision_tolerance(block_points))
    refuse(list(mistakes.values()))
    scene = scene_of(blocks, drawing.replace(tolerance=tolerance), path)
    shapes(scene)  # raises CaseError if the analysis cannot use a block
    _warn_of_several_surfaces(path, meshes, tolerance)
    return scene


def _warn_of_several_surfaces(path: Path, meshes: Sequence[Mesh], tolerance: float) -> None:
    """Issue a DrawingWarning that names the movable blocks that consist of several closed surfaces.

    Such a block is probably several stones, which the modelling program joined or wrote as one layer. Meshes
    that this package wrote are not checked, because their closed surfaces are the convex parts of a block.
    """
    checked_meshes = [mesh for mesh in meshes if not mesh.fixed and not mesh.is_exported]
    count = {mesh.name: count_outer_surfaces(mesh, tolerance) for mesh in checked_meshes}
    divided_blocks = [f"'{name}' ({number} surfaces)" for name, number in count.items() if number > 1]
    if not divided_blocks:
        return
    is_single = len(divided_blocks) == 1
    warning = (
        f"{path}: {'block' if is_single else 'blocks'} {listed_names(divided_blocks)} "
        f"{'consists' if is_single else 'consist'} of several closed surfaces, but each block moves as one "
        "rigid body: if the surfaces are stones, export each stone as a separate object"
    )
    warnings.warn(printable(warning), DrawingWarning, stacklevel=4)


def _solids(
    meshes: Sequence[Mesh], drawing: SolidDrawing, tolerance: float, middle: np.ndarray
) -> tuple[list[Solid], dict[int, str]]:
    """Return the solids of valid meshes, and a dict from the index of each invalid mesh to its mistake.

    ``middle`` is the middle of the movable blocks. The slab of a support lies on the side away from it.
    """
    solids = []
    mistakes = {}
    for number, mesh in enumerate(meshes):
        try:
            with naming(f"block '{mesh.name}'"):
                if mesh.flat and not mesh.fixed:
                    raise ValueError("the block is a single face: give it a thickness, or make it a support")
                solids.append(drawing.solid(_slab(mesh, middle) if mesh.flat else mesh, tolerance))
        except CaseError as error:
            mistakes[number] = str(error)
    return solids, mistakes


def _refuse_large_tolerance(wrong_meshes: Sequence[Mesh], drawing: SolidDrawing, default: float) -> None:
    """Raise ValueError if the ``wrong_meshes`` would be valid with a smaller tolerance.

    The tolerance of the drawing is halved until no mesh is wrong, or until it is smaller than the
    ``default``. The message names the thinnest wrong mesh and a sufficient upper limit of the tolerance.
    """
    tolerance = drawing.tolerance
    if tolerance is None or any(mesh.flat for mesh in wrong_meshes):
        return
    limit = tolerance / 2
    while _solids(wrong_meshes, drawing, limit, np.zeros(3))[1]:
        limit /= 2
        if limit < default:
            return
    thickness = {mesh.name: least_width(mesh) for mesh in wrong_meshes}
    name = min(thickness, key=lambda block: thickness[block])
    raise ValueError(f"block '{name}' is {too_thin_for(tolerance, thickness[name], limit)}")


def _slab(mesh: Mesh, middle: np.ndarray) -> Mesh:
    """Return the slab for a support drawn as a single face, on the side away from the movable blocks."""
    (ring,) = mesh.faces
    top = mesh.points[ring]
    area = area_vector(top)
    size = float(np.linalg.norm(area))
    if not size > 0:
        raise ValueError("the block is a face without area: remove the face")
    sign = np.sign((middle - top.mean(axis=0)) @ area) or 1.0
    bottom = top - sign * SLAB_THICKNESS * area / np.sqrt(size)
    faces = prism(top.tolist(), bottom.tolist())["faces"]
    return replace(mesh, points=np.concatenate([top, bottom]), faces=faces)


def _precision_tolerance(block_points: Sequence[np.ndarray]) -> float:
    """Return a tolerance for the scene that suits the precision of the coordinates of its corners.

    If all coordinates are rounded, the tolerance is twice the unit of their last decimal place, provided that
    this length is small relative to the blocks. Otherwise it is the default tolerance of a scene.
    """
    points = np.concatenate(block_points)
    default = RELATIVE_TOLERANCE * float(np.linalg.norm(np.ptp(points, axis=0)))
    smallest_size = min(float(np.cbrt(np.prod(np.ptp(corners, axis=0)))) for corners in block_points)
    for decimals in range(_MOST_DECIMALS + 1):
        unit = 10.0**-decimals
        if np.abs(points - np.round(points, decimals)).max() <= 1e-9 * np.abs(points).max():
            return max(default, 2 * unit) if 2 * unit <= NEAR_MISS * smallest_size else default
    return default

"""OBJ, PLY and STL to a scene in space."""

from __future__ import annotations

import importlib
import io
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.scene.blocks import Name, Number, Positive
from masonry_opt.scene.drawings.in_space import SolidDrawing, scene_in_space
from masonry_opt.scene.drawings.meshes import Mesh, shells, with_supports
from masonry_opt.scene.drawings.stones import FIXED, block_name
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tables import as_path, read_bytes

#: Files that are read, by the end of their names.
MESHES = (".obj", ".ply", ".stl")

#: Bytes; some 100 a triangle.
_LARGEST_MESH = 200_000_000

#: Axes x, y, z of a scene, by the axis of the file that points upwards.
_AXES = {
    "x": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]),
    "y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "z": np.eye(3),
}


class MeshDrawing(SolidDrawing):
    """Values that a mesh leaves open, and how it is meant: see :func:`read_mesh`."""

    fixed: list[Name] = []
    fixed_layers: list[Name] = list(FIXED)
    fixed_below: Number | None = None
    up: Literal["x", "y", "z"] = "z"
    scale: Positive = 1.0


def read_mesh(
    path: str | Path,
    *,
    friction: float,
    unit_weight: float,
    live: tuple[float, float, float] = (0.0, 0.0, 0.0),
    fixed: Iterable[str] = (),
    fixed_layers: Iterable[str] = FIXED,
    fixed_below: float | None = None,
    up: Literal["x", "y", "z"] = "z",
    scale: float = 1.0,
    tolerance: float | None = None,
) -> Scene:
    """Read a scene in space from closed meshes, one a block.

    Objects and groups of an OBJ file are the blocks; of a file that has none, and of PLY and STL, the closed
    surfaces. Triangles of one plane become one face; blocks that are not convex are cut into convex parts.

    Parameters
    ----------
    path:
        A ``.obj``, ``.ply`` or ``.stl`` file.
    friction:
        Of every joint, μ = tan φ.
    unit_weight:
        Weight per unit volume (of the scene's units).
    live:
        Live force on every movable block as a multiple of its weight, ``[fx, fy, fz]``, at the centroid.
    fixed:
        Names of blocks that are supports, beside those by name or height.
    fixed_layers:
        Blocks are supports if the name of their object or group contains one of these words, in capitals or
        not.
    fixed_below:
        Blocks that reach down to this height z, or below, are supports too.
    up:
        The axis of the file that points upwards (Blender and game programs: often y). It becomes z, by a
        rotation.
    scale:
        By which all lengths of the file are multiplied: 0.001 for millimetres to metres. Other lengths given
        are those of the scene.
    tolerance:
        Length below which gaps are nothing and faces flat; corners of a block nearer than this are one
        (default: twice the last decimal where all coordinates have a few decimals and that is little beside
        the blocks, else as in :class:`Scene`).

    Raises
    ------
    CaseError
        If the file cannot be read, a block is no closed surface or nothing is a support; the message names
        the file and the block.
    OptionError
        If trimesh (or for blocks that are not convex manifold3d), of the extra "meshes", is not installed.
    """
    path = as_path(path, "a mesh")
    if path.suffix.lower() not in MESHES:
        raise CaseError(f"{path}: the name of a mesh ends in {', '.join(MESHES)}")
    drawing = MeshDrawing(
        friction=friction,
        unit_weight=unit_weight,
        live=live,
        fixed=list(fixed),
        fixed_layers=list(fixed_layers),
        fixed_below=fixed_below,
        up=up,
        scale=scale,
        tolerance=tolerance,
    )
    try:
        meshes = with_supports(
            _meshes(path, drawing), drawing.fixed, drawing.fixed_below, drawing.fixed_layers
        )
    except ValueError as error:
        raise error if isinstance(error, CaseError) else CaseError(f"{path}: {error}") from None
    return scene_in_space(meshes, drawing, path)


def _meshes(path: Path, drawing: MeshDrawing) -> list[Mesh]:
    """Blocks as they stand in the scene, none a support."""
    axes = drawing.scale * _AXES[drawing.up].T
    found = []
    objects = _objects(path)
    for name, points, triangles in objects:
        if not np.isfinite(points).all() or len(triangles) == 0:
            raise ValueError(f"block '{name}' has no faces, or a coordinate that is no number")
        closed = [np.arange(len(triangles))] if len(objects) > 1 else shells(points, triangles)
        for number, own in enumerate(closed):
            used, corner = np.unique(triangles[own], return_inverse=True)
            called = name if len(closed) == 1 else f"{name}-{number}"
            found.append(Mesh(called, points[used] @ axes, corner.reshape(-1, 3).tolist(), False))
    twice = [name for name, count in Counter(mesh.name for mesh in found).items() if count > 1]
    if twice:
        raise ValueError(f"has two blocks '{twice[0]}': rename one")
    return found


def _objects(path: Path) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Name, points and triangles of each object of a file, in its order."""
    try:
        trimesh = importlib.import_module("trimesh")
    except ImportError:
        raise OptionError("meshes need trimesh; install it with: pip install '.[meshes]'") from None
    data = read_bytes(path, _LARGEST_MESH)
    if len(data) > _LARGEST_MESH:
        raise CaseError(f"{path}: is larger than {_LARGEST_MESH // 1_000_000} MB: simplify the blocks")
    kind = path.suffix.lower()[1:]
    # By name and group; nothing joined or dropped: blocks that touch keep corners of their own.
    options: dict[str, Any] = {"process": False}
    if kind == "obj":
        options |= {"split_objects": True, "split_groups": True, "group_material": False}
        options |= {"skip_materials": True, "maintain_order": True}
    try:
        scene = trimesh.load_scene(io.BytesIO(data), file_type=kind, **options)
        found = [
            (block_name(name) or "block", np.array(mesh.vertices, dtype=float), np.array(mesh.faces))
            for name, mesh in scene.geometry.items()
            if isinstance(mesh, trimesh.Trimesh)
        ]
    except MemoryError:
        raise
    # What a broken file makes the library raise is any exception at all.
    except Exception as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise CaseError(f"{path}: not valid {kind.upper()}: {reason}; save the mesh again") from None
    if not found:
        raise CaseError(f"{path}: holds no mesh")
    if len(found) == 1:
        return [(path.stem, *found[0][1:])]
    return found

"""Read OBJ, PLY, STL and glTF meshes, and folders of them, as scenes in space."""

import codecs
import io
import re
import warnings
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import ConfigDict

from masonry_opt.errors import CaseError, DrawingWarning, counted, listed, printable
from masonry_opt.files import is_written_by_package
from masonry_opt.scene.blocks import LARGEST_NUMBER
from masonry_opt.scene.drawings import stones
from masonry_opt.scene.drawings.gltf_files import read_gltf
from masonry_opt.scene.drawings.meshes import Mesh, used
from masonry_opt.scene.drawings.ply_files import read_ply
from masonry_opt.scene.drawings.surfaces import divide_into_surfaces
from masonry_opt.scene.mistakes import repeated
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tables import as_path, broken, library, read_bytes

#: File name endings of the mesh formats that can be read.
MESHES = (".obj", ".ply", ".stl", ".glb", ".gltf")

#: File name endings of formats that may contain stones but cannot be read. A warning names files of a folder
#: with these endings. Other unreadable files are skipped without a warning.
_UNREAD_FORMATS = (
    *(".3dm", ".3ds", ".blend", ".dae", ".dxf", ".fbx", ".igs", ".iges", ".off", ".step", ".stp"),
    *(".usd", ".usda", ".usdc", ".usdz", ".wrl", ".x3d"),
)

#: Largest number of files or folders that a warning names.
_MOST_NAMED = 3

#: Upward axis of mesh files, by the ending of the file name. The glTF standard requires y. The upward axis of
#: all other files is z.
_UP_AXES = {".glb": "y", ".gltf": "y"}

#: Largest size of a mesh file, or of all files of a folder, in bytes. Larger files raise an error. A triangle
#: needs about 100 bytes.
_LARGEST_MESH = 200_000_000

#: Rotation from the axes of a mesh file to the axes of the scene, for each axis of the file that may point
#: upwards. The rows are the axes x, y and z of the scene in the coordinates of the file.
_SCENE_AXES = {
    "x": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]),
    "y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "z": np.eye(3),
}


class MeshDrawing(stones.SolidDrawing, stones.AsDrawn):
    """Values that the user specifies for a mesh file, such as friction and axes; see :func:`read_mesh`."""

    model_config = ConfigDict(title="a mesh")


def read_mesh(  # noqa: PLR0913 - options of the public API are keywords
    path: str | Path,
    *,
    friction: float,
    unit_weight: float,
    live: tuple[float, float, float] = (0.0, 0.0, 0.0),
    fixed: Iterable[str] = (),
    fixed_layers: Iterable[str] = stones.SUPPORT_WORDS,
    fixed_below: float | None = None,
    up: Literal["x", "y", "z"] | None = None,
    scale: float = 1.0,
    tolerance: float | None = None,
    contact_tolerance: float | None = None,
) -> Scene:
    """Read a scene in space from a file of closed meshes, or from a folder with one mesh file for each block.

    The blocks depend on the type of the file:

    - OBJ: the objects of the file, or its groups if it has no objects.
    - glTF: the nodes with a mesh in the default scene of the file. A DrawingWarning reports the number of
      other meshes. Corners may be in ``.bin`` files in the folder of the file.
    - A file with a single mesh, such as a PLY or STL file: the closed surfaces of the mesh.
    - A folder: each file is a block, whose name is the file name without the ending. A DrawingWarning names
      files of formats that cannot be read, such as ``.dae``, and subfolders with meshes.

    A DrawingWarning names movable blocks that consist of several closed surfaces.

    Faces in one plane are merged. If the corners of a block are at most four times the tolerance away from
    the planes of its faces, its faces are flattened. Other faces that are not flat are divided into
    triangles. If the convex hull of a block adds less volume than the tolerance times the block's surface,
    the hull replaces the block. Other blocks that are not convex are divided into convex parts.

    Parameters
    ----------
    path: A ``.obj``, ``.ply``, ``.stl``, ``.glb`` or ``.gltf`` file, or a folder of such files.
    friction: Friction coefficient μ = tan φ of every joint.
    unit_weight: Weight per unit volume, in the units of the scene.
    live: Live force on every movable block as a multiple of its weight, ``[fx, fy, fz]``, at the centroid.
    fixed: Names of blocks that are supports, in addition to supports by ``fixed_layers`` or ``fixed_below``.
    fixed_layers: Words that mark supports. A block is a support if the name of its object or group contains
        one of these words, in upper or lower case. Most programs write the layer of an object as its group.
    fixed_below: Blocks that reach down to this height z, or below, are supports too.
    up: The axis of the file that points upwards, which becomes z by a rotation. Default: "y" in glTF files,
        "z" in all other files. Blender and game programs often write OBJ files with y upwards.
    scale: Factor that multiplies all lengths of the file, such as 0.001 from millimetres to metres. All other
        arguments are in the units of the scene.
    tolerance: Length below which gaps are ignored, faces count as flat, and corners of a block are merged.
        The default is twice the unit of the last decimal place if all coordinates are rounded to few decimal
        places and this length is small relative to the blocks. Otherwise the default is as in :class:`Scene`.
    contact_tolerance: Largest gap or overlap of faces that are in contact, such as the width of mortar that
        is not drawn. :class:`Scene` explains it.

    Returns
    -------
    Scene
        The scene in space.

    Raises
    ------
    CaseError
        If a file cannot be read, if a block is not a closed surface, or if there are no supports. The message
        names the file and each wrong block.
    OptionError
        If an STL file is given and trimesh is not installed, which is part of the extra "meshes".
    """
    path = as_path(path, "a mesh")
    if path.suffix.lower() not in MESHES and not path.exists():
        raise CaseError(f"{path}: no such file or folder")
    drawing = MeshDrawing.of(locals())
    with stones.naming(f"{path}:"):
        unmarked_meshes = (
            _meshes_in_folder(path, drawing) if path.is_dir() else _meshes_as_blocks(path, drawing)
        )
        _refuse_repeated_names(unmarked_meshes)
        meshes = stones.with_supports(unmarked_meshes, drawing, drawing.fixed_layers)
        return stones.scene_in_space(meshes, drawing, path)


def _refuse_repeated_names(meshes: Sequence[Mesh]) -> None:
    """Raise ValueError if blocks have the same name. The message lists the repeated names."""
    names = repeated(mesh.name for mesh in meshes)
    if len(names) == 1:
        raise ValueError(f"two blocks are named '{names[0]}': rename one of them")
    if names:
        raise ValueError(
            f"several blocks have the same name: {stones.listed_names(names)}: "
            "give each block a name of its own"
        )


def _meshes_in_folder(folder: Path, drawing: MeshDrawing) -> list[Mesh]:
    """Return the meshes of all files of a folder, named after their files.

    Files are sorted by name, with numbers in the order of their values. Files of other formats and hidden
    files are ignored. A DrawingWarning names files of formats that may contain stones. Raises ValueError,
    with one line for each file that cannot be read.
    """
    try:
        visible_files = _visible_files(folder)
        files = [file for file in visible_files if _is_mesh(file)]
        size = sum(
            file.stat().st_size
            for file in visible_files
            if (_is_mesh(file) or file.suffix.lower() == ".bin") and file.exists()
        )
        subfolders = [file for file in visible_files if file.is_dir() and _has_meshes(file)]
    except OSError as error:
        raise ValueError(f"the folder cannot be read: {error.strerror}") from None
    if not files:
        hint = f"; its subfolder '{subfolders[0].name}' has meshes" if subfolders else ""
        raise ValueError(
            f"the folder has no meshes: write one file for each block ({', '.join(MESHES)}){hint}"
        )
    if size > _LARGEST_MESH:
        raise ValueError(
            f"the folder has more than {_LARGEST_MESH // 1_000_000} MB of meshes: simplify the blocks"
        )
    _warn_of_unread(folder, visible_files, subfolders)
    meshes: list[Mesh] = []
    mistakes: list[str] = []
    for file in sorted(files, key=_sort_key):
        try:
            with stones.naming(f"{file.name}:"):
                file_meshes = _meshes(file, drawing)
        except ValueError as error:
            mistakes.append(str(error))
            continue
        stem = stones.block_name(file.stem)
        for mesh in file_meshes:
            name = f"{stem} {mesh.name}" if len(file_meshes) > 1 else stem
            meshes.append(replace(mesh, name=name, layers=f"{mesh.name} {mesh.layers}"))
    stones.refuse(mistakes)
    return meshes


def _visible_files(folder: Path) -> list[Path]:
    """Return the files and subfolders of a folder, without hidden ones.

    Raises OSError if the folder cannot be read.
    """
    return [file for file in folder.iterdir() if file.name[0] != "."]


def _has_meshes(folder: Path) -> bool:
    """Return True if a folder has visible mesh files, and False if it has none or cannot be read."""
    try:
        return any(map(_is_mesh, _visible_files(folder)))
    except OSError:
        return False


def _is_mesh(file: Path) -> bool:
    """Return True if the name of a file has the ending of a mesh format."""
    return file.suffix.lower() in MESHES and not file.is_dir()


def _warn_of_unread(folder: Path, files: Sequence[Path], subfolders: Sequence[Path]) -> None:
    """Issue DrawingWarnings that name files of formats that cannot be read, and subfolders with meshes."""
    formats = ", ".join(MESHES)
    unread_files = [file for file in files if file.suffix.lower() in _UNREAD_FORMATS]
    for omitted_paths, noun, kind, remedy in (
        (unread_files, "file", "of other formats", f"export each block in one of the formats {formats}"),
        (
            subfolders,
            "subfolder",
            "with meshes",
            "move the files of subfolders into the folder, or read each subfolder as a separate scene",
        ),
    ):
        if omitted_paths:
            names = listed([f"'{file.name}'" for file in sorted(omitted_paths, key=_sort_key)], _MOST_NAMED)
            verb = "was" if len(omitted_paths) == 1 else "were"
            warning = (
                f"{folder}: {counted(len(omitted_paths), noun)} {kind} {verb} left out: {names}; {remedy}"
            )
            warnings.warn(printable(warning), DrawingWarning, stacklevel=4)


def _sort_key(file: Path) -> list[tuple[int, str]]:
    """Return a key that sorts numbers in file names by value: stone_2 before stone_10."""
    parts = re.findall(r"([0-9]{1,18})|([^0-9]+)", file.name.casefold())
    return [(int(digits), "") if digits else (-1, text) for digits, text in parts]


def _meshes_as_blocks(path: Path, drawing: MeshDrawing) -> list[Mesh]:
    """Return the meshes of a file. If the file has only one mesh, return its closed surfaces instead.

    Raises CaseError if the ending of the file's name is not the ending of a mesh format.
    """
    meshes = _meshes(as_path(path, "a mesh", *MESHES), drawing)
    return divide_into_surfaces(meshes[0]) if len(meshes) == 1 else meshes


def _meshes(path: Path, drawing: MeshDrawing) -> list[Mesh]:
    """Return the meshes of a file in the axes of the scene. No mesh is marked as a support yet.

    Raises ValueError if the file cannot be read.
    """
    data = read_bytes(path, _LARGEST_MESH, "simplify the blocks").removeprefix(codecs.BOM_UTF8)
    ending = path.suffix.lower()
    if ending != ".stl" and data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise ValueError("the file is in the encoding UTF-16: save it in the encoding UTF-8")
    if ending == ".obj":
        meshes = _obj_meshes(data)
    elif ending == ".ply":
        meshes = read_ply(data)
    elif ending == ".stl":
        meshes = _stl_meshes(data)
    else:
        meshes = read_gltf(data, path, _LARGEST_MESH)
    if not meshes:
        raise ValueError(
            "the file has no complete faces: export closed surfaces, and check that the extension of the "
            "file name matches the format of the file"
        )
    meshes = _with_names(meshes, path.stem, ending in _UP_AXES)
    for mesh in meshes:
        if not (np.abs(mesh.points) <= LARGEST_NUMBER).all():
            raise ValueError(
                f"block '{mesh.name}' has a coordinate that is not a finite number or is too large"
            )
    upwards = drawing.up or _UP_AXES.get(ending, "z")
    axes = drawing.scale * _SCENE_AXES[upwards].T
    is_exported = is_written_by_package(path)
    return [replace(mesh, points=mesh.points @ axes, is_exported=is_exported) for mesh in meshes]


def _with_names(meshes: Sequence[Mesh], default: str, are_repeated_numbered: bool) -> list[Mesh]:
    """Return the meshes, with a name added to each mesh that has none.

    A mesh without a name is named ``default``. If several meshes have no name, or if another mesh has the
    default name, a number is appended: "default-0", "default-1" and so on. Numbers are skipped if another
    mesh has the resulting name. If ``are_repeated_numbered`` is True, as for nodes of glTF files, numbers are
    also appended to equal names.
    """
    names = [mesh.name for mesh in meshes]
    numbered_names = set(repeated(names)) if are_repeated_numbered else set()
    if names.count("") > 1 or default in names:
        numbered_names.add("")
    count: Counter[str] = Counter()
    named_meshes = []
    for mesh in meshes:
        base = name = mesh.name or default
        while mesh.name in numbered_names and (name == base or name in names):
            name = f"{base}-{count[base]}"
            count[base] += 1
        named_meshes.append(replace(mesh, name=name))
    return named_meshes


def _obj_meshes(data: bytes) -> list[Mesh]:
    """Return the objects of an OBJ file as meshes.

    In a file without objects, return its groups; in a file without groups, return one mesh without a name.

    Polygons are not divided. Other readers divide a notched polygon into a fan of triangles, which is wrong.
    """
    points: list[list[float]] = []
    faces: dict[tuple[int, str], list[list[int]]] = {}
    layers: dict[tuple[int, str], str] = {}
    objects = 0
    group = ""
    key = (0, "")
    text = data.decode("utf-8", "replace").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), start=1):
        word, arguments = [*line.split(maxsplit=1), "", ""][:2]
        try:
            if word == "v":
                x, y, z = map(float, arguments.split()[:3])
                points.append([x, y, z])
            elif word == "o":
                objects += 1
                key = (objects, stones.block_name(arguments))
            elif word == "g":
                group = stones.block_name(arguments)
                key = key if objects else (0, group)
            elif word == "f":
                indices = [int(corner.split("/")[0]) for corner in arguments.split()]
                face = [corner - 1 if corner > 0 else len(points) + corner for corner in indices]
                if len(face) < 3 or min(face) < 0 or 0 in indices:
                    raise ValueError
                faces.setdefault(key, []).append(face)
                layers[key] = group
        except ValueError:
            has_commas = word == "v" and "," in arguments
            advice = "write numbers with a decimal point" if has_commas else "export the blocks again"
            raise ValueError(
                f"the file is not valid OBJ in line {number} ('{stones.block_name(line)[:60]}'): {advice}"
            ) from None
    corners = np.array(points).reshape(-1, 3)
    if any(corner >= len(corners) for mesh in faces.values() for face in mesh for corner in face):
        raise ValueError(
            "the file is not valid OBJ: a face refers to a missing corner; export the blocks again"
        )
    return [used(key[1], corners, mesh, layers[key]) for key, mesh in faces.items()]


def _stl_meshes(data: bytes) -> list[Mesh]:
    """Return the meshes of an STL file. If there is only one mesh, it has no name."""
    trimesh = library("trimesh", "reading STL files needs trimesh: install it with pip install '.[meshes]'")
    with broken(lambda reason: ValueError(f"the file is not valid STL: {reason}; save the mesh again")):
        # Switch off the processing of trimesh, which would merge the corners of touching blocks.
        scene = trimesh.load_scene(io.BytesIO(data), file_type="stl", process=False)
        meshes = [
            (stones.block_name(name), np.array(mesh.vertices, dtype=float), mesh.faces.tolist())
            for name, mesh in scene.geometry.items()
            if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)
        ]
    if len(meshes) == 1:
        meshes = [("", *meshes[0][1:])]
    return [used(name, points, faces) for name, points, faces in meshes]

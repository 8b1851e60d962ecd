"""Files of solids for other programs: OBJ and glTF with a mechanism, COMPAS JSON with forces."""

import json
import math
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.drawing.colours import BLOCK, SUPPORT_COLOUR
from masonry_opt.drawing.elements import SHOWN_MOTION_SHARE, result_elements
from masonry_opt.drawing.marks import moved
from masonry_opt.errors import OptionError
from masonry_opt.files import JSON_KEY, MARK, WRITER
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.result import Result
from masonry_opt.scene.drawings.meshes import outwards
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import Polyhedron, Solid
from masonry_opt.scene.tables import library

#: File name extensions of the formats in which blocks can be saved as solids.
SOLID_ENDS = (".json", ".obj", ".glb", ".gltf")
_SUPPORT = "fixed"  #: Prefix of the names of supports in mesh files.
#: Block as a tuple: its name, True if the block is fixed, its corners, and its faces. A face is a list of
#: corner indices whose normal points outwards.
_Body = tuple[str, bool, np.ndarray, list[list[int]]]
#: Rotation matrix that turns the vertical z axis of a scene into the vertical axis of glTF, y.
_Y_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], dtype=float)


def solid_file(solids: Scene | Result, end: str, share: float | None) -> str | bytes:
    """Return the content of a file that contains the blocks of a scene or result as solids.

    Raises OptionError if the scene has no solids, the share is wrong, or trimesh is missing.

    Parameters
    ----------
    solids: A scene, or a result with its motion and forces.
    end: Ending of the file name, one of SOLID_ENDS.
    share: Fraction of the full motion by which meshes are displaced; None for the fraction of pictures.
    """
    result = solids if isinstance(solids, Result) else None
    scene = solids.assembly.scene if isinstance(solids, Result) else solids
    if scene.dimension == 2:
        raise OptionError(
            f"{scene.origin}: a scene in the plane has no solids: convert it to space with "
            "masonry_opt.extrude"
        )
    if end == ".json":
        if share is not None:
            raise OptionError(
                "a COMPAS file contains the blocks at rest, with displacements as attributes: omit 'moved'"
            )
        return _compas(result.assembly if result else assemble(scene), result)
    number = isinstance(share, int | float) and not isinstance(share, bool) and math.isfinite(share)
    if share is not None and not number:
        raise OptionError(
            f"'moved' is the fraction of the full motion: pass a finite number (found {share!r})"
        )
    elements = result_elements(result) if result else None
    if share and not (elements and elements.movement):
        raise OptionError("'moved' needs a motion: omit 'moved', or pass a result with a mechanism")
    origin, motion = np.zeros(3), np.zeros((len(scene.blocks), 6))
    if elements:
        origin = elements.assembly.geometry.origin
        motion = (SHOWN_MOTION_SHARE if share is None else share) * elements.motion
    bodies = _bodies(scene, origin, motion)
    return _obj(bodies) if end == ".obj" else _gltf(bodies, end)


def _bodies(scene: Scene, origin: np.ndarray, motion: np.ndarray) -> list[_Body]:
    """Return all blocks of a scene, displaced by a given motion.

    The prefix "fixed" is added to the names of supports.

    ``motion`` has shape (blocks, 6), with rotations about ``origin``.
    """
    bodies = []
    for block, block_motion in zip(scene.in_space(), motion, strict=True):
        needs_prefix = block.fixed and not block.name.startswith(_SUPPORT)
        name = f"{_SUPPORT} {block.name}" if needs_prefix else block.name
        corners, faces = _joined(block.polyhedra)
        displaced = moved(corners - origin, block_motion) + origin
        bodies.append((name, block.fixed, displaced, faces))
    return bodies


def _joined(parts: Iterable[Polyhedron]) -> tuple[np.ndarray, list[list[int]]]:
    """Return the corners and faces of a block that consists of several polyhedra.

    The normals of all faces point outwards.
    """
    corners: list[np.ndarray] = []
    faces: list[list[int]] = []
    for part in parts:
        first = sum(map(len, corners))
        faces += [[first + corner for corner in face] for face in outwards(*part)]
        corners.append(np.asarray(part.vertices, dtype=float))
    return np.concatenate(corners), faces


def _obj(bodies: list[_Body]) -> str:
    """Return the text of a Wavefront OBJ file."""
    lines, first = [f"# {MARK}"], 1
    for name, _, corners, faces in bodies:
        lines.append(f"o {name}")
        lines += [f"v {x:.12g} {y:.12g} {z:.12g}" for x, y, z in corners.tolist()]
        lines += ["f " + " ".join(str(first + corner) for corner in face) for face in faces]
        first += len(corners)
    return "\n".join(lines) + "\n"


def _gltf(bodies: list[_Body], end: str) -> str | bytes:
    """Return the content of a glTF file: binary (.glb), or text (.gltf) with embedded buffers."""
    trimesh = library("trimesh", "glTF files need trimesh: install it with pip install '.[meshes]'")
    scene = trimesh.Scene()
    for name, fixed, corners, faces in bodies:
        # Each face is convex, so a fan of triangles that share its first corner covers it.
        triangles = [[face[0], *edge] for face in faces for edge in pairwise(face[1:])]
        mesh = trimesh.Trimesh(corners, triangles, process=False)
        colour = trimesh.visual.color.hex_to_rgba(SUPPORT_COLOUR if fixed else BLOCK)
        look = {"baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 1.0}
        material = trimesh.visual.material.PBRMaterial(**look)
        mesh.visual = trimesh.visual.TextureVisuals(material=material)
        scene.add_geometry(mesh, node_name=name, geom_name=name, transform=_Y_UP)
    signed = {"tree_postprocessor": lambda tree: tree["asset"].update(generator=WRITER)}
    if end == ".glb":
        return scene.export(file_type="glb", **signed)
    files = scene.export(file_type="gltf", merge_buffers=True, embed_buffers=True, **signed)
    return files["model.gltf"].decode()


def _compas(assembly: Assembly, result: Result | None) -> str:
    """Return the JSON text of an Assembly of compas_assembly, whose interfaces are the joints of the scene.

    With a result, the interfaces contain the forces on the first block at each contact point, and the
    velocities are written as displacements. ``c_np - c_nn`` is the force along the z axis of the interface,
    which points into the first block. ``c_u`` and ``c_v`` are the forces along the other axes.
    """
    velocities = np.zeros((len(assembly.scene.blocks), 6))
    attributes: dict[str, Any] = {"name": assembly.scene.title or Path(assembly.scene.origin).stem}
    if result:
        rates = result.blocks[["vx", "vy", "vz", "wx", "wy", "wz"]].to_numpy()
        velocities[assembly.movable] = np.nan_to_num(rates)
        attributes["load_factor"] = result.load_factor
        attributes |= {"status": str(result.status), "method": result.method}
    node = {}
    for block, motion in zip(assembly.scene.in_space(), velocities.tolist(), strict=True):
        mesh = _object("compas_assembly.datastructures/Block", _mesh(block))
        node[repr(block.name)] = {"block": mesh, "is_support": block.fixed, "displacement": motion}
    edge: dict[str, dict[str, Any]] = {name: {} for name in node}
    ends = np.array([*node])[np.column_stack([assembly.joints.first, assembly.joints.second])].tolist()
    for (first, second), interface in zip(ends, _interfaces(assembly, result), strict=True):
        edge[first].setdefault(second, {"interfaces": []})["interfaces"].append(interface)
    at_rest = {"block": None, "is_support": False, "displacement": [0.0] * 6}
    graph: dict[str, Any] = {"attributes": {}, "default_node_attributes": at_rest}
    graph |= {"default_edge_attributes": {"interfaces": None}, "node": node, "edge": edge, "max_node": -1}
    data = {"attributes": attributes, "graph": _object("compas.datastructures/Graph", graph)}
    document = {JSON_KEY: WRITER, **_object("compas_assembly.datastructures/Assembly", data)}
    return json.dumps(document, allow_nan=False, ensure_ascii=False)


def _object(kind: str, data: Any) -> dict[str, Any]:
    """Return data in the JSON format of COMPAS, together with the name ``kind`` of their COMPAS type."""
    return {"dtype": kind, "data": data}


def _mesh(block: Solid) -> dict[str, Any]:
    """Return the mesh of a block in the JSON format of COMPAS."""
    corners, faces = _joined(block.polyhedra)
    points = [dict(zip("xyz", corner, strict=True)) for corner in corners.tolist()]
    mesh: dict[str, Any] = {"attributes": {"name": block.name}}
    mesh |= {"default_vertex_attributes": {"x": 0.0, "y": 0.0, "z": 0.0}}
    mesh |= {"default_edge_attributes": {}, "default_face_attributes": {}}
    for kind, parts in (("vertex", points), ("face", faces)):
        mesh[kind] = {str(key): part for key, part in enumerate(parts)}
    return mesh | {"facedata": {}, "edgedata": {}, "max_vertex": len(points) - 1, "max_face": len(faces) - 1}


def _interfaces(assembly: Assembly, result: Result | None) -> list[dict[str, Any]]:
    """Return one COMPAS interface, a contact face with forces, for each joint.

    If the result has forces, the interfaces contain the forces.
    """
    contacts, origin = assembly.joints, assembly.geometry.origin
    force = None
    if result is not None and result.contacts is not None and result.contacts["n"].notna().all():
        force = result.contacts[["fx", "fy", "fz"]].to_numpy()
    interfaces = []
    for joint, (normal, tangent, second_tangent) in enumerate(np.moveaxis(contacts.axes, 1, 0)):
        of_joint = contacts.joint == joint
        points = (contacts.point[of_joint] + origin).tolist()
        axes = np.stack([tangent, second_tangent, normal])
        frame = {"point": points[0], "xaxis": axes[0].tolist(), "yaxis": axes[1].tolist()}
        forces = None
        if force is not None:
            components = (force[of_joint] @ axes.T).tolist()
            forces = [
                {"c_np": max(n, 0.0), "c_nn": max(-n, 0.0), "c_u": u, "c_v": v} for u, v, n in components
            ]
        data = {"points": points, "size": float(contacts.extent[joint])}
        data |= {"frame": _object("compas.geometry/Frame", frame), "forces": forces, "mesh": None}
        interfaces.append(_object("compas_assembly.datastructures/Interface", data))
    return interfaces

"""Solids and scenes for tests of contacts in space, and scenes that are moved, mirrored or redrawn."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import masonry_opt as mo
from masonry_opt.scene.contacts.joints import find_joints
from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.space.shapes import shapes


def hull(name, points, **keys):
    """Return the convex hull of points as a solid with triangular faces."""
    points = np.asarray(points, dtype=float)
    found = ConvexHull(points)
    inside = points[found.vertices].mean(axis=0)
    faces = []
    for a, b, c in found.simplices.tolist():
        outwards = np.cross(points[b] - points[a], points[c] - points[a]) @ (points[a] - inside) > 0
        faces.append([a, b, c] if outwards else [a, c, b])
    return mo.Solid(name=name, vertices=points.tolist(), faces=faces, **({"weight": 1} | keys))


def parted(name, *boxes, **keys):
    return mo.Solid(name=name, parts=[{"box": box} for box in boxes], **({"weight": 1} | keys))


def box(name, x, y, z, **keys):
    return mo.box(name, x, y, z, **({} if keys.get("fixed") else {"weight": 1}) | keys)


FLOOR = box("floor", (-5, 5), (-5, 5), (-1, 0), fixed=True)


def scene(*blocks, **keys):
    return mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=[*blocks], **keys)


def contacts_of(scene, floating=False):
    """Return the contacts of a scene in space or in the plane."""
    at = geometry(scene) if scene.dimension == 2 else shapes(scene)
    return find_joints(scene, at, floating=floating)


def refusal(scene):
    """Return the message of the error that the search for contacts raises."""
    with pytest.raises(mo.CaseError) as error:
        contacts_of(scene)
    return str(error.value)


def joints(scene, floating=False):
    """Yield the names, area, normal and contact points of each joint, in the coordinates of the scene."""
    found = shapes(scene)
    contacts = find_joints(scene, found, floating=floating)
    names = [block.name for block in scene.blocks]
    for number, (first, second) in enumerate(zip(contacts.first, contacts.second, strict=True)):
        points = contacts.point[contacts.joint == number] + found.origin
        yield (names[first], names[second]), contacts.extent[number], contacts.normal[number], points


def with_parts(scene, change):
    """Return the scene with vertices and faces of every part as ``change(vertices, faces)`` returns them."""
    blocks = []
    for block in scene.blocks:
        parts = []
        for part in block.polyhedra:
            vertices, faces = change(part.vertices, part.faces)
            parts.append({"vertices": np.asarray(vertices).tolist(), "faces": faces})
        keys = block.model_dump(exclude={"vertices", "faces", "box", "parts"})
        blocks.append(mo.Solid(parts=parts, **keys))
    return scene.model_copy(update={"blocks": blocks})


def moved(scene, matrix, shift=(0, 0, 0)):
    """Return the scene with all corners multiplied by a matrix and shifted."""
    return with_parts(scene, lambda vertices, faces: (vertices @ np.asarray(matrix).T + shift, faces))


def in_triangles(scene):
    """Return the scene with each face as a fan of triangles that do not share corners, as in meshes."""

    def change(vertices, faces):
        fans = [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]
        return vertices[np.concatenate(fans)], np.arange(3 * len(fans)).reshape(-1, 3).tolist()

    return with_parts(scene, change)

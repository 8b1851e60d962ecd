"""Divide meshes into their closed surfaces, each of which may be a stone."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from masonry_opt.scene.drawings.meshes import (
    Edge,
    Mesh,
    across,
    area_vector,
    by_edge,
    rings_of,
    used,
    volume,
)
from masonry_opt.scene.rows import linked, steps_round

#: Angle between two faces at a common edge, in radians, below which the faces count as coincident.
_COINCIDENT_ANGLE = 1e-4

#: Largest distance of a corner from the plane of a flat mesh, relative to the extent of the mesh. With a
#: larger value, thin blocks would count as flat.
_FLATNESS = 1e-5


def shells(mesh: Mesh) -> list[Mesh]:
    """Divide a mesh into its closed surfaces, which may touch each other. Each surface is a block.

    The blocks are numbered from 0. Successive faces that form a closed surface are one block. If the faces
    have another order, faces with a common edge belong to one block. If more than two faces share an edge,
    two of these faces belong to one block if no other block lies between them.

    Raises ValueError if the surfaces cannot be separated, because their faces are oriented inconsistently.
    """
    at, corner = np.unique(mesh.points, axis=0, return_inverse=True)
    faces = [corner.reshape(-1)[face].tolist() for face in mesh.faces]
    group = _successive_surfaces(faces)
    if group is None:
        group = _connected_surfaces(at, faces)
    if not group.any():
        return [mesh]
    surfaces: list[list[list[int]]] = [[] for _ in range(group.max() + 1)]
    for number, face in zip(group.tolist(), mesh.faces, strict=True):
        surfaces[number].append(face)
    return [used(f"{mesh.name}-{number}", mesh.points, surface) for number, surface in enumerate(surfaces)]


def with_one_face(mesh: Mesh) -> Mesh:
    """Return a flat mesh with its outline as its single face. Any other mesh is returned unchanged.

    Programs divide a flat polygon into triangles, for example the ground.
    """
    off = mesh.points - mesh.points.mean(axis=0)
    normal = np.linalg.svd(off, full_matrices=False)[2][-1]
    if mesh.flat or np.abs(off @ normal).max() > _FLATNESS * np.ptp(off, axis=0).max():
        return mesh
    at, corner = np.unique(mesh.points, axis=0, return_inverse=True)
    faces = [corner.reshape(-1)[face].tolist() for face in mesh.faces]
    upwards = [face if area_vector(at[face]) @ normal > 0 else face[::-1] for face in faces]
    edges = {edge for face in upwards for edge in steps_round(face)}
    outline = [(tail, tip) for tail, tip in edges if (tip, tail) not in edges]
    following = dict(outline)
    if len(following) < len(outline):
        return mesh
    rings = rings_of(following)
    return replace(mesh, points=at, faces=rings) if len(rings) == 1 else mesh


def count_bodies(mesh: Mesh) -> int:
    """Return the number of closed surfaces of a mesh, without surfaces that bound a cavity."""
    try:
        corners = [surface.points for surface in shells(mesh)]
    except ValueError:
        return 1
    low = np.array([points.min(axis=0) for points in corners])
    high = np.array([points.max(axis=0) for points in corners])
    is_inside = [((low < low[k]) & (high[k] < high)).all(axis=1).any() for k in range(len(corners))]
    return len(corners) - sum(is_inside)


def _successive_surfaces(faces: list[list[int]]) -> np.ndarray | None:
    """Return the index of each face's surface, or None if successive faces do not form closed surfaces.

    Programs usually write one stone after another.
    """
    group: list[int] = []
    number = 0
    count: Counter[Edge] = Counter()
    single: set[Edge] = set()  # edges that belong to only one face of the present surface
    for face in faces:
        group.append(number)
        for tail, tip in steps_round(face):
            edge = min(tail, tip), max(tail, tip)
            count[edge] += 1
            if count[edge] > 2:
                return None
            single ^= {edge}
        if not single:
            number += 1
            count.clear()
    return None if single else np.array(group)


def _connected_surfaces(points: np.ndarray, faces: list[list[int]]) -> np.ndarray:
    """Return the index of each face's surface, found from the edges that faces share; see :func:`shells`."""
    if volume(points, faces) < 0:
        faces = [face[::-1] for face in faces]
    edges = by_edge(faces)
    if _are_oriented_inconsistently(faces, edges):
        raise ValueError(
            "faces at the common edges of several surfaces are oriented inconsistently, so the surfaces "
            "cannot be separated: orient all faces outwards, or export each stone as an object of its own"
        )
    links: list[list[int]] = []
    for edge, having in edges.items():
        several = len(having) > 2
        links += _through_inside(points, edge, having, faces) if several else [having[:1] + having[-1:]]
    return linked(len(faces), *np.array(links, dtype=int).reshape(-1, 2).T)


def _are_oriented_inconsistently(faces: list[list[int]], edges: dict[Edge, list[int]]) -> bool:
    """Return True if an edge has four or more faces, and if the faces are oriented inconsistently.

    Faces are oriented consistently if equal numbers traverse each edge in both directions. An edge of an odd
    number of faces is at a hole of a surface, and is not considered.
    """
    paired = {edge: having for edge, having in edges.items() if len(having) % 2 == 0}
    if all(len(having) == 2 for having in paired.values()):
        return False
    directed = [set(steps_round(face)) for face in faces]
    return any(
        2 * sum(edge in directed[number] for number in having) != len(having)
        for edge, having in paired.items()
    )


def _through_inside(
    points: np.ndarray, edge: Edge, having: list[int], faces: list[list[int]]
) -> Iterator[list[int]]:
    """At an edge of more than two faces, find the pairs of faces that belong to the same block.

    Faces are compared by their angle about the edge. Each face that traverses the edge forwards is paired
    with the face of the next smaller angle that traverses it backwards.
    """
    low, high = points[list(edge)]
    u, v = across((high - low) / np.linalg.norm(high - low))
    angles: dict[bool, list[tuple[int, float]]] = {True: [], False: []}
    for number in having:
        away = points[faces[number]].mean(axis=0) - low
        forth = edge in steps_round(faces[number])
        angles[forth].append((number, float(np.arctan2(away @ v, away @ u))))
    for number, angle in angles[True] if angles[False] else ():
        # Coincident faces of two blocks have no volume between them. Subtract a small angle, so that a
        # coincident face is chosen last.
        behind = [((angle - other - _COINCIDENT_ANGLE) % (2 * np.pi), mate) for mate, other in angles[False]]
        yield [number, min(behind)[1]]

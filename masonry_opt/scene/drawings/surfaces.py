"""Divide meshes into their closed surfaces, each of which may be a stone."""

from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from masonry_opt.scene.drawings.cells import COINCIDENT_ANGLE, stones_between_faces
from masonry_opt.scene.drawings.meshes import (
    FEWEST_SIDES,
    Edge,
    Mesh,
    across,
    by_edge,
    distinct_faces,
    first_near,
    from_smallest,
    merge_equal_corners,
    outwards,
    used,
    volume,
)
from masonry_opt.scene.drawings.winding import fan, winding_number
from masonry_opt.scene.rows import linked, steps_round


def divide_into_surfaces(mesh: Mesh) -> list[Mesh]:
    """Divide a mesh into its closed surfaces, which may touch each other. Each surface is a block.

    The blocks are numbered from 0. Successive faces that form a closed surface are one block. If the faces
    have another order, faces with a common edge belong to one block. If more than two faces share an edge,
    two of these faces belong to one block if no other block lies between them. If the mesh has faces in both
    orientations, surfaces around the outside of blocks are left out.

    Raises ValueError if the surfaces cannot be separated, because their faces are oriented inconsistently, or
    because the common face of two blocks is drawn only once.
    """
    merged_faces = merge_equal_corners(mesh)
    unique_faces = distinct_faces(merged_faces)
    surfaces = None
    if not _is_two_sided([*unique_faces.values()]):
        surfaces = _successive_surfaces(unique_faces)
        if surfaces is None:
            # If faces are oriented at random, the common face of two touching blocks may occur twice in the
            # same orientation. ``distinct_faces`` removes the second occurrence, so repeat the division with
            # all faces.
            surfaces = _successive_surfaces(dict(enumerate(merged_faces)))
        if surfaces is None:
            surfaces = stones_between_faces(mesh.points, merged_faces)
    if surfaces is None:
        surfaces = _connected_surfaces(mesh.points, unique_faces)
    if len(surfaces) < 2:
        return [mesh]
    return [
        used(f"{mesh.name}-{number}", mesh.points, [mesh.faces[face] for face in surface])
        for number, surface in enumerate(surfaces)
    ]


def count_outer_surfaces(mesh: Mesh, tolerance: float) -> int:
    """Return the number of closed surfaces of a mesh, without surfaces that bound a cavity.

    Corners that are nearer to each other than the tolerance are joined. Surfaces that are open even then
    count as parts of one surface. A surface bounds a cavity if the mean of its corners is inside an odd
    number of surfaces with a larger bounding box.
    """
    joined_mesh = replace(mesh, points=mesh.points[first_near(mesh.points, tolerance)])
    try:
        all_surfaces = divide_into_surfaces(joined_mesh)
    except ValueError:
        return 1
    surfaces = [surface for surface in all_surfaces if _is_closed(surface)]
    has_open_surface = len(surfaces) < len(all_surfaces)
    if not surfaces:
        return 1
    low = np.array([surface.points.min(axis=0) for surface in surfaces])
    high = np.array([surface.points.max(axis=0) for surface in surfaces])
    larger_surfaces = [
        np.flatnonzero(((low < low[number]) & (high[number] < high)).all(axis=1)).tolist()
        for number in range(len(surfaces))
    ]
    triangles = {number: _triangles(surfaces[number]) for number in set(chain.from_iterable(larger_surfaces))}
    count = 0
    for surface, candidates in zip(surfaces, larger_surfaces, strict=True):
        middle = surface.points.mean(axis=0)
        enclosing_count = sum(winding_number(middle, triangles[number]) > 0.5 for number in candidates)
        count += enclosing_count % 2 == 0
    return count + has_open_surface


def _is_closed(surface: Mesh) -> bool:
    """Return True if no edge of a surface belongs to only one face."""
    faces = [*distinct_faces(merge_equal_corners(surface)).values()]
    return all(len(edge_faces) > 1 for edge_faces in by_edge(faces).values())


def without_back_faces(mesh: Mesh) -> Mesh:
    """Return a closed mesh without its back faces, if each face is drawn in both orientations.

    Some programs export each face a second time in the opposite orientation, so that it is visible from both
    sides. Any other mesh is returned unchanged.
    """
    faces = distinct_faces(merge_equal_corners(mesh))
    if not _is_two_sided([*faces.values()]):
        return mesh
    front_faces: dict[tuple[int, ...], int] = {}
    for number, face in faces.items():
        front_faces.setdefault(min(from_smallest(face), from_smallest(face[::-1])), number)
    front_mesh = replace(mesh, faces=[mesh.faces[number] for number in front_faces.values()])
    owners = by_edge([faces[number] for number in front_faces.values()]).values()
    return front_mesh if all(len(edge_faces) == 2 for edge_faces in owners) else mesh


def _triangles(surface: Mesh) -> np.ndarray:
    """Return the triangles of a closed surface, oriented outwards, shape (triangles, 3, 3)."""
    faces = outwards(surface.points, merge_equal_corners(surface))
    return np.concatenate([fan(surface.points[face[0]], surface.points[face]) for face in faces])


def _is_two_sided(faces: list[list[int]]) -> bool:
    """Return True if a list of faces contains each of its faces in both orientations."""
    return bool(faces) and _has_reverses({from_smallest(face) for face in faces}, faces)


def _has_reverses(keys: set[tuple[int, ...]], faces: list[list[int]]) -> bool:
    """Return True if the reverse of each face is among the faces that ``keys`` represents.

    A key is the result of :func:`from_smallest` for a face.
    """
    return all(from_smallest(face[::-1]) in keys for face in faces)


def _successive_surfaces(faces: dict[int, list[int]]) -> list[list[int]] | None:
    """Divide a list of faces, in its order, into closed surfaces; return the face indices of each surface.

    Programs usually write all faces of a stone before the faces of the next stone. Return None if successive
    faces do not form closed and connected surfaces of at least four faces each.
    """
    surfaces: list[list[int]] = []
    surface: list[int] = []
    count: Counter[Edge] = Counter()
    open_edges: set[Edge] = set()  # edges that belong to only one face of the current surface
    for number, face in faces.items():
        surface.append(number)
        for tail, tip in steps_round(face):
            edge = min(tail, tip), max(tail, tip)
            count[edge] += 1
            if count[edge] > 2:
                return None
            open_edges ^= {edge}
        if not open_edges:
            if len(surface) < FEWEST_SIDES or not _is_connected([faces[number] for number in surface]):
                return None
            surfaces.append(surface)
            surface = []
            count.clear()
    return None if open_edges else surfaces


def _is_connected(faces: list[list[int]]) -> bool:
    """Return True if the faces are connected by edges that two faces share."""
    pairs = [edge_faces for edge_faces in by_edge(faces).values() if len(edge_faces) == 2]
    return not linked(len(faces), *np.array(pairs, dtype=int).reshape(-1, 2).T).any()


def _connected_surfaces(points: np.ndarray, unique_faces: dict[int, list[int]]) -> list[list[int]]:
    """Divide faces into surfaces by the edges that they share; return the face indices of each surface.

    See :func:`divide_into_surfaces`.
    """
    faces = list(unique_faces.values())
    if volume(points, faces) < 0:
        faces = [face[::-1] for face in faces]
    edges = by_edge(faces)
    if _are_oriented_inconsistently(faces, edges):
        raise ValueError(
            "faces at the common edges of several surfaces are oriented inconsistently, so the surfaces "
            "cannot be separated: orient all faces outwards, or export each stone as an object of its own"
        )
    links: list[list[int]] = []
    for edge, edge_faces in edges.items():
        has_several_surfaces = len(edge_faces) > 2
        links += (
            _pairs_through_inside(points, edge, edge_faces, faces)
            if has_several_surfaces
            else [edge_faces[:1] + edge_faces[-1:]]
        )
    group = linked(len(faces), *np.array(links, dtype=int).reshape(-1, 2).T)
    surface_faces: dict[int, dict[int, list[int]]] = defaultdict(dict)
    for surface, number, face in zip(group.tolist(), unique_faces, faces, strict=True):
        surface_faces[surface][number] = face
    keys = {from_smallest(face) for face in faces}
    return [
        list(surface)
        for surface in surface_faces.values()
        if not _is_around_blocks(points, [*surface.values()], keys)
    ]


def _is_around_blocks(points: np.ndarray, faces: list[list[int]], keys: set[tuple[int, ...]]) -> bool:
    """Return True if a surface is not a block, but the outer boundary of blocks, oriented inwards.

    A mesh in which each face occurs in both orientations contains the outer faces of its blocks a second
    time, oriented inwards. ``keys`` contains the result of :func:`from_smallest` for each face of the mesh. A
    flat polygon also has each face in both orientations, but is a block.
    """
    return _has_reverses(keys, faces) and not _is_two_sided(faces) and volume(points, faces) < 0


def _are_oriented_inconsistently(faces: list[list[int]], edges: dict[Edge, list[int]]) -> bool:
    """Return True if faces are oriented inconsistently, and some edge belongs to four or more faces.

    Faces are oriented consistently if, at each edge, as many faces traverse the edge forwards as backwards.
    An edge of an odd number of faces is at a hole of a surface, and is not considered.
    """
    even_edges = {edge: edge_faces for edge, edge_faces in edges.items() if len(edge_faces) % 2 == 0}
    if all(len(edge_faces) == 2 for edge_faces in even_edges.values()):
        return False
    directed_edges = [set(steps_round(face)) for face in faces]
    return any(
        2 * sum(edge in directed_edges[number] for number in edge_faces) != len(edge_faces)
        for edge, edge_faces in even_edges.items()
    )


def _pairs_through_inside(
    points: np.ndarray, edge: Edge, edge_faces: list[int], faces: list[list[int]]
) -> Iterator[list[int]]:
    """At an edge of more than two faces, find the pairs of faces that belong to the same block.

    Faces are compared by their angle about the edge. Each face that traverses the edge forwards is paired
    with the face of the next smaller angle that traverses it backwards.
    """
    low, high = points[list(edge)]
    u, v = across((high - low) / np.linalg.norm(high - low))
    angles: dict[bool, list[tuple[int, float]]] = {True: [], False: []}
    for number in edge_faces:
        direction = points[faces[number]].mean(axis=0) - low
        is_forward = edge in steps_round(faces[number])
        angles[is_forward].append((number, float(np.arctan2(direction @ v, direction @ u))))
    for number, angle in angles[True] if angles[False] else ():
        # A coincident face belongs to the neighbouring block. Subtract a small angle from the angle between
        # two faces, modulo 2π: for coincident faces the result is almost 2π, so they are chosen last.
        candidates = [
            ((angle - other_angle - COINCIDENT_ANGLE) % (2 * np.pi), mate)
            for mate, other_angle in angles[False]
        ]
        yield [number, min(candidates)[1]]

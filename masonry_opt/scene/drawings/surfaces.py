"""Divide meshes into their closed surfaces, each of which may be a stone."""

from collections import Counter, defaultdict
from collections.abc import Iterator
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
    merged = merge_equal_corners(mesh)
    distinct = distinct_faces(merged)
    surfaces = None
    if not _is_two_sided([*distinct.values()]):
        surfaces = _successive_surfaces(distinct)
        if surfaces is None:
            # If faces are oriented at random, the common face of two touching blocks may occur twice in the
            # same orientation. Then keep both.
            surfaces = _successive_surfaces(dict(enumerate(merged)))
        if surfaces is None:
            surfaces = stones_between_faces(mesh.points, merged)
    if surfaces is None:
        surfaces = _connected_surfaces(mesh.points, distinct)
    if len(surfaces) < 2:
        return [mesh]
    return [
        used(f"{mesh.name}-{number}", mesh.points, [mesh.faces[face] for face in surface])
        for number, surface in enumerate(surfaces)
    ]


def count_outer_surfaces(mesh: Mesh) -> int:
    """Return the number of closed surfaces of a mesh, without surfaces that bound a cavity.

    A surface bounds a cavity if the mean of its corners is inside an odd number of surfaces with a larger
    bounding box.
    """
    try:
        surfaces = divide_into_surfaces(mesh)
    except ValueError:
        return 1
    low = np.array([surface.points.min(axis=0) for surface in surfaces])
    high = np.array([surface.points.max(axis=0) for surface in surfaces])
    around = [
        np.flatnonzero(((low < low[number]) & (high[number] < high)).all(axis=1)).tolist()
        for number in range(len(surfaces))
    ]
    triangles = {number: _triangles(surfaces[number]) for number in set(chain.from_iterable(around))}
    count = 0
    for surface, larger in zip(surfaces, around, strict=True):
        middle = surface.points.mean(axis=0)
        enclosing = sum(winding_number(middle, triangles[number]) > 0.5 for number in larger)
        count += enclosing % 2 == 0
    return count


def _triangles(surface: Mesh) -> np.ndarray:
    """Return the triangles of a closed surface, oriented outwards, shape (triangles, 3, 3)."""
    faces = outwards(surface.points, merge_equal_corners(surface))
    return np.concatenate([fan(surface.points[face[0]], surface.points[face]) for face in faces])


def _is_two_sided(faces: list[list[int]]) -> bool:
    """Return True if the faces contain each face in both orientations."""
    return bool(faces) and _has_reverses({from_smallest(face) for face in faces}, faces)


def _has_reverses(keys: set[tuple[int, ...]], faces: list[list[int]]) -> bool:
    """Return True if the set of keys contains the key of the reverse of each face."""
    return all(from_smallest(face[::-1]) in keys for face in faces)


def _successive_surfaces(faces: dict[int, list[int]]) -> list[list[int]] | None:
    """Return the indices of the faces of each surface, if the faces of a surface follow one another.

    Programs usually write one stone after another. Return None if successive faces do not form closed and
    connected surfaces of at least four faces each.
    """
    surfaces: list[list[int]] = []
    present: list[int] = []
    count: Counter[Edge] = Counter()
    single: set[Edge] = set()  # edges that belong to only one face of the present surface
    for number, face in faces.items():
        present.append(number)
        for tail, tip in steps_round(face):
            edge = min(tail, tip), max(tail, tip)
            count[edge] += 1
            if count[edge] > 2:
                return None
            single ^= {edge}
        if not single:
            if len(present) < FEWEST_SIDES or not _is_connected([faces[number] for number in present]):
                return None
            surfaces.append(present)
            present = []
            count.clear()
    return None if single else surfaces


def _is_connected(faces: list[list[int]]) -> bool:
    """Return True if the faces are connected by edges that two faces share."""
    pairs = [having for having in by_edge(faces).values() if len(having) == 2]
    return not linked(len(faces), *np.array(pairs, dtype=int).reshape(-1, 2).T).any()


def _connected_surfaces(points: np.ndarray, distinct: dict[int, list[int]]) -> list[list[int]]:
    """Return the indices of the faces of each surface, found from the edges that faces share.

    See :func:`divide_into_surfaces`.
    """
    faces = list(distinct.values())
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
    group = linked(len(faces), *np.array(links, dtype=int).reshape(-1, 2).T)
    oriented: dict[int, dict[int, list[int]]] = defaultdict(dict)
    for surface, number, face in zip(group.tolist(), distinct, faces, strict=True):
        oriented[surface][number] = face
    keys = {from_smallest(face) for face in faces}
    return [
        list(surface)
        for surface in oriented.values()
        if not _is_around_blocks(points, [*surface.values()], keys)
    ]


def _is_around_blocks(points: np.ndarray, faces: list[list[int]], keys: set[tuple[int, ...]]) -> bool:
    """Return True if a surface encloses all blocks of a mesh, and is no block itself.

    A mesh in which each face occurs in both orientations has such a surface: the reversed outer faces of its
    blocks. The surface is oriented inwards. ``keys`` has the keys of all faces of the mesh. A flat polygon
    also has each face in both orientations, but is a block.
    """
    return _has_reverses(keys, faces) and not _is_two_sided(faces) and volume(points, faces) < 0


def _are_oriented_inconsistently(faces: list[list[int]], edges: dict[Edge, list[int]]) -> bool:
    """Return True if some edge belongs to four or more faces, and the orientations of the faces differ.

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
        behind = [((angle - other - COINCIDENT_ANGLE) % (2 * np.pi), mate) for mate, other in angles[False]]
        yield [number, min(behind)[1]]

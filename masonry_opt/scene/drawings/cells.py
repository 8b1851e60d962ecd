"""Separate stones that touch, whatever the orientation and the order of their faces.

The faces of a mesh divide space into cells: the stones, the outside, and voids. At an edge, the faces are
sorted by their angle about the edge. Between two successive faces lies one cell. A face that is drawn once
has a stone on one of its sides only. A face that is drawn twice has stones on both sides.
"""

from collections import Counter

import numpy as np

from masonry_opt.scene.drawings.meshes import (
    FEWEST_SIDES,
    Edge,
    across,
    area_vector,
    by_edge,
    distinct_faces,
    from_smallest,
    volume,
)
from masonry_opt.scene.rows import linked, steps_round, turned
from masonry_opt.scene.space.faces import place

#: Angle between two faces at a common edge, in radians, below which the faces count as coincident.
COINCIDENT_ANGLE = 1e-4


def stones_between_faces(points: np.ndarray, faces: list[list[int]]) -> list[list[int]] | None:
    """Return the indices of the faces of each stone, or None if the faces do not determine the stones.

    A face between two stones must be drawn twice; its orientation does not matter. Raises ValueError if such
    faces are drawn only once.

    Parameters
    ----------
    points : ndarray, shape (points, 3)
        Corners. No two corners are equal.
    faces : list of list of int
        Indices of the corners of each face, in order around the face.
    """
    numbers: dict[tuple[int, ...], int] = {}
    copies: Counter[int] = Counter()
    for number, face in enumerate(faces):
        for ring in distinct_faces([face]).values():
            key = min(from_smallest(ring), from_smallest(ring[::-1]))
            copies[numbers.setdefault(key, number)] += 1
    rings = [list(key) for key in numbers]
    edges = by_edge(rings)
    if any(len(edge_faces) == 1 for edge_faces in edges.values()) or max(copies.values(), default=0) > 2:
        return None
    cell = _cells(points, rings, edges)
    if cell is None:
        return None
    sides = np.split(np.argsort(cell, kind="stable"), np.cumsum(np.bincount(cell))[:-1])
    is_outside = np.array([_volume(points, rings, cell_sides) < 0 for cell_sides in sides])
    is_single = np.array([copies[number] == 1 for number in numbers.values()])
    is_stone = _stone_mask(cell, is_outside, is_single)
    if is_stone is None and is_single.all() and (~is_outside).sum() > 1:
        _refuse_single_faces(points, edges)
    if is_stone is None:
        return None
    face_numbers = np.array([*numbers.values()])
    stones = [
        face_numbers[cell_sides // 2].tolist()
        for cell_sides, fills in zip(sides, is_stone, strict=True)
        if fills
    ]
    # If faces of the drawing overlap, a cell can be on both sides of one face, or have too few faces for a
    # solid. The faces then define no stones.
    are_solids = all(len(set(stone)) == len(stone) >= FEWEST_SIDES for stone in stones)
    return sorted(sorted(stone) for stone in stones) if are_solids else None


def _stone_mask(cell: np.ndarray, is_outside: np.ndarray, is_single: np.ndarray) -> np.ndarray | None:
    """Return a mask of the cells that are stones, or None if no choice of stones fits the faces.

    Each connected group of faces must have a stone.

    Parameters
    ----------
    cell : ndarray
        Index of the cell on each side of each face, as returned by :func:`_cells`.
    is_outside : ndarray, shape (cells,)
        True for cells that surround a connected group of faces.
    is_single : ndarray, shape (faces,)
        True for faces that are drawn once. One of their two cells is a stone, and the other is not.
    """
    front, back = cell[::2], cell[1::2]
    turn, contradictory = turned(len(is_outside), front, back, is_single)
    group = linked(len(is_outside), front, back)
    outside_cells = np.flatnonzero(is_outside)
    if contradictory.any() or sorted(group[outside_cells].tolist()) != [*range(group.max() + 1)]:
        return None
    outside_of_group = np.empty(len(outside_cells), dtype=int)
    outside_of_group[group[outside_cells]] = outside_cells
    is_stone = turn != turn[outside_of_group[group]]
    return is_stone if np.bincount(group, is_stone).all() else None


def _cells(points: np.ndarray, rings: list[list[int]], edges: dict[Edge, list[int]]) -> np.ndarray | None:
    """Return the indices of the cells on the two sides of each face, shape (2 × faces,).

    The order is the front of the first face, the back of the first face, the front of the second face, and so
    on. Seen from the front, the corners of a face are counter-clockwise. None is returned if coincident faces
    cannot be ordered.
    """
    normals = np.array([area_vector(points[ring]) for ring in rings])
    directed_edges = [set(steps_round(ring)) for ring in rings]
    links: list[tuple[int, int]] = []
    for edge, edge_faces in edges.items():
        is_forward = np.array([edge in directed_edges[face] for face in edge_faces])
        order = [0, 1]
        if len(edge_faces) > 2:
            low, high = points[list(edge)]
            axis = (high - low) / np.linalg.norm(high - low)
            # Compute the vectors that point from the edge into the faces, perpendicular to the edge.
            inwards = np.cross(normals[edge_faces], np.where(is_forward[:, None], axis, -axis))
            order = _order_about_edge(np.arctan2(*(across(axis) @ inwards.T)[::-1]), is_forward)
        if not order:
            return None
        for position, next_position in steps_round(order):
            links.append(
                (
                    2 * edge_faces[position] + (not is_forward[position]),
                    2 * edge_faces[next_position] + int(is_forward[next_position]),
                )
            )
    return linked(2 * len(rings), *np.array(links).T)


def _order_about_edge(angle: np.ndarray, is_forward: np.ndarray) -> list[int]:
    """Return the order of faces about an edge, or an empty list if coincident faces cannot be ordered.

    Coincident faces can be ordered if there are two of them, which traverse the edge in opposite directions.
    Examples are triangles of touching stones that have different diagonals. The face that traverses the edge
    forwards is the first. The order is then the same at all edges of such faces.
    """
    turn = (angle - angle[0] + COINCIDENT_ANGLE) % (2 * np.pi)
    order = np.argsort(turn)
    group = np.append(0, np.cumsum(np.diff(turn[order]) > COINCIDENT_ANGLE))
    is_clear = (
        np.bincount(group, is_forward[order]).max() <= 1 and np.bincount(group, ~is_forward[order]).max() <= 1
    )
    return order[np.lexsort((~is_forward[order], group))].tolist() if is_clear else []


def _volume(points: np.ndarray, rings: list[list[int]], sides: np.ndarray) -> float:
    """Return the volume of a cell, which is negative for a cell that surrounds a group of faces.

    ``sides`` has the sides of faces that bound the cell, numbered as in the result of :func:`_cells`.
    """
    return volume(points, [rings[side // 2][:: 1 if side % 2 else -1] for side in sides.tolist()])


def _refuse_single_faces(points: np.ndarray, edges: dict[Edge, list[int]]) -> None:
    """Raise ValueError for a face between two stones that is drawn only once.

    The message names an edge of the face.
    """
    edge = next(edge for edge, edge_faces in edges.items() if len(edge_faces) > 2)
    start, end = (place(points[corner]) for corner in edge)
    raise ValueError(
        f"at the edge from {start} to {end}, two parts share a single face: if the parts are stones, draw "
        "the face once for each stone, or export each stone as a separate object; if not, delete the face"
    )

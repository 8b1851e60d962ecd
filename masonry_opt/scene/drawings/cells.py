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
    if any(len(having) == 1 for having in edges.values()) or max(copies.values(), default=0) > 2:
        return None
    cell = _cells(points, rings, edges)
    if cell is None:
        return None
    sides = np.split(np.argsort(cell, kind="stable"), np.cumsum(np.bincount(cell))[:-1])
    is_outside = np.array([_volume(points, rings, own) < 0 for own in sides])
    is_single = np.array([copies[number] == 1 for number in numbers.values()])
    is_stone = _stones(cell, is_outside, is_single)
    if is_stone is None and is_single.all() and (~is_outside).sum() > 1:
        _refuse_single_faces(points, edges)
    if is_stone is None:
        return None
    original = np.array([*numbers.values()])
    stones = [original[own // 2].tolist() for own, fills in zip(sides, is_stone, strict=True) if fills]
    # If faces cover the same area, a cell is on both sides of a face, or has too few faces for a solid.
    are_solids = all(len(set(stone)) == len(stone) >= FEWEST_SIDES for stone in stones)
    return sorted(sorted(stone) for stone in stones) if are_solids else None


def _stones(cell: np.ndarray, is_outside: np.ndarray, is_single: np.ndarray) -> np.ndarray | None:
    """Return a mask of the cells that are stones, or None if the faces contradict each other.

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
    outside = np.flatnonzero(is_outside)
    if contradictory.any() or sorted(group[outside].tolist()) != [*range(group.max() + 1)]:
        return None
    surrounding = np.empty(len(outside), dtype=int)
    surrounding[group[outside]] = outside
    is_stone = turn != turn[surrounding[group]]
    return is_stone if np.bincount(group, is_stone).all() else None


def _cells(points: np.ndarray, rings: list[list[int]], edges: dict[Edge, list[int]]) -> np.ndarray | None:
    """Return the index of the cell on each side of each face, shape (2 × faces,).

    The sides are the front of the first face, its back, the front of the second face, and so on. Seen from
    the front, the corners of a face are counter-clockwise. Return None if the order of coincident faces is
    not clear.
    """
    normals = np.array([area_vector(points[ring]) for ring in rings])
    directed = [set(steps_round(ring)) for ring in rings]
    links: list[tuple[int, int]] = []
    for edge, having in edges.items():
        forth = np.array([edge in directed[face] for face in having])
        order = [0, 1]
        if len(having) > 2:
            low, high = points[list(edge)]
            axis = (high - low) / np.linalg.norm(high - low)
            # The vectors from the edge into the faces, normal to the edge.
            inwards = np.cross(normals[having], np.where(forth[:, None], axis, -axis))
            order = _order_about_edge(np.arctan2(*(across(axis) @ inwards.T)[::-1]), forth)
        if not order:
            return None
        for this, after in steps_round(order):
            links.append((2 * having[this] + (not forth[this]), 2 * having[after] + int(forth[after])))
    return linked(2 * len(rings), *np.array(links).T)


def _order_about_edge(angle: np.ndarray, forth: np.ndarray) -> list[int]:
    """Return the order of faces about an edge, or an empty list if the order is not clear.

    Of two coincident faces, such as triangles of touching stones that have different diagonals, the face that
    traverses the edge forwards is the first. Then the order is the same at all edges of such faces.
    """
    turn = (angle - angle[0] + COINCIDENT_ANGLE) % (2 * np.pi)
    order = np.argsort(turn)
    group = np.append(0, np.cumsum(np.diff(turn[order]) > COINCIDENT_ANGLE))
    is_clear = np.bincount(group, forth[order]).max() <= 1 and np.bincount(group, ~forth[order]).max() <= 1
    return order[np.lexsort((~forth[order], group))].tolist() if is_clear else []


def _volume(points: np.ndarray, rings: list[list[int]], sides: np.ndarray) -> float:
    """Return the volume of a cell, which is negative for the outside. Sides are numbered as in ``_cells``."""
    return volume(points, [rings[side // 2][:: 1 if side % 2 else -1] for side in sides.tolist()])


def _refuse_single_faces(points: np.ndarray, edges: dict[Edge, list[int]]) -> None:
    """Raise ValueError for a face between two stones that is drawn once; the message names an edge of it."""
    edge = next(edge for edge, having in edges.items() if len(having) > 2)
    one, other = (place(points[corner]) for corner in edge)
    raise ValueError(
        f"a face between two parts is drawn only once, at the edge from {one} to {other}: if the parts are "
        "stones, draw the faces of each stone, or export each stone as an object of its own; if not, delete "
        "the face"
    )

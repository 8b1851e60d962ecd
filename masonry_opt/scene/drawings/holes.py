"""Find holes in the surfaces of blocks that are drawn as meshes."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import shapely

from masonry_opt.scene.drawings.meshes import Mesh, area_vector, by_edge, join_corners
from masonry_opt.scene.rows import spaces, steps_round
from masonry_opt.scene.space.faces import place
from masonry_opt.scene.tolerance_advice import ADVISED_SHARE, set_tolerance


def refuse_holes(mesh: Mesh, tolerance: float) -> None:
    """Raise ValueError if the surface of a block has a hole wider than the tolerance.

    An edge that belongs to a single face borders a hole, unless other edges of single faces lie along its
    whole length. Such edges exist where corners of one face lie on an edge of another face, and at gaps
    narrower than the tolerance.
    """
    hole = _find_hole(mesh, tolerance)
    if hole is None:
        return
    start, end = map(place, hole.edge)
    closing_tolerance = _closing_tolerance(mesh, tolerance)
    if closing_tolerance is not None:
        advice = f"its coordinates are inexact: {set_tolerance(closing_tolerance)}"
    elif hole.is_at_fin:
        advice = "delete this face, which is not part of the closed surface"
    else:
        advice = "add the missing face, or close the hole in the program that drew the block"
    raise ValueError(
        f"the block is not closed at its edge from {start} to {end}, which belongs to only one face: {advice}"
    )


class OpenEdge(NamedTuple):
    """Edge at which the surface of a block is not closed."""

    edge: np.ndarray  #: ends of the edge, shape (2, 3)
    #: True if the only face at the edge has another edge that belongs to more than two faces. The face then
    #: projects from the surface.
    is_at_fin: bool


def _find_hole(mesh: Mesh, tolerance: float) -> OpenEdge | None:
    """Return the first edge at a hole wider than the tolerance, or None; see :func:`refuse_holes`."""
    faces = join_corners(mesh.points, mesh.faces, tolerance)
    edge_faces = by_edge(faces)
    open_edges = [edge for edge, owners in edge_faces.items() if len(owners) == 1]
    ends = mesh.points[np.array(open_edges, dtype=int).reshape(-1, 2)]
    for number, neighbours in enumerate(_nearby_edges(ends, tolerance)):
        if not _is_covered(ends[number], ends[neighbours], tolerance):
            (owner,) = edge_faces[open_edges[number]]
            sides = [(min(side), max(side)) for side in steps_round(faces[owner])]
            return OpenEdge(ends[number], any(len(edge_faces[side]) > 2 for side in sides))
    return None


def _closing_tolerance(mesh: Mesh, tolerance: float) -> float | None:
    """Return a tolerance that closes all holes of a block's surface, or None if it would be too large.

    The tolerance is doubled until the holes are closed. It stays small compared with the block and with its
    edges, because a larger tolerance would join corners of different edges.
    """
    edges = np.array([edge for face in mesh.faces for edge in steps_round(face)])
    lengths = np.linalg.norm(np.subtract(*mesh.points[edges].swapaxes(0, 1)), axis=1)
    largest = ADVISED_SHARE * min(least_width(mesh), float(np.median(lengths)))
    tolerance *= 2
    while tolerance <= largest:
        if _find_hole(mesh, tolerance) is None:
            return tolerance
        tolerance *= 2
    return None


def least_width(mesh: Mesh) -> float:
    """Return the smallest distance between two planes that are parallel to a face and enclose the mesh."""
    vectors = np.array([area_vector(mesh.points[face]) for face in mesh.faces])
    sizes = np.linalg.norm(vectors, axis=1)
    normals = vectors[sizes > 0] / sizes[sizes > 0, None]
    return float(np.ptp(mesh.points @ normals.T, axis=0).min(initial=np.inf))


def _nearby_edges(ends: np.ndarray, tolerance: float) -> Iterator[np.ndarray]:
    """Find, for each edge, the indices of the other edges with bounding boxes near the edge's box.

    ``ends`` has shape (edges, 2, 3). The boxes are projected along the axis in which the mesh is least deep,
    and stored in a search tree, so that few candidates remain.
    """
    if not len(ends):
        return
    low, high = ends.min(axis=1), ends.max(axis=1)
    axes = np.argsort(np.ptp(ends.reshape(-1, 3), axis=0))[-2:]
    tree = shapely.STRtree(shapely.box(*low[:, axes].T, *high[:, axes].T))
    # Search within twice the tolerance because of rounding in the search tree. The caller then compares the
    # exact distances with the tolerance.
    reach = 2 * tolerance
    enlarged_boxes = shapely.box(*(low[:, axes] - reach).T, *(high[:, axes] + reach).T)
    for number, box in enumerate(enlarged_boxes):
        candidates = tree.query(box)
        distance = np.maximum(low[candidates] - high[number], low[number] - high[candidates]).max(axis=1)
        yield np.sort(candidates[(distance <= reach) & (candidates != number)])


def _is_covered(edge: np.ndarray, other_edges: np.ndarray, tolerance: float) -> bool:
    """Return True if ``other_edges``, shape (edges, 2, 3), cover the whole length of an edge."""
    length = float(np.linalg.norm(edge[1] - edge[0]))
    direction = (edge[1] - edge[0]) / length
    arms = other_edges - edge[0]
    position = arms @ direction
    distance = np.linalg.norm(arms - position[..., None] * direction, axis=-1)
    intervals = np.sort(position[(distance <= tolerance).all(axis=1)], axis=1).tolist()
    return not spaces(0.0, length, intervals, least=2 * tolerance)

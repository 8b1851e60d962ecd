"""Loads as forces at points of blocks, which keep their direction and their points as blocks move."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.thresholds import LOWER
from masonry_opt.errors import OptionError
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.edge_loads import LoadedPiece
from masonry_opt.problem.loads import Forces, loads

#: Simpson's rule on an edge, exact for what is cubic there: places along it, and weights.
_PLACES, _WEIGHTS = np.array([0.0, 0.5, 1.0]), np.array([1.0, 4.0, 1.0]) / 6


def placed(points: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Points at rest, shape (..., 2), where poses (x, y, θ), shape (..., 3), bring them: turned about the
    origin, then shifted."""
    return turned(points, poses) + poses[..., :2]


def turned(vectors: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Vectors, shape (..., 2), turned by the angle of poses, shape (..., 3)."""
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def moved(forces: Forces, poses: np.ndarray) -> np.ndarray:
    """Displacements of the points of forces, shape (f, 2), on movable blocks with these poses, shape
    (b, 3)."""
    return placed(forces.point, poses[forces.block]) - forces.point


def point_forces(assembly: Assembly) -> tuple[Forces, Forces]:
    """Dead and live forces of a scene in the plane.

    Raises OptionError if the scene has loads of whose points of action nothing is known here.
    """
    given = loads(assembly.scene, assembly.geometry, assembly.movable)
    found = _joined(assembly, "dead", given.weight, given.dead), _joined(assembly, "live", given.live)
    problem, centroid = assembly.problem, assembly.geometry.centroid[assembly.movable]
    units = problem.force_unit * np.array([1.0, 1.0, problem.length_unit])
    for forces, known in zip(found, (problem.dead, problem.live), strict=True):
        left = problem.by_block(forces.about(centroid)) / units - problem.by_block(known)
        if np.abs(left).max(initial=0.0) > LOWER * max(1.0, np.abs(known).max()):
            raise OptionError(
                f"{assembly.scene.called}: the capacity curve follows weights, forces at points and loads on "
                "edges alone: the scene has others, whose points of action are not known after the onset"
            )
    return found


def _joined(assembly: Assembly, kind: str, *parts: Forces) -> Forces:
    on_edges = [_on_edge(piece, assembly) for piece in assembly.loaded_pieces if piece.kind == kind]
    block, force, point = (
        np.concatenate([getattr(part, name) for part in (*parts, *on_edges)])
        for name in ("block", "force", "point")
    )
    return Forces(block, force, point, np.zeros((len(assembly.movable), 1)))


def _on_edge(piece: LoadedPiece, assembly: Assembly) -> Forces:
    """Three forces in place of a load on an edge."""
    along, (first, last) = piece.ends[1] - piece.ends[0], piece.intensity
    force = np.hypot(*along) * _WEIGHTS[:, None] * (first + np.outer(_PLACES, last - first))
    block = np.full(3, np.searchsorted(assembly.movable, piece.block))
    return Forces(block, force, piece.ends[0] + np.outer(_PLACES, along), np.zeros(0))

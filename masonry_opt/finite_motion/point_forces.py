"""Loads as forces at points of blocks, which keep their direction and their points as blocks move."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from masonry_opt.answer.thresholds import LOWER
from masonry_opt.errors import OptionError
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.edge_loads import LoadedPiece
from masonry_opt.problem.loads import Forces, loads

#: Simpson's rule on an edge, exact for what is cubic there: places along it, and weights.
_PLACES, _WEIGHTS = np.array([0.0, 0.5, 1.0]), np.array([1.0, 4.0, 1.0]) / 6


@dataclass(frozen=True)
class PointForces:
    """Forces of one kind, dead or live, in the case's units.

    Attributes
    ----------
    block: which of the movable blocks each acts on, shape (f,).
    force: shape (f, 2).
    point: where it acts at rest, relative to the geometry's origin, shape (f, 2).
    """

    block: np.ndarray
    force: np.ndarray
    point: np.ndarray

    def generalised(self, blocks: int, force_unit: float, length_unit: float) -> np.ndarray:
        """Of each block Σfx, Σfy, and about the origin Σ x × f and Σ x · f, shape (blocks, 4), in these
        units: turned by θ, forces that keep their direction have the moment Σ x × f cos θ − Σ x · f sin θ."""
        (x, y), (fx, fy) = self.point.T / length_unit, self.force.T / force_unit
        total = np.zeros((blocks, 4))
        np.add.at(total, self.block, np.column_stack([fx, fy, x * fy - y * fx, x * fx + y * fy]))
        return total

    def moved(self, poses: np.ndarray) -> np.ndarray:
        """Displacements of the points, shape (f, 2), of blocks with these poses, shape (b, 3)."""
        return placed(self.point, poses[self.block]) - self.point

    def work(self, poses: np.ndarray) -> float:
        """Work done on the way from rest."""
        return float((self.force * self.moved(poses)).sum())


def placed(points: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Points at rest, shape (..., 2), where poses (x, y, θ), shape (..., 3), bring them: turned about the
    origin, then shifted."""
    return turned(points, poses) + poses[..., :2]


def turned(vectors: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Vectors, shape (..., 2), turned by the angle of poses, shape (..., 3)."""
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def point_forces(assembly: Assembly) -> tuple[PointForces, PointForces]:
    """Dead and live forces of a scene in the plane.

    Raises OptionError if the scene has loads of whose points of action nothing is known here.
    """
    given = loads(assembly.scene, assembly.geometry, assembly.movable)
    dead = _joined(assembly, (given.weight, given.dead), "dead")
    live = _joined(assembly, (given.live,), "live")
    problem, centroid = assembly.problem, assembly.geometry.centroid[assembly.movable]
    for forces, known in ((dead, problem.dead), (live, problem.live)):
        total = forces.generalised(problem.blocks, problem.force_unit, problem.length_unit)
        arm = centroid / problem.length_unit
        total[:, 2] -= arm[:, 0] * total[:, 1] - arm[:, 1] * total[:, 0]
        if np.abs(total[:, :3].ravel() - known).max(initial=0.0) > LOWER * max(1.0, np.abs(known).max()):
            raise OptionError(
                f"{assembly.scene.called}: the capacity curve follows weights, forces at points and loads on "
                "edges alone: the scene has others, whose points of action are not known after the onset"
            )
    return dead, live


def _joined(assembly: Assembly, parts: Iterable[Forces], kind: str) -> PointForces:
    row_of = {int(block): row for row, block in enumerate(assembly.movable)}
    block, force, point = ([getattr(part, name) for part in parts] for name in ("block", "force", "point"))
    for piece in assembly.loaded_pieces:
        if piece.kind == kind:
            block.append(np.full(3, row_of[piece.block]))
            force.append(_on_edge(piece))
            point.append(piece.ends[0] + np.outer(_PLACES, piece.ends[1] - piece.ends[0]))
    return PointForces(np.concatenate(block), np.concatenate(force), np.concatenate(point))


def _on_edge(piece: LoadedPiece) -> np.ndarray:
    """Three forces in place of a load on an edge, shape (3, 2)."""
    length = np.hypot(*(piece.ends[1] - piece.ends[0]))
    first, last = piece.intensity
    return length * _WEIGHTS[:, None] * (first + np.outer(_PLACES, last - first))

"""How points of blocks move in a result that has a mechanism."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer import motion
from masonry_opt.answer.result import Result


def has_mechanism(result: Result) -> bool:
    """Whether there is a motion to show."""
    return bool(result.blocks["vx"].notna().all())


class Velocities:
    """Velocities of points of the scene's blocks, fixed ones included."""

    def __init__(self, result: Result) -> None:
        assembly = result.assembly
        self.centroid = assembly.geometry.centroid
        self.motion = np.zeros((len(self.centroid), 3))
        self.motion[assembly.movable] = result.blocks[["vx", "vy", "omega"]]

    def at(self, block: int, points: np.ndarray) -> np.ndarray:
        """Velocity of points, relative to the geometry's origin, of a block; shape (points, 2)."""
        vx, vy, omega = self.motion[block]
        arm = points - self.centroid[block]
        return np.array([vx, vy]) + omega * np.column_stack([-arm[:, 1], arm[:, 0]])


def fastest(result: Result) -> float:
    """Speed of the fastest corner; 1 where nothing moves."""
    assert result.solution.d is not None
    return motion.fastest(result.assembly, result.solution.d)

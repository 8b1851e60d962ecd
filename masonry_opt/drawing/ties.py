"""Ties and props as lines between their ends."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from masonry_opt.drawing.colours import STRUT
from masonry_opt.drawing.marks import Marks, moved
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role

#: Width in points, and dashes of those that yield.
_WIDTH = {Role.TIE: 1.8, Role.PROP: 3.6}
_YIELDS = (1.2, 0.8)


def strut_marks(assembly: Assembly, motion: np.ndarray, yields: np.ndarray) -> Iterable[Marks]:
    """Ties and props, those that yield dashed, and their ends.

    Parameters
    ----------
    motion: of the scene's blocks, shape (blocks, 3) or (blocks, 6).
    yields: which of the ties and props do, in the order of ``Result.ties``.
    """
    struts = [force for force in assembly.limited if force.role in _WIDTH]
    if not struts:
        return
    ends = np.array([[action.point for action in force.actions] for force in struts])
    with_ground = np.concatenate([motion, np.zeros((1, motion.shape[1]))])
    of_ends = with_ground[[[action.block for action in force.actions] for force in struts]]
    turning = _turning(ends, moved(ends, of_ends) - ends)
    role = np.array([force.role for force in struts])
    for kind, width in _WIDTH.items():
        for which, word, dashes in ((~yields, "", ()), (yields, ", yields", _YIELDS)):
            those = (role == kind) & which
            if those.any():
                halves, along = _halves(ends[those], of_ends[those], turning[those])
                yield Marks(kind, f"{kind}{word}", "line", STRUT, width, halves, along, dashes)
    points = ends.reshape(-1, 1, ends.shape[-1])
    yield Marks("ends", "", "square", STRUT, 4.0, points, of_ends.reshape(len(points), -1))


def _turning(ends: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Rotations of lines whose ends move so, shape (lines, 2, dim): shape (lines, 1), in space (lines, 3)."""
    along, apart = ends[:, 1] - ends[:, 0], moves[:, 1] - moves[:, 0]
    square = (along**2).sum(axis=1)[:, None]
    if ends.shape[-1] == 3:
        return np.asarray(np.cross(along, apart) / square)
    return (along[:, :1] * apart[:, 1:] - along[:, 1:] * apart[:, :1]) / square


def _halves(ends: np.ndarray, of_ends: np.ndarray, turning: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both halves of each line, and their motions as ``moved`` takes them: each goes with its end and turns
    with the line, so that they part in the middle where it lengthens."""
    turned = np.repeat(turning, 2, axis=0)
    middle = np.repeat(ends.mean(axis=1), 2, axis=0)
    at = ends.reshape(middle.shape)
    still = np.zeros_like(at)
    goes = moved(at, of_ends.reshape(len(at), -1)) - moved(at, np.column_stack([still, turned]))
    return np.stack([at, middle], axis=1), np.column_stack([goes, turned])

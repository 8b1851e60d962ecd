"""The resultants that joints carry, and where they act."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from masonry_opt.answer.result import Result
from masonry_opt.answer.thresholds import IDLE
from masonry_opt.problem.assembly import Assembly

#: Blocks in a row, each between two others, from which their points of thrust make a line.
_CHAIN = 3


@dataclass(frozen=True)
class Thrust:
    """What each joint carries, in the order of ``Result.joints``; NaN of a result without forces.

    Attributes
    ----------
    force: resultant on the joint's first block (on the second it is the opposite), in the case's unit of
        force, shape (c, 2).
    point: where it acts, in the case's coordinates; NaN where nothing presses the joint together, shape
        (c, 2).
    """

    force: np.ndarray
    point: np.ndarray


def thrust(result: Result) -> Thrust:
    """Resultants n, s at m / n from the joint's middle: together they do what n, s, m do in eq. (1)."""
    joints, frame = result.assembly.joints, result.joints
    n, s, m = (frame[name].to_numpy() for name in ("n", "s", "m"))
    # The direction of s. Where a joint has length it runs from start to end.
    along = np.column_stack([joints.normal[:, 1], -joints.normal[:, 0]])
    force = n[:, None] * joints.normal + s[:, None] * along
    pressed = n > IDLE * np.abs(n).max(initial=0.0)
    off = np.divide(m, n, out=np.full_like(n, np.nan), where=pressed)
    return Thrust(force, frame[["x", "y"]].to_numpy() + off[:, None] * along)


def chains(assembly: Assembly, acts: np.ndarray) -> np.ndarray:
    """Pairs of joints that a line of thrust joins, shape (pairs, 2): those of blocks that have two joints,
    both pressed, in rows of at least three.

    Parameters
    ----------
    acts: whether each joint is pressed together, shape (c,).
    """
    joints, count = assembly.joints, len(assembly.scene.blocks)
    sides = np.concatenate([joints.first, joints.second])
    number = np.tile(np.arange(len(joints.first)), 2)
    between = np.bincount(sides, minlength=count) == 2
    between &= np.bincount(sides[acts[number]], minlength=count) == 2
    movable = np.zeros(count, dtype=bool)
    movable[assembly.movable] = True
    between &= movable
    linked = between[joints.first] & between[joints.second]
    links = sp.coo_array(
        (np.ones(linked.sum()), (joints.first[linked], joints.second[linked])), shape=(count, count)
    )
    _, row = connected_components(links, directed=False)
    in_chain = between & (np.bincount(row)[row] >= _CHAIN)
    order = np.argsort(sides, kind="stable")
    return number[order][in_chain[sides[order]]].reshape(-1, 2)

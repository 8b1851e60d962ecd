"""Change the length of ties and props as blocks move."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.displaced import placed
from masonry_opt.problem.limited_forces import LimitedForce, Role


class StrutPath(NamedTuple):
    """Lengths of one tie or prop along a capacity curve."""

    role: Role  #: ``Role.TIE`` or ``Role.PROP``
    name: str  #: name of the tie or prop
    at_rest: float  #: length at rest
    #: Extension of the tie, or shortening of the prop, in each state of the curve, shape (states,).
    change: np.ndarray


def strut_ends(force: LimitedForce, poses: np.ndarray) -> np.ndarray:
    """Return the displaced ends of a tie or prop, shape (2, dim).

    ``poses`` has one row for each block of the scene, and a last row for the ground.
    """
    blocks = np.array([action.block for action in force.actions])
    return placed(np.array([action.point for action in force.actions]), poses[blocks])


def strut_paths(assembly: Assembly, poses: Sequence[np.ndarray]) -> list[StrutPath]:
    """Return the lengths of all ties and props along a capacity curve.

    ``poses`` contains the poses of all blocks in each state of the curve; the first state is at rest.
    """
    paths = []
    for force in assembly.limited:
        if force.role not in (Role.TIE, Role.PROP):
            continue
        with_ground = (np.vstack([state, np.zeros((1, state.shape[1]))]) for state in poses)
        ends = np.array([strut_ends(force, state) for state in with_ground])
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        sense = 1.0 if force.role is Role.TIE else -1.0
        paths.append(StrutPath(force.role, force.name, float(length[0]), sense * (length - length[0])))
    return paths

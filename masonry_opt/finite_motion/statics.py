"""Forces of displaced blocks: the greatest load factor, and whether any forces bear a given one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from masonry_opt.answer.thresholds import IDLE
from masonry_opt.effort import Effort
from masonry_opt.finite_motion.moved_joints import MovedJoints
from masonry_opt.finite_motion.point_forces import turned
from masonry_opt.solvers.highs_lp import LinearProgram
from masonry_opt.solvers.highs_session import HighsSession
from masonry_opt.solvers.lp import Verdict


@dataclass(frozen=True)
class ForceOptimum:
    """An optimum of statics.

    Attributes
    ----------
    value: load factor, or by how much yield conditions are violated at the least, in the unit of force.
    motion: rates of the poses of the blocks, and the ground, that the multipliers of equilibrium are, shape
        (blocks + 1, 3).
    pressed: joints with any force, shape (joints,).
    """

    value: float
    motion: np.ndarray
    pressed: np.ndarray


def moments_turned(loads: np.ndarray, angle: np.ndarray, about: np.ndarray | None = None) -> np.ndarray:
    """Generalised loads (fx, fy, x × f, x · f), shape (blocks, 4), of blocks turned by angles: fx, fy and
    moment about the point that was the origin, or points relative to it, shape (blocks, 3)."""
    moment = loads[:, 2] * np.cos(angle) - loads[:, 3] * np.sin(angle)
    if about is not None:
        moment -= about[:, 0] * loads[:, 1] - about[:, 1] * loads[:, 0]
    return np.column_stack([loads[:, :2], moment])


@dataclass(frozen=True)
class ForceProgram:
    """Forces of displaced blocks by linear programs.

    Attributes
    ----------
    dead, live: as :meth:`~.PointForces.generalised` gives them, shape (blocks, 4).
    """

    joints: MovedJoints
    dead: np.ndarray
    live: np.ndarray
    effort: Effort

    def solve(self, touch: np.ndarray, poses: np.ndarray, load_factor: float | None) -> ForceOptimum | None:
        """Linear program of equilibrium of the displaced blocks and yield of the corners that touch; None if
        the load factor has no limit.

        Closed joints carry n ≥ 0 in both corners and |s| ≤ c + μ n; a corner that touches alone n ≥ 0 and
        |s| ≤ μ n, on the edge that it touches, and where two corners meet on the edges of both.

        Parameters
        ----------
        touch: corners that touch, shape (joints, 2).
        poses: of the blocks and the ground, shape (blocks + 1, 3).
        load_factor: to be borne with the least violation; None: the greatest is sought.
        """
        joints, blocks = self.joints, len(self.dead)
        joint, corner = np.nonzero(touch)
        shears = np.flatnonzero(touch.any(axis=1))
        place = np.concatenate([joints.corner[joint, corner], joints.corner[shears, touch[shears].argmax(1)]])
        of = np.concatenate([joint, shears])
        along = np.concatenate([joints.normal[joint], joints.tangent[shears]])
        force = turned(along, poses[joints.ends[of, 0]])
        places, values, columns = [], [], np.arange(len(of))
        for side, sign in enumerate((1.0, -1.0)):
            block = joints.ends[of, side]
            arm = turned(place - joints.centroid[block], poses[block])
            moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
            places.append(3 * block[:, None] + np.arange(3))
            values.append(sign * np.column_stack([force, moment]))
        where = np.concatenate(places).ravel(), np.repeat(np.tile(columns, 2), 3)
        entries = np.concatenate(values).ravel(), where
        balance = sp.csr_array(sp.coo_array(entries, shape=(3 * blocks + 3, len(of))))[: 3 * blocks]
        # Moments about the centroids: about a common origin they would be differences of large numbers.
        middle = turned(joints.centroid[:-1], poses[:-1])
        angle, both = poses[:-1, 2], (self.dead, self.live)
        f_dead, f_live = (moments_turned(loads, angle, middle).ravel() for loads in both)
        limits, cohesion = _limits(joints, touch, poses)
        # Columns: forces, then λ, or by how much equilibrium (from both sides) and yield are missed: hinges
        # leave the forces of given λ no room, so that without it rounding would make the program infeasible.
        seeks, rows, yields = load_factor is None, 3 * blocks, len(cohesion)
        if load_factor is None:
            parts, last = [balance, limits], np.append(f_live, np.zeros(yields))
            lower, upper = np.append(-f_dead, -cohesion), np.append(-f_dead, np.full(yields, np.inf))
        else:
            load = f_dead + load_factor * f_live
            parts, last = [balance, -balance, limits], np.ones(2 * rows + yields)
            lower, upper = np.concatenate([-load, load, -cohesion]), np.full(2 * rows + yields, np.inf)
        matrix = sp.hstack([sp.vstack(parts), sp.csr_array(last[:, None])], format="csc")
        size = matrix.shape[1]
        low, cost, high = np.full(size, -np.inf), np.zeros(size), np.full(size, np.inf)
        low[-1], cost[-1] = (-np.inf, -1.0) if seeks else (0.0, 1.0)
        key = object()
        program = LinearProgram(cost, matrix, lower, upper, low, high, {id(key): np.arange(size)}, {})
        session = HighsSession(program, self.effort, "finite motion", small_matrix_value=1e-12)
        if session.solve() is not Verdict.OPTIMAL:
            return None
        x = session.values(key)
        motion = np.zeros((blocks + 1, 3))
        multipliers = session.multipliers()
        pulls = -multipliers[:rows] if seeks else multipliers[rows : 2 * rows] - multipliers[:rows]
        motion[:-1] = pulls.reshape(-1, 3)
        motion[:-1, :2] += motion[:-1, 2:] * np.column_stack([middle[:, 1], -middle[:, 0]])
        sizes = np.zeros(len(touch))
        np.maximum.at(sizes, of, np.abs(x[:-1]))
        return ForceOptimum(float(x[-1]), motion, sizes > IDLE * sizes.max(initial=0.0))


def _limits(joints: MovedJoints, touch: np.ndarray, poses: np.ndarray) -> tuple[sp.csr_array, np.ndarray]:
    """Yield conditions ``limits @ forces + cohesion ≥ 0`` of forces n of the corners that touch, then s of
    the joints that do."""
    (joint, corner), shears = np.nonzero(touch), np.flatnonzero(touch.any(axis=1))
    row_of_shear = np.full(len(touch), -1)
    row_of_shear[shears] = len(joint) + np.arange(len(shears))
    width = len(joint) + len(shears)
    coefficients: list[tuple[list[int], list[float]]] = []
    constants: list[float] = []
    angle = poses[joints.ends, 2]
    of_joint: dict[int, list[int]] = {}
    for column, j in enumerate(joint.tolist()):
        of_joint.setdefault(j, []).append(column)
    for j, normals in of_joint.items():
        mu, shear = float(joints.friction[j]), int(row_of_shear[j])
        if len(normals) == 2:
            coefficients += [([column], [1.0]) for column in normals]
            constants += [0.0, 0.0]
            if np.isfinite(mu):
                coefficients += [([*normals, shear], [mu, mu, sense]) for sense in (1.0, -1.0)]
                constants += 2 * [float(joints.cohesion[j])]
            continue
        turn = float(angle[j, 1] - angle[j, 0])
        for side, back in enumerate((0.0, turn)):
            if not joints.faces[j, corner[normals[0]], side]:
                continue
            # Force along normal and tangent of this block's edge, turned from the first one's.
            cos, sin = float(np.cos(back)), float(np.sin(back))
            n, s = np.array([cos, -sin]), np.array([sin, cos])
            lines = [n] + ([mu * n + s, mu * n - s] if np.isfinite(mu) else [])
            coefficients += [([normals[0], shear], line.tolist()) for line in lines]
            constants += [0.0] * len(lines)
    rows = np.repeat(np.arange(len(coefficients)), [len(columns) for columns, _ in coefficients])
    columns = np.concatenate([columns for columns, _ in coefficients])
    values = np.concatenate([values for _, values in coefficients])
    return sp.csr_array((values, (rows, columns)), shape=(len(coefficients), width)), np.array(constants)

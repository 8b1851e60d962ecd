"""Rigid bodies that hinge in points: equilibrium and motion at finite rotations.

Unknowns are the poses (x, y, θ) of the bodies, the force in each hinge, and λ:
    Q(θ, λ) + G(θ)ᵀ f = 0,    g(poses) = 0,
with Q the generalised loads, g the distance of the two places of each hinge point, G = ∂g/∂poses. With one
degree of freedom λ is that of virtual work; with more the solutions are still a line, on which each of them
is in equilibrium.
"""

from dataclasses import dataclass, replace

import numpy as np

from masonry_opt.finite_motion.moved_blocks import MovedBlocks, placed, turned
from masonry_opt.problem.loads import moment_of
from masonry_opt.scene.rows import dots

#: Share of the largest singular value below which equations depend on each other (one hinge point of several
#: joints gives the same equations several times).
_DEPENDENT = 1e-8

#: Newton steps of one correction, and the residual at which it ends.
_STEPS, _SOLVED = 12, 1e-13

#: Residual up to which a correction that comes no nearer is one: rounding.
_ROUNDING = 1e-10


@dataclass(frozen=True)
class PathPoint:
    """A point of the path: poses of the bodies, shape (bodies, 3), forces in the hinges on the first body,
    shape (hinges, 2), and λ."""

    poses: np.ndarray
    forces: np.ndarray
    load_factor: float


class Chain:
    """The bodies of joints that are closed, and the hinges between them.

    Parameters
    ----------
    touch: which corners of the joints touch, shape (joints, 2).
    """

    def __init__(self, blocks: MovedBlocks, touch: np.ndarray) -> None:
        self.body = blocks.bodies(touch)
        self.count = int(self.body.max())  # the ground's number
        self.dead, self.live = (
            (self.body[blocks.movable][each.block], each.point, each.force)
            for each in (blocks.dead, blocks.live)
        )
        ends = self.body[blocks.blocks]
        hinges = np.flatnonzero((touch.sum(axis=1) == 1) & (ends[:, 0] != ends[:, 1]))
        self.ends = ends[hinges]
        self.at = blocks.corner[hinges, touch[hinges].argmax(axis=1)]

    def start(self, of_blocks: np.ndarray) -> PathPoint:
        """The point with these poses of the blocks: forces and λ by least squares."""
        poses = np.zeros((self.count + 1, 3))
        poses[self.body] = of_blocks
        point = PathPoint(poses[:-1], np.zeros((len(self.at), 2)), 0.0)
        rest, slope = self._system(point)
        rows, free = slice(0, 3 * self.count), slice(3 * self.count, None)
        found = np.linalg.lstsq(slope[rows, free], -rest[rows], rcond=_DEPENDENT)[0]
        return replace(point, forces=found[:-1].reshape(-1, 2), load_factor=float(found[-1]))

    def of_blocks(self, of_bodies: np.ndarray) -> np.ndarray:
        """Poses, or their rates, of all blocks, shape (blocks, 3)."""
        return np.vstack([of_bodies, np.zeros(3)])[self.body]

    def tangents(self, point: PathPoint) -> np.ndarray:
        """Directions in which the line goes on, rates of poses then of λ, shape (k, 3 · bodies + 1): one,
        none where bodies jam, several where it branches."""
        _, slope = self._system(point)
        _, sizes, rows = np.linalg.svd(slope)
        rank = int((sizes > _DEPENDENT * sizes.max(initial=1.0)).sum())
        null = rows[rank:].T
        moves = null[[*range(3 * self.count), slope.shape[1] - 1]]
        left, sizes, _ = np.linalg.svd(moves, full_matrices=False)
        return left[:, sizes > _DEPENDENT].T

    def corrected(self, start: PathPoint, row: np.ndarray, value: float) -> PathPoint | None:
        """The point of the line at which row · (poses, λ) has a value; None if Newton steps find none."""
        point, full = start, np.zeros(3 * self.count + 2 * len(self.at) + 1)
        full[: 3 * self.count], full[-1] = row[:-1], row[-1]
        size, last = 1.0 + abs(value), np.inf
        for _ in range(_STEPS):
            rest, slope = self._system(point)
            now = float(row @ np.append(point.poses.ravel(), point.load_factor))
            rest, slope = np.append(rest, now - value), np.vstack([slope, full])
            of = np.ones(len(rest))
            of[: 3 * self.count], of[-1] = 1.0 + np.abs(point.forces).max(initial=0.0), size
            residual = float(np.abs(rest / of).max())
            if residual <= _SOLVED or (residual <= _ROUNDING and residual > 0.5 * last):
                return point
            if residual > 1e3:
                return None
            last = residual
            step = np.linalg.lstsq(slope, -rest, rcond=_DEPENDENT)[0]
            forces = point.forces + step[3 * self.count : -1].reshape(-1, 2)
            poses = point.poses + step[: 3 * self.count].reshape(-1, 3)
            point = PathPoint(poses, forces, point.load_factor + float(step[-1]))
        return None

    def _system(self, point: PathPoint) -> tuple[np.ndarray, np.ndarray]:
        """Residuals of equilibrium, then of the hinges, shape (3 · bodies + 2 · hinges,), and their
        derivatives by poses, forces and λ."""
        bodies, hinges = self.count, len(self.at)
        poses = np.vstack([point.poses, np.zeros(3)])
        live = self._acting(poses, *self.live)
        acting = self._acting(poses, *self.dead) + point.load_factor * live
        gap = np.zeros((hinges, 2))
        G = np.zeros((hinges, 2, bodies + 1, 3))
        each = np.arange(hinges)
        for side, sign in enumerate((1.0, -1.0)):
            of = self.ends[:, side]
            acting += self._acting(poses, of, self.at, sign * point.forces)
            arm = turned(self.at, poses[of])
            gap += sign * placed(self.at, poses[of])
            G[each[:, None], [0, 1], of[:, None], [0, 1]] += sign
            G[each, :, of, 2] += sign * np.column_stack([-arm[:, 1], arm[:, 0]])
        flat = G[:, :, :-1].reshape(2 * hinges, 3 * bodies)
        rest = np.append(acting[:-1, :3].ravel(), gap.ravel())
        slope = np.zeros((len(rest), len(rest) + 1))
        turns = 3 * np.arange(bodies) + 2
        slope[turns, turns] = -acting[:-1, 3]
        slope[: 3 * bodies, 3 * bodies : -1] = flat.T
        slope[3 * bodies :, : 3 * bodies] = flat
        slope[: 3 * bodies, -1] = live[:-1, :3].ravel()
        return rest, slope

    @staticmethod
    def _acting(poses: np.ndarray, body: np.ndarray, at: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Of forces on bodies, at points at rest, the sums fx, fy, x × f about the origin and x · f, by which
        the moment falls as a body turns, shape (bodies + 1, 4)."""
        total, arm = np.zeros((len(poses), 4)), turned(at, poses[body])
        np.add.at(total, body, np.column_stack([force, moment_of(arm, force), dots(arm, force)]))
        return total

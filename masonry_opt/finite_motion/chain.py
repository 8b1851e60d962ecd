"""Rigid bodies that hinge in points: equilibrium and motion at finite rotations.

Unknowns are the poses (x, y, θ) of the bodies, the force in each hinge, and λ:
    Q(θ, λ) + G(θ)ᵀ f = 0,    g(poses) = 0,
with Q the generalised loads, g the distance of the two places of each hinge point, G = ∂g/∂poses. With one
degree of freedom λ is that of virtual work; with more the solutions are still a line, on which each of them
is in equilibrium.
"""

import numpy as np

from masonry_opt.finite_motion.moved_blocks import MovedBlocks, placed, turned
from masonry_opt.problem.loads import moment_of
from masonry_opt.scene.rows import dots

#: Share of the largest singular value below which equations depend on each other: one hinge point of several
#: joints gives the same equations several times.
_DEPENDENT = 1e-8
_STEPS, _SOLVED = 12, 1e-13  #: Newton steps of one correction, and the residual at which it ends.
_ROUNDING = 1e-10  #: Residual up to which a correction that comes no nearer is one: rounding.


class Chain:
    """The bodies of joints that are closed, and the hinges between them, given which corners of the joints
    touch, shape (joints, 2).

    A point of the path has all unknowns in a row: poses of the bodies, shape (bodies, 3), forces in the
    hinges on the first body, shape (hinges, 2), and λ.
    """

    def __init__(self, blocks: MovedBlocks, touch: np.ndarray) -> None:
        self.touch, self.body = touch, blocks.bodies(touch)
        self.count = int(self.body.max())  # the ground's number
        body, loads = self.body[blocks.movable], (blocks.dead, blocks.live)
        self.dead, self.live = ((body[each.block], each.point, each.force) for each in loads)
        ends = self.body[blocks.blocks]
        hinges = np.flatnonzero((touch.sum(axis=1) == 1) & (ends[:, 0] != ends[:, 1]))
        self.ends = ends[hinges]
        self.at = blocks.corner[hinges, touch[hinges].argmax(axis=1)]

    def start(self, of_blocks: np.ndarray) -> np.ndarray:
        """The point with these poses of the blocks: forces and λ by least squares."""
        poses, moves = np.zeros((self.count + 1, 3)), 3 * self.count
        poses[self.body] = of_blocks
        point = np.append(poses[:-1].ravel(), np.zeros(2 * len(self.at) + 1))
        rest, slope = self._system(point)
        point[moves:] = np.linalg.lstsq(slope[:moves, moves:], -rest[:moves], rcond=_DEPENDENT)[0]
        return point

    def of_blocks(self, point: np.ndarray) -> np.ndarray:
        """Poses of all blocks in a point, or their rates in a direction, shape (blocks, 3)."""
        return np.vstack([point[: 3 * self.count].reshape(-1, 3), np.zeros(3)])[self.body]

    def tangents(self, point: np.ndarray) -> np.ndarray:
        """Directions in which the line goes on, rates of poses and of λ alone, shape (k, unknowns): one, none
        where bodies jam, several where it branches."""
        _, slope = self._system(point)
        _, sizes, rows = np.linalg.svd(slope)
        rank = int((sizes > _DEPENDENT * sizes.max(initial=1.0)).sum())
        moves = np.r_[: 3 * self.count, len(point) - 1]
        left, sizes, _ = np.linalg.svd(rows[rank:, moves].T, full_matrices=False)
        found = np.zeros((np.count_nonzero(sizes > _DEPENDENT), len(point)))
        found[:, moves] = left[:, sizes > _DEPENDENT].T
        return found

    def corrected(self, start: np.ndarray, row: np.ndarray, value: float) -> np.ndarray | None:
        """The point of the line whose product with a row has a value; None if Newton steps find none."""
        point, moves, last = start, 3 * self.count, np.inf
        for _ in range(_STEPS):
            rest, slope = self._system(point)
            rest, slope = np.append(rest, row @ point - value), np.vstack([slope, row])
            of = np.ones(len(rest))
            of[:moves], of[-1] = 1.0 + np.abs(point[moves:-1]).max(initial=0.0), 1.0 + abs(value)
            residual = float(np.abs(rest / of).max())
            if residual <= _SOLVED or (residual <= _ROUNDING and residual > 0.5 * last):
                return point
            if residual > 1e3:
                return None
            last = residual
            point = point + np.linalg.lstsq(slope, -rest, rcond=_DEPENDENT)[0]
        return None

    def _system(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals of equilibrium, then of the hinges, shape (3 · bodies + 2 · hinges,), and their
        derivatives by poses, forces and λ."""
        bodies, hinges, forces = self.count, len(self.at), point[3 * self.count : -1].reshape(-1, 2)
        poses = np.vstack([point[: 3 * bodies].reshape(-1, 3), np.zeros(3)])
        live = self._acting(poses, *self.live)
        acting = self._acting(poses, *self.dead) + point[-1] * live
        gap = np.zeros((hinges, 2))
        G = np.zeros((hinges, 2, bodies + 1, 3))
        each = np.arange(hinges)
        for side, sign in enumerate((1.0, -1.0)):
            of = self.ends[:, side]
            acting += self._acting(poses, of, self.at, sign * forces)
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

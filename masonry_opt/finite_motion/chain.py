"""Equilibrium of a chain of rigid bodies with hinges, in the plane and at finite rotations."""

import numpy as np

from masonry_opt.finite_motion.moved_blocks import MovedBlocks
from masonry_opt.problem.displaced import placed, turned
from masonry_opt.problem.loads import moment_of
from masonry_opt.scene.rows import dots

#: Singular values of the Jacobian of a chain's equations count as zero below this fraction of the largest
#: singular value. Some singular values are zero if joints share a hinge, because the equations are then
#: linearly dependent.
_RANK_TOLERANCE = 1e-8
#: Largest number of Newton iterations in one corrector step along the path. A step that needs more iterations
#: fails.
_NEWTON_ITERATIONS = 12
#: Newton's method has converged if the scaled residual, see :meth:`Chain.corrected`, is at most this value.
_CONVERGED = 1e-13
#: Newton's method also counts as converged if the scaled residual is at most this value and decreases by less
#: than half in an iteration. Rounding errors then prevent a much smaller residual.
_STALLED = 1e-10
#: Newton's method fails if the scaled residual exceeds this value, because the iterations diverge.
_DIVERGED = 1e3


class Chain:
    """Chain of rigid bodies with hinges, and its equations of equilibrium at finite rotations.

    A body consists of blocks that are connected by closed joints. A hinge is a joint that touches only at one
    corner. The unknowns are the poses (x, y, θ) of the bodies, the force f in each hinge, and λ:

        Q(θ, λ) + G(θ)ᵀ f = 0        (a) equilibrium, with the generalised loads Q
        g(poses) = 0                 (b) the hinge point of both bodies coincides; G = ∂g/∂poses

    There is one equation fewer than unknowns, so the solutions form a curve. If the bodies have one degree of
    freedom, λ follows from virtual work. A point of the curve is a vector of all unknowns: poses (bodies, 3),
    forces of the hinges on their first body (hinges, 2), and λ.
    """

    def __init__(self, blocks: MovedBlocks, touch: np.ndarray) -> None:
        self.touch, self.body = touch, blocks.bodies(touch)
        # Number of bodies that can move, which is also the index of the ground in arrays of bodies.
        self.count = int(self.body.max())
        body = self.body[blocks.movable]
        self.dead = body[blocks.dead.block], blocks.dead.point, blocks.dead.force
        self.live = body[blocks.live.block], blocks.live.point, blocks.live.force
        ends = self.body[blocks.blocks]
        hinges = np.flatnonzero((touch.sum(axis=1) == 1) & (ends[:, 0] != ends[:, 1]))
        self.ends = ends[hinges]
        self.at = blocks.corner[hinges, touch[hinges].argmax(axis=1)]

    def start(self, of_blocks: np.ndarray) -> np.ndarray:
        """Return the point of the equilibrium curve at which the blocks have the poses ``of_blocks``.

        The poses have shape (blocks, 3). Hinge forces and λ follow from equilibrium by least squares.
        """
        poses, coordinates = np.zeros((self.count + 1, 3)), 3 * self.count
        poses[self.body] = of_blocks
        point = np.append(poses[:-1].ravel(), np.zeros(2 * len(self.at) + 1))
        residual, jacobian = self._system(point)
        matrix, right = jacobian[:coordinates, coordinates:], -residual[:coordinates]
        point[coordinates:] = np.linalg.lstsq(matrix, right, rcond=_RANK_TOLERANCE)[0]
        return point

    def of_blocks(self, point: np.ndarray) -> np.ndarray:
        """Return the poses of all blocks at a point of the curve, shape (blocks, 3).

        For a tangent of the curve, the result is the rates of the poses.
        """
        return np.vstack([point[: 3 * self.count].reshape(-1, 3), np.zeros(3)])[self.body]

    def tangents(self, point: np.ndarray) -> np.ndarray:
        """Return the tangents of the equilibrium curve at a point, one in each row, shape (k, unknowns).

        The tangents span the null space of the Jacobian, restricted to poses and λ. There is no tangent if
        the bodies are locked, and there are several tangents at a bifurcation.
        """
        _, jacobian = self._system(point)
        _, values, right_vectors = np.linalg.svd(jacobian)
        rank = int((values > _RANK_TOLERANCE * values.max(initial=1.0)).sum())
        poses_and_lambda = np.r_[: 3 * self.count, len(point) - 1]
        null_space = right_vectors[rank:, poses_and_lambda].T
        basis, values, _ = np.linalg.svd(null_space, full_matrices=False)
        tangents = np.zeros((np.count_nonzero(values > _RANK_TOLERANCE), len(point)))
        tangents[:, poses_and_lambda] = basis[:, values > _RANK_TOLERANCE].T
        return tangents

    def corrected(self, start: np.ndarray, row: np.ndarray, value: float) -> np.ndarray | None:
        """Find a point of the equilibrium curve that satisfies ``row @ point == value``, by Newton's method.

        The result is None if Newton's method does not converge. Convergence is judged by the scaled residual:
        the largest residual of all equations, after two divisions.

        - Residuals of equilibrium are divided by 1 + F, where F is the largest component of a hinge force.
        - The residual of ``row @ point == value`` is divided by 1 + |value|.
        """
        point, coordinates, previous_norm = start, 3 * self.count, np.inf
        for _ in range(_NEWTON_ITERATIONS):
            residual, jacobian = self._system(point)
            residual = np.append(residual, row @ point - value)
            jacobian = np.vstack([jacobian, row])
            scale = np.ones(len(residual))
            scale[:coordinates] = 1.0 + np.abs(point[coordinates:-1]).max(initial=0.0)
            scale[-1] = 1.0 + abs(value)
            norm = float(np.abs(residual / scale).max())
            stalled = norm <= _STALLED and norm > 0.5 * previous_norm
            if norm <= _CONVERGED or stalled:
                return point
            if norm > _DIVERGED:
                return None
            previous_norm = norm
            point = point + np.linalg.lstsq(jacobian, -residual, rcond=_RANK_TOLERANCE)[0]
        return None

    def _system(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residuals of the equilibrium and hinge equations, and their Jacobian.

        The equations are (a) and (b) in the docstring of the class. The derivatives are with respect to
        poses, forces and λ.
        """
        bodies, hinges, forces = self.count, len(self.at), point[3 * self.count : -1].reshape(-1, 2)
        poses = np.vstack([point[: 3 * bodies].reshape(-1, 3), np.zeros(3)])
        live = self._resultants(poses, *self.live)
        resultants = self._resultants(poses, *self.dead) + point[-1] * live
        gap = np.zeros((hinges, 2))
        G = np.zeros((hinges, 2, bodies + 1, 3))
        hinge = np.arange(hinges)
        for side, sign in enumerate((1.0, -1.0)):
            body = self.ends[:, side]
            resultants += self._resultants(poses, body, self.at, sign * forces)
            arm = turned(self.at, poses[body])
            gap += sign * placed(self.at, poses[body])
            G[hinge[:, None], [0, 1], body[:, None], [0, 1]] += sign
            G[hinge, :, body, 2] += sign * np.column_stack([-arm[:, 1], arm[:, 0]])
        # Select the columns of the bodies that can move; the last body is the ground.
        G_free = G[:, :, :-1].reshape(2 * hinges, 3 * bodies)
        residual = np.append(resultants[:-1, :3].ravel(), gap.ravel())
        jacobian = np.zeros((len(residual), len(residual) + 1))
        rotations = 3 * np.arange(bodies) + 2
        jacobian[rotations, rotations] = -resultants[:-1, 3]
        jacobian[: 3 * bodies, 3 * bodies : -1] = G_free.T
        jacobian[3 * bodies :, : 3 * bodies] = G_free
        jacobian[: 3 * bodies, -1] = live[:-1, :3].ravel()
        return residual, jacobian

    @staticmethod
    def _resultants(poses: np.ndarray, body: np.ndarray, at: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Return sums over the forces f with arms a on a body, shape (bodies + 1, 4): fx, fy, a × f, a · f.

        The arm a is the position ``at`` of the force's point of action at rest, rotated with the body. Forces
        have constant directions. The sum of a × f is the moment on the body. The sum of a · f is the negative
        derivative of this moment with respect to the rotation of the body.
        """
        total, arm = np.zeros((len(poses), 4)), turned(at, poses[body])
        np.add.at(total, body, np.column_stack([force, moment_of(arm, force), dots(arm, force)]))
        return total

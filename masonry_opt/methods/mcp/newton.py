"""The linear algebra of a Newton step: elimination onto the blocks, refinement, and a full factorisation.

Of the faces only rocking and crushing are eliminated from what the solution must satisfy; sliding stays
explicit (eliminated too, residuals stall near 1e-2). The joints' compliance is then inverted joint by joint,
which leaves a matrix of the blocks alone, 3b + 1 square (6b + 1 in space) with the pattern of a frame's
stiffness. It is factorised by SuperLU (SciPy) without pivoting, in one order for the whole pass.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from masonry_opt.methods.mcp.edge_form import EdgeForm, Iterate
from masonry_opt.problem.faces import KINDS

#: Stiffnesses are cut off so far above what the gap lets a mechanism have: beyond, the rounding of what
#: stands still (1e-16 of it) would drown the stiffness of what moves, which falls with the gap. The cut acts
#: like a proximal term: what it leaves, refinement takes off, or the next step. Contacts that give bound
#: stiffnesses themselves, and a cut below theirs leaves errors that no refinement takes off.
_CUT = 1e12

#: Refinements of a solution at most, and the error beyond which a full factorisation is made instead.
_REFINEMENTS, _MOST_ERROR = 6, 1e-8

#: Joints up to which a full factorisation (10 to 25 times the price of elimination) is made: at any step
#: whose elimination leaves too large an error, and for the projection at the end of a pass.
_FULL_UP_TO, _FULL_ONCE_UP_TO = 3000, 20_000


class SingularError(ArithmeticError):
    """The matrix has no factors."""


class Parts(NamedTuple):
    """Right-hand sides, or unknowns, of a Newton step.

    As right-hand sides: of statics (3b,), of z dp + p dz (senses, k), of the motion of edges and shears
    (3, c), and of the work. As unknowns: velocities (3b,), sliding rates (senses, k), forces x (3, c), and λ.
    """

    blocks: np.ndarray
    sliding: np.ndarray
    joints: np.ndarray
    load: float

    def plus(self, other: Parts, times: float = 1.0) -> Parts:
        """The sum, the other so many times."""
        return Parts(
            self.blocks + times * other.blocks,
            self.sliding + times * other.sliding,
            self.joints + times * other.joints,
            self.load + times * other.load,
        )


class Elimination:
    """What the Newton matrices of a scene share: the blocks of each joint, the pattern and its order."""

    def __init__(self, form: EdgeForm) -> None:
        self.form, problem = form, form.problem
        b, c, of_block = problem.blocks, problem.joints, problem.layout.rows
        entries = form.A.tocoo()
        joint, kind, block = entries.col % c, entries.col // c, entries.row // of_block
        # A joint's blocks, one where the other is fixed (-1), and its part of A, shape (c, 6, 3).
        touching = np.unique(joint * np.int64(b) + block)
        of_joint = touching // b
        second = np.r_[False, of_joint[1:] == of_joint[:-1]].astype(int)
        ends = np.full((2, c), -1)
        ends[second, of_joint] = touching % b
        self._levers = np.zeros((c, 2 * of_block, KINDS))
        end = (block != ends[0, joint]).astype(int)
        self._levers[joint, of_block * end + entries.row % of_block, kind] = entries.data
        self.size = size = problem.dead.size + 1
        components = np.arange(of_block)
        self._order = np.append((of_block * _order(ends, b)[:, None] + components).ravel(), size - 1)
        of_end = of_block * ends.T[:, :, None] + components
        rows = np.where(ends.T[:, :, None] >= 0, self._order[of_end], -1).reshape(c, -1)
        down, across = np.broadcast_arrays(rows[:, :, None], rows[:, None, :])
        self._kept = (down >= 0) & (across >= 0)
        loaded = np.flatnonzero(problem.live)
        last, diagonal = np.full(len(loaded), size - 1), np.arange(size)
        row = np.concatenate([down[self._kept], self._order[loaded], last, diagonal])
        column = np.concatenate([across[self._kept], last, self._order[loaded], diagonal])
        places, self._place = np.unique(column * np.int64(size) + row, return_inverse=True)
        self._indices = (places % size).astype(np.int32)
        self._starts = np.searchsorted(places // size, np.arange(size + 1)).astype(np.int32)
        self._border = np.concatenate([-problem.live[loaded], problem.live[loaded]])

    def of(self, form: EdgeForm) -> Elimination:
        """The same, of a form that differs in law or compliance alone."""
        other = copy(self)
        other.form = form
        return other

    def factors(self, stiffness: np.ndarray, regularisation: float) -> Factors:
        """Factors of the blocks' matrix for joint stiffnesses, shape (c, 3, 3).

        Raises SingularError if there are none.
        """
        of_joints = self._levers @ stiffness @ self._levers.transpose(0, 2, 1)
        values = np.concatenate([of_joints[self._kept], self._border, np.full(self.size, regularisation)])
        data = np.bincount(self._place, values, len(self._indices))
        matrix = sp.csc_matrix((data, self._indices, self._starts), shape=(self.size, self.size))
        try:
            lu = splu(
                matrix,
                permc_spec="NATURAL",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True, "Equil": False},
            )
        except RuntimeError as error:
            raise SingularError(str(error)) from None
        return Factors(lu, self._order)


class Factors:
    """Factors of a matrix of the blocks and λ."""

    def __init__(self, lu: object, order: np.ndarray) -> None:
        self._lu, self._order = lu, order

    def solve(self, blocks: np.ndarray, load: float) -> tuple[np.ndarray, float]:
        """Velocities (3b,) and λ."""
        right = np.empty(len(self._order))
        right[self._order] = np.append(blocks, load)
        solution = self._lu.solve(right)[self._order]  # type: ignore[attr-defined]
        return solution[:-1], float(solution[-1])


def _order(ends: np.ndarray, blocks: int) -> np.ndarray:
    """Position of each block in an elimination that keeps fill low (minimum degree, by SuperLU)."""
    first, second = ends[:, ends.min(axis=0) >= 0]
    pairs = (np.concatenate([first, second]), np.concatenate([second, first]))
    graph = sp.csc_array((np.ones(len(pairs[0])), pairs), shape=(blocks, blocks))
    dominant = sp.csc_matrix(graph + sp.diags_array(graph.sum(axis=0) + 1.0))
    lu = splu(dominant, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    position: np.ndarray = lu.perm_c
    return position


@dataclass
class NewtonSystem:
    """The equations of a Newton step about an iterate.

    Attributes
    ----------
    elimination: of the scene.
    at: the iterate.
    friction: slope of the shear limits in the matrix, shape (k,); the true one is Newton's.
    regularisation: added to the diagonal of the blocks' matrix.
    exact: error of a solution at which its refinement ends.
    full: whether the equations are factorised as they stand, with pivoting, where that is affordable; else
        only once elimination leaves too large an error.
    rigid: whether contacts are rigid in the matrix, whether or not they give.
    """

    elimination: Elimination
    at: Iterate
    friction: np.ndarray
    regularisation: float
    exact: float
    full: bool = False
    rigid: bool = False

    def __post_init__(self) -> None:
        self._form = self.elimination.form
        self._compliance = np.zeros((3, 1)) if self.rigid else self._form.compliance
        problem = self._form.problem
        self._slope = problem.dilatancy
        self._affordable = problem.joints <= _FULL_UP_TO
        self.full = self.full and problem.joints <= _FULL_ONCE_UP_TO
        self._edges = slice(self._form.edges)
        self._rocking = self.at.opening / self.at.x[self._edges]
        self._crushing: sp.csr_array | None = None
        if len(self._form.bounded):
            crushing = sp.diags_array(self.at.crushed / self.at.room)
            self._crushing = (self._form.G.T @ crushing @ self._form.G).tocsr()
        steep = self._form.steep
        self._scale = 1 / np.maximum(self.at.z / steep, self.at.slip * steep)
        cut = _CUT * self.at.energy / max(float(self.at.d @ self.at.d), 1.0)
        self._most = np.inf if self._compliance.all() else cut

    def solve(self, right: Parts) -> tuple[Parts, float]:
        """A solution and its error: the largest residual over the largest entry of the right-hand side.

        Raises SingularError if the matrix has no factors.
        """
        size = self._norm(right)
        solution = self._approximate(right)
        error, best = np.inf, solution
        for _ in range(_REFINEMENTS):
            left = right.plus(self.apply(solution), -1.0)
            now = self._norm(left)
            if not now < error:
                break
            error, best = now, solution
            if now <= self.exact * max(size, 1e-8):
                break
            solution = solution.plus(self._approximate(left))
        if error > _MOST_ERROR * size and self._affordable and not self.full:
            self.full = True
            return self.solve(right)
        return best, error / max(size, 1e-300)

    def apply(self, of: Parts) -> Parts:
        """The left-hand sides: rocking and crushing eliminated, sliding explicit."""
        problem, at = self._form.problem, self.at
        joints = self._form.moves(of.blocks) - self._form.follow(of.sliding)
        joints[self._edges] += self._rocking * of.joints[self._edges]
        joints += self._compliance * of.joints
        if self._crushing is not None:
            crushed = self._crushing @ of.joints[self._edges].ravel()
            joints[self._edges] += crushed.reshape(joints[self._edges].shape)
        return Parts(
            self._form.A @ of.joints.ravel() + of.load * problem.live,
            at.z * of.sliding + at.slip * self._form.slacks(of.joints, self.friction),
            joints,
            float(problem.live @ of.blocks),
        )

    def _norm(self, of: Parts) -> float:
        sliding = np.abs(of.sliding * self._scale).max(initial=0.0)
        return float(max(np.abs(of.blocks).max(), sliding, np.abs(of.joints).max(), abs(of.load)))

    def _approximate(self, right: Parts) -> Parts:
        return self._by_full_factors(right) if self.full else self._by_elimination(right)

    def _by_elimination(self, right: Parts) -> Parts:
        rates = right.sliding / self.at.z
        drive = right.joints + self._form.follow(rates)
        blocks = self._form.A @ self._stiff(drive).ravel() - right.blocks
        velocities, load = self._factors.solve(blocks, right.load)
        forces = self._stiff(drive - self._form.moves(velocities))
        slip = rates - self.at.slip * self._form.slacks(forces, self.friction) / self.at.z
        return Parts(velocities, slip, forces, load)

    def _of_edges(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stiffness of each edge, shape (2, c), what the two of a joint that can crush share, shape (c,), and
        the determinant of both, shape (c,)."""
        edges = np.minimum(1 / (self._rocking + self._compliance[:2]), self._most)
        across = np.zeros(edges.shape[1])
        determinant = edges[0] * edges[1]
        if self._crushing is not None:
            joints = self._form.bounded
            # The inverse of 1/edges + what crushing adds, two by two.
            added = self._crushing.diagonal().reshape(2, -1)[:, joints]
            own = 1 / edges[:, joints]
            first, second = own + added
            shared = self._crushing.diagonal(len(across))[joints]
            # Where one chord outweighs all else, what it adds has no determinant but rounding.
            rest = np.maximum(added.prod(axis=0) - shared**2, 0.0)
            inverse = 1 / (own.prod(axis=0) + (own * added[::-1]).sum(axis=0) + rest)
            edges[:, joints] = np.stack([second, first]) * inverse
            across[joints] = -shared * inverse
            determinant[joints] = inverse
        return edges, across, determinant

    @cached_property
    def _stiffness(self) -> np.ndarray:
        """What turns motions of edges and shears into forces x, joint by joint, shape (3, 3, c): the inverse
        of the joints' compliance."""
        return self._between_two_limits() if self._form.problem.layout.dimension == 2 else self._in_a_cone()

    def _in_a_cone(self) -> np.ndarray:
        """The stiffness of contact points, by elimination with pivoting of each point's rates and forces."""
        problem, at = self._form.problem, self.at
        layout, sliding = problem.layout, problem.sliding
        c, sides = problem.joints, len(layout.senses)
        matrices = np.zeros((c, 3 + sides, 3 + sides))
        diagonal = np.arange(3 + sides)
        own = np.ones((3 + sides, c))
        own[:3] = self._compliance
        own[: self._form.edges] += self._rocking
        if self._crushing is not None:
            own[0] += self._crushing.diagonal()
        own[:3] = np.maximum(own[:3], 1 / self._most)
        own[3:, sliding] = at.z * self._scale
        rate = np.maximum(at.slip, at.z / self._most) * self._scale
        matrices[:, diagonal, diagonal] = own.T
        matrices[sliding, 0, 3:] = -layout.factor * self._slope[:, None]
        matrices[sliding, 1:3, 3:] = layout.senses.T
        matrices[sliding, 3:, 0] = rate.T * (layout.factor * self.friction)[:, None]
        matrices[sliding, 3:, 1:3] = -rate.T[:, :, None] * layout.senses
        motions = np.eye(3 + sides, 3)
        try:
            forces = np.linalg.solve(matrices, np.broadcast_to(motions, (c, *motions.shape)))
        except np.linalg.LinAlgError as error:
            raise SingularError(str(error)) from None
        return forces[:, :3].transpose(1, 2, 0)

    def _between_two_limits(self) -> np.ndarray:
        """The stiffness of joints in the plane, in closed form.

        With v = z/p of each sliding face and x/u of each edge, and T what these forces take off the sliding
        of both senses: x₂ = v₂ (u₂ − ψ T), x₃ = v₃ (u₃ − ψ T), and μ n ∓ s = v (T ∓ (u_s − ε s))/2. Entries
        are written so that large numbers of one sign are added (but for two of joints that crush). While
        sliding contracts (ψ < 0) the pivot may be small: refinement, or the full factors, catch that.
        """
        edges, across, determinant = self._of_edges()
        stiffness = np.zeros((3, 3, len(across)))
        stiffness[0, 0], stiffness[1, 1], stiffness[0, 1] = *edges, across
        gives = np.broadcast_to(self._compliance[2], len(across))
        stiffness[2, 2] = 1 / (1 / self._most + gives)  # of joints whose friction is unlimited
        of, faces = self._form.sliding, np.minimum(self.at.z / self.at.slip, self._most)
        mean, half, both = faces.sum(axis=0) / 2, (faces[0] - faces[1]) / 2, (edges + across)[:, of]
        wedges = 2 * self.friction * self._slope * (both[0] + both[1])
        along = faces[0] * faces[1] + mean * wedges
        follows = 2 * self.friction * self._slope * (1 + gives[of] * mean / 2)
        mean += gives[of] * faces[0] * faces[1] / 2
        wedges = follows * (both[0] + both[1])
        share, wedged = 1 / (mean + wedges), follows * determinant[of]
        stiffness[0, 0, of] = (edges[0, of] * mean + wedged) * share
        stiffness[1, 1, of] = (edges[1, of] * mean + wedged) * share
        stiffness[0, 1, of] = (across[of] * mean - wedged) * share
        stiffness[1, 0] = stiffness[0, 1]
        stiffness[:2, 2][:, of] = -self._slope * half * share * both
        stiffness[2, :2][:, of] = -self.friction * half * share * both
        stiffness[2, 2, of] = along * share / 2
        return stiffness

    def _stiff(self, motion: np.ndarray) -> np.ndarray:
        """Forces x that move edges and shear so, shape (3, c) each."""
        forces: np.ndarray = np.einsum("ijc,jc->ic", self._stiffness, motion)
        return forces

    @cached_property
    def _factors(self) -> Factors:
        return self.elimination.factors(self._stiffness.transpose(2, 0, 1), self.regularisation)

    def _by_full_factors(self, right: Parts) -> Parts:
        try:
            lu, rows = self._full_factors
        except SingularError:  # shears of joints with unlimited friction may be indeterminate
            self.full = self._affordable = False
            return self._by_elimination(right)
        b3, c3 = self.elimination.size - 1, right.joints.size
        stacked = np.concatenate([right.joints.ravel(), right.sliding.ravel(), right.blocks, [right.load]])
        solution = lu.solve(stacked * rows)  # type: ignore[attr-defined]
        forces, slip, velocities = np.split(solution[:-1], [c3, len(solution) - 1 - b3])
        return Parts(
            velocities,
            slip.reshape(right.sliding.shape),
            forces.reshape(right.joints.shape),
            float(solution[-1]),
        )

    @cached_property
    def _full_factors(self) -> tuple[object, np.ndarray]:
        """Factors with pivoting of the equations as they stand, and what their rows are scaled by."""
        problem, at, form = self._form.problem, self.at, self._form
        c, forces, slips = problem.joints, problem.B.shape[1], problem.table.slides.stop
        k, size = len(problem.sliding), forces + slips + self.elimination.size
        layout, sides, of = problem.layout, len(problem.layout.senses), form.edges
        kinds = problem.by_kind(np.arange(forces))[:, problem.sliding]
        edges, shears, slip = kinds[:of], kinds[of:], forces + np.arange(slips).reshape(sides, k)
        block, load = forces + slips + np.arange(problem.dead.size), size - 1
        A, gives = form.A.tocoo(), np.broadcast_to(self._compliance, (3, c))
        diagonal = np.concatenate([self._rocking + gives[:of], gives[of:]]).ravel()
        sliding, senses = slip[:, None], layout.senses[:, :, None]
        entries = [
            (np.arange(forces), np.arange(forces), diagonal),
            (edges, sliding, -layout.factor * self._slope),
            (shears, sliding, senses),
            (A.col, block[A.row], A.data),
            (sliding, edges, at.slip[:, None] * (layout.factor * self.friction)),
            (sliding, shears, -at.slip[:, None] * senses),
            (slip, slip, at.z),
            (block[A.row], A.col, A.data),
            (block, load, problem.live),
            (load, block, problem.live),
        ]
        if self._crushing is not None:
            crushing = self._crushing.tocoo()
            entries.append((crushing.row, crushing.col, crushing.data))
            diagonal = diagonal + np.append(self._crushing.diagonal(), np.zeros(forces - of * c))
        row, column, value = (
            np.concatenate([part.ravel() for part in parts])
            for parts in zip(*(np.broadcast_arrays(*entry) for entry in entries), strict=True)
        )
        row, column, value = row[value != 0], column[value != 0], value[value != 0]
        rows = np.concatenate(
            [1 / np.maximum(1.0, diagonal), self._scale.ravel(), np.ones(self.elimination.size)]
        )
        try:
            return splu(sp.csc_matrix((rows[row] * value, (row, column)), shape=(size, size))), rows
        except RuntimeError as error:
            raise SingularError(str(error)) from None

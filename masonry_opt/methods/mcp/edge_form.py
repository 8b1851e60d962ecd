"""The problem in which rocking faces are bounds of the forces at points."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import lsqr

from masonry_opt.problem.faces import selection
from masonry_opt.problem.laws import Law
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State


class Products(NamedTuple):
    """z p of the e edges, shape (e, c), of the sliding faces, shape (senses, k), and of the chords of
    crushing, shape (chords,)."""

    edges: np.ndarray
    sliding: np.ndarray
    crushing: np.ndarray


@dataclass(frozen=True)
class Iterate:
    """A point of the interior.

    Attributes
    ----------
    load_factor: λ.
    x: forces at the points of each joint, > 0, and its shears, shape (3, c).
    z: slacks of the sliding faces, > 0, shape (senses, k).
    d: block velocities, shape (3b,).
    opening: rates with which the edges open beyond what sliding explains, > 0, shape (e, c).
    slip: rates of the sliding faces, > 0, shape (senses, k).
    room: slacks of the chords of crushing, > 0, shape (chords,).
    crushed: rates of the chords of crushing, > 0, shape (chords,).
    """

    load_factor: float
    x: np.ndarray
    z: np.ndarray
    d: np.ndarray
    opening: np.ndarray
    slip: np.ndarray
    room: np.ndarray
    crushed: np.ndarray

    @cached_property
    def products(self) -> Products:
        """z p of all faces."""
        return Products(
            self.x[: len(self.opening)] * self.opening, self.z * self.slip, self.room * self.crushed
        )

    @cached_property
    def energy(self) -> float:
        """z·p, the sum of all products."""
        return float(sum(product.sum() for product in self.products))


@dataclass(frozen=True)
class IterateResiduals:
    """What an iterate leaves of the equations.

    Attributes
    ----------
    statics: B q + λ f_L + f_D, shape (3b,).
    yielding: z − (c + μ n ∓ s), shape (senses, k).
    crushing: room − (r + G x), shape (chords,).
    motion: departure of the edges' and the shears' motion from the flow rule, shape (3, c).
    work: f_L·d − Σ|f_L|.
    """

    statics: np.ndarray
    yielding: np.ndarray
    crushing: np.ndarray
    motion: np.ndarray
    work: float


class EdgeForm:
    """With x = (n₁, n₂, s) of each joint, and rows r + G x ≥ 0 where joints can crush, whose rates move
    points by Gᵀ:

        A x + λ f_L + f_D = 0,    z = c + μ (n₁ + n₂) ∓ s,    f_L·d = Σ|f_L|,
        Aᵀd + ε x = (ψ (p₀ + p₁) + u₁, ψ (p₀ + p₁) + u₂, p₁ − p₀),    n₁ u₁ = n₂ u₂ = z₀ p₀ = z₁ p₁ = 0

    In space x = (n, s, t), and each sense of sliding e_k has a slack z_k = cos(π/P) (c + μ n) − e_k·(s, t).

    Attributes
    ----------
    problem: the problem.
    edges: points of a joint, 2 in the plane, 1 in space.
    A, At: equilibrium of blocks under x, shape (3b, 3c), and its transpose.
    G: chords of crushing in the forces at points, and −n of joints with a largest normal force, shape
        (chords, e c).
    sliding: which joints can slide, as an index.
    bounded: indices of the joints that G has rows of.
    compliance: motion of edges and shears per unit of x where contacts give, shape (3, c); zero, shape
        (3, 1), where they are rigid.
    settled: x from which on contacts give, shape (3, c); zero, shape (3, 1), where they give from zero.
    least_forces: least x that carries the dead load, whatever the joints' law, shape (3, c).
    """

    def __init__(self, problem: Problem, most: np.ndarray | None = None) -> None:
        """Of joints with these largest normal forces, shape (c,); None: without any."""
        self.problem = problem
        self.A = problem.B
        self.At = self.A.T.tocsr()
        # Where all joints can slide a slice takes them, without a copy.
        every = len(problem.sliding) == problem.joints
        self.sliding: np.ndarray | slice = slice(None) if every else problem.sliding
        self._layout, self.edges = problem.layout, problem.layout.points
        rocking = self.edges * problem.joints
        self.G = problem.R[rocking:, :rocking].tocsr()
        self._most_room = problem.face_constant[problem.table.chords]
        self.bounded = problem.crushing
        if most is not None and len(pressed := np.flatnonzero(np.isfinite(most))):
            of_edges = [-selection(pressed, problem.joints)] * self.edges
            self.G = sp.vstack([self.G, sp.hstack(of_edges)], format="csr")
            self._most_room = np.append(self._most_room, most[pressed])
            self.bounded = np.append(problem.crushing, pressed)
        self.compliance = self.settled = np.zeros((3, 1))
        # Nothing of the joints' law, so that forms under other laws share them.
        least = lsqr(self.A, -problem.dead, atol=1e-8, btol=1e-8, iter_lim=300)[0]
        self.least_forces = problem.by_kind(least)

    def with_law(self, law: Law) -> EdgeForm:
        """The same, of joints under another law."""
        other = copy(self)
        other.problem = replace(self.problem, law=law)
        return other

    def giving(self, compliance: np.ndarray, settled: np.ndarray | None = None) -> EdgeForm:
        """The same, of contacts that give by so much per unit of each joint force from settled ones on, shape
        (3c,) each."""
        other = copy(self)
        other.problem = replace(self.problem, compliance=compliance, settled=settled)
        other.compliance = self.problem.by_kind(compliance)
        if settled is not None:
            other.settled = self.problem.by_kind(settled)
        return other

    @property
    def steep(self) -> np.ndarray:
        """What slacks of sliding are divided by where they are compared, shape (senses, k)."""
        return self.problem.steep[self.problem.table.slides].reshape(len(self._layout.senses), -1)

    @property
    def cohesion(self) -> np.ndarray:
        """What cohesion adds to the slack of each sense, shape (k,)."""
        return self._layout.factor * self.problem.cohesion

    def slacks(self, x: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Slope · n ∓ s of the joints that can slide, shape (senses, k); the true slacks but for cohesion."""
        normal = self._layout.factor * (slope * x[: self.edges].sum(axis=0)[self.sliding])
        slacks: np.ndarray = normal - self._layout.senses @ x[self.edges :, self.sliding]
        return slacks

    def follow(self, slip: np.ndarray) -> np.ndarray:
        """Motion of edges and shears that sliding rates, shape (senses, k), cause, shape (3, c)."""
        motion = np.zeros((3, self.problem.joints))
        motion[: self.edges, self.sliding] = self.problem.dilatancy * (self._layout.factor * slip.sum(axis=0))
        motion[self.edges :, self.sliding] = -self._layout.senses.T @ slip
        return motion

    def chords(self, x: np.ndarray) -> np.ndarray:
        """G x, shape (chords,): what forces add to the slacks of the chords of crushing."""
        # Most scenes have no chords, and products with an empty matrix are a fifth of their passes' time.
        return self.G @ x[: self.edges].ravel() if self.G.shape[0] else np.zeros(0)

    def room(self, x: np.ndarray) -> np.ndarray:
        """Slacks of the chords of crushing, shape (chords,)."""
        return self._most_room + self.chords(x)

    def crushes(self, rates: np.ndarray) -> np.ndarray:
        """Motion of edges that rates of the chords cause, shape (e, c)."""
        if not len(rates):
            return np.zeros((self.edges, self.problem.joints))
        moved: np.ndarray = (self.G.T @ rates).reshape(self.edges, -1)
        return moved

    def moves(self, d: np.ndarray) -> np.ndarray:
        """Motion of edges and shears under block velocities, shape (3, c)."""
        moved: np.ndarray = self.problem.by_kind(self.At @ d)
        return moved

    def residuals(self, at: Iterate) -> IterateResiduals:
        """What an iterate leaves."""
        problem = self.problem
        motion = self.moves(at.d) - self.follow(at.slip)
        motion[: self.edges] -= at.opening + self.crushes(at.crushed)
        motion += self.compliance * (at.x - self.settled)
        return IterateResiduals(
            self.A @ at.x.ravel() + at.load_factor * problem.live + problem.dead,
            at.z - self.cohesion - self.slacks(at.x, problem.friction),
            at.room - self.room(at.x),
            motion,
            float(problem.live @ at.d) - problem.live_norm,
        )

    def state(self, at: Iterate) -> State:
        """An iterate as a state of the problem."""
        rocks = at.opening.ravel() / self.edges
        p = np.concatenate([at.slip.ravel(), rocks, at.crushed])[: self.problem.table.chords.stop]
        return State(at.load_factor, at.x.ravel(), at.d, p)

    def iterate(self, state: State) -> Iterate:
        """A state as an iterate, whose slacks are those of its forces."""
        problem, table, p = self.problem, self.problem.table, state.p
        x = problem.by_kind(state.q)
        z = self.cohesion + self.slacks(x, problem.friction)
        opening = self.edges * p[table.rocks].reshape(self.edges, -1)
        slip = p[table.slides].reshape(z.shape)
        return Iterate(state.load_factor, x, z, state.d, opening, slip, self.room(x), p[table.chords])


def moved(at: Iterate, lengths: tuple[float, float], by: Iterate) -> Iterate:
    """An iterate after steps of these lengths in the unknowns of statics and of kinematics."""
    forces, motion = lengths
    return Iterate(
        at.load_factor + forces * by.load_factor,
        at.x + forces * by.x,
        at.z + forces * by.z,
        at.d + motion * by.d,
        at.opening + motion * by.opening,
        at.slip + motion * by.slip,
        at.room + forces * by.room,
        at.crushed + motion * by.crushed,
    )

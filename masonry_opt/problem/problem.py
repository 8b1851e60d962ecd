"""The limit analysis problem of a scene as matrices: eqs (1) to (6), in dimensionless units."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components


@dataclass(frozen=True)
class Problem:
    """Matrices of b movable blocks and c joints.

    Statics: ``B q + λ live + dead = 0``. Kinematics: ``u = Bᵀ d``, the motion of each joint's
    first block against its second. Forces are in units of ``force_unit`` (the median dead load of
    a block), lengths in units of ``length_unit`` (half the median joint length), so that the numbers a
    solver sees are near one whatever units a case file uses.

    Attributes
    ----------
    B: equilibrium matrix, shape (3b, 3c); rows fx, fy, moment about the centroid of each block,
        columns n (compression > 0), s, m (about the joint's middle) of each joint.
    dead, live: loads f_D and f_L, shape (3b,).
    half_length: L / 2 of each joint, shape (c,).
    friction: μ of each joint, ``inf`` where it cannot slide, shape (c,).
    cohesion: of each joint as a force (per unit length × L), shape (c,).
    dilatancy: tan φ₀ of each joint, shape (c,).
    dilatancy_force: normal forces up to which the dilatancy is whole and from which there is none (``inf``
        where it does not depend on them), shape (c, 2).
    force_unit, length_unit: what a dimensionless force or length is multiplied by.
    """

    B: sp.csr_array
    dead: np.ndarray
    live: np.ndarray
    half_length: np.ndarray
    friction: np.ndarray
    cohesion: np.ndarray
    dilatancy: np.ndarray
    dilatancy_force: np.ndarray
    force_unit: float
    length_unit: float

    @property
    def blocks(self) -> int:
        """Number of movable blocks, b."""
        return self.B.shape[0] // 3

    @property
    def joints(self) -> int:
        """Number of joints, c."""
        return self.B.shape[1] // 3

    @property
    def live_norm(self) -> float:
        """Σ|f_L|, by which objective and velocities are scaled (so that velocities are near 1)."""
        return float(np.abs(self.live).sum())

    @cached_property
    def B_n(self) -> sp.csr_array:
        """Columns of B of the normal forces, shape (3b, c)."""
        return self.B[:, 0::3].tocsr()

    @cached_property
    def B_s(self) -> sp.csr_array:
        """Columns of B of the shear forces, shape (3b, c)."""
        return self.B[:, 1::3].tocsr()

    @cached_property
    def B_m(self) -> sp.csr_array:
        """Columns of B of the moments, shape (3b, c)."""
        return self.B[:, 2::3].tocsr()

    @cached_property
    def sliding(self) -> np.ndarray:
        """Indices of the k joints that can slide (friction is limited), shape (k,)."""
        return np.flatnonzero(np.isfinite(self.friction))

    @cached_property
    def K(self) -> sp.csr_array:
        """Selects the joints that can slide: ``K @ x`` scatters x over all joints, shape (c, k)."""
        k = len(self.sliding)
        return sp.csr_array((np.ones(k), (self.sliding, np.arange(k))), shape=(self.joints, k))

    @cached_property
    def part(self) -> np.ndarray:
        """Number of the connected part of the scene that each joint belongs to, shape (c,). Parts
        that share supports alone do not act on each other."""
        incidence = (self.B != 0).astype(float)
        blocks_of_row = sp.csr_array(
            (np.ones(3 * self.blocks), (np.arange(3 * self.blocks) // 3, np.arange(3 * self.blocks)))
        )
        joint_of_column = sp.csr_array(
            (np.ones(3 * self.joints), (np.arange(3 * self.joints), np.arange(3 * self.joints) // 3))
        )
        touches = blocks_of_row @ incidence @ joint_of_column
        _, part = connected_components(touches.T @ touches, directed=False)
        return part

    @property
    def dilatancy_depends_on_stress(self) -> bool:
        """Whether the dilatancy of any joint falls with its normal force."""
        return bool((np.isfinite(self.dilatancy_force[:, 1]) & (self.dilatancy != 0)).any())

    def dilatancy_at(self, n: np.ndarray) -> np.ndarray:
        """tan φ₀ of each joint under normal forces n, shape (c,) each (section 6.5)."""
        depends = np.isfinite(self.dilatancy_force[:, 1])
        full, none = self.dilatancy_force[depends].T
        share = np.ones(self.joints)
        share[depends] = np.clip((none - n[depends]) / (none - full), 0.0, 1.0)
        return self.dilatancy * share

    def with_friction(self, friction: np.ndarray) -> Problem:
        """The same problem with other friction, shape (c,)."""
        return replace(self, friction=friction)

    def in_units_of(self, force: float) -> Problem:
        """The same problem with forces in units of ``force`` (itself in units of ``force_unit``)."""
        return replace(
            self,
            dead=self.dead / force,
            live=self.live / force,
            cohesion=self.cohesion / force,
            dilatancy_force=self.dilatancy_force / force,
            force_unit=self.force_unit * force,
        )

    def without_live_load(self) -> Problem:
        """The same problem with no live load: does the scene stand under its dead load?"""
        return replace(self, live=np.zeros_like(self.live))


@dataclass(frozen=True)
class ShearLimits:
    """|s| ≤ cohesion + slope · n at each joint that can slide (eq. (4), Fig. 4).

    Attributes
    ----------
    slope: shape (k,), over ``Problem.sliding``.
    cohesion: shape (k,) as forces, or None where a scene has none and no term is modelled.
    """

    slope: np.ndarray
    cohesion: np.ndarray | None = None

    @classmethod
    def associative(cls, problem: Problem) -> ShearLimits:
        """The joints' own friction and cohesion, flow being normal to them (C = D)."""
        cohesion = problem.cohesion[problem.sliding]
        return cls(problem.friction[problem.sliding], cohesion if cohesion.any() else None)


def yield_slacks(problem: Problem, q: np.ndarray) -> np.ndarray:
    """Slack z of each yield condition with the true friction law, eq. (4): negative is a violation.

    Parameters
    ----------
    q: joint forces n, s, m in turn, shape (3c,).

    Returns
    -------
    Array of shape (4, c): sliding c + μn ∓ s (``inf`` where friction is unlimited), rocking
    nL/2 ∓ m.
    """
    n, s, m = q[0::3], q[1::3], q[2::3]
    limit = np.full(problem.joints, np.inf)
    k = problem.sliding
    limit[k] = problem.cohesion[k] + problem.friction[k] * n[k]
    rocking = problem.half_length * n
    return np.stack([limit - s, limit + s, rocking - m, rocking + m])


def joint_rates(problem: Problem, p: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Joint velocities u = D p, eqs (5) and (6), for rates p and an opening ``slope`` per slip.

    Parameters
    ----------
    p: rates of sliding (+, −) and rocking (+, −), shape (4, c).
    slope: opening per unit slip of each joint (μ: associative; tan φ₀: its own), shape (c,).

    Returns
    -------
    Opening, slip, rotation of each joint in turn, shape (3c,).
    """
    u = np.empty(3 * problem.joints)
    u[0::3] = slope * (p[0] + p[1]) + problem.half_length * (p[2] + p[3])
    u[1::3] = p[1] - p[0]
    u[2::3] = p[3] - p[2]
    return u

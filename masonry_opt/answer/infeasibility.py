"""Proofs that there is no load factor, computed from the matrices and never from a solver."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from masonry_opt.problem.problem import Problem


class Existence(StrEnum):
    """What is proven of a load factor λ ≥ 0 at which blocks move under the joints' own flow rule."""

    #: Proven that there is none: no mechanism lets the live load do work.
    NO_MECHANISM = "none exists: no mechanism lets the live load do work"
    #: Proven that there is none: of every mechanism some faces cannot come to yield together.
    NO_STATE = "none exists: no mechanism goes with a state of equilibrium"
    #: Nothing proven, but that λ is unbounded in statics: mechanisms exist, which a state may go with.
    UNBOUNDED = "not decided: statics carry any multiple of the live load, and a mechanism exists"
    #: Nothing proven: mechanisms exist, and no forces were found that carry any multiple of the live load.
    UNDECIDED = "not decided: a mechanism exists, and no forces carry every multiple of the live load"

    @property
    def proven(self) -> bool:
        """Whether it is proven that no such load factor exists."""
        return self in (Existence.NO_MECHANISM, Existence.NO_STATE)


@dataclass(frozen=True)
class InfeasibilityCertificate:
    """Proof that no load factor exists, or the forces that leave it unbounded, with residuals; zero is exact.

    Attributes
    ----------
    existence: what is proven.
    equilibrium, yield_: of the ray q, forces that carry the live load alone: largest entry of B q + f_L, and
        largest violation of C q ≥ 0 (of the true friction without cohesion; where there is no mechanism, with
        the joints' own dilatancy in place of friction), as forces, over Σ|f_L|. None without a ray.
    clamped: joints, by their numbers in ``Result.joints``, that carry the opposite of the live load as well,
        the most stressed first: the two rays make a state of self-stress, whose friction no load causes.
        Empty where no forces carry the opposite.
    static_cuts, kinematic_cuts: inequalities that leave no choice of moving faces: so many sets of faces that
        cannot come to yield together, and so many of which one must move.
    cut_residual: the largest that any of them leaves of its conditions (see :func:`kinematic_residual`,
        :func:`static_residual`).
    """

    existence: Existence
    equilibrium: float | None = None
    yield_: float | None = None
    clamped: tuple[int, ...] = ()
    static_cuts: int = 0
    kinematic_cuts: int = 0
    cut_residual: float = 0.0

    @property
    def proven(self) -> bool:
        """Whether it is proven that no load factor λ ≥ 0 exists under the joints' own flow rule."""
        return self.existence.proven

    def as_dict(self) -> dict[str, Any]:
        """Everything by the names used in reports, and whether it is a proof."""
        table = {name.rstrip("_"): value for name, value in asdict(self).items()}
        return {
            **table,
            "clamped": list(self.clamped),
            "existence": str(self.existence),
            "proven": self.proven,
        }


def ray_residuals(problem: Problem, q: np.ndarray, slope: np.ndarray) -> tuple[float, float]:
    """What forces (3c,) leave of B q + f_L = 0 and of C(slope) q ≥ 0, as forces over Σ|f_L|."""
    unbalanced, violation = _ray_leaves(problem, q, slope)
    return unbalanced, float(violation.max(initial=0.0))


def _ray_leaves(problem: Problem, q: np.ndarray, slope: np.ndarray) -> tuple[float, np.ndarray]:
    """The same, the violation by face, shape (faces,)."""
    equilibrium = float(np.abs(problem.B @ q + problem.live).max())
    violation = -(problem.C(slope) @ q) / problem.face_arm
    return equilibrium / problem.live_norm, violation / problem.live_norm


def kinematic_residual(problem: Problem, q: np.ndarray, still: np.ndarray) -> float:
    """What forces (3c,) leave of B q + f_L = 0 and, on all faces but those that are ``still`` (faces,), of
    C(tan φ₀) q ≥ 0, as forces over Σ|f_L|: zero shows that f_L·d ≤ 0 unless one of these moves."""
    unbalanced, violation = _ray_leaves(problem, q, problem.dilatancy)
    return max(unbalanced, float(np.where(still, 0.0, violation).max(initial=0.0)))


def static_residual(problem: Problem, d: np.ndarray, p: np.ndarray, held: np.ndarray) -> float:
    """What a motion d (3b,) with rates p (faces,) leaves of Bᵀd = C(μ)ᵀp, of p ≥ 0 on all faces but those
    ``held`` at yield (faces,) and of f_L·d ≥ 0, over the energy f_D·d − c·p that it gains: zero shows that
    no state with λ ≥ 0 brings these to yield together. Infinite if it gains none."""
    gain = float(problem.dead @ d - problem.face_cohesion @ p)
    if not gain > 0:
        return float("inf")
    departure = float(np.abs(problem.departure(d, p, problem.friction)).max())
    backwards = float(np.where(held, 0.0, -p * problem.face_arm).max(initial=0.0))
    against = max(0.0, -float(problem.live @ d) / problem.live_norm)
    return max(departure, backwards, against) / gain

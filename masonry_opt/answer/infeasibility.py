"""Proofs that there is no load factor, computed from the matrices and never from a solver."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from masonry_opt.problem.problem import Of, Problem


class Existence(StrEnum):
    """What is proven of a load factor λ ≥ 0 at which blocks move under the joints' own flow rule."""

    NO_MECHANISM = "none exists: no mechanism lets the live load do work"
    NO_STATE = "none exists: no mechanism goes with a state of equilibrium"  #: faces never yield together
    UNBOUNDED = "not decided: statics carry any multiple of the live load, and a mechanism exists"
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
    equilibrium, yield_: :func:`ray_residuals` of forces that carry the live load alone within the true
        friction without cohesion (where there is no mechanism: within the joints' own dilatancy). None
        without such forces.
    clamped: joints in self-stress, by their numbers in the problem, of a result by those in
        ``Result.joints``, the most stressed first: other forces carry the opposite of the live load, and the
        sum of both balances itself.
    static_cuts, kinematic_cuts: numbers of sets of faces that cannot come to yield together, and of sets of
        which one face must move. Together they leave no choice of moving faces.
    cut_residual: the largest :func:`static_residual` or :func:`kinematic_residual` of these sets.
    """

    existence: Existence
    equilibrium: float | None = None
    yield_: float | None = None
    clamped: tuple[int, ...] = ()
    static_cuts: int = 0
    kinematic_cuts: int = 0
    cut_residual: float = 0.0

    proven = Of[bool]("existence")  #: whether no load factor λ ≥ 0 exists under the joints' own flow rule

    def as_dict(self) -> dict[str, Any]:
        """Everything by the names used in reports, and whether it is a proof."""
        own = {"clamped": list(self.clamped), "existence": str(self.existence), "proven": self.proven}
        return {name.rstrip("_"): value for name, value in asdict(self).items()} | own


def ray_residuals(
    problem: Problem, q: np.ndarray, slope: np.ndarray, still: np.ndarray | bool = False
) -> tuple[float, float]:
    """Residuals of B q + f_L = 0 and, on all faces but those ``still`` (faces,), of C(slope) q ≥ 0, as forces
    over Σ|f_L|, for joint forces q (3c,)."""
    equilibrium = float(np.abs(problem.B @ q + problem.live).max())
    violation = np.where(still, 0.0, -(problem.C(slope) @ q))
    return equilibrium / problem.live_norm, float(violation.max(initial=0.0)) / problem.live_norm


def kinematic_residual(problem: Problem, q: np.ndarray, still: np.ndarray) -> float:
    """The larger of :func:`ray_residuals` under the joints' own flow rule: zero shows that f_L·d ≤ 0 unless
    one of the faces ``still`` (faces,) moves."""
    return max(ray_residuals(problem, q, problem.dilatancy, still))


def static_residual(problem: Problem, d: np.ndarray, p: np.ndarray, held: np.ndarray) -> float:
    """Residual of Bᵀd = C(μ)ᵀp, of p ≥ 0 on all faces but those ``held`` at yield (faces,), and of f_L·d ≥ 0,
    for a motion d (3b,) with rates p (faces,), over the energy f_D·d − c·p that it gains: zero shows that no
    state with λ ≥ 0 brings these faces to yield together. Infinite if it gains none."""
    gain = float(problem.dead @ d - problem.face_cohesion @ p)
    if not gain > 0:
        return float("inf")
    departure = float(np.abs(problem.departure(d, p, problem.friction)).max())
    backwards = float(np.where(held, 0.0, -p).max(initial=0.0))
    against = max(0.0, -float(problem.live @ d) / problem.live_norm)
    return max(departure, backwards, against) / gain

"""How well an answer meets every condition, computed from the matrices and never from a solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_opt.problem.problem import Problem, joint_rates, yield_slacks


@dataclass(frozen=True)
class Certificate:
    """Residuals of a load factor λ, joint forces q and block velocities d; zero is exact.

    Attributes
    ----------
    equilibrium: largest entry of B q + λ f_L + f_D, over the total dead load.
    yield_: largest violation of the true friction law, of n ≥ 0 or of rocking, as a force in median
        block weights.
    flow: largest departure of Bᵀd from the flow rule, over the largest velocity.
    complementarity: Σ|z p| over the live load's work: energy of what moves without being at yield,
        in units of λ. (For associative flow: by how much λ can be off.)
    """

    equilibrium: float
    yield_: float
    flow: float
    complementarity: float

    def as_dict(self) -> dict[str, float]:
        """The four residuals by the names used in reports."""
        return {
            "equilibrium": self.equilibrium,
            "yield": self.yield_,
            "flow": self.flow,
            "complementarity": self.complementarity,
        }

    @property
    def worst(self) -> float:
        """The largest of the four."""
        return max(self.as_dict().values())


def certify(
    problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray, slope: np.ndarray
) -> Certificate:
    """Residuals of an answer under a flow rule.

    Parameters
    ----------
    q, d: joint forces (3c,) and block velocities (3b,).
    slope: opening per unit slip that the flow rule demands of each joint, shape (c,): μ for
        associative flow, tan φ₀ for the joints' own.
    """
    residual = problem.B @ q + load_factor * problem.live + problem.dead
    total_dead = np.hypot(problem.dead[0::3], problem.dead[1::3]).sum() or problem.live_norm
    z = yield_slacks(problem, q)
    violation = np.concatenate([-z[:2], -z[2:] / problem.half_length, -q[None, 0::3]])
    p = rates(problem, d, slope)
    departure = problem.B.T @ d - joint_rates(problem, p, finite(slope))
    scale = np.abs(d).max() or 1.0
    live_work = float(problem.live @ d) or problem.live_norm
    slack = np.where(np.isfinite(z), z, 0.0)
    return Certificate(
        equilibrium=float(np.abs(residual).max() / total_dead),
        yield_=max(0.0, float(violation.max())),
        flow=float(np.abs(departure).max() / scale),
        complementarity=float(np.abs(slack * p).sum() / abs(live_work)),
    )


def rates(problem: Problem, d: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Rates p ≥ 0 with which the joints could follow Bᵀd under a flow rule, shape (4, c).

    Slip gives the sliding rates, of one sense only; rotation and the opening that sliding does not
    explain give the rocking rates. Where the opening is too small for p ≥ 0, slip and rotation are
    kept, and ``u − D p`` is the violation of the flow rule.
    """
    u = problem.B.T @ d
    e, slip, rotation = u[0::3], u[1::3], u[2::3]
    limited = np.isfinite(problem.friction)
    slide = np.where(limited, np.stack([np.maximum(-slip, 0.0), np.maximum(slip, 0.0)]), 0.0)
    both_edges = (e - finite(slope) * slide.sum(axis=0)) / problem.half_length
    about = np.maximum(np.stack([both_edges - rotation, both_edges + rotation]) / 2, 0.0)
    # Never more than the rotation asks for when the joint cannot open that far.
    rock = np.where(both_edges >= np.abs(rotation), about, np.stack([-rotation, rotation]))
    return np.concatenate([slide, np.maximum(rock, 0.0)])


def finite(slope: np.ndarray) -> np.ndarray:
    """The slope, 0 where friction is unlimited and no sliding can open the joint."""
    return np.where(np.isfinite(slope), slope, 0.0)

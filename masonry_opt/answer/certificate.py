"""How well an answer meets every condition, computed from the matrices and never from a solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_opt.problem.problem import Problem


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
    problem: Problem,
    load_factor: float,
    q: np.ndarray,
    d: np.ndarray,
    slope: np.ndarray,
    by_parabola: bool = False,
) -> Certificate:
    """Residuals of an answer under a flow rule.

    Parameters
    ----------
    q, d: joint forces (3c,) and block velocities (3b,).
    slope: opening per unit slip that the flow rule demands of the joints that can slide, shape (k,): μ for
        associative flow, tan φ₀ for the joints' own.
    by_parabola: whether crushing is limited by the parabola itself, and not by its chords.
    """
    total_dead = problem.force_sizes(problem.dead).sum() or problem.live_norm
    z, p = problem.slacks(q, by_parabola), problem.rates(d, slope)
    live_work = float(problem.live @ d) or problem.live_norm
    return Certificate(
        equilibrium=float(np.abs(problem.unbalanced(load_factor, q)).max() / total_dead),
        yield_=max(0.0, -float((z / problem.face_arm).min()), -float(problem.normal_forces(q).min())),
        flow=float(np.abs(problem.departure(d, p, slope)).max() / (np.abs(d).max() or 1.0)),
        complementarity=problem.energy(q, p, by_parabola) / abs(live_work),
    )

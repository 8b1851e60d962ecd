"""A mechanism that given forces drive, with bounded velocities, in CVXPY.

It answers why there is no load factor. Driven by the dead load, with the joints' own flow: do
blocks fall, and which (the dual ray of an infeasible eq. (9), made finite)? Driven by the live load
on joints that slide without dilatancy: could anything move at all?
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import Mechanism
from masonry_opt.problem.problem import Problem, ShearLimits


class CvxpyMechanism:
    """Maximise the power of ``force``, less what cohesion dissipates, over velocities within ±1."""

    def __init__(self, problem: Problem, force: np.ndarray, limits: ShearLimits) -> None:
        self.problem = problem
        self.mechanism = Mechanism(problem)
        d = self.mechanism.d
        power = force @ d - self.mechanism.dissipation(limits.cohesion)
        compatibility = self.mechanism.compatibility(limits.slope)
        self.program = cp.Problem(cp.Maximize(power), [*compatibility, d <= 1, d >= -1])

    def read(self) -> np.ndarray:
        """Block velocities at the optimum, shape (3b,)."""
        return np.asarray(self.mechanism.d.value)

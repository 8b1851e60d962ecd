"""Forces that a dead load allows beside those at rest: what a scene stands with, nobody knows."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from masonry_opt.problem.problem import Problem


def self_stress(problem: Problem, rng: np.random.Generator) -> np.ndarray | None:
    """Forces (3c + t,) in equilibrium with the dead load, a vertex of those within yield, in space of its
    sides: of least random cost of its normal forces; None if there are none."""
    cost = rng.exponential(1.0, problem.B.shape[1])
    points = problem.layout.points * problem.joints
    cost[points:] = 0.0
    found = linprog(
        cost,
        A_ub=-problem.true_yield,
        b_ub=problem.face_cohesion,
        A_eq=problem.B,
        b_eq=-problem.dead,
        bounds=(None, None),
    )
    q: np.ndarray | None = found.x
    return q

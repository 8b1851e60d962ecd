"""Draw random self-stress: forces that carry the dead load, from which load histories may start."""

import numpy as np

from masonry_opt.problem.problem import Problem


def self_stress(problem: Problem, rng: np.random.Generator) -> np.ndarray | None:
    """Return random admissible forces that balance the dead load, or None if no such forces are found.

    The forces have shape (3c + t,). They minimise a random cost of the normal forces. In space the shear is
    limited by polygons.
    """
    # The import is local, because it takes 0.2 s and few options need it.
    from scipy.optimize import linprog

    cost = rng.exponential(1.0, problem.B.shape[1])
    cost[problem.layout.points * problem.joints :] = 0.0
    yield_rows, upper = -problem.true_yield, problem.face_cohesion
    forces: np.ndarray | None = linprog(cost, yield_rows, upper, problem.B, -problem.dead, (None, None)).x
    return forces

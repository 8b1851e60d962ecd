"""Associative load factor of blocks in space: Coulomb's cones handed to Clarabel.

Greatest λ so that B q + λ live + dead = 0 with, at each contact point, n ≥ 0 and |(s, t)| ≤ c + μ n.
"""

import clarabel
import numpy as np
import scipy.sparse as sp
from space.boxes import Pushed


def by_cones(wall: Pushed, friction: float, cohesion: float = 0.0) -> float:
    """Greatest load factor by second-order cones; cohesion is a force per area.

    Raises ArithmeticError where Clarabel ends with anything but a solution.
    """
    points, rows = len(wall.area), len(wall.dead)
    unknowns = 1 + 3 * points  # λ, then (n, s, t) of each point
    statics = sp.hstack([wall.live[:, None], wall.B])
    normal = 1 + 3 * np.arange(points)
    pressing = sp.csc_array((-np.ones(points), (np.arange(points), normal)), shape=(points, unknowns))
    # Clarabel: A x + slack = b, so a cone's slack is (c + μ n, s, t).
    factor = np.tile([friction, 1.0, 1.0], points)
    cone = sp.hstack([sp.csc_array((3 * points, 1)), sp.diags_array(-factor)])
    limit = np.zeros((points, 3))
    limit[:, 0] = cohesion * wall.area
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-9
    solution = clarabel.DefaultSolver(
        sp.csc_matrix((unknowns, unknowns)),
        -np.eye(1, unknowns)[0],
        sp.csc_matrix(sp.vstack([statics, pressing, cone])),
        np.concatenate([-wall.dead, np.zeros(points), limit.ravel()]),
        [
            clarabel.ZeroConeT(rows),
            clarabel.NonnegativeConeT(points),
            *[clarabel.SecondOrderConeT(3)] * points,
        ],
        settings,
    ).solve()
    if solution.status != clarabel.SolverStatus.Solved:
        raise ArithmeticError(f"Clarabel: {solution.status}")
    return float(solution.x[0])

"""Statics with chosen faces at yield, in CVXPY.

Of the states that hold the faces of a mechanism at the true yield condition, eq. (4), and keep all
others within it, the one whose λ is nearest to a given value. With that mechanism it satisfies
complementarity, eq. (8).
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.problem.problem import Problem


class CvxpyAtYield:
    """Minimise |λ − ``near``| subject to equilibrium, yield, and z = 0 on the faces ``at_yield``.

    Parameters
    ----------
    at_yield: which faces slide (+, −) and rock (+, −), shape (4, c).
    near: the load factor to stay near.
    """

    def __init__(self, problem: Problem, at_yield: np.ndarray, near: float) -> None:
        self.problem = problem
        c, k = problem.joints, problem.sliding
        n, s, m = (cp.Variable(c, name=name) for name in "nsm")
        load_factor = cp.Variable(name="load_factor")
        internal = problem.B_n @ n + problem.B_s @ s + problem.B_m @ m
        rows = [internal + load_factor * problem.live + problem.dead == 0]

        limit = problem.cohesion[k] + cp.multiply(problem.friction[k], n[k])
        rocking = cp.multiply(problem.half_length, n)
        faces = [(limit - s[k], at_yield[0, k]), (limit + s[k], at_yield[1, k])]
        faces += [(rocking - m, at_yield[2]), (rocking + m, at_yield[3])]
        for slack, held in faces:
            for chosen, hold in ((np.flatnonzero(held), True), (np.flatnonzero(~held), False)):
                if len(chosen):
                    rows.append(slack[chosen] == 0 if hold else slack[chosen] >= 0)
        self.program = cp.Problem(cp.Minimize(cp.abs(load_factor - near)), rows)
        self._load_factor, self._forces = load_factor, [n, s, m]

    def read(self) -> tuple[float, np.ndarray]:
        """λ and joint forces n, s, m in turn, shape (3c,), at the optimum."""
        forces = np.stack([force.value for force in self._forces], axis=1).ravel()
        return float(self._load_factor.value), forces

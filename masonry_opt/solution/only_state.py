"""Proof that no other load factor above zero is one of collapse, where equilibrium alone fixes all forces.

If the columns of B are independent, equilibrium leaves one vector of forces under each load factor, which is
affine in λ. Slacks z of the yield conditions are concave functions of the forces, and so of λ. Load factors
without a violated condition therefore form an interval, which contains the dead load alone, λ = 0.

1. A condition that has slack at λ = 0 and none at λ* is violated above λ*: no state of equilibrium is higher.
2. At a collapse state between zero and λ*, each condition that moves has no slack. A concave function that is
   nowhere negative and vanishes inside an interval vanishes in all of it. The condition therefore has no
   slack under any load between zero and λ*.
3. If the forces in these conditions vanish too, their motion takes no energy under any load. By virtual work
   neither the dead nor the live load then does work in the motion: the motion is no collapse.

So λ* is the only load factor above zero at which a load drives a collapse. The proof assumes nothing of the
flow rule. Forces and slacks are computed from the matrices, not taken from the solver of λ*.
"""

import numpy as np

from masonry_opt.problem.problem import Problem
from masonry_opt.problem.rank import solve_independent

#: Slack, relative to the largest force, below which a yield condition may be active. A larger value makes
#: fewer proofs succeed.
_MAY_YIELD = 1e-6

#: Slack, relative to the largest force, above which a yield condition is inactive. A larger value makes fewer
#: proofs succeed.
_HAS_SLACK = 1e-4

#: Force, relative to the largest force, below which a force is rounding. A smaller value makes fewer proofs
#: succeed, because rounding then counts as a force.
_FORCE_ROUNDING_TOLERANCE = 1e-9

#: Unbalanced force, relative to the largest force, that counts as rounding. A smaller value makes fewer
#: proofs succeed.
_BALANCED = 1e-8


def is_only_load_factor(problem: Problem, load_factor: float) -> bool:
    """Return True if it is proven that no other load factor above zero can cause collapse.

    The proof does not use the known collapse state at this load factor.
    """
    if not problem.statics_fix_forces or load_factor <= 0:
        return False
    problem = problem.by_cone.by_parabola
    loads = np.column_stack([problem.dead, problem.dead + load_factor * problem.live])
    forces = solve_independent(problem.B, -loads)
    largest = float(np.abs(forces).max())
    if np.abs(problem.B @ forces + loads).max() > _BALANCED * largest:
        return False
    without_live, at_collapse = (problem.slacks(q) / largest for q in forces.T)
    if min(without_live.min(), at_collapse.min()) < -_MAY_YIELD:
        return False
    ends_here = (without_live > _HAS_SLACK) & (at_collapse < _MAY_YIELD)
    always_at_yield = (without_live < _MAY_YIELD) & (at_collapse < _MAY_YIELD)
    force_in_condition = (abs(problem.true_yield) @ np.abs(forces)).max(axis=1)
    carries = force_in_condition > _FORCE_ROUNDING_TOLERANCE * largest
    return bool(ends_here.any() and not (always_at_yield & carries).any())

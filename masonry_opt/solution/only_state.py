"""Prove that no other load factor above zero can cause collapse if equilibrium alone fixes all forces.

If the columns of B are independent, there is one vector of equilibrium forces for each λ, and it is affine in
λ. The slacks z of the yield conditions are concave functions of the forces, and hence of λ. The load factors
without a violated condition therefore form an interval, which contains λ = 0 (dead load alone).

1. A condition that has slack at λ = 0 and none at λ* is violated above λ*. No equilibrium exists above λ*.
2. In a collapse state between zero and λ*, each condition with a nonzero rate has no slack. A nonnegative
   concave function that vanishes inside an interval vanishes on the whole interval. The condition therefore
   has no slack at any load between zero and λ*.
3. If the forces in these conditions vanish too, their motion dissipates no energy under any load. By virtual
   work, neither the dead load nor the live load does work in this motion, so the motion is not a collapse.

Hence λ* is the only load factor above zero at which the loads drive a collapse. The proof makes no assumption
about the flow rule. Forces and slacks are computed from the matrices, not taken from the solver of λ*.
"""

import numpy as np

from masonry_opt.problem.problem import Problem
from masonry_opt.problem.rank import solve_independent

#: Slack, relative to the largest force, below which a yield condition may be active. With a smaller value,
#: rounding errors count as slack, and active conditions are missed.
_MAY_YIELD = 1e-6

#: Slack, relative to the largest force, above which a yield condition is inactive. With a larger value,
#: uniqueness of the load factor is proven for fewer scenes.
_HAS_SLACK = 1e-4

#: Forces below this fraction of the largest force count as zero. With a smaller value, rounding errors count
#: as forces, and uniqueness of the load factor is proven for fewer scenes.
_FORCE_ROUNDING_TOLERANCE = 1e-9

#: Unbalanced forces up to this fraction of the largest force count as rounding errors. With a smaller value,
#: uniqueness of the load factor is proven for fewer scenes.
_LARGEST_IMBALANCE = 1e-8


def is_only_load_factor(problem: Problem, load_factor: float) -> bool:
    """Return True if it is proven that no load factor above zero other than ``load_factor`` causes collapse.

    The proof uses the known load factor, but not the forces or the mechanism of its collapse state.
    """
    if not problem.statics_fix_forces or load_factor <= 0:
        return False
    problem = problem.by_cone.by_parabola
    loads = np.column_stack([problem.dead, problem.dead + load_factor * problem.live])
    forces = solve_independent(problem.B, -loads)
    largest = float(np.abs(forces).max())
    if np.abs(problem.B @ forces + loads).max() > _LARGEST_IMBALANCE * largest:
        return False
    without_live, at_collapse = (problem.slacks(q) / largest for q in forces.T)
    if min(without_live.min(), at_collapse.min()) < -_MAY_YIELD:
        return False
    ends_here = (without_live > _HAS_SLACK) & (at_collapse < _MAY_YIELD)
    always_at_yield = (without_live < _MAY_YIELD) & (at_collapse < _MAY_YIELD)
    force_in_condition = (abs(problem.true_yield) @ np.abs(forces)).max(axis=1)
    carries = force_in_condition > _FORCE_ROUNDING_TOLERANCE * largest
    return bool(ends_here.any() and not (always_at_yield & carries).any())

"""The end of the loop: an exact state of statics on the mechanism it found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_opt.models.interface import State
from masonry_opt.problem.certificate import certify
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.cvxpy_driver import state_at_yield
from masonry_opt.timing import Stopwatch

#: A face belongs to the mechanism if its rate exceeds this share of the largest: well above what the
#: solver's tolerance leaves of a zero. First the larger mechanism, then the surer one.
_SHARES = {True: (1e-4,), False: (1e-6, 1e-4)}

#: Energy of faces that move without being at yield, and departure from the flow rule, beyond which a state
#: is none of the mechanism's (in units of λ, and of the largest velocity).
MOST_ENERGY, MOST_DEPARTURE = 1e-3, 1e-2


@dataclass(frozen=True)
class ExactForces:
    """Joint forces (3c,) that obey equilibrium and the true law, at yield wherever the mechanism moves."""

    load_factor: float
    q: np.ndarray


def exact_finish(
    problem: Problem, state: State, near: float | None, slope: np.ndarray, rough: bool, watch: Stopwatch
) -> tuple[ExactForces | None, int]:
    """An exact state on the mechanism of a sub-problem, if there is one: the one whose λ is nearest to
    ``near``, or the least.

    Parameters
    ----------
    slope: opening per unit slip under the flow rule the state is to obey, shape (c,).
    rough: whether the sub-problem was solved roughly.

    Returns
    -------
    The forces or None, and how many linear programs were solved.
    """
    solves = 0
    for share in _SHARES[rough]:
        found = state_at_yield(problem, state.p > share * state.p.max(), near, watch)
        solves += 1
        if found is None:
            continue
        load_factor, q = found
        left = certify(problem, load_factor, q, state.d, slope)
        allowed = MOST_ENERGY * max(abs(load_factor), 1e-6)
        if left.complementarity <= allowed and left.flow <= MOST_DEPARTURE:
            return ExactForces(load_factor, q), solves
    return None, solves

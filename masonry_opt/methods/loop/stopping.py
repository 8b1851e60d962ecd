"""When a run of the loop stops, beside step 3: nothing to do, divergence, cycles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_opt.answer.thresholds import SAME
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import State

#: As often in a row must λ more than double for the loop to diverge.
_DOUBLINGS = 5

#: Or rises by so much at a time, as often in a row, to so many times where it began.
_RISE, _RISES, _GROWN = 1e-2, 30, 1e3

#: Longest cycle looked for, and the drift from one to the next, over its swing, that still is one.
LONGEST_PERIOD = 6
_STEADY = 0.05


def obeys_own_flow(problem: Problem, state: State) -> bool:
    """Whether sliding takes no part in the energy of an associative mechanism: it then obeys the joints' own
    flow rule, too."""
    n = problem.normal_forces(state.q)
    spared = ShearLimits(problem.friction - problem.dilatancy_at(n), problem.cohesion).at(n[problem.sliding])
    energy = float(spared @ problem.slip(state.p))
    return energy <= SAME * abs(state.load_factor) * problem.live_norm


def diverges(load_factors: Sequence[float]) -> bool:
    """Whether λ has more than doubled, or risen, time and again, to far beyond where it began."""

    def rose(by: float, times: int) -> bool:
        last = np.array(load_factors[-times - 1 :])
        return len(last) > times and last[0] > 0 and bool((last[1:] > (1 + by) * last[:-1]).all())

    return rose(1, _DOUBLINGS) or (rose(_RISE, _RISES) and load_factors[-1] > _GROWN * load_factors[0] > 0)


def period(load_factors: Sequence[float], normal: Sequence[np.ndarray]) -> int:
    """Length of the cycle the loop is in, or 0: load factors and normal forces came back twice, and
    the swing hardly dies away.

    Parameters
    ----------
    load_factors: of all sub-problems.
    normal: normal forces of the last few, ``LONGEST_PERIOD`` + 1 at least where there are as many.
    """
    values = np.array(load_factors)
    largest = float(np.abs(normal[-1]).max())
    for length in range(2, LONGEST_PERIOD + 1):
        if len(values) < 3 * length + 1:
            break
        earlier, before, now = values[-3 * length :].reshape(3, length)
        drift = max(np.abs(now - before).max(), np.abs(before - earlier).max())
        back = np.abs(normal[-1] - normal[-1 - length]).max() < 1e-2 * largest
        if drift < _STEADY * np.ptp(now) and back:
            return length
    return 0

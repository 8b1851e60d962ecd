"""The end of the loop: an exact state of statics on the mechanism it found."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from masonry_opt.answer.certificate import certify
from masonry_opt.effort import Stopwatch
from masonry_opt.problem.problem import Problem, yield_slacks
from masonry_opt.problem.state import State
from masonry_opt.solvers.cvxpy_driver import forces_for, motion_for, state_at_yield
from masonry_opt.solvers.load_units import in_units_of_load

#: A face belongs to the mechanism if its rate exceeds this share of the largest: well above what the
#: solver's tolerance leaves of a zero. First the larger mechanism, then the surer one.
_SHARES = (1e-6, 1e-4)

#: Energy of faces that move without being at yield, and departure from the flow rule, beyond which forces
#: and mechanism do not belong together (in units of λ, and of the largest velocity).
MOST_ENERGY, MOST_DEPARTURE = 1e-3, 1e-2

#: Below this λ is no measure of energy.
_SMALLEST = 1e-6

#: Weight of that energy over λ where a mechanism is known roughly: λ must fall by more than so many times the
#: energy that it adds. On façades 10 leaves up to half as much energy again; 100 leaves λ up to 0.2 % higher.
_WEIGHT = 30.0


@dataclass(frozen=True)
class ExactForces:
    """Joint forces (3c,) that obey equilibrium and the true law, the block velocities (3b,) of a mechanism
    that moves where they are at yield (but for MOST_ENERGY), and the opening per unit slip that the forces
    allow each joint, shape (c,)."""

    load_factor: float
    q: np.ndarray
    d: np.ndarray
    slope: np.ndarray


def exact_finish(
    problem: Problem, state: State, near: float, watch: Stopwatch
) -> tuple[ExactForces | None, int]:
    """An exact state on the mechanism of an accurately solved sub-problem, if there is one: the one whose λ
    is nearest to ``near``.

    Returns
    -------
    The forces or None, and how many linear programs were solved.
    """
    solves = 0
    for share in _SHARES:
        found = state_at_yield(problem, state.p > share * state.p.max(), near, watch)
        solves += 1
        if found is not None and (exact := _accepted(problem, *found, state.d)):
            return exact, solves
    return None, solves


def rough_finish(problem: Problem, state: State, watch: Stopwatch) -> tuple[ExactForces | None, int]:
    """Exact forces and a mechanism near that of a sub-problem solved roughly, whose rates are zero nowhere.

    First the forces that leave little energy z·p for its rates and have a low λ; then the mechanism of the
    true flow rule that leaves least for those forces (the sub-problem's own where the solver finds none).
    """
    scaled = in_units_of_load(problem)
    found = forces_for(scaled.problem, state.p, _WEIGHT, watch)
    if found is None:
        return None, 1
    load_factor, q = found
    slope = scaled.problem.dilatancy_at(q[0::3])[problem.sliding]
    slacks = np.maximum(yield_slacks(scaled.problem, q), 0.0)
    d = motion_for(scaled.problem, slacks, slope, watch)
    whole = scaled.state(replace(state, load_factor=load_factor, q=q))
    return _accepted(problem, whole.load_factor, whole.q, state.d if d is None else d), 2


def leaves_little(
    problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray, slope: np.ndarray
) -> bool:
    """Whether forces (3c,) and velocities (3b,) belong together under a flow rule, shape (c,)."""
    left = certify(problem, load_factor, q, d, slope)
    most = MOST_ENERGY * max(abs(load_factor), _SMALLEST)
    return left.complementarity <= most and left.flow <= MOST_DEPARTURE


def _accepted(problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray) -> ExactForces | None:
    slope = problem.dilatancy_at(q[0::3])
    if leaves_little(problem, load_factor, q, d, slope):
        return ExactForces(load_factor, q, d, slope)
    return None

"""Exact states of scenes of any size: the two programs in turn, by interior points.

From forces near a state, the mechanism that leaves least energy z·p for them; then, for its rates, forces of
low λ that leave little energy; and again. Interior points bring what is left to some 1e-8 of λ, on façades
where simplex would take minutes.
"""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.acceptance import Kind, over_load_factor
from masonry_opt.answer.answer import Answer, certified
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.energy import forces_for, motion_for
from masonry_opt.problem.load_units import in_units_of_load
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.registry import find_solver

#: Weights of the energy over λ, in turn. The first lets λ fall far, the last leaves hardly any energy.
_WEIGHTS = (1e3, 1e4)

#: Tolerance of the solver: at 1e-10 forces of façades exceed yield by 3e-8.
_TOLERANCE = 1e-11

#: Energy that a state may leave, over λ: with more another start is better.
_LEFT = 1e-5

#: What a solver does here, as a result tells it.
_PURPOSE = "exact state"


def alternated(problem: Problem, load_factor: float, q: np.ndarray, effort: Effort) -> Answer | None:
    """The state that λ and forces (3c,) lead to, exact but for an energy z·p up to 1e-5 of λ; None if there
    is none."""
    scaled, solver = in_units_of_load(problem), find_solver("cvxpy", None, _TOLERANCE)
    forces: tuple[float, np.ndarray] | None = load_factor / scaled.load_factor, q / scaled.force
    found: Answer | None = None
    effort.begins("exact state")
    for weight in (*_WEIGHTS, None):
        if forces is None:
            break
        d = motion_for(scaled, forces[1], solver, effort, _PURPOSE)
        if d is None:
            break
        answer = certified(problem, scaled.load_factor * forces[0], scaled.force * forces[1], d)
        left = over_load_factor(answer.certificate.complementarity, answer.load_factor)
        found = found if left > _LEFT or answer.failing(Kind.ONE_PASS) else answer
        if weight is not None:
            p = problem.rates(d, problem.dilatancy)
            forces = forces_for(scaled, p, solver, effort, _PURPOSE, weight)
    return found

"""The end of the loop: an exact state of statics on the mechanism it found."""

from dataclasses import replace
from functools import partial

import numpy as np

from masonry_opt.answer.acceptance import LIMITS, MOST_ENERGY, SMALLEST, Kind
from masonry_opt.answer.answer import Answer, certified
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.alternation import forces_for, motion_for
from masonry_opt.models.cvxpy_exact import CvxpyAtYield
from masonry_opt.problem.load_units import in_units_of_live_load, in_units_of_load
from masonry_opt.problem.problem import Problem, State
from masonry_opt.solvers.cvxpy_engine import has_optimum
from masonry_opt.solvers.registry import Solver, in_cvxpy

#: Share of the largest rate above which a face belongs to the mechanism, well above what the solver's
#: tolerance leaves of a zero: first for the larger mechanism, then for the surer one.
_SHARES = (1e-6, 1e-4)

_PURPOSE = "exact end"  #: What a solver does here, as a result tells it.


def accurate_end(
    problem: Problem, state: State, near: float, solver: Solver, effort: Effort
) -> Answer | None:
    """The exact state of λ nearest to ``near`` on the mechanism of an accurately solved sub-problem; None if
    there is none."""
    scaled = in_units_of_live_load(problem)
    for share in _SHARES:
        at_yield = state.p > share * state.p.max()
        model = CvxpyAtYield(scaled.problem, at_yield, near / scaled.load_factor)
        if has_optimum(model.program, in_cvxpy(solver), effort, _PURPOSE):
            load_factor, q = model.statics.forces()
            if end := _belonging(problem, scaled.load_factor * load_factor, q, state.d):
                return end
    return None


def rough_end(problem: Problem, state: State, solver: Solver, effort: Effort) -> Answer | None:
    """Exact forces and a mechanism near that of a sub-problem solved roughly, whose rates are zero nowhere.

    First the forces of low λ that leave little energy z·p for its rates; then the mechanism of the true flow
    rule that leaves least for those forces (the sub-problem's own if the solver finds none).
    """
    scaled = in_units_of_load(problem.by_cone)
    solver = in_cvxpy(solver, scaled.problem.by_friction.conic)
    solves = partial(has_optimum, solver=solver, effort=effort, purpose=_PURPOSE)
    forces = forces_for(scaled, state.p, solves)
    if forces is None:
        return None
    load_factor, q = forces
    d = motion_for(scaled, q, solves)
    whole = scaled.state(replace(state, load_factor=load_factor, q=q))
    return _belonging(problem, whole.load_factor, whole.q, state.d if d is None else d)


def belong_together(answer: Answer) -> bool:
    """Whether the forces and the velocities of an answer belong together, but for MOST_ENERGY."""
    most = MOST_ENERGY * max(abs(answer.load_factor), SMALLEST)
    left = answer.certificate
    return left.complementarity <= most and left.flow <= LIMITS[Kind.LOOP].flow


def _belonging(problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray) -> Answer | None:
    answer = certified(problem.by_cone, load_factor, q, d)
    return answer if belong_together(answer) else None

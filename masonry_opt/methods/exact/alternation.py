"""Exact states of scenes of any size: the two programs in turn, by interior points.

From forces near a state, the mechanism that leaves least energy z·p for them; then, for its rates, forces of
low λ that leave little; and again. Interior points bring what is left to some 1e-8 of λ, on façades where
simplex would take minutes.
"""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import cvxpy as cp
import numpy as np

from masonry_opt.answer.acceptance import Kind, over_load_factor
from masonry_opt.answer.answer import Answer, certified
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_cone import cone_forces, cone_motion
from masonry_opt.models.cvxpy_exact import CvxpyForces, CvxpyMotion, energy_costs
from masonry_opt.models.cvxpy_terms import Statics
from masonry_opt.problem.problem import Problem, Scaled, in_units_of_load
from masonry_opt.solvers.cvxpy_engine import has_optimum
from masonry_opt.solvers.registry import find_solver

#: Weight of the energy z·p over λ where a mechanism is known roughly: λ must fall by more than so many times
#: what that adds. On façades 10 leaves up to half as much energy again; 100 leaves λ up to 0.2 % higher.
WEIGHT = 30.0

Solves = Callable[[cp.Problem], bool]  #: Solves; whether there is an optimum to read.


def forces_for(
    scaled: Scaled, p: np.ndarray, solves: Solves, weight: float = WEIGHT
) -> tuple[float, np.ndarray] | None:
    """λ and forces (3c,) of a low λ that leave little energy for rates p (faces,); None if none are found."""
    problem = scaled.problem
    statics: Statics
    if problem.by_friction.conic:
        statics, program = cone_forces(problem, p, weight)
    else:
        forces = CvxpyForces(problem, energy_costs(problem, p, weight))
        statics, program = forces.statics, forces.program
    return statics.forces() if solves(program) else None


def motion_for(scaled: Scaled, q: np.ndarray, solves: Solves) -> np.ndarray | None:
    """Velocities (3b,) of the true flow rule that leave least energy for forces (3c,); None if none are."""
    problem = scaled.problem
    slope = problem.dilatancy_at(problem.normal_forces(q))
    if problem.by_friction.conic:
        d, program = cone_motion(problem, q, slope)
    else:
        motion = CvxpyMotion(problem, np.maximum(problem.slacks(q), 0.0) / problem.steep, slope)
        d, program = motion.mechanism.d, motion.program
    return np.asarray(d.value) if solves(program) else None


#: Weights of the energy over λ, in turn. The first lets λ fall far, the last leaves hardly any energy. In
#: space exact states lie further apart, and a weight that rises slowly leads lower; where it leads to none,
#: as on many rings of wedges, a large one from the start stays near the forces given.
_WEIGHTS = ((1e3, 1e4),)
_WEIGHTS_IN_SPACE = ((3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 1e4), (*5 * [1e4], *2 * [1e5, 1e6]))

#: Tolerances of the solver, the next where it does not come to one: at 1e-10 forces of façades exceed yield
#: by 3e-8. In the plane a program that is not solved to the first is given up.
_TOLERANCES = (1e-11, 1e-10, 1e-9)

_LEFT = 1e-5  #: Energy that a state may leave, over λ: with more another start is better.
_PURPOSE = "exact state"  #: What a solver does here, as a result tells it.


def alternated(
    problem: Problem,
    q: np.ndarray,
    d: np.ndarray | None,
    effort: Effort,
    follow: Callable[[], None] = lambda: None,
) -> Answer | None:
    """The state that forces (3c,) lead to, and the mechanism (3b,) where it is known, in space of the cone,
    exact but for an energy z·p up to 1e-5 of λ. ``follow`` is called before each program, and at the end."""
    effort.begins("exact state")
    problem = problem.by_cone
    conic = problem.by_friction.conic
    tolerances = _TOLERANCES if conic else _TOLERANCES[:1]
    solvers = [find_solver("cvxpy", None, tolerance) for tolerance in tolerances]

    def solve(program: Callable[..., Any]) -> Any:
        for solver in solvers:
            follow()
            # Contact points whose forces are indeterminate often stop Clarabel short of any tolerance.
            nearly = conic and solver is solvers[-1]
            solves = partial(has_optimum, solver=solver, effort=effort, purpose=_PURPOSE, nearly=nearly)
            if (one := program(solves=solves)) is not None:
                return one
        return None

    series = _WEIGHTS_IN_SPACE if conic else _WEIGHTS
    found = (_in_turn(problem, q, d, weights, solve) for weights in series)
    state = next((one for one in found if one is not None), None)
    follow()
    return state


def _in_turn(
    problem: Problem, q: np.ndarray, d: np.ndarray | None, weights: Iterable[float], solve: Callable[..., Any]
) -> Answer | None:
    """The last state within the limits that these weights lead to; of those that are exact, if any is."""
    scaled = in_units_of_load(problem)
    # Forces of contacts that give, or of other loads, need not balance: the load that fits best.
    fits = -float(problem.live @ problem.unbalanced(0.0, q)) / float(problem.live @ problem.live)
    forces: tuple[float, np.ndarray] | None = fits / scaled.load_factor, q / scaled.force
    found: Answer | None = None
    for weight in (*weights, None):
        if forces is None:
            break
        d = solve(partial(motion_for, scaled, forces[1])) if d is None else d
        if d is None:
            break
        load_factor, q = scaled.load_factor * forces[0], scaled.force * forces[1]
        answer = certified(problem, load_factor, q, d)
        left = over_load_factor(answer.certificate.complementarity, answer.load_factor)
        within = left <= _LEFT and not answer.failing(Kind.NEARLY_COMPLEMENTARY)
        if within and (found is None or answer.exact or not found.exact):
            found = answer
        if weight is not None:
            p, d = problem.rates(d, problem.dilatancy), None
            forces = solve(partial(forces_for, scaled, p, weight=weight))
    return found

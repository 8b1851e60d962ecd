"""Statics and kinematics at once, eqs (1) to (6), in Pyomo: what complementarity is asked of."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_terms import (
    SENSES,
    ShearLimited,
    add_forces,
    add_mechanism,
    dot,
    put,
    values,
)
from masonry_opt.problem.problem import Problem, ShearLimits, yield_slacks
from masonry_opt.problem.state import State, gather_state


class PyomoBothSides(ShearLimited):
    """Minimise λ (or, ``minimise=False``, nothing) subject to equilibrium, yield with its slacks z, the
    joints' own flow rule with its rates p, and f_L·d = Σ|f_L|. Complementarity of z and p is left to
    the models derived from this one."""

    def __init__(self, problem: Problem, minimise: bool = True) -> None:
        super().__init__(problem, ShearLimits.associative(problem))
        model, half = self.program, problem.half_length.tolist()
        dilatancy = problem.dilatancy.tolist()
        add_forces(model, problem)
        add_mechanism(model, problem, slope=lambda i: dilatancy[i])
        live_work = dot(problem.live, list(model.d.values()))
        model.live_work = pyo.Constraint(expr=live_work == problem.live_norm)

        model.slide_slack = pyo.Var(SENSES, model.sliding, domain=pyo.NonNegativeReals)
        model.rock_slack = pyo.Var(SENSES, model.joints, domain=pyo.NonNegativeReals)

        def slide_yield(m: Any, sense: str, i: int) -> Any:
            force = m.s[i] if sense == "+" else -m.s[i]
            return m.slide_slack[sense, i] == self.limit(i, m.n[i]) - force

        def rock_yield(m: Any, sense: str, i: int) -> Any:
            force = m.m[i] if sense == "+" else -m.m[i]
            return m.rock_slack[sense, i] == half[i] * m.n[i] - force

        model.slide_yield = pyo.Constraint(SENSES, model.sliding, rule=slide_yield)
        model.rock_yield = pyo.Constraint(SENSES, model.joints, rule=rock_yield)
        # A constant objective must still mention a variable to be written to a solver's file.
        model.objective = pyo.Objective(expr=(problem.live_norm if minimise else 0.0) * model.load_factor)

    def start_from(self, state: State) -> None:
        """Put a state, and the yield slacks that follow from it, into the variables."""
        model, k = self.program, self.problem.sliding
        slack = np.maximum(yield_slacks(self.problem, state.q), 0.0)
        model.load_factor.set_value(state.load_factor)
        for column, force in enumerate((model.n, model.s, model.m)):
            put(force, state.q[column::3])
        put(model.d, state.d)
        put(model.slide, state.p[:2, k])
        put(model.rock, state.p[2:])
        put(model.slide_slack, slack[:2, k])
        put(model.rock_slack, slack[2:])

    def read(self) -> State:
        """The state that the variables hold."""
        model = self.program
        return gather_state(
            self.problem,
            load_factor=model.load_factor.value,
            forces=[values(force) for force in (model.n, model.s, model.m)],
            d=values(model.d),
            slide=list(values(model.slide).reshape(2, -1)),
            rock=list(values(model.rock).reshape(2, -1)),
        )

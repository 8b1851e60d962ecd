"""Statics and kinematics in one Pyomo program; the MPEC and the global search add complementarity."""

from __future__ import annotations

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_arrays import put, values
from masonry_opt.models.pyomo_terms import Mechanism, Statics
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import State


class PyomoStates:
    """States under the joints' own flow rule, but for complementarity, eq. (8), which is left to the models
    derived from this one:

        min  λ Σ|f_L|    s.t.    B q + λ f_L + f_D = 0,    z = C(μ) q + c ≥ 0,
                                 Bᵀ d = D(tan φ₀) p,    f_L·d = Σ|f_L|,    p ≥ 0
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        model = self.program = pyo.ConcreteModel()
        statics = self.statics = Statics(model, problem, ShearLimits.true(problem))
        self.mechanism = Mechanism(model, problem, problem.dilatancy.tolist())
        faces = range(problem.faces)
        model.z = pyo.Var(faces, domain=pyo.NonNegativeReals)
        model.yielding = pyo.Constraint(faces, rule=lambda m, face: m.z[face] == statics.slacks[face])
        model.objective = pyo.Objective(expr=problem.live_norm * model.load_factor)

    def start_from(self, state: State) -> None:
        """Put a state, and the slacks that follow from it, into the variables."""
        model = self.program
        model.load_factor.set_value(state.load_factor)
        for variable, numbers in ((model.q, state.q), (model.d, state.d), (model.p, state.p)):
            put(variable, numbers)
        put(model.z, np.maximum(self.problem.slacks(state.q), 0.0))

    def read(self) -> State:
        """The state that the variables hold."""
        return State(*self.statics.forces(), values(self.mechanism.d), values(self.mechanism.p))

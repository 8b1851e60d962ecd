"""Collapse with Coulomb friction as a mixed complementarity problem (MCP), in Pyomo.

The MPEC and the program of method ``global`` extend this model.
"""

from typing import Any

import pyomo.environ as pyo
from pyomo.mpec import Complementarity, complements

from masonry_opt.models.pyomo_terms import PyomoMechanism, PyomoStatics, put, values
from masonry_opt.problem.problem import Problem, ShearLimits, State


class PyomoMcp:
    """Mixed complementarity problem whose solutions are the collapse states with Coulomb friction.

    The flow rule of each joint is given by the dilatancy of the joint. The conditions are eqs (1) to (6) and
    (8):

        B q + λ f_L + f_D = 0,    Bᵀ d = D(tan φ₀) p,    f_L·d = Σ|f_L|,
        0 ≤ z = C(μ) q + c  ⟂  p ≥ 0    for each face

    There is no objective. Several load factors λ may satisfy these conditions.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        model = self.program = pyo.ConcreteModel()
        statics = self.statics = PyomoStatics(model, problem, ShearLimits.true(problem))
        self.mechanism = PyomoMechanism(model, problem, problem.dilatancy.tolist())
        model.complementarity = Complementarity(
            range(problem.faces), rule=lambda m, face: complements(statics.slacks[face] >= 0, m.p[face] >= 0)
        )

    def start_from(self, state: State) -> None:
        """Set the initial values of the variables to a state."""
        self.program.load_factor.set_value(state.load_factor)
        put(self.statics.q, state.q)
        put(self.mechanism.d, state.d)
        put(self.mechanism.p, state.p)

    def read(self) -> State:
        """Return the state that the present values of the variables describe."""
        return State(*self.statics.forces(), values(self.mechanism.d), values(self.mechanism.p))


def with_slack_variables(model: PyomoMcp, transformation: str) -> Any:
    """Add slack variables z = C(μ) q + c ≥ 0 to the complementarity conditions, and return z.

    The program is changed in place. ``transformation`` is the name of a Pyomo transformation.
    """
    conditions = model.program.complementarity
    pyo.TransformationFactory(transformation).apply_to(model.program)
    for condition in conditions.values():
        condition.c.deactivate()  # omit the row p ≥ 0, because it is implied by the lower bound of p
    return pyo.Reference(conditions[:].v)


def with_pairs(model: PyomoMcp) -> None:
    """Rewrite the complementarity conditions in the form that Pyomo's writer of NL files needs.

    The program is changed in place. Each yield condition has a free variable z = C(μ) q + c, and a row z ≥ 0
    that is complementary to the bound p ≥ 0.
    """
    pyo.TransformationFactory("mpec.nl").apply_to(model.program)

"""Kinematic formulation, eq. (10), in Pyomo."""

import pyomo.environ as pyo

from masonry_opt.models.pyomo_terms import PyomoMechanism, PyomoShearParameters, dot, duals, values
from masonry_opt.problem.problem import Problem, ShearLimits, State


class PyomoKinematic:
    """Kinematic program, eq. (10), scaled such that velocities are of the order of 1.

    min  −f_D·d + c·p    s.t.    Bᵀ d = D(slope) p,    f_L·d = Σ|f_L|,    p ≥ 0
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        model = self.program = pyo.ConcreteModel()
        model.dual = pyo.Suffix(direction=pyo.Suffix.IMPORT)
        self.limits = PyomoShearParameters(model, limits)
        mechanism = self.mechanism = PyomoMechanism(model, problem, self.limits.slope)
        raising = dot(-problem.dead, list(mechanism.d.values()))
        dissipated = sum(self.limits.cohesion[i] * slip for i, slip in enumerate(mechanism.slip))
        model.objective = pyo.Objective(expr=raising + dissipated + mechanism.resisted)

    def read(self) -> State:
        """Return the state at the optimum of the program.

        Forces and λ are the dual values of compatibility and of the live work.
        """
        mechanism = self.mechanism
        load_factor, q = self.program.dual[mechanism.live_work], duals(mechanism.compatibility)
        return State(float(load_factor), q, values(mechanism.d), values(mechanism.p))

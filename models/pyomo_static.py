"""Static formulation, eq. (9), in Pyomo."""

import pyomo.environ as pyo

from masonry_opt.models.pyomo_terms import PyomoShearParameters, PyomoStatics, duals
from masonry_opt.problem.problem import Problem, ShearLimits, State


class PyomoStatic:
    """Static linear program, eq. (9) of the paper: the maximum of λ, written as a minimum of −λ.

        min  −λ Σ|f_L|    s.t.    B q + λ f_L + f_D = 0,    −z = −C(slope) q − c ≤ 0

    The condition n ≥ 0 is not a row, because the two rocking faces of a joint imply it. The program is not a
    maximisation, because the interior-point method of HiGHS without crossover would then report the status
    "unknown" at the optimum.
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        model = self.program = pyo.ConcreteModel()
        model.dual = pyo.Suffix(direction=pyo.Suffix.IMPORT)
        self.limits = PyomoShearParameters(model, limits)
        self.statics = PyomoStatics(model, problem, self.limits)
        z, faces = self.statics.slacks, range(problem.faces)
        model.within_yield = pyo.Constraint(faces, rule=lambda _, face: -z[face] <= 0)
        model.objective = pyo.Objective(expr=-problem.live_norm * self.statics.load_factor)

    def read(self) -> State:
        """Return the load factor, forces, velocities and rates at the optimum of the solved program.

        Velocities and rates are the negative of the dual values of equilibrium and yield.
        """
        d, p = -duals(self.statics.equilibrium), -duals(self.program.within_yield)
        return State(*self.statics.forces(), d, p)

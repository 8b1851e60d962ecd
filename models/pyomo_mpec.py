"""The least Coulomb load factor as a mathematical program with equilibrium constraints (MPEC), in Pyomo.

The module also contains a relaxation of the MPEC for IPOPT, and a form with a binary variable for each face.
"""

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_mcp import PyomoMcp, with_slack_variables
from masonry_opt.models.pyomo_terms import dot, put, values
from masonry_opt.problem.problem import Problem, State


class PyomoMpec(PyomoMcp):
    """MPEC for the least load factor of all exact Coulomb states.

        min  λ Σ|f_L|    over the states of PyomoMcp

    The objective is scaled by Σ|f_L|, like the velocities.
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        model = self.program
        model.objective = pyo.Objective(expr=problem.live_norm * model.load_factor)


class PyomoRelaxed:
    """Scholtes' relaxation of the complementarity conditions of an MCP or MPEC.

        z = C(μ) q + c,    z ≥ 0,    p ≥ 0,    z p ≤ ε    for each face

    The program of the MCP or MPEC is changed in place. For ε = 0, the feasible points are the states of the
    MCP.
    """

    def __init__(self, model: PyomoMcp) -> None:
        self._model = model
        self.program = model.program
        self.z = with_slack_variables(model, "mpec.simple_nonlinear")
        self.epsilon = self.program.mpec_bound  #: the bound ε, a mutable parameter
        #: Rows z p ≤ ε of all yield conditions. Only the bound ε changes between solves.
        self.complementarity_rows = list(pyo.Reference(self.program.complementarity[:].ccon).values())

    def start_from(self, state: State) -> None:
        """Set the initial values of the variables to a state, and those of z to the slacks of its forces."""
        self._model.start_from(state)
        put(self.z, np.maximum(self._model.problem.slacks(state.q), 0.0))

    def read(self) -> State:
        """Return the state that the present values of the variables describe."""
        return self._model.read()

    def products(self) -> np.ndarray:
        """Return the product z p of each yield condition, shape (faces,)."""
        return values(self.z) * values(self.program.p)


class PyomoGlobal(PyomoMpec):
    """MPEC with the bounds 0 ≤ λ ≤ Λ and with a binary variable y for each yield condition.

        p ≤ P y,    z ≤ Z (1 − y),    −f_D·d ≤ Λ Σ|f_L|

    The slack of a face is zero if y = 1, and its rate is zero if y = 0. The model is exact if the bounds P of
    rates and Z of slacks, shape (faces,), exclude no collapse state. Λ is an upper bound on λ ≥ 0, such as
    the associative load factor.

    The last row limits the rates but excludes no state: sliding dissipates energy, so the work of the live
    load is at least the work that raises the blocks.
    """

    def __init__(
        self, problem: Problem, most_slack: np.ndarray, most_rate: np.ndarray, highest: float
    ) -> None:
        super().__init__(problem)
        model = self.program
        faces = range(problem.faces)
        z = with_slack_variables(self, "mpec.standard_form")
        Z = most_slack.tolist()
        P = most_rate.tolist()
        model.load_factor.setlb(0.0)
        model.load_factor.setub(highest)
        model.y = pyo.Var(faces, domain=pyo.Binary)
        model.at_rest = pyo.Constraint(faces, rule=lambda m, face: m.p[face] <= P[face] * m.y[face])
        model.at_yield = pyo.Constraint(faces, rule=lambda m, face: z[face] <= Z[face] * (1 - m.y[face]))
        raising = dot(-problem.dead, list(model.d.values()))
        model.raising = pyo.Constraint(expr=raising <= highest * problem.live_norm)

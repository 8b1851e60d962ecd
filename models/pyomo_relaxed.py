"""Complementarity relaxed to products of slacks and rates, in Pyomo: what IPOPT is given."""

from __future__ import annotations

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_arrays import put, values
from masonry_opt.models.pyomo_mcp import PyomoMcp, with_slack_variables
from masonry_opt.problem.problem import State


class PyomoRelaxed:
    """An MCP or MPEC, rewritten in place, with Scholtes' relaxation of complementarity:

        z = C(μ) q + c,    z ≥ 0,    p ≥ 0,    z p ≤ ε    for each face

    At ε = 0 its feasible points are the states of the MCP.

    Attributes
    ----------
    epsilon: ε, a parameter of the program.
    complementarity_rows: the rows z p ≤ ε, whose bound is all that changes between solves.
    """

    def __init__(self, model: PyomoMcp) -> None:
        self._model = model
        self.program = model.program
        self.z = with_slack_variables(model, "mpec.simple_nonlinear")
        self.epsilon = self.program.mpec_bound
        self.complementarity_rows = list(pyo.Reference(self.program.complementarity[:].ccon).values())

    def start_from(self, state: State) -> None:
        """Put a state, and the slacks that follow from it, into the variables."""
        self._model.start_from(state)
        put(self.z, np.maximum(self._model.problem.slacks(state.q), 0.0))

    def read(self) -> State:
        """The state that the variables hold."""
        return self._model.read()

    def products(self) -> np.ndarray:
        """z p of every face, shape (faces,)."""
        return values(self.z) * values(self.program.p)

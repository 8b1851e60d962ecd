"""Residuals of a state in the equations of a declared complementarity problem."""

from typing import NamedTuple

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_mcp import PyomoMcp
from masonry_opt.models.pyomo_terms import values
from masonry_opt.problem.problem import State


class Residuals(NamedTuple):
    """Residuals of all equations, and the slack z and rate p of each face."""

    equilibrium: np.ndarray
    compatibility: np.ndarray
    live_work: float
    z: np.ndarray
    p: np.ndarray


def residuals(mcp: PyomoMcp, state: State) -> Residuals:
    """Return the residuals of a state; the variables of the model are set to the state."""
    mcp.start_from(state)
    statics, mechanism = mcp.statics, mcp.mechanism
    equations = (statics.equilibrium, mechanism.compatibility, mechanism.live_work)
    equilibrium, compatibility, (live_work,) = (
        np.array([pyo.value(row.body) - pyo.value(row.upper) for row in rows.values()]) for rows in equations
    )
    z = np.array([pyo.value(slack) for slack in statics.slacks])
    return Residuals(equilibrium, compatibility, live_work, z, values(mechanism.p))

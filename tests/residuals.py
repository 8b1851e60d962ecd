"""Residuals of a state in the equations of a declared complementarity problem."""

from typing import NamedTuple

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_mcp import PyomoMcp
from masonry_opt.models.pyomo_terms import values
from masonry_opt.problem.problem import State


class Residuals(NamedTuple):
    """Of each equation, and slack and rate of each face."""

    equilibrium: np.ndarray
    compatibility: np.ndarray
    live_work: float
    z: np.ndarray
    p: np.ndarray


def residuals(mcp: PyomoMcp, state: State) -> Residuals:
    """What the state, which the variables hold from then on, leaves."""
    mcp.start_from(state)
    statics, mechanism = mcp.statics, mcp.mechanism
    equations = (statics.equilibrium, mechanism.compatibility, mechanism.live_work)
    equilibrium, compatibility, (live_work,) = (
        np.array([pyo.value(row.body) - pyo.value(row.upper) for row in rows.values()]) for rows in equations
    )
    z = np.array([pyo.value(slack) for slack in statics.slacks])
    return Residuals(equilibrium, compatibility, live_work, z, values(mechanism.p))

"""What is recorded of each step of a pass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class NewtonStep:
    """One step of a pass, as it began.

    Attributes
    ----------
    iteration: counted from 1 in each attempt; a number is missing where the matrix had no factors and the
        step was tried again.
    load_factor: λ.
    gap: energy z·p of all faces, over the live load's work at |λ| (at 1e-3 at least).
    statics, yielding, motion: largest residuals: of equilibrium over the largest dead load (one at least), of
        slacks in the same units, and of the flow rule over the largest velocity (one at least).
    contraction: α.
    blend: θ.
    centring: σ, the share of the gap that is aimed at; NaN where the pass ended.
    forces, velocities: lengths of the step in statics and in kinematics.
    error: of the solution of the linear equations.
    full: whether they took a full factorisation.
    seconds: the step's time.
    attempt: which set of rules it belongs to.
    """

    iteration: int
    load_factor: float
    gap: float
    statics: float
    yielding: float
    motion: float
    contraction: float
    blend: float
    centring: float = np.nan
    forces: float = np.nan
    velocities: float = np.nan
    error: float = np.nan
    full: bool = False
    seconds: float = 0.0
    attempt: int = 1

"""Statics and kinematics of an answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class State:
    """Load factor, forces and motion, in the problem's dimensionless units.

    Attributes
    ----------
    load_factor: λ.
    q: joint forces, n of all joints, then s, then m, shape (3c,).
    d: block velocities vx, vy, ω in turn, scaled so that f_L·d = Σ|f_L|, shape (3b,).
    p: rates ≥ 0 of the faces, shape (faces,).
    """

    load_factor: float
    q: np.ndarray
    d: np.ndarray
    p: np.ndarray

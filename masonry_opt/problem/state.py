"""What every declared model has in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_opt.problem.problem import Problem, ShearLimits


@dataclass(frozen=True)
class State:
    """Statics and kinematics of an answer, in the problem's dimensionless units.

    Attributes
    ----------
    load_factor: λ.
    q: joint forces n, s, m in turn, shape (3c,).
    d: block velocities vx, vy, ω in turn, scaled so that f_L·d = Σ|f_L|, shape (3b,).
    p: rates ≥ 0 of sliding (+, −) and rocking (+, −), shape (4, c); zero where not modelled.
    """

    load_factor: float
    q: np.ndarray
    d: np.ndarray
    p: np.ndarray


def gather_state(
    problem: Problem,
    *,
    load_factor: float,
    forces: Sequence[np.ndarray],
    d: np.ndarray,
    slide: Sequence[np.ndarray],
    rock: Sequence[np.ndarray],
) -> State:
    """A state from n, s, m (each (c,)), d, sliding rates (two (k,), or none) and rocking rates (c,)."""
    p = np.zeros((4, problem.joints))
    for sense, rate in enumerate(slide):
        p[sense, problem.sliding] = rate
    p[2], p[3] = rock
    return State(float(load_factor), np.stack(forces, axis=1).ravel(), np.asarray(d), p)


def expect_same_terms(declared: bool, limits: ShearLimits) -> None:
    """Raise ValueError if limits bring a cohesion to a model declared without, or the reverse."""
    if declared != (limits.cohesion is not None):
        raise ValueError(
            "the model was declared with cohesion terms and the limits have none"
            if declared
            else "the limits have cohesion and the model was declared without its terms"
        )

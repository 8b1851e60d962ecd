"""What an analysis finds, before names and units are put to it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from masonry_opt.answer.status import Status
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.problem.state import State
from masonry_opt.solvers.lp import LpSize


@dataclass(frozen=True)
class Iteration:
    """One sub-problem of the loop.

    Attributes
    ----------
    iteration: counted from 1.
    load_factor: λ of the sub-problem, uncorrected.
    alpha: slope of its shear limit over μ (NaN for the first).
    change: largest change of a normal force since the last one, in median block weights.
    violation: largest violation of the true Coulomb law, in median block weights.
    raising: work against the dead load, in units of λ (paper, Fig. 12).
    sliding: energy dissipated in the sub-problem's sliding, in units of λ.
    coulomb_sliding: the same slips against the true law's shear limit (the paper's corrected
        energy), in units of λ.
    mismatch: energy by which sliding joints are off the true law (the small cohesion apart), each
        counted for itself, in units of λ.
    seconds: the solver's time.
    attempt, remedy: which run of the loop it belongs to, and what that run changed.
    state, limits: forces, mechanism and shear limits; for whoever follows the loop, not kept in a history.
    """

    iteration: int
    load_factor: float
    alpha: float
    change: float
    violation: float
    raising: float
    sliding: float
    coulomb_sliding: float
    mismatch: float
    seconds: float
    attempt: int = 1
    remedy: str = ""
    state: State | None = field(default=None, repr=False)
    limits: ShearLimits | None = field(default=None, repr=False)


@dataclass
class Finding:
    """How an analysis ended, in the problem's dimensionless units.

    Attributes
    ----------
    status, message: how, and in words (for a failure: what a user can do).
    load_factor: λ, None unless the status is usable.
    q, d: joint forces (3c,) and block velocities (3b,), where there are any.
    slope: opening per unit slip under the flow rule the answer claims, shape (c,).
    flow_rule_matters: False if the associative answer already obeys the joints' own flow rule.
    exact_end: whether the loop ended with forces that obey the true law exactly.
    history: the loop's sub-problems, or what another method records of its steps.
    iterations, lp_solves, nlp_solves: of the solver, and programs solved.
    stationary: of a refined state: True if no mechanism tried among the faces at yield lowers λ.
    bound: proven lower bound of λ, of the global search.
    size: of the linear program.
    """

    status: Status
    message: str = ""
    load_factor: float | None = None
    q: np.ndarray | None = None
    d: np.ndarray | None = None
    slope: np.ndarray | None = None
    flow_rule_matters: bool = True
    exact_end: bool = False
    history: list[Any] = field(default_factory=list)
    iterations: int = 0
    lp_solves: int = 0
    nlp_solves: int = 0
    stationary: bool | None = None
    bound: float | None = None
    size: LpSize | None = None

    def take(self, state: State) -> None:
        """Keep a state's forces and velocities."""
        self.q, self.d = state.q, state.d

"""What changes from step to step of a pass, when it has ended, and when it is given up."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from masonry_opt.methods.mcp.edge_form import EdgeForm, Iterate, IterateResiduals

#: Shares θ of the true friction in the statics of the matrix, the rest being the flow rule's slope: a rung up
#: after a short step, down after a long one. At θ = 1 the matrix is Newton's, at 0 that of an associative
#: program. The path of solutions over the gap has folds, at which the determinant of Newton's matrix changes
#: sign; a smaller θ passes. Below the gap θ is 1, and the brake is off.
_RUNGS, _NEWTON_BELOW = (1.0, 0.9, 0.7, 0.4, 0.0), 1e-4

#: Brakes of passes in turn: the gap falls no faster than so many times what the residuals weigh. Where a pass
#: stalls one under another brake mostly ends: on 15 of 15 stalls in 100 rubble walls of 200 stones, after
#: three at most.
BRAKES = (1.0, 0.3, 0.1, 3.0, 0.6, 0.2, 2.0)

#: Where contacts give, steps of statics and of kinematics are as long as each other below this gap, or what
#: forces move contacts by would be left over; in a pass under another brake than the first, below the second.
_ALIKE_BELOW, _ALIKE_AGAIN = 1e-6, 1e-2

#: Steps shorter than the first are short, longer than the second long.
_SHORT, _LONG = 0.1, 0.3

#: A pass is given up after so many steps in a row shorter than this, or when the gap has not halved in so
#: many steps.
_SHORTEST, _MOST_SHORT, _PATIENCE = 0.05, 13, 40

#: On the matrix's diagonal: at least, at most, and the factors on it after a short and after a long step.
_LEAST_DIAGONAL, _MOST_DIAGONAL, _MORE, _LESS = 1e-10, 1e-4, 100.0, 0.1

#: The end, which is no gate (the state must meet its kind's limits): gap, residual of statics and yield (over
#: the largest dead load, one at least), residual of kinematics (over the largest velocity, one at least;
#: projections at the end take off what is left of it), and how far below the gap the centre is set at most.
_GAP, _STATICS, _KINEMATICS, _OVERSHOOT = 1e-9, 1e-9, 1e-6, 0.3

#: Beyond this gap (or so many times that of the start, which is large where what carries the load weighs next
#: to nothing), or this work of the live load over the sum of dead loads (one at least), a pass has left what
#: can be an answer.
_LOST_GAP, _LOST_GROWTH, _LOST_LOAD = 1e9, 1e3, 1e8

#: The gap is measured at this λ at least.
LEAST_LOAD = 1e-3


@dataclass(frozen=True)
class NewtonStep:
    """One step of a pass, as it began.

    Attributes
    ----------
    iteration: counted from 1 in each pass; a number is missing where the matrix had no factors and the
        step was tried again.
    load_factor: λ.
    gap: energy z·p of all faces, over the live load's work at |λ| (at 1e-3 at least).
    statics, yielding, motion: largest residuals: of equilibrium over the largest dead load (one at least), of
        slacks in the same units, and of the flow rule over the largest velocity (one at least).
    blend: θ.
    centring: σ, the share of the gap that is aimed at; NaN where the pass ended.
    forces, velocities: lengths of the step in statics and in kinematics.
    error: of the solution of the linear equations.
    full: whether they took a full factorisation.
    seconds: the step's time.
    attempt: number of the pass.
    """

    iteration: int
    load_factor: float
    gap: float
    statics: float
    yielding: float
    motion: float
    blend: float
    centring: float = np.nan
    forces: float = np.nan
    velocities: float = np.nan
    error: float = np.nan
    full: bool = False
    seconds: float = 0.0
    attempt: int = 1


class Schedule:
    """Blend and diagonal of Newton's matrix, and the ends of a pass.

    Attributes
    ----------
    friction: slope of the shear limits in the matrix, shape (k,).
    diagonal: what is added to the diagonal of the blocks' matrix.
    alike_below: gap below which steps of statics and of kinematics are as long as each other.
    residuals: of the iterate looked at.
    """

    friction: np.ndarray
    residuals: IterateResiduals

    def __init__(self, form: EdgeForm, start: Iterate, brake: float) -> None:
        self._brake = brake
        rigid = not form.compliance.any()
        self.alike_below = 0.0 if rigid else _ALIKE_BELOW if brake == BRAKES[0] else _ALIKE_AGAIN
        self.form, problem = form, form.problem
        self.diagonal, self._rung, self._short = _LEAST_DIAGONAL, 0, 0
        self._halved = (0, inf)
        self._largest = max(float(np.abs(problem.dead).max()), 1.0)
        self._most_load = _LOST_LOAD * max(float(np.abs(problem.dead).sum()), 1.0) / problem.live_norm
        self._most_gap = max(_LOST_GAP, _LOST_GROWTH * self.gap(start))

    def gap(self, at: Iterate) -> float:
        """Energy z·p of all faces, over the live load's work at |λ|."""
        return at.energy / (self.form.problem.live_norm * max(abs(at.load_factor), LEAST_LOAD))

    def look(self, at: Iterate, iteration: int) -> NewtonStep:
        """Set the matrix's friction by the gap, and record what the iterate leaves."""
        problem, gap = self.form.problem, self.gap(at)
        theta = 1.0 if gap < _NEWTON_BELOW else _RUNGS[self._rung]
        self.friction = theta * problem.friction + (1 - theta) * problem.dilatancy
        left = self.residuals = self.form.residuals(at)
        return NewtonStep(
            iteration,
            at.load_factor,
            gap,
            float(np.abs(left.statics).max()) / self._largest,
            max(float(np.abs(of).max(initial=0.0)) for of in (left.yielding / self.form.steep, left.crushing))
            / self._largest,
            float(np.abs(left.motion).max()) / max(float(np.abs(at.d).max()), 1.0),
            theta,
        )

    def lost(self, step: NewtonStep) -> bool:
        """Whether gap or λ has left what can be an answer."""
        return not step.gap <= self._most_gap or abs(step.load_factor) > self._most_load

    def ended(self, step: NewtonStep) -> bool:
        """Whether the iterate is an answer."""
        exact = max(step.statics, step.yielding) < _STATICS and step.motion < _KINEMATICS
        return step.gap < _GAP and exact

    def centre(self, at: Iterate, predicted: float, gap: float) -> float:
        """σ: the share of the gap to aim at, given the predictor's energy. The brake keeps steps long
        until the residuals are gone."""
        energy = at.energy
        sigma = min(max(min(predicted / energy, 1.0) ** 3, _OVERSHOOT * _GAP / gap), 1.0)
        if gap > _NEWTON_BELOW:
            left = self.residuals
            weighs = (
                np.abs(left.yielding * at.slip).sum()
                + np.abs(left.crushing * at.crushed).sum()
                + np.abs(left.motion * at.x).sum()
                + np.abs(left.statics * at.d).sum()
            )
            sigma = max(sigma, min(1.0, self._brake * float(weighs) / energy))
        return sigma

    def lingers(self, step: NewtonStep) -> bool:
        """Whether the gap has not halved for too long."""
        if step.gap < self._halved[1] / 2:
            self._halved = (step.iteration, step.gap)
        return step.iteration - self._halved[0] > _PATIENCE

    def singular(self) -> bool:
        """Raise the diagonal of a matrix without factors; whether it cannot be raised further."""
        at_most = self.diagonal >= _MOST_DIAGONAL
        self.diagonal = min(_MORE * self.diagonal, _MOST_DIAGONAL)
        return at_most

    def stalls(self, length: float, *, at_once: bool = False) -> bool:
        """Adapt to the length of a step; whether it was the last of too many very short ones in a row, or at
        once the first."""
        if length < _SHORT:
            self._rung = min(self._rung + 1, len(_RUNGS) - 1)
            self.diagonal = min(_MORE * self.diagonal, _MOST_DIAGONAL)
        elif length > _LONG:
            self._rung = max(self._rung - 1, 0)
            self.diagonal = max(_LESS * self.diagonal, _LEAST_DIAGONAL)
        self._short = self._short + 1 if length < _SHORTEST else 0
        return self._short >= (1 if at_once else _MOST_SHORT)

"""Crushing as the parabola that it is, in CVXPY: eq. (9) and eq. (10) as conic programs."""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_kinematic import CvxpyKinematic
from masonry_opt.models.cvxpy_terms import Mechanism, ShearParameters, Statics
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import State


class CvxpyParabolaStatic:
    """Eq. (9), with the limit of crushing in place of its chords:

    max  λ Σ|f_L|    s.t.    B q + λ f_L + f_D = 0,    z = C(slope) q + c ≥ 0,
    |m| ≤ n (L/2 − n / (2 f_c))    at joints of limited strength
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        self._problem, joints = problem, problem.crushing
        straight = self._straight = np.ones(problem.faces, dtype=bool)
        straight[problem.bent] = False  # rocking and crushing of joints of limited strength
        self.limits = ShearParameters(limits)
        statics = self.statics = Statics(problem, self.limits)
        columns = problem.by_kind(np.arange(problem.B.shape[1]))[:, joints]
        n, _, m = (statics.q[of_kind] for of_kind in columns)
        half = problem.half_length[joints]
        most = cp.multiply(half, n - cp.multiply(1 / problem.crushing_force, cp.square(n)))
        self.within_yield = statics.slacks[straight] >= 0
        self.uncrushed = [m <= most, -m <= most]
        objective = cp.Maximize(problem.live_norm * statics.load_factor)
        self.program = cp.Problem(objective, [statics.equilibrium, self.within_yield, *self.uncrushed])

    def read(self) -> State:
        """The state at the optimum: velocities and rates are the duals of equilibrium and yield, those of
        crushing in the place of the rocking faces."""
        p = np.zeros(self._problem.faces)
        p[self._straight] = self.within_yield.dual_value
        for row, faces in zip(self.uncrushed, self._problem.bent[..., 0], strict=True):
            p[faces] = row.dual_value
        return State(*self.statics.forces(), self.statics.equilibrium.dual_value, p)


class CvxpyParabolaKinematic(CvxpyKinematic):
    """Eq. (10), where edges that turn by P and come w nearer than rigid ones dissipate f_c w² / (2 P):

    min  −f_D·d + c·p + Σ t    s.t.    Bᵀ d = D(slope) p − w,    f_L·d = Σ|f_L|,    p ≥ 0,
    f_c L w² ≤ 2 L P t
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        joints = problem.crushing
        self.limits = ShearParameters(limits)
        self.mechanism = mechanism = Mechanism(problem, self.limits.slope)
        one, other = problem.bent[..., 0]
        turning = mechanism.p[one] + mechanism.p[other]
        # The flow of D turns about edges a little within the true ones: about the first chord's.
        half, lever = problem.half_length[joints], problem.lever[joints]
        self.closing = cp.Variable(len(joints), name="w")
        self.energy = cp.Variable(len(joints), name="t")
        into = np.zeros((problem.B.shape[1], len(joints)))
        into[joints, np.arange(len(joints))] = 1.0
        flow = mechanism.compatibility.expr + into @ (self.closing - cp.multiply(half - lever, turning))
        self.compatibility = flow == 0
        factor = problem.crushing_force / (4 * half)
        cone = cp.SOC(
            turning + self.energy,
            cp.vstack([turning - self.energy, 2 * cp.multiply(np.sqrt(factor), self.closing)]),
            axis=0,
        )
        work = -problem.dead @ mechanism.d + self.limits.cohesion @ mechanism.slip + cp.sum(self.energy)
        if problem.matrices.limited:
            of_forces = problem.table.limits
            work += problem.face_constant[of_forces] @ mechanism.p[of_forces]
        chords = mechanism.p[problem.table.chords] == 0
        rows = [self.compatibility, mechanism.live_work, chords, cone]
        self.program = cp.Problem(cp.Minimize(work), rows)

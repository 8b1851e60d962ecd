"""Crushing as the parabola that it is, in CVXPY: eq. (9) and eq. (10) as conic programs."""

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_kinematic import CvxpyKinematic
from masonry_opt.models.cvxpy_terms import Mechanism, ShearParameters, Statics
from masonry_opt.problem.problem import Problem, ShearLimits, State


class CvxpyParabolaStatic:
    """Eq. (9), with the limit of crushing in place of its chords:

    max  λ Σ|f_L|    s.t.    B q + λ f_L + f_D = 0,    z = C(slope) q + c ≥ 0,
    2 n₁, 2 n₂ ≥ t,    n² ≤ f_c L t    at joints of limited strength

    (the paper's |m| ≤ L/2 (n − n² / (f_c L))).
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        self._problem, joints = problem, problem.crushing
        straight = self._straight = np.ones(problem.faces, dtype=bool)
        straight[problem.bent] = straight[problem.table.turning] = False
        self.limits = ShearParameters(limits)
        statics = self.statics = Statics(problem, self.limits)
        first, second = (statics.q[of_point + joints] for of_point in (0, problem.joints))
        t = cp.Variable(len(joints), name="t")
        self.within_yield = statics.slacks[straight] >= 0
        self.uncrushed = [t <= 2 * first, t <= 2 * second]
        n = cp.multiply(1 / np.sqrt(problem.crushing_force), first + second)
        cone = cp.SOC(t + 1, cp.vstack([t - 1, 2 * n]), axis=0)
        objective = cp.Maximize(problem.live_norm * statics.load_factor)
        self.program = cp.Problem(objective, [statics.equilibrium, self.within_yield, *self.uncrushed, cone])

    def read(self) -> State:
        """The state at the optimum: velocities and rates are the duals of equilibrium and yield, those of
        crushing in the place of the rocking faces."""
        p = np.zeros(self._problem.faces)
        p[self._straight] = self.within_yield.dual_value
        for row, faces in zip(self.uncrushed, self._problem.table.turning, strict=True):
            p[faces] = row.dual_value
        return State(*self.statics.forces(), self.statics.equilibrium.dual_value, p)


class CvxpyParabolaKinematic(CvxpyKinematic):
    """Eq. (10), where joints whose points rock at rates of the sum P and come w nearer than rigid ones
    dissipate f_c L w² / (4 P) ≤ t:

    min  −f_D·d + c·p + Σ t    s.t.    Bᵀ d = D(slope) p − w,    f_L·d = Σ|f_L|,    p ≥ 0,
    f_c L w² ≤ 4 P t
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        joints = problem.crushing
        self.limits = ShearParameters(limits)
        self.mechanism = mechanism = Mechanism(problem, self.limits.slope)
        one, other = problem.table.turning
        turning = mechanism.p[one] + mechanism.p[other]
        self.closing = cp.Variable(len(joints), name="w")
        t = cp.Variable(len(joints), name="t")
        nearer = problem.table.normal_sums[joints].T
        self.compatibility = mechanism.compatibility.expr + nearer @ self.closing == 0
        crushed = cp.multiply(np.sqrt(problem.crushing_force), self.closing)
        cone = cp.SOC(turning + t, cp.vstack([turning - t, crushed]), axis=0)
        work = -problem.dead @ mechanism.d + self.limits.cohesion @ mechanism.slip + cp.sum(t)
        if problem.matrices.limited:
            of_forces = problem.table.limits
            work += problem.face_constant[of_forces] @ mechanism.p[of_forces]
        chords = mechanism.p[problem.table.chords] == 0
        rows = [self.compatibility, mechanism.live_work, chords, cone]
        self.program = cp.Problem(cp.Minimize(work), rows)

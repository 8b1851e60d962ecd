"""Crushing as the parabola that it is, in CVXPY: eq. (9) and eq. (10) as conic programs."""

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_kinematic import CvxpyKinematic
from masonry_opt.models.cvxpy_terms import Mechanism, ShearParameters, Statics
from masonry_opt.problem.problem import Problem, ShearLimits, State


class _Sized:
    """Cones of crushing for normal forces of the size N: those of numbers far from one, or from each other,
    cost a solver its last digits."""

    def __init__(self, problem: Problem) -> None:
        self._problem, crushing = problem, len(problem.crushing)
        self.per_size = cp.Parameter(crushing, name="1/N")
        #: N² / (f_c L): what forces of that size take off 2 n₁ and 2 n₂.
        self.most_lost = cp.Parameter(crushing, name="lost")
        self.resize(None)

    def resize(self, q: np.ndarray | None) -> None:
        """Take N from forces q, shape (3c,); without any, between a force of one and one that crushes."""
        joints, whole = self._problem.crushing, self._problem.crushing_force
        n = np.sqrt(whole) if q is None else np.abs(self._problem.normal_forces(q)[joints]).mean() + 0 * whole
        self.per_size.value, self.most_lost.value = 1 / n, n**2 / whole


class CvxpyParabolaStatic(_Sized):
    """Eq. (9), with the limit of crushing in place of its chords:

    max  λ Σ|f_L|    s.t.    B q + λ f_L + f_D = 0,    z = C(slope) q + c ≥ 0,
    2 n₁, 2 n₂ ≥ N t / (f_c L),    n² ≤ N t    at joints of limited strength

    (the paper's |m| ≤ L/2 (n − n² / (f_c L))).
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        super().__init__(problem)
        joints = problem.crushing
        straight = self._straight = np.ones(problem.faces, dtype=bool)
        straight[problem.bent] = straight[problem.table.turning] = False
        self.limits = ShearParameters(limits)
        statics = self.statics = Statics(problem, self.limits)
        first, second = (statics.q[of_point + joints] for of_point in (0, problem.joints))
        t = cp.Variable(len(joints), name="t")
        lost = cp.multiply(self.most_lost, t)
        self.within_yield = statics.slacks[straight] >= 0
        self.uncrushed = [lost <= 2 * first, lost <= 2 * second]
        n = cp.multiply(self.per_size, first + second)
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


class CvxpyParabolaKinematic(_Sized, CvxpyKinematic):
    """Eq. (10), where joints whose points rock at rates of the sum P and come w nearer than rigid ones
    dissipate f_c L w² / (4 P) ≤ N² t / (f_c L):

    min  −f_D·d + c·p + Σ N² t / (f_c L)    s.t.    Bᵀ d = D(slope) p − w,    f_L·d = Σ|f_L|,    p ≥ 0,
    (f_c L w / 2 N)² ≤ P t
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        _Sized.__init__(self, problem)
        joints = problem.crushing
        self.limits = ShearParameters(limits)
        self.mechanism = mechanism = Mechanism(problem, self.limits.slope)
        one, other = problem.table.turning
        turning = mechanism.p[one] + mechanism.p[other]
        self.closing = cp.Variable(len(joints), name="w")
        t = cp.Variable(len(joints), name="t")
        nearer = problem.table.normal_sums[joints].T
        self.compatibility = mechanism.compatibility.expr + nearer @ self.closing == 0
        crushed = cp.multiply(cp.multiply(problem.crushing_force, self.per_size), self.closing)
        cone = cp.SOC(turning + t, cp.vstack([turning - t, crushed]), axis=0)
        work = -problem.dead @ mechanism.d + self.limits.cohesion @ mechanism.slip + self.most_lost @ t
        if problem.matrices.limited:
            of_forces = problem.table.limits
            work += problem.face_constant[of_forces] @ mechanism.p[of_forces]
        chords = mechanism.p[problem.table.chords] == 0
        rows = [self.compatibility, mechanism.live_work, chords, cone]
        self.program = cp.Problem(cp.Minimize(work), rows)

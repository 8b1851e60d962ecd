"""Static and kinematic programs, eqs (9) and (10), with the parabola of limited strength, in CVXPY."""

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_kinematic import CvxpyKinematic
from masonry_opt.models.cvxpy_terms import CvxpyMechanism, CvxpyShearParameters, CvxpyStatics
from masonry_opt.problem.problem import Problem, ShearLimits, State


class _Sized:
    """Base class of programs with a cone constraint for crushing, scaled by a reference normal force N.

    Solvers lose their last digits if the numbers in a cone are far from one, or far from each other.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        crushing = len(problem.crushing)
        self.per_size = cp.Parameter(crushing, name="1/N")
        #: The crushing law requires 2 n₁ and 2 n₂ ≥ n² / (f_c L). Here n₁ and n₂ are the forces at the two
        #: edges of the joint, n is their sum, and f_c L is the crushing force. This parameter is n² / (f_c L)
        #: for n = N.
        self.most_lost = cp.Parameter(crushing, name="lost")
        self.resize(None)

    def resize(self, q: np.ndarray | None) -> None:
        """Set N to the mean normal force of the joints that can crush, for joint forces q of shape (3c,).

        If q is None, N is √(f_c L), the geometric mean of 1 and the crushing force.
        """
        whole = self._problem.crushing_force
        if q is None:
            n = np.sqrt(whole)
        else:
            n = np.abs(self._problem.normal_forces(q)[self._problem.crushing]).mean() + 0 * whole
        self.per_size.value = 1 / n
        self.most_lost.value = n**2 / whole


class CvxpyParabolaStatic(_Sized):
    """Static program, eq. (9), with the exact crushing parabola instead of its chords.

        max  λ Σ|f_L|    s.t.    B q + λ f_L + f_D = 0,    z = C(slope) q + c ≥ 0,
        2 n₁, 2 n₂ ≥ N t / (f_c L),    n² ≤ N t    at joints of limited strength

    This is the paper's |m| ≤ L/2 (n − n² / (f_c L)).
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        super().__init__(problem)
        joints = problem.crushing
        straight = self._straight = np.ones(problem.faces, dtype=bool)
        straight[problem.bent] = straight[problem.table.turning] = False
        self.limits = CvxpyShearParameters(limits)
        statics = self.statics = CvxpyStatics(problem, self.limits)
        first = statics.q[joints]
        second = statics.q[problem.joints + joints]
        t = cp.Variable(len(joints), name="t")
        lost = cp.multiply(self.most_lost, t)
        self.within_yield = statics.slacks[straight] >= 0
        self.uncrushed = [lost <= 2 * first, lost <= 2 * second]
        n = cp.multiply(self.per_size, first + second)
        cone = cp.SOC(t + 1, cp.vstack([t - 1, 2 * n]), axis=0)
        objective = cp.Maximize(problem.live_norm * statics.load_factor)
        self.program = cp.Problem(objective, [statics.equilibrium, self.within_yield, *self.uncrushed, cone])

    def read(self) -> State:
        """Return the state at the optimum of the program.

        Velocities and rates are the dual values of equilibrium and yield. The dual values of the crushing
        conditions are the rates of the rocking faces.
        """
        p = np.zeros(self._problem.faces)
        p[self._straight] = self.within_yield.dual_value
        for row, faces in zip(self.uncrushed, self._problem.table.turning, strict=True):
            p[faces] = row.dual_value
        return State(*self.statics.forces(), self.statics.equilibrium.dual_value, p)


class CvxpyParabolaKinematic(_Sized, CvxpyKinematic):
    """Kinematic program, eq. (10), in which crushing dissipates energy according to the exact parabola.

    A joint dissipates the energy f_c L w² / (4 P) ≤ N² t / (f_c L). Here P is the sum of the rocking rates of
    its points, and w is its closing:

        min  −f_D·d + c·p + Σ N² t / (f_c L)    s.t.    Bᵀ d = D(slope) p − w,    f_L·d = Σ|f_L|,    p ≥ 0,
        (f_c L w / 2 N)² ≤ P t
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        _Sized.__init__(self, problem)
        joints = problem.crushing
        self.limits = CvxpyShearParameters(limits)
        self.mechanism = mechanism = CvxpyMechanism(problem, self.limits.slope)
        first, second = problem.table.turning
        rocking = mechanism.p[first] + mechanism.p[second]
        self.closing = cp.Variable(len(joints), name="w")
        t = cp.Variable(len(joints), name="t")
        normal = problem.table.normal_sums[joints].T
        self.compatibility = mechanism.compatibility.expr + normal @ self.closing == 0
        crushed = cp.multiply(cp.multiply(problem.crushing_force, self.per_size), self.closing)
        cone = cp.SOC(rocking + t, cp.vstack([rocking - t, crushed]), axis=0)
        work = -problem.dead @ mechanism.d + self.limits.cohesion @ mechanism.slip + self.most_lost @ t
        if problem.matrices.limited:
            limit_faces = problem.table.limits
            work += problem.face_constant[limit_faces] @ mechanism.p[limit_faces]
        chords = mechanism.p[problem.table.chords] == 0
        rows = [self.compatibility, mechanism.live_work, chords, cone]
        self.program = cp.Problem(cp.Minimize(work), rows)

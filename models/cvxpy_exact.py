"""Programs for exact states, in CVXPY: forces for a given mechanism, and a mechanism for given forces.

Each program minimises the energy z·p of faces that have nonzero rates although they are not at yield. If this
energy is zero, forces and mechanism satisfy complementarity, eq. (8), and form a collapse state. Two further
programs are Farkas alternatives: each proves that one of the first two programs has no solution.
"""

from dataclasses import replace

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import CvxpyMechanism, CvxpyStatics
from masonry_opt.problem.problem import Problem, ShearLimits


class CvxpyForces:
    """Program for forces that satisfy equilibrium and the yield conditions, and minimise a linear cost.

        min  a λ + b·q    s.t.    B q + λ f_L + f_D = 0,    0 ≤ z = C(μ) q + c ≤ room,    λ within an interval

    The costs are the number a and the vector b of shape (3c,), which may be a parameter. Both are zero by
    default. With costs from the rates of a mechanism, the program finds forces that are compatible with the
    mechanism. ``room`` is infinite in this declaration. The solver session sets it to 0 for the faces that
    must be at yield.
    """

    def __init__(
        self,
        problem: Problem,
        costs: tuple[float, np.ndarray | cp.Parameter] | None = None,
        within: tuple[float, float] | None = None,
    ) -> None:
        load_factor = cp.Variable(bounds=list(within), name="load_factor") if within else None
        statics = self.statics = CvxpyStatics(problem, ShearLimits.true(problem), load_factor)
        self.within_yield = cp.multiply(1 / problem.steep, statics.slacks) >= 0
        a, b = costs or (0.0, np.zeros(problem.B.shape[1]))
        cost = b @ statics.q + a * statics.load_factor
        self.program = cp.Problem(cp.Minimize(cost), [statics.equilibrium, self.within_yield])


class CvxpyMotion:
    """Program for the mechanism whose rates minimise a linear cost.

        min  cost·p    s.t.    Bᵀ d = D(slope) p,    f_L·d = Σ|f_L|,    0 ≤ p ≤ most,    −f_D·d ≤ raising

    The cost, shape (faces,), may be a parameter. It usually consists of the slacks z ≥ 0 of given forces,
    with which the mechanism is then compatible; the default is zero. The slope is the opening per unit slip,
    shape (k,); the default is the joints' dilatancy. ``most`` is infinite in this declaration. The solver
    session sets it to 0 for the faces whose rates must be zero.
    """

    def __init__(
        self,
        problem: Problem,
        cost: np.ndarray | cp.Parameter | None = None,
        slope: np.ndarray | None = None,
        raising: float | None = None,
    ) -> None:
        mechanism = self.mechanism = CvxpyMechanism(problem, problem.dilatancy if slope is None else slope)
        rows = [mechanism.compatibility, mechanism.live_work]
        if raising is not None:
            rows.append(-problem.dead @ mechanism.d <= raising)
        cost = np.zeros(problem.faces) if cost is None else cost
        self.program = cp.Problem(cp.Minimize(cost @ mechanism.p), rows)


class CvxpyDrivenMotion:
    """Program for a mechanism that the live load can drive at a load factor of at most λ.

        Bᵀ d = D(tan ψ) p,    f_L·d = Σ|f_L|,    p ≥ 0,    e·p − f_D·d ≤ λ Σ|f_L|

    The energy e, shape (faces,), is the least energy that each yield condition dissipates per unit rate. It
    is c and, for sliding, the least (μ − tan ψ) n of all states in addition. A collapse state satisfies c·p +
    Σ (μ − tan ψ) n γ − f_D·d = λ f_L·d, in which γ is the slip of each joint.
    """

    def __init__(self, problem: Problem, energy: np.ndarray, highest: float) -> None:
        mechanism = self.mechanism = CvxpyMechanism(problem, problem.dilatancy)
        self.balance = energy @ mechanism.p - problem.dead @ mechanism.d <= highest * problem.live_norm
        rows = [mechanism.compatibility, mechanism.live_work, self.balance]
        self.program = cp.Problem(cp.Minimize(0), rows)


class CvxpyAtYield:
    """Program for joint forces that are at yield on all faces with nonzero rates.

    The program minimises the distance of λ from the value ``near``:

        min  |λ − near|    s.t.    B q + λ f_L + f_D = 0,    z = 0 on the faces at yield,    z ≥ 0 elsewhere

    Such forces satisfy complementarity with the mechanism, eq. (8). ``at_yield``, shape (faces,), is True for
    the faces with nonzero rates in the mechanism.
    """

    def __init__(self, problem: Problem, at_yield: np.ndarray, near: float) -> None:
        self.statics = CvxpyStatics(problem, ShearLimits.true(problem))
        z = self.statics.slacks
        rows = [self.statics.equilibrium, z[at_yield] == 0, z[~at_yield] >= 0]
        self.program = cp.Problem(cp.Minimize(cp.abs(self.statics.load_factor - near)), rows)


class CvxpyNoMotion:
    """Program for joint forces which prove that the live load does no positive work in any mechanism.

    The forces are in equilibrium with the live load alone, without the dead load.

        min  Σ v    s.t.    B q + f_L = 0,    C(slope) q + v ≥ 0,    0 ≤ v ≤ most

    Every mechanism Bᵀ d = D(slope) p satisfies f_L·d = −(C(slope) q)·p. This work is at most 0 unless a face
    with v > 0 has a nonzero rate. The proof is therefore complete if v = 0.

    If the slope, shape (k,), is the true friction, the forces are a direction in which λ grows without bound.
    ``most`` is infinite in this declaration. The solver session sets it to 0 for the faces that may have
    nonzero rates.
    """

    def __init__(self, problem: Problem, slope: np.ndarray) -> None:
        alone = replace(problem.recession_cone, dead=problem.live)
        statics = CvxpyStatics(alone, ShearLimits(slope, np.zeros_like(slope)), load_factor=cp.Constant(0.0))
        self.q, self.v = statics.q, cp.Variable(problem.faces, nonneg=True, name="v")
        rows = [statics.equilibrium, statics.slacks + self.v >= 0]
        self.program = cp.Problem(cp.Minimize(cp.sum(self.v)), rows)


class CvxpyNoForces:
    """Program for a motion which proves that given yield conditions cannot all be active in one state.

    If a motion gains energy, no forces bring all given conditions to yield.

        min  Σ r    s.t.    Bᵀ d = C(μ)ᵀ (p − r),    f_L·d ≥ 0,    f_D·d − c·(p − r) = 1,    p ≥ 0,
        0 ≤ r ≤ most

    All forces with λ ≥ 0 satisfy z·(p − r) = c·(p − r) − f_D·d − λ f_L·d ≤ −1. Therefore z ≥ 0 everywhere and
    z = 0 on the faces with r > 0 are not possible together. ``most`` is infinite in this declaration. The
    solver session sets it to 0 for the faces that are not required to be at yield.
    """

    def __init__(self, problem: Problem) -> None:
        self.d = cp.Variable(problem.B.shape[0], name="d")
        self.p, self.r = (cp.Variable(problem.faces, nonneg=True, name=name) for name in "pr")
        rates = self.p - self.r
        gain = problem.dead @ self.d - problem.face_cohesion @ rates
        compatibility = problem.B.T @ self.d - problem.D(problem.friction) @ rates == 0
        rows = [compatibility, problem.live @ self.d >= 0, gain == 1]
        self.program = cp.Problem(cp.Minimize(cp.sum(self.r)), rows)

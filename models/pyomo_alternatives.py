"""Farkas' alternatives of the two programs of exact refinement, in Pyomo: what shows that they are empty."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyomo.environ as pyo
import scipy.sparse as sp

from masonry_opt.models.pyomo_arrays import dot, rows
from masonry_opt.models.pyomo_terms import Statics
from masonry_opt.problem.problem import Problem, ShearLimits


class PyomoNoMotion:
    """Forces that carry the live load alone: they show that no mechanism lets it do work.

        min  Σ v    s.t.    B q + f_L = 0,    C(slope) q + v ≥ 0,    0 ≤ v ≤ most

    Every mechanism Bᵀ d = D(slope) p has f_L·d = −(C(slope) q)·p, and so f_L·d ≤ 0 unless a face with v > 0
    moves. With the slope of the true friction the forces are a ray along which λ grows without end.

    ``most`` is infinite here; a solver that stays loaded is given 0 for the faces that may move.

    Parameters
    ----------
    slope: opening per unit slip, shape (k,).
    """

    def __init__(self, problem: Problem, slope: np.ndarray) -> None:
        model = self.program = pyo.ConcreteModel()
        alone = replace(problem.recession_cone, dead=problem.live)
        limits = ShearLimits(slope, np.zeros_like(slope))
        statics, faces = Statics(model, alone, limits, load_factor=0.0), range(problem.faces)
        model.v = pyo.Var(faces, domain=pyo.NonNegativeReals)
        model.within_yield = pyo.Constraint(faces, rule=lambda m, face: statics.slacks[face] + m.v[face] >= 0)
        model.objective = pyo.Objective(expr=sum(model.v.values()))


class PyomoNoForces:
    """A motion that gains energy: it shows that no forces bring certain faces to yield together.

        min  Σ r    s.t.    Bᵀ d = C(μ)ᵀ (p − r),    f_L·d ≥ 0,    f_D·d − c·(p − r) = 1,    p ≥ 0,
        0 ≤ r ≤ most

    All forces with λ ≥ 0 have Σ z (p − r) = c·(p − r) − f_D·d − λ f_L·d ≤ −1, and so not z ≥ 0 with z = 0 on
    the faces with r > 0.

    ``most`` is infinite here; a solver that stays loaded is given 0 for the faces that are not held at yield.
    """

    def __init__(self, problem: Problem) -> None:
        model = self.program = pyo.ConcreteModel()
        faces = range(problem.faces)
        model.d = pyo.Var(range(problem.B.shape[0]))
        model.p = pyo.Var(faces, domain=pyo.NonNegativeReals)
        model.r = pyo.Var(faces, domain=pyo.NonNegativeReals)
        d, rates = list(model.d.values()), [*model.p.values(), *model.r.values()]
        flow, cohesion = problem.D(problem.friction), problem.face_cohesion
        motion = list(rows(problem.B.T.tocsr(), d))
        against = list(rows(sp.hstack([-flow, flow], format="csr"), rates))
        model.compatibility = pyo.Constraint(
            range(problem.B.shape[1]), rule=lambda _, row: motion[row] + against[row] == 0
        )
        model.live_work = pyo.Constraint(expr=dot(problem.live, d) >= 0)
        everything = np.concatenate([problem.dead, -cohesion, cohesion])
        model.gain = pyo.Constraint(expr=dot(everything, [*d, *rates]) == 1)
        model.objective = pyo.Objective(expr=sum(model.r.values()))

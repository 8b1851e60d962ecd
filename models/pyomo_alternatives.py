"""Farkas' alternatives of the two programs of exact refinement, in Pyomo: what shows that they are empty."""

from __future__ import annotations

from math import inf

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_arrays import dot, rows
from masonry_opt.problem.problem import Problem


class PyomoNoMotion:
    """Forces that carry the live load alone: they show that no mechanism lets it do work.

        min  Σ v    s.t.    B q + f_L = 0,    C(slope) q + v ≥ 0,    0 ≤ v ≤ most

    Every mechanism Bᵀ d = D(slope) p has f_L·d = −(C(slope) q)·p, and so f_L·d ≤ 0 unless a face with v > 0
    moves. With the slope of the true friction the forces are a ray along which λ grows without end.

    Parameters
    ----------
    slope: opening per unit slip, shape (k,).

    Parameter of the program: ``most``, shape (faces,), 0 but on the faces that do not move.
    """

    def __init__(self, problem: Problem, slope: np.ndarray) -> None:
        model = self.program = pyo.ConcreteModel()
        faces = range(problem.faces)
        model.q = pyo.Var(range(problem.B.shape[1]))
        model.v = pyo.Var(faces, domain=pyo.NonNegativeReals)
        model.cost = pyo.Param(faces, mutable=True, initialize=1.0)
        model.most = pyo.Param(faces, mutable=True, initialize=0.0)
        q, live = list(model.q.values()), problem.live.tolist()
        internal, slacks = list(rows(problem.B, q)), list(rows(problem.C(slope), q))
        model.equilibrium = pyo.Constraint(
            range(problem.B.shape[0]), rule=lambda _, row: internal[row] == -live[row]
        )
        model.within_yield = pyo.Constraint(faces, rule=lambda m, face: slacks[face] + m.v[face] >= 0)
        model.objective = pyo.Objective(expr=pyo.sum_product(model.cost, model.v))


class PyomoNoForces:
    """A motion that gains energy: it shows that no forces bring certain faces to yield together.

        min  Σ r    s.t.    Bᵀ d = C(μ)ᵀ (p − r),    f_L·d ≥ 0,    f_D·d − c·(p − r) = 1,    p ≥ 0,
        0 ≤ r ≤ most

    All forces with λ ≥ 0 have Σ z (p − r) = c·(p − r) − f_D·d − λ f_L·d ≤ −1, and so not z ≥ 0 with z = 0 on
    the faces with r > 0.

    Parameter of the program: ``most``, shape (faces,), 0 but on the faces that are held at yield.
    """

    def __init__(self, problem: Problem) -> None:
        model = self.program = pyo.ConcreteModel()
        faces = range(problem.faces)
        model.d = pyo.Var(range(problem.B.shape[0]))
        model.p = pyo.Var(faces, domain=pyo.NonNegativeReals)
        model.r = pyo.Var(faces, domain=pyo.NonNegativeReals)
        model.cost = pyo.Param(faces, mutable=True, initialize=1.0)
        model.most = pyo.Param(faces, mutable=True, initialize=inf)
        d = list(model.d.values())
        rates = [*model.p.values(), *model.r.values()]
        flow = problem.D(problem.friction)
        motion, follows = list(rows(problem.B.T.tocsr(), d)), list(rows(flow, rates[: problem.faces]))
        held = list(rows(flow, rates[problem.faces :]))
        model.compatibility = pyo.Constraint(
            range(problem.B.shape[1]), rule=lambda _, row: motion[row] - follows[row] + held[row] == 0
        )
        model.live_work = pyo.Constraint(expr=dot(problem.live, d) >= 0)
        cohesion = problem.face_cohesion
        everything = np.concatenate([problem.dead, -cohesion, cohesion])
        model.gain = pyo.Constraint(expr=dot(everything, [*d, *rates]) == 1)
        model.objective = pyo.Objective(expr=pyo.sum_product(model.cost, model.r))

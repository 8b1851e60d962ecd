"""The two linear programs of exact refinement, in Pyomo, with everything that changes as parameters."""

from __future__ import annotations

from math import inf

import pyomo.environ as pyo

from masonry_opt.models.pyomo_arrays import dot
from masonry_opt.models.pyomo_terms import Mechanism, Statics
from masonry_opt.problem.problem import Problem, ShearLimits


class PyomoForces:
    """Forces on a mechanism: least cost with z = 0 where there is no room.

        min  a λ + b·q    s.t.    B q + λ f_L + f_D = 0,    0 ≤ z = C(μ) q + c ≤ room,    λ within an interval

    Parameters of the program: ``load_cost`` a, ``force_cost`` b, shape (3c,), and ``room``, shape (faces,), 0
    on the faces that are held at yield and infinite elsewhere.
    """

    def __init__(self, problem: Problem, within: tuple[float, float] = (-inf, inf)) -> None:
        model = self.program = pyo.ConcreteModel()
        self.statics = Statics(model, problem, ShearLimits.true(problem))
        model.load_factor.bounds = within
        model.load_cost = pyo.Param([0], mutable=True, initialize=0.0)
        model.force_cost = pyo.Param(range(3 * problem.joints), mutable=True, initialize=0.0)
        model.room = pyo.Param(range(problem.faces), mutable=True, initialize=inf)
        model.within_yield = pyo.Constraint(
            range(problem.faces), rule=lambda m, face: (-m.room[face], -self.statics.slacks[face], 0.0)
        )
        cost = model.load_cost[0] * model.load_factor + pyo.sum_product(model.force_cost, model.q)
        model.objective = pyo.Objective(expr=cost)


class PyomoMotion:
    """A mechanism for given forces: least cost over the faces that may move.

        min  cost·p    s.t.    Bᵀ d = D(tan φ₀) p,    f_L·d = Σ|f_L|,    0 ≤ p ≤ most,    −f_D·d ≤ raising

    Parameters of the program: ``cost``, shape (faces,), such as the slacks z of a state, and ``most``, shape
    (faces,), 0 on the faces that must not move.
    """

    def __init__(self, problem: Problem, raising: float = inf) -> None:
        model = self.program = pyo.ConcreteModel()
        faces = range(problem.faces)
        self.mechanism = Mechanism(model, problem, problem.dilatancy.tolist())
        model.cost = pyo.Param(faces, mutable=True, initialize=0.0)
        model.most = pyo.Param(faces, mutable=True, initialize=inf)
        for face in faces:
            model.p[face].setub(model.most[face])
        model.raised = pyo.Constraint(expr=dot(-problem.dead, list(model.d.values())) <= raising)
        model.objective = pyo.Objective(expr=pyo.sum_product(model.cost, model.p))

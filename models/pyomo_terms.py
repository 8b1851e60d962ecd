"""Terms that the Pyomo formulations share: shear limits as mutable parameters, and compatibility."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pyomo.environ as pyo
import scipy.sparse as sp
from pyomo.core.expr import LinearExpression

from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import expect_same_terms

#: The two senses of sliding and of rocking.
SENSES = ("+", "-")


class ShearLimited:
    """A model whose shear limits are mutable: a slope, and a cohesion where one is declared."""

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        self.problem = problem
        self.program = pyo.ConcreteModel()
        self.program.joints = pyo.RangeSet(0, problem.joints - 1)
        self.program.sliding = pyo.Set(initialize=problem.sliding.tolist(), ordered=True)
        self.program.dual = pyo.Suffix(direction=pyo.Suffix.IMPORT)
        self.program.slope = pyo.Param(self.program.sliding, mutable=True, initialize=0.0)
        self._cohesive = limits.cohesion is not None
        if self._cohesive:
            self.program.cohesion = pyo.Param(self.program.sliding, mutable=True, initialize=0.0)
        self.set_shear_limits(limits)

    def set_shear_limits(self, limits: ShearLimits) -> None:
        """Change the shear limits, and nothing else.

        Raises ValueError if cohesion terms were declared and are not given, or the reverse.
        """
        expect_same_terms(self._cohesive, limits)
        model, joints = self.program, self.problem.sliding.tolist()
        model.slope.store_values(dict(zip(joints, limits.slope.tolist(), strict=True)))
        if limits.cohesion is not None:
            model.cohesion.store_values(dict(zip(joints, limits.cohesion.tolist(), strict=True)))

    def limit(self, i: int, n: Any) -> Any:
        """Shear limit of joint i under normal force n: cohesion + slope · n."""
        limit = self.program.slope[i] * n
        return self.program.cohesion[i] + limit if self._cohesive else limit


def add_forces(model: pyo.ConcreteModel, problem: Problem) -> None:
    """Declare ``load_factor``, joint forces ``n``, ``s``, ``m``, and equilibrium between them."""
    model.load_factor = pyo.Var()
    model.n, model.s, model.m = (pyo.Var(model.joints) for _ in range(3))
    q = [force for i in model.joints for force in (model.n[i], model.s[i], model.m[i])]
    internal = list(products(problem.B, q))
    live, dead = problem.live.tolist(), problem.dead.tolist()

    def balance(m: Any, row: int) -> Any:
        external = live[row] * m.load_factor if live[row] else 0.0
        return internal[row] + external == -dead[row]

    model.equilibrium = pyo.Constraint(range(3 * problem.blocks), rule=balance)


def add_mechanism(model: pyo.ConcreteModel, problem: Problem, slope: Callable[[int], Any]) -> None:
    """Declare velocities ``d``, rates ``slide`` and ``rock`` ≥ 0, and Bᵀ d = D p between them."""
    model.d = pyo.Var(range(3 * problem.blocks))
    model.slide = pyo.Var(SENSES, model.sliding, domain=pyo.NonNegativeReals)
    model.rock = pyo.Var(SENSES, model.joints, domain=pyo.NonNegativeReals)
    d = list(model.d.values())
    half = problem.half_length.tolist()
    opening, slip, rotation = (
        list(products(B.T.tocsr(), d)) for B in (problem.B_n, problem.B_s, problem.B_m)
    )

    def open_by(m: Any, i: int) -> Any:
        rocking = half[i] * (m.rock["+", i] + m.rock["-", i])
        if i not in m.sliding:
            return opening[i] == rocking
        return opening[i] == slope(i) * (m.slide["+", i] + m.slide["-", i]) + rocking

    def slip_by(m: Any, i: int) -> Any:
        return slip[i] == (m.slide["-", i] - m.slide["+", i] if i in m.sliding else 0)

    def rotate_by(m: Any, i: int) -> Any:
        return rotation[i] == m.rock["-", i] - m.rock["+", i]

    model.opening = pyo.Constraint(model.joints, rule=open_by)
    model.slip = pyo.Constraint(model.joints, rule=slip_by)
    model.rotation = pyo.Constraint(model.joints, rule=rotate_by)


def products(matrix: sp.csr_array, variables: Sequence[Any]) -> Iterator[Any]:
    """Each row of ``matrix @ variables`` as a linear expression."""
    for row in range(matrix.shape[0]):
        span = slice(matrix.indptr[row], matrix.indptr[row + 1])
        yield LinearExpression(
            linear_coefs=matrix.data[span].tolist(),
            linear_vars=[variables[column] for column in matrix.indices[span]],
        )


def dot(coefficients: np.ndarray, variables: Sequence[Any]) -> Any:
    """``coefficients · variables`` as a linear expression, zeros left out."""
    return next(products(sp.csr_array(coefficients[None, :]), variables))


def values(variable: pyo.Var) -> np.ndarray:
    """The loaded values of an indexed variable, in order."""
    return np.array([data.value for data in variable.values()])


def duals(constraint: pyo.Constraint) -> np.ndarray:
    """The loaded duals of an indexed constraint, in order."""
    dual = constraint.model().dual
    return np.array([dual[data] for data in constraint.values()])


def put(variable: pyo.Var, numbers: np.ndarray) -> None:
    """Give an indexed variable these values, in order."""
    for data, number in zip(variable.values(), np.ravel(numbers).tolist(), strict=True):
        data.set_value(number, skip_validation=True)

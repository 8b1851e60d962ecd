"""Statics and mechanisms in Pyomo, eqs (1) to (6): the terms of every Pyomo model.

The module also converts between arrays and Pyomo's expressions and variables.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pyomo.environ as pyo
import scipy.sparse as sp
from pyomo.core.expr import LinearExpression

from masonry_opt.problem.problem import Problem, ShearLimits


def rows(matrix: sp.csr_array, variables: Sequence[Any], by_joint: int = 0) -> Iterator[Any]:
    """Return the rows of the product ``matrix @ variables``, as linear expressions.

    The terms of a row are in the order of the columns. If ``by_joint`` is the number of joints, the terms are
    sorted by joint instead, so that all forces of a joint are together. HiGHS orders its columns like the
    terms. This order determines the optimal vertex in which the simplex method ends.
    """
    for row in range(matrix.shape[0]):
        span = slice(matrix.indptr[row], matrix.indptr[row + 1])
        columns, entries = matrix.indices[span], matrix.data[span]
        if by_joint:
            order = np.lexsort((columns, columns % by_joint))
            columns, entries = columns[order], entries[order]
        terms = [variables[column] for column in columns]
        yield LinearExpression(linear_coefs=entries.tolist(), linear_vars=terms)


def dot(coefficients: np.ndarray, variables: Sequence[Any]) -> Any:
    """Return the scalar product ``coefficients · variables`` as a Pyomo expression without zero terms."""
    return next(rows(sp.csr_array(coefficients[None, :]), variables))


def values(variable: pyo.Var) -> np.ndarray:
    """Return the values of an indexed Pyomo variable as an array, in the order of its indices.

    A variable that occurs in no constraint has no value in Pyomo. Its value is 0 here, which has no effect.
    """
    return np.array([0.0 if data.value is None else data.value for data in variable.values()])


def duals(constraint: pyo.Constraint) -> np.ndarray:
    """Return the dual values of an indexed Pyomo constraint as an array, in the order of its indices."""
    dual = constraint.model().dual
    return np.array([dual[data] for data in constraint.values()])


def put(variable: pyo.Var, numbers: np.ndarray) -> None:
    """Set an indexed Pyomo variable to the values of an array, in the order of its indices."""
    for data, number in zip(variable.values(), numbers.tolist(), strict=True):
        data.set_value(number, skip_validation=True)


class PyomoShearParameters:
    """Slope and cohesion of the shear limits, as mutable Pyomo parameters.

    There is one value of each for the k joints that can slide.
    """

    def __init__(self, model: pyo.ConcreteModel, limits: ShearLimits) -> None:
        joints = range(len(limits.slope))
        self.slope = model.slope = pyo.Param(joints, mutable=True, initialize=0.0)
        self.cohesion = model.cohesion = pyo.Param(joints, mutable=True, initialize=0.0)
        self.set(limits)

    def set(self, limits: ShearLimits) -> None:
        """Set the values of the slope and cohesion parameters."""
        self.slope.store_values(dict(enumerate(limits.slope.tolist())))
        self.cohesion.store_values(dict(enumerate(limits.cohesion.tolist())))


class PyomoStatics:
    """Pyomo variables for the load factor λ and the joint forces q, and the equilibrium constraint, eq. (1).

        B q + λ f_L + f_D = 0,    z = C(slope) q + c

    Shear limits are parameters or numbers. ``slacks`` contains the slack z of each face, eq. (4), as an
    expression.
    """

    def __init__(
        self, model: pyo.ConcreteModel, problem: Problem, limits: PyomoShearParameters | ShearLimits
    ) -> None:
        self.load_factor: Any = pyo.Var()
        model.load_factor = self.load_factor
        self.q = model.q = pyo.Var(range(problem.B.shape[1]))
        q = list(self.q.values())
        slope = limits.slope
        cohesion = limits.cohesion
        internal = list(rows(problem.B, q, by_joint=problem.joints))
        live, dead = problem.live.tolist(), problem.dead.tolist()

        def balance(_: Any, row: int) -> Any:
            external = live[row] * self.load_factor if live[row] else 0.0
            return internal[row] + external == -dead[row]

        self.equilibrium = model.equilibrium = pyo.Constraint(range(problem.B.shape[0]), rule=balance)
        limit = [cohesion[i] + slope[i] * n for i, n in enumerate(rows(problem.N, q))]
        constant: list[Any] = problem.face_constant.tolist()
        factors = problem.limit_factors.tocoo()
        for face, joint, factor in zip(factors.row, factors.col, factors.data.tolist(), strict=True):
            constant[face] = factor * limit[joint]
        without_friction = rows(problem.C(np.zeros(len(limit))), q)
        self.slacks: list[Any] = [z + c for z, c in zip(without_friction, constant, strict=True)]

    def forces(self) -> tuple[float, np.ndarray]:
        """Return the current values of the load factor λ and of the vector of joint forces q."""
        return float(self.load_factor.value), values(self.q)


class PyomoMechanism:
    """Pyomo variables for the block velocities d and the rates p ≥ 0 of the yield conditions.

    The constraints are compatibility, eqs (2), (5) and (6), and the normalised work of the live load.

        Bᵀ d = D(slope) p,    f_L·d = Σ|f_L|

    The slope is the opening per unit slip, as parameters or as numbers.
    """

    def __init__(self, model: pyo.ConcreteModel, problem: Problem, slope: Any) -> None:
        self.d = model.d = pyo.Var(range(problem.B.shape[0]))
        self.p = model.p = pyo.Var(range(problem.faces), domain=pyo.NonNegativeReals)
        d, p = list(self.d.values()), list(self.p.values())
        motion = list(rows(problem.B.T.tocsr(), d))
        without_dilatancy = list(rows(problem.D(np.zeros_like(problem.friction)), p))
        #: One expression for the slip of each joint that can slide: the sum of its rates in all directions of
        #: slip.
        self.slip = list(rows(problem.limit_factors.T.tocsr(), p))
        #: Expression for the power that limited forces (such as tie forces) dissipate at their limits, plus
        #: the power that crushing dissipates, summed over the chords of the crushing curve.
        self.resisted = dot(problem.face_constant, p) if problem.face_constant.any() else 0.0
        dilates: dict[int, Any] = {
            row: slope[i] * self.slip[i]
            for i, joint in enumerate(problem.sliding.tolist())
            for row in range(joint, problem.layout.points * problem.joints, problem.joints)
        }

        def follows(_: Any, row: int) -> Any:
            return motion[row] == dilates.get(row, 0.0) + without_dilatancy[row]

        self.compatibility = model.compatibility = pyo.Constraint(range(problem.B.shape[1]), rule=follows)
        self.live_work = model.live_work = pyo.Constraint(expr=dot(problem.live, d) == problem.live_norm)

"""A declared Pyomo program in a HiGHS that stays loaded while its parameters change."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from typing import Any

import highspy
import numpy as np
import pyomo.environ as pyo

from masonry_opt.effort import Effort
from masonry_opt.solvers.highs_lp import LinearProgram
from masonry_opt.solvers.lp import Verdict
from masonry_opt.solvers.registry import find_solver

#: Pairs of what a parameter stands at, variable or rows, and the parameter.
Links = Sequence[tuple[Any, pyo.Param]]

#: HiGHS's feasibility tolerances.
_FEASIBILITY = 1e-10

_STATUS = highspy.HighsModelStatus
_VERDICTS = {
    _STATUS.kOptimal: Verdict.OPTIMAL,
    _STATUS.kInfeasible: Verdict.INFEASIBLE,
    _STATUS.kUnbounded: Verdict.UNBOUNDED,
    _STATUS.kUnboundedOrInfeasible: Verdict.INFEASIBLE_OR_UNBOUNDED,
}


class HighsSession:
    """Simplex with warm starts: after a change of parameters the last basis is where it begins.

    Pyomo's own persistent interface looks at every parameter in Python before every solve, which would take
    longer than the solves. Here it is said once which parameter stands where.

    Parameters
    ----------
    costs: by variable, the parameter that is its cost.
    most: by variable, the parameter that is its upper bound.
    room: by rows ``body ≤ u``, the parameter r of ``u − r ≤ body ≤ u``.
    purpose: what it is solved for, under which the effort records the solver.
    lp: the program as arrays, where it was compiled before.

    Attributes
    ----------
    lp: the program as it was loaded.
    """

    def __init__(
        self,
        program: pyo.ConcreteModel,
        effort: Effort,
        purpose: str,
        costs: Links,
        most: Links = (),
        room: Links = (),
        lp: LinearProgram | None = None,
    ) -> None:
        self.effort = effort
        simplex = find_solver("pyomo", "highs", _FEASIBILITY)
        effort.uses(simplex.name, purpose)
        self.lp = lp = lp or LinearProgram.of(program)
        self._columns: dict[int, np.ndarray] = {}
        self.size = lp.size
        self._highs = highspy.Highs()
        self._highs.silent()
        for name, value in simplex.options.items():
            self._highs.setOptionValue(name, value)
        self._highs.passModel(lp.highs(np.zeros(len(lp.cost))))
        self._lower, self._upper = lp.low, lp.row_upper
        self._set: dict[int, Callable[[np.ndarray], None]] = {}
        for variable, parameter in costs:
            self._set[id(parameter)] = partial(self._set_costs, self.columns(variable))
        for variable, parameter in most:
            self._set[id(parameter)] = partial(self._set_most, self.columns(variable))
        self._rooms = {}
        for constraint, parameter in room:
            rows = np.array([lp.row[id(data)] for data in constraint.values()], dtype=np.int32)
            self._set[id(parameter)] = partial(self._set_room, rows)
            self._rooms[id(constraint)] = rows

    def set(self, parameter: pyo.Param, values: np.ndarray) -> None:
        """Give a parameter of the program other values, in order; they reach HiGHS alone."""
        self._set[id(parameter)](np.asarray(values, dtype=float))

    def _set_costs(self, columns: np.ndarray, costs: np.ndarray) -> None:
        self._highs.changeColsCost(len(columns), columns, costs)

    def _set_most(self, columns: np.ndarray, most: np.ndarray) -> None:
        self._highs.changeColsBounds(len(columns), columns, self._lower[columns], most)

    def _set_room(self, rows: np.ndarray, room: np.ndarray) -> None:
        upper = self._upper[rows]
        self._highs.changeRowsBounds(len(rows), rows, upper - room, upper)

    def columns(self, variable: pyo.Var) -> np.ndarray:
        """Columns of a variable, in order."""
        if id(variable) not in self._columns:
            found = [self.lp.column[id(data)] for data in variable.values()]
            self._columns[id(variable)] = np.array(found, dtype=np.int32)
        return self._columns[id(variable)]

    def solve(self, seconds: float = inf) -> Verdict:
        """Solve with the present parameters, within so many seconds."""
        ends = time.perf_counter() + seconds
        verdict = self._run(seconds)
        left = ends - time.perf_counter()
        if verdict is Verdict.FAILED and left > 0:
            # A warm start may leave HiGHS undecided: once more, from the beginning.
            self._highs.clearSolver()
            verdict = self._run(left)
        self.effort.lp_solves += 1
        return verdict

    def _run(self, seconds: float) -> Verdict:
        self._highs.setOptionValue("time_limit", seconds)
        start = self._highs.getRunTime()
        self._highs.run()
        self.effort.add("solve", self._highs.getRunTime() - start)
        self.effort.iterations += max(self._highs.getInfo().simplex_iteration_count, 0)
        return _VERDICTS.get(self._highs.getModelStatus(), Verdict.FAILED)

    def values(self, variable: pyo.Var) -> np.ndarray:
        """Values of a variable at the last optimum."""
        return np.array(self._highs.getSolution().col_value)[self.columns(variable)]

    def duals(self, constraint: pyo.Constraint) -> np.ndarray:
        """Duals of rows with room at the last optimum: change of the optimum per unit of bound."""
        return np.array(self._highs.getSolution().row_dual)[self._rooms[id(constraint)]]

    def least(self) -> tuple[float, np.ndarray]:
        """What the multipliers of the last optimum prove of its costs, see :meth:`LinearProgram.least`."""
        return self._as_it_stands().least(np.array(self._highs.getSolution().row_dual))

    def contradiction(self) -> tuple[float, np.ndarray]:
        """What the dual ray of the last program, an infeasible one, proves: ``short·|x| ≥ value`` for every x
        that meets its rows and bounds, ``short`` being rounding; the value is 0 if there is no ray."""
        nothing = np.zeros(len(self.lp.cost))
        _, found, ray = self._highs.getDualRay()
        return replace(self._as_it_stands(), cost=nothing).least(np.array(ray)) if found else (0.0, nothing)

    def _as_it_stands(self) -> LinearProgram:
        """The program with the costs and bounds that it has in HiGHS now."""
        lp = self._highs.getLp()
        return replace(
            self.lp,
            cost=np.array(lp.col_cost_),
            row_lower=np.array(lp.row_lower_),
            row_upper=np.array(lp.row_upper_),
            low=np.array(lp.col_lower_),
            high=np.array(lp.col_upper_),
        )

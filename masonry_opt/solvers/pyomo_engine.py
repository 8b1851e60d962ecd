"""Solve programs that are declared in Pyomo, through its persistent interface to HiGHS."""

import math
import time

import pyomo.environ as pyo
from pyomo.contrib.solver.common.results import TerminationCondition
from pyomo.contrib.solver.solvers.highs import Highs

from masonry_opt.deadline import SAME_TIME, check_time, seconds_left
from masonry_opt.effort import Effort
from masonry_opt.solvers.registry import LpSize, Solved, Solver, Verdict, iterations_of

_PYOMO_VERDICTS = {
    TerminationCondition.convergenceCriteriaSatisfied: Verdict.OPTIMAL,
    TerminationCondition.provenInfeasible: Verdict.INFEASIBLE,
    TerminationCondition.unbounded: Verdict.UNBOUNDED,
    TerminationCondition.infeasibleOrUnbounded: Verdict.INFEASIBLE_OR_UNBOUNDED,
}


class PyomoEngine:
    """Program that is declared in Pyomo, and stays loaded in HiGHS between solves.

    See :class:`~.cvxpy_engine.CvxpyEngine` for the arguments. The argument ``repeats`` has no effect.
    """

    def __init__(
        self, program: pyo.ConcreteModel, solver: Solver, effort: Effort, purpose: str, repeats: bool = False
    ) -> None:
        self.program, self.solver, self.effort = program, solver, effort
        effort.uses(solver.name, purpose)
        self._purpose = purpose
        with effort.measure("compile"):
            self._highs = Highs()
            config = self._highs.config
            config.load_solutions = config.raise_exception_on_nonoptimal_result = False
            config.solver_options = solver.options
            # Only parameters change between solves, so Pyomo does not have to check the rest of the program
            # for changes.
            updates = config.auto_updates
            for name in updates:
                updates[name] = name == "update_parameters"
            self._highs.set_instance(program)

    def restart(self, effort: Effort) -> None:
        """Prepare for solves of another problem, and record their time and iterations in ``effort``.

        The basis of earlier solves is discarded.
        """
        self.effort = effort
        effort.uses(self.solver.name, self._purpose)
        highs = self._highs._solver_model
        # HiGHS would reuse the basis and the matrix scaling of an earlier solve. If the model is passed
        # again, HiGHS discards both.
        highs.passModel(highs.getLp())

    @property
    def size(self) -> LpSize:
        """Return the numbers of rows, columns and nonzeros of the program in HiGHS."""
        lp = self._highs._solver_model.getLp()
        return LpSize(lp.num_row_, lp.num_col_, len(lp.a_matrix_.value_))

    def solve(self) -> Solved:
        """Solve the program with the current parameters, from the basis of the previous solve, if any.

        Raises TimeLimitReached if the time limit of the analysis has passed.
        """
        check_time()
        effort = self.effort
        effort.lp_solves += 1
        highs = self._highs._solver_model
        start = time.perf_counter()
        before = highs.getRunTime()
        # The time limit of HiGHS applies to the total time of all runs, so the time of earlier runs is added.
        self._highs.config.time_limit = before + seconds_left() if math.isfinite(seconds_left()) else None
        result = self._highs.solve(self.program)
        seconds = highs.getRunTime() - before
        effort.add("solve", seconds)
        # The time outside the solver, in which changed parameters are passed to HiGHS, counts as compilation.
        effort.add("compile", max(time.perf_counter() - start - seconds, 0.0))
        effort.iterations += iterations_of(highs.getInfo())
        condition = result.termination_condition
        verdict = _PYOMO_VERDICTS.get(condition, Verdict.FAILED)
        if verdict is Verdict.FAILED:
            check_time(SAME_TIME)
        if verdict is Verdict.OPTIMAL:
            with effort.measure("read"):
                result.solution_loader.load_vars()
                self.program.dual.update(result.solution_loader.get_duals())
        return Solved(verdict, condition.name, seconds)

"""Drives models declared in Pyomo, through its persistent interface to HiGHS."""

from __future__ import annotations

import time

from pyomo.contrib.solver.common.results import TerminationCondition
from pyomo.contrib.solver.solvers.highs import Highs

from masonry_opt.effort import Stopwatch
from masonry_opt.models.pyomo_kinematic import PyomoKinematic
from masonry_opt.models.pyomo_static import PyomoStatic
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.lp import Answer, LpSize, Outcome, outcome_of
from masonry_opt.solvers.registry import Solver

_MODELS: dict[str, type[PyomoStatic] | type[PyomoKinematic]] = {
    "static": PyomoStatic,
    "kinematic": PyomoKinematic,
}

_NEITHER = TerminationCondition.infeasibleOrUnbounded
_INFEASIBLE = (TerminationCondition.provenInfeasible, _NEITHER)
_UNBOUNDED = (TerminationCondition.unbounded, _NEITHER)


class PyomoDriver:
    """A declared Pyomo model, and a HiGHS that stays loaded with it between solves."""

    def __init__(
        self,
        problem: Problem,
        formulation: str,
        limits: ShearLimits,
        solver: Solver,
        watch: Stopwatch,
    ) -> None:
        self.formulation, self.solver, self.watch = formulation, solver, watch
        self.solves = 0
        self._run_time = 0.0
        with watch.measure("build"):
            self.model = _MODELS[formulation](problem, limits)
        with watch.measure("compile"):
            self._highs = Highs()
            self._highs.config.load_solutions = False
            self._highs.config.raise_exception_on_nonoptimal_result = False
            self._highs.config.solver_options = solver.options
            # Between solves nothing changes but parameters: look for nothing else.
            updates = self._highs.config.auto_updates
            for name in updates:
                updates[name] = name == "update_parameters"
            self._highs.set_instance(self.model.program)

    def set_shear_limits(self, limits: ShearLimits) -> None:
        """Change the model's shear limits, and nothing else."""
        with self.watch.measure("compile"):
            self.model.set_shear_limits(limits)

    def size(self) -> LpSize:
        """Rows, columns and non-zeros as HiGHS holds them."""
        lp = self._highs._solver_model.getLp()
        return LpSize(lp.num_row_, lp.num_col_, len(lp.a_matrix_.value_))

    def solve(self) -> Answer:
        """Solve with the present shear limits, from the last basis where there is one."""
        self.solves += 1
        start = time.perf_counter()
        result = self._highs.solve(self.model.program)
        elapsed = time.perf_counter() - start
        # HiGHS's clock runs on from solve to solve.
        run_time = float(result.timing_info.highs_time)
        seconds, self._run_time = run_time - self._run_time, run_time
        self.watch.add("solve", seconds)
        self.watch.add("compile", max(elapsed - seconds, 0.0))  # changed parameters, handed over
        condition = result.termination_condition
        counts = result.extra_info.value()
        iterations = max(0, *(int(counts.get(f"{kind}_iteration_count") or 0) for kind in ("simplex", "ipm")))
        if condition == TerminationCondition.convergenceCriteriaSatisfied:
            with self.watch.measure("read"):
                result.solution_loader.load_vars()
                self.model.program.dual.update(result.solution_loader.get_duals())
                state = self.model.read()
            return Answer(Outcome.OPTIMAL, condition.name, state, iterations, seconds)
        outcome = outcome_of(
            self.formulation,
            infeasible=condition in _INFEASIBLE,
            unbounded=condition in _UNBOUNDED,
        )
        return Answer(outcome, condition.name, None, iterations, seconds)

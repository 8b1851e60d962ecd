"""IPOPT for models declared in Pyomo: the library in CasADi's wheel, or an executable."""

import re
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyomo.environ as pyo
from pyomo.common.errors import ApplicationError
from pyomo.repn.plugins.nl_writer import NLWriter

from masonry_opt.models.pyomo_mpec import PyomoRelaxed

#: Options for a series of solves that each begin near the last one's end.
_OPTIONS: dict[str, Any] = {
    "tol": 1e-9,
    "constr_viol_tol": 1e-9,
    "acceptable_tol": 1e-9,
    "mu_strategy": "monotone",
    "mu_init": 1e-2,
    "warm_start_init_point": "yes",
    "warm_start_bound_push": 1e-6,
    "warm_start_mult_bound_push": 1e-6,
    "warm_start_slack_bound_push": 1e-6,
    # Rates and slacks stay ≥ 0: a product of two small negatives would pass for complementary.
    "bound_relax_factor": 0.0,
    "max_iter": 700,
}


@dataclass(frozen=True)
class NlpAnswer:
    """One solve: IPOPT's status, whether it found a local optimum, and its iterations."""

    status: str
    solved: bool
    iterations: int


class CasadiIpopt:
    """IPOPT through CasADi, which reads the program once from Pyomo's ``.nl``. The values of the program's
    variables are the start of a solve, and afterwards its end."""

    def __init__(self, model: PyomoRelaxed) -> None:
        import casadi

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "program.nl"
            with path.open("w") as stream:
                written = NLWriter().write(model.program, stream, linear_presolve=False, scale_model=False)
            problem = casadi.NlpBuilder()
            problem.import_nl(str(path))
        self._variables = written.variables
        row_of = {id(row): index for index, row in enumerate(written.constraints)}
        self._products = [row_of[id(row)] for row in model.complementarity_rows]
        self._bounds = {
            "lbx": np.array(problem.x_lb),
            "ubx": np.array(problem.x_ub),
            "lbg": np.array(problem.g_lb),
            "ubg": np.array(problem.g_ub),
        }
        functions = {"x": casadi.vertcat(*problem.x), "f": problem.f, "g": casadi.vertcat(*problem.g)}
        # Expanded to scalar operations the derivatives take a thirtieth of the time.
        quiet = {"expand": True, "print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"}
        options = {f"ipopt.{name}": value for name, value in _OPTIONS.items()} | quiet
        self._solver = casadi.nlpsol("program", "ipopt", functions, options)
        self._multipliers: dict[str, Any] = {}

    def solve(self, epsilon: float) -> NlpAnswer:
        """Solve with z p ≤ ``epsilon``, from the variables' values and the last solve's multipliers."""
        self._bounds["ubg"][self._products] = epsilon
        start = np.array([variable.value for variable in self._variables])
        found = self._solver(x0=start, **self._bounds, **self._multipliers)
        stats = self._solver.stats()
        solved = stats["return_status"] in ("Solve_Succeeded", "Solved_To_Acceptable_Level")
        if solved:
            self._multipliers = {"lam_x0": found["lam_x"], "lam_g0": found["lam_g"]}
            end = np.array(found["x"]).ravel().tolist()
            for variable, value in zip(self._variables, end, strict=True):
                variable.set_value(value, skip_validation=True)
        return NlpAnswer(stats["return_status"], solved, int(stats["iter_count"]))

    def forget(self) -> None:
        """Begin the next solve without multipliers."""
        self._multipliers = {}


class ExecutableIpopt:
    """The same by an ``ipopt`` executable on the PATH, through Pyomo."""

    def __init__(self, model: PyomoRelaxed) -> None:
        self._solver = pyo.SolverFactory("ipopt", executable=shutil.which("ipopt"))
        self._solver.options.update(_OPTIONS)
        self._epsilon = model.epsilon
        program = self._program = model.program
        # The multipliers that one solve leaves and the next begins with.
        for bound in ("zL", "zU"):
            program.add_component(f"ipopt_{bound}_out", pyo.Suffix(direction=pyo.Suffix.IMPORT))
            program.add_component(f"ipopt_{bound}_in", pyo.Suffix(direction=pyo.Suffix.EXPORT))
        program.dual = pyo.Suffix(direction=pyo.Suffix.IMPORT_EXPORT)

    def solve(self, epsilon: float) -> NlpAnswer:
        """See :meth:`CasadiIpopt.solve`."""
        program = self._program
        self._epsilon.set_value(epsilon)
        program.ipopt_zL_in.update(program.ipopt_zL_out)
        program.ipopt_zU_in.update(program.ipopt_zU_out)
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "ipopt.log"
            try:
                result = self._solver.solve(program, load_solutions=False, logfile=str(log))
            except (ApplicationError, ValueError, OSError) as error:
                return NlpAnswer(f"{type(error).__name__}: {error}", False, 0)
            counted = re.search(r"Number of Iterations\.*: *(\d+)", log.read_text(errors="replace"))
        status = str(result.solver.termination_condition)
        solved = status == "optimal"
        if solved:
            program.solutions.load_from(result)
        return NlpAnswer(status, solved, int(counted[1]) if counted else 0)

    def forget(self) -> None:
        """Begin the next solve without multipliers."""
        for suffix in ("ipopt_zL_out", "ipopt_zU_out", "ipopt_zL_in", "ipopt_zU_in", "dual"):
            getattr(self._program, suffix).clear()

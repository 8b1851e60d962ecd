"""IPOPT, the library in CasADi's wheel, for models declared in Pyomo."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
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
        bounds = {"lbx": problem.x_lb, "ubx": problem.x_ub, "lbg": problem.g_lb, "ubg": problem.g_ub}
        self._bounds = {name: np.array(of) for name, of in bounds.items()}
        functions = {"x": casadi.vertcat(*problem.x), "f": problem.f, "g": casadi.vertcat(*problem.g)}
        # Expanded to scalar operations the derivatives take a thirtieth of the time.
        quiet = {"expand": True, "print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"}
        options = {f"ipopt.{name}": value for name, value in _OPTIONS.items()} | quiet
        self._solver = casadi.nlpsol("program", "ipopt", functions, options)
        self.multipliers: dict[str, Any] = {}  #: of the last solve, with which the next begins

    def solve(self, epsilon: float) -> tuple[bool, str, int]:
        """Solve with z p ≤ ``epsilon``, from the variables' values and the last solve's multipliers: whether
        IPOPT found a local optimum, its status and its iterations."""
        self._bounds["ubg"][self._products] = epsilon
        start = np.array([variable.value for variable in self._variables])
        found = self._solver(x0=start, **self._bounds, **self.multipliers)
        stats = self._solver.stats()
        solved = stats["return_status"] in ("Solve_Succeeded", "Solved_To_Acceptable_Level")
        if solved:
            self.multipliers = {"lam_x0": found["lam_x"], "lam_g0": found["lam_g"]}
            end = np.array(found["x"]).ravel().tolist()
            for variable, value in zip(self._variables, end, strict=True):
                variable.set_value(value, skip_validation=True)
        return solved, stats["return_status"], int(stats["iter_count"])

"""Method "mpec": solve the MPEC by relaxation of complementarity (Table 1, [24]).

The method gives reference values for the loop. It follows Scholtes' scheme: z p ≤ ε is required for a
falling ε, and each solve starts from the last solution. The result is a local optimum of a non-convex
problem, and depends on the start.
"""

import math
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, InstanceOf, Strict, model_validator
from pyomo.repn.plugins.nl_writer import NLWriter

from masonry_opt.deadline import SAME_TIME, check_time, seconds_left
from masonry_opt.methods.loop.nonassociative import nonassociative
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.task import Options, Task, of_same_scene
from masonry_opt.models.pyomo_mpec import PyomoMpec, PyomoRelaxed
from masonry_opt.problem.problem import State, in_units_of_live_load
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import FinalState, certified
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.registry import find_solver

#: Ratio of ε in a relaxation to ε in the previous relaxation. With a larger ratio a series needs more solves.
_EPSILON_RATIO = 0.1

#: If a series of relaxations fails, the next series begins with this fraction of the first ε of the failed
#: series.
_SMALLER_START = 1e-3

#: Smallest ε with which a series of relaxations may begin. If a series fails and the next series would have
#: to begin with a smaller ε, the method ends without an answer.
_SMALLEST_START = 1e-8

#: Options of IPOPT. Each solve starts from the solution of the previous solve, and the warm-start options
#: keep it close to this solution.
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
    # IPOPT must not relax the bounds z ≥ 0 and p ≥ 0. Otherwise the product z p of two small negative numbers
    # would be admissible.
    "bound_relax_factor": 0.0,
    "max_iter": 700,
}


class MpecOptions(Options):
    """Options of the relaxation.

    Attributes
    ----------
    start: "loop" (the answer of the loop), "cold" (no forces and no motion), or a result of the same scene.
    epsilon: first bound ε of each product z p, relative to the median dead load of a block times the live
        load's mean velocity.
    epsilon_min: last bound ε, in the unit of ``epsilon``.
    """

    start: Literal["loop", "cold"] | InstanceOf[Solution] = "loop"
    epsilon: Annotated[float, Strict(), Field(gt=0, le=10)] = 0.03
    epsilon_min: Annotated[float, Strict(), Field(gt=0, le=10)] = 3e-9

    @model_validator(mode="after")
    def _falling(self) -> "MpecOptions":
        """Raise ValueError if ``epsilon`` is smaller than ``epsilon_min``."""
        if self.epsilon < self.epsilon_min:
            raise ValueError("'epsilon' must be at least 'epsilon_min'")
        return self


@dataclass(frozen=True)
class RelaxationStep:
    """Record of one solve in a series of relaxations z p ≤ ε with decreasing ε."""

    epsilon: float  #: bound ε of the product z p of each yield condition (slack times rate)
    load_factor: float  #: load factor λ; NaN if the solve failed
    word: str  #: IPOPT's status
    iterations: int  #: number of IPOPT's iterations
    largest_product: float  #: largest product z p; NaN if the solve failed
    #: Complementarity gap: the sum of all products z p, relative to the work of the live load at λ = 1. The
    #: gap is NaN if the solve failed.
    gap: float
    seconds: float  #: time of the solve


class CasadiIpopt:
    """Interface to IPOPT through CasADi. CasADi reads the Pyomo program once, from an ``.nl`` file.

    A solve starts from the present values of the program's variables, and stores its solution in them.
    """

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
        self._bounds = {name: np.array(bound) for name, bound in bounds.items()}
        self._functions: dict[str, Any] = {
            "x": casadi.vertcat(*problem.x),
            "f": problem.f,
            "g": casadi.vertcat(*problem.g),
        }
        self._solver = self._compiled()
        #: Multipliers of the previous solve, from which the next solve starts.
        self.multipliers: dict[str, Any] = {}

    def _compiled(self) -> Any:
        """Compile the program for IPOPT, and return a solver that stops at the time limit of the analysis."""
        import casadi

        # Option "expand": functions are expanded to scalar operations, so that derivatives are thirty times
        # as fast.
        options: dict[str, Any] = {
            "expand": True,
            "print_time": False,
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
        }
        options |= {f"ipopt.{name}": value for name, value in _OPTIONS.items()}
        remaining_time = seconds_left()
        if math.isfinite(remaining_time):
            options["ipopt.max_wall_time"] = max(remaining_time, SAME_TIME)  # IPOPT refuses zero
        return casadi.nlpsol("program", "ipopt", self._functions, options)

    def solve(self, epsilon: float) -> tuple[bool, str, int]:
        """Solve the program with z p ≤ ``epsilon``, from the present values of the variables.

        Returns three values: True if IPOPT found a local optimum, IPOPT's status, and its number of
        iterations. Raises TimeLimitReached if the time limit of the analysis is over.
        """
        check_time()
        if math.isfinite(seconds_left()):
            # The time limit of an IPOPT solver cannot be changed, so create a new solver with the remaining
            # time.
            self._solver = self._compiled()
        self._bounds["ubg"][self._products] = epsilon
        start = np.array([variable.value for variable in self._variables])
        solution = self._solver(x0=start, **self._bounds, **self.multipliers)
        stats = self._solver.stats()
        solved = stats["return_status"] in ("Solve_Succeeded", "Solved_To_Acceptable_Level")
        if solved:
            self.multipliers = {"lam_x0": solution["lam_x"], "lam_g0": solution["lam_g"]}
            values = np.array(solution["x"]).ravel().tolist()
            for variable, value in zip(self._variables, values, strict=True):
                variable.set_value(value, skip_validation=True)
        else:
            check_time(SAME_TIME)
        return solved, stats["return_status"], int(stats["iter_count"])


def mpec(task: Task) -> Solution:
    """Return a local optimum of the MPEC, computed by Scholtes' relaxation.

    Option ``start`` determines the start. Raises OptionError if the start is a result of another scene, or
    has no forces.
    """
    problem, options = task.problem, task.options
    if options.start == "cold":
        return _relaxed(task, None)
    if isinstance(options.start, Solution):
        start = of_same_scene(options.start, problem)
    else:
        # Solve the sub-problems of the loop accurately, because the relaxation needs a start that shows which
        # faces have nonzero rates.
        accurate = LoopOptions(sub_problems="accurate")
        start = nonassociative(task.with_options(accurate, find_solver("cvxpy", None)))
    if start.q is None or start.d is None:
        return start.telling_first(reason(Code.START_FAILED))
    p = problem.rates(start.d, problem.dilatancy)
    solution = _relaxed(task, State(start.load_factor or 0.0, start.q, start.d, p))
    return replace(solution, flow_rule_matters=start.flow_rule_matters)


def _relaxed(task: Task, start: State | None) -> Solution:
    """Solve by series of relaxations with decreasing ε; return the solution of the first successful series.

    A series is successful if it reaches the smallest ε. Each series begins at the state ``start``, or at rest
    if ``start`` is None. If a series from a state fails, the next series begins with a smaller ε. If all
    series fail, the solution has no load factor.
    """
    problem, effort, smallest = task.problem, task.effort, task.options.epsilon_min
    scaled = in_units_of_live_load(problem)
    with effort.measure("build"):
        model = PyomoRelaxed(PyomoMpec(scaled.problem))
        q, d, p = (np.zeros(size) for size in (*problem.B.shape[::-1], problem.faces))
        begin = start or State(0.0, q, d, p)
        begin = replace(begin, load_factor=begin.load_factor / scaled.load_factor)
    with effort.measure("compile"):
        ipopt = CasadiIpopt(model)
    effort.uses(task.solver.name, "relaxation")
    series = [task.options.epsilon]
    while start and series[-1] * _SMALLER_START >= max(smallest, _SMALLEST_START):
        # Try a smaller first ε only if a series fails. A series from a smaller ε fails less often, but is
        # more likely to end in a local minimum with a high λ.
        series.append(series[-1] * _SMALLER_START)
    history: list[RelaxationStep] = []
    last: State | None = None

    def followed(first: float) -> bool:
        """Follow a series of relaxations from ε = ``first``; return True if it reaches the smallest ε."""
        nonlocal last
        model.start_from(begin)
        ipopt.multipliers = {}
        for epsilon in _epsilons(first, smallest):
            effort.begins(f"relaxation, ε = {epsilon:.0e}")
            began = time.perf_counter()
            solved, word, iterations = ipopt.solve(epsilon)
            seconds = time.perf_counter() - began
            effort.add("solve", seconds)
            effort.iterations += iterations
            effort.nlp_solves += 1
            load_factor, largest, gap = math.nan, math.nan, math.nan
            if solved:
                last, products = scaled.state(model.read()), model.products()
                load_factor, largest = last.load_factor, float(products.max())
                gap = float(products.sum()) / problem.live_norm
            history.append(RelaxationStep(epsilon, load_factor, word, iterations, largest, gap, seconds))
            task.progress(history[-1])
            if not solved:
                return False
        return True

    converged = any(map(followed, series))
    ending = Solution(Status.HOMOTOPY, Kind.RELAXED, history=tuple(history), solver=task.solver)
    if converged and last is not None:
        ending = replace(ending, state=certified(problem, last.load_factor, last.q, last.d))
        return ending.ended(Status.CONVERGED, Code.LOCAL_MINIMUM, epsilon=smallest)
    failed = history[-1]
    ending = ending.ended(Status.HOMOTOPY, Code.RELAXATION_STOPPED, word=failed.word, epsilon=failed.epsilon)
    if last is not None:
        return replace(ending, state=FinalState(q=last.q, d=last.d, slope=problem.dilatancy))
    state = FinalState() if start is None else FinalState(q=start.q, d=start.d)
    return replace(ending, state=state).telling(reason(Code.NOTHING_SOLVED))


def _epsilons(epsilon: float, smallest: float) -> Iterator[float]:
    """Generate the bounds ε of the products z p in a series of relaxations, in descending order."""
    while epsilon > smallest:
        yield epsilon
        following = _EPSILON_RATIO * epsilon
        epsilon = following if following >= 2 * smallest else smallest
    yield smallest

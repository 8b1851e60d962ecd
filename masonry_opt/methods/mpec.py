"""The MPEC by relaxation of complementarity: reference values for the loop (Table 1, [24]).

Scholtes' scheme: solve with z p ≤ ε for a falling ε, each time from the last solution. It ends in a local
optimum of a non-convex problem, which depends on the start.
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

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Found, certified
from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.methods.loop.nonassociative import nonassociative
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.task import Options, Task, of_same_scene
from masonry_opt.models.pyomo_mpec import PyomoMpec, PyomoRelaxed
from masonry_opt.problem.problem import State, in_units_of_live_load
from masonry_opt.solvers.registry import find_solver

_FALL = 0.1  #: The relaxation falls by this factor between solves.

#: A series that fails begins again with this share of its first ε, down to a smallest.
_SMALLER_START, _SMALLEST_START = 1e-3, 1e-8

#: Options of IPOPT for a series of solves that each begin near the last one's end.
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


class MpecOptions(Options):
    """Parameters of the relaxation.

    Attributes
    ----------
    start: "loop" (the loop's answer), "cold" (no forces, no motion), or a result of the same scene.
    epsilon: first bound on each z p, in median block weights times the live load's mean velocity.
    epsilon_min: last bound.
    """

    start: Literal["loop", "cold"] | InstanceOf[Solution] = "loop"
    epsilon: Annotated[float, Strict(), Field(gt=0, le=10)] = 0.03
    epsilon_min: Annotated[float, Strict(), Field(gt=0, le=10)] = 3e-9

    @model_validator(mode="after")
    def _falling(self) -> "MpecOptions":
        if self.epsilon < self.epsilon_min:
            raise ValueError("'epsilon' must not be below 'epsilon_min'")
        return self


@dataclass(frozen=True)
class RelaxationStep:
    """One solve of the series."""

    epsilon: float  #: bound on each z p
    load_factor: float  #: λ, NaN if the solve failed
    word: str  #: IPOPT's own
    iterations: int  #: IPOPT's own
    largest_product: float  #: largest z p
    gap: float  #: Σ z p over the live load's work, in units of λ
    seconds: float


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
        """Solve with z p ≤ ``epsilon``: whether IPOPT found a local optimum, its status, its iterations."""
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


def mpec(task: Task) -> Solution:
    """Least load factor near a start."""
    problem, options = task.problem, task.options
    if options.start == "cold":
        return _relaxed(task, None)
    if isinstance(options.start, Solution):
        before = of_same_scene(options.start, problem)
    else:
        # Accurate at any size: what follows needs to know which faces move.
        accurate = LoopOptions(sub_problems="accurate")
        before = nonassociative(task.with_options(accurate, find_solver("cvxpy", None)))
    if before.q is None or before.d is None:
        return before.telling_first(reason(Code.START_FAILED))
    p = problem.rates(before.d, problem.dilatancy)
    solution = _relaxed(task, State(before.load_factor or 0.0, before.q, before.d, p))
    return replace(solution, flow_rule_matters=before.flow_rule_matters)


def _relaxed(task: Task, start: State | None) -> Solution:
    """The first series of solves for a falling ε, from a start or from rest, that comes to its end."""
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
        # A smaller ε is easier to follow, but leaves less room to find a lower λ.
        series.append(series[-1] * _SMALLER_START)
    history: list[RelaxationStep] = []
    last: State | None = None

    def followed(first: float) -> bool:
        """Whether the series from there comes to its end."""
        nonlocal last
        model.start_from(begin)
        ipopt.multipliers = {}
        for epsilon in _epsilons(first, smallest):
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
        ending = replace(ending, found=certified(problem, last.load_factor, last.q, last.d))
        return ending.ended(Status.CONVERGED, Code.LOCAL_MINIMUM, epsilon=smallest)
    failed = history[-1]
    ending = ending.ended(Status.HOMOTOPY, Code.RELAXATION_STOPPED, word=failed.word, epsilon=failed.epsilon)
    if last is not None:
        return replace(ending, found=Found(q=last.q, d=last.d, slope=problem.dilatancy))
    found = Found() if start is None else Found(q=start.q, d=start.d)
    return replace(ending, found=found).telling(reason(Code.NOTHING_SOLVED))


def _epsilons(epsilon: float, smallest: float) -> Iterator[float]:
    """ε of each solve of a series, down to the smallest."""
    while epsilon > smallest:
        yield epsilon
        following = _FALL * epsilon
        epsilon = following if following >= 2 * smallest else smallest
    yield smallest

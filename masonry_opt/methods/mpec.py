"""The MPEC by relaxation of complementarity: reference values for the loop (Table 1, [24]).

Scholtes' scheme: solve with z p ≤ ε for a falling ε, each time from the last solution. It ends in a local
optimum of a non-convex problem, which depends on the start.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, InstanceOf, Strict, model_validator

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Found, certified
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.methods.loop.nonassociative import nonassociative
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.task import Options, Task, of_same_scene
from masonry_opt.models.pyomo_mpec import PyomoMpec
from masonry_opt.models.pyomo_relaxed import PyomoRelaxed
from masonry_opt.problem.load_units import Scaled, in_units_of_live_load
from masonry_opt.problem.state import State
from masonry_opt.solvers import ipopt as drivers
from masonry_opt.solvers.ipopt import Ipopt
from masonry_opt.solvers.registry import find_solver

#: The relaxation falls by this factor between solves.
_FALL = 0.1

#: A series that fails begins again with this share of its first ε, down to a smallest.
_SMALLER_START, _SMALLEST_START = 1e-3, 1e-8


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
    def _falling(self) -> MpecOptions:
        if self.epsilon < self.epsilon_min:
            raise ValueError("'epsilon' must not be below 'epsilon_min'")
        return self


@dataclass(frozen=True)
class RelaxationStep:
    """One solve of the series.

    Attributes
    ----------
    epsilon: bound on each z p.
    load_factor: λ, NaN if the solve failed.
    word, iterations: IPOPT's own.
    largest_product: largest z p.
    gap: Σ z p over the live load's work, in units of λ.
    """

    epsilon: float
    load_factor: float
    word: str
    iterations: int
    largest_product: float
    gap: float
    seconds: float


def mpec(task: Task) -> Solution:
    """Least load factor near a start."""
    problem, options = task.problem, task.options
    if options.start == "cold":
        return _relaxed(task, options, None)
    if isinstance(options.start, Solution):
        before = of_same_scene(options.start, problem)
    else:
        # Accurate at any size: what follows needs to know which faces move.
        accurate = LoopOptions(sub_problems="accurate")
        before = nonassociative(task.with_options(accurate, find_solver("cvxpy", None)))
    if before.q is None or before.d is None:
        before.reasons.insert(0, reason(Code.START_FAILED))
        return before
    p = problem.rates(before.d, problem.dilatancy)
    solution = _relaxed(task, options, State(before.load_factor or 0.0, before.q, before.d, p))
    solution.flow_rule_matters = before.flow_rule_matters
    return solution


def _relaxed(task: Task, options: MpecOptions, start: State | None) -> Solution:
    problem, effort, scaled = task.problem, task.effort, in_units_of_live_load(task.problem)
    with effort.measure("build"):
        model = PyomoRelaxed(PyomoMpec(scaled.problem))
        q, d, p = (np.zeros(size) for size in (*problem.B.shape[::-1], problem.faces))
        if start is not None:
            start = replace(start, load_factor=start.load_factor / scaled.load_factor)
        model.start_from(start or State(0.0, q, d, p))
    with effort.measure("compile"):
        ipopt = getattr(drivers, task.solver.entry.engine)(model)
    effort.uses(task.solver.name, "relaxation")
    solution = Solution(Status.HOMOTOPY, Kind.RELAXED, solver=task.solver)
    epsilon = options.epsilon
    while not _follow(task, scaled, model, ipopt, epsilon, options.epsilon_min, solution):
        epsilon *= _SMALLER_START
        if start is None or epsilon < options.epsilon_min or epsilon < _SMALLEST_START:
            return _stopped(solution, start)
        # A smaller ε is easier to follow, but leaves less room to find a lower λ.
        model.start_from(start)
        ipopt.forget()
    solution.end(Status.CONVERGED, Code.LOCAL_MINIMUM, epsilon=options.epsilon_min)
    state = scaled.state(model.read())
    solution.found = certified(problem, state.load_factor, state.q, state.d)
    if epsilon < options.epsilon:
        solution.add(Code.RELAXED_FROM, epsilon=epsilon)
    return solution


def _follow(
    task: Task,
    scaled: Scaled,
    model: PyomoRelaxed,
    ipopt: Ipopt,
    epsilon: float,
    last: float,
    solution: Solution,
) -> bool:
    """Solve for a falling ε from the model's values, which are of the scaled problem; whether all were
    solved."""
    while True:
        began = time.perf_counter()
        answer = ipopt.solve(epsilon)
        seconds = time.perf_counter() - began
        task.effort.add("solve", seconds)
        task.effort.iterations += answer.iterations
        task.effort.nlp_solves += 1
        load_factor, largest, gap = math.nan, math.nan, math.nan
        if answer.solved:
            state, products = scaled.state(model.read()), model.products()
            solution.found = Found(q=state.q, d=state.d, slope=task.problem.dilatancy)
            load_factor, largest = state.load_factor, float(products.max())
            gap = float(products.sum()) / task.problem.live_norm
        solution.history.append(
            RelaxationStep(epsilon, load_factor, answer.status, answer.iterations, largest, gap, seconds)
        )
        task.progress(solution.history[-1])
        if not answer.solved or epsilon <= last:
            return answer.solved
        epsilon *= _FALL
        if epsilon < 2 * last:
            epsilon = last


def _stopped(solution: Solution, start: State | None) -> Solution:
    failed = solution.history[-1]
    solution.end(Status.HOMOTOPY, Code.RELAXATION_STOPPED, word=failed.word, epsilon=failed.epsilon)
    solved = [step for step in solution.history if not math.isnan(step.load_factor)]
    if solved:
        last = solved[-1]
        solution.add(Code.KEPT_RELAXATION, epsilon=last.epsilon, load_factor=last.load_factor, gap=last.gap)
    elif start is not None:
        solution.found = Found(q=start.q, d=start.d)
        solution.add(Code.KEPT_START)
    else:
        solution.add(Code.NOTHING_SOLVED)
    return solution

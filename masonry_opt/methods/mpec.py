"""The MPEC by relaxation of complementarity: reference values for the loop (Table 1, [24]).

Scholtes' scheme: solve with z p ≤ ε for a falling ε, each time from the last solution, until ε is
nothing. Local optima of a non-convex problem: where it starts decides where it ends.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, InstanceOf, Strict, model_validator

from masonry_opt.answer.result import Result
from masonry_opt.answer.solution import Finding
from masonry_opt.answer.status import Status
from masonry_opt.effort import Stopwatch
from masonry_opt.models.pyomo_mpec import PyomoMpec
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State
from masonry_opt.scene.blocks import Number, Record
from masonry_opt.solvers.ipopt import Ipopt

#: The relaxation falls by this factor between solves.
_FALL = 0.1

#: A series that cannot be followed begins again with this share of its first ε, down to a smallest.
_SMALLER_START, _SMALLEST_START = 1e-3, 1e-8


class MpecOptions(Record):
    """Parameters of the relaxation.

    Attributes
    ----------
    start: "loop" (the loop's answer), "cold" (no forces, no motion), or a result of the same scene.
    epsilon: first bound on each z p, in median block weights times the live load's mean velocity.
    epsilon_min: last bound.
    minimise: look for the least λ; False for any state at all (the paper's MCP column).

    Raises
    ------
    pydantic.ValidationError
        If a parameter is of the wrong type or out of range.
    """

    start: Literal["loop", "cold"] | InstanceOf[Result] = "loop"
    epsilon: Annotated[Number, Field(gt=0, le=10)] = 0.03
    epsilon_min: Annotated[Number, Field(gt=0, le=10)] = 3e-9
    minimise: Annotated[bool, Strict()] = True

    @model_validator(mode="after")
    def _falling(self) -> MpecOptions:
        if self.epsilon < self.epsilon_min:
            raise ValueError("'epsilon' must not be below 'epsilon_min'")
        return self


@dataclass(frozen=True)
class Relaxation:
    """One solve of the series.

    Attributes
    ----------
    epsilon: bound on each z p.
    load_factor: λ, NaN if the solve failed.
    word: IPOPT's own word.
    iterations: IPOPT's.
    largest_product: largest z p.
    gap: Σ z p over the live load's work, in units of λ.
    seconds: of the solve.
    """

    epsilon: float
    load_factor: float
    word: str
    iterations: int
    largest_product: float
    gap: float
    seconds: float


Progress = Callable[[Relaxation], None]


def mpec(
    problem: Problem,
    load: Callable[[PyomoMpec], Ipopt],
    start: State | None,
    options: MpecOptions,
    watch: Stopwatch,
    progress: Progress = lambda _: None,
) -> Finding:
    """Least load factor near a start, of a scene that stands.

    Parameters
    ----------
    load: loads the declared program into IPOPT.
    start: the state to begin from; None for a cold start.
    progress: called after every solve.
    """
    with watch.measure("build"):
        model = PyomoMpec(problem, options.minimise)
        nothing = State(
            0.0, np.zeros(3 * problem.joints), np.zeros(3 * problem.blocks), np.zeros((4, problem.joints))
        )
        model.start_from(start or nothing)
    with watch.measure("compile"):
        ipopt = load(model)
    finding = Finding(Status.HOMOTOPY, slope=problem.dilatancy)
    epsilon = options.epsilon
    while not _follow(problem, model, ipopt, epsilon, options, finding, watch, progress):
        epsilon *= _SMALLER_START
        if start is None or epsilon < options.epsilon_min or epsilon < _SMALLEST_START:
            return _stopped(finding, start)
        # Nearer to its end the relaxation is easier to follow, if less free to find a lower λ.
        model.start_from(start)
        ipopt.forget()
    best = model.read()
    finding.status, finding.load_factor = Status.CONVERGED, best.load_factor
    kind = "a local minimum" if options.minimise else "one state of many (MCP)"
    finding.message = f"{kind}, complementary to within ε = {options.epsilon_min:.0e}"
    if epsilon < options.epsilon:
        finding.message += f"; relaxed from ε = {epsilon:.0e}, larger ones could not be followed"
    return finding


def _follow(
    problem: Problem,
    model: PyomoMpec,
    ipopt: Ipopt,
    epsilon: float,
    options: MpecOptions,
    finding: Finding,
    watch: Stopwatch,
    progress: Progress,
) -> bool:
    """Solve for a falling ε from the values the model holds; whether all were solved."""
    while True:
        began = time.perf_counter()
        answer = ipopt.solve(epsilon)
        seconds = time.perf_counter() - began
        watch.add("solve", seconds)
        finding.iterations += answer.iterations
        finding.nlp_solves += 1
        load_factor, largest, gap = float("nan"), float("nan"), float("nan")
        if answer.solved:
            state, products = model.read(), model.products()
            finding.take(state)
            load_factor, largest = state.load_factor, float(products.max())
            gap = float(products.sum()) / problem.live_norm
        finding.history.append(
            Relaxation(epsilon, load_factor, answer.word, answer.iterations, largest, gap, seconds)
        )
        progress(finding.history[-1])
        if not answer.solved or epsilon <= options.epsilon_min:
            return answer.solved
        epsilon *= _FALL
        if epsilon < 2 * options.epsilon_min:
            epsilon = options.epsilon_min


def _stopped(finding: Finding, start: State | None) -> Finding:
    failed = finding.history[-1]
    finding.message = f"IPOPT ended with '{failed.word}' at ε = {failed.epsilon:.0e}; "
    solved = [step for step in finding.history if not math.isnan(step.load_factor)]
    if solved:
        last = solved[-1]
        finding.message += (
            f"forces and velocities kept are those of ε = {last.epsilon:.0e}, λ = {last.load_factor:.6g}, "
            f"which is no answer: its complementarity gap is {last.gap:.1e}"
        )
    elif start is not None:
        finding.take(start)
        finding.message += (
            "no relaxation was solved; forces and velocities kept are those of the start: begin with a "
            "smaller 'epsilon'"
        )
    else:
        finding.message += "no relaxation was solved: start from the loop, or with a smaller 'epsilon'"
    return finding

"""Exact states of Coulomb friction: the loop's or the MPEC's answer, refined."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, InstanceOf, Strict

from masonry_opt.answer.certificate import certify
from masonry_opt.answer.result import Result
from masonry_opt.answer.solution import Finding
from masonry_opt.answer.status import Status
from masonry_opt.effort import Stopwatch
from masonry_opt.methods.refined.programs import EXACT, ExactState, Refiner, search
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.blocks import Number, Record

#: So many series of kicks, each with random numbers of its own, from the lowest starts in turn: a long
#: series gets caught where another does not.
_POLISHED = 3

#: Kicks by default: at most, and times joints squared (each costs programs that grow with the scene).
_MOST_KICKS, _KICKS_TIMES_JOINTS_SQUARED = 300, 5_000_000


class RefinedOptions(Record):
    """Parameters of the refinement.

    Attributes
    ----------
    start: whose answer is refined: "loop", "mpec", or a result of the same scene.
    kicks: how often, in each of three series, a state is perturbed in search of a lower one (default:
        5e6 over the square of the number of joints, at most 300).
    restarts: further starts from loops on the scene with its frictions changed at random.
    spread: by how much restarts change each joint's friction (standard deviation of its logarithm).
    seed: of the random numbers; the same seed gives the same answer.

    Raises
    ------
    pydantic.ValidationError
        If a parameter is of the wrong type or out of range.
    """

    start: Literal["loop", "mpec"] | InstanceOf[Result] = "loop"
    kicks: Annotated[int, Strict(), Field(ge=0)] | None = None
    restarts: Annotated[int, Strict(), Field(ge=0)] = 0
    spread: Annotated[Number, Field(gt=0, le=1)] = 0.06
    seed: Annotated[int, Strict(), Field(ge=0)] = 0


@dataclass(frozen=True)
class Refinement:
    """One state that lowered λ on the way.

    Attributes
    ----------
    load_factor: λ.
    lp_solves: linear programs that the refinement itself has solved so far.
    seconds: HiGHS's own time so far.
    """

    load_factor: float
    lp_solves: int
    seconds: float


Progress = Callable[[Refinement], None]


def refined(
    problem: Problem,
    starts: Callable[[int], Finding],
    options: RefinedOptions,
    watch: Stopwatch,
    progress: Progress = lambda _: None,
) -> Finding:
    """Lowest exact state found from one or more starts, of a scene that stands.

    Parameters
    ----------
    starts: the finding to begin with, by number: 0 the scene's own, 1, 2, ... the restarts'.
    progress: called whenever λ falls.
    """
    first = starts(0)
    if first.q is None and not options.restarts:
        return first
    with watch.measure("build"):
        refiner = Refiner(problem)
    history: list[Refinement] = []

    def record(state: ExactState) -> None:
        if not history or state.load_factor < history[-1].load_factor:
            history.append(Refinement(state.load_factor, refiner.solves, refiner.seconds))
            progress(history[-1])

    kicks = options.kicks
    if kicks is None:
        kicks = min(_MOST_KICKS, _KICKS_TIMES_JOINTS_SQUARED // problem.joints**2)
    findings = [first]
    found: list[ExactState] = []
    for number in range(options.restarts + 1):
        if number:
            findings.append(starts(number))
        q = findings[-1].q
        state = None if q is None else refiner.first(q)
        if state is not None:
            found.append(refiner.descend(state, one_by_one=False))
    best, stationary = None, False
    lowest = _lowest(found)
    for turn in range(_POLISHED if kicks and lowest else len(lowest)):
        state = lowest[turn % len(lowest)]
        polished, settled = search(refiner, state, kicks, options.seed + turn, record)
        if best is None or polished.load_factor < best.load_factor:
            best, stationary = polished, settled
    watch.add("solve", refiner.seconds)
    lp_solves = refiner.solves + sum(finding.lp_solves for finding in findings)
    nlp_solves = sum(finding.nlp_solves for finding in findings)
    iterations = refiner.iterations + sum(finding.iterations for finding in findings)
    reason = refiner.reason
    if best is not None:
        residual = certify(problem, best.load_factor, best.q, best.d, problem.dilatancy).worst
        if residual > EXACT:
            best, reason = None, f"the state found leaves residuals up to {residual:.1e}"
    if best is None:
        first.message += f"; not refined: {reason}"
        first.lp_solves, first.nlp_solves, first.iterations = lp_solves, nlp_solves, iterations
        return first
    return Finding(
        Status.CONVERGED,
        _message(first, best, stationary),
        load_factor=best.load_factor,
        q=best.q,
        d=best.d,
        slope=problem.dilatancy,
        history=history,
        iterations=iterations,
        lp_solves=lp_solves,
        nlp_solves=nlp_solves,
        stationary=stationary,
        flow_rule_matters=first.flow_rule_matters,
        size=refiner.size,
    )


def _lowest(states: list[ExactState]) -> list[ExactState]:
    """The lowest few, each load factor once."""
    distinct = {round(state.load_factor, 7): state for state in states}
    return [distinct[load_factor] for load_factor in sorted(distinct)[:_POLISHED]]


def jittered(problem: Problem, spread: float, rng: np.random.Generator) -> Problem:
    """The problem with each joint's friction changed at random, to start from elsewhere."""
    factor = np.exp(spread * rng.standard_normal(problem.joints))
    return problem.with_friction(np.maximum(problem.friction * factor, problem.dilatancy))


def _message(first: Finding, best: ExactState, stationary: bool) -> str:
    parts = ["exact"]
    if first.load_factor is not None:
        fall = first.load_factor - best.load_factor
        if fall >= 0:
            parts[0] += f", {fall:.1e} below its start"
        else:
            parts[0] += f", {-fall:.1e} above its start, which is not exact"
    parts.append(
        "stationary: no mechanism tried among the faces at yield lowers it"
        if stationary
        else "stuck: for some mechanisms the solver could not tell whether they lower it"
    )
    return "; ".join(parts)

"""Method "refined": exact states of Coulomb friction, from the loop's or the MPEC's answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, InstanceOf, Strict

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.methods.mpec import MpecOptions, loop_or, mpec
from masonry_opt.methods.refined.programs import ExactState, Refiner, is_lower
from masonry_opt.methods.task import Method, Options, Task
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.registry import find_solver

#: So many searches, each with random numbers of its own, from the lowest starts in turn: a long
#: one gets caught where another does not.
_SEARCHES = 3

#: Perturbations by default: at most, and times joints squared (each costs programs that grow with the scene).
_MOST_PERTURBATIONS, _TIMES_JOINTS_SQUARED = 300, 5_000_000

#: A perturbed state is looked into if it is above the best by at most the first share of λ, and followed
#: if, after descending, it is above the last by at most a random part of the second.
_WORTH_A_LOOK, _WORTH_FOLLOWING = 0.03, 0.01


class RefinedOptions(Options):
    """Parameters of the refinement.

    Attributes
    ----------
    start: whose answer is refined: "loop", "mpec", or a result of the same scene.
    perturbations: how often, in each of three searches, a state is perturbed in search of a lower one
        (default: 5e6 over the square of the number of joints, at most 300).
    restarts: further starts from loops on the scene with its frictions changed at random.
    spread: by how much restarts change each joint's friction (standard deviation of its logarithm).
    seed: of the random numbers; the same seed gives the same answer.
    """

    start: Literal["loop", "mpec"] | InstanceOf[Solution] = "loop"
    perturbations: Annotated[int, Strict(), Field(ge=0)] | None = None
    restarts: Annotated[int, Strict(), Field(ge=0)] = 0
    spread: Annotated[float, Strict(), Field(gt=0, le=1)] = 0.06
    seed: Annotated[int, Strict(), Field(ge=0)] = 0


@dataclass(frozen=True)
class Refinement:
    """One state that lowered λ on the way.

    Attributes
    ----------
    load_factor: λ.
    lp_solves: linear programs solved so far.
    seconds: the solvers' own time so far.
    """

    load_factor: float
    lp_solves: int
    seconds: float


def refined(task: Task) -> Solution:
    """Lowest exact state found from one or more starts."""
    problem, options, effort = task.problem, task.options, task.effort
    if options.start == "mpec":
        find_solver("pyomo", "casadi")  # said before long work
    first = _start(task, problem)
    if first.q is None and not options.restarts:
        return first
    with effort.measure("build"):
        refiner = Refiner(problem, effort)
    history: list[Refinement] = []

    def record(state: ExactState) -> None:
        if not history or state.load_factor < history[-1].load_factor:
            history.append(Refinement(state.load_factor, effort.lp_solves, effort.seconds["solve"]))
            task.progress(history[-1])

    rng = np.random.default_rng(options.seed)
    found: list[ExactState] = []
    for number in range(options.restarts + 1):
        q = first.q if number == 0 else _start(task, _with_random_friction(problem, options.spread, rng)).q
        state = None if q is None else refiner.first(q)
        if state is not None:
            found.append(refiner.descend(state, one_by_one=False))
    best, stationary = _searched(refiner, _lowest(found), options, record)
    solution = Solution(
        Status.CONVERGED,
        Kind.EXACT,
        slope=problem.dilatancy,
        history=history,
        stationary=stationary,
        flow_rule_matters=first.flow_rule_matters,
        size=refiner.size,
    )
    if best is None:
        first.add(Code.NOT_REFINED, why=str(refiner.why))
        return first
    solution.load_factor, solution.q, solution.d = best.load_factor, best.q, best.d
    if failing := solution.failing(problem):
        first.add(Code.NOT_REFINED, why=str(Code.RESIDUAL), residuals=failing)
        return first
    fall = None if first.load_factor is None else first.load_factor - best.load_factor
    solution.add(Code.EXACT, fall=fall)
    solution.add(Code.STATIONARY if stationary else Code.UNDECIDED)
    return solution


def _start(task: Task, problem: Problem) -> Solution:
    """A solution to begin from; of another problem than the task's, always the loop's."""
    start = task.options.start
    if problem is not task.problem:
        return loop_or("loop", replace(task, problem=problem))
    if start == "mpec":
        return mpec(task.with_options(MpecOptions(), find_solver("pyomo", "casadi")))
    return loop_or(start, task)


def _with_random_friction(problem: Problem, spread: float, rng: np.random.Generator) -> Problem:
    """The problem with each joint's friction changed at random, to start from elsewhere."""
    factor = np.exp(spread * rng.standard_normal(problem.joints))[problem.sliding]
    return replace(problem, friction=np.maximum(problem.friction * factor, problem.dilatancy))


def _lowest(states: list[ExactState]) -> list[ExactState]:
    """The lowest few, each load factor once."""
    distinct = {round(state.load_factor, 7): state for state in states}
    return [distinct[load_factor] for load_factor in sorted(distinct)[:_SEARCHES]]


def _searched(
    refiner: Refiner, lowest: list[ExactState], options: RefinedOptions, record: Callable[[ExactState], None]
) -> tuple[ExactState | None, bool]:
    """The best of a few searches from the lowest states, and whether it is stationary."""
    count = options.perturbations
    if count is None:
        count = min(_MOST_PERTURBATIONS, _TIMES_JOINTS_SQUARED // refiner.problem.joints**2)
    best, stationary = None, False
    for turn in range(_SEARCHES if count and lowest else len(lowest)):
        rng = np.random.default_rng(options.seed + turn)
        state, settled = search(refiner, lowest[turn % len(lowest)], count, rng, record)
        if best is None or state.load_factor < best.load_factor:
            best, stationary = state, settled
    return best, stationary


def search(
    refiner: Refiner,
    state: ExactState,
    perturbations: int,
    rng: np.random.Generator,
    record: Callable[[ExactState], None] = lambda _: None,
) -> tuple[ExactState, bool]:
    """Descend, then perturb and descend again; the best state, and whether it is stationary.

    Stationary: for each face that holds λ up a mechanism among the faces at yield that avoids it was
    tried, and none lowered λ (or there is none). Slightly worse states are followed for a while.
    """
    best = current = refiner.descend(state, one_by_one=True)
    stationary = refiner.undecided == 0
    record(best)
    for _ in range(perturbations):
        near = refiner.perturbed(current, rng)
        if near is None or near.load_factor > best.load_factor + _WORTH_A_LOOK * _size(best):
            continue
        near = refiner.descend(near, one_by_one=False)
        worse = near.load_factor - current.load_factor
        if is_lower(near, best):
            best = current = refiner.descend(near, one_by_one=True)
            stationary = refiner.undecided == 0
            record(best)
        elif worse < _WORTH_FOLLOWING * rng.random() * _size(current):
            current = near
        else:
            current = best
    return best, stationary


def _size(state: ExactState) -> float:
    """|λ|, kept away from zero."""
    return max(abs(state.load_factor), 1e-3)


REFINED = Method(
    "refined", refined, RefinedOptions, {"pyomo": ("highs",)}, own_tolerances=True, constant_dilatancy=True
)

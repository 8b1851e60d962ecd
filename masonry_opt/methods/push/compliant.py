"""Method "compliant": the incremental load factor of a scene that stands under its weight and is then pushed.

Coulomb's problem has many states. Where contacts give a little, by an elastic compliance E of each joint,
forces are unique: Bᵀd in eqs (5) and (6) becomes Bᵀd + E (q - q₀), with q₀ those of the dead load alone. From
rest λ comes to where blocks move on for ever: on that ray contacts give no more, and the state is exact.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf
from typing import Annotated, Any

import numpy as np
from pydantic import Field, Strict, model_validator

from masonry_opt.answer.acceptance import SMALLEST, Kind, over_load_factor
from masonry_opt.answer.answer import Found
from masonry_opt.answer.reasons import Code, Reason, Status, reason
from masonry_opt.answer.solution import Solution, Way
from masonry_opt.answer.thresholds import PLATEAU, ZERO
from masonry_opt.methods.push.push import Elastic, Ended, Pushed, PushStep, elastic_of
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.problem import Problem

#: Joints, in space contacts, up to which other methods compute the incremental load factor too.
PUSHED_UP_TO = 3000
SOFT = 3e1  #: Displacement at which contacts are soft still: in space their forces at times lead lower.

#: How much softer contacts are with which a state is compared, and the states of a curve at most.
_SOFTER, _ON_CURVE = 10.0, 100

KEYFRAMES, _AGAIN = 60, 3.0  #: Keyframes, and how many times as far a path is shown as up to where λ stays.
_STIFFNESS = 0.5  #: Standard deviation of the logarithm of a contact's stiffness.


class CompliantOptions(Options):
    """Options of contacts that give.

    Attributes
    ----------
    give: motion of a contact of mean length under the mean contact force of the dead load, as a share of the
        motion at collapse (in which the live load does the work Σ|f_L|); by default, none is left at the end.
    curve: whether to tell λ over displacement too: ``result.curve``.
    spread: of how many draws of contacts' stiffness, and of as many of self-stress at rest, the least and the
        largest incremental load factor are told too.
    """

    give: Annotated[float, Strict(), Field(gt=0, le=1e3)] | None = None
    curve: Annotated[bool, Strict()] = False
    spread: Annotated[int, Strict(), Field(ge=1, le=1000)] | None = None

    @model_validator(mode="after")
    def _has_an_end(self) -> "CompliantOptions":
        if self.curve and self.give is not None:
            raise ValueError("'curve' goes through all compliances: leave 'give' out")
        if self.spread and self.give is not None:
            raise ValueError("option 'spread' needs the incremental load factor: omit 'give'")
        return self


def compliant(task: Task) -> Solution:
    """Load factor at the ray that the path from rest ends in, or where it stays far from rest, else the
    largest that blocks come to rest under; where contacts are to give so much, of the state there."""
    options, effort = task.options or CompliantOptions(), task.effort
    effort.begins("pushed from rest")
    effort.uses(task.solver.name, "complementarity problem")
    with effort.measure("build"):
        elastic = elastic_of(task)

    def follow(step: PushStep) -> None:
        effort.iterations += 1
        task.progress(step)

    with effort.measure("solve"):
        asked = 1 / options.give if options.give else None
        pushed = elastic.pushed(follow, asked or inf)
        if falls := elastic.falls:
            found = Found(q=falls.q, d=falls.d, slope=falls.slope, forms=falls.forms)
            solution = Solution(Status.UNSTABLE, Kind.COMPLIANT, found=found, solver=task.solver)
            return solution.withdrawn(Status.UNSTABLE, Code.WEDGED, blocks=[])
        solution = _solution(elastic, pushed, asked)
        if options.curve:
            solution = _with_curve(elastic, pushed, solution)
        if options.spread:
            solution = solution.telling(_spread(elastic, options.spread))
        softer = elastic.at(pushed, SOFT) if task.problem.layout.round else None
    history, along = (*pushed.steps, *pushed.growth_steps), partial(_way, elastic, pushed)
    return replace(solution, history=history, way=along, softer=softer, solver=task.solver)


def _solution(elastic: Elastic, pushed: Pushed, asked: float | None) -> Solution:
    """How a push ends, or the state that was asked for at a u."""
    solution, end = Solution(Status.SOLVER_FAILED, Kind.COMPLIANT), pushed.answer
    growth, steps = pushed.growth, len(pushed.steps) + len(pushed.growth_steps)
    folds, deep_fall = (0, None) if growth else (pushed.folds, pushed.deep_fall)
    told: dict[str, Any] = {"steps": steps, "folds": folds, "deep_fall": deep_fall}
    if asked is None and pushed.ended is Ended.JAM:
        return solution.ended(Status.SOLVER_FAILED, Code.JAMS, **told)
    if asked is None and end is not None and elastic.tells(end.load_factor, end.d):
        highest = pushed.peak or 0.0
        peak = highest if highest > end.load_factor * (1 + PLATEAU) + ZERO else None
        code = Code.LEVEL if pushed.ended is Ended.LEVEL else Code.RAY
        ended = replace(solution, found=end).ended(Status.CONVERGED, code, **told, peak=peak)
        return replace(ended, followed_to_end=True, peak=peak)
    state = elastic.at(pushed, asked) if asked else elastic.carried(growth) if growth else None
    if state is None or state.answer.failing(Kind.COMPLIANT):
        stopped = {"word": str(pushed.ended), "steps": steps, "looped": False}
        return solution.ended(Status.SOLVER_FAILED, Code.PUSH_STOPPED, **stopped)
    found = state.answer
    if growth is not None:
        beyond = growth.beyond and growth.beyond / elastic.problem.live_norm
        return replace(solution, found=found).ended(Status.CONVERGED, Code.GROWN, beyond=beyond, steps=steps)
    before = elastic.at(pushed, 1 / (_SOFTER * state.give))
    change = None
    if before is not None:
        apart = abs(found.load_factor - before.answer.load_factor)
        change = over_load_factor(apart, found.load_factor)
    code = Code.PLATEAU if change is not None and change <= PLATEAU else Code.NO_PLATEAU
    given = {"give": state.give, "change": change, "softer": _SOFTER, "steps": steps}
    return replace(solution, found=found).ended(Status.CONVERGED, code, **given)


def _with_curve(elastic: Elastic, pushed: Pushed, ending: Solution) -> Solution:
    """An end with states on the way."""
    # The displacement of the first is nothing but rounding.
    ahead = [(point.at, u) for point in pushed.points[1:] if (u := elastic.curve.u(point.at)) > 0]
    states = [elastic.next_to(pushed, *near) for near in ahead[:: max(1, -(-len(ahead) // _ON_CURVE))]]
    curve = tuple(state for state in states if state is not None)
    ending = replace(ending, curve=curve)
    if not curve:
        return ending
    load_factors = [state.answer.load_factor for state in curve]
    told = {"peak": max(load_factors), "last": load_factors[-1], "left_out": len(states) - len(curve)}
    return ending.telling(reason(Code.CURVE, states=len(curve), **told))


def _spread(elastic: Elastic, draws: int) -> Reason:
    """Return ranges of the incremental load factor, over draws of stiffness and over draws of self-stress.

    A draw of self-stress is a vertex of the forces that balance the dead load, or a mixture of two vertices.
    """
    rng = np.random.default_rng(0)
    stiffness, by_stiffness = _range(elastic.drawn(_STIFFNESS, rng) for _ in range(draws))
    stress, by_stress = _range(_stressed(elastic, number, rng) for number in range(draws))
    without = 2 * draws - by_stiffness - by_stress
    return reason(Code.SPREAD, draws=draws, stiffness=stiffness, stress=stress, without=without)


def _stressed(elastic: Elastic, number: int, rng: np.random.Generator) -> Elastic | None:
    one, other = (self_stress(elastic.problem, rng) for _ in range(2))
    if one is None or other is None:
        return None
    share = rng.uniform() if number % 2 else 1.0
    return elastic.again_for(replace(elastic.problem, settled=share * one + (1 - share) * other))


def self_stress(problem: Problem, rng: np.random.Generator) -> np.ndarray | None:
    """Return forces (3c + t,) that carry the dead load within yield; None if there are none.

    The forces minimise a random cost of the normal forces. In space the polygons of friction limit them.
    """
    # Importing scipy.optimize takes a fifth of a second, and only the option "spread" needs a program here.
    from scipy.optimize import linprog

    cost = rng.exponential(1.0, problem.B.shape[1])
    cost[problem.layout.points * problem.joints :] = 0.0
    sides, most = -problem.true_yield, problem.face_cohesion
    found: np.ndarray | None = linprog(cost, sides, most, problem.B, -problem.dead, (None, None)).x
    return found


def _range(drawn: Iterable[Elastic | None]) -> tuple[tuple[float, float] | None, int]:
    """Return the least and largest incremental load factor, and the number of load histories."""
    pushes = (one.pushed() for one in drawn if one is not None)
    peaks = [float(pushed.peak) for pushed in pushes if pushed.peak is not None]
    return ((min(peaks), max(peaks)) if peaks else None), len(peaks)


def _way(elastic: Elastic, pushed: Pushed) -> Way | None:
    """Keyframes of a push, on the tangents of its points; None of one that did not begin."""
    points, unit = pushed.points, elastic.problem.live_norm
    if len(points) < 2:
        return None
    curve = elastic.curve.rounded_by(pushed.rounding)
    path = [points[0].at]
    for before, after in pairwise(points):
        path += [curve.corner(before, after)] if len(points) < KEYFRAMES else []
        path += [after.at]
    u, load = np.array([(curve.u(each), each[-1] / unit) for each in path]).T
    at = keyframes(u - u[0], load)
    first = np.minimum(at.astype(int), len(path) - 2)
    states = np.stack(path[: first[-1] + 2])
    states = states[first] + (at - first)[:, None] * np.diff(states, axis=0)[first]
    q = np.stack([curve.forces(each) for each in states])
    d, load = states[:, :-1] - states[0, :-1], (states[:, -1] - states[0, -1]) / unit
    return Way(elastic.giving(1.0), d @ curve.live, load, d, q, pushed.rounding)


def keyframes(u: np.ndarray, load_factor: np.ndarray) -> np.ndarray:
    """Keyframes of a path of u and λ, shape (points,) each, as fractional numbers of its points: evenly along
    the curve of λ over u, u beyond half the highest λ by its logarithm; each moved to a fold or turn, else a
    point of the path, that is near."""
    away = np.abs(load_factor - load_factor[-1]) > PLATEAU * np.abs(load_factor).max()
    stays, numbers = int(np.flatnonzero(away).max(initial=0)) + 1, np.arange(len(u))
    goal, end = _AGAIN * u[: stays + 1].max(), len(u) - 1.0
    beyond = stays + np.flatnonzero(u[stays:] >= goal)
    if goal > 0 and len(beyond):
        last = beyond[0] - 1 + np.arange(2)
        end = float(np.interp(goal, u[last], last))
    places = np.append(numbers[numbers < end], end)
    half = max(abs(u[(np.abs(load_factor) >= np.abs(load_factor).max() / 2).argmax()]), SMALLEST)
    shown = np.sign(u) * np.log1p(np.abs(u) / half), load_factor
    steps = np.stack([np.diff(np.interp(places, numbers, of)) for of in shown])
    sizes = np.maximum(np.abs(steps.cumsum(axis=1)).max(axis=1, keepdims=True), SMALLEST)
    far = np.append(0.0, np.hypot.reduce(steps / sizes, axis=0).cumsum())
    turns = 1 + np.flatnonzero((steps[:, 1:] * steps[:, :-1] < 0).any(axis=0))
    at, apart = np.linspace(0.0, far[-1], KEYFRAMES, retstep=True)
    for kept in (numbers[1 : len(places) - 1], turns):
        at[np.rint(far[kept] / apart).astype(int)] = far[kept]
    at[[0, -1]] = far[[0, -1]]
    found: np.ndarray = np.interp(at, far, places)
    return found

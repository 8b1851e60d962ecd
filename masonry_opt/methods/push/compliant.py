"""Method "compliant": the load to expect of a scene that stands under its weight and is then pushed.

Coulomb's problem has many states. Where contacts give a little, forces are unique: with a small elastic
compliance E of each joint, Bᵀd in eqs (5) and (6) becomes Bᵀd + E (q - q₀), and all else stays: q₀ are the
forces under the dead load alone, whose slip is past when the live load comes. Followed from rest, λ comes to
where blocks move on for ever: on that ray contacts give no more, and the state is exact.
"""

from dataclasses import replace
from functools import partial
from math import inf
from typing import Annotated, Any

from pydantic import Field, Strict, model_validator

from masonry_opt.answer.acceptance import Kind, over_load_factor
from masonry_opt.answer.answer import Found
from masonry_opt.answer.reasons import Code, Reason, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import PLATEAU, ZERO
from masonry_opt.methods.push.keyframes import way
from masonry_opt.methods.push.push import Elastic, elastic_of
from masonry_opt.methods.push.pushed import Ended, Pushed, PushStep
from masonry_opt.methods.push.spread import spread
from masonry_opt.methods.task import Options, Task

#: Joints, in space contact points, up to which the load to expect is told beside other methods' answers.
PUSHED_UP_TO = 3000

#: Displacement at which contacts are soft still: in space alone their forces lead to lower states at times.
SOFT = 3e1

#: How much softer contacts are with which a state is compared, and the states of a curve at most.
_SOFTER, _ON_CURVE = 10.0, 100


class CompliantOptions(Options):
    """Options of contacts that give.

    Attributes
    ----------
    give: motion of a contact of mean length under the mean contact force of the dead load, as a share of the
        motion at collapse (in which the live load does the work Σ|f_L|); by default, none is left at the end.
    curve: whether to tell λ over displacement too: ``result.curve``.
    spread: of how many draws of contacts' stiffness, and of as many of self-stress at rest, the least and the
        largest load to expect are told too.
    """

    give: Annotated[float, Strict(), Field(gt=0, le=1e3)] | None = None
    curve: Annotated[bool, Strict()] = False
    spread: Annotated[int, Strict(), Field(ge=1, le=1000)] | None = None

    @model_validator(mode="after")
    def _has_an_end(self) -> "CompliantOptions":
        if self.curve and self.give is not None:
            raise ValueError("'curve' goes through all compliances: leave 'give' out")
        if self.spread and self.give is not None:
            raise ValueError("'spread' is of loads to expect, where contacts give no more: leave 'give' out")
        return self


def compliant(task: Task) -> Solution:
    """Load factor at the ray that the path from rest ends in; where it comes to none, the largest that blocks
    come to rest under; where contacts are to give so much, of the state there."""
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
            solution = solution.telling(spread(elastic, options.spread))
        softer = elastic.at(pushed, SOFT) if task.problem.layout.round else None
    along = partial(way, elastic, pushed)
    return replace(
        solution, history=(*pushed.steps, *pushed.growth_steps), way=along, softer=softer, solver=task.solver
    )


def jams(task: Task) -> Reason | None:
    """That from rest friction jams the blocks; None if it does not."""
    solution = task.expected or compliant(task.with_options(None))
    return next((said for said in solution.reasons if said.code is Code.JAMS), None)


def _solution(elastic: Elastic, pushed: Pushed, asked: float | None) -> Solution:
    """How a push ends: on a ray, in a jam, or in the state that it came to, or was asked for at a u."""
    solution, answer = Solution(Status.SOLVER_FAILED, Kind.COMPLIANT), pushed.answer
    growth, steps = pushed.growth, len(pushed.steps) + len(pushed.growth_steps)
    told: dict[str, Any] = {"steps": steps, "folds": pushed.folds, "deep_fall": pushed.deep_fall}
    if growth is not None:
        told = {"steps": steps, "folds": 0, "deep_fall": None}
    if asked is None and pushed.ended is Ended.JAM:
        return solution.ended(Status.SOLVER_FAILED, Code.JAMS, **told)
    if asked is None and answer is not None and elastic.tells(answer.load_factor, answer.d):
        peak = pushed.peak or 0.0
        told["peak"] = peak if peak > answer.load_factor * (1 + PLATEAU) + ZERO else None
        return replace(solution, found=answer).ended(Status.CONVERGED, Code.RAY, **told)
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
    ahead = [step for step in pushed.steps[1:] if step.displacement > 0]
    chosen = ahead[:: max(1, -(-len(ahead) // _ON_CURVE))]
    states = [elastic.next_to(pushed, step) for step in chosen]
    curve = tuple(state for state in states if state is not None)
    ending = replace(ending, curve=curve)
    if not curve:
        return ending
    load_factors = [state.answer.load_factor for state in curve]
    told = {"peak": max(load_factors), "last": load_factors[-1], "left_out": len(states) - len(curve)}
    return ending.telling(reason(Code.CURVE, states=len(curve), **told))

"""Method "compliant": the load to expect of a scene that stands under its weight and is then pushed.

Coulomb's problem has many states. Where contacts give a little, forces are unique and a pass is easy: with a
small elastic compliance E of each joint, Bᵀd in eqs (5) and (6) becomes Bᵀd + E q, and all else stays. As
contacts stiffen, λ comes to a plateau that hardly depends on them.
"""

from __future__ import annotations

from math import log10
from typing import Annotated

import numpy as np
from pydantic import Field, Strict, model_validator

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Found, certified
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.solution import GivingState, Solution
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import PLATEAU
from masonry_opt.methods.mcp.passes import follow, prepared
from masonry_opt.methods.mcp.rules import GIVING
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.problem import Problem

#: Compliances of the passes that look for the plateau, from soft to stiff; softer ones, where none ends.
STIFF, SOFT = (1e-3, 1e-4, 1e-5, 1e-6), (1e-2, 1e-1)

#: The softest compliance of a curve, and its passes a decade.
_SOFTEST, _A_DECADE = 10.0, 4

#: Share of λ from which on a change between two compliances means that there is no load factor: where nothing
#: collapses λ grows with the stiffness.
_GROWS = 0.8


class CompliantOptions(Options):
    """Options of contacts that give.

    Attributes
    ----------
    give: motion of a contact of mean length under the mean contact force of the dead load, as a share of the
        motion at collapse (in which the live load does the work Σ|f_L|); by default, as little as brings λ to
        its plateau.
    curve: whether to follow λ over displacement too: ``result.curve``, some twenty passes more.
    """

    give: Annotated[float, Strict(), Field(gt=0, le=1e3)] | None = None
    curve: Annotated[bool, Strict()] = False

    @model_validator(mode="after")
    def _has_a_plateau(self) -> CompliantOptions:
        if self.curve and self.give is not None:
            raise ValueError("'curve' goes through all compliances: leave 'give' out")
        return self


def compliant(task: Task) -> Solution:
    """Load factor with contacts so stiff that ten times softer ones change it by ``PLATEAU`` at most.

    Where they change it more, or only one pass ends, the reason says so; where they change it five-fold
    there is no load factor.
    """
    options = task.options or CompliantOptions()
    solution = Solution(Status.SOLVER_FAILED, Kind.COMPLIANT)
    contacts = _Contacts(task, solution)
    _look_for_plateau(solution, contacts, options)
    if options.curve:
        _follow_curve(solution, contacts)
    return solution


def _look_for_plateau(solution: Solution, contacts: _Contacts, options: CompliantOptions) -> None:
    change: float | None = None
    for give in STIFF if options.give is None else (options.give,):
        state, before = contacts.state(give), solution.load_factor
        if state is None:
            continue
        if before is not None:
            change = abs(state.answer.load_factor - before) / abs(state.answer.load_factor)
        _end(solution, state, change)
        if change is not None and change <= PLATEAU:
            return
    if solution.answer is None and options.give is None:
        for give in SOFT:
            if state := contacts.state(give):
                _end(solution, state, None)
                return
    if solution.answer is None:
        solution.end(
            Status.SOLVER_FAILED, Code.PASS_STOPPED, word=contacts.word, attempts=len(contacts.states)
        )
    elif change is not None and change > _GROWS:
        grown = {"load_factor": solution.load_factor, "change": change}
        solution.found = Found()  # elastic motion, of no mechanism
        solution.end(Status.SOLVER_FAILED, Code.GROWS_WITH_STIFFNESS, **grown)


def _follow_curve(solution: Solution, contacts: _Contacts) -> None:
    """States from the softest contacts to the stiffest of the passes before. (At λ < 0 the live load would
    pull back what the dead load has moved: such states are none of a scene that is pushed.)"""
    decades = round(log10(_SOFTEST / min(contacts.states)))
    gives = [_SOFTEST / 10 ** (number / _A_DECADE) for number in range(decades * _A_DECADE + 1)]
    states = [state for give in gives if (state := contacts.state(give))]
    solution.curve = [state for state in states if state.answer.load_factor >= 0]
    if solution.curve:
        load_factors = [state.answer.load_factor for state in solution.curve]
        told = {"peak": max(load_factors), "last": load_factors[-1], "left_out": len(gives) - len(states)}
        solution.add(Code.CURVE, states=len(load_factors), **told)


def unit_compliance(problem: Problem, least_forces: np.ndarray) -> np.ndarray:
    """Compliance of each joint by kind of force, shape (3c,): a contact of mean length moves by one under the
    mean contact force.

    A contact is an edge of a joint. Its stiffness grows with its area, here its length; in shear a joint is
    half as stiff as along its normal, about as stone is.

    Parameters
    ----------
    least_forces: least forces at edges and in shear that carry the dead load, shape (3, c).
    """
    force = float(np.abs(least_forces[:2]).mean()) or 1.0
    contact = problem.half_length.mean() / problem.half_length / force
    return np.concatenate([contact / 2, contact, contact / (2 * problem.lever**2)])


class _Contacts:
    """Passes over a problem with contacts that give.

    Attributes
    ----------
    states: that the passes so far ended in, by compliance; None of those that ended in none.
    word: how the last pass ended.
    """

    def __init__(self, task: Task, solution: Solution) -> None:
        self._task, self._passes, self._history = task, prepared(task), solution.history
        self._unit = unit_compliance(task.problem, self._passes.least_forces)
        self.states: dict[float, GivingState | None] = {}
        self.word = ""

    def state(self, give: float) -> GivingState | None:
        """The state with this compliance; None if no pass ends in one."""
        if give not in self.states:
            self.states[give] = self._ended(give)
        return self.states[give]

    def _ended(self, give: float) -> GivingState | None:
        self._task.effort.begins(f"contacts that give by {give:.0e}")
        passes = self._passes.giving(give * self._unit)
        state = follow(self._task, passes, GIVING, self._history, len(self.states) + 1)
        self.word = str(passes.outcome)
        if state is None:
            return None
        answer = certified(passes.problem, state.load_factor, state.q, state.d)
        return None if answer.failing(Kind.COMPLIANT) else GivingState(give, passes.problem, answer)


def _end(solution: Solution, state: GivingState, change: float | None) -> None:
    code = Code.PLATEAU if change is not None and change <= PLATEAU else Code.NO_PLATEAU
    solution.found = state.answer
    solution.end(Status.CONVERGED, code, give=state.give, change=change, steps=len(solution.history))

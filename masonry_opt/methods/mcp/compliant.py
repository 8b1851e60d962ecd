"""Method "compliant": the load to expect of a scene that stands under its weight and is then pushed.

Coulomb's problem has many states. Where contacts give a little, forces are unique and a pass is easy: with a
small elastic compliance E of each joint, Bᵀd in eqs (5) and (6) becomes Bᵀd + E q, and all else stays. As
contacts stiffen, λ comes to a plateau that hardly depends on them.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, Strict

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer, Found, certified
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import PLATEAU
from masonry_opt.methods.mcp.passes import follow, prepared
from masonry_opt.methods.mcp.rules import GIVING
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.problem import Problem

#: Compliances of the passes that look for the plateau, from soft to stiff; softer ones, where none ends.
STIFF, SOFT = (1e-3, 1e-4, 1e-5, 1e-6), (1e-2, 1e-1)

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
    """

    give: Annotated[float, Strict(), Field(gt=0, le=1e3)] | None = None


def compliant(task: Task) -> Solution:
    """Load factor with contacts so stiff that ten times softer ones change it by ``PLATEAU`` at most.

    Where they change it more, or only one pass ends, the reason says so; where they change it five-fold
    there is no load factor.
    """
    options = task.options or CompliantOptions()
    solution = Solution(Status.SOLVER_FAILED, Kind.COMPLIANT)
    contacts = _Contacts(task, solution)
    change: float | None = None
    for give in STIFF if options.give is None else (options.give,):
        answer, before = contacts.answer(give), solution.load_factor
        if answer is None:
            continue
        if before is not None:
            change = abs(answer.load_factor - before) / abs(answer.load_factor)
        _end(solution, answer, give, change)
        if change is not None and change <= PLATEAU:
            return solution
    if solution.answer is None and options.give is None:
        for give in SOFT:
            if answer := contacts.answer(give):
                _end(solution, answer, give, None)
                return solution
    if solution.answer is None:
        solution.end(Status.SOLVER_FAILED, Code.PASS_STOPPED, word=contacts.word, attempts=contacts.tried)
    elif change is not None and change > _GROWS:
        grown = {"load_factor": solution.load_factor, "change": change}
        solution.found = Found()  # elastic motion, of no mechanism
        solution.end(Status.SOLVER_FAILED, Code.GROWS_WITH_STIFFNESS, **grown)
    return solution


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
    tried: passes so far.
    word: how the last one ended.
    """

    def __init__(self, task: Task, solution: Solution) -> None:
        self._task, self._passes, self._history = task, prepared(task), solution.history
        self._unit = unit_compliance(task.problem, self._passes.least_forces)
        self.tried, self.word = 0, ""

    def answer(self, give: float) -> Answer | None:
        """The answer with this compliance; None if no pass ends in one."""
        self.tried += 1
        self._task.effort.begins(f"contacts that give by {give:.0e}")
        passes = self._passes.giving(give * self._unit)
        state = follow(self._task, passes, GIVING, self._history, self.tried)
        self.word = str(passes.outcome)
        if state is None:
            return None
        answer = certified(passes.problem, state.load_factor, state.q, state.d)
        return None if answer.failing(Kind.COMPLIANT) else answer


def _end(solution: Solution, answer: Answer, give: float, change: float | None) -> None:
    code = Code.PLATEAU if change is not None and change <= PLATEAU else Code.NO_PLATEAU
    solution.found = answer
    solution.end(Status.CONVERGED, code, give=give, change=change, steps=len(solution.history))

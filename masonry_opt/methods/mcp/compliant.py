"""Method "compliant": the load to expect of a scene that stands under its weight and is then pushed.

Coulomb's problem has many states. Where contacts give a little, forces are unique and a pass is easy: with a
small elastic compliance E of each joint, Bᵀd in eqs (5) and (6) becomes Bᵀd + E q, and all else stays. As
contacts stiffen, λ comes to a plateau that hardly depends on them.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field, Strict

from masonry_opt.answer.acceptance import SMALLEST, Kind
from masonry_opt.answer.answer import Answer, Found, certified
from masonry_opt.answer.reasons import Code, Reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import PLATEAU
from masonry_opt.methods.mcp.passes import follow, prepared
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State

#: Compliances of the passes that look for the plateau, from soft to stiff; softer ones, where none ends.
STIFF, SOFT = (1e-3, 1e-4, 1e-5, 1e-6), (1e-2, 1e-1)

#: The same, of the passes whose forces alone are wanted: the first that ends.
_FIRST = (1e-4, 1e-5, 1e-3)

#: Elastic share of the live load's work above which nothing collapses: λ grows with the stiffness. At a
#: collapse the share falls with the compliance; where friction jams the blocks it stays near one.
_ELASTIC = 0.5


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

    Where they change it more, or only one pass ends, the reason says so; where nearly all work is elastic
    there is no load factor.
    """
    options = task.options or CompliantOptions()
    solution = Solution(Status.SOLVER_FAILED, Kind.COMPLIANT)
    contacts = _Contacts(task, solution)
    for give in STIFF if options.give is None else (options.give,):
        if contacts.settles(give):
            return solution
    if solution.answer is None and options.give is None:
        for give in SOFT:
            if contacts.settles(give) or solution.answer:
                return solution
    if solution.answer is None:
        solution.end(Status.SOLVER_FAILED, Code.PASS_STOPPED, word=contacts.word, attempts=contacts.tried)
    return solution


def pushed(task: Task, history: list[Any]) -> State | None:
    """The first state that a pass with contacts that give ends in, for its forces alone."""
    passes = prepared(task)
    for attempt, give in enumerate(_FIRST, start=1):
        if state := follow(task, passes.giving(give), history, attempt):
            return state
    return None


def jams(task: Task) -> Reason | None:
    """That the load factor grows with the stiffness of contacts; None if it does not."""
    solution = task.expected or compliant(task.with_options(None))
    return next((said for said in solution.reasons if said.code is Code.GROWS_WITH_STIFFNESS), None)


class _Contacts:
    """Passes over a problem with contacts that give, which a solution records.

    Attributes
    ----------
    tried: passes so far.
    word: how the last one ended.
    """

    def __init__(self, task: Task, solution: Solution) -> None:
        self._task, self._passes, self._solution = task, prepared(task), solution
        self.tried, self.word = 0, ""

    def settles(self, give: float) -> bool:
        """Whether a pass with this compliance settles the load factor, or that there is none."""
        answer, before = self._answer(give), self._solution.load_factor
        if answer is None:
            return False
        elastic = elastic_share(answer, give * self._passes.unit_compliance, self._task.problem)
        if elastic > _ELASTIC:
            self._solution.found = Found()  # of no mechanism
            values = {"load_factor": answer.load_factor, "give": give, "elastic": elastic}
            self._solution.end(Status.SOLVER_FAILED, Code.GROWS_WITH_STIFFNESS, **values)
            return True
        change = None if before is None else abs(answer.load_factor - before) / abs(answer.load_factor)
        settled = change is not None and change <= PLATEAU
        code, steps = Code.PLATEAU if settled else Code.NO_PLATEAU, len(self._solution.history)
        self._solution.found = answer
        self._solution.end(Status.CONVERGED, code, give=give, change=change, steps=steps)
        return settled

    def _answer(self, give: float) -> Answer | None:
        self.tried += 1
        self._task.effort.begins(f"contacts that give by {give:.0e}")
        passes = self._passes.giving(give)
        state = follow(self._task, passes, self._solution.history, self.tried)
        self.word = str(passes.outcome)
        if state is None:
            return None
        answer = certified(passes.problem, state.load_factor, state.q, state.d)
        return None if answer.failing(Kind.COMPLIANT) else answer


def elastic_share(state: State | Answer, compliance: np.ndarray, problem: Problem) -> float:
    """Elastic energy q·E q of a state, over the live load's work."""
    work = abs(state.load_factor) * problem.live_norm
    return float(state.q @ (compliance * state.q)) / max(work, SMALLEST)

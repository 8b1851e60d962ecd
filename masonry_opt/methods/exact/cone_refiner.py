"""Exact states of contact points in space for a search: by conic programs, under cones of friction."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer
from masonry_opt.answer.reasons import Code
from masonry_opt.methods.exact.alternation import alternated
from masonry_opt.methods.exact.refiner import ExactState, StateFinder


class ConeRefiner(StateFinder):
    """By alternation: what holds λ up is not known, states have no neighbours."""

    def state_near(self, q: np.ndarray) -> ExactState | None:
        problem = self.problem
        # Forces of contacts that give, or of other loads, need not balance: the load that fits best.
        unbalanced = problem.unbalanced(0.0, q)
        load_factor = -float(problem.live @ unbalanced) / float(problem.live @ problem.live)
        self.why = Code.NO_PROGRAM
        answer = alternated(problem, load_factor, q, self.effort, self._follow)
        if answer:
            self.left = answer.failing(Kind.EXACT)
        if answer is None or self.left:
            return None
        nothing = np.zeros(problem.faces)
        return ExactState(answer.load_factor, answer.q, answer.d, nothing, nothing, nothing, answer)

    def _follow(self, last: Answer | None) -> None:
        self.left = last.failing(Kind.EXACT) if last else {}
        self.check_time()

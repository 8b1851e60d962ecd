"""Exact states of contact points in space for a search: by conic programs, under cones of friction."""

from __future__ import annotations

from math import inf

import numpy as np

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.alternation import alternated
from masonry_opt.methods.exact.refiner import ExactState, Refiner
from masonry_opt.problem.problem import Problem


class ConeRefiner(Refiner):
    """A refiner by alternation, of :meth:`settled` alone: what holds λ up is not known, states have no
    neighbours."""

    def __init__(self, problem: Problem, effort: Effort) -> None:
        self.problem, self.effort, self.size = problem, effort, None
        self.undecided, self.why, self.left, self.deadline = 0, Code.NO_STATICS, {}, inf

    def settled(self, q: np.ndarray) -> ExactState | None:
        """The exact state that forces (3c,) lead to; None if they lead to none."""
        self.check_time()
        problem = self.problem
        # Forces of contacts that give, or of other loads, need not balance: the load that fits best.
        unbalanced = problem.unbalanced(0.0, q)
        load_factor = -float(problem.live @ unbalanced) / float(problem.live @ problem.live)
        answer = alternated(problem, load_factor, q, self.effort)
        self.left = answer.failing(Kind.EXACT) if answer else {}
        if answer is None or self.left:
            return None
        nothing = np.zeros(problem.faces)
        return ExactState(answer.load_factor, answer.q, answer.d, nothing, nothing > 0, nothing, answer)

"""Associative load factors of one scene under one live load after the other, by one linear program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import certified
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_static import CvxpyStatic
from masonry_opt.problem.load_units import in_units_of_load
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.highs_session import HighsSession
from masonry_opt.solvers.lp import Verdict


class MovingLoad:
    """Eq. (9) in HiGHS, compiled once of a scene that stands, with any live load: of a new one the column of
    λ alone changes, and simplex goes on from the last basis."""

    def __init__(self, problem: Problem, effort: Effort) -> None:
        self._problem = problem
        scaled = in_units_of_load(problem)
        self._force = scaled.force
        model = CvxpyStatic(scaled.problem, scaled.limits(ShearLimits.true(problem)))
        self._statics = model.statics
        self._program = HighsSession(model.program, effort, "associative load factor")
        self.solved = 0

    def __call__(self, live: np.ndarray) -> Solution:
        """The associative answer under a live load, shape (3b,), certified by itself."""
        problem = replace(self._problem, live=live)
        statics, program = self._statics, self._program
        program.set_column(statics.load_factor, statics.equilibrium, live / problem.live_norm)
        self.solved += 1
        verdict = program.solve()
        solution = Solution(Status.OPTIMAL, Kind.ASSOCIATIVE, size=program.size)
        if verdict is Verdict.OPTIMAL:
            q = self._force * program.values(statics.q)
            d = program.duals(statics.equilibrium)
            load_factor = self._force * float(program.values(statics.load_factor)[0]) / problem.live_norm
            found = certified(problem, load_factor, q, d * problem.live_norm / (live @ d), problem.friction)
            return replace(solution, found=found).accepted()
        if verdict in (Verdict.UNBOUNDED, Verdict.INFEASIBLE_OR_UNBOUNDED):
            # The scene stands: the program has a state, at λ = 0.
            return solution.ended(Status.UNLIMITED, Code.NO_MECHANISM)
        return solution.ended(Status.SOLVER_FAILED, Code.SOLVER_STOPPED, word=verdict.value)

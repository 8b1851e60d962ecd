"""The dual program answers where the solver ends short in the one that was asked."""

from __future__ import annotations

from dataclasses import replace

import pytest
from scenes import WALLS

import masonry_opt as mo
from masonry_opt.answer.reasons import Code
from masonry_opt.methods.associative import associative
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.solvers.registry import find_solver


def test_the_dual_answers_where_a_program_ends_short():
    """With ever more iterations of Clarabel: nothing, then by the dual, then by the program itself; λ of wall
    2 is .58000 (Gilbert, Casapulla & Ahmed 2006, Table 1: .58000)."""
    problem, solver = assemble(mo.load(WALLS[1])).problem, find_solver("cvxpy", None)
    found = []
    for most in range(10, 15):
        short = replace(solver, options=solver.options | {"max_iter": most})
        found.append(associative(Task(problem, short), "kinematic"))
    by_dual = [Code.BY_DUAL in [said.code for said in one.reasons] for one in found]
    assert found[0].load_factor is None
    assert any(by_dual)
    assert not by_dual[-1]
    for one in (found[by_dual.index(True)], found[-1]):
        assert one.load_factor == pytest.approx(0.58, abs=2e-5)
    (said,) = (said for said in found[by_dual.index(True)].reasons if said.code is Code.BY_DUAL)
    assert said.values["formulation"] == "static"

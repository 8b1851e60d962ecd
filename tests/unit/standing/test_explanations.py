"""Why there is no load factor: the blocks and joints that are named, in codes and in pictures."""

import numpy as np
import pytest
from scenes import values_of

import masonry_opt as mo
from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Found, certified
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.answer.solution import Solution
from masonry_opt.drawing.elements import KINDS
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import assemble
from masonry_opt.result import make_result
from masonry_opt.solvers.registry import find_solver


def slot(blocks: int) -> mo.Scene:
    """Blocks in a row between a floor and a roof, the first pushed along; another stands outside."""
    row = [
        mo.Block(
            name=f"b{number}",
            vertices=[(number, 0), (number + 1, 0), (number + 1, 1), (number, 1)],
            weight=1,
            live=(0 if number else 1, 0),
        )
        for number in range(blocks)
    ]
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.5),
        blocks=[
            *row,
            mo.Block(name="outside", vertices=[(-5, 0), (-4, 0), (-4, 1), (-5, 1)], weight=1),
            mo.Block(name="floor", vertices=[(-9, -1), (20, -1), (20, 0), (-9, 0)], fixed=True),
            mo.Block(name="roof", vertices=[(-2, 1), (20, 1), (20, 2), (-2, 2)], fixed=True),
        ],
    )


def pairs(result):
    """The joints named, by the names of their blocks."""
    named = values_of(result, Code.JOINTS)
    assert named["status"] == str(result.status)
    return [tuple(pair) for pair in named["pairs"]]


@pytest.mark.parametrize("blocks", [1, 4])
def test_dilatancy_names_the_joints_that_lock_and_no_others(blocks):
    """Each of the row between floor and roof; the block outside has no part in it."""
    result = mo.solve(slot(blocks), "static")
    assert result.status is Status.LOCKED
    expected = {(f"b{number}", other) for number in range(blocks) for other in ("floor", "roof")}
    assert set(pairs(result)) == expected
    assert values_of(result, Code.DILATANCY_LOCKS) == {}


@pytest.mark.parametrize(
    ("status", "moves"), [*((status, True) for status in Status), (Status.UNSTABLE, False)]
)
def test_every_status_can_be_drawn(status, moves):
    assembly = assemble(slot(2))
    problem = assembly.problem
    q, d = np.ones(3 * problem.joints), np.linspace(-1, 1, 3 * problem.blocks)
    found = Found(q=q, d=d) if moves else Found()
    found = certified(problem, 0.5, q, d) if status.usable else found
    solution = Solution(status, Kind.ASSOCIATIVE, found=found)
    result = make_result(assembly, solution, Effort(), "static", find_solver("cvxpy", None))
    # Of an answer, and of what falls, in every kind.
    for kind in KINDS if status in (Status.OPTIMAL, Status.UNSTABLE) else KINDS[:1]:
        title = result.plot(kind).axes[0].get_title()
        assert (f"no load factor ({status})" in title) != status.usable

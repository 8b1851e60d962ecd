"""Corner walls and façades: associative values of another program, incremental load factors of contact
dynamics, and the lowest exact states known."""

from collections.abc import Callable

import pytest
from scenes import solved
from second_program import bounds
from space.reference_values import REFERENCES, Reference

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.alternation import Alternation
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.laws import Cone
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Code

#: Blocks and friction of the wall of fast tests; blocks of the largest whose exact states are asked for.
FAST, MOST = (13, 0.6), 42
#: Blocks and friction of the corner whose blocks still move after many steps under loads 1 % apart.
IN_A_RANGE = 42, 0.6


def corners(sizes: Callable[[Reference], bool]) -> list[object]:
    found = [reference for reference in REFERENCES if sizes(reference)]
    marks = [() if (each.blocks, each.friction) == FAST else (pytest.mark.slow,) for each in found]
    return [pytest.param(each, marks=mark, id=str(each)) for each, mark in zip(found, marks, strict=True)]


@pytest.mark.parametrize("reference", corners(lambda wall: True))
def test_associative_load_factor_is_that_of_cones_declared_directly(reference):
    """By a program whose units are not scaled: on walls of 100 and 231 blocks it ends up to 6e-6 below, where
    statics and kinematics here agree to 3e-9."""
    found = solved(reference.scene, "static")
    problem = found.assembly.problem
    assert (problem.blocks, problem.joints) == (reference.blocks, reference.points)
    near = 2e-6 if reference.blocks < 100 else 1e-5
    assert found.load_factor == pytest.approx(reference.associative, abs=near)


@pytest.mark.parametrize("reference", corners(lambda wall: wall.blocks <= 20))
def test_associative_load_factor_by_polygons_is_that_of_another_program(reference):
    """By HiGHS, inside the cones; as many sides, a corner along each direction of shear."""
    inside = bounds(assemble(reference.scene)).inside
    found = mo.solve(reference.scene, "static", model="pyomo", solver="highs-ipm")
    assert found.load_factor == pytest.approx(inside, abs=2e-6)


@pytest.mark.parametrize("reference", corners(lambda wall: wall.carried is not None))
def test_the_incremental_load_factor_is_that_of_contact_dynamics(reference):
    """Within 1 %; a load increment there is .3 % of the least. By the cone, exact: what blocks move on with
    for ever is a state of rigid ones.

    Rigid blocks in LMGC90 begin to leave within 4 % of it. The corner of 42 blocks is 3.6 % above LMGC90
    (with smaller increments 2.7 to 3.6 %) and 0.3 % above contact dynamics.
    """
    found = solved(reference.scene, "incremental")
    assert found.incremental == pytest.approx(reference.carried, rel=1e-2)
    if reference.lmgc90 is not None:
        assert found.incremental == pytest.approx(reference.lmgc90, rel=4e-2)
    if reference.incremental is not None:
        assert found.incremental == pytest.approx(reference.incremental, rel=2e-2)
    assert found.incremental < reference.associative + 1e-6
    if (reference.blocks, reference.friction) == IN_A_RANGE:
        assert found.reasons[0].code is Code.RANGE
    elif reference.blocks <= MOST:
        assert found.reasons[0].code is Code.COLLAPSE
        assert found.solution.answer.forms.friction is Cone
        assert not found.solution.answer.failing(Kind.EXACT)
        assert len(found.history) <= 80


@pytest.mark.parametrize("reference", corners(lambda wall: wall.blocks <= MOST))
def test_default_is_exact_and_as_low_as_the_lowest_known(reference):
    """At or below 1.10 times the lowest exact states that are known, and never the associative value."""
    result = solved(reference.scene, incremental=True)
    answer = result.solution.answer
    assert answer.forms.friction is Cone
    assert not answer.failing(Kind.NEARLY_COMPLEMENTARY)
    assert answer.slope == pytest.approx(0)
    assert result.load_factor < reference.associative + 1e-6
    assert result.associative == pytest.approx(reference.associative, abs=1e-5)
    if reference.wall.__name__ == "corner_wall":
        # Of these walls the flow rule decides: nothing associative is called Coulomb's.
        assert result.load_factor < result.incremental < 0.95 * result.associative
        assert result.exact
    if reference.least is not None:
        assert result.load_factor <= 1.10 * reference.least


@pytest.mark.slow
def test_a_facade_of_231_blocks_is_exact():
    """Its mechanism leaves 2.5e-8 of λ where solvers end at an absolute gap of its bare energy."""
    wall = next(each for each in REFERENCES if (each.blocks, each.friction) == (231, 0.6))
    found = solved(wall.scene, "incremental")  # an earlier test compares its load factor
    problem, history = found.assembly.problem, found.solution.load_history
    _, forces = history.state_at(0.9 * history.load_factors[-1])
    answer = Alternation(problem, Effort()).state_near(forces)
    assert answer is not None
    assert answer.forms.friction is Cone
    assert not answer.failing(Kind.EXACT)

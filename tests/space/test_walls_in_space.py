"""Corner walls and façades in space compared with independent programs.

The programs gave associative load factors, incremental load factors by contact dynamics, and exact states.
"""

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

#: Number of blocks and friction of the wall in fast tests.
FAST = (13, 0.6)
#: Largest number of blocks of a wall whose exact states are tested.
MOST = 42
#: Blocks and friction of the corner whose load history ends in a range, because its blocks move slowly.
IN_A_RANGE = 42, 0.6


def corners(sizes: Callable[[Reference], bool]) -> list[object]:
    found = [reference for reference in REFERENCES if sizes(reference)]
    marks = [() if (each.blocks, each.friction) == FAST else (pytest.mark.slow,) for each in found]
    return [pytest.param(each, marks=mark, id=str(each)) for each, mark in zip(found, marks, strict=True)]


@pytest.mark.parametrize("reference", corners(lambda wall: True))
def test_associative_load_factor_is_that_of_cones_declared_directly(reference):
    """The associative load factor is that of an independent program with cones, to 2e-6.

    From 100 blocks on, the tolerance is 1e-5. The other program does not scale its units and ends up to 6e-6
    lower, while statics and kinematics of the package agree to 3e-9.
    """
    found = solved(reference.scene, "static")
    problem = found.assembly.problem
    assert (problem.blocks, problem.joints) == (reference.blocks, reference.points)
    near = 2e-6 if reference.blocks < 100 else 1e-5
    assert found.load_factor == pytest.approx(reference.associative, abs=near)


@pytest.mark.slow
@pytest.mark.parametrize("reference", corners(lambda wall: wall.blocks <= 20))
def test_associative_load_factor_by_polygons_is_that_of_another_program(reference):
    """The associative load factor by polygons inside the cones is that of an independent program, to 2e-6.

    Both programs use HiGHS and the same number of sides, with a corner in the direction of each shear.
    """
    inside = bounds(assemble(reference.scene)).inside
    found = mo.solve(reference.scene, "static", model="pyomo", solver="highs-ipm")
    assert found.load_factor == pytest.approx(inside, abs=2e-6)


@pytest.mark.parametrize("reference", corners(lambda wall: wall.carried is not None))
def test_the_incremental_load_factor_is_that_of_contact_dynamics(reference):
    """The incremental load factor is that of contact dynamics, to 1 %, and its final state is exact by cones.

    A load increment of contact dynamics is 0.3 % of the smallest load factor. The load at which rigid blocks
    in LMGC90 begin to move agrees to 4 %. The corner of 42 blocks is 3.6 % above LMGC90 (2.7 to 3.6 % with
    smaller increments) and 0.3 % above contact dynamics.
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


@pytest.mark.slow
@pytest.mark.parametrize("reference", corners(lambda wall: wall.blocks <= MOST))
def test_default_is_exact_and_as_low_as_the_lowest_known(reference):
    """The default's state is exact, at most 1.10 times the lowest known one, and below the associative λ."""
    result = solved(reference.scene, incremental=True)
    answer = result.solution.answer
    assert answer.forms.friction is Cone
    assert not answer.failing(Kind.NEARLY_COMPLEMENTARY)
    assert answer.slope == pytest.approx(0)
    assert result.load_factor < reference.associative + 1e-6
    assert result.associative == pytest.approx(reference.associative, abs=1e-5)
    if reference.wall.__name__ == "corner_wall":
        # On these walls the flow rule matters: the Coulomb load factors are well below the associative one.
        assert result.load_factor < result.incremental < 0.95 * result.associative
        assert result.exact
    if reference.least is not None:
        assert result.load_factor <= 1.10 * reference.least


@pytest.mark.slow
def test_a_facade_of_231_blocks_is_exact():
    """A façade of 231 blocks has an exact state near the forces at 0.9 of its load history.

    If solvers stopped at an absolute gap of the unscaled energy, the residual would be 2.5e-8 of λ.
    """
    wall = next(each for each in REFERENCES if (each.blocks, each.friction) == (231, 0.6))
    found = solved(wall.scene, "incremental")  # an earlier test compares its load factor
    problem, history = found.assembly.problem, found.solution.load_history
    _, forces = history.state_at(0.9 * history.load_factors[-1])
    answer = Alternation(problem, Effort()).state_near(forces)
    assert answer is not None
    assert answer.forms.friction is Cone
    assert not answer.failing(Kind.EXACT)

"""The search for exact states with cones ends at its deadline, and without a state if programs fail."""

import pytest
from scenes import values_of
from scenes_in_space import corner_wall

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.alternation import Alternation
from masonry_opt.methods.exact.refiner import ConeRefiner, RefinerTimeout
from masonry_opt.solution.reasons import Code
from masonry_opt.solvers.cvxpy_engine import CvxpyEngine

WALL = corner_wall(2, 2, 2)


def cone_refiner(problem):
    effort = Effort()
    return ConeRefiner(problem, effort, Alternation(problem, effort))


@pytest.fixture(scope="module")
def start():
    return mo.solve(WALL, "incremental")


def test_it_ends_after_the_program_in_which_its_deadline_passes(watched, start):
    refiner = cone_refiner(start.assembly.problem)
    programs = watched(CvxpyEngine, "solve", lambda _: setattr(refiner, "deadline", 0.0))
    with pytest.raises(RefinerTimeout):
        refiner.state_near(start.solution.q)
    assert len(programs) == 1


def test_no_state_where_no_program_ends(failing, start):
    failing("cvxpy")
    refiner = cone_refiner(start.assembly.problem)
    assert refiner.state_near(start.solution.q) is None


@pytest.mark.slow
def test_a_search_without_time_says_so():
    searched = mo.solve(WALL, "coulomb", search=1e-9)
    assert values_of(searched, Code.NO_TIME) == {}

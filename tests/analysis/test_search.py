"""The search for lower exact states: where it ends, that it is repeatable, and that it can be stopped."""

from itertools import islice

import pytest
from scenes import WALLS, small_wall, two_blocks, values_of

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.refiner import Refiner
from masonry_opt.methods.exact.search import Search, StateRecord
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Code

#: Largest residual of an exact state.
EXACT = 1e-8

WALL_5 = WALLS[4]


def visited(result):
    """Return the states that lowered λ: number of the candidate, its origin, and λ."""
    return list(result.history[["candidate", "origin", "load_factor"]].itertuples(index=False, name=None))


@pytest.mark.slow
def test_a_search_ends_where_it_was_to_come():
    """A search ends at the first state at or below ``until``, although its time limit is ten minutes.

    The first state of wall 5 is at 0.20863, and the second state is below 0.208.
    """
    first = mo.solve(WALL_5, "coulomb", search=600.0, until=0.209)
    second = mo.solve(WALL_5, "coulomb", search=600.0, until=0.208)
    assert len(first.history) == 1
    assert first.load_factor > 0.208
    assert (second.history["load_factor"].iloc[:-1] > 0.208).all()
    assert second.load_factor <= 0.208
    assert values_of(second, Code.SEARCHED)["candidates"] == second.history["candidate"].iloc[-1]


@pytest.mark.slow
def test_one_seed_visits_the_same_states_and_the_time_decides_how_far():
    long, short = (mo.solve(small_wall(), "coulomb", search=seconds, seed=3) for seconds in (0.4, 0.2))
    common = min(len(long.history), len(short.history))
    assert visited(long)[:common] == visited(short)[:common]
    assert long.load_factor <= short.load_factor


@pytest.mark.slow
def test_a_search_stopped_at_any_time_has_a_whole_answer():
    seconds = 0.02
    result = mo.solve(small_wall(), "coulomb", search=seconds)
    assert result.status is mo.Status.CONVERGED
    assert result.kind in (Kind.EXACT, Kind.NEARLY_COMPLEMENTARY)
    assert result.certificate.worst < (EXACT if result.kind is Kind.EXACT else 1e-6)
    # Not counted: the load history, the models, and the program that runs when the time is over.
    assert sum(result.seconds.values()) < seconds + 5


@pytest.mark.parametrize(
    "joints",
    [{"cohesion": 0.05}, pytest.param({"dilatancy": 0.1}, marks=pytest.mark.slow)],
    ids=["cohesion", "dilatancy"],
)
def test_every_kind_of_candidate_suits_joints_of_every_kind(joints):
    """In the first 24 candidates of a search, each kind of candidate leads to at least one exact state."""
    problem = assemble(small_wall(3, 2, **{"friction": 0.5} | joints)).problem
    search = Search(Refiner(problem, Effort()), IncrementalAnalysis(problem), StateRecord(LoadFactorScale()))
    tried = list(islice(search.endless(None, 0), 24))
    assert {origin for origin, state in tried if state} == {origin for origin, _ in tried}
    assert max(state.answer.certificate.worst for _, state in tried if state) < EXACT


def test_a_start_is_repeated_if_the_solver_left_programs_undecided(monkeypatch):
    """A start whose first attempt leaves a program undecided is repeated, and its state is then stored."""
    problem = assemble(two_blocks()).problem
    refiner, q = Refiner(problem, Effort()), mo.solve(two_blocks(), "static").solution.q
    lowest_from, attempts = refiner._lowest_from, []

    def attempted(first):
        state = lowest_from(first)
        attempts.append(first)
        refiner.undecided = int(len(attempts) == 1)
        return None if refiner.undecided else state

    monkeypatch.setattr(refiner, "_lowest_from", attempted)
    found = [(refiner.state_near(q), refiner.undecided) for _ in range(3)]
    assert found[0] == (None, 1)
    assert found[1][0].load_factor == pytest.approx(0.15, rel=1e-9)
    assert found[2] == (found[1][0], 0)
    assert len(attempts) == 2

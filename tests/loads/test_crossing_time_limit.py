"""The time limit of a crossing: it is that of all positions, and the worst position by then is the answer."""

import time

import pytest
from loads.overhang import OVERHANG, WEIGHT, axles

import masonry_opt as mo
from masonry_opt.deadline import TimeLimitReached
from masonry_opt.errors import TimeLimitError
from masonry_opt.studies.crossing import crossing as module
from masonry_opt.studies.crossing.search import PassageTrials

LOADED = OVERHANG.replace(axles=[axles(3.0)])


def ends_at(number, known, error=None):
    """Progress of a crossing whose time is over after some positions; ``known`` records their λ."""

    def ends(position, load_factor):
        known[position] = load_factor
        if len(known) == number:
            raise error or TimeLimitReached(7.0)

    return ends


@pytest.fixture
def slow_positions(monkeypatch):
    """Each position takes a fiftieth of a second."""
    solved = PassageTrials.of

    def slow(trials, live):
        time.sleep(0.02)
        return solved(trials, live)

    monkeypatch.setattr(PassageTrials, "of", slow)


def test_the_limit_is_that_of_all_positions(slow_positions):
    """All positions need 2 s, and each of them much less than the limit of .4 s."""
    began = time.perf_counter()
    found = mo.crossing(LOADED, method="static", time_limit=0.4)
    assert time.perf_counter() - began < 0.8
    assert found.time_limit_reached
    assert 1 <= len(found.table) < 25


@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_the_worst_position_by_then_is_the_answer(method):
    """An axle of 3 at x turns the slab about the edge at .5: λ 3 (|x| - .5) = .5 · 12."""
    known = {}
    found = mo.crossing(LOADED, method=method, incremental=False, progress=ends_at(3, known))
    assert found.time_limit_reached
    assert found.interrupted
    assert sorted(found.table["position"]) == sorted(known)
    assert found.load_factor == pytest.approx(min(known.values()), rel=1e-9)
    assert found.load_factor == pytest.approx(0.5 * WEIGHT / (3 * (abs(found.position) - 0.5)), rel=1e-6)
    assert found.bound is None
    assert found.as_dict()["time_limit_reached"] is True
    assert found.facts()["stopped"] == (
        "by the time limit of 7 s; λ may be less at positions that were not solved"
    )


def test_a_stopped_crossing_decides_nothing_about_a_factor_that_it_reaches_so_far():
    with_factor = mo.crossing(LOADED, method="static", required_factor=0.1, progress=ends_at(3, {}))
    assert "not decided, because the time limit ended the crossing" in with_factor.facts()["required"]


def test_a_coulomb_method_solves_the_worst_associative_position_first():
    """It is the end of the slab, so the answer does not change after one of the positions."""
    found = mo.crossing(LOADED, progress=ends_at(1, {}))
    assert found.load_factor == pytest.approx(WEIGHT / 3, rel=1e-6)
    assert abs(found.position) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize(
    ("stop", "error"), [(TimeLimitReached(7.0), TimeLimitError), (KeyboardInterrupt(), KeyboardInterrupt)]
)
def test_before_a_coulomb_answer_the_least_upper_bound_is_stated(monkeypatch, stop, error):
    """The associative load factors of the whole road are known, and no other."""

    def ends(*_):
        raise stop

    monkeypatch.setattr(module.search, "least_coulomb", ends)
    known = r"no position was solved with method 'coulomb'; least associative load factor at \d+ positions"
    with pytest.raises(error, match=known + ": 4.000000, an upper bound of λ"):
        mo.crossing(LOADED)


def test_the_last_solve_may_find_the_time_over(watched):
    """The worst position is solved again for its incremental load factor, which is then missing."""

    def ends(*_):
        if len(solved) == 2:
            raise TimeLimitReached(7.0)

    solved = watched(module.Session, "solve", ends)
    found = mo.crossing(LOADED, method="static")
    assert len(solved) == 2
    assert found.time_limit_reached
    assert found.load_factor == pytest.approx(WEIGHT / 3, rel=1e-6)


def test_time_that_is_over_before_the_first_position_is_an_error():
    with pytest.raises(TimeLimitError, match="the time limit of 1e-09 s ended"):
        mo.crossing(LOADED, time_limit=1e-9)


def test_the_command_prints_the_answer_and_ends_with_exit_code_1(slow_positions, command, tmp_path):
    mo.save(LOADED, tmp_path / "overhang.toml")
    arguments = "crossing", tmp_path / "overhang.toml", "--method", "static", "--time-limit", "0.5"
    answer = command.json(*arguments, code=1)
    assert answer["time_limit_reached"] is True
    assert answer["load_factor"] >= 4.0 - 1e-6

"""Tests of the time limit of a crossing: all positions share it, and the worst solved position is the
answer."""

from dataclasses import replace

import numpy as np
import pytest
from loads.overhang import OVERHANG, WEIGHT, axles
from settled_scenes import SINKS, beam

import masonry_opt as mo
from masonry_opt.deadline import TimeLimitReached
from masonry_opt.effort import Effort
from masonry_opt.errors import TimeLimitError
from masonry_opt.solution.stopped import with_answer
from masonry_opt.studies.crossing import crossing as module

LOADED = OVERHANG.replace(axles=[axles(3.0)])
#: The axles count twice in case a, and once in case b.
IN_TWO_CASES = LOADED.replace(
    load_cases=[mo.LoadCase(name=name, live={"axles": factor}) for name, factor in (("a", 2), ("b", 1))]
)


def ends_at(number, known, error=None):
    """Return a progress callback that ends a crossing after some positions; ``known`` records their λ."""

    def ends(position, load_factor):
        known[position] = load_factor
        if len(known) == number:
            raise error or TimeLimitReached(7.0)

    return ends


def by_hand(axle, position):
    """Return λ of an axle at x, which turns the slab about the edge at 0.5: λ P (|x| - 0.5) = 0.5 W."""
    return 0.5 * WEIGHT / (axle * (abs(position) - 0.5))


@pytest.fixture
def time_is_over_at(clock, watched):
    """Return a function that lets the limit of 100 s be over in the given solve of a session."""

    def of(number):
        def advance(*_):
            if len(assembled) == number:
                clock.now += 100.0

        assembled = watched(module.Session, "_assembled", advance)

    return of


def test_the_limit_is_that_of_all_positions(slow_positions):
    """Each position takes 10 s of the clock, so ten positions are solved within 100 s."""
    found = mo.crossing(LOADED, method="static", time_limit=100)
    assert slow_positions.now == 100.0
    assert found.time_limit_reached
    assert found.time_limit == 100
    assert len(found.table) == 10


@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_the_worst_position_by_then_is_the_answer(method):
    known = {}
    found = mo.crossing(LOADED, method=method, incremental=False, progress=ends_at(3, known))
    assert found.time_limit_reached
    assert found.interrupted
    assert sorted(found.table["position"]) == sorted(known)
    assert found.load_factor == pytest.approx(min(known.values()), rel=1e-9)
    assert found.load_factor == pytest.approx(by_hand(3, found.position), rel=1e-6)
    assert found.bound is None
    assert found.as_dict()["time_limit_reached"] is True
    assert found.facts()["stopped"] == (
        "by the time limit of 7 s; λ may be less at positions that were not solved"
    )
    # The solve of the worst position itself was completed.
    assert not found.worst.time_limit_reached
    assert not found.worst.solution.interrupted
    assert str(found).count("time limit") == 1
    # The λ so far is no capacity.
    assert found.capacity == []
    assert not {"governing λ", "at collapse"} & {*found.facts()}


def test_a_stopped_crossing_decides_nothing_about_a_factor_that_it_reaches_so_far():
    with_factor = mo.crossing(LOADED, method="static", required_factor=0.1, progress=ends_at(3, {}))
    assert "not decided, because the time limit ended the crossing" in with_factor.facts()["required"]


def test_a_coulomb_method_solves_the_worst_associative_position_first():
    """The first solved position is the end of the slab, where λ is least, so that its answer is final."""
    found = mo.crossing(LOADED, progress=ends_at(1, {}))
    assert found.load_factor == pytest.approx(WEIGHT / 3, rel=1e-6)
    assert abs(found.position) == pytest.approx(1, abs=1e-6)


def test_load_cases_solved_before_the_limit_are_not_lost(time_is_over_at):
    """Case "a" was solved before the limit and case "b" was not, so that "a" governs; its axles count
    twice."""
    time_is_over_at(2)
    found = mo.crossing(IN_TWO_CASES, method="static", time_limit=100)
    assert (found.worst.load_case, found.not_crossed) == ("a", ["b"])
    assert found.load_factor == pytest.approx(by_hand(6, found.position), rel=1e-6)
    assert found.facts()["stopped"] == (
        "by the time limit of 100 s; λ may be less at positions that were not solved; load cases that were "
        "not reached: 'b'"
    )


@pytest.mark.parametrize("error", [TimeLimitError("over"), KeyboardInterrupt()])
def test_an_error_in_a_later_load_case_loses_no_earlier_case(watched, error):
    def ends(*_):
        if len(solved) == 2:
            raise error

    solved = watched(module.Session, "solve", ends)
    found = mo.crossing(IN_TWO_CASES, method="static", time_limit=100)
    assert (found.interrupted, found.time_limit_reached) == (True, isinstance(error, TimeLimitError))
    assert found.by_case["a"] == found.load_factor == pytest.approx(by_hand(6, found.position), rel=1e-6)
    assert found.by_case["b"] is None


def test_a_case_with_a_lower_state_governs_although_another_case_was_stopped(monkeypatch):
    """Case "a" governs although the limit ended the search for lower states in case "b", whose λ is twice
    as large."""
    answer = module.Session.answer

    def stopped(session, scene, progress, effort):
        assembly, solution = answer(session, scene, progress, effort)
        if scene.load_case.name == "b":
            solution = with_answer(solution, TimeLimitReached(100.0), effort)
        return assembly, solution

    monkeypatch.setattr(module.Session, "answer", stopped)
    found = mo.crossing(IN_TWO_CASES, method="static", time_limit=100)
    assert found.time_limit == 100
    assert found.worst.load_case == "a"
    assert found.not_crossed == []
    assert found.by_case["b"] == pytest.approx(2 * found.by_case["a"], rel=1e-6)


def test_a_limit_in_the_first_solve_is_an_error(time_is_over_at):
    time_is_over_at(1)
    with pytest.raises(TimeLimitError, match=r"100 s ended the crossing: method 'static' had not yet solved"):
        mo.crossing(LOADED, method="static", time_limit=100)


def test_an_error_at_the_limit_has_the_warnings_about_the_scene(time_is_over_at):
    """A coefficient of friction of 31 is probably an angle in degrees."""
    in_degrees = LOADED.replace(joints={"friction": 31})
    expected = mo.crossing(in_degrees, method="static").worst.warning_sentences
    assert any("degrees" in sentence for sentence in expected)
    time_is_over_at(1)
    with pytest.raises(TimeLimitError) as stopped:
        mo.crossing(in_degrees, method="static", time_limit=100)
    assert stopped.value.warnings == expected
    assert "warning" not in stopped.value.message


def test_ctrl_c_in_the_first_solve_is_an_interrupt(watched):
    def ends(*_):
        raise KeyboardInterrupt

    watched(module.Session, "solve", ends)
    with pytest.raises(KeyboardInterrupt, match="method 'static' had not yet solved any position"):
        mo.crossing(LOADED, method="static")


def test_ctrl_c_is_not_taken_for_the_time_limit_of_a_method():
    """Method "global" has its own time limit, which may end its solve of the worst position."""
    whole = mo.crossing(LOADED, method="static")
    solution = with_answer(whole.worst.solution, TimeLimitReached(60.0), Effort())
    found = replace(whole, worst=replace(whole.worst, solution=solution), interrupted=True)
    assert found.worst.time_limit_reached
    assert not found.time_limit_reached
    assert "stopped" not in found.facts()
    assert "λ may be less" in found.facts()["interrupted"]


def test_the_limit_may_end_the_solve_of_the_default_method(time_is_over_at):
    """The third solve is that of the default method; the crossing itself is complete.

    The first two solves are those of the first and of the worst position.
    """
    time_is_over_at(3)
    found = mo.crossing(LOADED, method="static", time_limit=100)
    assert found.default is None
    assert found.no_default == "the time limit of 100 s ended the solve"
    assert found.as_dict()["no_default"] == found.no_default
    assert "not compared with the default method: the time limit of 100 s ended the solve" in str(found)
    assert not found.interrupted
    assert found.bound is not None


def test_a_load_factor_that_the_default_method_has_by_the_limit_is_compared():
    whole = mo.crossing(LOADED, method="static")
    solution = with_answer(whole.default.solution, TimeLimitReached(100.0), Effort())
    found = replace(whole, default=replace(whole.default, solution=solution))
    assert "4.000000 at the worst position, when the time limit ended the search: the same as" in str(found)


def test_a_stopped_crossing_of_a_settled_bridge_draws_the_axle_loads():
    """The forces that pictures draw on blocks have the resultants of the problem's loads."""
    scene = beam(live=(0, 0)).replace(axles=[axles(3.0, road=[(0, 2), (5, 2)])])
    found = mo.crossing(scene, method="static", settled=SINKS, progress=ends_at(3, {}))
    assert found.time_limit_reached
    assembly = found.worst.assembly
    problem, live = assembly.problem, assembly.block_loads.live
    scale = problem.force_unit * np.array([1.0, 1.0, problem.length_unit])
    expected = problem.by_block(problem.live) * scale
    assert np.abs(expected).max() > 1.0
    resultants = live.about(assembly.geometry.centroid[assembly.movable])
    np.testing.assert_allclose(resultants.reshape(-1, 3), expected, atol=1e-9)


@pytest.mark.parametrize(
    ("stop", "error"), [(TimeLimitReached(7.0), TimeLimitError), (KeyboardInterrupt(), KeyboardInterrupt)]
)
def test_before_a_coulomb_answer_the_least_upper_bound_is_stated(monkeypatch, stop, error):
    """By then only associative load factors are known, for the whole road; the error states the least of
    them."""

    def ends(*_):
        raise stop

    monkeypatch.setattr(module.search, "least_coulomb", ends)
    known = r"method 'coulomb' had not yet solved .*; λ is at most 4.000000, the least of the"
    with pytest.raises(error, match=known + r" associative load factors at \d+ positions"):
        mo.crossing(LOADED)


def test_the_last_solve_may_find_the_time_over(watched):
    """The worst position is solved a second time for its incremental load factor, which the time limit
    ends."""

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
    arguments = "crossing", tmp_path / "overhang.toml", "--method", "static", "--time-limit", "100"
    answer = command.json(*arguments, code=1)
    assert answer["time_limit_reached"] is True
    assert answer["load_factor"] >= 4.0 - 1e-6


@pytest.mark.slow
def test_a_report_of_a_stopped_crossing_ends_with_exit_code_1(slow_positions, command, tmp_path):
    """The report is written with the worst position so far."""
    mo.save(LOADED, tmp_path / "overhang.toml")
    limited = "report", tmp_path / "overhang.toml", "--method", "static", "--time-limit", "100"
    page = tmp_path / "page.html"
    command(*limited, "--out", page, code=1)
    assert "λ may be less at positions that were not solved" in page.read_text("utf-8")

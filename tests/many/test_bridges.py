"""Tests of axles that cross the scene of each run: sweeps, samples and thresholds, by hand and by crossings.

On the slab of ``loads.overhang``, an axle P turns the slab about the edge of its support. The edge is 0.5
from the middle of the slab, which extends 0.5 beyond the edge: λ P 0.5 = 0.5 W.
"""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from loads.overhang import OVERHANG, WEIGHT, axles, support
from speeds import slow

import masonry_opt as mo
from masonry_opt.analysis import prepare
from masonry_opt.errors import NoLoadFactorError, TimeLimitError
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.solution import Solution
from masonry_opt.studies.many.charts import drawings
from masonry_opt.studies.many.run_warnings import warnings_of_falls
from masonry_opt.studies.many.runs import is_outdated, run_scene
from masonry_opt.studies.many.sample import Sample
from masonry_opt.studies.many.scene_answer import SceneAnswer
from masonry_opt.studies.many.sweep import summary_text
from masonry_opt.studies.run_columns import CROSSED_RUNS, CROSSING_COLUMNS, RUN_COLUMNS, framed

WITH_AXLES = OVERHANG.replace(axles=[axles(3.0)])
STATIC = {"method": "static", "workers": 1}


def in_two_cases():
    """Return the slab with axles in two load cases, λ = 0.9 W / 4.5 and W / 9 by hand, and a third without
    axles."""
    crowd = mo.Load(block="slab", live=(0.0, -6.0), at=(1.0, 0.5), group="crowd")
    cases = [
        mo.LoadCase(name="alone", dead={"weight": 0.9}, live={"axles": 1.5}),
        mo.LoadCase(name="crowd too", live={"axles": 2.0, "crowd": 0.5}),
        mo.LoadCase(name="crowd", live={"crowd": 1.0}),
    ]
    return WITH_AXLES.replace(loads=[crowd], load_cases=cases)


@pytest.mark.parametrize(
    ("name", "values", "by_hand"),
    [
        ("block.slab.weight", [6.0, 12.0, 30.0], [2.0, 4.0, 10.0]),
        ("axles.a.factor", [0.5, 2.0], [8.0, 2.0]),
        *slow(("axles.loads.1", [3.0, 6.0], [4.0, 2.0])),
        ("axles.a.loads.1", [3.0, 6.0], [4.0, 2.0]),
        ("axles.width", [1.0, 4.0], [4.0, 16.0]),
    ],
)
def test_each_run_is_the_least_of_all_positions(name, values, by_hand):
    """The load factor of a run is that of the worst position, the end of the slab: λ P 0.5 = 0.5 W.

    P is the axle load times its factor, divided by its width.
    """
    table = mo.sweep(WITH_AXLES, {name: values}, **STATIC)
    assert table["load_factor"].to_list() == pytest.approx(by_hand, rel=1e-6)
    assert table["position"].abs().to_list() == pytest.approx([1.0] * len(values), abs=1e-6)
    assert [*table] == [name, *RUN_COLUMNS, *CROSSING_COLUMNS]
    assert {*table["axles"]} == {"a"}
    assert (table["bound"] <= table["load_factor"] * (1 + 1e-9)).all()
    assert (table["undecided_positions"] == 0).all()
    summary = summary_text(table, [name])
    assert CROSSED_RUNS in summary
    assert "with 'a' at -1" in summary
    assert CROSSED_RUNS in drawings(table, [name])[0].notes


def test_other_live_loads_act_too():
    """A live load of 6 at the end of the slab acts together with the axle: λ (3 + 6) 0.5 = 0.5 W."""
    loaded = WITH_AXLES.replace(blocks={"slab": {"live": (0.0, -6.0), "live_at": (1.0, 0.5)}})
    table = mo.sweep(loaded, {"joints.friction": [0.5, 0.6]}, **STATIC)
    assert table["load_factor"].to_list() == pytest.approx([WEIGHT / 9] * 2, rel=1e-6)
    assert (table["warnings"] == "").all()


def test_runs_without_moving_axles_are_solved_as_before():
    """Axles do not move in an earthquake or on tilted ground: the block slides on its floor at λ = μ."""
    shaken = WITH_AXLES.replace(earthquake={"direction": "left"})
    table = mo.sweep(shaken, {"joints.friction": [0.2, 0.3]}, **STATIC)
    assert table["load_factor"].to_list() == pytest.approx([0.2, 0.3])
    assert "position" not in table
    assert "this analysis ignores the axles 'a'" in table["warnings"].iloc[0]


@pytest.mark.slow
def test_the_least_of_all_load_cases_governs():
    scene = in_two_cases()
    table = mo.sweep(scene, {"block.slab.weight": [WEIGHT, 2 * WEIGHT]}, **STATIC)
    assert table["load_factor"].to_list() == pytest.approx([WEIGHT / 9, 2 * WEIGHT / 9], rel=1e-6)
    assert {*table["load_case"]} == {"crowd too"}
    (warning,) = table.attrs["warning_records"]
    assert (warning["code"], warning["cases"], warning["runs"]) == ("cases without axles", ["crowd"], 2)
    alone = mo.sweep(scene.in_case("alone"), {"block.slab.weight": [WEIGHT]}, **STATIC)
    assert alone["load_factor"].to_list() == pytest.approx([0.9 * WEIGHT / 4.5], rel=1e-6)
    fixed = mo.sweep(scene.in_case("crowd"), {"block.slab.weight": [WEIGHT]}, **STATIC)
    assert fixed["load_factor"].to_list() == pytest.approx([WEIGHT / 6], rel=1e-6)
    assert "position" not in fixed
    factors = mo.sweep(scene, {"load_case.alone.live.axles": [1.5, 6.0]}, **STATIC)
    assert factors["load_case"].to_list() == ["crowd too", "alone"]
    assert factors["load_factor"].to_list() == pytest.approx([WEIGHT / 9, 0.9 * WEIGHT / 18], rel=1e-6)


def small_bridge(voussoirs=6):
    """Return a small arch under fill that presses on its extrados, with an axle on the road.

    The road is three times as long as the bridge. Positions are at most a hundredth of the road apart, so
    that few positions are solved.
    """
    ring = mo.Arch(radius=2, angles=(150, 30), thickness=0.3, voussoirs=voussoirs, unit_weight=20)
    fill = mo.Fill(road=[(-1.7, 2.5), (1.7, 2.5)], unit_weight=18, friction_angle=30, mobilised=0.3)
    return mo.Scene(
        joints={"friction": 0.5},
        blocks=ring.blocks(),
        fills=[fill],
        axles=[axles(40.0, road=[(-5, 2.5), (5, 2.5)])],
    )


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("joints.friction", [0.3, 0.6]),
        pytest.param("fill.mobilised", [0.15, 0.9], marks=pytest.mark.slow),
        pytest.param("joints.strength", [500.0, 5000.0], marks=pytest.mark.slow),
        pytest.param("thickness", [0.5, 2.0], marks=pytest.mark.slow),
    ],
)
def test_a_sweep_of_a_bridge_equals_single_crossings(name, values):
    scene = small_bridge(voussoirs=3)
    table = mo.sweep(scene, {name: values}, **STATIC)
    changes = {
        "joints.friction": lambda value: {"friction": value},
        "joints.strength": lambda value: {"strength": value},
        "fill.mobilised": lambda value: {"fills": [scene.fills[0].replace(mobilised=value)]},
        "thickness": lambda value: {"thickness": value},
    }
    for value, run in zip(values, table.to_dict("records"), strict=True):
        alone = mo.crossing(scene.replace(**changes[name](value)), method="static")
        assert run["load_factor"] == pytest.approx(alone.load_factor, rel=1e-7)
        assert run["bound"] == pytest.approx(alone.bound, rel=1e-6)
        assert run["direction"] == alone.direction
        there = mo.solve(alone.least.passage.scene(run["position"]), "static")
        assert there.load_factor == pytest.approx(run["load_factor"], rel=1e-7)
    assert table["load_factor"].iloc[0] < table["load_factor"].iloc[1]


@pytest.mark.slow
def test_a_sweep_by_the_default_method_equals_single_crossings():
    scene = small_bridge(voussoirs=3)
    (run,) = mo.sweep(scene, {"joints.friction": [0.3]}, workers=1).to_dict("records")
    alone = mo.crossing(scene.replace(friction=0.3))
    assert run["load_factor"] == pytest.approx(alone.load_factor, rel=1e-6)
    assert run["incremental"] == pytest.approx(alone.worst.incremental, rel=1e-6)
    assert run["load_factor"] <= run["associative"] * (1 + 1e-6)


@pytest.mark.slow
def test_two_spans_by_friction():
    """λ = 3.2495 for μ = 0.3 and 4.2205 from μ = 0.4, by a linear program made from the geometry alone."""
    friction = [0.3, 0.4, 0.8]
    table = mo.sweep(Path(__file__).parent / "two_spans.toml", {"joints.friction": friction}, **STATIC)
    assert table["load_factor"].to_list() == pytest.approx([3.2495, 4.2205, 4.2205], abs=5e-5)
    assert table["mechanism"].to_list() == ["mixed", "hinging", "hinging"]


def test_a_sample_of_a_scene_with_axles():
    """λ = W / 3 in each run, and no slab falls."""
    found = mo.sample(WITH_AXLES, {"block.slab.weight": ("uniform", 6.0, 18.0)}, n=8, **STATIC)
    assert found.load_factors == pytest.approx(found.table["block.slab.weight"] / 3, rel=1e-6)
    assert (found.undecided, found.refused, found.falling) == (0, 0, 0)
    assert found.facts()["axles"] == CROSSED_RUNS
    assert found.sensitivity()["rank_correlation"].to_list() == pytest.approx([1.0])


def test_a_scene_that_falls_and_one_that_carries_any_load():
    """A slab whose weight acts beyond its support is unstable; a slab on a wide support carries any load."""
    off = OVERHANG.replace(blocks={"slab": {"weight_at": (0.6, 0.5)}}, axles=[axles(3.0)])
    fallen = mo.sweep(off, {"block.slab.weight": [6.0, 12.0]}, **STATIC)
    assert {*fallen["status"]} == {str(mo.Status.UNSTABLE)}
    assert fallen["position"].isna().all()
    assert "unstable" in summary_text(fallen, ["block.slab.weight"])
    wide = mo.Scene(joints={"friction": 0.5}, blocks=[OVERHANG["slab"], support(-3, 3)])
    held = wide.replace(axles=[axles(3.0, road=[(-1, 1), (1, 1)])])
    found = mo.sample(held, {"block.slab.weight": ("uniform", 6.0, 12.0)}, n=2, **STATIC)
    assert found.unlimited == 2


def test_an_undecided_position_is_not_hidden_by_any_load_elsewhere():
    whole = mo.crossing(WITH_AXLES, method="static")
    (one,) = whole.passages
    failed = Solution(mo.Status.SOLVER_FAILED, Kind.ASSOCIATIVE)
    unlimited = Solution(mo.Status.UNLIMITED, Kind.ASSOCIATIVE)
    trials = replace(one, answers={-0.2: unlimited, 0.9: failed})
    assert trials.position == 0.9
    crossed = replace(whole, passages=(trials,))
    (warning,) = SceneAnswer(crossed.worst, crossed).warning_records
    assert warning["code"] == "positions undecided"
    assert (warning["count"], warning["positions"]) == (1, [0.9])
    columns = SceneAnswer(crossed.worst, crossed).columns()
    assert (columns["positions"], columns["undecided_positions"]) == (2, 1)


@pytest.mark.slow
def test_the_least_weight_that_carries_the_axles():
    """λ = W / 3 is 2 at W = 6. A search without a load factor to be carried refuses axles."""

    def of(weight):
        return WITH_AXLES.replace(blocks={"slab": {"weight": weight}})

    found = mo.least(of, 1.0, 30.0, load=2.0, method="static")
    assert found.value == pytest.approx(6.0, rel=1e-5)
    assert found.holds.answer.crossing.axles == "a"
    assert found.as_dict()["holds"]["axles"] == "a"
    assert "with 'a' at -1, travelling right" in str(found)
    assert found.history["position"].abs().to_list() == pytest.approx([1.0] * found.evaluations, abs=1e-6)
    with pytest.raises(mo.OptionError, match="to the load factor to be carried"):
        mo.least(of, 1.0, 30.0)
    with pytest.raises(mo.OptionError, match="has load cases"):
        mo.least(lambda _: in_two_cases(), 1.0, 2.0)
    in_cases = mo.most(
        lambda w: in_two_cases().replace(axles=[axles(w)]), 1.0, 30.0, load=1.0, method="static"
    )
    assert in_cases.value == pytest.approx((WEIGHT - 3) / 2, rel=1e-5)  # By hand, (2 P + 3) 0.5 = 0.5 W.
    assert in_cases.warning_records[0]["code"] == "cases without axles"


def test_an_interrupted_crossing_of_a_study_is_no_answer(monkeypatch):
    """After Ctrl-C a crossing returns the positions solved so far; a study must not use them as its
    answer."""
    whole = mo.crossing(WITH_AXLES, method="static")
    interrupted = replace(whole, interrupted=True)
    monkeypatch.setattr("masonry_opt.studies.crossing.crossing.cross", lambda *_: interrupted)
    with pytest.raises(KeyboardInterrupt):
        mo.least(lambda _: WITH_AXLES, 1.0, 2.0, load=1.0, method="static")


def light_and_heavy(factor=1.0):
    """Return the slab with two groups of one axle: a load of ``factor``, and a load three times as large.

    The heavy axle governs: λ = W / (3 factor). For the light axle alone, λ is three times as large. Within 45
    s of ``slow_positions`` only the light axle moves, beginning at the end of the slab.
    """
    return OVERHANG.replace(axles=[axles(factor, name="light"), axles(3 * factor, name="heavy")])


def test_a_run_whose_crossing_was_stopped_is_not_complete(slow_positions):
    how = pickle.dumps(prepare("static", time_limit=45).how)
    row = run_scene(how, light_and_heavy())
    assert row["load_factor"] == pytest.approx(WEIGHT, rel=1e-6)
    assert (row["status"], row["reason"], row["any_load"]) == (str(mo.Status.TIME_LIMIT), "time limit", False)
    assert row["positions"] == 5
    # A command with more time repeats the run, and a command with the same time does not.
    assert [is_outdated(row, limit) for limit in (10, 45, 100, None)] == [False, False, True, True]
    complete = run_scene(pickle.dumps(prepare("static").how), WITH_AXLES)
    assert not is_outdated(complete, 100)
    (warning,) = [record for record in row["warned"] if record["code"] == "crossing stopped"]
    assert warning["seconds"] == 45
    assert warning["sentence"] == row["message"]
    assert row["message"].startswith(
        "the time limit of 45 s ended the crossing, and λ may be less at positions"
    )


@pytest.mark.parametrize("load", [2.0, 8.0])
def test_a_stopped_crossing_does_not_show_that_a_load_is_carried(slow_positions, load):
    """The threshold is W / (3 load), but only the upper bound λ ≤ W / factor is known at the time limit."""
    words = r"^at 0\.1: it could not be decided.*45 s ended the crossing"
    with pytest.raises(NoLoadFactorError, match=words):
        mo.most(light_and_heavy, 0.1, 10.0, load=load, method="static", time_limit=45)


def test_a_stopped_crossing_may_show_that_a_load_is_not_carried(slow_positions):
    """With axles of 10 and 30, λ ≤ W / 10 = 1.2, so that a load of 2 is not carried; the next scene is
    undecided."""
    tried = []
    given = {"method": "static", "time_limit": 45, "progress": tried.append}
    with pytest.raises(NoLoadFactorError, match=r"^at -1: it could not be decided"):
        mo.least(lambda x: light_and_heavy(-x), -10.0, -1.0, load=2.0, **given)
    (trial,) = tried
    assert not trial.holds
    assert trial.number == pytest.approx(WEIGHT / 10, rel=1e-6)


def test_a_limit_before_any_position_names_the_value(clock, watched):
    def is_over(*_):
        clock.now += 100.0

    watched(prepare("static").__class__, "_assembled", is_over)
    with pytest.raises(TimeLimitError, match=r"^at 0\.1: .*had not yet solved any position of the axles"):
        mo.most(light_and_heavy, 0.1, 10.0, load=8.0, method="static", time_limit=45)


def test_a_sample_counts_a_stopped_crossing_as_undecided():
    statuses = [mo.Status.TIME_LIMIT, mo.Status.OPTIMAL]
    rows = [
        {"weight": 6.0, "load_factor": 2.0, "status": str(status), "message": "why"} for status in statuses
    ]
    table = framed(rows, ["weight"], RUN_COLUMNS)
    found = Sample("slab", table, ("weight",), {"weight": "uniform"})
    np.testing.assert_array_equal(found.load_factors, [np.nan, 2.0])
    assert found.undecided == 1
    assert "1 run undecided (stopped by the time limit): why" in str(found.warning_records)


def test_a_stopped_crossing_does_not_show_that_a_load_factor_falls():
    runs = {"joints.friction": [0.3, 0.4], "load_factor": [2.0, 1.0], "status": "optimal"}
    table = pd.DataFrame(runs)
    assert len(list(warnings_of_falls(table, ["joints.friction"], "coulomb"))) == 1
    for row in (0, 1):
        stopped = table.copy()
        stopped.loc[row, "status"] = str(mo.Status.TIME_LIMIT)
        assert not list(warnings_of_falls(stopped, ["joints.friction"], "coulomb"))


def test_bad_input_names_what_to_change():
    with pytest.raises(mo.OptionError, match=r"'axles.a.load.1'.*did you mean 'axles.a.loads.1'"):
        mo.sweep(WITH_AXLES, {"axles.a.load.1": [1.0]}, **STATIC)
    with pytest.raises(mo.MasonryError, match=r"axles.a.loads.1 = -3.*must be greater than 0"):
        mo.sweep(WITH_AXLES, {"axles.a.loads.1": [-3.0]}, **STATIC)
    low = WITH_AXLES.replace(axles=[axles(3.0, road=[(-5, 0.5), (5, 0.5)])])
    with pytest.raises(mo.MasonryError, match=r"status 'refused' in 1 of 1 runs: .*road of axles 'a'"):
        mo.sweep(low, {"block.slab.weight": [1.0]}, **STATIC)


def test_a_refused_run_adds_no_load_case_to_the_worst_position():
    """A table with a refused run has NaN in the column of load cases, also for a scene without load cases."""
    frame = mo.sweep(WITH_AXLES, {"block.slab.weight": [-1, 6]}, **STATIC)
    assert frame["status"].tolist() == ["refused", "optimal"]
    text = summary_text(frame, ["block.slab.weight"])
    assert "smallest at block.slab.weight = 6, with 'a' at -1, travelling right\n" in text
    assert "load case" not in text


@pytest.mark.slow
@pytest.mark.usefixtures("without_charts")
def test_the_command_names_the_worst_position(tmp_path, command):
    mo.save(WITH_AXLES, tmp_path / "slab.toml")
    asked = ("--vary", "block.slab.weight=6,12", "--method", "static", "--workers", "1")
    output = command("sweep", tmp_path / "slab.toml", *asked, "--out", tmp_path / "out")
    assert "smallest at block.slab.weight = 6, with 'a' at -1, travelling right" in output
    written = pd.read_csv(tmp_path / "out" / "runs.csv")
    np.testing.assert_allclose(written["load_factor"], [2.0, 4.0], rtol=1e-6)
    assert written["position"].abs().to_list() == pytest.approx([1.0, 1.0], abs=1e-6)
    again = command("sweep", tmp_path / "slab.toml", *asked, "--out", tmp_path / "out")
    assert again == output
    least = ("--vary", "block.slab.weight=1:30", "--load", "2", "--method", "static")
    assert "least value      5.99999" in command("least", tmp_path / "slab.toml", *least)

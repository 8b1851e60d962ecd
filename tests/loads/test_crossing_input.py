"""Tests of axles and roads as input: other load cases, wrong input, the command and the page."""

import json
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from loads.overhang import OVERHANG, WEIGHT, axles, interrupts, slab, support

import masonry_opt as mo
from masonry_opt.scene.road import SETS
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Code
from masonry_opt.solution.solution import Solution


def test_a_group_that_is_the_same_from_behind_crosses_once():
    assert axles(1.0, 2.0, 1.0, distances=[1.0, 1.0]).directions == ("right",)
    assert axles(1.0, 2.0, 1.0, distances=[1.0, 1.5]).directions == ("right", "left")
    assert axles(1.0, 2.0, distances=[1.0], travels="left").directions == ("left",)


def test_other_live_loads_stay_and_plain_solving_says_that_axles_move():
    own = OVERHANG.replace(blocks={"slab": {"live": (0.0, -6.0), "live_at": (1.0, 0.5)}})
    alone = mo.solve(own, "static")
    with_axles = mo.solve(own.replace(axles=[axles(3.0)]), "static")
    assert with_axles.load_factor == alone.load_factor == pytest.approx(WEIGHT / 6)
    (warning,) = with_axles.warnings
    assert warning.code is Code.AXLES_LEFT_OUT
    # Both loads are at the end: λ (3 + 6) 0.5 = 0.5 W.
    assert mo.crossing(own, axles(3.0), method="static").load_factor == pytest.approx(WEIGHT / 9, rel=1e-6)
    with pytest.raises(mo.CaseError, match="crossing"):
        mo.solve(OVERHANG.replace(axles=[axles(3.0)]), "static")
    shaken = OVERHANG.replace(axles=[axles(3.0)], earthquake={"direction": "left"})
    (warning,) = mo.solve(shaken, "static").warnings
    assert warning.code is Code.AXLES_LEFT_OUT


def in_cases(**keys):
    """Return the slab with a load of 6 in group "crowd" at its end, and with load cases with and without
    axles."""
    crowd = mo.Load(block="slab", live=(0.0, -6.0), at=(1.0, 0.5), group="crowd")
    cases = [
        mo.LoadCase(name="alone", dead={"weight": 0.9}, live={"axles": 1.5}),
        mo.LoadCase(name="crowd too", live={"axles": 2.0, "crowd": 0.5}),
        mo.LoadCase(name="crowd", live={"crowd": 1.0}),
    ]
    return OVERHANG.model_copy(update={"loads": [crowd], "load_cases": cases} | keys)


@pytest.mark.slow
def test_load_cases(tmp_path):
    """The load factors of two cases agree with moments about the edge of the support, with the axle at an
    end.

    λ · 1.5 · 3 · 0.5 = 0.9 W · 0.5 in case "alone", and λ (2 · 3 + 0.5 · 6) 0.5 = 0.5 W in case "crowd too".
    """
    for name, expected in (("alone", 0.9 * WEIGHT / 4.5), ("crowd too", WEIGHT / 9)):
        found = mo.crossing(in_cases(), axles(3.0), method="static", load_case=name)
        assert found.load_factor == pytest.approx(expected, rel=1e-6)
        assert found.as_dict()["load_case"] == found.worst.load_case == name
        # The scene of the worst position has the same load factor by another method.
        own = found.least.passage.scene(found.position)
        assert mo.solve(own, "kinematic").load_factor == pytest.approx(expected, rel=1e-6)
        # Its case file has the same load factor, for the load case of this name.
        mo.save(own, tmp_path / f"{name}.toml")
        again = mo.solve(tmp_path / f"{name}.toml", "static", load_case=name)
        assert again.load_factor == pytest.approx(expected, rel=1e-6)
    for name, word in (("crowd", "leaves axles out"), ("none", "no load case")):
        with pytest.raises(mo.MasonryError, match=word):
            mo.crossing(in_cases(), axles(3.0), method="static", load_case=name)
    with pytest.raises(mo.CaseError, match="'axles', which are a moving live load"):
        mo.LoadCase(name="a", dead={"axles": 1.0}, live={"live": 1.0})
    with pytest.raises(mo.CaseError, match="axle loads act downwards"):
        mo.LoadCase(name="a", live={"axles": -1.0})


@pytest.mark.parametrize("method", ["static", pytest.param("nonassociative", marks=pytest.mark.slow)])
def test_all_load_cases_at_once(tmp_path, method):
    """A crossing of all load cases equals the crossings of single cases, and governs by the lesser λ by hand.

    Case "crowd too" has the greater λ near the support, where the crowd helps an axle at the other end. It
    has the lesser λ at the end of the slab.
    """
    of = in_cases(axles=[axles(3.0, road=[(-10, 1), (10, 1)])])
    names = ("alone", "crowd too")
    alone = {name: mo.crossing(of, method=method, load_case=name) for name in names}
    found = mo.crossing(of, method=method)
    assert found.by_case == pytest.approx({name: one.load_factor for name, one in alone.items()}, rel=1e-5)
    assert found.worst.load_case == "crowd too"
    assert found.left_out == ("crowd",)
    assert {*found.table["load_case"]} == {*names}
    rows = found.governing
    assert len(rows) * 2 == len(found.table)
    turns = (rows["position"].abs() - 0.5).clip(lower=0)
    with np.errstate(divide="ignore"):
        by_hand = np.minimum(0.9 * WEIGHT * 0.5 / (4.5 * turns), by_crowd(rows["position"]))
    off = np.isfinite(by_hand) & (rows["position"].abs() <= 1)
    np.testing.assert_allclose(rows["load_factor"][off], by_hand[off], rtol=1e-5)
    assert {*rows["load_case"].dropna()} == {*names}
    record = json.loads(found.to_json())
    assert record["by_case"]["crowd too"] == pytest.approx(WEIGHT / 9, rel=1e-6)
    assert [row["load_case"] for row in record["governing"]] == [
        None if x is None else x for x in rows["load_case"]
    ]
    found.save(tmp_path / "a.html")
    positions = (tmp_path / "a.html").read_text().rpartition("<table")[2]
    assert positions.count("<tr>") == len(rows) + 1
    falls = of.replace(load_cases={"alone": {"dead": {"crowd": 5.0}}})
    fallen = mo.crossing(falls, method=method).worst
    assert (fallen.status, fallen.load_case) == (mo.Status.UNSTABLE, "alone")


@pytest.mark.slow
def test_load_cases_that_were_not_crossed_are_named(tmp_path):
    """Load cases that were not crossed are named in the answer and in the report.

    The crossing ends after Ctrl-C in the first case, or because the scene is unstable in a case.
    """
    positions = []
    of = in_cases(axles=[axles(3.0)])
    stopped = mo.crossing(of, method="static", progress=interrupts(positions))
    assert stopped.not_crossed == ["crowd too"]
    by_case = json.loads(stopped.to_json())["by_case"]
    assert by_case == {"alone": pytest.approx(stopped.load_factor, rel=1e-5), "crowd too": None}
    fallen = mo.crossing(of.replace(load_cases={"alone": {"dead": {"crowd": 5.0}}}), method="static")
    assert (fallen.worst.status, fallen.left_out) == (mo.Status.UNSTABLE, ("crowd",))
    assert fallen.by_case == {"alone": None, "crowd too": None}
    for found in (stopped, fallen):
        assert "governs" not in str(found)
        mo.report(found, tmp_path / "report.html", force=True)
        text = (tmp_path / "report.html").read_text("utf-8")
        assert "every load case" not in text
        unchecked = text.partition('id="unchecked"')[2].partition("</ul>")[0].replace("&#39;", "'")
        assert "Load case 'crowd too': no result, because the axles were not moved" in unchecked
        assert "Load case 'crowd': this load case has no axles" in unchecked
        assert "Load case 'alone'" not in unchecked


@pytest.mark.slow
def test_an_undecided_load_case_is_named_and_not_hidden():
    """A position with an undecided load case is reported once.

    The other case carries any load, or has no answer either.
    """
    whole = mo.crossing(in_cases(), axles(3.0), method="static")
    failed = Solution(mo.Status.SOLVER_FAILED, Kind.ASSOCIATIVE)
    unlimited = Solution(mo.Status.UNLIMITED, Kind.ASSOCIATIVE)
    first, second = whole.passages
    for answer, rows in ((unlimited, 1), (failed, 2)):
        changed = replace(first, answers={0.9: answer}), replace(second, answers={0.9: failed})
        found = replace(whole, passages=changed)
        assert (found.undecided, len(found.undecided_at)) == (1, rows)
        (row,) = found.governing.to_dict("records")
        assert row["status"] == str(failed.status)
        assert row["load_case"] is None


@pytest.mark.parametrize(
    ("error", "words"), [(KeyboardInterrupt(), "interrupted"), (mo.OptionError("too large"), "too large")]
)
def test_a_first_look_that_ends_loses_no_crossing(watched, error, words):
    def ends(method, **_):
        if method != "static":
            raise error

    watched(import_module("masonry_opt.studies.crossing.crossing"), "prepare", ends)
    found = mo.crossing(OVERHANG, axles(3.0), method="static")
    assert found.load_factor == pytest.approx(WEIGHT / 3, rel=1e-6)
    assert not found.interrupted
    assert found.as_dict()["default"] is None
    assert f"not compared with the default method: {words}" in str(found)


def by_crowd(x):
    """Return λ of case "crowd too" by hand: a load of 0.5 · 6 at x = 1, and an axle load of 2 · 3 at x.

    The slab turns about the edge at 0.5, or about the edge at -0.5 if the axle turns it to the left.
    """
    right = 6 * (x - 0.5) + 1.5
    left = 6 * (-x - 0.5) - 4.5
    most = np.maximum(right, left)
    return np.where(most > 0, 0.5 * WEIGHT / np.where(most > 0, most, 1.0), np.inf)


def test_a_width_is_a_share_of_loads_by_the_thickness():
    whole = mo.crossing(OVERHANG, axles(3.0), method="static")
    shared = mo.crossing(OVERHANG.replace(thickness=0.5), axles(3.0, width=2.5), method="static")
    assert shared.load_factor == pytest.approx(5 * whole.load_factor, rel=1e-9)
    with pytest.raises(mo.CaseError, match="'width'"):
        axles(3.0, width=0.0)


@pytest.mark.slow
def test_a_first_look_says_by_how_much_the_default_differs():
    found = mo.crossing(OVERHANG, axles(3.0), method="static")
    assert found.as_dict()["default"] == pytest.approx(found.load_factor, rel=1e-6)
    lighter = OVERHANG.replace(
        blocks={"slab": {"weight": 0.75 * WEIGHT, "live": (0.0, -3.0), "live_at": (1, 0.5)}}
    )
    less = replace(found, default=mo.solve(lighter))
    assert "λ = 3.000000 at the worst position: 25.00% less than the associative load factor, " in str(less)
    assert mo.crossing(OVERHANG, axles(3.0), method="nonassociative").default is None


def test_solving_leaves_out_cases_of_axles_alone():
    of = in_cases(axles=[axles(3.0)])
    found = mo.solve_cases(of, "static")
    assert {name: one.load_factor for name, one in found.results.items()} == pytest.approx(
        {"crowd too": WEIGHT / 3, "crowd": WEIGHT / 6}
    )
    assert found.left_out == ("alone",)
    assert json.loads(found.to_json())["left_out"] == ["alone"]
    assert "'alone'" in found.summary
    codes = {name: [one.code for one in result.warnings] for name, result in found.results.items()}
    assert codes == {"crowd too": [Code.AXLES_LEFT_OUT], "crowd": []}
    # The warning also appears if the scene itself has no axles.
    (warning,) = mo.solve(in_cases(), "static", load_case="crowd too").warnings
    assert (warning.code, warning.values["names"]) == (Code.AXLES_LEFT_OUT, [])
    alone = of.model_copy(update={"load_cases": of.load_cases[:1]})
    for solves in (lambda: mo.solve_cases(alone), lambda: mo.solve(alone, load_case="alone")):
        with pytest.raises(mo.CaseError, match="'alone': the only live loads are axles"):
            solves()


def test_without_a_load_factor():
    falls = OVERHANG.model_copy(update={"blocks": [slab(), support(0.5, 1.0)]})
    found = mo.crossing(falls, axles(3.0), method="static")
    assert found.worst.status is mo.Status.UNSTABLE
    assert found.table.empty
    assert found.position is None
    with pytest.raises(mo.OptionError):
        found.plot()
    assert json.loads(found.to_json())["positions"] == []


def test_sets_are_whole():
    for distances, loads, source in SETS.values():
        assert len(distances) == len(loads) - 1
        assert source
    # LM1 of EN 1991-2 has twice 300 kN, and the double axle of CS 454 twice 9.5 t.
    assert sum(SETS["LM1 lane 1"].loads) == 600
    assert mo.Axles(name="a", set="CS 454 double 1.3 m", factor=0.5).group.loads == pytest.approx(
        (46.5975, 46.5975)
    )


@pytest.mark.parametrize(
    ("keys", "word"),
    [
        ({"loads": [1, 0], "distances": [1]}, "greater than 0"),
        ({"loads": [1, 1], "distances": [-1]}, "greater than 0"),
        ({"loads": [1, 1]}, r"need 1 'distances'.* \(found 0\)"),
        ({}, "no load"),
        ({"set": "LM9"}, "did you mean 'LM2'"),
        ({"set": "tank"}, "LM1 lane 1"),
        ({"set": "LM2", "loads": [1]}, "but not both"),
        ({"loads": [1], "road": [(1, 0), (0, 0)]}, "left to right"),
        ({"loads": [1], "travels": "up"}, "travels"),
    ],
)
def test_groups_that_are_none(keys, word):
    with pytest.raises(mo.CaseError, match=word):
        mo.Axles(name="a", **keys)


@pytest.mark.parametrize(
    ("group", "word"),
    [
        (axles(1.0, road=[(-5, 0.5), (5, 0.5)]), "runs through block 'slab'"),
        (axles(1.0, road=[(3, 1), (5, 1)]), "no movable block is below"),
        (axles(1.0, road=None), "have no road"),
        (None, "has no axles"),
        ("b", "no axles 'b'"),
        (3, "axles must be one mo.Axles, a list of mo.Axles, or the name"),
    ],
)
def test_roads_that_are_none(group, word):
    with pytest.raises(mo.MasonryError, match=word):
        mo.crossing(OVERHANG, group, method="static")


def test_scenes_that_no_axle_crosses():
    with pytest.raises(mo.OptionError, match="solids"):
        mo.crossing(mo.extrude(OVERHANG, 1.0), axles(1.0))
    with pytest.raises(mo.CaseError, match="tilt"):
        mo.crossing(OVERHANG.replace(tilt="right"), axles(1.0))
    with pytest.raises(mo.CaseError, match="remove 'earthquake'"):
        mo.crossing(OVERHANG.replace(earthquake={"direction": "left"}), axles(1.0))
    with pytest.raises(mo.CaseError, match="two groups of axles"):
        OVERHANG.replace(axles=[axles(1.0), axles(2.0)])
    with pytest.raises(mo.CaseError, match="'axles' do not tilt"):
        OVERHANG.replace(tilt="right", axles=[axles(1.0)])
    with pytest.raises(mo.OptionError, match="axles"):
        mo.extrude(OVERHANG.replace(axles=[axles(1.0)]), 1.0)


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "slab.toml"
    mo.save(OVERHANG.replace(axles=[axles(3.0)]), path)
    return path


@pytest.mark.slow
def test_command(case, tmp_path, command):
    asked = ("crossing", case, "--method", "static")
    record = command.json(*asked, "--plot", tmp_path / "a.png")
    assert record["load_factor"] == pytest.approx(4, rel=1e-6)
    assert record["status"] == "optimal"
    assert record["worst"]["load_factor"] == record["load_factor"]
    assert len(record["positions"]) > 10
    assert (tmp_path / "a.png").stat().st_size > 10_000
    out = command(*asked, "--plot", tmp_path / "a.png", "--table")  # An existing picture is replaced.
    assert "4.000000" in out
    assert out.count(" right ") > 10
    for wrong in (("--axles", "b"), ("--plot", tmp_path / "a.doc"), ("-o", "axles=1")):
        command.refused("crossing", case, *wrong)


@pytest.mark.slow
def test_page(case, tmp_path):
    pytest.importorskip("jinja2")
    found = mo.crossing(case, method="static")
    found.save(tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text()
    positions = text.rpartition("<table")[2]
    assert positions.count("<tr>") == len(found.table) + 1
    assert "data:image/svg+xml" in text
    # Over the support nothing moves, and the page leaves the mechanism empty.
    assert found.table["mechanism"].isna().any()
    assert ">nan<" not in text

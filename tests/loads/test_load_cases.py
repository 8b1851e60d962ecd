"""Tests of load cases: factors on dead and live loads, matrices that cases share, and wrong input."""

import numpy as np
import pytest
from scenes import GOOD, block_on_floor
from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

LOADS = [
    mo.Load(block="A", dead=(0.0, -4.0), at=(0.25, 2.0), group="floor"),
    mo.Load(block="A", live=(3.0, 0.0), at=(0.0, 1.5), group="wind"),
    mo.Load(block="A", live=(0.5, 0.0)),
    mo.Load(block="A", dead=(0.1, 0.0)),
]
EDGE = mo.EdgeLoad(start=(0, 0), end=(0, 2), pressure=2.0, kind="live", group="wind")


def scene(*cases: dict[str, object], **keys: object) -> mo.Scene:
    """Return a block of 1 × 2 and weight 1 with a live load of 1 to the right, and other loads in groups."""
    return block_on_floor().replace(
        **{"loads": LOADS, "edge_loads": [EDGE], "load_cases": list(cases)} | keys
    )


def forces(of: mo.Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return the dead and the live load: fx, fy and the moment about the centroid (0.5, 1)."""
    problem = assemble(of).problem
    unit = problem.force_unit * np.array([1, 1, problem.length_unit])
    return problem.dead * unit, problem.live * unit


def test_factors_of_groups_as_dead_and_as_live():
    factors = {"dead": {"weight": 0.9, "floor": 0.5, "live": 2.0}, "live": {"wind": 1.5, "weight": 0.1}}
    dead, live = forces(scene({"name": "a"} | factors).in_case("a"))
    # The dead load is 0.9 of the weight, half of group "floor", and all dead and twice the live loads without
    # group.
    assert dead == pytest.approx([0.1 + 2 * 1.5, -0.9 - 2.0, -0.25 * -2.0])
    # The live load is 1.5 of group "wind" and a tenth of the weight. The wind is a force of 3 at half a unit
    # above the centroid, and a pressure of 2 on a height of 2.
    assert live == pytest.approx([1.5 * 7.0, -0.1, -1.5 * 3.0 * 0.5])


def test_what_a_case_does_not_name():
    dead, live = forces(scene({"name": "a", "live": {"live": 1.0}}).in_case("a"))
    assert dead == pytest.approx([0.1, -1.0, 0.0])
    assert live == pytest.approx([1.5, 0.0, 0.0])


def test_without_a_case_loads_act_as_they_are_given():
    plain = scene({"name": "a", "live": {"live": 1.0}})
    dead, live = forces(plain)
    assert dead == pytest.approx([0.1, -5.0, 1.0])
    assert live == pytest.approx([1.5 + 3 + 4, 0.0, -1.5])
    with pytest.raises(mo.OptionError, match="load cases"):
        mo.solve(plain)


def test_moments_of_solids():
    load = mo.Load(block="A", live_moment=(1.0, 2.0, 3.0), group="jack")
    case = {"name": "a", "dead": {"jack": 0.5, "dead": 2.0}, "live": {"jack": 3.0}}
    of = box_on_floor(dead_moment=(0.0, 5.0, 0.0)).replace(loads=[load], load_cases=[case])
    problem = assemble(of.in_case("a")).problem
    unit = problem.force_unit * problem.length_unit
    assert problem.dead[3:] * unit == pytest.approx([0.5, 11.0, 1.5])
    assert problem.live * unit == pytest.approx([0, 0, 0, 3.0, 6.0, 9.0])


def test_an_earthquake_pushes_the_masses_of_the_dead_loads_of_its_case():
    """An earthquake acts on the dead loads of its case: W = 1 and half of group "floor", but no live load."""
    quake = {"direction": "right", "vertical": -0.5}
    of = scene({"name": "q", "dead": {"floor": 0.5}, "earthquake": quake}).in_case("q")
    _, live = forces(of)
    # Half of 2 acts upwards, 0.25 left of the centroid; 2 acts sideways, 1 above it.
    down = -0.25 * 1.0 + 1.0 * -2.0
    assert live == pytest.approx([3.0, 1.5, down])


@pytest.mark.parametrize("method", ["static", pytest.param("coulomb", marks=pytest.mark.slow)])
def test_all_cases_are_those_solved_one_by_one(method):
    of = scene(
        {"name": "wind", "live": {"wind": 1.0}},
        {"name": "wind, floor loaded", "dead": {"floor": 1.0}, "live": {"wind": 1.0}},
        {"name": "quake", "earthquake": {"direction": "left", "vertical": 0.2}},
        {"name": "weight", "live": {"weight": 1.0}},
    )
    found = mo.solve_cases(of, method, incremental=False)
    for case in of.load_cases:
        alone = mo.solve(of, method, load_case=case.name, incremental=False)
        assert found.results[case.name].status is alone.status
        if alone.load_factor is not None:
            assert found.results[case.name].load_factor == pytest.approx(alone.load_factor, rel=1e-9)
    least = found.table["load_factor"].idxmin()
    assert found.governing == found.table["load_case"][least]
    assert not found.usable  # More weight causes no collapse.
    matrices = {id(result.assembly.problem.matrices) for result in found.results.values()}
    assert len(matrices) == 1


def test_a_case_that_falls_governs():
    loads = [mo.Load(block="A", dead=(1.0, 0.0), at=(0.5, 2.0), group="pull")]
    cases = ({"name": "falls", "dead": {"pull": 1}, "live": {"live": 1}}, {"name": "a", "live": {"live": 1}})
    found = mo.solve_cases(scene(*reversed(cases), loads=loads, edge_loads=[]), "static")
    assert found.governing == "falls"
    assert found.as_dict()["load_factor"] is None


def test_numbers_vary_within_a_case(tmp_path):
    of = scene({"name": "q", "earthquake": {"direction": "right", "vertical": 0.0}}, loads=[], edge_loads=[])
    table = mo.sweep(
        of.in_case("q"), {"load_case.earthquake.vertical": [0.0, -0.5]}, method="static", workers=1
    )
    assert table["load_factor"].to_numpy() == pytest.approx([1 / 2, 1 / 2.5], rel=1e-6)
    pushed = scene({"name": "a", "live": {"live": 1.0}}, loads=[], edge_loads=[]).in_case("a")
    table = mo.sweep(pushed, {"load_case.live.live": [1.0, 4.0]}, method="static", workers=1)
    assert table["load_factor"].to_numpy() == pytest.approx([1 / 2, 1 / 8], rel=1e-6)
    with pytest.raises(mo.OptionError, match="load cases"):
        mo.sweep(of, {"joints.friction": [0.5]}, workers=1)
    with pytest.raises(mo.OptionError, match="load cases"):
        mo.least(lambda _: of, 0.0, 1.0)


def test_solids_made_of_a_scene_have_its_cases():
    push = {"direction": "left", "vertical": 0.2, "coefficient": 0.4}
    quake = {"name": "quake", "dead": {"floor": 1.0}, "earthquake": push}
    of = scene({"name": "wind", "live": {"wind": 1.0}}, quake, edge_loads=[])
    solids = mo.extrude(of, 0.7)
    for name in ("wind", "quake"):
        flat, solid = (mo.solve(one, "static", load_case=name).required() for one in (of, solids))
        assert solid == pytest.approx(flat, rel=1e-6)


CASE = GOOD.replace("live = [1.0, 0.0]\n", "")
LOADED = CASE + '[[load]]\nblock = "A"\nlive = [1, 0]\ngroup = "wind"\n'

IN_A = LOADED + '[[load_case]]\nname = "a"\n'
SHAKEN = '[earthquake]\ndirection = "left"\n'

WRONG = {
    "nothing live": (IN_A, ["load_case no. 1 ('a')", "has no live load"]),
    "unknown group": (
        IN_A + "live = { win = 1 }\n",
        ["load_case no. 1 ('a')", "'live'", "'win'", "did you mean 'wind'?"],
    ),
    "name twice": (
        LOADED + 2 * '[[load_case]]\nname = "a"\nlive = { wind = 1 }\n',
        ["no. 2 ('a')", "another load case has the same name"],
    ),
    "pressure below zero": (
        IN_A + "live = { wind = 1 }\npressure = -1\n",
        ["('a')", "'pressure'", "0 or more"],
    ),
    "both": (
        IN_A + 'live = { wind = 1 }\nearthquake = { direction = "left" }\n',
        ["('a')", "'live' or 'earthquake', not both"],
    ),
    "a direction in space": (CASE + "[earthquake]\ndirection = 30\n", ["'earthquake'", '"left" or "right"']),
    "another side": (CASE + '[earthquake]\ndirection = "up"\n', ["[earthquake]", "'direction'", "'left'"]),
    "no coefficient": (CASE + SHAKEN + "coefficient = 0\n", ["'coefficient'", "greater than 0"]),
    "another live load": (LOADED + SHAKEN, ["'earthquake'", "load no. 1 has a live load too"]),
    "beside cases": (IN_A + "live = { wind = 1 }\n" + SHAKEN, ["'earthquake'", "[[load_case]]"]),
    "tilted": ('tilt = "left"\n' + CASE + SHAKEN, ["'tilt'"]),
    "a group's name": (LOADED.replace('"wind"', '"weight"'), ["load no. 1 ('A')", "'group'"]),
    "two kinds": (LOADED.replace("live", "dead = [1, 0]\nlive"), ["load no. 1 ('A')", "two loads"]),
    "a group of nothing": (LOADED.replace("live = [1, 0]", "weight = 2"), ["'group' needs 'live'"]),
    "negative mass": (LOADED + '[[load]]\nblock = "A"\nmass = -1\n', ["load no. 2 ('A')", "'mass'"]),
}


@pytest.mark.parametrize(("text", "named"), WRONG.values(), ids=list(WRONG))
def test_what_is_wrong_is_named(tmp_path, text, named):
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(mo.CaseError) as error:
        mo.load(path)
    for words in [str(path), *named]:
        assert words in str(error.value)


def test_cases_that_load_nothing_and_cases_there_are_not():
    of, plain = scene({"name": "a", "live": {"live": 1.0}}, loads=[]), block_on_floor()
    with pytest.raises(mo.CaseError, match="load case 'a'"):
        mo.solve_cases(block_on_floor(live=(0.0, 0.0)).replace(load_cases=of.load_cases))
    with pytest.raises(mo.OptionError, match="no load case 'b'; there are: 'a'"):
        mo.solve(of, load_case="b")
    with pytest.raises(mo.OptionError, match="load_case"):
        mo.solve_cases(plain)
    with pytest.raises(mo.OptionError, match="the scene has no load cases"):
        plain.in_case("a")
    with pytest.raises(mo.OptionError, match="every"):
        mo.directions(box_on_floor(), every=0)
    with pytest.raises(mo.OptionError, match="every"):
        mo.directions(block_on_floor(), every=0)
    with pytest.raises(mo.OptionError, match="vertical"):
        mo.directions(plain, vertical=())
    with pytest.raises(mo.CaseError, match="vertical"):
        mo.directions(plain, vertical="up")


@pytest.mark.parametrize(
    ("direction", "moment", "said"),
    [("left", 0.0, "angle in plan"), ([0, 0, 1], 0.0, "gravity"), (0, 1.0, "has a live load too")],
)
def test_what_solids_are_not_shaken_by(direction, moment, said):
    box = box_on_floor(live=(0.0, 0.0, 0.0), live_moment=(0.0, moment, 0.0))
    with pytest.raises(mo.CaseError, match=said):
        box.replace(earthquake={"direction": direction})


def test_a_factor_on_weights_is_no_force_that_was_given():
    of = scene({"name": "a", "dead": {"weight": 1.0001}, "live": {"live": 1}}, loads=[], edge_loads=[])
    assert not mo.solve(of, "static", load_case="a").warnings


def test_fill_in_a_case_and_in_an_earthquake():
    """Fill is a dead load of a case, and a mass in an earthquake.

    Fill of unit weight 2 and depth 1.5 on a block of width 1 and height 2 weighs 3. It acts at the middle of
    the top.
    """
    fill = mo.Fill(road=[(0, 3.5), (1, 3.5)], unit_weight=2.0, pressure=False)
    cases = [
        {"name": "heavy", "dead": {"fill": 1.2}, "live": {"live": 1}},
        {"name": "shaken", "earthquake": {"direction": "right", "vertical": -0.5}},
    ]
    of = block_on_floor().replace(fills=[fill], load_cases=cases)
    dead, live = forces(of.in_case("heavy"))
    assert dead == pytest.approx([0.0, -1.0 - 1.2 * 3.0, 0.0])
    assert live == pytest.approx([1.0, 0.0, 0.0])
    _, live = forces(of.in_case("shaken"))
    assert live == pytest.approx([1.0 + 3.0, 0.5 * 4.0, -3.0 * 1.0])


def test_ties_between_cases_of_other_dead_loads():
    """The strength of a tie is the same in all cases, although the unit of force changes with the dead
    load."""
    tie = mo.Tie(between=("A", "ground"), at=((0.5, 1.5), (-5, 1.5)), strength=0.3)
    cases = (
        {"name": "a", "live": {"live": 1.0}},
        {"name": "b", "dead": {"weight": 5.0}, "live": {"live": 1.0}},
    )
    of = scene(*cases, loads=[], edge_loads=[], ties=[tie])
    found = mo.solve_cases(of, "static").table["load_factor"]
    # The block of 1 × 2, with W = 1 or 5, turns at λ = W b/2 + 1.5 T and slides at λ = μ W + T.
    assert found[0] == pytest.approx(min(0.5 + 0.45, 0.6 + 0.3), rel=1e-6)
    assert found[1] == pytest.approx(min(2.5 + 0.45, 3.0 + 0.3), rel=1e-6)

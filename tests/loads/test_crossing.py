"""Axles over a road: closed forms by virtual work, sweeps by hand, what is proven, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scenes import run_command

import masonry_opt as mo
from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.answer.solution import Solution
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.road import Road
from masonry_opt.scene.axles import SETS
from masonry_opt.studies.crossing.crossing import _passages
from masonry_opt.studies.crossing.search import MovingLoad, PassageTrials, least_associative

ROAD = [(-5, 1), (5, 1)]
WEIGHT = 12.0


def slab(name="slab", left=-1.0, **keys):
    """A block 2 wide and 1 high, from its left end."""
    right = left + 2
    return mo.Block(name=name, vertices=[(left, 0), (right, 0), (right, 1), (left, 1)], weight=WEIGHT, **keys)


def support(left, right):
    return mo.Block(
        name=f"support {left}", vertices=[(left, -1), (right, -1), (right, 0), (left, 0)], fixed=True
    )


#: A slab that reaches .5 beyond its support on either side.
OVERHANG = mo.Scene(joints={"friction": 0.5}, blocks=[slab(), support(-0.5, 0.5)])


def axles(*loads, distances=(), **keys):
    return mo.Axles(**{"name": "a", "road": ROAD} | keys, loads=list(loads), distances=list(distances))


@pytest.mark.parametrize("method", ["static", "mcp"])
def test_a_slab_on_its_support_carries_any_axle(method):
    """The road begins before the slab, over the support, where an axle loads nothing that can move."""
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[slab(), support(-3, 3)])
    group = axles(3.0, 2.0, distances=[0.7], road=[(-3, 2), (3, 2)])
    for fills in ([], [mo.Fill(road=[(-3, 2), (3, 2)], unit_weight=1.0, pressure=False)]):
        found = mo.crossing(scene.model_copy(update={"fills": fills}), group, method=method)
        assert found.load_factor is None
        assert found.worst.solution.carries_any_load


@pytest.mark.parametrize("method", ["static", "kinematic", "mcp", "nonassociative"])
def test_one_axle_turns_a_slab_over_the_edge_of_its_support(method):
    """About the edge at x = .5: λ P (x - .5) = W .5, least at the end of the slab. Between the edges of the
    support any load is carried."""
    found = mo.crossing(OVERHANG, axles(3.0), method=method)
    assert found.load_factor == pytest.approx(WEIGHT / 3, rel=1e-6)
    assert abs(found.position) == pytest.approx(1, abs=1e-6)
    assert found.worst.method == method
    table = found.table
    expected = 0.5 * WEIGHT / (3 * (table["position"].abs() - 0.5))
    outside = table["position"].abs() > 0.5 + 1e-6
    assert 3 < outside.sum() < len(table)
    np.testing.assert_allclose(table["load_factor"][outside], expected[outside], rtol=1e-6)
    assert table["load_factor"][~outside].isna().all()
    assert found.undecided == 0
    if method in ("static", "kinematic"):
        assert found.bound == pytest.approx(found.load_factor, rel=2e-3)
        assert found.bound <= found.load_factor * (1 + 1e-9)
        assert table["any_load"][~outside].all()


@pytest.mark.parametrize("method", ["static", "mcp"])
def test_interrupted_it_keeps_the_positions_solved_by_then(method):
    told = []

    def third(position, load_factor):
        told.append(position)
        if len(told) == 3:
            raise KeyboardInterrupt

    found = mo.crossing(OVERHANG, axles(3.0), method=method, progress=third)
    assert found.interrupted
    assert sorted(found.table["position"]) == sorted(told)
    assert found.bound is None
    assert found.as_dict()["interrupted"]


def test_positions_without_an_answer_are_told_and_end():
    """Where the solver fails right of the support, ranges there are not halved, and nothing is proven."""
    passage = next(_passages(OVERHANG, axles(3.0)))
    problem = replace(passage.assembly.problem, live=passage.live(-1.0))
    exact, solved = MovingLoad(problem, Effort()), 0

    def fails_on_the_right(live):
        nonlocal solved
        solved += 1
        turning = float(live.reshape(-1, 3)[:, 2].sum())
        return exact(live) if turning >= 0 else Solution(Status.SOLVER_FAILED, Kind.ASSOCIATIVE)

    found = PassageTrials(passage, fails_on_the_right)
    least_associative(found, 0.25, 1e-3)
    undecided = found.positions[np.isnan(found.load_factors)]
    assert len(undecided) > 1
    assert (undecided > 0).all()
    assert found.bound is None
    assert solved < 200
    assert np.nanmin(found.load_factors) == pytest.approx(WEIGHT / 3, rel=1e-6)


def test_axles_beyond_the_road_do_not_count():
    """To the right: with the first axle at the end, the second (three times it) holds the slab down; worst is
    the second alone, at the end. To the left the same in the mirror."""
    found = mo.crossing(OVERHANG, axles(1.0, 3.0, distances=[0.8]), method="static")
    assert found.load_factor == pytest.approx(0.5 * WEIGHT / (3 * 0.5), rel=1e-6)
    assert {*found.table["direction"]} == {"right", "left"}
    assert abs(found.at[1]) == pytest.approx(1, abs=1e-6)
    assert abs(found.position) == pytest.approx(1.8, abs=1e-6)
    # A road that begins at x = -.9: there the second axle turns the slab, the first at x = -.1 against it.
    short = axles(1.0, 3.0, distances=[0.8], road=[(-0.9, 1), (0.7, 1)], travels="right")
    found = mo.crossing(OVERHANG, short, method="static")
    assert found.load_factor == pytest.approx(0.5 * WEIGHT / (3 * 0.4 - 1 * 0.4), rel=1e-6)
    assert found.at[1] == pytest.approx(-0.9, abs=1e-6)


def test_a_group_that_is_the_same_from_behind_crosses_once():
    assert axles(1.0, 2.0, 1.0, distances=[1.0, 1.0]).directions == ("right",)
    assert axles(1.0, 2.0, 1.0, distances=[1.0, 1.5]).directions == ("right", "left")
    assert axles(1.0, 2.0, distances=[1.0], travels="left").directions == ("left",)


def test_load_factors_jump_between_two_blocks():
    """Left of x = 0 an axle stands over a support. Right of it, on the next block, it turns that about the
    edge of its own at x = .5, which takes λ P .5 = W .5; nothing holds the two together."""
    scene = mo.Scene(
        joints={"friction": 0.0, "dilatancy": 0.0},
        blocks=[
            slab("left", -2.0),
            slab("right", 0.0),
            support(-2.0, 0.0),
            support(0.5, 1.5),
        ],
    )
    table = mo.crossing(scene, axles(4.0), method="static").table
    beside = table[table["position"].abs() < 1e-6].sort_values("position")
    assert len(beside) == 2
    assert np.isnan(beside["load_factor"].iloc[0])
    assert beside["load_factor"].iloc[1] == pytest.approx(WEIGHT / 4, rel=1e-6)


def arch(voussoirs=10, friction=0.45):
    ring = mo.Arch(radius=2, angles=(150, 30), thickness=0.3, voussoirs=voussoirs, unit_weight=20)
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=ring.blocks())


def at_points(scene, points):
    """The scene with loads by hand: each on the voussoir whose back lies below it."""
    loads = []
    for x, load in points:
        for block in scene.blocks:
            corners = np.array(block.vertices)
            back = corners[np.argsort(np.hypot(*corners.T))[-2:]]
            if not block.fixed and back[:, 0].min() <= x < back[:, 0].max():
                y = float(np.interp(x, *back[np.argsort(back[:, 0])].T))
                loads.append(mo.Load(block=block.name, live=(0, -load), at=(x, y)))
    return scene.model_copy(update={"loads": loads})


ON_ARCH = axles(60.0, 110.0, distances=[0.8], road=[(-2.2, 2.3), (2.2, 2.3)], travels="right")


def test_no_load_by_hand_is_worse_than_the_least():
    scene = arch()
    found = mo.crossing(scene, ON_ARCH, method="static")
    swept = []
    for x in np.arange(-1.75, 2.6, 0.07).tolist():
        by_hand = at_points(scene, [(x, 60.0), (x - 0.8, 110.0)])
        if by_hand.loads:
            swept.append(mo.solve(by_hand, "static").load_factor or np.inf)
    assert found.bound <= found.load_factor * (1 + 1e-9) <= min(swept)
    again = at_points(scene, zip(found.at, (60.0, 110.0), strict=True))
    assert mo.solve(again, "static").load_factor == pytest.approx(found.load_factor, rel=1e-8)


def test_a_coulomb_method_ends_at_the_least_of_its_own_sweep():
    scene = arch(8)
    found = mo.crossing(scene, ON_ARCH, method="nonassociative")
    (one,) = found.passages
    swept = [
        mo.solve(one.passage.scene(x), "nonassociative", expected=False).load_factor or np.inf
        for x in one.associative.positions[::4]
        if one.passage.carried(x)
    ]
    assert found.load_factor <= min(swept) * (1 + 1e-3)
    assert len(found.table) < 0.6 * len(found.envelope)
    merged = found.table.merge(found.envelope, on="position")
    assert len(merged) > 20
    known = merged["load_factor"].notna() & merged["associative_y"].notna()
    assert (merged["load_factor"] <= merged["associative_y"] * (1 + 1e-6))[known].all()


def test_a_changed_column_is_a_program_made_anew():
    scene = arch(12)
    assembly = assemble(scene)
    (one,) = mo.crossing(scene, ON_ARCH, method="static").passages
    moving = MovingLoad(one.passage.loaded(one.passage.live(0.3)).problem, Effort())
    for x in (0.3, -1.2, 1.9, -0.35, 2.4):
        live = one.passage.live(x)
        alone, moved = MovingLoad(one.passage.loaded(live).problem, Effort())(live), moving(live)
        assert moved.load_factor == pytest.approx(alone.load_factor, rel=1e-9)
        assert moved.answer.certificate.worst < 1e-9
    assert assembly.problem.B.shape == one.passage.assembly.problem.B.shape


def test_the_load_of_a_road_keeps_its_sum_and_its_place():
    scene = arch()
    assembly = assemble(scene)
    road = Road(scene, assembly.geometry, ON_ARCH.road)
    x, load = np.array([-1.1, 0.25, 0.3, 1.9, 7.0]), np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    forces = road.on_blocks(x, load)
    assert not forces[:, 0].any()
    # The last two are on an abutment, and beyond the road.
    assert forces[:, 1].sum() == pytest.approx(-6)
    centroid = assembly.geometry.centroid + assembly.geometry.origin
    moment = forces[:, 2].sum() + (centroid[:, 0] * forces[:, 1]).sum()
    assert moment == pytest.approx(-(x[:3] @ load[:3]))


@pytest.mark.slow
@pytest.mark.parametrize("method", ["static", "mcp"])
def test_bridge_with_fill_against_a_sweep(method):
    """Loads spread through fill: nothing jumps, and no load is a line or parabola of the position."""
    bridge = mo.load("cases/bridges/arch_with_fill.toml").model_copy(update={"loads": []})
    bogie = mo.Axles(name="bogie", set="CS 454 double 1.3 m", factor=0.4)
    found = mo.crossing(bridge, bogie, method=method, expected=False)
    passage = found.least.passage
    swept = {
        x: mo.solve(passage.scene(x), method, expected=False).load_factor
        for x in np.arange(-0.6, 0.1, 0.01 if method == "static" else 0.05).tolist()
    }
    assert found.load_factor <= min(swept.values()) * (1 + 1e-3)
    assert found.load_factor >= min(swept.values()) * (1 - 1e-3)
    if method == "static":
        assert found.bound <= min(swept.values())
        assert found.bound >= (1 - 2e-3) * found.load_factor


def test_other_live_loads_stay_and_plain_solving_says_that_axles_move():
    own = OVERHANG.model_copy(
        update={"blocks": [slab(live=(0.0, -6.0), live_at=(1.0, 0.5)), support(-0.5, 0.5)]}
    )
    alone = mo.solve(own, "static")
    with_axles = mo.solve(own.model_copy(update={"axles": [axles(3.0)]}), "static")
    assert with_axles.load_factor == alone.load_factor == pytest.approx(WEIGHT / 6)
    (warning,) = with_axles.warnings
    assert warning.code is Code.AXLES_LEFT_OUT
    # Both at the end: λ (3 + 6) .5 = W .5.
    assert mo.crossing(own, axles(3.0), method="static").load_factor == pytest.approx(WEIGHT / 9, rel=1e-6)
    with pytest.raises(mo.CaseError, match="crossing"):
        mo.solve(OVERHANG.model_copy(update={"axles": [axles(3.0)]}), "static")
    shaken = {"axles": [axles(3.0)], "earthquake": mo.Earthquake(direction="left")}
    (warning,) = mo.solve(OVERHANG.model_copy(update=shaken), "static").warnings
    assert warning.code is Code.AXLES_LEFT_OUT


def in_cases(**keys):
    """The slab with a load of 6 down at its end, of group "crowd", and cases with axles and without."""
    crowd = mo.Load(block="slab", live=(0.0, -6.0), at=(1.0, 0.5), group="crowd")
    cases = [
        mo.LoadCase(name="alone", dead={"weight": 0.9}, live={"axles": 1.5}),
        mo.LoadCase(name="crowd too", live={"axles": 2.0, "crowd": 0.5}),
        mo.LoadCase(name="crowd", live={"crowd": 1.0}),
    ]
    return OVERHANG.model_copy(update={"loads": [crowd], "load_cases": cases} | keys)


def test_load_cases(tmp_path):
    """About the edge of the support: λ 1.5 · 3 · .5 = .9 W .5, and λ (2 · 3 + .5 · 6) .5 = W .5 at an end."""
    for name, expected in (("alone", 0.9 * WEIGHT / 4.5), ("crowd too", WEIGHT / 9)):
        found = mo.crossing(in_cases(), axles(3.0), method="static", load_case=name)
        assert found.load_factor == pytest.approx(expected, rel=1e-6)
        assert found.as_dict()["load_case"] == found.worst.load_case == name
        assert name in str(found)
        # The worst is the answer of its own scene, by another method too.
        own = found.least.passage.scene(found.position)
        assert mo.solve(own, "kinematic").load_factor == pytest.approx(expected, rel=1e-6)
        # So is that of its file, by the name of the case.
        mo.save(own, tmp_path / f"{name}.toml")
        again = mo.solve(tmp_path / f"{name}.toml", "static", load_case=name)
        assert again.load_factor == pytest.approx(expected, rel=1e-6)
    for name, word in (("crowd", "leaves axles out"), (None, "has load cases"), ("none", "no load case")):
        with pytest.raises(mo.MasonryError, match=word):
            mo.crossing(in_cases(), axles(3.0), method="static", load_case=name)
    with pytest.raises(mo.CaseError, match="'axles', which move"):
        mo.LoadCase(name="a", dead={"axles": 1.0}, live={"live": 1.0})
    with pytest.raises(mo.CaseError, match="press down"):
        mo.LoadCase(name="a", live={"axles": -1.0})


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
    # Whether or not the scene itself has them.
    (warning,) = mo.solve(in_cases(), "static", load_case="crowd too").warnings
    assert (warning.code, warning.values["names"]) == (Code.AXLES_LEFT_OUT, [])
    alone = of.model_copy(update={"load_cases": of.load_cases[:1]})
    for solves in (lambda: mo.solve_cases(alone), lambda: mo.solve(alone, load_case="alone")):
        with pytest.raises(mo.CaseError, match="'alone': its axles move"):
            solves()


def test_without_a_load_factor():
    firm = OVERHANG.model_copy(update={"blocks": [slab(), support(-1.0, 1.0)]})
    found = mo.crossing(firm, axles(3.0), method="static")
    assert found.load_factor is None
    assert found.worst.solution.carries_any_load
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
    # Of EN 1991-2 twice 300 kN, of CS 454 twice 9.5 t.
    assert sum(SETS["LM1 lane 1"].loads) == 600
    assert mo.Axles(name="a", set="CS 454 double 1.3 m", factor=0.5).group.loads == pytest.approx(
        (46.5975, 46.5975)
    )


@pytest.mark.parametrize(
    ("keys", "word"),
    [
        ({"loads": [1, 0], "distances": [1]}, "greater than 0"),
        ({"loads": [1, 1], "distances": [-1]}, "greater than 0"),
        ({"loads": [1, 1]}, "1, has 0"),
        ({}, "no axle"),
        ({"set": "LM9"}, "LM1 lane 1"),
        ({"set": "LM2", "loads": [1]}, "not both"),
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
        (axles(1.0, road=[(3, 1), (5, 1)]), "no movable block lies under"),
        (axles(1.0, road=None), "on which road"),
        (None, "has no axles"),
        ("b", "no axles 'b'"),
    ],
)
def test_roads_that_are_none(group, word):
    with pytest.raises(mo.MasonryError, match=word):
        mo.crossing(OVERHANG, group, method="static")


def test_scenes_that_no_axle_crosses():
    with pytest.raises(mo.OptionError, match="solids"):
        mo.crossing(mo.extrude(OVERHANG, 1.0), axles(1.0))
    with pytest.raises(mo.CaseError, match="tilt"):
        mo.crossing(OVERHANG.model_copy(update={"tilt": "right"}), axles(1.0))
    with pytest.raises(mo.CaseError, match="take 'earthquake' away"):
        mo.crossing(OVERHANG.model_copy(update={"earthquake": mo.Earthquake(direction="left")}), axles(1.0))
    with pytest.raises(mo.CaseError, match="two groups of axles"):
        mo.Scene(joints={"friction": 0.5}, blocks=list(OVERHANG.blocks), axles=[axles(1.0), axles(2.0)])
    with pytest.raises(mo.CaseError, match="'axles' do not tilt"):
        mo.Scene(joints={"friction": 0.5}, blocks=list(OVERHANG.blocks), tilt="right", axles=[axles(1.0)])
    with pytest.raises(mo.OptionError, match="axles"):
        mo.extrude(OVERHANG.model_copy(update={"axles": [axles(1.0)]}), 1.0)


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "slab.toml"
    mo.save(OVERHANG.model_copy(update={"axles": [axles(3.0)]}), path)
    return path


def test_command(case, tmp_path, monkeypatch, capsys):
    asked = ("--method", "static", "--plot", tmp_path / "a.png")
    code, out, _ = run_command(monkeypatch, capsys, "crossing", case, *asked, "--json")
    assert code == 0
    told = json.loads(out)
    assert told["load_factor"] == pytest.approx(4, rel=1e-6)
    assert told["status"] == "optimal"
    assert told["worst"]["load_factor"] == told["load_factor"]
    assert len(told["positions"]) > 10
    assert (tmp_path / "a.png").stat().st_size > 10_000
    code, out, _ = run_command(monkeypatch, capsys, "crossing", case, *asked)
    assert code == 0  # the picture of before is replaced
    assert "4.000000" in out
    code, out, _ = run_command(monkeypatch, capsys, "crossing", case, "--method", "static", "--table")
    assert (code, out.count(" right ") > 10) == (0, True)
    for wrong in (("--axles", "b"), ("--plot", tmp_path / "a.doc"), ("-o", "axles=1")):
        assert run_command(monkeypatch, capsys, "crossing", case, *wrong)[0] == 2


def test_page(case, tmp_path):
    pytest.importorskip("jinja2")
    found = mo.crossing(case, method="static")
    found.save(tmp_path / "a.html")
    found.save(tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text()
    assert text.count("<tr>") == len(found.table) + 1
    assert "data:image/svg+xml" in text
    assert found.table["mechanism"].isna().any()  # over the support nothing moves, and the page says nothing
    assert ">nan<" not in text

"""Tests of axles on a road: closed forms by virtual work, comparisons with sweeps, and proven bounds."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from loads.overhang import OVERHANG, WEIGHT, axles, interrupts, slab, support
from scenes import CASES, axles_on_a_beam
from settled_scenes import beam
from speeds import slow

import masonry_opt as mo
from masonry_opt.analysis import Session
from masonry_opt.effort import Effort
from masonry_opt.finite_motion.settled_state import settled_scene
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.fill import Road
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Status
from masonry_opt.solution.solution import Solution
from masonry_opt.studies.crossing.passages import passages_of
from masonry_opt.studies.crossing.search import PassageTrials, least_associative, moving_load


@pytest.mark.slow
def test_a_slab_on_its_support_carries_any_axle():
    """A slab whose support is wider carries any axle, under fill and without.

    The road begins before the slab, over the support, where an axle loads no movable block.
    """
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[slab(), support(-3, 3)])
    group = axles(3.0, 2.0, distances=[0.7], road=[(-3, 2), (3, 2)])
    for fills in ([mo.Fill(road=[(-3, 2), (3, 2)], unit_weight=1.0, pressure=False)], []):
        found = mo.crossing(scene.model_copy(update={"fills": fills}), group, method="static")
        assert found.load_factor is None
        assert found.worst.solution.carries_any_load


@pytest.mark.parametrize("method", ["static", "kinematic", *slow("nonassociative", "coulomb")])
def test_one_axle_turns_a_slab_over_the_edge_of_its_support(method):
    """The load factor of one axle agrees with moments about the edge at x = 0.5: λ P (x - 0.5) = 0.5 W.

    It is least at the end of the slab. Between the edges of the support any load is carried.
    """
    found = mo.crossing(OVERHANG, axles(3.0, road=[(-8, 1), (8, 1)]), method=method)
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


@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_interrupted_it_keeps_the_positions_solved_by_then(method):
    positions = []
    found = mo.crossing(OVERHANG, axles(3.0), method=method, progress=interrupts(positions))
    assert found.interrupted
    assert sorted(found.table["position"]) == sorted(positions)
    assert found.bound is None
    assert found.as_dict()["interrupted"]


@pytest.mark.parametrize("method", ["static", pytest.param("coulomb", marks=pytest.mark.slow)])
def test_interrupted_in_its_last_solve_it_keeps_what_was_found(method, watched):
    """Ctrl-C in the last solve loses only the incremental load factor.

    The last solve repeats the worst position to compute this load factor.
    """
    whole = mo.crossing(OVERHANG, axles(3.0), method=method, incremental=False)
    first = ["stands", "last"]

    def ends(*_):
        if len(asked) == len(first):
            raise KeyboardInterrupt

    asked = watched(Session, "solve", ends)
    found = mo.crossing(OVERHANG, axles(3.0), method=method)
    assert len(asked) == len(first)
    assert found.load_factor == pytest.approx(whole.load_factor, rel=1e-9) == pytest.approx(WEIGHT / 3)
    assert (found.position, found.bound, found.interrupted) == (whole.position, None, True)
    assert found.worst.incremental is None
    assert found.worst.joints["n"].to_numpy() == pytest.approx(whole.worst.joints["n"].to_numpy(), abs=1e-6)
    assert found.worst.assembly.scene == whole.worst.assembly.scene
    assert "λ so far" in found.facts()


def test_positions_without_an_answer_are_told_and_end():
    """If the solver fails right of the support, the search does not halve ranges there, and proves no
    bound."""
    ((passage,),), _ = passages_of(OVERHANG, axles(3.0))
    problem = replace(passage.assembly.problem, live=passage.live(-1.0))
    exact, solved = moving_load(problem, Effort()), 0

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


@pytest.mark.parametrize(("required", "least_bound"), [(None, 0.8), (0.95, 0.95), (0.999, 0.999), (1.1, 0.8)])
def test_positions_are_solved_until_the_bound_decides_about_a_required_factor(required, least_bound):
    """1/λ is the length of the load (x, 1 - x²), which is 1 at its greatest: the least λ is 1."""
    passage = SimpleNamespace(live=lambda x: np.array([x, 1 - x * x]), pieces=lambda _: [(-1.0, 1.0)])

    def by_length(live):
        return SimpleNamespace(load_factor=1 / np.linalg.norm(live), status=None, interrupted=False)

    found = PassageTrials(passage, by_length)
    least_associative(found, 2.0, 0.25, required)
    assert found.least == pytest.approx(1)
    assert least_bound <= found.bound <= 1
    if required is None or required > 1:
        assert found.bound < 0.95


@pytest.mark.slow
def test_axles_beyond_the_road_do_not_count():
    """An axle beyond the road does not count.

    On the way to the right, the second axle, three times as heavy, holds the slab down while the first is at
    the end. The worst position has the second axle alone, at the end. To the left, the positions are
    mirrored.
    """
    found = mo.crossing(OVERHANG, axles(1.0, 3.0, distances=[0.8]), method="static")
    assert found.load_factor == pytest.approx(0.5 * WEIGHT / (3 * 0.5), rel=1e-6)
    assert {*found.table["direction"]} == {"right", "left"}
    assert abs(found.at[1]) == pytest.approx(1, abs=1e-6)
    assert abs(found.position) == pytest.approx(1.8, abs=1e-6)
    # On a road that begins at x = -0.9, the second axle turns the slab there, and the first, at x = -0.1,
    # resists.
    short = axles(1.0, 3.0, distances=[0.8], road=[(-0.9, 1), (0.7, 1)], travels="right")
    found = mo.crossing(OVERHANG, short, method="static")
    assert found.load_factor == pytest.approx(0.5 * WEIGHT / (3 * 0.4 - 1 * 0.4), rel=1e-6)
    assert found.at[1] == pytest.approx(-0.9, abs=1e-6)


@pytest.mark.slow
def test_each_load_case_has_the_road_of_its_own_settlement(monkeypatch):
    """Each load case has a road that follows its own settlement.

    The beam turns about x = 1 by a quarter of the settlement, which is twice as large in case "heavy".
    """
    movements = {"light": {"R": (0.0, -0.02)}, "heavy": {"R": (0.0, -0.04)}}

    def settles(scene, _):
        return settled_scene(scene, movements[scene.load_case.name])

    monkeypatch.setattr("masonry_opt.studies.crossing.passages.settled_scene", settles)
    cases = [mo.LoadCase(name=name, live={"axles": 1}) for name in movements]
    scene = beam(live=(0, 0)).replace(load_cases=cases)
    (passages,), _ = passages_of(scene, axles(3.0, road=[(0, 2), (5, 2)]), movements)
    assert [passage.case for passage in passages] == [*movements]
    at_the_pier = [float(np.interp(4.0, *passage.road.line.T)) for passage in passages]
    assert at_the_pier == pytest.approx([2 - 0.02 * 3 / 4, 2 - 0.04 * 3 / 4], abs=3e-4)


def test_load_factors_jump_between_two_blocks():
    """The load factor jumps where an axle passes from one block to the next.

    Left of x = 0, an axle is over a support. Right of x = 0, it turns the next block about the edge of its
    support at x = 0.5: λ P 0.5 = 0.5 W. Without friction, nothing connects the two blocks.
    """
    scene = mo.Scene(
        joints={"friction": 0.0, "dilatancy": 0.0},
        blocks=[slab("left", -2.0), slab("right", 0.0), support(-2.0, 0.0), support(0.5, 1.5)],
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
    """Return the scene with point loads, each on the voussoir whose extrados lies below it."""
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


@pytest.mark.slow
def test_no_load_by_hand_is_worse_than_the_least():
    scene = arch()
    found = mo.crossing(scene, ON_ARCH, method="static")
    swept = []
    for x in np.arange(-1.75, 2.6, 0.21).tolist():
        by_hand = at_points(scene, [(x, 60.0), (x - 0.8, 110.0)])
        if by_hand.loads:
            swept.append(mo.solve(by_hand, "static").load_factor or np.inf)
    assert found.bound <= found.load_factor * (1 + 1e-9) <= min(swept)
    again = at_points(scene, zip(found.at, (60.0, 110.0), strict=True))
    assert mo.solve(again, "static").load_factor == pytest.approx(found.load_factor, rel=1e-8)


#: Relative tolerance of sampled load factors against a bound; the programs are solved to 1e-9.
_SAMPLED = 1e-7


@pytest.mark.parametrize(
    ("strength", "law"), [(None, ""), pytest.param(900.0, "parabola", marks=pytest.mark.slow)]
)
def test_the_bound_is_of_the_associative_load_factor_by_its_own_law(strength, law):
    """No position has a lower associative load factor than the bound, if crushing follows the same law.

    The positions are solved as scenes with the axle as a load on a voussoir. Chords underestimate the moment
    by up to 0.65 %, so that λ with chords may be below the bound.
    """
    scene = arch(6)
    if strength:
        scene = scene.replace(joints={"friction": 0.45, "strength": strength})
    found = mo.crossing(scene, axles(60.0, road=[(-5.0, 2.3), (5.0, 2.3)]), method="static")
    (one,) = found.passages
    assert found.worst.crushing == law
    sampled = []
    for x in np.linspace(-1.6, 1.6, 9).tolist():
        answer = mo.solve(one.passage.scene(x), "static")
        assert answer.crushing == law
        sampled.append(answer.load_factor or np.inf)
    assert 0 < found.bound <= found.load_factor
    assert found.bound <= min(sampled) * (1 + _SAMPLED)
    facts = found.facts()
    assert "lower bound on the associative load factor" in facts["bound"]
    assert ("with crushing by the parabola" in facts["bound"]) == bool(strength)
    if strength:
        assert found.default.crushing == "chords"
        assert found.default.load_factor < found.bound
        # The associative load factor with the same chords is not lower.
        assert found.default.associative >= found.default.load_factor * (1 - _SAMPLED)
        assert (1 - 0.0065) * found.load_factor <= found.default.associative
        assert "by the same law" in facts["first look"]


@pytest.mark.slow
def test_a_coulomb_method_ends_at_the_least_of_its_own_sweep():
    scene = arch(8)
    found = mo.crossing(scene, ON_ARCH, method="nonassociative")
    (one,) = found.passages
    swept = [
        mo.solve(one.passage.scene(x), "nonassociative", incremental=False).load_factor or np.inf
        for x in one.associative.positions[::8]
        if one.passage.carried(x)
    ]
    assert found.load_factor <= min(swept) * (1 + 1e-3)
    assert len(found.table) < 0.6 * len(found.envelope)
    merged = found.table.merge(found.envelope, on="position")
    assert len(merged) > 20
    known = merged["load_factor"].notna() & merged["associative_y"].notna()
    assert (merged["load_factor"] <= merged["associative_y"] * (1 + 1e-6))[known].all()


@pytest.mark.slow
def test_a_changed_column_is_a_program_made_anew():
    scene = arch(12)
    assembly = assemble(scene)
    (one,) = mo.crossing(scene, ON_ARCH, method="static").passages
    moving = moving_load(one.passage.loaded(one.passage.live(0.3)).problem, Effort())
    for x in (0.3, -1.2, 1.9, -0.35, 2.4):
        live = one.passage.live(x)
        alone, moved = moving_load(one.passage.loaded(live).problem, Effort())(live), moving(live)
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
    # The last two loads are on an abutment and beyond the road.
    assert forces[:, 1].sum() == pytest.approx(-6)
    centroid = assembly.geometry.centroid + assembly.geometry.origin
    moment = forces[:, 2].sum() + (centroid[:, 0] * forces[:, 1]).sum()
    assert moment == pytest.approx(-(x[:3] @ load[:3]))


def arch_under_fill():
    """Return an arch of 14 voussoirs on fixed abutments, under fill."""
    bank = [(1.5, -1), (4, -1), (4, 0.18), (1.74, 0.18), (1.5, 0)]
    abutments = [
        mo.Block(name=name, vertices=[(side * x, y) for x, y in bank], fixed=True)
        for name, side in (("left", -1), ("right", 1))
    ]
    ring = mo.Arch(span=3, rise=0.75, thickness=0.3, voussoirs=14, unit_weight=22, abutments=False)
    return mo.Scene(
        joints=mo.JointDefaults(friction_angle=33),
        blocks=[*ring.blocks(), *abutments],
        fills=[mo.Fill(road=[(-4, 1.35), (4, 1.35)], unit_weight=19, friction_angle=35, mobilised=0.2)],
    )


@pytest.mark.slow
@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_bridge_with_fill_against_a_sweep(method):
    """The least load factor of a bogie on a bridge with fill agrees to 1e-3 with a sweep of positions.

    Loads spread through fill, so that λ does not jump. No load on a block is a linear or quadratic function
    of the position. With Coulomb friction, a position takes a hundred times as long; this test then uses a
    single arch of fewer voussoirs.
    """
    bridge = mo.load(CASES / "bridges" / "arch_with_fill.toml").model_copy(update={"loads": []})
    bogie = mo.Axles(name="bogie", set="CS 454 double 1.3 m", factor=0.4)
    if method == "static":
        near_the_least = np.arange(-0.27, -0.15, 0.01)
        scene, places = bridge, np.concatenate([np.arange(-0.6, 0.1, 0.05), near_the_least])
    else:
        near_the_least = np.arange(2.24, 2.29, 0.01)
        scene, places = arch_under_fill(), np.concatenate([np.arange(1.9, 2.6, 0.1), near_the_least])
        bogie = bogie.replace(road=[(-12, 1.35), (12, 1.35)])
    found = mo.crossing(scene, bogie, method=method, incremental=False)
    passage = found.least.passage
    swept = {x: mo.solve(passage.scene(x), method, incremental=False).load_factor for x in places.tolist()}
    assert min(swept, key=swept.get) not in (places.min(), places.max())
    assert found.load_factor <= min(swept.values()) * (1 + 1e-3)
    assert found.load_factor >= min(swept.values()) * (1 - 1e-3)
    if method == "static":
        assert found.bound <= min(swept.values())
        assert found.bound >= (1 - 2e-3) * found.load_factor


@pytest.mark.slow
@pytest.mark.parametrize("load_factor", [0.0, 0.5])
def test_a_load_factor_below_its_bound_is_no_longer_hidden(load_factor):
    """A load factor below its bound contradicts the bound: a warning says so, and no bound is given.

    The bound and the answer come from different programs.
    """
    found = mo.crossing(axles_on_a_beam(0.6), method="static")
    assert found.bound == pytest.approx(found.load_factor, rel=2e-3)
    assert found.warning_records == []
    solution = found.worst.solution
    lower = replace(solution, state=replace(solution.state, load_factor=load_factor))
    contradicted = replace(found, worst=replace(found.worst, solution=lower))
    (warning,) = contradicted.as_dict()["warnings"]
    assert warning["code"] == "below bound"
    assert (warning["load_factor"], warning["bound"]) == (load_factor, pytest.approx(found.bound))
    assert contradicted.bound is None
    assert "bound" not in contradicted.facts()


def test_a_bound_is_lowered_for_rounding_alone():
    found = mo.crossing(axles_on_a_beam(0.6), method="static")
    solution, less = found.worst.solution, found.bound * (1 - 1e-12)
    lower = replace(solution, state=replace(solution.state, load_factor=less))
    assert replace(found, worst=replace(found.worst, solution=lower)).bound == less


def at_first_position(trials):
    """Return the answers of a passage at its first position alone."""
    first = min(trials.answers)
    return replace(trials, answers={first: trials.answers[first]}, associative_trials=None)


def test_a_position_that_is_zero_but_for_rounding_is_printed_as_zero():
    """The road begins at 1.5e-9, and the first position is 5e-9 behind its start. The last position is 3."""
    blocks = [slab(), slab("second", 1.0), support(-0.5, 0.5), support(1.5, 2.5)]
    scene = mo.Scene(joints={"friction": 0.5}, blocks=blocks)
    found = mo.crossing(scene, axles(3.0, road=[(1.5e-9, 1), (5, 1)]), method="static")
    positions = found.table["position"]
    assert positions.min() == pytest.approx(6.5e-9, rel=0.01)
    assert positions.max() == pytest.approx(3, abs=1e-6)
    [table] = found.page_tables().values()
    column = table["columns"].index("first axle at")
    printed = [row[column] for row in table["rows"]]
    assert printed == ["0", *(f"{position:.6g}" for position in sorted(positions)[1:])]
    assert found.notebook_table["position"].tolist() == [0.0, *sorted(positions)[1:]]
    # If the first position is the worst one, it is also printed as zero.
    first = replace(found, passages=tuple(at_first_position(trials) for trials in found.passages))
    assert first.at == [positions.min()]
    assert first.facts()["position"] == "axles at x = 0"


@pytest.mark.parametrize("end", [1e-9, 1e-8])
def test_a_bound_differs_from_a_load_factor_near_zero_by_rounding_only(end):
    """The support ends almost below the centroid of the slab, so λ is almost zero: 12 × the distance."""
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[slab(), support(-0.5, end)])
    found = mo.crossing(scene, axles(1.0), method="static")
    assert found.load_factor == pytest.approx(WEIGHT * end, abs=1e-9)
    assert found.bound == pytest.approx(found.load_factor, abs=1e-9)
    assert "below bound" not in [record["code"] for record in found.warning_records]

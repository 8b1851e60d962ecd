"""Tests of the assessment of a crossing: loads at collapse, a required load factor, reasons for
differences."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from loads.overhang import OVERHANG, WEIGHT, axles, slab, support

import masonry_opt as mo
from masonry_opt.reporting.load_factors import meaning
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.solution import Solution
from masonry_opt.studies.crossing import crossing as module
from masonry_opt.studies.many.scene_answer import SceneAnswer
from masonry_opt.studies.many.trial import Trial
from masonry_opt.studies.report.report import _governing

#: The slab on joints of limited strength, so that methods differ by chords and parabola.
STRONG = OVERHANG.replace(joints={"friction": 0.5, "strength": 200.0})


#: An axle on a long road, of which few positions are on the slab: they are a hundredth of the road apart.
AXLE = axles(3.0, road=[(-20, 1), (20, 1)])


def crossed(group=AXLE, **options):
    return mo.crossing(OVERHANG, group, **{"method": "static"} | options)


@pytest.mark.slow
def test_loads_at_collapse():
    """At collapse the axle weighs W, whatever its load in the case is: λ P 0.5 = 0.5 W."""
    for load, factor in ((3.0, 1.0), (5.0, 1.0), (5.0, 2.0)):
        found = crossed(axles(load, factor=factor))
        assert found.axle_loads == [load * factor]
        assert found.capacity == pytest.approx([WEIGHT], rel=1e-6)
    assert crossed(axles(3.0)).facts()["at collapse"].endswith(": axle loads 12 = λ × 3")
    assert "(with the factor 2 of the group)" in crossed(axles(5.0, factor=2.0)).facts()["at collapse"]
    two = crossed(axles(1.0, 1.0, distances=[0.1]))
    assert two.capacity == pytest.approx([two.load_factor] * 2)
    assert "axle loads 2 × " in two.facts()["at collapse"]


def test_loads_at_collapse_contain_the_factor_of_the_load_case():
    case = mo.LoadCase(name="case", live={"axles": 1.5})
    found = mo.crossing(OVERHANG.replace(load_cases=[case]), axles(3.0), method="static")
    assert found.axle_loads == [4.5]
    assert found.capacity == pytest.approx([WEIGHT], rel=1e-6)
    assert "1.5 of the load case" in found.facts()["at collapse"]


@pytest.mark.slow
def test_loads_at_collapse_of_a_uniform_load():
    """A load of 8 per unit length over a length of 0.5 turns the slab at λ · 8 · 0.5 · 0.25 = 0.5 W."""
    group = axles(uniform=[mo.UniformLoad(load=8.0, start=0.0, end=0.5)])
    found = crossed(group)
    assert (found.axle_loads, found.capacity, found.at) == ([], [], [])
    assert found.uniform_loads == [8.0]
    assert "uniform loads 48 per unit length = λ × 8" in found.facts()["at collapse"]
    assert found.facts()["position"].startswith("uniform load from x = ")
    json = found.as_dict()
    assert (json["uniform_loads"], json["capacity"]) == ([8.0], [])


@pytest.mark.parametrize(("required", "passed"), [(3.9, True), (4.0, True), (4.1, False)])
def test_a_required_load_factor(required, passed):
    """A crossing passes if its least load factor, 4 by hand, is not below the required load factor."""
    found = crossed(required_factor=required)
    assert found.passed is passed
    assert found.as_dict()["passed"] is passed
    assert f"λ ≥ {required:g}: {'passed' if passed else 'failed'}" in str(found)


def test_the_picture_shows_a_required_load_factor_far_above_the_least():
    """The axis of λ usually ends at four times the least load factor; here it includes the required one."""
    chart = crossed(required_factor=100.0).plot().axes[0].child_axes[0]
    (line,) = [line for line in chart.get_lines() if line.get_label() == "required"]
    assert line.get_ydata()[0] == 100.0
    assert chart.get_ylim()[1] > 100.0


@pytest.mark.slow
def test_what_a_required_load_factor_is_compared_with():
    found = crossed(required_factor=3.5)
    proven = "proven lower bound on the associative load factor"
    assert proven in found.facts()["required"] or found.bound == 4
    # The default method found a lower load factor at the worst position.
    lighter = OVERHANG.replace(
        blocks={"slab": {"weight": 0.75 * WEIGHT, "live": (0.0, -3.0), "live_at": (1, 0.5)}}
    )
    less = replace(found, default=mo.solve(lighter))
    assert less.passed is False
    assert "upper bound by method 'coulomb'" in less.facts()["required"]
    interrupted = replace(found, interrupted=True)
    assert interrupted.passed is False
    assert "not decided, because the crossing was interrupted" in interrupted.facts()["required"]
    (one,) = found.passages
    failed = Solution(mo.Status.SOLVER_FAILED, Kind.ASSOCIATIVE)
    undecided = replace(found, passages=(replace(one, answers=one.answers | {0.7: failed}, bound=None),))
    assert undecided.passed is False
    assert "λ could not be computed at some positions" in undecided.facts()["required"]
    assert crossed().passed is None
    assert "required" not in crossed().facts()


def test_a_required_load_factor_between_both_bounds_is_undecided():
    """A proven lower bound below the required load factor does not prove that the scene fails."""
    found = crossed(required_factor=3.9)
    (trials,) = found.passages
    found = replace(found, passages=(replace(trials, bound=3.8),))
    assert found.passed is False
    assert "not decided, because the required load factor is between the proven lower bound 3.8" in str(found)
    assert "failed" in replace(found, required_factor=4.1).facts()["required"]
    assert (
        "passed, 3.800000 is 1.027 times the required"
        in replace(found, required_factor=3.7).facts()["required"]
    )


@pytest.fixture(scope="module")
def by_coulomb():
    return crossed(method="coulomb", incremental=False)


def test_a_least_load_factor_is_not_called_an_upper_bound(by_coulomb):
    proven = replace(by_coulomb, required_factor=3.0).facts()
    assert proven["governing λ"] == "4.000000 (least at this position, proven)"
    assert "upper bound" not in proven["required"]


def test_a_crossing_has_one_name_for_its_load_factor(by_coulomb):
    """With a Coulomb method nothing is proven along the road, so no page says "least, proven"."""
    found, early = by_coulomb, replace(by_coulomb, interrupted=True)
    proven, so_far = "least at this position, proven", "the least at the positions solved so far"
    assert _governing(found) == f"governing λ = 4 ({proven})"
    assert _governing(early) == f"interrupted, so that λ may be less than λ = 4 ({so_far})"
    for crossing, name in ((found, proven), (early, so_far)):
        answer = SceneAnswer(crossing.worst, crossing)
        assert Trial(1.0, True, 4.0, answer, None).name == answer.columns()["which"] == name
        assert f"({name})" in str(crossing)
        assert crossing.facts()["certainty"].startswith("at this position: ")
        assert "λ may be less" in meaning([name])
    assert not crossed().facts()["certainty"].startswith("at this position")


@pytest.fixture(scope="module")
def by_chords():
    return mo.crossing(STRONG, AXLE, method="nonassociative", incremental=False)


@pytest.fixture(scope="module")
def by_parabola():
    return mo.crossing(STRONG, AXLE, method="static", incremental=False)


def with_associative(result, associative):
    """Return a result with another associative load factor."""
    return replace(result, solution=replace(result.solution, associative=associative))


def test_a_load_factor_that_chords_do_not_explain_fails(by_chords, by_parabola):
    """λ = 3.1987 is compared with a Coulomb λ far below its associative λ, which the parabola raises by
    0.67 %, from 4.47 to 4.5."""
    low = replace(by_chords, worst=with_associative(by_chords.worst, 4.47), by_parabola=4.5)
    verdicts = {}
    for required in (3.1, 3.21, 3.23, 4.4, 4.6):
        verdicts[required] = replace(low, required_factor=required).facts()["required"].split(": ", 1)[1]
    assert verdicts[3.1].startswith("passed")
    assert verdicts[3.21].startswith("not decided, because 3.19")
    assert verdicts[3.23].startswith("failed, 3.22")
    assert verdicts[4.4].startswith("failed, 3.22")
    assert "is assumed to raise other values of λ by at most this factor" in verdicts[4.4]
    assert verdicts[4.6].startswith("failed")
    default = with_associative(by_parabola.default, 4.47)
    low = replace(by_parabola, default=default, required_factor=3.21)
    assert low.facts()["required"].startswith("λ ≥ 3.21: failed, 3.19")


def test_a_missing_load_factor_by_the_parabola_is_undecided(watched, monkeypatch):
    """The third solve is that of method "static" with the parabola.

    The first two solves are those of the first and of the worst position.
    """

    def ends(*_):
        if len(solved) == 3:
            raise KeyboardInterrupt

    solved = watched(module.Session, "solve", ends)
    found = mo.crossing(STRONG, AXLE, method="nonassociative", incremental=False, required_factor=3.3)
    assert (found.by_parabola, found.no_parabola, found.interrupted) == (None, "interrupted", False)
    assert found.as_dict()["no_parabola"] == "interrupted"
    assert "not decided, because 3.19" in found.facts()["required"]
    assert "the associative λ with the parabola is unknown: interrupted" in found.facts()["required"]
    assert "the associative λ with the parabola is unknown: interrupted" in found.facts()["crushing"]
    assert replace(found, required_factor=3.1).passed
    unlimited = SimpleNamespace(crushing="parabola", solution=SimpleNamespace(carries_any_load=True))
    monkeypatch.setattr(module, "_solved_by", lambda method, scene: (unlimited, ""))
    assert module._solved_by_parabola(STRONG) == (None, "any load is carried")


def test_chords_are_not_an_upper_bound_for_the_parabola(by_chords, by_parabola):
    """The slab with a strength of 200 rocks about a point in the joint at a distance n / (2 f) from its edge.

    With n = W + P, the equilibrium P (1 - 1/2 + n / 400) = W (1/2 - n / 400) has the solution P = 3 λ.
    """
    chords, parabola = by_chords, by_parabola
    load = np.roots([1 / 400, 0.5 + 2 * WEIGHT / 400, WEIGHT * (WEIGHT / 400 - 0.5)]).max()
    assert parabola.load_factor == pytest.approx(load / 3, rel=1e-6)
    assert 0.99 * parabola.load_factor < chords.load_factor < 0.995 * parabola.load_factor
    assert "28 chords inside the crushing parabola, at most 0.65 % below it" in chords.facts()["crushing"]
    assert "is the associative load factor with chords" in chords.facts()["associative"]
    assert chords.by_parabola == pytest.approx(parabola.load_factor, rel=1e-6)
    assert "the associative λ at this position is 3.218417, 0.6" in chords.facts()["crushing"]
    assert "failed" in replace(chords, required_factor=3.22).facts()["required"]
    assert "not decided" in replace(chords, required_factor=3.21).facts()["required"]
    assert "passed, 3.1" in replace(chords, required_factor=3.1).facts()["required"]
    between = replace(parabola, required_factor=3.21)
    assert between.facts()["required"].startswith("λ ≥ 3.21: not decided, because 3.19")


@pytest.mark.slow
def test_a_scene_that_falls_fails_and_one_that_carries_any_load_passes():
    off = OVERHANG.replace(blocks={"slab": {"weight_at": (0.6, 0.5)}})
    fallen = mo.crossing(off, axles(3.0), method="static", required_factor=1.0)
    assert fallen.passed is False
    assert "failed, because the scene is unstable" in str(fallen)
    wide = mo.Scene(joints={"friction": 0.5}, blocks=[slab(), support(-3, 3)])
    held = mo.crossing(wide, axles(3.0, road=[(-1, 1), (1, 1)]), method="static", required_factor=1e6)
    assert (held.load_factor, held.passed, held.capacity) == (None, True, [])
    assert "passed, because any load is carried" in str(held)


@pytest.mark.parametrize("value", [0, -1.0, float("nan"), float("inf"), "3", True])
def test_a_required_load_factor_is_a_positive_number(value):
    with pytest.raises(mo.OptionError, match="required_factor must be a number above 0"):
        crossed(required_factor=value)


@pytest.mark.slow
def test_the_command_ends_with_the_verdict(tmp_path, command):
    mo.save(OVERHANG.replace(axles=[axles(3.0)]), tmp_path / "slab.toml")
    asked = ("crossing", tmp_path / "slab.toml", "--method", "static", "--required-factor")
    assert "λ ≥ 3.9: passed" in command(*asked, "3.9")
    assert "λ ≥ 4.1: failed" in command(*asked, "4.1", code=1)
    assert command.json(*asked, "4.1", code=1)["passed"] is False
    assert "above 0" in command.refused(*asked, "0")


@pytest.mark.slow
def test_bounds_say_why_they_differ_from_the_answer():
    static = crossed().facts()
    assert "Coulomb friction may lower λ below this bound" in static["bound"]
    assert "the same as the associative load factor" in static["first look"]
    coulomb = mo.crossing(OVERHANG, AXLE, method="nonassociative", incremental=False).facts()
    assert "bound" not in coulomb
    assert "λ is the same as the associative load factor" in coulomb["associative"]


@pytest.mark.slow
def test_chords_are_named_as_a_reason():
    ring = mo.Arch(radius=2, angles=(150, 30), thickness=0.3, voussoirs=6, unit_weight=20)
    scene = mo.Scene(joints={"friction": 0.45, "strength": 900.0}, blocks=ring.blocks())
    found = mo.crossing(scene, axles(60.0, road=[(-5.0, 2.3), (5.0, 2.3)]), method="static")
    facts = found.facts()
    assert "(chords inside the parabola lower λ by " in facts["first look"]
    assert "chords inside the crushing parabola may lower λ below this bound" in facts["bound"]


@pytest.mark.slow
def test_the_picture_has_a_legend_of_hinges_fill_and_loads():
    ring = mo.Arch(radius=2, angles=(150, 30), thickness=0.3, voussoirs=6, unit_weight=20)
    backing = mo.Backing(line=[(-1.7, 1.6), (1.7, 1.6)], unit_weight=20)
    road = [(-1.7, 2.5), (1.7, 2.5)]
    fill = mo.Fill(road=road, unit_weight=18, friction_angle=30, mobilised=0.3, backing=backing)
    scene = mo.Scene(joints={"friction": 0.5}, blocks=ring.blocks(), fills=[fill])
    long = [(-5, 2.5), (5, 2.5)]
    group = axles(40.0, road=long, uniform=[mo.UniformLoad(load=10.0, start=0.5, end=1.0)])
    found = mo.crossing(scene, group, method="static", incremental=False, required_factor=1.0)
    (legend,) = found.plot().legends
    labels = [text.get_text() for text in legend.get_texts()]
    assert {"fill", "backing", "road", "axle", "uniform load", "required", "worst"} < {*labels}
    assert any("hinging" in label or "sliding" in label for label in labels)
    assert len(labels) == len({*labels})
    assert {"block", "support"} < {*labels}

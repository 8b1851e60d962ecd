"""Warnings about scenes that look unintended appear for the inputs that they concern, and for no others."""

import json
from math import inf

import pytest
from atlas.small_scenes import rectangle
from scenes import ALL_CASES, block_on_floor, run_command, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.reporting.sentences import message
from masonry_opt.solution.reasons import Code, reason
from masonry_opt.solution.sense import warnings_of

#: Façades with ten thousand joints or more.
LARGE = {"facade_3x9", "facade_4x12"}
#: Larger façades from the same generator, with the same stones and joints as the smaller façades.
LIKE_SMALLER = {"facade_6x18", "facade_8x24", "facade_10x30"}


def warned(scene, code):
    """Return the values of all warnings with a code."""
    return [warning.values for warning in warnings_of(assemble(scene), None) if warning.code is code]


def with_blocks(scene, *blocks):
    return scene.replace(blocks=[*scene.blocks, *blocks])


def row(*weights, **of_first):
    """Return a scene with a row of separate unit cubes on a floor, with the weights given. The keyword
    arguments are properties of the first cube, such as a live load."""
    cubes = [
        rectangle(f"{n}", 2 * n, 0, 2 * n + 1, 1, weight=weight, **({} if n else of_first))
        for n, weight in enumerate(weights)
    ]
    floor = rectangle("floor", -1, -1, 2 * len(weights), 0)
    return mo.Scene(joints={"friction": 0.5}, blocks=[*cubes, floor])


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.slow if path.stem in LARGE else ())
        for path in ALL_CASES
        if path.stem not in LIKE_SMALLER
    ],
)
def test_no_case_is_warned_of(path):
    assert warnings_of(assemble(mo.load(path)), None) == ()


@pytest.mark.parametrize("kind", ["ties", "props"])
def test_a_support_in_which_a_tie_or_prop_ends_is_not_idle(kind):
    above = rectangle("above", 0, 5, 1, 6)
    scene = with_blocks(block_on_floor(), above)
    assert warned(scene, Code.IDLE_SUPPORTS) == [{"blocks": ["above"]}]
    strut = {"ties": mo.Tie, "props": mo.Prop}[kind](between=("A", "above"), at=((0.5, 1.9), (0.5, 5.1)))
    assert warned(scene.replace(**{kind: [strut]}), Code.IDLE_SUPPORTS) == []


@pytest.mark.parametrize(("friction", "is_warned"), [(3.0, False), (3.001, True), (35.0, True), (inf, False)])
def test_friction_in_degrees(friction, is_warned):
    expected = [{"friction": friction, "pairs": []}] if is_warned else []
    assert warned(block_on_floor(friction=friction), Code.FRICTION_HIGH) == expected
    named = two_blocks().replace(exceptions=[mo.Joint(between=("B", "support"), friction=friction)])
    expected = [{"friction": friction, "pairs": [["B", "support"]]}] if is_warned else []
    assert warned(named, Code.FRICTION_HIGH) == expected


@pytest.mark.parametrize(
    ("dilatancy", "is_warned"), [(0.5, False), (-0.5, False), (-0.51, True), (-5.0, True)]
)
def test_contraction_that_friction_does_not_resist(dilatancy, is_warned):
    scene = small_wall(2, 2, friction=0.5, dilatancy=dilatancy)
    expected = [{"dilatancy": dilatancy, "friction": 0.5, "pairs": []}] if is_warned else []
    assert warned(scene, Code.DILATANCY_LOW) == expected
    # Here the friction of one joint is too small for the dilatancy, which is the same for all joints.
    less = [mo.Joint(between=("A", "floor"), friction=0.1)]
    scene = block_on_floor().replace(friction=0.5, dilatancy=-0.3, exceptions=less)
    values = {"dilatancy": -0.3, "friction": 0.1, "pairs": [["A", "floor"]]}
    assert warned(scene, Code.DILATANCY_LOW) == [values]


def test_supports_that_touch_nothing():
    """A fixed block without a movable neighbour causes a warning, unless it supports a fill."""
    scene = with_blocks(block_on_floor(), rectangle("idle", 2, 5, 3, 6), rectangle("below", -5, -2, 6, -1))
    assert warned(scene, Code.IDLE_SUPPORTS) == [{"blocks": ["idle", "below"]}]
    assert warned(block_on_floor(), Code.IDLE_SUPPORTS) == []
    scene = with_blocks(block_on_floor(), rectangle("ground", 6, -1, 15, 0))
    fill = mo.Fill(road=[(0, 3), (15, 3)], unit_weight=18, pressure=False)
    assert warned(scene, Code.IDLE_SUPPORTS) == [{"blocks": ["ground"]}]
    assert warned(scene.replace(fills=[fill]), Code.IDLE_SUPPORTS) == []
    # Where the floor and the slab overlap, only the floor has a joint.
    scene = with_blocks(block_on_floor(), rectangle("slab", 0, -0.4, 0.5, 0))
    assert warned(scene, Code.IDLE_SUPPORTS) == []


#: Diagonal of the bounding box of the block and its floor, 11 by 3.
SIZE = 130**0.5


@pytest.mark.parametrize(("times", "is_warned"), [(9.9, False), (10.1, True)])
def test_blocks_far_from_all_others(times, is_warned):
    """A fixed block, or a block with its own floor, causes a warning if its distance from the others is more
    than ten times their size. The first floor ends at x = 6."""
    left = 6 + times * SIZE
    alone = rectangle("far", left, 0, left + 1, 1)
    group = [rectangle("B", left, 0, left + 1, 1, weight=1), rectangle("its floor", left, -1, left + 1, 0)]
    for blocks in ([alone], group):
        found = warned(with_blocks(block_on_floor(), *blocks), Code.FAR_AWAY)
        assert [values["blocks"] for values in found] == (
            [[block.name for block in blocks]] if is_warned else []
        )
        if is_warned:
            assert found[0]["distance"] == pytest.approx(times * SIZE)
            assert found[0]["size"] == pytest.approx(SIZE)
    # Two floors are 9 apart, which is far relative to the tiny one, but not relative to the other.
    tiny = [rectangle("B", 15, 0, 15.1, 0.1, weight=1), rectangle("its floor", 15, -0.1, 15.1, 0)]
    assert warned(with_blocks(block_on_floor(), *tiny), Code.FAR_AWAY) == []


@pytest.mark.parametrize(
    ("shaped", "quantity"),
    [
        (lambda scene: scene, "weight per area"),
        (lambda scene: scene.replace(thickness=0.5), "unit weight"),
        (mo.extrude, "unit weight"),
    ],
    ids=["plane", "thick", "space"],
)
@pytest.mark.parametrize(
    ("weights", "names", "ratio"),
    [
        ((1, 1, 1, 299), [], None),
        ((1, 1, 1, 301), ["3"], 301),
        ((1, 1, 1, 1 / 301), ["3"], 1 / 301),
        ((1, 500, 1, 1 / 1000), ["3", "1"], 1 / 1000),
        ((1, 0, 0, 0), [], None),
        ((0, 0), [], None),
        ((1, 1000), ["1"], 1000),
    ],
)
def test_weights_of_other_units(weights, names, ratio, shaped, quantity):
    found = warned(shaped(row(*weights, live=(1, 0))), Code.WEIGHTS_DIFFER)
    assert [values["blocks"] for values in found] == ([names] if names else [])
    if names:
        assert found[0]["ratio"] == pytest.approx(ratio)
        assert message([reason(Code.WEIGHTS_DIFFER, **found[0])]).startswith(f"the {quantity} of ")


@pytest.mark.parametrize(
    ("load", "force", "is_warned"),
    [
        ("live", 590, False),
        ("live", 610, True),
        ("live", 1e-6, False),  # a unit force in a small unit
        ("dead", 590, False),
        ("dead", 610, True),
        ("dead", 2 / 990, False),
        ("dead", 2 / 1010, True),
    ],
)
def test_forces_of_other_units(load, force, is_warned):
    """A force above 300 times the weight of its block, 2, causes a warning, as does a dead force below 1/1000
    of it. On a light plate, a force that is usual for the other blocks causes none."""
    found = warned(row(2, 2, 2, **{load: (0.6 * force, 0.8 * force)}), Code.FORCES_DIFFER)
    assert [values["load"] for values in found] == ([load] if is_warned else [])
    if is_warned:
        assert found[0]["blocks"] == ["0"]
        assert found[0]["ratio"] == pytest.approx(force / 2)
    assert warned(row(0.001, 1, 1, live=(100.0, 0.0)), Code.FORCES_DIFFER) == []


@pytest.mark.parametrize("load", ["live", "dead", "load"])
@pytest.mark.parametrize(
    ("point", "distance"),
    [((0.5, 1.0), None), ((1.0, 2.0), None), ((1.02, 1.0), None), ((1.1, 1.0), 0.1), ((4.0, 6.0), 5.0)],
)
def test_forces_that_act_outside_of_their_blocks(load, point, distance):
    """Forces on a block 1 by 2 are applied at its middle, on a corner, and 0.02, 0.1 and 5 outside of it. The
    force is a property of the block, or a load that names the block."""
    if load == "load":
        scene, load = block_on_floor().replace(loads=[mo.Load(block="A", dead=(0, -0.1), at=point)]), "dead"
    else:
        scene = block_on_floor(**{"dead": (0.0, -1.0 * (load == "dead")), f"{load}_at": point})
    found = warned(scene, Code.ACTS_OUTSIDE)
    assert [(values["load"], values["blocks"]) for values in found] == ([(load, ["A"])] if distance else [])
    assert [values["distance"] for values in found] == pytest.approx([distance] if distance else [])


def test_forces_may_act_in_a_notch_and_the_farthest_is_named_first():
    outline = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    notched = mo.Block(name="L", vertices=outline, weight=1, live=(1, 0), live_at=(1.5, 1.5))
    scene = block_on_floor(live_at=(9, 1))
    beside = rectangle("B", 5, 0, 6, 1, weight=1, live=(1, 0), live_at=(0, 0))
    assert warned(scene.replace(blocks=[notched, scene.blocks[1]]), Code.ACTS_OUTSIDE) == []
    # The forces are 8 and 5 away from their blocks.
    (found,) = warned(with_blocks(scene, beside), Code.ACTS_OUTSIDE)
    assert found["blocks"] == ["A", "B"]


def test_small_gaps_are_told_with_both_blocks_and_their_width():
    gaps = [rectangle(name, x, 0, end, 2, weight=1) for name, x, end in (("B", 1.0002, 2), ("C", 2.0007, 3))]
    scene = with_blocks(block_on_floor(), *gaps)
    (found,) = warned(scene, Code.SMALL_GAPS)
    assert found["pairs"] == [["B", "C"], ["A", "B"]]
    assert found["widths"] == pytest.approx([0.0007, 0.0002])
    assert warned(scene.replace(tolerance=0.001), Code.SMALL_GAPS) == []


@pytest.mark.slow
def test_warnings_are_shown_wherever_the_result_is(monkeypatch, capsys, tmp_path):
    """Warnings appear in Python, on the command line and in JSON. They change neither the load factor nor the
    exit code."""
    case = tmp_path / "case.toml"
    mo.save(with_blocks(block_on_floor(friction=35.0), rectangle("idle", 2, 5, 3, 6)), case)
    codes = [Code.FRICTION_HIGH, Code.IDLE_SUPPORTS]
    result = mo.solve(case)
    assert result.load_factor == pytest.approx(0.5, rel=1e-7)
    assert [warning.code for warning in result.warnings] == codes
    exit_code, out, err = run_command(monkeypatch, capsys, "solve", case)
    assert (exit_code, out.count("warning: ")) == (0, 0)
    assert err.splitlines() == [f"warning: {sentence}" for sentence in result.warning_sentences]
    _, out, _ = run_command(monkeypatch, capsys, "solve", case, "--json")
    records = json.loads(out)["warnings"]
    assert [warning["code"] for warning in records] == [str(code) for code in codes]
    assert [warning["sentence"] for warning in records] == list(result.warning_sentences)
    assert records[0]["friction"] == 35.0
    assert [warning.code for warning in mo.check(case).warnings] == codes
    exit_code, out, err = run_command(monkeypatch, capsys, "check", case)
    assert (exit_code, out.count("warning: ")) == (0, 0)
    assert err.count("warning: ") == 2


def on_two_tips(weight=8.0, **of_left):
    """Return a slab, 4 by 1/2, on the tips of two fixed stones 3 apart, pushed sideways by its weight. A
    third tip touches the end of the slab without pressing on it."""
    slab = rectangle("slab", 0, 2, 4, 2.5, weight=weight, live=(weight, 0))
    tips = {"left": [(0, 1), (1, 1), (0.5, 2)], "right": [(3, 1), (4, 1), (3.5, 2)]}
    tips["behind"] = [(-1, 2), (0, 2.25), (-1, 2.5)]
    stones = [mo.Block(name=name, vertices=corners, fixed=True) for name, corners in tips.items()]
    exceptions = [mo.Joint(between=("slab", "left"), **of_left)] if of_left else []
    return mo.Scene(joints={"friction": 0.5}, blocks=[slab, *stones], exceptions=exceptions)


@pytest.mark.parametrize(
    ("method", "weight"), [("coulomb", 8.0), ("static", 8.0), ("static", 8e6), ("nonassociative", 8e6)]
)
def test_corners_that_press_where_strength_is_limited(method, weight):
    """The warning names the corners that press on edges of limited strength. The slab slides at λ = μ.
    Moments about the middle of its base, 1/4 below its centroid, yield n₂ − n₁ = μ W/4 / (3/2)."""

    def warning_values(scene):
        result = mo.solve(scene, method)
        assert result.required() == pytest.approx(0.5, rel=1e-3)
        return [warning.values for warning in result.warnings if warning.code is Code.CORNERS_BEAR]

    left, right = weight * (1 / 2 - 1 / 24), weight * (1 / 2 + 1 / 24)
    (values,) = warning_values(on_two_tips(weight).replace(strength=100.0))
    assert [set(pair) for pair in values["pairs"]] == [{"slab", "right"}, {"slab", "left"}]
    assert values["normal_forces"] == pytest.approx([right, left], rel=1e-3)
    (values,) = warning_values(on_two_tips(weight, strength=100.0))
    assert values["normal_forces"] == pytest.approx([left], rel=1e-3)
    assert warning_values(on_two_tips(weight)) == []

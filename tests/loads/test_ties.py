"""Tests of ties and props: closed forms by hand and comparisons with equivalent loads, in the plane and in
space."""

import json
import warnings

import numpy as np
import pytest
from atlas.held_scenes import held
from scenes import block_on_floor, on_floor
from speeds import slow

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.blocks import rectangle

METHODS = (*("static", "kinematic", "nonassociative", "coulomb", "incremental"),)
TO_THE_LEFT = {"A": {"live": (-1.0, 0.0)}}
#: Tolerance of load factors against closed forms: the error that solvers leave.
CLOSE = 1e-7


def tied(friction: float, height: float = 1.5, **tie: float) -> mo.Scene:
    """Return a block of width 1, height 2 and weight 1, held back by a horizontal tie to the ground."""
    rod = mo.Tie(between=("A", "ground"), at=((0.5, height), (-4, height)), **tie)
    return block_on_floor(friction=friction).replace(ties=[rod])


def solve_by(method: str, scene: mo.Scene) -> mo.Result:
    """Return the result of a method, without the incremental load factor of the default method."""
    return mo.solve(scene, method, **({"incremental": False} if method == "coulomb" else {}))


def in_space(scene: mo.Scene) -> mo.Scene:
    return mo.extrude(scene, 0.7)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("friction", [0.9, 0.45], ids=["turns", "slides"])
def test_a_tie_adds_its_strength_by_its_lever(method, friction):
    """The load factor is the lesser of two closed forms.

    If the block turns about its right edge, λ W h/2 = W b/2 + T y. If it slides, λ W = μ W + T.
    """
    T, y = 0.1, 1.5
    exact = min(0.5 + 2 * T * y / 2, friction + T)
    scenes = [tied(friction, y, strength=T)]
    # In space, each method solves the block that turns. One method solves the block that slides.
    if friction > 0.5 or method == "static":
        scenes.append(in_space(scenes[0]))
    for scene in scenes:
        result = solve_by(method, scene)
        assert result.load_factor == pytest.approx(exact, abs=CLOSE)
        assert result.ties["force"].tolist() == pytest.approx([T], abs=CLOSE)
        assert result.ties["yields"].tolist() == [True]


def test_prestress_acts_against_a_load_the_other_way():
    """If the block is pushed to the left, the tie slackens to its prestress P: λ W h/2 = W b/2 − P y."""
    left = mo.solve(tied(0.9, strength=0.4, prestress=0.05).replace(blocks=TO_THE_LEFT))
    assert left.load_factor == pytest.approx(0.5 - 0.05 * 1.5, abs=CLOSE)
    assert left.ties["force"].tolist() == pytest.approx([0.05])
    assert left.ties["yields"].tolist() == [False]


def test_about_a_tie_that_never_yields_the_foot_slides_out():
    """A block with a tie that never yields turns about the tie, and its foot slides out.

    By moments about the tie at height y, λ W (y − h/2) = μ W y + W b/2. The weight is on the corner on which
    the block turns.
    """
    for friction in (0.3, 0.6):
        exact = (friction * 1.5 + 0.5) / 0.5
        assert mo.solve(tied(friction), method="static").load_factor == pytest.approx(exact, abs=CLOSE)


@pytest.mark.parametrize(("strength", "exact"), [(None, (0.9 * 1.5 + 0.5) / 0.5), (0.1, 0.65)])
def test_a_prop_pushes_back_and_never_pulls(strength, exact):
    """A prop on the right at y = 1.5 pushes back, and does not pull if the block is pushed to the left.

    If the prop yields at N, λ = b/h + 2 N y/(W h). If it never yields, the foot slides out below it, as below
    a tie.
    """
    prop = mo.Prop(between=("A", "ground"), at=((1, 1.5), (4, 1.5)), strength=strength)
    scene = block_on_floor(friction=0.9).replace(props=[prop])
    result = mo.solve(scene, method="static")
    assert result.load_factor == pytest.approx(exact, abs=CLOSE)
    assert result.ties["yields"].tolist() == [strength is not None]
    free = mo.solve(scene.replace(blocks=TO_THE_LEFT))
    assert free.load_factor == pytest.approx(0.5, abs=CLOSE)
    assert free.ties["force"].tolist() == pytest.approx([0.0], abs=CLOSE)


def stacked(low: float, high: float, friction: float) -> mo.Scene:
    """Return two stacked blocks of the given heights, each pushed by its weight of 1."""
    push = {"weight": 1, "live": (1, 0)}
    A = mo.Block(name="A", vertices=rectangle(0, 1, 0, low), **push)
    return on_floor(
        A, mo.Block(name="B", vertices=rectangle(0, 1, low, low + high), **push), friction=friction
    )


def test_a_yielding_tie_is_its_strength_as_a_dead_load():
    """A tie that yields acts as its strength does as a dead load: λ of two stacked blocks is the same to
    1e-7."""
    scene = stacked(1, 1, friction=0.7)
    rod = mo.Tie(between=("B", "ground"), at=((0.5, 1.5), (-1.5, 0)), strength=0.2)
    with_rod = mo.solve(scene.replace(ties=[rod]))
    assert with_rod.ties["yields"].tolist() == [True]
    pull = 0.2 * np.array([-2, -1.5]) / 2.5
    by_hand = mo.Load(block="B", dead=tuple(pull), at=(0.5, 1.5))
    instead = mo.solve(scene.replace(loads=[by_hand]))
    assert with_rod.load_factor == pytest.approx(instead.load_factor, abs=CLOSE)


@pytest.mark.parametrize("space", [False, True])
def test_a_limited_force_is_one_column_and_two_faces(space):
    scene = tied(0.6, strength=0.1)
    scenes = [scene, scene.replace(ties=[]), tied(0.6), scene.replace(ties=[*scene.ties, *tied(0.6).ties])]
    one, none, endless, two = (assemble(in_space(s) if space else s).problem for s in scenes)
    assert one.B.shape[1] - none.B.shape[1] == 1
    assert one.faces - none.faces == 2
    assert endless.faces - none.faces == 1  # The tie pulls, and never yields.
    assert two.B.shape[1] - none.B.shape[1] == 2
    np.testing.assert_array_equal(one.B[:, :-1].toarray(), none.B.toarray())
    np.testing.assert_array_equal(one.true_yield[:-2, :-1].toarray(), none.true_yield.toarray())
    np.testing.assert_array_equal(one.face_cohesion[:-2], none.face_cohesion)
    np.testing.assert_allclose(one.D(one.friction).toarray(), one.C(one.friction).toarray().T)


def answer_beside_duality(scene):
    """Return the default answer for a scene whose four associative programs agree to 1e-8.

    Returns None if the programs have no load factor.
    """
    try:
        table = mo.check(scene).table
    except mo.MasonryError:
        assert mo.solve(scene, method="static").load_factor is None
        return None
    assert np.ptp(table["load_factor"]) <= 1e-8 * max(1.0, table["load_factor"].max())
    return mo.solve(scene, incremental=False)


@pytest.mark.parametrize(
    ("kind", "seed", "space"),
    [
        ("wall", 2, False),
        *slow(("filled", 0, False), ("arch", 1, False), ("tessellation", 1, False)),
        *slow(("wedges", 9, True), ("piers", 10, True)),
    ],
)
def test_duality_and_certificates_of_held_scenes(kind, seed, space):
    """Associative programs agree for scenes with ties and props, and the Coulomb load factor is not above
    theirs.

    The Coulomb state is exact in the plane. The Coulomb load factor of the wall is 1.258, and its associative
    load factor is 2.264. An answer without a load factor states its reasons.
    """
    result = answer_beside_duality(held(kind, seed, space))
    if result is None:
        return
    if result.load_factor is None:
        assert result.reasons
    else:
        assert result.exact or space
        assert not result.assembly.problem.load_factor_scale.is_lower(result.associative, result.load_factor)
        if kind == "wall":
            assert result.load_factor < 0.6 * result.associative


def test_results_tell_of_ties():
    result = mo.solve(tied(0.9, strength=0.1), method="static")
    row = json.loads(result.to_json())["tie_results"][0]
    assert (row["name"], row["kind"], row["yields"]) == ("A|ground", "tie", True)
    assert row["lengthens"] > 0
    unlimited = json.loads(mo.solve(tied(0.3), method="static").to_json())
    assert unlimited["tie_results"][0]["highest"] is None
    assert "tie_results" not in json.loads(mo.solve(block_on_floor(), method="static").to_json())


@pytest.mark.parametrize("strength", [None, 200.0])
def test_a_tie_below_its_strength_does_not_yield_where_contacts_give(strength):
    """With elastic contacts, a tie below its strength does not yield, although it lengthens.

    The lower block slides out. The tie on the upper block lengthens because the contacts deform.
    """
    rod = mo.Tie(between=("B", "ground"), at=((0.5, 2.5), (-4, 0)), strength=strength)
    loads = {"A": {"weight": 40, "live": (10, 0)}, "B": {"weight": 20, "live": (5, 0)}}
    scene = stacked(2, 1, friction=0.6).replace(blocks=loads, ties=[rod])
    result = mo.solve(mo.extrude(scene, 0.8), method="incremental")
    assert result.ties["force"].item() == pytest.approx(123.5476, abs=1e-3)
    assert not result.ties["yields"].any()


@pytest.mark.parametrize(
    ("tie", "named"),
    [
        ({"between": ("A", "B")}, "B"),
        ({"between": ("floor", "ground")}, "floor"),
        ({"at": ((3, 3), (-4, 3))}, "tie no. 1 .* 'A', but it is in no block"),
        ({"at": ((0.5, -0.5), (-4, 3))}, "'A', but it is in 'floor'"),
        ({"at": ((0.5, 1, 0), (-4, 1, 0))}, "x, y"),
        ({"at": ((0.5, 1), (0.5, 1))}, "at"),
        ({"at": ((1e-30, 1), (2e-30, 1))}, "tolerance"),
        ({"strength": 0}, "strength"),
        ({"strength": 1e12}, "has the limit"),
        ({"prestress": 1e12}, "has the limit"),
        ({"strength": 0.1, "prestress": 0.2}, "prestress"),
        ({"between": ("A", "A")}, "between"),
    ],
)
def test_wrong_ties_are_refused_by_name(tie, named):
    keys = {"between": ("A", "ground"), "at": ((0.5, 1), (-4, 1))} | tie
    with pytest.raises(mo.CaseError, match=named):
        mo.solve(block_on_floor().replace(ties=[keys]))


def test_what_does_not_know_ties_says_so():
    with pytest.raises(mo.OptionError, match="tie"):
        mo.solve(tied(0.9, strength=0.1), method="global")
    with pytest.raises(mo.CaseError, match="tie"):
        tied(0.9, strength=0.1).replace(blocks={"A": {"live": (0.0, 0.0)}}, tilt="right")


def test_ties_of_one_name_are_swept_one_by_one():
    """Two ties between the same ends are swept one by one: λ is 1/2 plus 2 T y/(W h) of each tie."""
    scene = tied(0.9, strength=0.1)
    two = scene.replace(ties=2 * scene.ties)
    for number in (1, 2):
        table = mo.sweep(two, {f"tie.{number}.strength": [0.05, 0.1]}, method="static", workers=1)
        assert table["load_factor"].tolist() == pytest.approx([0.725, 0.8], abs=CLOSE)


@pytest.mark.parametrize("named", ["tie", "tie.rod"])
def test_a_tie_alone_is_swept_with_or_without_its_name(named):
    """The only tie of a scene is swept with or without its name: λ of the block that turns is 1/2 + 2 T
    y/(W h)."""
    scene = tied(0.9, strength=0.1)
    scene = scene.replace(ties=[scene.ties[0].replace(name="rod")])
    table = mo.sweep(scene, {f"{named}.strength": [0.05, 0.1]}, method="static", workers=1)
    assert table["load_factor"].tolist() == pytest.approx([0.575, 0.65], abs=CLOSE)


def test_a_number_is_not_swept_by_two_names():
    scene = tied(0.9, strength=0.1)
    scene = scene.replace(ties=[scene.ties[0].replace(name="rod")])
    both = {"tie.strength": [0.05], "tie.rod.strength": [0.1]}
    with pytest.raises(
        mo.OptionError, match=r"'tie\.strength' and 'tie\.rod\.strength' are the same parameter"
    ):
        mo.sweep(scene, both, method="static", workers=1)
    with pytest.raises(mo.OptionError, match=r"no parameter is called 'tie\.bar\.strength'"):
        mo.sweep(scene, {"tie.bar.strength": [0.1]}, method="static", workers=1)


def hung(push_at: float, strength: float | None = None) -> mo.Scene:
    """Return a scene with a unit cube of weight 1 that touches no block and hangs on three ties.

    Two vertical ties hold its upper corners, and a horizontal tie holds it at half its height. The cube is
    pushed to the right at the height `push_at` above its foot. Another block rests on the floor.
    """
    cube = [(0, 3), (1, 3), (1, 4), (0, 4)]
    ends = [((0, 4), (0, 6)), ((1, 4), (1, 6)), ((0, 3.5), (-3, 3.5))]
    ties = [mo.Tie(between=("cube", "ground"), at=at) for at in ends]
    block = mo.Block(name="cube", vertices=cube, weight=1, live=(1, 0), live_at=(0.5, 3 + push_at))
    scene = block_on_floor(live=(0.0, 0.0))
    return scene.replace(blocks=[*scene.blocks, block], ties=[*ties[:2], ties[2].replace(strength=strength)])


@pytest.mark.parametrize("method", [*(method for method in METHODS if method != "coulomb"), *slow("coulomb")])
def test_blocks_that_ties_alone_hold(method):
    """The load factors of a cube that only ties hold agree with closed forms, by all methods.

    The horizontal tie yields at λ W = T. Pushed at 3/4 of its height, the cube lifts when the moment λ W/4
    about the horizontal tie has shifted all weight to one vertical tie: λ/4 = 1/2.
    """
    for scene, exact in ((hung(0.5, 0.3), 0.3), (hung(0.75), 2.0)):
        assert solve_by(method, scene).load_factor == pytest.approx(exact, abs=CLOSE)
        if method == "static" or (method == "coulomb" and exact == 0.3):
            assert solve_by(method, in_space(scene)).load_factor == pytest.approx(exact, abs=CLOSE)


def test_what_ties_cannot_hold():
    scene = hung(0.5)
    # The cube swings until its centroid is below the tie.
    aside = mo.solve(scene.replace(ties=scene.ties[:1]), "static")
    assert aside.status == "unstable under dead load"
    with pytest.raises(mo.CaseError, match="'cube' touches no other block"):
        mo.solve(scene.replace(ties=[]), "static")
    floating = mo.Tie(between=("cube", "A"), at=((0.5, 3.5), (0.5, 2.5)))
    apart = mo.Block(name="A", vertices=[(0, 2), (1, 2), (1, 2.8), (0, 2.8)], weight=1)
    without_a = [block for block in scene.blocks if block.name != "A"]
    loose = scene.replace(blocks=[*without_a, apart], ties=[floating])
    alone = r"'cube' \(likewise 1 more: 'A'\) is not connected to any fixed block"
    with pytest.raises(mo.CaseError, match=alone):
        mo.solve(loose, "static")


def hanging(count=1, size=1.0, force=1.0, strength=1.0, weight=0.233, aside=0.0):
    """Return bricks that hang below each other, each on its own wire; the lowest brick is pulled down by
    λ."""
    blocks, ties = [], []
    for number in range(count + 1):
        y = -2.0 * number
        corners = [(size * x, size * (y + z)) for x, z in ((-1, -0.5), (1, -0.5), (1, 0.5), (-1, 0.5))]
        keys = {"weight": force * weight} if number else {"fixed": True}
        if number == count:
            keys["live"] = (0, -force)
        blocks.append(mo.Block(name=f"brick {number}", vertices=corners, **keys))
        if number:
            ends = ((size * aside, size * (y + 0.3)), (size * aside, size * (y + 1.7)))
            between = (f"brick {number}", f"brick {number - 1}")
            ties.append(mo.Tie(between=between, at=ends, strength=force * strength))
    return mo.Scene(joints={"friction": 0.5}, blocks=blocks, ties=ties)


@pytest.mark.parametrize(
    ("method", "space"),
    [*((method, False) for method in METHODS), ("static", True), *slow(("coulomb", True))],
)
def test_a_scene_without_joints_hangs_on_its_wires(method, space):
    """A scene without joints collapses when its uppermost wire yields, by all methods.

    By hand, the wire of strength 1 yields at λ = 1 - 0.233, and the uppermost of three wires at 1 - 3 · 0.1.
    In space the bricks can also turn about their wires, so that the mechanism is not unique.
    """
    for scene, exact in ((hanging(), 0.767), (hanging(3, 1e-3, 5e5, weight=0.1), 0.7)):
        result = solve_by(method, in_space(scene) if space else scene)
        assert result.load_factor == pytest.approx(exact, abs=CLOSE)
        assert len(result.joints) == 0
        if not space:
            assert result.ties["yields"].to_list() == [True, *[False] * (len(scene.ties) - 1)]


def test_props_alone_hold_a_plank():
    """A plank of weight 2 on two props, 4 apart, collapses when the right prop yields.

    The live load acts at 3/4 of the span. The right prop carries 1 + 3/4 λ = 2.
    """
    blocks = [mo.Block(name="floor", vertices=[(-9, -3), (9, -3), (9, -2), (-9, -2)], fixed=True)]
    plank = [(-2.5, 0), (2.5, 0), (2.5, 0.2), (-2.5, 0.2)]
    blocks.append(mo.Block(name="plank", vertices=plank, weight=2, live=(0, -1), live_at=(1, 0.1)))
    props = [mo.Prop(between=("plank", "floor"), at=((x, 0.1), (x, -2.0)), strength=2.0) for x in (-2.0, 2.0)]
    scene = mo.Scene(joints={"friction": 0.5}, blocks=blocks, props=props)
    for method in ("static", "coulomb"):
        assert mo.solve(scene, method).load_factor == pytest.approx(4 / 3, abs=CLOSE)


@pytest.mark.slow
def test_a_hanging_scene_is_drawn_checked_exported_and_answered_without_live_load(tmp_path):
    scene = hanging()
    result = mo.solve(scene)
    for name, kind in (
        ("mechanism.png", "mechanism"),
        ("thrust.svg", "thrust"),
        ("page.html", "utilisation"),
    ):
        result.save(tmp_path / name, kind)
    assert mo.check(scene).passed
    mo.draw(scene, tmp_path / "scene.png")
    mo.report(result, tmp_path / "report.html")
    for name in ("program.lp", "program.mps", "program.nl"):
        mo.export(scene, tmp_path / name)
    unloaded = scene.replace(blocks={"brick 1": {"live": (0, 0)}})
    stable = mo.solve(unloaded)
    assert (stable.status, stable.stability.unique) == ("stable", True)
    assert (stable.stability.geometric_margin, stable.stability.worst_joint) == (None, None)
    assert stable.ties["force"].to_list() == pytest.approx([0.233], abs=CLOSE)
    stable.save(tmp_path / "stable.html")
    with pytest.raises(mo.MasonryError, match="no blocks touch"):
        mo.check(unloaded)
    assert mo.solve(unloaded.replace(ties=[unloaded.ties[0].replace(strength=0.2)])).status.startswith(
        "unstable"
    )
    assert mo.solve(hanging(aside=0.1)).status.startswith("unstable")  # The brick would swing.


def test_a_brick_on_a_wire_beside_its_middle_swings_without_a_numerical_warning():
    """A brick on one wire slightly beside its middle is unstable. No warning reports the damped motion.

    The wire carries all but a small moment, which no damping balances.
    """
    scene = hanging(aside=1e-4).replace(blocks={"brick 1": {"live": (0, 0)}})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert mo.solve(scene).status.startswith("unstable")


def test_the_ground_reaches_farther_than_its_block():
    """A tie to the ground may end outside of a fixed block named "ground"; the block need not contain the
    anchor."""
    found = mo.solve(tied(0.9, strength=0.1).replace(blocks={"floor": {"name": "ground"}}), method="static")
    assert found.load_factor == pytest.approx(0.65, abs=CLOSE)
    assert found.ties["second"].tolist() == ["ground"]


def hung_from_ground(strengths, **brick):
    """Return a brick of weight 0.233 that hangs on two wires from the ceiling at its ends, without a fixed
    block."""
    ends = [(-0.1, 0.03), (0.1, 0.03)]
    outline = [(-0.11, -0.03), (0.11, -0.03), (0.11, 0.03), (-0.11, 0.03)]
    wires = [
        mo.Tie(between=("brick", "ground"), at=(end, (end[0], 1.0)), strength=strength)
        for end, strength in zip(ends, strengths, strict=True)
    ]
    block = mo.Block(name="brick", vertices=outline, weight=0.233, **brick)
    return mo.Scene(blocks=[block], joints={"friction": 0.5}, ties=wires)


@pytest.mark.parametrize("method", METHODS)
def test_a_brick_hangs_on_two_wires_from_the_ground(method):
    """Each wire carries half of the load, so λ = 2 · 0.5 − 0.233 if the weaker wire yields at 0.5."""
    result = mo.solve(hung_from_ground((0.5, 1.0), live=(0, -1)), method)
    assert result.load_factor == pytest.approx(0.767, abs=CLOSE)
    assert result.ties["yields"].tolist() == [True, False]


def test_without_live_load_a_brick_on_two_wires_is_stable_and_on_one_it_falls():
    stable = mo.solve(hung_from_ground((0.5, 1.0)))
    assert stable.status is mo.Status.STABLE
    assert stable.ties["force"].tolist() == pytest.approx([0.1165, 0.1165])
    one = hung_from_ground((0.5, 1.0))
    assert mo.solve(one.replace(ties=one.ties[:1])).status is mo.Status.UNSTABLE


@pytest.mark.parametrize("method", ["static", "coulomb", "incremental"])
def test_a_solid_hangs_on_three_wires_from_the_ground(method):
    """Two wires at one end carry a quarter of the load each: λ = 4 · 0.25 − 0.233 if one of them yields."""
    span = (-0.11, 0.11), (-0.05, 0.05), (-0.03, 0.03)
    brick = mo.Solid(name="brick", box=span, weight=0.233, live=(0, 0, -1))
    wires = [
        mo.Tie(between=("ground", "brick"), at=((x, y, 1), (x, y, 0.03)), strength=strength)
        for x, y, strength in ((-0.1, -0.04, 0.25), (-0.1, 0.04, 0.3), (0.1, 0, 1))
    ]
    scene = mo.Scene(blocks=[brick], gravity=(0, 0, -1), joints={"friction": 0.5}, ties=wires)
    result = mo.solve(scene, method)
    assert result.load_factor == pytest.approx(0.767, abs=CLOSE)
    assert result.ties["force"].tolist() == pytest.approx([0.25, 0.25, 0.5], abs=CLOSE)
    assert "friction" not in result.summary


def test_blocks_apart_from_a_hanging_one_still_need_a_support():
    scene = hung_from_ground((0.5, 1.0))
    far = mo.Block(name="far", vertices=[(3, 0), (4, 0), (4, 1), (3, 1)], weight=1)
    with pytest.raises(mo.CaseError, match="'far' touches no other block"):
        mo.solve(scene.replace(blocks=[*scene.blocks, far]))
    with pytest.raises(mo.CaseError, match=r'no block is fixed.*end a tie at "ground"'):
        scene.replace(ties=[])


def test_a_movable_block_named_ground_supports_nothing():
    """A tie that ends at "ground" ends at the block of this name, even if that block can move."""
    scene = hung_from_ground((0.5, 1.0))
    above = mo.Block(name="ground", vertices=rectangle(-0.2, 0.2, 1, 1.2), weight=1, fixed=True)
    assert mo.solve(scene.replace(blocks=[*scene.blocks, above])).stability
    with pytest.raises(mo.CaseError, match=r"no block is fixed, not even the block named 'ground': mark"):
        scene.replace(blocks=[*scene.blocks, above.replace(fixed=False)])


def test_an_error_of_a_capacity_curve_names_all_ties_that_must_be_omitted():
    result = mo.solve(hung_from_ground((0.5, 1.0), live=(0, -1)), "static")
    ties = r"\[\[tie\]\] 'brick\|ground', 'brick\|ground': omit them, or use 'solve' to compute"
    with pytest.raises(mo.OptionError, match=ties):
        mo.capacity(result)

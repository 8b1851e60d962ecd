"""Tests of case files of textbooks and of ``cases/closed_forms``: each load factor is calculated by hand.

:data:`KNOWN` has all load factors, with associative flow and without dilatancy. The rest of this file derives
the numbers. It also tests other frictions and further facts about the cases.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
from hinges import four_hinge_load_factors, radial_joints
from scenes import CASES, solved
from speeds import slow

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.acceptance import PROVEN_GAP
from masonry_opt.solution.answer import certify

METHODS = ["static", "coulomb", "nonassociative"]


def read(name: str) -> mo.Scene:
    return mo.load(CASES / f"{name}.toml")


def changed(name: str, friction: float, *exceptions: mo.Joint) -> mo.Scene:
    joints = mo.JointDefaults(friction=friction)
    return read(name).model_copy(update={"joints": joints, "exceptions": list(exceptions)})


# Beer & Johnston, sample problem 8.4: a wedge of 8° raises and lowers a block, with friction 0.35. The weight
# W, the reaction R of the wedge at an angle a to the vertical, and the push N of the guide with its friction
# are in equilibrium: R sin a = N, and R cos a = W + μ N if the block rises, W - μ N if it sinks.

FRICTION = 0.35
WEDGE = math.radians(8)
ANGLE = math.atan(FRICTION)


def on_wedge(reaction: float, guide: float) -> float:
    """Return the force on the wedge, R sin a + μ R cos a, since the floor has friction too.

    `guide` is the friction of the guide divided by its push, positive upwards.
    """
    return 400.0 / (1 + guide * math.tan(reaction)) * (math.tan(reaction) + FRICTION)


RAISING = on_wedge(ANGLE + WEDGE, -FRICTION)
LOWERING = on_wedge(ANGLE - WEDGE, FRICTION)
#: If the dilatancy is μ, it exceeds the slope: the block rises although the wedge is pulled out.
DILATING = on_wedge(ANGLE - WEDGE, -FRICTION)

# Meriam & Kraige, sample problem 6/5: three blocks lie on an incline of 30°, and the middle one is pulled
# down. Only weights press the blocks on each other, so that all friction forces are known.

TOP, MIDDLE, BOTTOM = (mass * 9.81 for mass in (30, 50, 40))
ABOVE, BETWEEN, BELOW = (
    friction * weight * math.sqrt(0.75)
    for friction, weight in ((0.30, TOP), (0.40, TOP + MIDDLE), (0.45, TOP + MIDDLE + BOTTOM))
)
ALONE = ABOVE + BETWEEN - MIDDLE / 2
TOGETHER = ABOVE + BELOW - (MIDDLE + BOTTOM) / 2


def tan(degrees: float) -> float:
    return math.tan(math.radians(degrees))


#: Livesley's wedges (section 5.1, Fig. 8): uplift divided by the weight of a wedge, with φ = 9° and abutments
#: that are inclined by 10°.
LIVESLEY = tuple(1 + (tan(9) - tan(1)) / (tan(9) + tan(other)) for other in (1, 19))


def by_four_hinges(name: str) -> float:
    """Return λ of an arch by enumeration of four hinges; the voussoirs weigh as annular sectors do."""
    arch = read(name).case.arch[0]
    angles = np.radians(np.linspace(*arch.angles, arch.voussoirs + 1))
    outer, inner = (arch.radius + side * arch.thickness / 2 for side in (1, -1))
    angle = angles[0] - angles[1]
    area = angle / 2 * (outer**2 - inner**2)
    distance = 2 / 3 * np.sin(angle / 2) / (angle / 2) * (outer**3 - inner**3) / (outer**2 - inner**2)
    middles = (angles[1:] + angles[:-1]) / 2
    at = distance * np.stack([np.cos(middles), np.sin(middles)], axis=1)
    found = four_hinge_load_factors(radial_joints(arch), np.full(arch.voussoirs, area), at)
    np.testing.assert_allclose(found, found[0], rtol=1e-9)
    return float(found[0])


#: Unit weight of the dam's masonry divided by that of water, and width over height of its triangular section.
#: Down to any depth y, the dam weighs γ (b/h) y² / 2, at a third of its width from the water. The water
#: pushes with y² / 2, at a third of the depth above the joint there. Therefore λ is the same for every joint.
GAMMA = 2.4
SLENDER = 0.65


class Known(NamedTuple):
    """Load factors with associative flow and with Coulomb friction, and the tolerances of the methods and
    the loop."""

    associative: float
    coulomb: float
    near: float = 1e-8
    of_loop: float = 1e-8


KNOWN = {
    "beer_johnston/wedge_raises": Known(RAISING, RAISING),
    "beer_johnston/wedge_lowers": Known(DILATING, LOWERING),
    "meriam_kraige/three_blocks": Known(TOGETHER, TOGETHER),
    "livesley/wedges": Known(*LIVESLEY, of_loop=1e-6),
    "oppenheim/seven_voussoirs": Known(*2 * (by_four_hinges("oppenheim/seven_voussoirs"),)),
    # Makris & Vassiliou (2013): columns that carry a beam uplift at b/h, as columns without a beam do.
    "makris_vassiliou/rocking_frame": Known(1 / 4, 1 / 4, of_loop=1e-6),
    # Fig. 6: 2.5 μ with associative flow, 1.5 μ with Coulomb friction.
    "gilbert/two_blocks": Known(0.25, 0.15, of_loop=1e-3),
    # Each leaf turns about its toe, at width over height: the face of one leaf slides up the face of the
    # other.
    "closed_forms/two_leaves": Known(*2 * (125 / (30 * 65),), near=1e-7, of_loop=1e-7),
    "closed_forms/dam_slides": Known(*2 * (0.75 * GAMMA * SLENDER,), near=1e-7, of_loop=1e-7),
    "closed_forms/dam_overturns": Known(*2 * (2 * GAMMA * SLENDER**2,), near=1e-7, of_loop=1e-7),
    # The faces are inclined by 1 in 2 and open at once, so that nothing rubs.
    "closed_forms/keystone": Known(1.0, 1.0, near=1e-7, of_loop=1e-7),
    # Paterson & Zwick: the blocks extend by s = 0.9 of the overhang at balance, and the topmost block turns
    # at (1 - s) / s.
    **{f"paterson_zwick/harmonic_{count}": Known(1 / 9, 1 / 9) for count in (2, 3, 5)},
    # The right block of 0.9 turns about the end of the base, 0.05 from its centre and 0.4 from its tip.
    "paterson_zwick/best_3": Known(1 / 8, 1 / 8),
}
#: All cases by all methods, with two exceptions. The loop finds no state or another state of rows and stacks.
#: The default solves the two leaves in a test of its own.
SOLVED = [
    (name, method)
    for name in KNOWN
    for method in METHODS
    if not (method == "nonassociative" and name.startswith("paterson_zwick"))
    and (name, method) != ("closed_forms/two_leaves", "coulomb")
]


#: Slow cases: all of the loop except one, whose Coulomb load factor differs from the associative one.
SLOW_CASES = [
    (name, method)
    for name, method in SOLVED
    if method == "nonassociative" and name != "beer_johnston/wedge_lowers"
]


@pytest.mark.parametrize(
    ("name", "method"), [*(pair for pair in SOLVED if pair not in SLOW_CASES), *slow(*SLOW_CASES)]
)
def test_load_factor(name, method):
    """The load factor agrees with the closed form; numbers in case files have twelve digits."""
    known = KNOWN[name]
    expected = known.associative if method == "static" else known.coulomb
    near = known.of_loop if method == "nonassociative" else known.near
    assert solved(CASES / f"{name}.toml", method).load_factor == pytest.approx(expected, rel=near)


@pytest.mark.slow
def test_the_load_history_ends_in_the_state_of_the_two_leaves():
    """The load history finds the load factor of the two leaves, and its forces lead to the exact state.

    The leaves move far at a constant load, so the load history takes several seconds.
    """
    name = "closed_forms/two_leaves"
    result = solved(CASES / f"{name}.toml")
    assert result.exact
    assert [entry.step for entry in result.solution.log] == [
        "incremental analysis",
        "exact state from the incremental forces",
    ]
    load_factors = [result.load_factor, *(entry.load_factor for entry in result.solution.log)]
    assert load_factors == pytest.approx([KNOWN[name].coulomb] * 3, rel=KNOWN[name].near)


@pytest.mark.parametrize("name", KNOWN)
def test_references_of_case_files_are_the_closed_forms(name):
    """References agree with the closed forms within the tolerance that the file states."""
    known, references = KNOWN[name], read(name).reference
    for key, expected in (("associative", known.associative), ("coulomb", known.coulomb)):
        if key in references:
            assert references[key].value == pytest.approx(expected, rel=references[key].tolerance), key
    assert {"associative", "coulomb"} & {*references}


def test_closed_forms_are_the_published_numbers():
    assert pytest.approx(423, abs=0.5) == RAISING
    assert pytest.approx(206, abs=0.55) == LOWERING  # from forces that are rounded to three digits
    assert pytest.approx(400 * math.tan(2 * ANGLE - WEDGE), rel=1e-12) == DILATING
    assert pytest.approx(103.1, abs=0.05) == ALONE
    assert min(ALONE, TOGETHER) == pytest.approx(93.8, abs=0.05)
    assert pytest.approx((1.80147, 1.28034), abs=5e-6) == LIVESLEY
    assert KNOWN["oppenheim/seven_voussoirs"].coulomb == pytest.approx(0.370, abs=5e-4)
    arch = "casapulla_lauro/arch"
    assert by_four_hinges(arch) == pytest.approx(read(arch).reference["associative"].value, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("beer_johnston/wedge_raises", PROVEN_GAP),
        ("beer_johnston/wedge_lowers", PROVEN_GAP),
        ("livesley/wedges", 1e-9),
        ("oppenheim/seven_voussoirs", 1e-9),
    ],
)
def test_no_coulomb_state_is_lower(name, near):
    """The bound of method "global" proves that no Coulomb state is lower than the closed form.

    If the case closes the gap to the solver's own tolerance, the load factor is optimal too.
    """
    result, expected = solved(CASES / f"{name}.toml", "global"), KNOWN[name].coulomb
    assert result.bound == pytest.approx(expected, rel=PROVEN_GAP)
    if near < PROVEN_GAP:
        assert result.status is mo.Status.OPTIMAL
        assert result.load_factor == pytest.approx(expected, rel=near)


def moves(name: str, method: str):
    return solved(CASES / f"{name}.toml", method).blocks.set_index("block")


def test_mechanisms_differ_with_the_flow_rule():
    """Mechanisms agree with the flow rule.

    The lowered block sinks by the slope of the wedge that is pulled out; with dilatancy it rises. The
    unloaded wedge of Livesley's rises in Fig. 8 (a) and not in (b), and the loaded wedge moves by 1 in both.
    Of the three blocks, the middle one moves the bottom one along, and the top one stays.
    """
    true, dilatant = (moves("beer_johnston/wedge_lowers", method) for method in ("coulomb", "static"))
    assert true["vy"]["B"] == pytest.approx(math.tan(WEDGE) * true["vx"]["A"], rel=1e-8)
    assert true["vx"]["A"] < 0
    assert dilatant["vy"]["B"] > 0
    true, dilatant = (moves("livesley/wedges", method) for method in ("global", "static"))
    assert true["vy"]["right"] < 0 < dilatant["vy"]["right"]
    assert [true["vy"]["left"], dilatant["vy"]["left"]] == pytest.approx([1, 1], rel=1e-6)
    x = moves("meriam_kraige/three_blocks", "coulomb")["vx"]
    assert x["bottom"] == pytest.approx(x["middle"], rel=1e-9)
    assert x["top"] == pytest.approx(0, abs=1e-9)
    rougher = {"joints": mo.JointDefaults(friction=0.6)}
    found = solved(read("meriam_kraige/three_blocks").model_copy(update=rougher))
    assert found.load_factor == pytest.approx(ALONE, rel=1e-8)


def test_the_loop_itself_ends_near_the_wedges():
    """The bare loop ends 9e-5 below the closed form, because of its small cohesion and its last slope."""
    path = CASES / "livesley" / "wedges.toml"
    assert solved(path, "nonassociative").certificate.complementarity < 1e-7
    bare = solved(path, "nonassociative", finish=False)
    assert bare.load_factor == pytest.approx(LIVESLEY[1], rel=2e-4)


@pytest.mark.parametrize(
    ("beam", "friction", "expected"), [(0.01, 0.6, 1 / 4), (100.0, 0.6, 1 / 4), (5.0, 0.2, 0.2)]
)
def test_any_beam_uplifts_at_the_slenderness_or_slides(beam, friction, expected):
    """Columns uplift at b/h or slide at μ, whatever the weight of the beam.

    Columns of b × h that turn by θ move the beam by θ b and θ h, and their own centroids by half as much.
    """
    scene = changed("makris_vassiliou/rocking_frame", friction)
    scene = scene.replace(blocks={"beam": {"weight": beam, "live": (beam, 0.0)}})
    for method in METHODS:
        assert solved(scene, method).load_factor == pytest.approx(expected, rel=1e-6)
    if expected == 1 / 4:
        blocks = solved(scene).blocks.set_index("block")
        assert blocks["omega"]["left column"] == pytest.approx(blocks["omega"]["right column"], rel=1e-9)
        assert blocks["omega"]["beam"] == pytest.approx(0, abs=1e-9)
        assert blocks["vy"]["beam"] == pytest.approx(blocks["vx"]["beam"] / 4, rel=1e-9)


def test_friction_between_leaves_is_nothing_to_rely_on():
    """The leaves stay in contact without pressing on each other: an exact state, although dilatancy would
    bond them."""
    bonded = changed("closed_forms/two_leaves", 0.65)
    passed = solved(bonded)
    assert passed.certificate.worst < 1e-8
    assert passed.load_factor == pytest.approx(125 / 1950, rel=1e-8)
    assert solved(bonded, "static").load_factor > 1.1 * passed.load_factor


MU = 0.5


def pulled(wall: float) -> float:
    """Return λ of A under B, for a friction of the wall on B divided by its push of ``wall`` (upwards
    positive).

    The friction of A pushes B against the wall with μ n, so that n = 1 - wall μ n of the weight 1 of B rests
    on A. A, of weight 1, slides on the bed below B and on the floor: λ = μ n + μ (n + 1).
    """
    n = 1 / (1 + wall * MU)
    return MU * n + MU * (n + 1)


@pytest.mark.parametrize("wall", [0.0, MU])
def test_a_stone_pulled_out_beside_a_wall(wall):
    """λ has its largest value with dilatancy, and its least value if the wall carries part of B.

    With dilatancy B rises, and the friction of the wall holds B down. Without dilatancy B does not move, and
    the friction of the wall may act upwards.
    """
    scene = changed("closed_forms/pulled_stone", MU, mo.Joint(between=("B", "wall"), friction=wall))
    assert solved(scene, "static").load_factor == pytest.approx(pulled(-wall), rel=1e-8)
    lowest = solved(scene, "global")
    assert lowest.load_factor == pytest.approx(pulled(wall), rel=1e-8)
    assert lowest.bound == pytest.approx(pulled(wall), rel=1e-6)
    for method in ("coulomb", "nonassociative"):
        found = solved(scene, method).load_factor
        assert pulled(wall) * (1 - 1e-6) <= found <= pulled(-wall) * (1 + 1e-6)


@pytest.mark.parametrize("wall", [-MU, 0.3])
def test_any_friction_of_the_wall_is_an_exact_state(wall):
    """There is an exact state for each friction of the wall, because B does not move along the wall.

    A slides out at every load factor between the least and the associative one.
    """
    assembly = assemble(read("closed_forms/pulled_stone"))
    problem = assembly.problem
    bed, floor, side = range(3)  # Joints A-B, A-floor and B-wall in q: n at starts, n at ends, shears.
    second, shear = 3, 6
    conditions = np.zeros((4, 10))
    conditions[0, [bed, second + bed, shear + bed]] = MU, MU, -1  # A drags B to the right.
    conditions[1, [floor, second + floor, shear + floor]] = MU, MU, 1
    conditions[2, [side, second + side, shear + side]] = wall, wall, -1
    # The wall presses 0.3 units away from the middle of its face, towards the start.
    off = 0.3 * problem.length_unit / (assembly.joints.extent[side] / 2)
    conditions[3, [side, second + side]] = off - 1, off + 1
    matrix = np.vstack([np.column_stack([problem.B.toarray(), problem.live]), conditions])
    *q, load_factor = np.linalg.solve(matrix, np.concatenate([-problem.dead, np.zeros(4)]))
    assert load_factor == pytest.approx(pulled(wall), rel=1e-9)
    out = np.array([1.0, 0, 0, 0, 0, 0])
    assert certify(problem, load_factor, np.array(q), out, problem.dilatancy).worst < 1e-12


@pytest.mark.parametrize(("friction", "expected"), [(0.6, 4 / 3), (0.3, 0.3 * 4 / 1.7)])
def test_a_buttress_overturns_or_slides(friction, expected):
    """λ is the least over all joints of turning about a toe and of sliding.

    The thrust λ (2, -1) acts at the height 7 on a pile of stones of weight 4, 2 × 2 each. It turns the k
    stones above a joint about the toe of this joint, or pushes them off the joint.
    """
    found = []
    for stones in range(1, 5):
        weight, lever = 4 * stones, 7 - (8 - 2 * stones)
        found.append(friction * weight / (2 - friction))
        if 2 * lever > 2:  # Otherwise the thrust passes inside of this toe.
            found.append(weight / (2 * lever - 2))
    assert min(found) == pytest.approx(expected, rel=1e-12)
    for method in METHODS:
        result = solved(changed("closed_forms/buttress", friction), method)
        assert result.load_factor == pytest.approx(expected, rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.3, 0.45])
def test_two_stones_that_lean_on_each_other_spread(friction):
    """λ of two leaning stones agrees with moments by hand.

    The least thrust H passes through the top of the crown, 4 high, and through the inner end of the
    springing, 2 from the crown. Therefore 4 H = W a + 2 λ, where a is the distance from this end to the
    centroid of the stone. The stone slides at H = μ (W + λ).
    """
    weight = 6.0
    # The stone is the triangle (-4, 0), (0, 0), (0, 4) without the triangle (-2, 0), (0, 0), (0, 3).
    arm = (8 * -4 / 3 - 3 * -2 / 3) / (8 - 3) + 2
    expected = (friction * weight - weight * arm / 4) / (2 / 4 - friction)
    for method in (*METHODS, "global"):
        found = solved(changed("closed_forms/pitched_stones", friction), method).load_factor
        assert found == pytest.approx(expected, rel=1e-7)


@pytest.mark.slow
def test_more_friction_than_slope_locks_what_dilates():
    """Joints whose dilatancy exceeds the slope of their motion are locked with associative flow.

    Stones that lean on each other never spread. The faces of a keystone open by sin β and slide by cos β,
    with tan β = 1/2, which is too little for a larger dilatancy. Without dilatancy, nothing rubs.
    """
    assert solved(changed("closed_forms/pitched_stones", 0.51), "static").status is mo.Status.LOCKED
    assert solved(changed("closed_forms/keystone", 0.499), "static").load_factor == pytest.approx(1, rel=1e-7)
    assert solved(changed("closed_forms/keystone", 0.501), "static").status is mo.Status.LOCKED
    for method in ("coulomb", "nonassociative", "global"):
        found = solved(changed("closed_forms/keystone", 0.7), method).load_factor
        assert found == pytest.approx(1, rel=1e-7)


@pytest.mark.slow
def test_leaning_stones_do_not_spread_without_dilatancy():
    """A proof by cuts, which takes a second or more, shows that no collapse state exists."""
    result = solved(changed("closed_forms/pitched_stones", 0.51))
    assert result.status is mo.Status.UNLIMITED
    assert result.solution.proven_none


@pytest.mark.parametrize("voussoir", [2, 4])
def test_a_parabolic_arch_under_fill_of_one_depth(voussoir):
    """λ of a parabolic arch under fill of constant depth agrees with the closed form to 1e-8.

    Let f be the height of the thrust line above the intrados, x the distance from the left springing, and a
    the x of the load. H is the horizontal thrust.

    Between the loads H y'' = -w, and the intrados has y'' = -8 r / L², so f'' = 2 k = 8 r / L² - w / H. The
    thrust line passes through the intrados at x = 0 and through the extrados at a. It touches the intrados at
    c, and passes through the extrados at L: f = k (x - c)² with c = (a + L) / 2, k = 4 t / (L - a)².

    At the load, the slope of f falls by P / H, from k a + t / a on the left to -4 t / (L - a). For a = L / 4
    this is P = 25 w L t / (2 (9 r - 16 t)).
    """
    span, rise, t, a = 16.0, 3.0, 0.8, float(voussoir)
    k = 4 * t / (span - a) ** 2
    thrust = (22 * t + 18) / (8 * rise / span**2 - 2 * k)
    expected = thrust * (k * a + t / a + 4 * t / (span - a))
    if voussoir == 4:
        by_hand = 25 * (22 * t + 18) * span * t / (2 * (9 * rise - 16 * t))
        assert expected == pytest.approx(by_hand, rel=1e-12)
    scene = read("closed_forms/parabola_under_fill")
    back = scene.blocks[voussoir - 1].vertices[2]
    load = mo.Load(block=f"v{voussoir}", live=(0, -1), at=back)
    for method in METHODS:
        found = solved(scene.model_copy(update={"loads": [load]}), method).load_factor
        assert found == pytest.approx(expected, rel=1e-8)

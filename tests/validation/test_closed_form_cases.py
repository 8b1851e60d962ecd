"""The cases of ``cases/closed_forms``: each load factor worked out by hand."""

import math

import numpy as np
import pytest
from scenes import CASES, block_on_floor, solved

import masonry_opt as mo
from masonry_opt.answer.answer import certify
from masonry_opt.problem.assembly import assemble

FOLDER = CASES / "closed_forms"
METHODS = ["static", "mcp", "nonassociative"]


def changed(name: str, friction: float, *exceptions: mo.Joint) -> mo.Scene:
    scene = mo.load(FOLDER / f"{name}.toml")
    joints = mo.JointDefaults(friction=friction)
    return scene.model_copy(update={"joints": joints, "exceptions": list(exceptions)})


@pytest.mark.parametrize("method", METHODS)
def test_two_leaves_overturn_one_by_one(method):
    """Each about its toe, at width over height. Both turn alike, and the one's face slides up the other's."""
    expected = 125 / (30 * 65)
    assert expected == pytest.approx(0.0641026, abs=5e-8)
    result = solved(FOLDER / "two_leaves.toml", method)
    assert result.load_factor == pytest.approx(expected, rel=1e-7)


def test_friction_between_leaves_is_nothing_to_rely_on():
    """They stay in touch without pressing on each other: an exact state, though dilatancy would bond them."""
    bonded = changed("two_leaves", 0.65)
    passed = solved(bonded)
    assert passed.certificate.worst < 1e-8
    assert passed.load_factor == pytest.approx(125 / 1950, rel=1e-8)
    assert solved(bonded, "static").load_factor > 1.1 * passed.load_factor


MU = 0.5


def pulled(wall: float) -> float:
    """A under B, whose friction against the wall, over its push, is ``wall`` (upwards positive).

    A's friction pushes B against the wall with μ n, so n = 1 - wall μ n of B's weight 1 rests on A; A (1)
    slides on the bed below B and on the floor: λ = μ n + μ (n + 1).
    """
    n = 1 / (1 + wall * MU)
    return MU * n + MU * (n + 1)


@pytest.mark.parametrize("wall", [0.0, 0.25, MU])
def test_a_stone_pulled_out_beside_a_wall(wall):
    """The wall holds B down as dilatancy lifts it; at best it bears B as B stays where it is."""
    scene = changed("pulled_stone", MU, mo.Joint(between=("B", "wall"), friction=wall))
    assert solved(scene, "static").load_factor == pytest.approx(pulled(-wall), rel=1e-8)
    lowest = solved(scene, "global")
    assert lowest.load_factor == pytest.approx(pulled(wall), rel=1e-8)
    assert lowest.bound == pytest.approx(pulled(wall), rel=1e-6)
    for method in ("mcp", "nonassociative"):
        found = solved(scene, method).load_factor
        assert pulled(wall) * (1 - 1e-6) <= found <= pulled(-wall) * (1 + 1e-6)


@pytest.mark.parametrize("wall", [-MU, -0.2, 0.0, 0.3, MU])
def test_any_friction_of_the_wall_is_an_exact_state(wall):
    """B does not move against the wall, whose friction is what it may be: A slides out at every load factor
    between the least and the associative one."""
    assembly = assemble(mo.load(FOLDER / "pulled_stone.toml"))
    problem = assembly.problem
    bed, floor, side = range(3)  # A-B, A-floor, B-wall: n at their starts, at their ends, then shears in q
    second, shear = 3, 6
    conditions = np.zeros((4, 10))
    conditions[0, [bed, second + bed, shear + bed]] = MU, MU, -1  # A drags B to the right
    conditions[1, [floor, second + floor, shear + floor]] = MU, MU, 1
    conditions[2, [side, second + side, shear + side]] = wall, wall, -1
    # Where the wall presses: 0.3 units off the middle of its face, towards the start.
    off = 0.3 * problem.length_unit / (assembly.joints.extent[side] / 2)
    conditions[3, [side, second + side]] = off - 1, off + 1
    matrix = np.vstack([np.column_stack([problem.B.toarray(), problem.live]), conditions])
    *q, load_factor = np.linalg.solve(matrix, np.concatenate([-problem.dead, np.zeros(4)]))
    assert load_factor == pytest.approx(pulled(wall), rel=1e-9)
    out = np.array([1.0, 0, 0, 0, 0, 0])
    assert certify(problem, load_factor, np.array(q), out, problem.dilatancy).worst < 1e-12


#: Weight of the dam's masonry over that of water, and width over height of its section.
GAMMA, SLENDER = 2.4, 0.65


@pytest.mark.parametrize("method", METHODS)
def test_a_dam_slides_or_overturns(method):
    """A triangle below its crest, the dam down to any depth y weighs γ (b/h) y² / 2 at a third of its width
    from the water, which pushes with y² / 2 a third of the depth above that joint: λ is the same for
    every joint, as sliding and overturning about the toe go."""
    slides = 0.75 * GAMMA * SLENDER
    overturns = GAMMA * SLENDER / 2 * (2 / 3 * SLENDER) / (1 / 6)
    assert solved(FOLDER / "dam_slides.toml", method).load_factor == pytest.approx(slides, rel=1e-7)
    assert solved(FOLDER / "dam_overturns.toml", method).load_factor == pytest.approx(overturns, rel=1e-7)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("friction", [0.6, 0.3])
def test_a_buttress_overturns_or_slides(friction, method):
    """Thrust λ (2, -1) at the height 7 of stones of weight 4, 2 × 2: it turns them about the toe of the
    joint below k of them, or pushes them off it."""
    found = []
    for stones in range(1, 5):
        weight, lever = 4 * stones, 7 - (8 - 2 * stones)
        found.append(friction * weight / (2 - friction * 1))
        if 2 * lever > 1 * 2:  # else the thrust passes inside that toe
            found.append(weight * 1 / (2 * lever - 1 * 2))
    expected = min(found)
    result = solved(changed("buttress", friction), method)
    assert result.load_factor == pytest.approx(expected, rel=1e-7)
    assert expected == pytest.approx({0.6: 4 / 3, 0.3: 0.3 * 4 / 1.7}[friction], rel=1e-12)


@pytest.mark.parametrize("method", [*METHODS, "global"])
@pytest.mark.parametrize("friction", [0.3, 0.4, 0.45])
def test_two_stones_that_lean_on_each_other_spread(friction, method):
    """The least thrust H passes the crown at its top, 4 high, and the springing at its inner end, 2 from the
    crown: 4 H = W a + 2 λ, a from that end to the stone's centroid. It slides at H = μ (W + λ)."""
    weight = 6.0
    # The stone is what the triangle (-4, 0), (0, 0), (0, 4) has beyond (-2, 0), (0, 0), (0, 3).
    centroid = (8 * -4 / 3 - 3 * -2 / 3) / (8 - 3)
    arm = centroid + 2
    expected = (friction * weight - weight * arm / 4) / (2 / 4 - friction)
    assert solved(changed("pitched_stones", friction), method).load_factor == pytest.approx(
        expected, rel=1e-7
    )


def test_two_stones_with_more_friction_than_slope_never_spread():
    assert solved(changed("pitched_stones", 0.51), "static").status is mo.Status.LOCKED


@pytest.mark.slow
def test_nor_do_they_without_dilatancy():
    """Proven by cuts; a second or more."""
    assert solved(changed("pitched_stones", 0.51)).status is mo.Status.JAMMED


@pytest.mark.parametrize("method", ["mcp", "nonassociative", "global"])
@pytest.mark.parametrize("friction", [0.3, 0.7])
def test_a_keystone_pulled_up_weighs_what_it_weighs(friction, method):
    """Its faces lean by 1 in 2 and open at once, so that nothing rubs."""
    assert solved(changed("keystone", friction), method).load_factor == pytest.approx(1, rel=1e-7)


def test_a_rougher_keystone_jams_if_it_dilates():
    """Up by 1 its faces open by sin β and slide by cos β, tan β = 1/2: too little where dilatancy is more."""
    assert solved(changed("keystone", 0.499), "static").load_factor == pytest.approx(1, rel=1e-7)
    assert solved(changed("keystone", 0.501), "static").status is mo.Status.LOCKED


@pytest.mark.parametrize("voussoir", [2, 4])
@pytest.mark.parametrize("method", METHODS)
def test_a_parabolic_arch_under_fill_of_one_depth(method, voussoir):
    """Let f be the height of the thrust H above the intrados, x from the left springing, the load at a.

    Between the loads H y'' = -w, and the intrados has y'' = -8 r / L², so f'' = 2 k = 8 r / L² - w / H. The
    thrust passes the intrados at x = 0, the back at a, touches the intrados at c, and passes the back at L:
    f = k (x - c)² with c = (a + L) / 2, k = 4 t / (L - a)². Its slope falls at the load by P / H, from
    k a + t / a on the left to -4 t / (L - a). At a = L / 4 this is P = 25 w L t / (2 (9 r - 16 t)).
    """
    span, rise, t, a = 16.0, 3.0, 0.8, float(voussoir)
    k = 4 * t / (span - a) ** 2
    thrust = (22 * t + 18) / (8 * rise / span**2 - 2 * k)
    expected = thrust * (k * a + t / a + 4 * t / (span - a))
    if voussoir == 4:
        by_hand = 25 * (22 * t + 18) * span * t / (2 * (9 * rise - 16 * t))
        assert expected == pytest.approx(by_hand, rel=1e-12)
    scene = mo.load(FOLDER / "parabola_under_fill.toml")
    back = scene.blocks[voussoir - 1].vertices[2]
    load = mo.Load(block=f"v{voussoir}", live=(0, -1), at=back)
    found = solved(scene.model_copy(update={"loads": [load]}), method).load_factor
    assert found == pytest.approx(expected, rel=1e-8)


#: A linear program solved to 1e-9.
EXACT = 1e-7


@pytest.mark.parametrize("method", [*METHODS, "kinematic"])
@pytest.mark.parametrize(
    ("width", "height", "friction"),
    [(1, 2, 0.3), (1, 2, 0.8), (1, 2, math.inf), (2, 1, 0.8), (2, 1, math.inf), (1, 1, 0.8)],
)
def test_single_block_slides_or_overturns(width, height, friction, method):
    """One block w × h, horizontal live load = weight: λ = min(w/h, μ). The loop ends within its own
    tolerance (1e-5 on λ)."""
    result = solved(block_on_floor(width, height, friction), method)
    tolerance = 2e-5 if method == "nonassociative" else EXACT
    assert result.load_factor == pytest.approx(min(width / height, friction), rel=tolerance)


@pytest.mark.parametrize("angle", [10, 20, 26])
def test_tilting_table(angle):
    """A block on a table tilted by θ slides or overturns when tan θ reaches λ, so with gravity tilted
    by θ the live load along the table still needed is cos θ (λ₀ - tan θ)."""
    tilt = math.radians(angle)
    scene = block_on_floor(1, 2, 0.6).model_copy(update={"gravity": (math.sin(tilt), -math.cos(tilt))})
    expected = math.cos(tilt) * (0.5 - math.tan(tilt))
    assert solved(scene, "static").load_factor == pytest.approx(expected, rel=1e-6)


def test_table_tilted_too_far():
    tilt = math.radians(27)
    scene = block_on_floor(1, 2, 0.6).model_copy(update={"gravity": (math.sin(tilt), -math.cos(tilt))})
    assert solved(scene, "static").status is mo.Status.UNSTABLE


def test_cohesion_adds_its_length():
    """Sliding at μ + c L / weight."""
    scene = block_on_floor(3, 1, 0.3)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.3, cohesion=0.1), blocks=scene.blocks)
    assert solved(scene, "static").load_factor == pytest.approx(0.6, rel=EXACT)
    assert solved(scene).load_factor == pytest.approx(0.6, rel=2e-5)
    assert solved(scene, "mcp").load_factor == pytest.approx(0.6, rel=EXACT)


def test_live_load_at_the_top_overturns_sooner():
    scene = block_on_floor(1, 2, 0.6, live_at=(0.5, 2.0))
    assert solved(scene, "static").load_factor == pytest.approx(0.25, rel=EXACT)

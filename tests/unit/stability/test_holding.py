"""Blocks that fall in the plane and in space, and the friction or strength that would hold them, by statics
by hand."""

from math import cos, pi, radians, sin, tan

import pytest
from atlas.small_scenes import rectangle
from mappings import mapped, turned
from scenes import block_on_floor, values_of
from scenes_in_space import box_on_floor
from speeds import slow

import masonry_opt as mo
from masonry_opt.analysis import prepare
from masonry_opt.problem import assembly
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.stability import diagnosis

#: Relative distance between the least factor known to hold and the greatest factor known not to hold.
NEAR = 1.1e-3


def scene(friction, *blocks, **keys):
    return mo.Scene(joints={"friction": friction}, blocks=list(blocks), **keys)


def on_slope(degrees: float, friction: float, cohesion: float = 0.0) -> mo.Scene:
    """Return a flat block of weight 2 on a slope, with a bed 4 long. Gravity is rotated instead of the
    blocks."""
    block = rectangle("A", 0, 0, 4, 1, weight=2, live=(1, 0))
    down = (sin(radians(degrees)), -cos(radians(degrees)))
    return scene(friction, block, rectangle("ramp", -9, -1, 9, 0), gravity=down).replace(cohesion=cohesion)


def against_wall(friction: float) -> mo.Scene:
    """Return a block of weight 1, 1 wide and 2 high, that a dead force of 4 presses against a wall. Its shear
    of 1 has the moment 1/2, which the normal force of the wall can resist up to 4 times 1."""
    block = rectangle("A", 0, 0, 1, 2, weight=1, dead=(4, 0), live=(0, 1))
    return scene(friction, block, rectangle("wall", 1, 0, 2, 2))


def under_ceiling(*others: mo.Block, friction: float = 0.5) -> mo.Scene:
    block = rectangle("A", 0, 0, 1, 1, weight=1, live=(1, 0))
    return scene(friction, block, rectangle("ceiling", -1, 1, 2, 2), *others)


@pytest.mark.parametrize(
    ("falls", "factor", "pair"),
    [
        (on_slope(30, 0.4), tan(radians(30)) / 0.4, ["A", "ramp"]),
        (on_slope(30, 0.05), tan(radians(30)) / 0.05, ["A", "ramp"]),
        # The force 2 sin 30° is balanced by the cohesion 4 c and by friction.
        (on_slope(30, 0.2, cohesion=0.1), (1 - 0.4) / (0.2 * 2 * cos(radians(30))), ["A", "ramp"]),
        (against_wall(0.1), 1 / (4 * 0.1), ["A", "wall"]),
        (mo.extrude(on_slope(30, 0.4)), tan(radians(30)) / 0.4, ["A", "ramp"]),
    ],
    ids=["slope", "smooth slope", "slope with cohesion", "pressed against a wall", "slope in space"],
)
def test_least_friction_that_holds(falls, factor, pair):
    result = mo.solve(falls, "static")
    assert result.status is mo.Status.UNSTABLE
    assert [reason.code for reason in result.reasons] == [Code.FALLS, Code.FRICTION_WOULD_HOLD]
    found = values_of(result, Code.FRICTION_WOULD_HOLD)
    assert found["pairs"] == [pair]
    assert not found["hangs"]
    assert found["above"] <= factor * (1 + 1e-6)
    assert found["factor"] >= factor * (1 - 1e-6)
    # For large factors, few trials remain, so the bracket is wider.
    assert found["factor"] / found["above"] < 1 + NEAR * (1 if factor < 4 else 10)
    # The scene is stable with the larger factor and unstable with the smaller one.
    for times, stands in ((found["factor"], True), (found["above"], False)):
        again = mo.solve(falls.replace(friction=times * falls.joints.friction), "static")
        assert (again.status is not mo.Status.UNSTABLE) is stands


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
@pytest.mark.parametrize("degrees", [0, 90, 200])
def test_no_friction_holds_what_hangs(degrees, shaped):
    """The result does not depend on the axes, but on the direction of the dead load."""
    turn = turned(radians(degrees))
    result = mo.solve(shaped(mapped(under_ceiling(), turn, turn)), "static")
    assert [reason.code for reason in result.reasons] == [Code.FALLS, Code.HANGS, Code.NO_FRICTION_HOLDS]
    assert values_of(result, Code.HANGS) == {"blocks": ["A"]}


def test_what_lies_on_a_hanging_block_hangs_with_it():
    """A block is next to a smooth wall, another block is on top of it, and both fall. A column elsewhere is
    stable."""
    lower = rectangle("lower", 0, 0, 2, 1, weight=1, live=(1, 0))
    upper = rectangle("upper", 0, 1, 2, 2, weight=1)
    wall, column = rectangle("wall", -1, 0, 0, 1), rectangle("column", 10, 0, 11, 1, weight=1)
    floor = rectangle("floor", 9, -1, 12, 0)
    result = mo.solve(scene(0.0, lower, upper, wall, column, floor), "static")
    assert set(values_of(result, Code.HANGS)["blocks"]) == {"lower", "upper"}
    assert set(values_of(result, Code.NO_FRICTION_HOLDS)["blocks"]) == {"lower", "upper"}


def test_what_friction_could_jam_in_a_corner_hangs_all_the_same():
    """Two forces along the diagonal can hold a unit block between a wall and a ceiling. They are at 45° to
    both faces, so friction must be at least 1."""
    result = mo.solve(under_ceiling(rectangle("wall", -1, 0, 0, 1)), "static")
    assert values_of(result, Code.HANGS) == {"blocks": ["A"]}
    found = values_of(result, Code.FRICTION_WOULD_HOLD)
    assert found["hangs"]
    # Just above μ = 1, the forces are very large, and no solver finds them.
    assert found["factor"] == pytest.approx(1 / 0.5, rel=3e-3)


def test_where_joints_without_friction_slide_no_factor_helps():
    falls = on_slope(30, 0.5)
    beside = rectangle("B", -8, 0, -4, 1, weight=1)
    smooth = [mo.Joint(between=("A", "ramp"), friction=0.0)]
    both = falls.replace(blocks=[*falls.blocks, beside], exceptions=smooth)
    found = values_of(mo.solve(both, "static"), Code.FRICTION_WOULD_HOLD)
    assert ["A", "ramp"] in found["pairs"]
    assert found["factor"] is None
    assert found["above"] == pytest.approx(100 / 0.5)
    nothing = values_of(mo.solve(on_slope(30, 0.0), "static"), Code.FRICTION_WOULD_HOLD)
    assert (nothing["factor"], nothing["above"]) == (None, 1.0)


def test_few_programs(watched):
    """At most twelve factors are tried, however large the least one is, and none if the scene is stable."""
    tried = watched(diagnosis, "mechanism_or_forces")
    mo.solve(on_slope(30, 0.003), "static")
    assert len(tried) - 2 == 12  # two more before: with the given friction, and without sliding
    assert max(problem.friction.max(initial=0.0) for problem, *_ in tried) <= 100
    tried.clear()
    assert mo.solve(block_on_floor(), "static").status.usable
    assert len(tried) == 1


@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_a_pillar_that_crushes_under_its_weight_asks_for_strength(method):
    """A weight of 1 is on a joint of length 1 that carries 0.9. More strength would hold it, but no friction
    would."""
    scene = block_on_floor().replace(strength=0.9)
    result = mo.solve(scene, method)
    assert result.status is Status.UNSTABLE
    assert [reason.code for reason in result.reasons] == [Code.FALLS, Code.STRENGTH_WOULD_HOLD]
    assert mo.solve(scene.replace(strength=1.1), "static").load_factor > 0


@pytest.mark.parametrize(("slope", "stands"), [(0.599, True), (0.601, False)])
@pytest.mark.parametrize("solver", ["clarabel", "highs"])
def test_the_cone_decides_whether_a_box_stands(slope, stands, solver):
    """In the direction normal to a side, 7.5° from an axis, the polygon alone would hold only up to 0.6
    cos(π/24) = 0.5949."""
    gravity = (slope * cos(radians(7.5)), slope * sin(radians(7.5)), -1)
    box = box_on_floor((1, 1, 1), 0.6, live=(0, 0, -1)).replace(gravity=gravity)
    assert (values_of(mo.solve(box, "static", solver=solver), Code.FALLS) is None) is stands
    assert 0.6 * cos(pi / 24) < 0.599


def test_contacts_are_found_once_while_joints_alone_change(watched):
    found, session = watched(assembly, "find_joints"), prepare("static", keeps=True)
    box = box_on_floor((2, 2, 1), 0.5)
    for friction in (0.3, 0.4, 0.45):
        assert session.solve(box.replace(friction=friction)).load_factor == pytest.approx(friction, rel=1e-6)
    assert len(found) == 1


def leaning(strength, friction=0.4, sideways=1.3):
    """Return a leaning block with a tie at its top, which must carry 0.75 by moments about the right toe."""
    floor = mo.Block(name="floor", vertices=[(-5, -1), (5, -1), (5, 0), (-5, 0)], fixed=True)
    corners = [(0, 0), (0.5, 0), (sideways, 2), (sideways - 0.5, 2)]
    block = mo.Block(name="leans", vertices=corners, weight=10)
    at = ((sideways - 0.5, 2), (-3, 2))
    tie = mo.Tie(name="rod", between=("leans", "ground"), at=at, strength=strength)
    return mo.Scene(joints={"friction": friction}, blocks=[floor, block], ties=[tie])


@pytest.mark.parametrize("method", ["static", *slow("coulomb")])
def test_a_tie_that_yields_under_the_dead_load_asks_for_strength(method):
    result = mo.solve(leaning(0.7), method)
    assert result.status is Status.UNSTABLE
    codes = [reason.code for reason in result.reasons]
    assert codes == [Code.FALLS, Code.TIES_WOULD_HOLD, Code.NO_FRICTION_HOLDS]
    assert "tie 'rod' yields: with more 'strength' the scene would be stable" in str(result)
    assert mo.solve(leaning(0.8), method).status is Status.STABLE


def test_a_tie_that_does_not_help_asks_for_no_strength():
    """The block needs a horizontal force of 0.75, but friction carries only 0.5."""
    result = mo.solve(leaning(10.0, friction=0.05))
    assert [reason.code for reason in result.reasons] == [Code.FALLS, Code.FRICTION_WOULD_HOLD]


def test_a_prop_and_a_wire_that_are_too_weak_are_named():
    brick = mo.Block(name="brick", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=5)
    wire = mo.Tie(name="wire", between=("brick", "ground"), at=((0.5, 1), (0.5, 4)), strength=2)
    prop = mo.Prop(name="post", between=("brick", "ground"), at=((0.5, 0), (0.5, -4)), strength=2)
    result = mo.solve(mo.Scene(joints={"friction": 0.5}, blocks=[brick], ties=[wire], props=[prop]))
    (names,) = [each.values["names"] for each in result.reasons if each.code is Code.TIES_WOULD_HOLD]
    assert names == ["tie 'wire'", "prop 'post'"]

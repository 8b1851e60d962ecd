"""What falls in the plane and in space, and what would hold it, against statics by hand."""

from math import cos, pi, radians, sin, tan

import pytest
from atlas.small_scenes import rectangle
from mappings import mapped, turned
from scenes import block_on_floor, values_of
from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.analysis import prepare
from masonry_opt.problem import assembly
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.stability import diagnosis

#: Between the least factor seen to hold and the greatest seen not to.
NEAR = 1.1e-3


def scene(friction, *blocks, **keys):
    return mo.Scene(joints={"friction": friction}, blocks=list(blocks), **keys)


def on_slope(degrees: float, friction: float, cohesion: float = 0.0) -> mo.Scene:
    """A flat block of weight 2 on a slope, its bed 4 long: gravity turned instead of the blocks."""
    block = rectangle("A", 0, 0, 4, 1, weight=2, live=(1, 0))
    down = (sin(radians(degrees)), -cos(radians(degrees)))
    return scene(friction, block, rectangle("ramp", -9, -1, 9, 0), gravity=down).replace(cohesion=cohesion)


def against_wall(friction: float) -> mo.Scene:
    """A block of weight 1, 1 wide and 2 high, that a dead force of 4 presses against a wall: its shear, 1,
    turns it by 1/2, which the wall's normal force resists by 4 times 1."""
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
        # 2 sin 30° is held by 4 c and friction.
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
    # The fewer factors are left to try, the larger the first that holds.
    assert found["factor"] / found["above"] < 1 + NEAR * (1 if factor < 4 else 10)
    # And it does: the scene with so much friction has a state, with less it has none.
    for times, stands in ((found["factor"], True), (found["above"], False)):
        again = mo.solve(falls.replace(friction=times * falls.joints.friction), "static")
        assert (again.status is not mo.Status.UNSTABLE) is stands


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
@pytest.mark.parametrize("degrees", [0, 90, 200])
def test_no_friction_holds_what_hangs(degrees, shaped):
    """Whatever the axes: what counts is where the dead load acts."""
    turn = turned(radians(degrees))
    result = mo.solve(shaped(mapped(under_ceiling(), turn, turn)), "static")
    assert [reason.code for reason in result.reasons] == [Code.FALLS, Code.HANGS, Code.NO_FRICTION_HOLDS]
    assert values_of(result, Code.HANGS) == {"blocks": ["A"]}


def test_what_lies_on_a_hanging_block_hangs_with_it():
    """A column outside stands; of two blocks one on the other, the lower beside a smooth wall, both fall."""
    lower = rectangle("lower", 0, 0, 2, 1, weight=1, live=(1, 0))
    upper = rectangle("upper", 0, 1, 2, 2, weight=1)
    wall, column = rectangle("wall", -1, 0, 0, 1), rectangle("column", 10, 0, 11, 1, weight=1)
    floor = rectangle("floor", 9, -1, 12, 0)
    result = mo.solve(scene(0.0, lower, upper, wall, column, floor), "static")
    assert set(values_of(result, Code.HANGS)["blocks"]) == {"lower", "upper"}
    assert set(values_of(result, Code.NO_FRICTION_HOLDS)["blocks"]) == {"lower", "upper"}


def test_what_friction_could_jam_in_a_corner_hangs_all_the_same():
    """Between wall and ceiling a unit block is held by two forces along its diagonal, at 45° to either face:
    from μ = 1 on."""
    result = mo.solve(under_ceiling(rectangle("wall", -1, 0, 0, 1)), "static")
    assert values_of(result, Code.HANGS) == {"blocks": ["A"]}
    found = values_of(result, Code.FRICTION_WOULD_HOLD)
    assert found["hangs"]
    # Just above it the forces are beyond any bound, and no solver sees them.
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
    """At most twelve factors, however far the least one is, and none where the scene stands."""
    tried = watched(diagnosis, "mechanism_or_forces")
    mo.solve(on_slope(30, 0.003), "static")
    assert len(tried) - 2 == 12  # and two before: as it is, and so that nothing slides
    assert max(problem.friction.max(initial=0.0) for problem, *_ in tried) <= 100
    tried.clear()
    assert mo.solve(block_on_floor(), "static").status.usable
    assert len(tried) == 1


@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_a_pillar_that_crushes_under_its_weight_asks_for_strength(method):
    """Weight 1 on a joint of length 1 that carries 0.9: no friction holds it, more strength does."""
    scene = block_on_floor().replace(strength=0.9)
    result = mo.solve(scene, method)
    assert result.status is Status.UNSTABLE
    assert [reason.code for reason in result.reasons] == [Code.FALLS, Code.STRENGTH_WOULD_HOLD]
    assert mo.solve(scene.replace(strength=1.1), "static").load_factor > 0


@pytest.mark.parametrize(("slope", "stands"), [(0.599, True), (0.601, False)])
@pytest.mark.parametrize("solver", ["clarabel", "highs"])
def test_the_cone_decides_whether_a_box_stands(slope, stands, solver):
    """Across a side, 7.5° off an axis, the polygon would hold up to 0.6 cos(π/24) = 0.5949 alone."""
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

"""Tests of fill: its weight, pressure and touched edges by hand, and fills that are refused."""

import math

import numpy as np
import pytest
import shapely
from scenes import CASES, forces_of
from scenes_in_space import box_on_floor
from speeds import slow

import masonry_opt as mo
from masonry_opt.drawing.elements import counts, result_elements, scene_elements
from masonry_opt.problem.assembly import assemble
from masonry_opt.reporting.summary import of_fills, summary
from masonry_opt.scene.blocks import rectangle

GAMMA = 2.0


def block(name, vertices, weight=10.0, **keys):
    return mo.Block(name=name, vertices=vertices, weight=weight, **keys)


BASE = mo.Block(name="base", vertices=[(-3, -1), (9, -1), (9, 0), (-3, 0)], fixed=True)
LOW = block("low", [(0, 0), (2, 0), (2, 1), (0, 1)])
SLOPED = block("sloped", [(2, 0), (4, 0), (4, 1), (2, 2)])


def fill(road, **keys):
    return mo.Fill(road=road, unit_weight=GAMMA, **{"pressure": False} | keys)


def scene(blocks, fills, **keys):
    return mo.Scene(joints={"friction": 0.6}, blocks=[*blocks, BASE], fills=fills, **keys)


def of_fill(made):
    """Return the forces and moments of the fill on the blocks: dead loads without the weights, shape
    (blocks, 3)."""
    return forces_of(assemble(made)) - forces_of(assemble(made.model_copy(update={"fills": []})))


def names(made):
    assembly = assemble(made)
    return [(made.blocks[piece.block].name, piece) for piece in assembly.filled_pieces]


def test_weight_under_a_road_that_bends_and_ends_within_a_block():
    """The weight of the fill on two blocks agrees with trapezia by hand.

    The road runs from (1, 2) over (3, 3) to (4, 2). The depth is 1 to 1.5 above the flat edge. Above the
    slope it is 0.5 to 1.5, then 1.5 to 1. The centroid of the sloped block is 8 / 9 from its upper end.
    """
    acting = of_fill(scene([LOW, SLOPED], [fill([(1, 2), (3, 3), (4, 2)])], thickness=0.5))
    weight = 0.5 * GAMMA
    flat = weight * 1.25 * (1 + (1 + 2 * 1.5) / (3 * 2.5) - 1)
    rising, falling = weight * 1.0, weight * 1.25
    at = 8 / 9
    slope = rising * ((0.5 + 2 * 1.5) / (3 * 2.0) - at) + falling * (1 + (1.5 + 2 * 1.0) / (3 * 2.5) - at)
    expected = [[0, -1.25 * weight, -flat], [0, -(rising + falling), -slope]]
    np.testing.assert_allclose(acting, expected, atol=1e-12)


def test_the_edges_that_fill_touches():
    """Fill touches the tops, the step between the blocks, the free side of the last block and the ground next
    to it.

    It does not touch the free side of the first block, where the road begins.
    """
    made = scene([LOW, SLOPED], [fill([(0, 3), (5, 3)])])
    found = [(name, (piece.ends + assemble(made).geometry.origin).tolist()) for name, piece in names(made)]
    assert found == [
        ("low", [[2, 1], [0, 1]]),
        ("sloped", [[4, 1], [2, 2]]),
        ("base", [[5, 0], [4, 0]]),
        ("sloped", [[2, 2], [2, 1]]),
        ("sloped", [[4, 0], [4, 1]]),
    ]
    assert [piece.depth.tolist() for _, piece in names(made)][-2:] == [[1, 2], [3, 2]]


def test_what_an_overhang_hides_is_not_touched():
    """There is no fill below a cap that overhangs: neither on the ground nor against the shaft."""
    shaft = block("shaft", [(0, 0), (1, 0), (1, 2), (0, 2)])
    cap = block("cap", [(0, 2), (2, 2), (2, 3), (0, 3)])
    made = scene([shaft, cap], [fill([(0, 4), (3, 4)])])
    assert [name for name, _ in names(made)] == ["cap", "base", "cap"]


def test_counted_and_told(tmp_path):
    pushed = LOW.model_copy(update={"live": (1.0, 0.0)})
    made = scene([pushed, SLOPED], [fill([(0, 3), (5, 3)], spread=25)])
    mo.save(made, tmp_path / "a.toml")
    assert mo.load(tmp_path / "a.toml") == made
    text = summary(mo.solve(made, "static"))
    assert "touches 5 edges; weighs 14 on 2 blocks, in the force unit of the case;" in text
    assert "fill touches 5 edges; weighs 14" in str(mo.check(made))
    heavy = made.with_load_case(mo.LoadCase(name="heavy", dead={"fill": 1.2}, live={"live": 1}))
    (line,) = of_fills(assemble(heavy))
    assert "weighs 14 on 2 blocks (the factor 1.2 of the load case is not included), in the force" in line
    assert "within 25° of the vertical" in text
    assert "5 edges touched by fill" in counts(assemble(made))


@pytest.mark.parametrize("part", ["weight", "spread", "pressure"])
def test_each_part_can_be_switched_off(part):
    keys = {"weight": True, "spread": 20.0, "pressure": True, "friction_angle": 35.0, "mobilised": 0.3}
    made = scene([LOW], [fill([(0, 2), (2, 2)], **keys | {part: False})])
    assert of_fill(made)[0, 1] == (0.0 if part == "weight" else pytest.approx(-2 * GAMMA))


LINE = [(0, 1), (9, 1)]


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"unit_weight": 0.0}, ["'unit_weight'", "greater than 0"]),
        ({"friction_angle": -1.0}, ["'friction_angle'", "0 or more"]),
        ({"friction_angle": 0.0}, ["'mobilised' times K_p is 0.5, below K_a = 1: raise 'mobilised'"]),
        ({"friction_angle": 90.0}, ["'friction_angle'", "less than 90"]),
        ({"mobilised": 1.1}, ["'mobilised'", "1 or less"]),
        ({"mobilised": 0.05}, ["'mobilised'", "K_a"]),
        ({"friction_angle": 0.6}, ["below K_a", "'friction_angle' in degrees (atan 0.6 = 31.0°)"]),
        ({"mobilised": None}, ["'mobilised'", "'pressure = false'"]),
        ({"friction_angle": None}, ["'friction_angle'", "'pressure = false'"]),
        ({"spread": 90.0}, ["'spread'", "between 0 and 90 degrees, or false"]),
        ({"spread": True}, ["'spread'", "between 0 and 90 degrees, or false"]),
        ({"road": [(0, 2)]}, ["'road'", "at least 2"]),
        ({"backing": {"line": [(-9, 5), (9, 5)], "unit_weight": 1}}, ["'backing'", "above the 'road'"]),
        ({"backing": {"line": LINE, "unit_weight": 0}}, ["'backing.unit_weight'", "greater than 0"]),
        ({"backing": {"line": LINE, "unit_weight": 1, "mobilised": 0.01}}, ["'backing'", "K_a"]),
        ({"road": [(2, 2), (0, 2)]}, ["'road'", "left to right"]),
    ],
)
def test_wrong_values_are_refused_by_name(keys, words):
    right = {"road": [(0, 2), (2, 2)], "unit_weight": 18.0, "friction_angle": 30.0, "mobilised": 0.5}
    mo.Fill(**right)
    with pytest.raises(mo.CaseError) as error:
        mo.Fill(**right | keys)
    assert all(word in str(error.value) for word in words), str(error.value)


@pytest.mark.parametrize(
    ("road", "words"),
    [
        ([(-5, 3), (2, 3)], ["fill no. 1", "no block below", "x = -5 to -3"]),
        ([(-3, 2), (4, 2.5), (9, 0.5)], []),
        ([(0, 3), (4, 0.5)], ["fill no. 1", "runs through block 'sloped'"]),
        ([(5, 3), (8, 3)], ["fill no. 1", "no movable block"]),
        ([(0, 1), (2, 1)], ["fill no. 1", "no movable block"]),
    ],
)
def test_fill_above_nothing_and_roads_below_blocks_are_refused(road, words):
    made = scene([LOW, SLOPED], [fill(road)])
    if not words:
        assert assemble(made).filled_pieces
        return
    with pytest.raises(mo.CaseError) as error:
        assemble(made)
    assert all(word in str(error.value) for word in words), str(error.value)


def test_what_goes_with_no_fill():
    flat = [fill([(0, 3), (2, 3)])]
    with pytest.raises(mo.CaseError, match=r"no\. 1 and no\. 2 overlap"):
        scene([LOW], [*flat, fill([(1, 4), (2, 4)])])
    scene([LOW, SLOPED], [*flat, fill([(2, 4), (4, 4)])])
    with pytest.raises(mo.CaseError, match="straight down"):
        scene([LOW], flat, gravity=(0.1, -1.0))
    with pytest.raises(mo.CaseError, match="'fill' does not tilt"):
        scene([LOW], flat, tilt="right")
    with pytest.raises(mo.CaseError, match="'fill' is only for scenes in the plane"):
        box_on_floor().replace(fills=flat)
    with pytest.raises(mo.OptionError, match="'fill' is only for scenes in the plane"):
        mo.extrude(scene([LOW], flat), 1.0)


ANGLE = 32.0
SHARE = 0.4
ACTIVE = (1 - math.sin(math.radians(ANGLE))) / (1 + math.sin(math.radians(ANGLE)))
PASSIVE = SHARE / ACTIVE
WIDTH = 1.2
HEIGHT = 2.5
DEEP = 2.0
WEIGHT = 40.0
THICK = 0.7


def retaining(push, friction, **keys):
    """Return a wall with fill of depth ``DEEP`` to its right, pushed at the height of its centroid."""
    corners = [(0, 0), (WIDTH, 0), (WIDTH, HEIGHT), (0, HEIGHT)]
    wall = mo.Block(name="wall", vertices=corners, weight=WEIGHT, live=(push, 0.0))
    made = mo.Fill(
        road=[(WIDTH, DEEP), (5, DEEP)], unit_weight=GAMMA, friction_angle=ANGLE, mobilised=SHARE, **keys
    )
    return mo.Scene(joints={"friction": friction}, blocks=[wall, BASE], fills=[made], thickness=THICK)


@pytest.mark.parametrize(
    ("method", "keys"),
    [
        ("static", {"solver": "highs"}),
        ("coulomb", {}),
        *slow(("kinematic", {"solver": "highs"}), ("nonassociative", {"solver": "highs"})),
        *slow(("coulomb", {"search": 0.2})),
    ],
)
@pytest.mark.parametrize("push", [-1.0, 1.0])
@pytest.mark.parametrize("friction", [0.25, 0.9])
def test_a_wall_that_retains_fill(push, friction, method, keys):
    """The load factor of a wall that retains fill is the lesser of turning about its toe and sliding along
    its bed.

    The earth pressure is E = γ t h² / 2 times a coefficient, at a third of the depth. If the wall is pushed
    away from the fill, the coefficient is K_a, and E adds to the push. If it is pushed into the fill, the
    coefficient is m K_p, and E resists. The wall turns at (W b / 2 ± E h / 3) / (H / 2), and slides at
    μ W ± E.
    """
    whole = GAMMA * THICK * DEEP**2 / 2
    earth = PASSIVE * whole if push > 0 else -ACTIVE * whole
    overturns = (WEIGHT * WIDTH / 2 + earth * DEEP / 3) / (HEIGHT / 2)
    slides = friction * WEIGHT + earth
    found = mo.solve(retaining(push, friction), method, **keys)
    assert found.load_factor == pytest.approx(min(overturns, slides), rel=1e-9)
    assert (slides < overturns) == (friction < 0.5)


@pytest.mark.parametrize("push", [-1.0, 1.0])
@pytest.mark.parametrize(("method", "keys"), [("static", {"solver": "highs"}), ("coulomb", {})])
def test_a_fill_without_friction_presses_like_a_fluid(push, method, keys):
    """The pressure is γ times the depth in both directions: E = γ t h² / 2 at a third of the depth."""
    made = retaining(push, 0.9)
    fluid = made.replace(fills=[made.fills[0].replace(friction_angle=0.0, mobilised=1.0)])
    earth = GAMMA * THICK * DEEP**2 / 2
    found = mo.solve(fluid, method, **keys)
    expected = (WEIGHT * WIDTH / 2 + math.copysign(earth, push) * DEEP / 3) / (HEIGHT / 2)
    assert found.load_factor == pytest.approx(expected, rel=1e-9)
    assert "fill angle low" not in [warning.code for warning in found.warnings]


UPPER = 1.2
BACKED = 3.0
BACKED_SHARE = 0.9


@pytest.mark.parametrize("factor", [*slow(1.0), 1.35, *slow(0.0)])
@pytest.mark.parametrize("push", [-1.0, 1.0])
def test_a_wall_that_retains_fill_over_backing(push, factor):
    """The pressure of fill over backing agrees with the closed form, also with a factor of the load case.

    The pressure grows as a triangle to γ h₁ at the backing. Below, it is a trapezium from γ h₁ to γ h₁ + γ_b
    h₂. Each part is multiplied by its own coefficient and by the factor of the load case. The two load cases
    differ by this factor alone.
    """
    backing = {"line": [(0, UPPER), (5, UPPER)], "unit_weight": BACKED, "mobilised": BACKED_SHARE}
    made = retaining(push, 0.9, backing=backing).replace(
        load_cases=[
            {"name": "a", "live": {"live": 1}},
            {"name": "b", "live": {"live": 1}, "pressure": factor},
        ]
    )
    into = push > 0
    upper, lower = (PASSIVE, BACKED_SHARE / ACTIVE) if into else (-ACTIVE, -ACTIVE)
    h, top = DEEP - UPPER, GAMMA * (DEEP - UPPER)
    parts = (
        (upper * top * h / 2, UPPER + h / 3),
        (lower * top * UPPER, UPPER / 2),
        (lower * BACKED * UPPER**2 / 2, UPPER / 3),
    )
    about = factor * THICK * sum(force * arm for force, arm in parts)
    expected = (WEIGHT * WIDTH / 2 + about) / (HEIGHT / 2)
    for name, found in mo.solve_cases(made, "static", solver="highs").results.items():
        if name == "b":
            assert found.load_factor == pytest.approx(expected, rel=1e-9)
            assert found.pressures["force"].sum() == pytest.approx(
                factor * THICK * abs(sum(force for force, _ in parts)), rel=1e-6
            )
            assert ("the load case multiplies" in summary(found)) == (factor != 1)
    alone = mo.solve(made, "coulomb", load_case="b")
    assert alone.load_factor == pytest.approx(expected, rel=1e-7)
    # The line of the backing divides the face of the wall, which still counts as one edge. The second edge is
    # the ground next to the wall.
    assert "touches 2 edges" in summary(alone)
    assert "its backing touches 2 edges" in summary(alone)


@pytest.mark.parametrize("turn", [1, -1])
def test_backing_that_ends_at_a_face_presses_the_side_on_which_it_lies(turn):
    """Backing presses only the side of a wall on which it lies, even if its line ends exactly at a face.

    The load factor equals that for a line that ends 1 mm before the face. The wall has fill of the same
    height on both sides.
    """
    found = []
    for end in (3.0, 2.999, 2.0, 2.001):
        line = [(0, 1.5), (end, 1.5)] if end > 2.5 else [(end, 1.5), (6, 1.5)]
        line, road = ([(turn * x, y) for x, y in of][::turn] for of in (line, [(0, 2.5), (6, 2.5)]))
        backing = {"line": line, "unit_weight": 25, "mobilised": 1.0}
        earth = mo.Fill(road=road, unit_weight=18, friction_angle=30, mobilised=0.3, backing=backing)
        ground, left_right = sorted((0, 6 * turn)), sorted((2 * turn, 3 * turn))
        blocks = [
            mo.Block(name="base", vertices=rectangle(*ground, -1, 0), fixed=True),
            mo.Block(name="wall", vertices=rectangle(*left_right, 0, 2), unit_weight=20, live=(turn, 0)),
        ]
        made = mo.Scene(joints={"friction": 0.9}, blocks=blocks, fills=[earth])
        found.append(mo.solve(made, "static", solver="highs").load_factor)
    assert found[::2] == pytest.approx(found[1::2], rel=1e-6)
    assert found[2] > 1.2 * found[0]


def test_what_fill_and_backing_weigh_over_an_arch_are_their_areas():
    """Over an arch, fill and backing weigh their areas, computed with polygons, times their unit weights.

    The areas lie between the road, the line of the backing and the extrados. The line bends, and ends short
    of one springing.
    """
    line = [(-1.5, 0.9), (0.3, 1.0), (1.0, 1.1)]
    ring = mo.Arch(span=3, rise=1, thickness=0.25, voussoirs=40, unit_weight=22).blocks()
    earth = fill([(-1.6, 1.5), (1.6, 1.5)], backing={"line": line, "unit_weight": BACKED})
    made = mo.Scene(joints={"friction": 0.6}, blocks=ring, fills=[earth])
    free = shapely.box(-1.6, 0, 1.6, 1.5) - shapely.union_all(
        [shapely.Polygon(b.vertices) for b in made.blocks]
    )
    (above,) = (one for one in free.geoms if one.bounds[3] == 1.5)
    backed = shapely.intersection(above, shapely.Polygon([*line, (1.0, 0), (-1.5, 0)])).area
    acting = of_fill(made)
    assert -acting[:, 1].sum() == pytest.approx(GAMMA * (above.area - backed) + BACKED * backed, rel=1e-9)
    assert 0.02 < backed < above.area / 4


def test_pressure_switched_off_leaves_the_wall_alone():
    found = mo.solve(retaining(1.0, 0.25, pressure=False), "static")
    assert found.load_factor == pytest.approx(0.25 * WEIGHT, rel=1e-9)


def test_pressure_on_an_inclined_edge_acts_on_its_height_where_depth_has_its_centre():
    """Pressure on an inclined edge acts on its height, at the centroid of the trapezium of depths.

    The slope runs from (4, 1) up to (2, 2) below a road at 3. Its depths are 2 and 1 and its height is 1, so
    that the pressure is 1.5 γ times the coefficient.
    """
    keys = {"pressure": True, "friction_angle": ANGLE, "mobilised": SHARE}
    made = scene([LOW, SLOPED], [fill([(2, 3), (4, 3)], **keys)])
    assembly = assemble(made)
    (force,) = assembly.limited
    (action,) = force.actions
    assert (action.point + assembly.geometry.origin)[1] == pytest.approx(3 - (4 + 2 + 1) / 4.5, rel=1e-12)
    assert action.force.tolist() == [-1.0, 0.0]
    assert [force.lowest, force.highest] == pytest.approx([ACTIVE * GAMMA * 1.5, PASSIVE * GAMMA * 1.5])


BRIDGE = mo.load(CASES / "bridges" / "arch_with_fill.toml")


def test_pictures_have_the_fill_and_what_it_presses():
    result = mo.solve(BRIDGE, "static")
    elements = result_elements(result)
    names = {kind: {marks.name for marks in elements.shown(kind)} for kind in ("mechanism", "thrust")}
    assert {"fill", "filled", "road"} <= names["mechanism"]
    assert "earth" in names["thrust"]
    (arrows,) = [marks for marks in elements.layers["thrust"] if marks.name == "earth"]
    assert len(arrows.points) == len(result.pressures) == 52
    assert result.ties.empty
    backing = {"line": [(-4, 0.5), (4, 0.5)], "unit_weight": 22}
    backed = BRIDGE.replace(fills=[BRIDGE.fills[0].replace(backing=backing)])
    drawn = [marks for marks in scene_elements(assemble(backed)).shown("scene") if marks.name == "backing"]
    lows, tops = (marks.points + assemble(backed).geometry.origin for marks in drawn)
    assert len(lows) > 10
    assert [of[..., 1].max() for of in (lows, tops)] == pytest.approx([0.5, 0.5])

"""Tests of cards that lean on each other: corners meet corners, without a common side."""

import math

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.reasons import Code

LEAN = math.radians(25)
#: Tolerance of values by bisection, which ends at a relative difference of 2e-4.
BISECTED = 3e-4


def card(name, foot, lean, length, thickness):
    """Return a card whose inner face rises from its foot, inclined to the right by an angle (left if
    negative)."""
    along = np.array([math.sin(lean), math.cos(lean)])
    outwards = math.copysign(1.0, lean) * np.array([-math.cos(lean), math.sin(lean)])
    start = np.array(foot)
    corners = [start, start + length * along, start + length * along + thickness * outwards]
    corners.append(start + thickness * outwards)
    return mo.Block(name=name, vertices=[tuple(map(float, corner)) for corner in corners], weight=1)


def tent(name, x, y, length=0.4, thickness=0.002, lean=LEAN):
    """Return two cards whose inner faces meet at the ridge."""
    half = length * math.sin(lean)
    left = card(f"{name} left", (x - half, y), lean, length, thickness)
    return [left, card(f"{name} right", (x + half, y), -lean, length, thickness)]


def on_table(*blocks, friction=0.25, size=1.0):
    table = mo.Block(
        name="table",
        vertices=[(-3 * size, -size), (3 * size, -size), (3 * size, 0), (-3 * size, 0)],
        fixed=True,
    )
    return mo.Scene(joints={"friction": friction}, blocks=[*blocks, table])


def least_of_tent(length, thickness, lean=LEAN):
    """Return the least friction of a tent.

    By moments about the foot of a card, the thrust H at the ridge balances the weight W of the card. The foot
    carries H and W.
    """
    arm = (length * math.sin(lean) - thickness * math.cos(lean)) / 2
    return arm / (length * math.cos(lean))


def two_storeys(thickness, apart, friction=0.4):
    """Return two tents whose feet are apart, with a card across their ridges, and a tent on this card."""
    top = 0.4 * math.cos(LEAN) + thickness * math.sin(LEAN)
    flat = [(-0.2, top), (0.2, top), (0.2, top + thickness), (-0.2, top + thickness)]
    lower = [*tent("A", -apart, 0, thickness=thickness), *tent("B", apart, 0, thickness=thickness)]
    upper = tent("C", 0, top + thickness, thickness=thickness)
    across = mo.Block(name="flat", vertices=flat, weight=1)
    return on_table(*lower, across, *upper, friction=friction)


@pytest.mark.slow
@pytest.mark.parametrize("thickness", [0.0005, 0.002, 0.02])
def test_a_tent_of_two_cards_needs_the_friction_of_its_feet(thickness):
    """The least friction is that of ``least_of_tent``, by hand; for thin cards it is tan 25° / 2 = 0.2332."""
    least = least_of_tent(0.4, thickness)
    stability = mo.solve(on_table(*tent("A", 0, 0, thickness=thickness))).stability
    assert stability.least_friction == pytest.approx(least, rel=BISECTED)
    assert stability.unique
    for method in ("coulomb", "static"):
        stands, slides = (
            mo.solve(on_table(*tent("A", 0, 0, thickness=thickness), friction=share * least), method)
            for share in (1.005, 0.995)
        )
        assert (stands.status, slides.status) == ("stable", "unstable under dead load")


def test_the_limit_of_thin_cards():
    assert least_of_tent(1.0, 0.0) == pytest.approx(math.tan(LEAN) / 2)
    assert math.tan(LEAN) / 2 == pytest.approx(0.2332, abs=5e-5)


@pytest.mark.parametrize("thickness", [1e-4, 5e-4])
def test_two_storeys_of_cards(thickness):
    """The least friction of thin cards agrees with hand calculation to 1 %.

    A lower ridge carries half of three cards, so that H = 1.25 W tan 25° / (2 · ½). A lower foot carries 1.75
    W, and 1.25 · 0.4663 / 1.75 = 0.3331.
    """
    least = mo.solve(two_storeys(thickness, 0.1715)).stability.least_friction
    assert 1.25 * math.tan(LEAN) / 1.75 == pytest.approx(0.3331, abs=5e-5)
    assert least == pytest.approx(1.25 * math.tan(LEAN) / 1.75, rel=0.01)


def moved(scene, angle, mirrored, size):
    """Return a scene that is mirrored, rotated, scaled and shifted, together with its gravity."""
    cos, sin = math.cos(angle), math.sin(angle)
    matrix = np.array([[cos, -sin], [sin, cos]]) @ np.diag([-1.0 if mirrored else 1.0, 1.0])
    blocks = [
        block.replace(
            vertices=[tuple((size * (matrix @ corner) + [7.0, -3.0]).tolist()) for corner in block.vertices]
        )
        for block in scene.blocks
    ]
    return scene.replace(blocks=blocks, gravity=tuple((matrix @ [0.0, -1.0]).tolist()))


@pytest.mark.parametrize(
    ("angle", "mirrored", "size"),
    [(0.0, True, 1.0), (0.7, False, 1e-3), (math.pi / 2, False, 50.0), (4.0, True, 1.0)],
)
def test_a_tent_that_is_turned_mirrored_or_scaled(angle, mirrored, size):
    scene = moved(on_table(*tent("A", 0, 0), friction=0.5), angle, mirrored, size)
    stability = mo.solve(scene).stability
    assert stability.least_friction == pytest.approx(least_of_tent(0.4, 0.002), rel=2 * BISECTED)


def test_the_order_of_blocks_and_of_corners_does_not_matter():
    scene = on_table(*tent("A", 0, 0))
    turned = [block.replace(vertices=[*block.vertices[2:], *block.vertices[:2]]) for block in scene.blocks]
    for blocks in (scene.blocks[::-1], turned):
        least = mo.solve(scene.replace(blocks=blocks)).stability.least_friction
        assert least == pytest.approx(least_of_tent(0.4, 0.002), rel=BISECTED)


@pytest.mark.parametrize("method", ["coulomb", "static"])
def test_the_ridge_of_a_tent_in_space_is_a_joint_along_its_edges(method):
    result = mo.solve(mo.extrude(on_table(*tent("A", 0, 0)), 0.3), method)
    assert result.stability.least_friction == pytest.approx(least_of_tent(0.4, 0.002), rel=2 * BISECTED)
    ridge = result.joints.query("first == 'A left' and second == 'A right'")
    assert ridge[["nx", "ny", "nz"]].to_numpy().ravel() == pytest.approx([-1, 0, 0], abs=1e-9)
    assert result.contacts["joint"].value_counts()[ridge.index[0]] == 2


def test_uneven_cards_lean_on_the_bisector_of_their_facing_sides():
    """Cards that are inclined by 20° and 40° meet on a line that is inclined by 10°."""
    ridge = 1.0
    blocks = []
    for name, lean in (("left", math.radians(20)), ("right", -math.radians(40))):
        foot = (-ridge * math.tan(lean), 0.0)
        blocks.append(card(name, foot, lean, ridge / math.cos(lean), 0.01))
    scene = on_table(*blocks, friction=0.9)
    assembly = assemble(scene)
    (ridge_joint,) = np.flatnonzero((assembly.joints.first == 0) & (assembly.joints.second == 1))
    tilt = math.radians(10)
    assert assembly.joints.normal[ridge_joint] == pytest.approx([-math.cos(tilt), -math.sin(tilt)], abs=1e-9)


def test_a_warning_names_the_joint_at_corners():
    result = mo.solve(on_table(*tent("A", 0, 0)))
    assert [warning.code for warning in result.warnings] == [Code.JOINT_AT_CORNERS]
    assert "'A left'–'A right' meet corner on corner" in result.warning_sentences[0]


@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("in_space", [False, True])
def test_a_corner_in_a_notch_rests_on_both_of_its_sides(first, in_space):
    """A wedge with its point in a notch of 90°, held upright by ties at its sides, rests on both sides of the
    notch.

    Two forces along the normals of the sides carry the weight 1 of the wedge: 1 / √2 each, without friction.
    """
    notch = mo.Block(
        name="notch", vertices=[(-2, 0), (2, 0), (2, 2), (1, 2), (0, 1), (-1, 2), (-2, 2)], weight=1
    )
    wedge = mo.Block(name="wedge", vertices=[(0, 1), (0.4, 3), (-0.4, 3)], weight=1)
    blocks = [wedge, notch] if first else [notch, wedge]
    upright = [mo.Tie(between=("wedge", "ground"), at=((x, 2.9), (9 * x, 2.9))) for x in (-0.3, 0.3)]
    scene = on_table(*blocks).replace(ties=upright)
    if in_space:
        assembly = assemble(mo.extrude(scene.replace(ties=[]), 0.5))
        at = (assembly.joints.first == 0) & (assembly.joints.second == 1)
        assert np.abs(assembly.joints.normal[at][:, 2]) == pytest.approx(2 * [math.sqrt(0.5)])
        return
    result = mo.solve(scene)
    assert result.status == "stable"
    assert result.stability.least_friction == 0
    frictionless = mo.solve(scene.replace(joints={"friction": 1e-6}))
    at_point = frictionless.joints.query("first != 'table' and second != 'table'")
    assert at_point["n"].to_list() == pytest.approx(2 * [math.sqrt(0.5)], rel=1e-4)

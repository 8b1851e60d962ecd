"""Messages about stones drawn without their mortar: the gaps they name, and the tolerances they advise."""

import math
import re
from functools import cache

import numpy as np
import pytest
import shapely
from brickwork import (
    FLOOR,
    MORTAR,
    STATIC,
    WALL,
    Arch,
    advised,
    brick_ring,
    drawn_to_touch,
    facade,
    scene_of,
    static,
    stone,
    upright_stone,
)
from mappings import mapped, turned
from scenes import solved
from speeds import slow
from touching_solids import contacts_of, refusal

import masonry_opt as mo
from masonry_opt.reporting.sentences import sentences
from masonry_opt.solution.reasons import Code

IN_BOTH = pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])


@cache
def arched() -> mo.Scene:
    """Return a wall of twelve bricks over an opening under an arch of bricks."""
    return facade(12, 24, (Arch(1.56, 8, 0.5, 21),))


@pytest.mark.slow
def test_the_message_about_a_facade_keeps_its_promise() -> None:
    """One message closes all gaps, with the announced numbers of joints and blocks. In the plane and as
    solids, the façade has the same joints and the same λ."""
    tolerance, joints, blocks = advised(refusal(arched()))
    assert blocks == sum(not block.fixed for block in arched().blocks)
    closed = arched().replace(contact_tolerance=tolerance)
    found = contacts_of(closed)
    assert (len(found.first), found.gaps) == (joints, {})
    solids = mo.extrude(closed)
    assert len(contacts_of(solids).first) == joints
    # The plane merges segments of one pair of stones within a twentieth of the gap, but solids keep them
    # separate.
    assert static(closed) == pytest.approx(static(solids), rel=1e-3)


@pytest.mark.slow
def test_a_tolerance_that_leaves_joints_open_names_them() -> None:
    """The tolerance closes the mortar of the wall but not the wedges of the arch. The warning names all
    wedges, and its advice closes them."""
    (warning,) = mo.solve(arched().replace(contact_tolerance=MORTAR), "static").warnings
    assert warning.code is Code.SMALL_GAPS
    assert warning.values["option"] == "contact_tolerance"
    assert len(warning.values["pairs"]) >= 20
    (sentence,) = sentences([warning])
    (named,) = re.findall(r"'contact_tolerance' to ([\d.]+)", sentence)
    closed = contacts_of(arched().replace(contact_tolerance=float(named)))
    assert len(closed.first) == advised(refusal(arched()))[1]


def growing() -> mo.Scene:
    """Return four unit squares above each other, with gaps of 0.1, 0.12, 0.13 and 0.14 below them."""
    heights = np.cumsum([0.1, 1.12, 1.13, 1.14])
    stones = [
        upright_stone(f"stone {n}", (0, 1), (z, z + 1)) for n, z in enumerate(heights.tolist(), start=1)
    ]
    return scene_of(upright_stone("ground", (-5, 6), (-1, 0), fixed=True), *stones)


def solids() -> mo.Scene:
    """Return unit cubes with the gaps of :func:`growing`."""
    return mo.extrude(growing())


@pytest.mark.parametrize(
    ("shaped", "tolerance", "added"),
    [(growing, None, 4), (growing, 0.11, 3), *slow((solids, None, 4)), (solids, 0.11, 4), (solids, 0.31, 4)],
)
def test_gaps_that_grow_are_closed_in_one_round(shaped, tolerance: float | None, added: int) -> None:
    """By hand, the stack overturns about (1, 0.05), so λ (0.55 + 1.67 + 2.8 + 3.94) = 4 · 0.5."""
    said = refusal(shaped().replace(tolerance=tolerance))
    value, joints, blocks = advised(said)
    assert value == 0.141
    assert "'stone 3' and 'stone 4'" in said
    assert ("remove 'tolerance'" in said) is (tolerance is not None)
    # In the plane, a tolerance of 0.11 closes the first gap. In space it closes none, because all faces are
    # narrower than ten times the tolerance.
    assert (joints, blocks) == (added, added)
    result = solved(shaped().replace(contact_tolerance=value))
    assert [result.load_factor, result.associative] == pytest.approx([2 / 8.96] * 2, rel=1e-6)


def surveyed(wall: mo.Scene, error: float, seed: int) -> mo.Scene:
    """Return a wall whose stones have random errors of their corners, relative to the width of the mortar."""
    rng = np.random.default_rng([seed, 61])
    blocks = []
    for block in wall.blocks:
        if not block.fixed:
            errors = error * MORTAR * rng.uniform(-1, 1, (len(block.vertices), 2))
            block = block.replace(vertices=np.array(block.vertices) + errors, live_at=None)
        blocks.append(block)
    return wall.replace(blocks=blocks)


def options_of(said: str) -> dict[str, float]:
    """Return the tolerances that a message advises, by option."""
    return {
        option: float(value)
        for option, value in re.findall(r"'(contact_tolerance|tolerance)' to ([\d.e-]+\d)", said)
    }


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("error", [0.8, 0.9])
def test_stones_that_errors_make_overlap_are_joined_in_one_round(error: float, seed: int) -> None:
    """Corners have errors nearly as large as the mortar, so that some stones overlap and others are apart.

    With the two options of the first message, the wall has all its joints, and no gap is named.
    """
    wall = facade(3, 5)
    scene = surveyed(wall, error, seed)
    said = refusal(scene)
    assert "overlap" in said
    found = contacts_of(scene.replace(**options_of(said)))
    assert (found.gaps, found.lost.gaps, found.bridged) == ({}, {}, {})
    exact = contacts_of(wall.replace(contact_tolerance=0.0101))
    joined = {*zip(found.first.tolist(), found.second.tolist(), strict=True)}
    assert joined >= {*zip(exact.first.tolist(), exact.second.tolist(), strict=True)}


@pytest.mark.parametrize("seed", range(2))
def test_no_tolerance_that_would_remove_joints_of_solids_is_advised(seed: int) -> None:
    """In space, joints narrower than ten times the tolerance are left out, and bricks are 65 mm high."""
    said = refusal(mo.extrude(surveyed(facade(3, 5), 0.9, seed)))
    assert "overlap" in said
    assert options_of(said).keys() == {"contact_tolerance"}


@IN_BOTH
def test_one_brick_that_is_too_long_in_a_turned_wall(shaped) -> None:
    """The message advises the contact tolerance alone, because the sides of all gaps are parallel."""
    wall = facade(3, 5)
    bricks = []
    for block in wall.blocks:
        if block.name == "2-1-0":
            corners = np.array(block.vertices)
            corners[corners[:, 0] > corners[:, 0].mean(), 0] += MORTAR + 0.001
            block = block.replace(vertices=corners.tolist(), live_at=None)
        bricks.append(block)
    said = refusal(shaped(mapped(wall.replace(blocks=bricks), turned(0.3))))
    assert "overlap" in said
    assert options_of(said) == {"contact_tolerance": pytest.approx(MORTAR, rel=0.02)}


@IN_BOTH
def test_a_tolerance_thicker_than_a_stone_is_refused_by_name(shaped) -> None:
    thin = upright_stone("tile", (2, 3), (0, 0.25))
    scene = shaped(scene_of(FLOOR, upright_stone("A", (0, 1), (0, 1)), thin))
    said = refusal(scene.replace(contact_tolerance=0.3))
    assert "'tile' is 0.25 thick" in said
    assert "'contact_tolerance' 0.3" in said
    said = refusal(scene.replace(tolerance=0.3))
    assert "'tile' is too thin for 'tolerance' 0.3" in said
    assert "'contact_tolerance'" in said


@IN_BOTH
def test_copies_of_different_size_and_stones_drawn_into_one_another(shaped) -> None:
    copies = upright_stone("A", (0, 1), (0, 1)), upright_stone("copy", (0, 0.9), (0, 0.9))
    said = refusal(shaped(scene_of(FLOOR, *copies)))
    assert "'A' and 'copy' overlap" in said
    assert "one block is inside the other" in said
    assert "tolerance" not in said
    into = scene_of(FLOOR, upright_stone("A", (0, 1), (0, 1)), upright_stone("B", (0.95, 2), (0, 1)))
    said = refusal(shaped(into))
    assert "set 'contact_tolerance' to 0.0501" in said
    found = contacts_of(shaped(into.replace(contact_tolerance=0.05)))
    assert len(found.first) == 3


def test_joints_that_a_large_tolerance_loses_are_named() -> None:
    """Two bricks of 65 mm are side by side. Faces narrower than ten times the tolerance form no joint, and a
    warning says so."""
    bricks = [upright_stone("A", (0, 0.25), (0, 0.065)), upright_stone("B", (0.26, 0.51), (0, 0.065))]
    scene = mo.extrude(scene_of(FLOOR, *bricks, tolerance=0.0101))
    (warning,) = mo.solve(scene, "static").warnings
    assert (warning.code, warning.values["pairs"]) == (Code.LOST_JOINTS, [["A", "B"]])
    assert warning.values["widths"] == pytest.approx([0.01])
    (sentence,) = sentences([warning])
    assert "set 'contact_tolerance' to 0.0101 and remove 'tolerance'" in sentence
    assert len(contacts_of(scene.replace(tolerance=None, contact_tolerance=0.0101)).first) == 3


@pytest.mark.parametrize("option", ["tolerance", "contact_tolerance"])
@IN_BOTH
def test_head_joints_wider_than_the_option_are_named(shaped, option: str) -> None:
    """The option closes beds of 10 mm but not head joints of 12 mm. The warning names the three head joints
    of each of four courses."""
    bricks = [
        upright_stone(f"{row}-{n}", (left, left + 0.25), (0.01 + 0.075 * row, 0.075 * (row + 1)))
        for row in range(4)
        for n in range(4)
        for left in [0.262 * n + 0.131 * (row % 2)]
    ]
    scene = shaped(scene_of(FLOOR, *bricks, **{option: 0.0101}))
    warnings = mo.solve(scene, "static").warnings
    # A tolerance as large as the mortar causes another warning.
    bridged = [warning for warning in warnings if warning.code is Code.BRIDGED_BY_TOLERANCE]
    assert bool(bridged) == (option == "tolerance")
    (warning,) = [warning for warning in warnings if warning not in bridged]
    assert len(warning.values["pairs"]) == 12
    assert warning.values["widths"] == pytest.approx([0.012] * 12)
    assert "'contact_tolerance' to 0.0121" in sentences([warning])[0]
    closed = scene.replace(tolerance=None, contact_tolerance=0.0121)
    assert len(contacts_of(closed).first) == 4 + 12 + 3 * 7


def test_a_block_too_far_away_is_named_beside_the_gaps() -> None:
    said = refusal(WALL.replace(blocks=[*WALL.blocks, upright_stone("far", (3, 3.2), (1, 1.1))]))
    assert "connects 25 blocks to supports, but not 'far'" in said


def test_a_tolerance_that_hides_all_joints_of_touching_stones_is_named() -> None:
    """Two cubes of 0.1 are on a floor and on each other. Faces narrower than ten times the tolerance form no
    joint."""
    cubes = [upright_stone(name, (0, 0.1), (z, z + 0.1)) for name, z in (("A", 0), ("B", 0.1))]
    scene = mo.extrude(scene_of(FLOOR, *cubes), thickness=0.1)
    said = refusal(scene.replace(tolerance=0.011))
    advice = (
        r"set 'tolerance' to less than ([\d.]+), because its present value prevents 2 joints that would "
        "connect 2 blocks to supports"
    )
    limit = float(re.search(advice, said)[1])
    assert limit <= 0.01
    assert len(contacts_of(scene.replace(tolerance=0.99 * limit)).first) == 2


@IN_BOTH
def test_a_tolerance_as_large_as_mortar_is_named_with_the_contact_tolerance_that_is_meant(shaped):
    """Such a `tolerance` makes the same joints but moves corners, so λ differs by up to 0.6 %. The advised
    `contact_tolerance` has the right λ. Bricks that touch cause no warning."""
    large = shaped(WALL.replace(tolerance=0.0101))
    result = mo.solve(large, "static")
    (warning,) = [warning for warning in result.warnings if warning.code is Code.BRIDGED_BY_TOLERANCE]
    (sentence,) = sentences([warning])
    found = re.search(r"set 'contact_tolerance' to ([\d.]+) and remove 'tolerance'", sentence)
    assert result.load_factor == pytest.approx(STATIC, rel=1e-2)
    meant = mo.solve(large.replace(tolerance=None, contact_tolerance=float(found[1])), "static")
    assert meant.load_factor == pytest.approx(STATIC, rel=1e-4)
    assert meant.warnings == ()
    touching = shaped(drawn_to_touch(WALL)).replace(tolerance=0.0101)
    assert contacts_of(touching).bridged == {}


def test_wide_mortar_between_the_bricks_of_a_ring_is_bridged_in_one_round():
    """The mortar is half as thick as the bricks. The gaps to level springers are narrower."""
    thick, brick = 0.25, 0.197
    scene = brick_ring(1.875, thick, 21, brick)
    blocks = [block for block in scene.blocks if not block.fixed]
    for name, x in (("left", -2.0), ("right", 2.0)):
        blocks.append(stone(name, shapely.box(x - 0.3, -0.2, x + 0.3, 0), fixed=True))
    scene = scene.replace(blocks=blocks)
    with pytest.raises(mo.CaseError) as refusal:
        mo.solve(scene, "static")
    tolerance, joints, connected = advised(str(refusal.value))
    assert (joints, connected) == (22, 21)
    assert len(mo.solve(scene.replace(contact_tolerance=tolerance), "static").joints) == 22


def test_bricks_of_a_ring_that_touch_at_the_intrados_name_the_mortar_between_them():
    """Rectangular bricks as thick as their share of the intrados touch at corners, so that mortar is lost.

    Without a mortar joint the ring is unstable. Voussoirs of the same weights fill the wedges.
    """
    brick = 2 * 1.5 * math.tan(math.pi / 21 / 2)
    scene = brick_ring(1.5, 0.3, 21, brick)
    (warning,) = sentences(mo.solve(scene, "static").warnings)
    assert "if mortar fills the wedges between these blocks, set 'contact_tolerance' to" in warning
    value = float(re.search(r"'contact_tolerance' to ([\d.]+)", warning)[1])
    exact = mo.solve(brick_ring(1.5, 0.3, 21, brick, touching=True), "static").load_factor
    found = mo.solve(scene.replace(contact_tolerance=value), "static")
    assert len(found.joints) == 22
    assert found.load_factor == pytest.approx(exact, rel=0.02)
    assert not found.warnings


@IN_BOTH
def test_bricks_at_an_angle_of_20_degrees_name_the_angle(shaped) -> None:
    """Nine bricks of a semicircle are at 20° to each other, so no contact tolerance joins them."""
    said = refusal(shaped(brick_ring(1.85, 0.3, 9, 0.62)))
    assert "no two facing sides are parallel within 20°: close the gap" in said
    assert "draw the blocks as wedges" in said


@IN_BOTH
def test_bricks_that_meet_diagonally_name_no_angle(shaped) -> None:
    """Sides of the two squares are parallel, but they are not opposite each other."""
    diagonal = upright_stone("B", (1.05, 2), (1.05, 2))
    said = refusal(shaped(scene_of(FLOOR, upright_stone("A", (0, 1), (0, 1)), diagonal)))
    assert "'B' touches no other block: the nearest block 'A' is 0.0707 away: close the gap, or" in said


#: A slate of 0.02 lies on the floor, and a block is far away from all other blocks.
SLATE, FAR = upright_stone("slate", (3, 4), (0, 0.02)), upright_stone("C", (3, 4), (4, 5))


@IN_BOTH
@pytest.mark.parametrize("more", [(), (FAR,)], ids=["alone", "with a distant block"])
def test_no_contact_tolerance_that_a_thin_stone_refuses_is_advised(
    shaped, more: tuple[mo.Block, ...]
) -> None:
    """Only a contact tolerance thicker than the slate would close the gap of 0.05."""
    scene = shaped(scene_of(FLOOR, SLATE, upright_stone("A", (0, 1), (0.05, 1)), *more))
    said = refusal(scene)
    assert "contact_tolerance" not in said
    assert "the nearest block 'floor' is 0.05 away: close the gap, or remove the block" in said


@IN_BOTH
@pytest.mark.parametrize("more", [(), (FAR,)], ids=["alone", "with a distant block"])
def test_gaps_narrower_than_a_thin_stone_are_closed(shaped, more: tuple[mo.Block, ...]) -> None:
    """The gap of 0.01 can be closed, although the gap of 0.05 cannot."""
    narrow, wide = upright_stone("A", (0, 1), (0.01, 1)), upright_stone("B", (-1.5, -0.5), (0.05, 1))
    scene = shaped(scene_of(FLOOR, SLATE, narrow, wide, *more))
    said = refusal(scene)
    assert advised(said) == (0.0101, 1, 1)
    assert "but not 'B'" in said
    closed = refusal(scene.replace(contact_tolerance=0.0101))
    assert "'slate'" not in closed
    assert "'A'" not in closed
    assert "'B'" in closed

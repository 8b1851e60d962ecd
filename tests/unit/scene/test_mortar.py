"""Stones drawn without their mortar: their joints, their load factors, and messages about the gaps."""

import math
import re
from functools import cache

import numpy as np
import pytest
import shapely
from brickwork import MORTAR, Arch, advised, brick_ring, drawn_to_touch, facade, stone, voussoirs
from mappings import mapped, mirrored, shuffled, turned
from scenes import solved
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.reporting.sentences import sentences
from masonry_opt.scene.geometry import geometry
from masonry_opt.solution.reasons import Code

IN_BOTH = pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])

#: Ten courses of two bricks of 240 × 65 mm. STATIC is the load factor of the bricks as solids, whose contacts
#: are found by other code.
WALL = facade(2, 10, length=0.24)
STATIC = 0.57919


@cache
def arched() -> mo.Scene:
    """Return a wall of twelve bricks over an opening under an arch of bricks."""
    return facade(12, 24, (Arch(1.56, 8, 0.5, 21),))


def static(scene: mo.Scene) -> float:
    return mo.solve(scene, "static").required()


def message(scene: mo.Scene) -> str:
    """Return the message with which a scene is refused."""
    with pytest.raises(mo.CaseError) as error:
        contacts_of(scene)
    return str(error.value)


def rectangle(name: str, x: tuple[float, float], y: tuple[float, float], fixed: bool = False) -> mo.Block:
    return stone(name, shapely.box(x[0], y[0], x[1], y[1]), fixed)


def scene_of(*blocks: mo.Block, **keys: object) -> mo.Scene:
    return mo.Scene(**{"joints": {"friction": 0.6}, "blocks": blocks} | keys)


FLOOR = rectangle("floor", (-2, 6), (-1, 0), fixed=True)


@IN_BOTH
@pytest.mark.parametrize("tolerance", [0.01, 0.0101, 0.015])
def test_bricks_with_mortar_have_all_their_joints(shaped, tolerance: float) -> None:
    """The load factor is that of the bricks as solids. A gap exactly as wide as the contact tolerance is
    closed too."""
    scene = shaped(WALL.replace(contact_tolerance=tolerance))
    found = contacts_of(scene)
    assert (len(found.first), found.gaps, found.lost) == (53, {}, {})
    assert static(scene) == pytest.approx(STATIC, rel=1e-4)


def test_joints_are_projections_of_edges_and_corners_stay() -> None:
    """By hand: 15 head joints of 0.065, two beds of 0.24 on the footing, 36 of (0.24 - 0.01) / 2.

    Joints on the footing are in the middle of its gap, at y = 0.005. Head joints are at x = 0.12, 0.245 and
    0.37.
    """
    scene = WALL.replace(contact_tolerance=MORTAR)
    found = contacts_of(scene)
    lengths, count = np.unique(found.extent.round(9), return_counts=True)
    assert dict(zip(lengths.tolist(), count.tolist(), strict=True)) == {0.065: 15, 0.115: 36, 0.24: 2}
    middle = found.middle + geometry(scene).origin
    assert middle[found.extent > 0.2, 1] == pytest.approx([0.005] * 2)
    assert set(middle[found.extent < 0.07, 0].round(9)) == {0.12, 0.245, 0.37}
    assert found.turn.max() == found.shift.max() == 0


def test_a_tolerance_as_large_as_the_mortar_loses_no_joint_of_parallel_edges() -> None:
    """The tolerance moves joints by up to half of its value to align them, so λ agrees only within 2 %."""
    scene = WALL.replace(tolerance=0.0101)
    assert len(contacts_of(scene).first) == 53
    assert static(scene) == pytest.approx(STATIC, rel=0.02)


def test_bricks_with_mortar_are_as_strong_as_bricks_that_touch() -> None:
    """The bricks that touch are larger by half the mortar but have the same weights, so λ agrees only within
    2 %."""
    touching = drawn_to_touch(WALL)
    assert len(contacts_of(touching).first) == 53
    assert static(WALL.replace(contact_tolerance=MORTAR)) == pytest.approx(static(touching), rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("gap", [1e-4, 1e-3, 0.01, 0.03])
@pytest.mark.parametrize("count", [7, 15, 16])
def test_voussoirs_with_uniform_gaps_are_exactly_as_strong_as_voussoirs_that_touch(
    gap: float, count: int
) -> None:
    """With and without gaps, the joints are radii of the ring, so the static and the lowest load factor agree
    to rounding."""
    tolerance, joints, blocks = advised(message(voussoirs(count, gap)))
    assert (joints, blocks) == (count + 1, count)
    assert gap < tolerance <= 1.1 * gap
    touching, apart = voussoirs(count, 0.0), voussoirs(count, gap, contact_tolerance=tolerance)
    assert static(apart) == pytest.approx(static(touching), rel=1e-8)
    assert solved(apart).required() == pytest.approx(solved(touching).required(), rel=1e-8)


@pytest.mark.parametrize(
    "change",
    [
        lambda scene: mapped(scene, turned(0.4), turned(0.4)),
        lambda scene: mapped(scene, mirrored, mirrored),
        lambda scene: mapped(scene, lambda point: (point[0] + 5e3, point[1] - 2e3)),
        shuffled,
    ],
    ids=["turned", "mirrored", "far away", "in another order"],
)
def test_gaps_close_wherever_the_masonry_stands(change) -> None:
    scene = change(voussoirs(9, 0.01)).replace(contact_tolerance=0.01)
    assert len(contacts_of(scene).first) == 10
    assert static(scene) == pytest.approx(static(voussoirs(9, 0.0)), rel=1e-8)


def test_lengths_in_millimetres() -> None:
    scene = mapped(voussoirs(9, 0.01), lambda point: (1000 * point[0], 1000 * point[1]), length=1000.0)
    tolerance, joints, blocks = advised(message(scene))
    assert (tolerance, joints, blocks) == (10.1, 10, 9)
    assert len(contacts_of(scene.replace(contact_tolerance=tolerance)).first) == 10


@pytest.mark.parametrize(
    "ring",
    [(1.0, 0.215, 40, 0.065), (0.5, 0.215, 20, 0.065), (0.3, 0.1025, 12, 0.065), (2.0, 0.4, 80, 0.065)],
)
def test_rectangular_bricks_in_an_arch_have_all_their_joints(ring: tuple[float, float, int, float]) -> None:
    """The gaps are wedges of up to 15°. λ agrees within 2 % with that of voussoirs that fill the gaps."""
    count = ring[2]
    tolerance, joints, blocks = advised(message(brick_ring(*ring)))
    assert (joints, blocks) == (count + 1, count)
    apart = brick_ring(*ring, contact_tolerance=tolerance)
    found = contacts_of(apart)
    assert (len(found.first), found.gaps) == (count + 1, {})
    assert static(apart) == pytest.approx(static(brick_ring(*ring, touching=True)), rel=0.02)


@pytest.mark.slow
def test_the_message_about_a_facade_keeps_its_promise() -> None:
    """One message closes all gaps, with the announced numbers of joints and blocks. In the plane and as
    solids, the façade has the same joints and the same λ."""
    tolerance, joints, blocks = advised(message(arched()))
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
    assert len(closed.first) == advised(message(arched()))[1]


@pytest.mark.slow
def test_a_facade_of_1500_stones_is_as_strong_as_its_solids() -> None:
    """The façade has four arches and five footings. The plane and the solids find contacts by different code,
    and their λ agree within 0.3 %."""
    arches = tuple(Arch(x, 15, 0.5, 21) for x in (1.04, 2.86, 4.68, 6.5))
    scene = facade(30, 56, arches)
    assert len(scene.blocks) == 1481
    tolerance, joints, _ = advised(message(scene))
    closed = scene.replace(contact_tolerance=tolerance)
    assert len(contacts_of(closed).first) == joints
    assert static(closed) == pytest.approx(static(mo.extrude(closed)), rel=0.003)


def growing() -> mo.Scene:
    """Return four unit squares above each other, with gaps of 0.1, 0.12, 0.13 and 0.14 below them."""
    heights = np.cumsum([0.1, 1.12, 1.13, 1.14])
    stones = [rectangle(f"stone {n}", (0, 1), (z, z + 1)) for n, z in enumerate(heights.tolist(), start=1)]
    return scene_of(rectangle("ground", (-5, 6), (-1, 0), fixed=True), *stones)


def solids() -> mo.Scene:
    """Return unit cubes with the gaps of :func:`growing`."""
    return mo.extrude(growing())


@pytest.mark.parametrize(
    ("shaped", "tolerance", "added"),
    [(growing, None, 4), (growing, 0.11, 3), (solids, None, 4), (solids, 0.11, 4), (solids, 0.31, 4)],
)
def test_gaps_that_grow_are_closed_in_one_round(shaped, tolerance: float | None, added: int) -> None:
    """By hand, the stack overturns about (1, 0.05), so λ (0.55 + 1.67 + 2.8 + 3.94) = 4 · 0.5."""
    said = message(shaped().replace(tolerance=tolerance))
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
    said = message(scene)
    assert "overlap" in said
    found = contacts_of(scene.replace(**options_of(said)))
    assert (found.gaps, found.lost, found.bridged) == ({}, {}, {})
    exact = contacts_of(wall.replace(contact_tolerance=0.0101))
    joined = {*zip(found.first.tolist(), found.second.tolist(), strict=True)}
    assert joined >= {*zip(exact.first.tolist(), exact.second.tolist(), strict=True)}


@pytest.mark.parametrize("seed", range(2))
def test_no_tolerance_that_would_remove_joints_of_solids_is_advised(seed: int) -> None:
    """In space, joints narrower than ten times the tolerance are left out, and bricks are 65 mm high."""
    said = message(mo.extrude(surveyed(facade(3, 5), 0.9, seed)))
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
    said = message(shaped(mapped(wall.replace(blocks=bricks), turned(0.3))))
    assert "overlap" in said
    assert options_of(said) == {"contact_tolerance": pytest.approx(MORTAR, rel=0.02)}


@IN_BOTH
def test_a_tolerance_thicker_than_a_stone_is_refused_by_name(shaped) -> None:
    thin = rectangle("tile", (2, 3), (0, 0.25))
    scene = shaped(scene_of(FLOOR, rectangle("A", (0, 1), (0, 1)), thin))
    said = message(scene.replace(contact_tolerance=0.3))
    assert "'tile' is 0.25 thick" in said
    assert "'contact_tolerance' 0.3" in said
    said = message(scene.replace(tolerance=0.3))
    assert "'tile' is too thin for 'tolerance' 0.3" in said
    assert "'contact_tolerance'" in said


@IN_BOTH
def test_copies_of_different_size_and_stones_drawn_into_one_another(shaped) -> None:
    copies = rectangle("A", (0, 1), (0, 1)), rectangle("copy", (0, 0.9), (0, 0.9))
    said = message(shaped(scene_of(FLOOR, *copies)))
    assert "'A' and 'copy' overlap" in said
    assert "one block is inside the other" in said
    assert "tolerance" not in said
    into = scene_of(FLOOR, rectangle("A", (0, 1), (0, 1)), rectangle("B", (0.95, 2), (0, 1)))
    said = message(shaped(into))
    assert "set 'contact_tolerance' to 0.0501" in said
    found = contacts_of(shaped(into.replace(contact_tolerance=0.05)))
    assert len(found.first) == 3


@IN_BOTH
def test_no_joint_reaches_through_a_third_block(shaped) -> None:
    """A tile of 0.02 is between two stones, with mortar of 0.002. The stones get no joint through the
    tile."""
    stones = [rectangle("A", (0, 1), (0, 1)), rectangle("B", (0, 1), (1.024, 2))]
    tile = rectangle("tile", (0, 1), (1.002, 1.022), fixed=True)
    scene = shaped(scene_of(FLOOR, *stones, tile, contact_tolerance=0.03))
    names = [block.name for block in scene.blocks]
    found = contacts_of(scene)
    pairs = {frozenset((names[i], names[j])) for i, j in zip(found.first, found.second, strict=True)}
    assert pairs == {frozenset(pair) for pair in (("floor", "A"), ("A", "tile"), ("tile", "B"))}


def test_a_corner_above_an_edge_is_no_joint_across_mortar() -> None:
    tip = stone("tip", shapely.Polygon([(0.5, 1.01), (1, 2), (0, 2)]))
    scene = scene_of(FLOOR, rectangle("A", (0, 1), (0, 1)), tip, contact_tolerance=0.02)
    assert "'tip' touches no other block" in message(scene)


def test_joints_that_a_large_tolerance_loses_are_named() -> None:
    """Two bricks of 65 mm are side by side. Faces narrower than ten times the tolerance form no joint, and a
    warning says so."""
    bricks = [rectangle("A", (0, 0.25), (0, 0.065)), rectangle("B", (0.26, 0.51), (0, 0.065))]
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
        rectangle(f"{row}-{n}", (left, left + 0.25), (0.01 + 0.075 * row, 0.075 * (row + 1)))
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
    said = message(WALL.replace(blocks=[*WALL.blocks, rectangle("far", (3, 3.2), (1, 1.1))]))
    assert "connects 25 blocks to supports, but not 'far'" in said


@pytest.mark.parametrize("chords", [(14, 14), (14, 24)])
def test_parallel_arcs_in_chords_are_one_line_across_mortar(chords: tuple[int, int]) -> None:
    """A cap and a vault, 20 mm apart, form one arc of 60° at the middle of the gap. λ agrees within 2 % with
    that of a cap that touches the vault.

    The rise of the chords is 3.5 % of the gap.
    """

    def arc(radius: float, count: int) -> list[tuple[float, float]]:
        angles = np.linspace(math.pi / 3, 2 * math.pi / 3, count + 1)
        return [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]

    def scene(gap: float, pieces: tuple[int, int]) -> mo.Scene:
        inner, outer = arc(1 - gap / 2, pieces[0]), arc(1 + gap / 2, pieces[1])
        vault = stone("vault", shapely.Polygon([*inner, (-0.5, 0), (0.5, 0)]), fixed=True)
        weight = {"weight": 1, "weight_at": (0, 1.2)}
        cap = stone("cap", shapely.Polygon([*outer, (-0.5, 1.4), (0.5, 1.4)]), **weight)
        return scene_of(vault, cap, contact_tolerance=gap or None)

    apart = scene(0.02, chords)
    found = contacts_of(apart)
    assert found.gaps == {}
    assert found.extent.sum() == pytest.approx(math.pi / 3, rel=0.02)
    assert static(apart) == pytest.approx(static(scene(0.0, (14, 14))), rel=0.02)


def test_a_tolerance_that_hides_all_joints_of_touching_stones_is_named() -> None:
    """Two cubes of 0.1 are on a floor and on each other. Faces narrower than ten times the tolerance form no
    joint."""
    cubes = [rectangle(name, (0, 0.1), (z, z + 0.1)) for name, z in (("A", 0), ("B", 0.1))]
    scene = mo.extrude(scene_of(FLOOR, *cubes), thickness=0.1)
    said = message(scene.replace(tolerance=0.011))
    assert (
        "lower 'tolerance', because its present value prevents 2 joints that would connect 2 blocks to "
        "supports" in said
    )
    assert len(contacts_of(scene.replace(tolerance=0.009)).first) == 2


def test_the_joint_of_an_exception_may_be_across_mortar() -> None:
    held = mo.Joint(between=("0-0-0", "0-1-0"), friction=0.9)
    scene = WALL.replace(exceptions=[held])
    found = contacts_of(scene.replace(contact_tolerance=MORTAR))
    assert sorted(set(found.friction)) == [0.6, 0.9]


@pytest.mark.parametrize("pressure", [{"pressure": False}, {"friction_angle": 30, "mobilised": 0.5}])
@pytest.mark.parametrize("count", [15, 16])
def test_fill_on_an_arch_lies_on_its_mortar_too(count: int, pressure: dict[str, float]) -> None:
    """The fill also covers the gaps, so λ is that of the arch drawn to touch. With 16 voussoirs, the gap at
    the crown is vertical."""
    earth = mo.Fill(road=[(-1.2, 1.6), (1.2, 1.6)], unit_weight=2, **pressure)
    touching, apart = (
        voussoirs(count, gap, contact_tolerance=gap or None, fills=[earth]) for gap in (0.0, 0.02)
    )
    assert static(apart) == pytest.approx(static(touching), rel=1e-8)


@pytest.mark.parametrize("gap", [0.0, 0.01, 0.05])
def test_an_edge_load_pushes_stones_and_mortar(gap: float) -> None:
    """By hand, a load of 1 per length overturns a stack of height h = 4 - gap and weight 4: λ h · 2 = 4 ·
    0.5."""
    stones = [
        rectangle(f"{k}", (0, 1), (k + gap / 2, k + 1 - gap / 2)).replace(
            live_per_weight=(0, 0), weight=1, unit_weight=None
        )
        for k in range(4)
    ]
    ground = rectangle("ground", (-1, 2), (-1, -gap / 2), fixed=True)
    load = mo.EdgeLoad(**{"from": (0, gap / 2), "to": (0, 4 - gap / 2), "force": (1, 0), "kind": "live"})
    scene = scene_of(ground, *stones, edge_loads=[load], contact_tolerance=gap or None)
    result = mo.solve(scene, "static")
    assert result.load_factor == pytest.approx(1 / (4 - gap), rel=1e-8)
    assert result.warnings == ()


def test_a_drawing_without_mortar_is_read_with_a_contact_tolerance(tmp_path) -> None:
    path = tmp_path / "wall.dxf"
    mo.write_dxf(WALL, path)
    given = {"friction": 0.6, "unit_weight": 1, "live": (1, 0)}
    assert advised(message(mo.read_dxf(path, **given))) == (0.0101, 53, 25)
    assert static(mo.read_dxf(path, **given, contact_tolerance=0.01)) == pytest.approx(STATIC, rel=1e-4)
    solid = mo.read_dxf(path, **given, contact_tolerance=0.01, thickness=0.5)
    assert static(solid) == pytest.approx(STATIC, rel=1e-4)


def test_a_case_file_keeps_its_contact_tolerance(tmp_path) -> None:
    path = tmp_path / "wall.toml"
    mo.save(WALL.replace(contact_tolerance=0.01), path)
    assert "contact_tolerance = 0.01" in path.read_text()
    assert static(mo.load(path)) == pytest.approx(STATIC, rel=1e-4)
    assert math.isclose(mo.load(path).contact_tolerance, 0.01)


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


def test_bricks_at_an_angle_of_20_degrees_name_the_angle():
    """Nine bricks of a semicircle are at 20° to each other, so no contact tolerance joins them."""
    with pytest.raises(
        mo.CaseError, match=r"face each other at an angle of less than 20°: .*draw the blocks"
    ):
        mo.solve(brick_ring(1.85, 0.3, 9, 0.62), "static")

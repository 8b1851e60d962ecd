"""Stones drawn without their mortar: their joints and their load factors with a contact tolerance."""

import math

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
    voussoirs,
)
from mappings import mapped, mirrored, shuffled, turned
from scenes import solved
from touching_solids import contacts_of, refusal

import masonry_opt as mo
from masonry_opt.scene.geometry import geometry

IN_BOTH = pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])


@IN_BOTH
@pytest.mark.parametrize("tolerance", [0.01, 0.0101, 0.015])
def test_bricks_with_mortar_have_all_their_joints(shaped, tolerance: float) -> None:
    """The load factor is that of the bricks as solids. A gap exactly as wide as the contact tolerance is
    closed too."""
    scene = shaped(WALL.replace(contact_tolerance=tolerance))
    found = contacts_of(scene)
    assert (len(found.first), found.gaps, found.lost.gaps) == (53, {}, {})
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
    tolerance, joints, blocks = advised(refusal(voussoirs(count, gap)))
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
    tolerance, joints, blocks = advised(refusal(scene))
    assert (tolerance, joints, blocks) == (10.1, 10, 9)
    assert len(contacts_of(scene.replace(contact_tolerance=tolerance)).first) == 10


@pytest.mark.parametrize(
    "ring",
    [
        *((0.5, 0.215, 20, 0.065), (0.3, 0.1025, 12, 0.065)),
        *(
            pytest.param(ring, marks=pytest.mark.slow)
            for ring in ((1.0, 0.215, 40, 0.065), (2.0, 0.4, 80, 0.065))
        ),
    ],
)
def test_rectangular_bricks_in_an_arch_have_all_their_joints(ring: tuple[float, float, int, float]) -> None:
    """The gaps are wedges of up to 15°. λ agrees within 2 % with that of voussoirs that fill the gaps."""
    count = ring[2]
    tolerance, joints, blocks = advised(refusal(brick_ring(*ring)))
    assert (joints, blocks) == (count + 1, count)
    apart = brick_ring(*ring, contact_tolerance=tolerance)
    found = contacts_of(apart)
    assert (len(found.first), found.gaps) == (count + 1, {})
    assert static(apart) == pytest.approx(static(brick_ring(*ring, touching=True)), rel=0.02)


@pytest.mark.slow
def test_a_facade_of_1500_stones_is_as_strong_as_its_solids() -> None:
    """The façade has four arches and five footings. The plane and the solids find contacts by different code,
    and their λ agree within 0.3 %."""
    arches = tuple(Arch(x, 15, 0.5, 21) for x in (1.04, 2.86, 4.68, 6.5))
    scene = facade(30, 56, arches)
    assert len(scene.blocks) == 1481
    tolerance, joints, _ = advised(refusal(scene))
    closed = scene.replace(contact_tolerance=tolerance)
    assert len(contacts_of(closed).first) == joints
    assert static(closed) == pytest.approx(static(mo.extrude(closed)), rel=0.003)


@IN_BOTH
def test_no_joint_reaches_through_a_third_block(shaped) -> None:
    """A tile of 0.02 is between two stones, with mortar of 0.002. The stones get no joint through the
    tile."""
    stones = [upright_stone("A", (0, 1), (0, 1)), upright_stone("B", (0, 1), (1.024, 2))]
    tile = upright_stone("tile", (0, 1), (1.002, 1.022), fixed=True)
    scene = shaped(scene_of(FLOOR, *stones, tile, contact_tolerance=0.03))
    names = [block.name for block in scene.blocks]
    found = contacts_of(scene)
    pairs = {frozenset((names[i], names[j])) for i, j in zip(found.first, found.second, strict=True)}
    assert pairs == {frozenset(pair) for pair in (("floor", "A"), ("A", "tile"), ("tile", "B"))}


def test_a_corner_above_an_edge_is_no_joint_across_mortar() -> None:
    tip = stone("tip", shapely.Polygon([(0.5, 1.01), (1, 2), (0, 2)]))
    scene = scene_of(FLOOR, upright_stone("A", (0, 1), (0, 1)), tip, contact_tolerance=0.02)
    assert "'tip' touches no other block" in refusal(scene)


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
        upright_stone(f"{k}", (0, 1), (k + gap / 2, k + 1 - gap / 2)).replace(
            live_per_weight=(0, 0), weight=1, unit_weight=None
        )
        for k in range(4)
    ]
    ground = upright_stone("ground", (-1, 2), (-1, -gap / 2), fixed=True)
    load = mo.EdgeLoad(**{"from": (0, gap / 2), "to": (0, 4 - gap / 2), "force": (1, 0), "kind": "live"})
    scene = scene_of(ground, *stones, edge_loads=[load], contact_tolerance=gap or None)
    result = mo.solve(scene, "static")
    assert result.load_factor == pytest.approx(1 / (4 - gap), rel=1e-8)
    assert result.warnings == ()


def test_a_drawing_without_mortar_is_read_with_a_contact_tolerance(tmp_path) -> None:
    path = tmp_path / "wall.dxf"
    mo.write_dxf(WALL, path)
    given = {"friction": 0.6, "unit_weight": 1, "live": (1, 0)}
    assert advised(refusal(mo.read_dxf(path, **given))) == (0.0101, 53, 25)
    assert static(mo.read_dxf(path, **given, contact_tolerance=0.01)) == pytest.approx(STATIC, rel=1e-4)
    solid = mo.read_dxf(path, **given, contact_tolerance=0.01, thickness=0.5)
    assert static(solid) == pytest.approx(STATIC, rel=1e-4)


def test_a_case_file_keeps_its_contact_tolerance(tmp_path) -> None:
    path = tmp_path / "wall.toml"
    mo.save(WALL.replace(contact_tolerance=0.01), path)
    assert "contact_tolerance = 0.01" in path.read_text()
    assert static(mo.load(path)) == pytest.approx(STATIC, rel=1e-4)
    assert math.isclose(mo.load(path).contact_tolerance, 0.01)

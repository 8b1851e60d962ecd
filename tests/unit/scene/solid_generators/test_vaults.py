"""Barrel and groin vaults, domes and shafts: volumes, joints and places by closed forms, what is refused."""

from math import cos, hypot, pi, radians, sin

import numpy as np
import pytest
import shapely

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

BARREL = {"span": 4.0, "rise": 1.0, "thickness": 0.4, "voussoirs": 9, "length": 3.0, "unit_weight": 2.0}
DOME = {"radius": 2.0, "thickness": 0.3, "rings": 4, "voussoirs": 8, "unit_weight": 2.0}
GROIN = {
    "span": 4.0,
    "rise": 2.0,
    "thickness": 0.4,
    "voussoirs": 10,
    "bay": 6.0,
    "stone": 0.8,
    "unit_weight": 2.0,
}
SHAFT = {"diameter": (1.2, 0.8), "sides": 12, "height": 5.0, "drums": 6, "unit_weight": 2.0}


def assembled(generator):
    assembly = assemble(mo.Scene(joints={"friction": 0.6}, blocks=generator.blocks()))
    assert not assembly.joints.gaps
    assert not assembly.joints.without_normal
    return assembly


def moving(assembly, values):
    return sum(value for block, value in zip(assembly.scene.blocks, values, strict=True) if not block.fixed)


@pytest.mark.parametrize(
    "keys", [{}, {"skewbacks": 0.5}, {"rise": 3.0, "voussoirs": 8}, {"abutments": False}]
)
def test_a_barrel_of_one_stone_is_an_arch_extruded(keys):
    made = mo.Barrel(**BARREL | keys).blocks()
    foot = mo.Block(name="foot", vertices=[(-9, -9), (9, -9), (9, -8), (-9, -8)], fixed=True)
    arch = mo.Arch(**{key: value for key, value in (BARREL | keys).items() if key != "length"})
    flat = mo.Scene(joints={"friction": 0.6}, thickness=3.0, blocks=[foot, *arch.blocks(thickness=3.0)])
    extruded = mo.extrude(flat).in_space()[1:]
    assert [block.name.removesuffix("-1") for block in made] == [block.name for block in extruded]
    for one, other in zip(made, extruded, strict=True):
        apart = np.linalg.norm(one.corners()[:, None] - other.corners(), axis=2)
        assert max(*apart.min(axis=0), *apart.min(axis=1)) < 1e-12
        assert one.weight == pytest.approx(other.weight)
        if other.weight_at is not None:
            np.testing.assert_allclose(one.weight_at, other.weight_at, atol=1e-12)


@pytest.mark.parametrize(("stone", "pieces"), [(1.0, (3, 4)), (0.8, (4, 5)), (2.0, (2, 2))])
@pytest.mark.parametrize("keys", [{}, {"skewbacks": 0.5, "rise": 0.8}])
def test_stones_of_a_barrel_fill_it_and_lie_in_bond(stone, pieces, keys):
    """Upright joints are sections of the arch: one less than stones a voussoir; beds as the vault."""
    whole, cut = (assembled(mo.Barrel(**BARREL | keys, stone=each)) for each in (None, stone))
    assert cut.geometry.size.sum() == pytest.approx(whole.geometry.size.sum())
    weights = [sum(block.weight or 0 for block in each.scene.blocks) for each in (whole, cut)]
    assert weights[0] == pytest.approx(weights[1])
    beds = whole.joints.extent.sum()
    rows = [*range(9), *((1, 9) if keys else ())]
    section = [volume / 3 for volume in whole.geometry.size]
    heads = sum(section[at] * (pieces[row % 2] - 1) for at, row in enumerate(rows))
    assert cut.joints.extent.sum() == pytest.approx(beds + heads)
    stacked = assembled(mo.Barrel(**BARREL | keys, stone=stone, bond="stacked"))
    assert stacked.joints.extent.sum() == pytest.approx(beds + sum(section[: len(rows)]) * (pieces[0] - 1))
    # In bond no upright joint meets another at a bed: these are cut at the joints of both sides.
    joints = cut.joints
    upright = np.abs(joints.normal[:, 1]) > 0.5
    assert (
        len(joints.first) - upright.sum()
        > len(stacked.joints.first) - (np.abs(stacked.joints.normal[:, 1]) > 0.5).sum()
    )


@pytest.mark.parametrize(
    "keys", [{}, {"springing": 20.0}, {"oculus": 0.5}, {"oculus": 0.5, "springing": 10.0}]
)
@pytest.mark.parametrize("bond", ["running", "meridians"])
def test_a_dome_is_whole(bond, keys):
    """Volume: a section swept round the axis between flat faces, n sin(2π/n) ∫∫ ρ dA. Joints: beds of n
    trapezoids, and voussoirs' own sections, half (r₂² - r₁²) sin Δ each."""
    made = mo.Dome(**DOME, bond=bond, **keys)
    assembly = assembled(made)
    inner, outer, rings, n = 1.85, 2.15, 4, 16 if bond == "running" else 8
    first = radians(keys.get("springing", 0.0))
    end = np.arccos(0.5 / inner) if "oculus" in keys else pi / 2
    step = (end - first) / (rings + 0.5 * ("oculus" not in keys))
    volume = sum(
        n
        * sin(2 * pi / n)
        * (outer**3 - inner**3)
        / 3
        * sin(step)
        * cos(step / 2)
        * cos(first + (ring + 0.5) * step)
        for ring in range(rings)
    )
    angles = [first + ring * step for ring in range(rings + 1)]
    beds = [
        n * sin(pi / n) * cos(angle) * (inner + outer) * 0.3 * hypot(cos(angle) * cos(pi / n), sin(angle))
        for angle in angles
    ]
    if "oculus" in keys:
        beds.pop()
        highest = max(block.corners()[:, 2].max() for block in made.blocks())
        assert highest == pytest.approx(outer * np.sqrt(1 - (0.5 / inner) ** 2))
    else:
        (low, z0), (high, z1) = ((d * cos(angles[-1]), d * sin(angles[-1])) for d in (inner, outer))
        volume += n / 2 * sin(2 * pi / n) * (low**2 + low * high + high**2) / 3 * (z1 - z0)
    assert moving(assembly, assembly.geometry.size) == pytest.approx(volume)
    sides = rings * 8 * (outer**2 - inner**2) / 2 * sin(step)
    assert assembly.joints.extent.sum() == pytest.approx(sum(beds) + sides)
    # Corners of neighbours coincide: each bed between rings is one trapezoid a sector.
    each = 2 if bond == "running" else 1
    foot = each if first else 1  # a level foot is one plane
    joints = rings * 8 + 8 * (each * (rings - 1) + foot + (0 if "oculus" in keys else each))
    assert len(assembly.joints.first) == joints


@pytest.mark.parametrize("rise", [1.2, 2.0, 3.0])
def test_a_groin_vault_is_whole(rise):
    """Each of eight legs is the half arch between the groin, y = x, and the end of the barrel, y = 3: of a
    piece of section dA it has 3 - x, of beds as much of each dx. At the crown two legs share a joint."""
    assembly = assembled(mo.Groin(**GROIN | {"rise": rise}))
    arch = mo.Arch(span=4.0, rise=rise, thickness=0.4, voussoirs=10, unit_weight=1.0)
    half = [shapely.Polygon(block.vertices) for block in arch.blocks()[5:10]]
    volume = [section.area * (3 - section.centroid.x) for section in half]
    assert moving(assembly, assembly.geometry.size) == pytest.approx(8 * sum(volume))
    crown, *beds = [shapely.LineString(block.vertices[:2]) for block in arch.blocks()[5:10]]
    beds.append(shapely.LineString(arch.blocks()[9].vertices[2:]))
    of_beds = 8 * sum(bed.length * (3 - bed.centroid.x) for bed in beds) + 4 * crown.length * 3
    sections = [section.area for section in half[::-1]]
    pieces = [
        sum(block.name.startswith(f"1 x{course}-") for block in assembly.scene.blocks)
        for course in range(1, 6)
    ]
    heads = 8 * sum(number * area for number, area in zip(pieces, sections, strict=True))
    assert assembly.joints.extent.sum() == pytest.approx(of_beds + heads)


@pytest.mark.parametrize("sides", [3, 4, 12])
def test_a_shaft_is_a_frustum(sides):
    made = mo.Shaft(**SHAFT | {"sides": sides}, at=(1.0, 2.0, 3.0))
    assembly = assembled(made)
    polygon = sides / 2 * sin(2 * pi / sides)
    radii = np.linspace(0.6, 0.4, 7)
    assert moving(assembly, assembly.geometry.size) == pytest.approx(polygon * 5 * (0.36 + 0.24 + 0.16) / 3)
    assert assembly.joints.extent.sum() == pytest.approx(polygon * (radii[:6] ** 2).sum())
    foot = made.blocks()[0].corners()
    assert foot[:, 2].min() == 3.0
    # One side faces x.
    assert foot[:, 0].max() == pytest.approx(1 + 0.6 * cos(pi / sides))


REFUSED = [
    (mo.Barrel, BARREL | {"stone": 4.0}, "'stone' is longer than the vault"),
    (mo.Barrel, BARREL | {"radius": 1.0}, "'radius' and 'angles', or 'span' and 'rise'"),
    (mo.Barrel, BARREL | {"rise": 3.0}, "even number of 'voussoirs'"),
    (mo.Barrel, BARREL | {"stone": 1e-5}, "blocks large"),
    (mo.Barrel, BARREL | {"at": (1, 2)}, "three numbers"),
    (mo.Barrel, BARREL | {"live": (1, 2)}, "unknown key 'live'"),
    (mo.Barrel, BARREL | {"length": 0.0}, "'length'"),
    (mo.Dome, DOME | {"thickness": 4.0}, "less than twice the 'radius'"),
    (mo.Dome, DOME | {"oculus": 1.9}, "less than the foot's radius within, 1.85"),
    (mo.Dome, DOME | {"springing": 90.0}, "'springing'"),
    (mo.Dome, DOME | {"voussoirs": 2}, "'voussoirs'"),
    (mo.Dome, DOME | {"bond": "stacked"}, "'bond'"),
    (mo.Dome, DOME | {"rings": 1000, "voussoirs": 1000}, "blocks large"),
    (mo.Groin, GROIN | {"bay": 5.0}, "'bay' must be 5.2 or more"),
    (mo.Groin, GROIN | {"voussoirs": 9}, "'voussoirs'"),
    (mo.Groin, GROIN | {"stone": 1e-4}, "blocks large"),
    (mo.Shaft, SHAFT | {"sides": 2}, "'sides'"),
    (mo.Shaft, SHAFT | {"diameter": (1.0, 0.0)}, r"'diameter\[1\]'"),
    (mo.Shaft, SHAFT | {"drums": 0}, "'drums'"),
]


@pytest.mark.parametrize(("record", "keys", "words"), REFUSED)
def test_what_cannot_be_built_is_refused(record, keys, words):
    with pytest.raises(mo.CaseError, match=words):
        record(**keys)


CASE = """
[joints]
friction = 0.6
[dome]
radius = 2
thickness = 0.3
rings = 2
voussoirs = 6
unit_weight = 1
{}
"""


def test_case_files_have_them(tmp_path):
    path = tmp_path / "dome.toml"
    path.write_text(
        CASE.format(
            "[[shaft]]\nname = 's'\nat = [0, 0, 9]\ndiameter = 1\n"
            "sides = 8\nheight = 2\ndrums = 2\nunit_weight = 1"
        )
    )
    scene = mo.load(path)
    assert scene.gravity == (0, 0, -1)
    assert [block.name for block in scene.blocks[-3:]] == ["s d1", "s d2", "s base"]
    assert scene.blocks[:14] == mo.Dome(radius=2, thickness=0.3, rings=2, voussoirs=6, unit_weight=1).blocks()
    copied = tmp_path / "copied.toml"
    mo.save(scene, copied)
    assert mo.load(copied) == scene


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (
            "[column]\nwidth = 1\nheight = 2\ndrums = 2\nunit_weight = 1",
            r"\[column\] builds blocks in the plane",
        ),
        ("[[block]]\nname = 'A'\nvertices = [[0, 0], [1, 0], [1, 1]]\nweight = 1", "'A' lies in the plane"),
        ("thicknes = 1", "did you mean 'thickness'"),
        ("oculus = 5", r"\[dome\]: 'oculus' must be less"),
    ],
)
def test_what_does_not_go_with_them_is_refused(tmp_path, other, words):
    path = tmp_path / "dome.toml"
    path.write_text(CASE.format(other))
    with pytest.raises(mo.CaseError, match=words):
        mo.load(path)

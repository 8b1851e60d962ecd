"""Generators of solids: vaults are compared with closed forms, walls along a plan are bonded, and wrong keys
raise errors."""

from itertools import pairwise
from math import cos, hypot, pi, radians, sin

import numpy as np
import pytest
import shapely
import tomli_w
from speeds import slow

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

BARREL = {"span": 4.0, "rise": 1.0, "thickness": 0.4, "voussoirs": 9, "length": 3.0, "unit_weight": 2.0}
DOME = {"radius": 2.0, "thickness": 0.3, "rings": 4, "voussoirs": 8, "unit_weight": 2.0}
GROIN = {"span": 4, "rise": 2, "thickness": 0.4, "voussoirs": 10, "bay": 6, "stone": 0.8, "unit_weight": 2}
SHAFT = {"diameter": (1.2, 0.8), "sides": 12, "height": 5.0, "drums": 6, "unit_weight": 2.0}


def assembled(generator):
    assembly = assemble(mo.Scene(joints={"friction": 0.6}, blocks=generator.blocks()))
    assert not assembly.joints.gaps
    assert not assembly.joints.without_normal
    return assembly


def moving(assembly, values):
    return sum(value for block, value in zip(assembly.scene.blocks, values, strict=True) if not block.fixed)


@pytest.mark.parametrize("keys", [{}, {"skewbacks": 0.5}, {"rise": 3, "voussoirs": 8}, {"abutments": False}])
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


@pytest.mark.parametrize(("stone", "pieces"), [(1.0, (3, 4)), *slow((0.8, (4, 5)), (2.0, (2, 2)))])
@pytest.mark.parametrize("keys", [{}, {"skewbacks": 0.5, "rise": 0.8}])
def test_stones_of_a_barrel_fill_it_and_lie_in_bond(stone, pieces, keys):
    """A barrel of many stones has the volume, weight and beds of a barrel with one stone per voussoir. The
    number of head joints of a voussoir is one less than that of its stones. Each has the area of the arch
    section."""
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
    # In running bond, the head joints of neighbouring rows do not meet, and both cut the bed into more
    # joints.
    beds_of = [(np.abs(each.joints.normal[:, 1]) <= 0.5).sum() for each in (cut, stacked)]
    assert beds_of[0] > beds_of[1]


@pytest.mark.parametrize(
    "keys", [{}, {"oculus": 0.5, "springing": 10}, *slow({"springing": 20}, {"oculus": 0.5})]
)
@pytest.mark.parametrize("bond", ["running", "meridians"])
def test_a_dome_is_whole(bond, keys):
    """The volume is that of a section swept around the axis between flat faces: n sin(2π/n) ∫∫ ρ dA. The
    joints are beds of n trapezoids, and sections of voussoirs with the area (r₂² - r₁²) sin(Δ) / 2 each."""
    made = mo.Dome(**DOME, bond=bond, **keys)
    assembly = assembled(made)
    inner, outer, rings, n = 1.85, 2.15, 4, 16 if bond == "running" else 8
    first = radians(keys.get("springing", 0.0))
    end = np.arccos(0.5 / inner) if "oculus" in keys else pi / 2
    step = (end - first) / (rings + 0.5 * ("oculus" not in keys))
    section = (outer**3 - inner**3) / 3 * sin(step) * cos(step / 2)
    volume = n * sin(2 * pi / n) * section * sum(cos(first + (ring + 0.5) * step) for ring in range(rings))
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
    # Corners of neighbours coincide, so each bed between rings is one trapezoid per sector.
    each = 2 if bond == "running" else 1
    foot = each if first else 1  # a horizontal foot is one plane
    joints = rings * 8 + 8 * (each * (rings - 1) + foot + (0 if "oculus" in keys else each))
    assert len(assembly.joints.first) == joints


@pytest.mark.parametrize("rise", [1.2, 2.0, 3.0])
def test_a_groin_vault_is_whole(rise):
    """Each of eight legs is half of the arch between the groin, y = x, and the end of the barrel, y = 3. At
    each x the leg is 3 - x long, which determines its volume and its beds. At the crown, two legs share a
    joint."""
    assembly = assembled(mo.Groin(**GROIN | {"rise": rise}))
    arch = mo.Arch(span=4.0, rise=rise, thickness=0.4, voussoirs=10, unit_weight=1.0)
    half = [shapely.Polygon(block.vertices) for block in arch.blocks()[5:10]]
    volume = [section.area * (3 - section.centroid.x) for section in half]
    assert moving(assembly, assembly.geometry.size) == pytest.approx(8 * sum(volume))
    crown, *beds = [shapely.LineString(block.vertices[:2]) for block in arch.blocks()[5:10]]
    beds.append(shapely.LineString(arch.blocks()[9].vertices[2:]))
    of_beds = 8 * sum(bed.length * (3 - bed.centroid.x) for bed in beds) + 4 * crown.length * 3
    sections = [section.area for section in half[::-1]]
    names = [block.name for block in assembly.scene.blocks]
    pieces = [sum(name.startswith(f"1 x{course}-") for name in names) for course in range(1, 6)]
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
    (mo.Barrel, BARREL | {"stone": 4.0}, "'stone' must be at most 3, the length of the vault"),
    (mo.Barrel, BARREL | {"radius": 1.0}, "'radius' and 'angles', or 'span' and 'rise'"),
    (mo.Barrel, BARREL | {"rise": 3.0}, "even number of 'voussoirs'"),
    (mo.Barrel, BARREL | {"stone": 1e-5}, "at most 100000"),
    (mo.Barrel, BARREL | {"at": (1, 2)}, "three numbers"),
    (mo.Barrel, BARREL | {"live": (1, 2)}, "unknown key 'live'"),
    (mo.Barrel, BARREL | {"length": 0.0}, "'length'"),
    (mo.Dome, DOME | {"thickness": 4.0}, "less than twice the 'radius'"),
    (mo.Dome, DOME | {"oculus": 1.9}, "less than 1.85, the inner radius at the foot"),
    (mo.Dome, DOME | {"springing": 90.0}, "'springing'"),
    (mo.Dome, DOME | {"voussoirs": 2}, "'voussoirs'"),
    (mo.Dome, DOME | {"bond": "stacked"}, "'bond'"),
    (mo.Dome, DOME | {"rings": 1000, "voussoirs": 1000}, "at most 100000"),
    (mo.Groin, GROIN | {"bay": 5.0}, "'bay' must be at least 5.2"),
    (mo.Groin, GROIN | {"voussoirs": 9}, "'voussoirs'"),
    (mo.Groin, GROIN | {"stone": 1e-4}, "at most 100000"),
    (mo.Shaft, SHAFT | {"sides": 2}, "'sides'"),
    (mo.Shaft, SHAFT | {"diameter": (1.0, 0.0)}, r"'diameter\[1\]'"),
    (mo.Shaft, SHAFT | {"drums": 0}, "'drums'"),
]


@pytest.mark.parametrize(("record", "keys", "words"), REFUSED)
def test_what_cannot_be_built_is_refused(record, keys, words):
    with pytest.raises(mo.CaseError, match=words):
        record(**keys)


SMALL = {"radius": 2, "thickness": 0.3, "rings": 2, "voussoirs": 6, "unit_weight": 1}
ON_TOP = {"name": "s", "at": [0, 0, 9], "diameter": 1, "sides": 8, "height": 2, "drums": 2, "unit_weight": 1}


def loaded(folder, **tables):
    """Return the scene of a case file with a small dome and other tables."""
    path = folder / "dome.toml"
    path.write_text(tomli_w.dumps({"joints": {"friction": 0.6}, "dome": SMALL} | tables))
    return mo.load(path)


def test_case_files_have_them(tmp_path):
    scene = loaded(tmp_path, shaft=[ON_TOP])
    assert scene.gravity == (0, 0, -1)
    assert [block.name for block in scene.blocks[-3:]] == ["s d1", "s d2", "s base"]
    assert scene.blocks[:14] == mo.Dome(**SMALL).blocks()
    copied = tmp_path / "copied.toml"
    mo.save(scene, copied)
    assert mo.load(copied) == scene


COLUMN = {"width": 1, "height": 2, "drums": 2, "unit_weight": 1}
FLAT = {"name": "A", "vertices": [[0, 0], [1, 0], [1, 1]], "weight": 1}


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"column": COLUMN}, r"\[column\] builds blocks in the"),
        ({"block": [FLAT]}, "'A' lies in the plane"),
        ({"dome": SMALL | {"thicknes": 1}}, "did you mean 'thickness'"),
        ({"dome": SMALL | {"oculus": 5}}, r"\[dome\]: 'oculus' must be less"),
    ],
)
def test_what_does_not_go_with_them_is_refused(tmp_path, other, words):
    with pytest.raises(mo.CaseError, match=words):
        loaded(tmp_path, **other)


KEYS = {"block": (2.0, 1.0), "thickness": 1.0, "courses": 4, "unit_weight": 1.0}


def wall(name, *axis, **keys):
    return {"name": name, "axis": axis} | keys


def plan(*walls, **keys):
    return mo.Plan(walls=walls, **KEYS | keys)


MAIN = wall("main", (0, 0), (10, 0))
CORNER = wall("L", (0, 0), (8, 0), (8, 6))
ROOM = wall("room", (0, 0), (7, 0), (7, 9), (0, 9), (0, 0))
CROSS = [wall("a", (0, 0), (10.3, 0)), wall("b", (5.2, -5.15), (5.2, 6))]
DOOR = {"at": 4, "width": 2, "height": 2}
WINDOW = {"at": 1, "width": 1.5, "height": 1, "sill": 1, "bearing": 0.5}

#: For each plan: its area, the length of its outline, and the effects of its openings. The effects are the
#: removed volume, the removed area of the foot, and the change of the outside area.
FILLED = {
    "straight": (plan(MAIN), 10, 22, ()),
    "corner": (plan(CORNER), 14, 30, ()),
    "T": (plan(MAIN, wall("stem", (5.5, 0), (5.5, 6))), 15.5, 33, ()),
    "T, butted": (plan(MAIN, wall("stem", (5.5, 0), (5.5, 6)), bond="butted"), 15.5, 33, ()),
    "X, not modular": (plan(*CROSS), 20.45, 42.9, ()),
    "room": (plan(ROOM), 32, 64, ()),
    "two rooms": (plan(ROOM, wall("spine", (0, 4), (7, 4))), 38, 74, ()),
    "at its face": (plan(MAIN, wall("stem", (3, 0.5), (3, 4))), 13.5, 29, ()),
    "two leaves": (plan(CORNER | {"leaves": 2}), 28, 32, ()),
    "headers": (plan(CORNER | {"leaves": 2}, headers=2), 28, 32, ()),
    "two leaves and one": (plan(MAIN | {"leaves": 2}, wall("stem", (5, 0), (5, 6)), headers=3), 25, 34, ()),
    # A door of 2 by 2 removes two faces and a part of the foot, and adds two jambs and a soffit.
    "door": (plan(MAIN | {"openings": [DOOR]}), 10, 22, (4, 2, -8 + 4 + 2 - 2)),
    "window": (plan(MAIN | {"openings": [WINDOW]}), 10, 22, (1.5, 0, -3 + 2 + 3)),
    "both": (plan(MAIN | {"openings": [DOOR, WINDOW]}), 10, 22, (5.5, 2, -4 + 2)),
    # One door is as far from the corner along x as the other is along y.
    "both legs": (plan(CORNER | {"openings": [DOOR | {"at": 2}, DOOR | {"at": 10}]}), 14, 30, (8, 4, -8)),
}


@pytest.mark.parametrize("name", FILLED)
def test_blocks_fill_the_walls_and_touch_wherever_they_meet(name):
    """Each face of a block is outside or in a joint with a face of another block. The area of all joints is
    therefore half of the inner faces of all blocks, plus the foot."""
    made, foot, outline, openings = FILLED[name]
    volume, of_foot, faces = openings or (0, 0, 0)
    assembly = assemble(mo.Scene(joints={"friction": 0.6}, blocks=made.blocks()))
    sizes = np.array([np.ptp(block.box, axis=1) for block in assembly.scene.in_space() if not block.fixed])
    assert np.prod(sizes, axis=1).sum() == pytest.approx(4 * foot - volume)
    surface = 2 * (sizes[:, [0, 1, 2]] * sizes[:, [1, 2, 0]]).sum()
    outside = 2 * foot + 4 * outline + faces
    assert assembly.joints.extent.sum() == pytest.approx((surface - outside) / 2 + foot - of_foot)
    assert not assembly.joints.gaps
    assert made.size >= len(sizes)


#: Length and thickness of a block, and the walls of a plan. Some walls have lengths that are multiples of
#: half a block.
BONDED = [
    (2, 1, [MAIN, wall("stem", (5.5, 0), (5.5, 6))]),
    (2, 1, CROSS),
    (2, 1, [ROOM, wall("spine", (0, 4), (7, 4))]),
    (0.8, 0.6, [CORNER]),
    (1, 0.25, [CORNER]),
    (1, 0.45, [CORNER, wall("stem", (2, 0), (2, 3))]),
    (1, 1, [CORNER, wall("stem", (2.3, 0), (2.3, 3))]),
    (1, 0.5, [MAIN | {"openings": [DOOR | {"height": 1}]}, wall("stem", (9, 0), (9, 6))]),
]


@pytest.mark.parametrize(("length", "thickness", "walls"), BONDED)
def test_no_upright_joint_goes_on_in_the_next_course(length, thickness, walls):
    made = plan(*walls, block=(length, 1.0), thickness=thickness)
    joints = assemble(mo.Scene(joints={"friction": 0.6}, blocks=made.blocks())).joints
    heads: list[set] = [set() for _ in range(4)]
    for joint, normal in enumerate(joints.normal):
        outline = joints.point[joints.joint == joint]
        if abs(normal[2]) < 0.5:
            low, high = outline.min(axis=0), outline.max(axis=0)
            axis = int(np.abs(normal).argmax())
            course = heads[round(low[2] - joints.point[:, 2].min())]
            course.add((axis, low[axis], low[1 - axis], high[1 - axis]))
    assert all(heads)
    for below, above in pairwise(heads):
        for axis, at, low, high in below:
            on = [each for each in above if each[0] == axis and abs(each[1] - at) < 1e-6]
            assert all(min(high, each[3]) - max(low, each[2]) < 1e-6 for each in on)


def test_blocks_are_as_long_as_given_but_for_pieces_at_ends_and_crossings():
    """A wall of length 10.2 has blocks of length 1. The last block of each course takes up the remainder of
    0.2."""
    made = plan(wall("w", (0, 0), (10.2, 0)), block=(1.0, 1.0), thickness=0.5)
    lengths = [round(np.ptp(block.box[0]), 9) for block in made.blocks()[:-1]]
    assert lengths[:10] == [1] * 9 + [1.2]
    assert lengths[10:21] == [0.5] + [1] * 9 + [0.7]


def test_blocks_are_named_by_wall_course_and_number_and_placed():
    made = plan(MAIN | {"openings": [DOOR]}, name="west", at=(10, 20, 30))
    blocks = {block.name: block for block in made.blocks()}
    # The lintel in the third course, from 3 to 7, has a bearing of half a block on each side of the door.
    (lintel,) = [block for block in blocks.values() if np.ptp(block.box[0]) == 4]
    assert lintel.name == "west main 3-3"
    assert lintel.box == ((13, 17), (19.5, 20.5), (32, 33))
    assert blocks["west base"].box == ((9, 21), (18.5, 21.5), (29, 30))
    assert blocks["west base"].fixed


def test_a_lower_wall_is_crossed_no_higher():
    made = plan(MAIN, wall("low", (5, 0), (5, 4), courses=2))
    names = [block.name for block in made.blocks()]
    assert [name for name in names if name.startswith("low 3")] == []
    assert {name[:4] for name in names if " 4-" in name} == {"main"}
    top = [block.box[0] for block in made.blocks() if block.name.startswith("main 4-")]
    assert all(one[1] == other[0] for one, other in pairwise(top))


NO_PLANS = [
    ([wall("w", (0, 0), (3, 1))], {}, "not parallel to x or y between point no. 1"),
    ([wall("w", (0, 0), (0, 0))], {}, "not parallel to x or y"),
    ([wall("w", (0, 0), (3, 0), (5, 0))], {}, "must turn by 90° at each point between its two ends"),
    ([wall("w", (0, 0))], {}, "axis"),
    ([MAIN, MAIN], {}, "two walls are named 'main'"),
    ([MAIN, wall("s", (0.2, 0), (0.2, 4))], {}, "'main' ends inside wall 's'"),
    ([MAIN, wall("s", (3, 0.3), (3, 4))], {}, "'s' ends inside wall 'main'"),
    ([MAIN, wall("s", (3, 0.3), (8, 0.3))], {}, "'main' and 's' overlap"),
    ([MAIN, wall("s", (10, 0), (14, 0)), wall("t", (10, 0), (10, 5))], {}, "'main' and 's' overlap"),
    ([wall("w", (0, 0), (0.3, 0))], {}, "0.3 long, less than a quarter"),
    ([MAIN | {"openings": [DOOR | {"at": 1.2}]}], {}, "course 3 would be 0.2 long"),
    ([MAIN | {"openings": [DOOR | {"at": 8}]}], {}, "opening no. 1.*beyond the wall"),
    ([MAIN | {"openings": [DOOR | {"height": 4}]}], {}, "in course 5, but the wall has 4 courses"),
    ([MAIN | {"openings": [DOOR, DOOR | {"at": 7}]}], {}, "no. 1 and no. 2 or their lintels overlap"),
    ([MAIN | {"openings": [DOOR]}, wall("s", (5, 0), (5, 4))], {}, "into a crossing wall"),
    ([MAIN], {"headers": 2}, "'leaves = 2'"),
    ([MAIN | {"leaves": 3}], {}, "leaves"),
    ([MAIN], {"block": (1e-4, 1)}, "at most 100000"),
    ([], {}, "walls"),
]


@pytest.mark.parametrize(("walls", "keys", "words"), NO_PLANS)
def test_what_no_plan_can_be_is_refused(walls, keys, words):
    with pytest.raises(mo.CaseError, match=words):
        plan(*walls, **keys)

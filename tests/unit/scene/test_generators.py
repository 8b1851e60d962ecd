"""Names, places and weights of all generators, several generators in one file, and columns and façades by
hand."""

import itertools
from operator import attrgetter

import numpy as np
import pytest
import tomli_w
from scenes import CASES

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.loads import weights

WALL = {"block": (2.0, 1.0), "courses": [[1, 1], [0.5, 1, 0.5]], "live": (1.0, 0.0)}
FACADE = {
    "openings": (1, 1), "block": (2.0, 1.0), "jamb": 2, "opening": (1, 2), "sill": 1, "spandrel": 2,
    "live": (1.0, 0.0),
}  # fmt: skip
COLUMN = {"width": (2.0, 1.0), "height": 3.0, "drums": 3, "live": (1.0, 0.0)}
ARCH = {"span": 4.0, "rise": 3.0, "thickness": 0.5, "voussoirs": 6, "unit_weight": 2.0, "live": (1.0, 0.0)}
RING = {"radius": 10.0, "angles": (180.0, 0.0), "thickness": 2.0, "voussoirs": 9, "unit_weight": 3.0}

#: For each generator, its record and keys. The weights are unit weights.
BUILT = {
    "wall": (mo.Wall, WALL | {"unit_weight": 2.0}),
    "facade": (mo.Facade, FACADE | {"unit_weight": 2.0}),
    "column": (mo.Column, COLUMN | {"unit_weight": 2.0}),
    "arch": (mo.Arch, ARCH | {"rise": 1.0, "voussoirs": 9}),
    "pointed": (mo.Arch, ARCH | {"live": (0, 0), "point_loads": [mo.PointLoad(voussoir=2, force=(0, -1))]}),
    "ring": (mo.Arch, RING),
}


def made(kind, **changes):
    record, keys = BUILT[kind]
    return record(**keys | changes)


@pytest.mark.parametrize("kind", BUILT)
def test_a_name_and_a_place_change_nothing_else(kind):
    plain, placed = made(kind).blocks(), made(kind, name="left", at=(3.0, -2.0)).blocks()
    assert [block.name for block in placed] == [f"left {block.name}" for block in plain]
    for one, other in zip(plain, placed, strict=True):
        np.testing.assert_allclose(np.array(other.vertices) - [3.0, -2.0], one.vertices, atol=1e-12)
        for at in ("weight_at", "live_at"):
            assert (getattr(one, at) is None) == (getattr(other, at) is None)
            if getattr(one, at) is not None:
                moved = np.array(getattr(other, at)) - [3, -2]
                np.testing.assert_allclose(moved, getattr(one, at), atol=1e-12)
        for key in ("unit_weight", "live", "live_per_weight", "fixed"):
            assert getattr(one, key) == getattr(other, key)


#: For each generator at (10, 5): the least and greatest x and y of its movable blocks, those of x of its
#: base, and the least y of the base.
PLACED = {
    "wall": ((10, 14), (5, 7), (8, 16), 4),
    "facade": ((10, 20), (5, 11), (8, 22), 4),
    "column": ((10, 12), (5, 8), (10, 12), 4),
}


@pytest.mark.parametrize("kind", PLACED)
def test_a_place_is_that_of_the_left_end_of_the_foot(kind):
    across, up, base, below = PLACED[kind]
    blocks = made(kind, at=(10.0, 5.0)).blocks()
    moving = np.concatenate([block.corners() for block in blocks if not block.fixed])
    (fixed,) = [block.corners() for block in blocks if block.fixed]
    assert np.column_stack([moving.min(axis=0), moving.max(axis=0)]).tolist() == [list(across), list(up)]
    assert np.column_stack([fixed.min(axis=0), fixed.max(axis=0)]).tolist() == [list(base), [below, 5]]


@pytest.mark.parametrize("kind", ["wall", "facade", "column", "ring", "pointed"])
def test_unit_weight_weighs_the_blocks_drawn(kind):
    drawn = {"weights": "straight"} if kind in ("ring", "pointed") else {}
    scene = mo.Scene(joints={"friction": 0.5}, blocks=made(kind, **drawn, live=(0.5, 0)).blocks(1.0))
    shapes, unit_weight = assemble(scene).geometry, BUILT[kind][1]["unit_weight"]
    for block in made(kind, **drawn).blocks():
        assert block.unit_weight == (None if block.fixed else unit_weight)
    for block, size, centroid in zip(scene.blocks, shapes.size, shapes.centroid, strict=True):
        if not block.fixed:
            assert block.weight == pytest.approx(unit_weight * size, rel=1e-12)
            assert block.live_per_weight == (0.5, 0.0)
        if block.weight_at is not None:
            np.testing.assert_allclose(block.weight_at, centroid + shapes.origin, atol=1e-12)


#: Generators with each kind of weight: by area, between arcs, along the centreline, and as forces.
WEIGHED = BUILT | {
    "centreline": (mo.Arch, RING | {"weights": "centreline"}),
    "pointed centreline": (mo.Arch, ARCH | {"weights": "centreline"}),
    "straight": (mo.Arch, ARCH | {"weights": "straight"}),
    "skewbacks": (mo.Arch, ARCH | {"rise": 1.0, "skewbacks": 1.0}),
    "buttress": (mo.Column, COLUMN | {"unit_weight": 2.0, "batter": "left"}),
    "wall by force": (mo.Wall, WALL | {"weight": 3.0}),
    "facade by force": (mo.Facade, FACADE | {"weight": 3.0, "lintel_weight": 5.0}),
    "column by force": (mo.Column, COLUMN | {"weight": 3.0}),
}


#: Each kind has one thickness other than 1, and one kind also the thickness 1.
THICK = [*((kind, 0.5 if number % 2 else 7.8) for number, kind in enumerate(WEIGHED)), ("straight", 1.0)]


@pytest.mark.parametrize(("kind", "thickness"), THICK)
def test_python_and_case_files_give_equal_weights(kind, thickness, tmp_path):
    """A unit weight is multiplied by the scene's thickness once, however the blocks reach the scene."""
    record, keys = WEIGHED[kind]
    generator = record(**keys)
    table = {record.__name__.lower(): generator.model_dump(exclude_defaults=True)}
    path = tmp_path / "case.toml"
    path.write_text(tomli_w.dumps({"joints": {"friction": 0.6}, "thickness": thickness} | table))
    base = 1.0 if "unit_weight" in keys else 1.0 / thickness  # forces are not multiplied
    flat = [block.weight for block in generator.blocks(thickness=1.0) if not block.fixed]

    def weights_of(scene):
        assembly = assemble(scene, floating=True)
        return weights(scene, assembly.geometry, assembly.movable)

    python = {"joints": {"friction": 0.6}, "thickness": thickness}
    scenes = [
        mo.load(path),
        mo.Scene(blocks=generator.blocks(), **python),
        mo.Scene(blocks=generator.blocks(thickness), **python),
        mo.Scene(blocks=generator.blocks(), **python | {"thickness": 1.0}).replace(thickness=thickness),
    ]
    mo.save(scenes[1], tmp_path / "saved.toml")
    for scene in (*scenes, mo.load(tmp_path / "saved.toml")):
        assert weights_of(scene) == pytest.approx(np.multiply(flat, thickness * base), rel=1e-12)


@pytest.mark.parametrize("kind", WEIGHED)
def test_blocks_at_a_thickness_have_a_force_that_no_scene_multiplies(kind):
    record, keys = WEIGHED[kind]
    per_area = "unit_weight" in keys
    for one, other in zip(record(**keys).blocks(1.0), record(**keys).blocks(thickness=0.3), strict=True):
        if not one.fixed:
            assert other.unit_weight is None
            assert other.weight == pytest.approx((0.3 if per_area else 1.0) * one.weight, rel=1e-12)


#: Kinds of generators, changes of their keys, and words of the error message.
REFUSED = [
    *(
        (kind, {"unit_weight": None}, "exactly one of the keys 'weight' and 'unit_weight'")
        for kind in ("wall", "facade", "column")
    ),
    *((kind, {"weight": 1.0}, "exactly one of the keys") for kind in ("wall", "facade", "column")),
    *((kind, {"live": (1, 0), "live_per_weight": (1, 0)}, "old name") for kind in BUILT),
    ("wall", {"course": {"H": [1]}}, "course 'H' is not used"),
    ("facade", {"doors": [2]}, "'doors' names opening 2"),
    ("facade", {"doors": [1, 1]}, "'doors'.*twice"),
    ("facade", {"doors": [0]}, "'doors"),
    ("facade", {"doors": [1], "sill": 0, "opening": (1, 3)}, "'sill'"),
    ("facade", {"jamb": 0}, "'jamb'"),
    ("facade", {"opening": (0, 1)}, "'opening"),
    ("facade", {"unit_weight": None, "weight": -1.0}, "'weight'"),
    ("facade", {"unit_weight": None, "weight": 1.0}, "needs a 'lintel_weight'"),
    ("facade", {"lintel_weight": 1.0}, "remove 'lintel_weight'"),
    ("column", {"width": 1.0, "batter": "left"}, "'batter'"),
    ("column", {"batter": "top"}, "'batter'"),
    ("column", {"width": (1.0, 0.0)}, r"'width\[1\]'"),
    ("column", {"width": 0.0}, "'width'"),
    ("column", {"drums": 0}, "'drums'"),
    ("ring", {"angles": (90.0, 90.0)}, "'angles' of an arch must differ .*found 0°"),
    ("ring", {"angles": (0.0, 360.0)}, "found 360°"),
    ("ring", {"voussoirs": 1}, "raise the number of 'voussoirs'"),
    ("ring", {"thickness": 20.0}, "'thickness'.*twice the radius"),
    (
        "ring",
        {"point_loads": [{"voussoir": 10, "force": (0.0, -1.0)}]},
        "names voussoir 10, but the voussoirs are numbered from 1 to 9",
    ),
    ("ring", {"point_loads": [{"voussoir": 2, "force": (0.0, -1.0)}] * 2}, "several loads on voussoir 2"),
    ("ring", {"skewbacks": 1.0, "angles": (200.0, 30.0)}, "feet are level"),
    ("ring", {"skewbacks": 1.0, "angles": (80.0, 30.0)}, "feet are level"),
    ("arch", {"radius": 5.0, "angles": (180.0, 0.0)}, "'radius' and 'angles', or 'span' and 'rise'"),
    ("arch", {"radius": 5.0}, "'radius' and 'angles', or 'span' and 'rise'"),
    ("arch", {"span": None}, "'radius' and 'angles', or 'span' and 'rise'"),
    ("arch", {"rise": 2.5}, "even number of 'voussoirs'"),
    ("arch", {"rise": 2.0, "voussoirs": 1}, "raise the number of 'voussoirs'"),
    ("arch", {"skewbacks": 1.0, "rise": 2.0}, "feet are level"),
    ("arch", {"skewbacks": 1.0, "rise": 3.0, "voussoirs": 8}, "feet are level"),
    ("arch", {"skewbacks": 0.39}, "at least as wide as the foot of the arch, 0.4"),
    ("arch", {"skewbacks": 0.0}, "'skewbacks'"),
]


@pytest.mark.parametrize(("kind", "changes", "words"), REFUSED)
def test_what_cannot_be_built_is_refused(kind, changes, words):
    assert made(kind).size > 0
    with pytest.raises(mo.CaseError, match=words):
        made(kind, **changes)


ON_PIERS = CASES / "examples" / "arch_on_piers.toml"


def test_a_file_may_hold_several_generators():
    """The case file lists its blocks and joints, which are counted by hand."""
    names = [block.name for block in mo.load(ON_PIERS).blocks]
    drums = {"left pier": 8, "left buttress": 4, "right pier": 8, "right buttress": 4}
    columns = [f"{name} d{number}" for name, count in drums.items() for number in range(1, count + 1)]
    assert names == ["ground", *(f"v{number}" for number in range(1, 13)), *columns]


def test_generators_that_share_names_are_told_to_take_one(tmp_path):
    path, text = tmp_path / "case.toml", ON_PIERS.read_text("utf-8")
    path.write_text(text.replace('name = "left pier"\n', "").replace('name = "right pier"\n', ""))
    with pytest.raises(mo.CaseError, match=r"both named 'd1'.*'name'"):
        mo.load(path)


def test_an_error_names_the_one_of_several(tmp_path):
    path, text = tmp_path / "case.toml", ON_PIERS.read_text("utf-8")
    path.write_text(text.replace("at = [1.8, 0]", "att = [1.8, 0]"))
    with pytest.raises(mo.CaseError, match=r"column no. 3 \('right pier'\): unknown key 'att'"):
        mo.load(path)
    path.write_text(text.replace("span = 4", "span = -4"))
    with pytest.raises(mo.CaseError, match=r"\[arch\]: key 'span'"):
        mo.load(path)


STRESSES = {
    "wall": "[wall]\nblock = [2, 1]\nunit_weight = {w}\ncourses = [[1, 1], [0.5, 1, 0.5]]\n",
    "blocks": '[[block]]\nname = "A"\nvertices = [[0, 0], [2, 0], [2, 2], [0, 2]]\nunit_weight = {w}\n'
    '[[block]]\nname = "f"\nvertices = [[-1, -1], [5, -1], [5, 0], [-1, 0]]\nfixed = true\n',
    "arch": "[arch]\nspan = 4\nrise = 1\nthickness = 1\nvoussoirs = 5\nunit_weight = {w}\nlive = [1, 0]\n",
}


@pytest.mark.parametrize("kind", STRESSES)
def test_thickness_multiplies_stresses_once(kind, tmp_path):
    """A scene of thickness t has the same forces as a scene of thickness 1 whose stresses are all multiplied
    by t."""
    t, assembled = 0.3, []
    for thickness, by in ((t, 1.0), (1.0, t)):
        text = f"thickness = {thickness}\n[joints]\nfriction = 0.6\ncohesion = {0.2 * by}\ndilatancy = 0.2\n"
        text += f"dilatancy_stress = [{0.5 * by}, {2.0 * by}]\n" + STRESSES[kind].format(w=2.0 * by)
        if kind != "arch":
            for load in (f'kind = "live"\npressure = [{3 * by}, {1 * by}]', f"force = [{0.1 * by}, 0]"):
                text += f"[[edge_load]]\nfrom = [0, 0]\nto = [0, 2]\n{load}\n"
        path = tmp_path / "case.toml"
        path.write_text(text)
        assembled.append(assemble(mo.load(path)).problem)
    one, other = assembled
    # Both problems have the same force unit, which is derived from their forces.
    assert one.force_unit == pytest.approx(other.force_unit, rel=1e-12)
    for name in ("dead", "live", "cohesion", "law.dilatancy_force", "friction"):
        own, others = map(attrgetter(name), (one, other))
        np.testing.assert_allclose(own, others, rtol=1e-12, atol=1e-14)
    assert one.cohesion.any()
    assert one.live.any()


SLENDER = {"width": 1.0, "height": 4.0, "drums": 5, "weight": 8.0}


@pytest.mark.parametrize("batter", ["left", "right", "both"])
def test_drums_share_the_weight_by_their_areas(batter):
    blocks = mo.Column(**SLENDER | {"width": (3.0, 1.0), "drums": 2, "batter": batter}).blocks()
    # The widths are 3, 2 and 1 at the heights 0, 2 and 4.
    assert [block.weight for block in blocks[:-1]] == pytest.approx([8.0 * 5 / 8, 8.0 * 3 / 8])
    left = {"left": [0, 1, 2], "right": [0, 0, 0], "both": [0, 0.5, 1]}[batter]
    assert [blocks[0].vertices[0][0], *(block.vertices[3][0] for block in blocks[:-1])] == pytest.approx(left)
    assert blocks[1].vertices[2][1] == 4.0


def test_the_base_is_as_wide_as_the_foot_and_may_be_left_out():
    blocks = mo.Column(**SLENDER).blocks()
    assert [block.name for block in blocks] == ["d1", "d2", "d3", "d4", "d5", "base"]
    assert blocks[-1].fixed
    assert blocks[-1].vertices == [(0.0, -0.8), (1.0, -0.8), (1.0, 0.0), (0.0, 0.0)]
    assert not any(block.fixed for block in mo.Column(**SLENDER, base=False).blocks())


def facade(**changed):
    return mo.Facade(**FACADE | {"weight": 3.0, "lintel_weight": 5.0, "omit_top_left": True} | changed)


def courses(built):
    """Return the blocks of each course, from the bottom, without the base."""
    rows = {}
    for block in built.blocks()[:-1]:
        rows.setdefault(int(block.name.split("-")[0]), []).append(block)
    return [rows[number] for number in sorted(rows)]


def test_jambs_are_straight_and_the_lintel_spans_the_opening():
    rows = courses(facade())
    for course in rows[1:3]:
        ends = {x for block in course for x, _ in block.vertices}
        assert {4.0, 6.0} <= ends  # the opening is the third block of length 2
        assert not any(4.0 < x < 6.0 for x in ends)
    lintel = rows[3][2]
    assert lintel.vertices == [(3.0, 3.0), (7.0, 3.0), (7.0, 4.0), (3.0, 4.0)]
    assert lintel.weight == 5.0
    assert lintel.live_per_weight == (1.0, 0.0)


def test_blocks_and_joints_are_those_counted_by_hand():
    """The façade is five blocks wide and has six courses: a sill, two courses of the opening, a lintel and
    two of the spandrel.

    The sill has 5 whole blocks. The opening has a half, a whole and a half on either side, then 2 whole ones
    on either side. The lintel has a half and a whole on either side, and it bears on half a block left and
    right. The spandrel has 5 whole blocks, then 4 and a half, because the leftmost half is omitted.
    """
    rows = courses(facade())
    assert [len(course) for course in rows] == [5, 6, 4, 5, 5, 5]
    assert len(courses(made("facade"))[-1]) == 6  # by default, no block is omitted
    within = sum(
        left.vertices[1][0] == right.vertices[0][0]
        for course in rows
        for left, right in itertools.pairwise(course)
    )
    assert within == 4 + 4 + 2 + 4 + 4 + 4  # two of these courses have a gap
    # Joints below each course: 5 on the base, and 1 + 2 + 1 on either side below the two courses after it.
    # Below the lintel's course there are 1 + 2 on either side and the lintel's two bearings. Below the first
    # spandrel course there are 2 per block, but 1 for the middle block, on the lintel alone. The last course
    # has 4 · 2 + 1.
    between = 5 + 8 + 8 + 8 + 9 + 9
    scene = mo.Scene(joints={"friction": 0.75}, blocks=facade().blocks())
    size = mo.solve(scene, "static").size
    assert (size.blocks, size.joints) == (30, within + between)


def test_a_door_reaches_the_ground():
    """A façade has two storeys of two openings each. By hand, it is twelve blocks wide, and each storey has
    eight courses, with sills of three courses.

    The door removes 2 blocks of each of these courses, with half blocks at its jambs in the shifted course.
    The window keeps its sill, and the upper storey has no door.
    """
    keys = {"openings": (2, 2), "sill": 3, "opening": (2, 2), "spandrel": 2, "omit_top_left": False}
    closed, open_ = facade(**keys), facade(**keys, doors=[2])
    assert closed.width == 12
    assert [len(course) for course in courses(closed)[:3]] == [12, 13, 12]
    # The door spans blocks 8 to 10, with 8 whole blocks on its left and 2 on its right. In the shifted
    # course, it has a half, 7 and a half on its left, and a half, 1 and a half on its right.
    assert [len(course) for course in courses(open_)[:3]] == [10, 12, 10]
    for course in courses(open_)[:5]:
        ends = {x for block in course for x, _ in block.vertices}
        assert {16.0, 20.0} <= ends
        assert not any(16.0 < x < 20.0 for x in ends)
    # The door removes the weight of 2 blocks in each of 3 courses. All other blocks are unchanged.
    without, weight = (sum(block.weight or 0 for block in one.blocks()) for one in (closed, open_))
    assert without - weight == pytest.approx(6 * 3.0)
    for below, above in zip(courses(closed)[3:], courses(open_)[3:], strict=True):
        assert [block.vertices for block in below] == [block.vertices for block in above]
    # The base carries the whole weight.
    scene = mo.Scene(joints={"friction": 0.75}, blocks=open_.blocks())
    joints = mo.solve(scene, "static").joints
    on_base = joints[(joints["first"] == "base") | (joints["second"] == "base")]
    assert len(on_base) == 10
    assert on_base["n"].sum() == pytest.approx(weight, rel=1e-7)

"""DXF drawings are read as scenes, and scenes are written as drawings."""

import itertools
import math

import numpy as np
import pytest
from sheets import FLOOR, STONE, polylines, read
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.scene.geometry import geometry


def movable(scene):
    return [block for block in scene.blocks if not block.fixed]


def area_of(scene, number=0):
    return geometry(scene).size[scene.blocks.index(movable(scene)[number])]


@pytest.mark.parametrize("version", ["R2000", "R2010", "R2018"])
def test_outlines_are_blocks_and_layers_say_what_is_fixed(sheet, version):
    """The outline of the stone is drawn clockwise and repeats a corner."""
    scene = read(sheet(polylines([*STONE[::-1], STONE[-1]]), version=version))
    assert [block.fixed for block in scene.blocks] == [True, False]
    (stone,) = movable(scene)
    assert sorted(stone.vertices) == sorted(STONE)
    # The stone is 4 wide and 1 high, so it slides, at λ = μ, before it overturns.
    assert mo.solve(scene, "static").required() == pytest.approx(0.5, rel=1e-6)


def chords(sagitta, radius, angle):
    """Return the number of equal chords of an arc whose rise, r (1 - cos(half a chord's angle)), is at most
    the sagitta."""
    return math.ceil(angle / (2 * math.acos(1 - sagitta / radius)))


#: Area of half a disc of radius 1 in twelve chords, for a sagitta of 0.01: triangles between the centre and
#: the chords.
HALF_DISC = 6 * math.sin(math.pi / 12)


@pytest.mark.parametrize(("bulge", "sign"), [(1.0, 1), (-1.0, -1)])
def test_arcs_are_flattened_with_the_sagitta(sheet, bulge, sign):
    """Half a disc is added to the top of a stone, or cut out of it."""

    def make(space):
        corners = [(0, 0, 0), (4, 0, 0), (4, 2, 0), (3, 2, bulge), (1, 2, 0), (0, 2, 0)]
        space.add_lwpolyline(corners, format="xyb", close=True)

    scene = read(sheet(make), sagitta=0.01)
    assert chords(0.01, 1.0, math.pi) == 12
    assert area_of(scene) == pytest.approx(8 + sign * HALF_DISC, rel=1e-12)
    on_arc = [point for point in movable(scene)[0].vertices if 1.0001 < point[0] < 2.9999]
    assert [math.dist(point, (2, 2)) for point in on_arc] == pytest.approx([1.0] * 11, rel=1e-12)


def test_loops_of_lines_and_arcs_are_outlines(sheet):
    """The outlines are half a disc drawn with an arc, a whole circle, and loops of lines, arcs and open
    polylines."""

    def make(space):
        corners = [(1, 2), (0, 2), (0, 0), (4, 0), (4, 2), (3, 2)]
        for a, b in itertools.pairwise(corners[:4]):
            space.add_line(b, a)
        space.add_lwpolyline(corners[3:])
        space.add_arc((2, 2), 1, 0, 180)
        space.add_circle((7, 3), 1)
        space.add_line((5, 0), (8, 0), dxfattribs={"layer": "other"})
        space.add_arc((6.5, 0), 1.5, 0, 180, dxfattribs={"layer": "other"})

    scene = read(sheet(make), sagitta=0.01)
    assert area_of(scene, 0) == pytest.approx(8 + HALF_DISC, rel=1e-12)
    assert area_of(scene, 1) == pytest.approx(2 * HALF_DISC, rel=1e-12)
    number = chords(0.01, 1.5, math.pi)
    assert area_of(scene, 2) == pytest.approx(1.5**2 * number / 2 * math.sin(math.pi / number), rel=1e-12)


def test_mirrored_entities_are_seen_from_above(sheet):
    """The x axis of a mirrored entity points to the left, and its arcs turn the other way."""

    def make(space):
        corners = [(0, 0, 0), (4, 0, 0), (4, 2, 0), (3, 2, 1.0), (1, 2, 0), (0, 2, 0)]
        mirrored = [(-x, y, -bulge) for x, y, bulge in corners]
        space.add_lwpolyline(mirrored, format="xyb", close=True, dxfattribs={"extrusion": (0, 0, -1)})
        space.add_lwpolyline([(7, 0), (5, 0)], dxfattribs={"layer": "other"})
        # The arc runs from (7, 0) counter-clockwise over the top to (5, 0), in a plane seen from below.
        arc = {"layer": "other", "extrusion": (0, 0, -1)}
        space.add_arc((-6, 0), 1, 0, 180, dxfattribs=arc)

    scene = read(sheet(make), sagitta=0.01)
    assert area_of(scene, 0) == pytest.approx(8 + HALF_DISC, rel=1e-12)
    assert area_of(scene, 1) == pytest.approx(HALF_DISC, rel=1e-12)
    assert max(y for _, y in movable(scene)[1].vertices) == pytest.approx(1.0)


def arch(space, curve):
    """Draw voussoirs between two ellipses, and the lines between the voussoirs. ``curve`` draws an ellipse
    from one parameter to another."""
    ends = np.linspace(0, math.pi, 6)
    for number, (start, end) in enumerate(itertools.pairwise(ends)):
        layer = {"layer": f"stone {number}"}
        for size in (2.0, 3.0):
            curve(space, size, start, end, layer)
        for at in (start, end):
            line = [(size * math.cos(at), size / 2 * math.sin(at)) for size in (2.0, 3.0)]
            space.add_line(*line, dxfattribs=layer)


def by_ellipse(space, size, start, end, layer):
    space.add_ellipse((0, 0), (size, 0), 0.5, start, end, dxfattribs=layer)


def by_spline(space, size, start, end, layer):
    """Draw a rational spline of degree 2, which is exactly the same piece of the ellipse."""
    middle, half = (start + end) / 2, (end - start) / 2
    corners = [(start, 1.0), (middle, 1 / math.cos(half)), (end, 1.0)]
    points = [(size * far * math.cos(at), size / 2 * far * math.sin(at)) for at, far in corners]
    space.add_rational_spline(points, [1, math.cos(half), 1], degree=2, dxfattribs=layer)


@pytest.mark.parametrize("curve", [by_ellipse, by_spline])
def test_an_arch_of_ellipses_and_splines(sheet, curve):
    """In an ellipse with half axes a and a/2, the sector between two parameters has the area a²/4 (t1 -
    t0)."""
    sagitta = 1e-4
    scene = read(sheet(lambda space: arch(space, curve)), sagitta=sagitta)
    found = [area_of(scene, number) for number in range(5)]
    exact = (9 - 4) / 4 * math.pi / 5
    # A curve of length up to 3 π/5 loses or gains an area of up to the sagitta times its length.
    assert found == pytest.approx([exact] * 5, abs=sagitta * 3 * math.pi / 5)
    assert found != pytest.approx([exact] * 5, abs=1e-3 * sagitta)
    # The joints between voussoirs are as long as the lines between them. The springers are on the floor.
    extent = contacts_of(scene).extent
    lines = [math.hypot(math.cos(at), math.sin(at) / 2) for at in np.linspace(0, math.pi, 6)]
    assert sorted(extent) == pytest.approx(sorted(lines))


def test_closed_ellipses_and_splines_are_outlines(sheet):
    """An ellipse has the area π a b. The last outline is a mirrored half of an ellipse, closed by a line."""

    def make(space):
        space.add_ellipse((0, 2), (2, 0), 0.5)
        drop = [(10, 0), (12, 0), (12, 2), (10, 0)]
        space.add_open_spline(drop, degree=2, dxfattribs={"layer": "spline"})
        mirrored = {"layer": "half", "extrusion": (0, 0, -1)}
        space.add_ellipse((20, 0), (2, 0), 0.5, 0, math.pi, dxfattribs=mirrored)
        space.add_line((18, 0), (22, 0), dxfattribs={"layer": "half"})

    scene = read(sheet(make), sagitta=1e-5)
    # The drop is two parabolas that meet at (12, 1), each with 2/3 of the area of its triangle of control
    # points, 1.
    expected = [2 * math.pi, 4 / 3, math.pi]
    assert [area_of(scene, number) for number in range(3)] == pytest.approx(expected, abs=1e-5 * 10)
    assert min(y for _, y in movable(scene)[2].vertices) == pytest.approx(-1)


def test_a_curved_joint_is_the_same_from_both_sides(sheet):
    """Two stones, one drawn clockwise and the other counter-clockwise, share the chords of the arc between
    them."""

    def make(space):
        space.add_lwpolyline([(0, 0, 0), (2, 0, 0.3), (2, 2, 0), (0, 2, 0)], format="xyb", close=True)
        space.add_lwpolyline([(5, 0, 0), (2, 0, 0.3), (2, 2, 0), (5, 2, 0)], format="xyb", close=True)

    scene = read(sheet(make), sagitta=1e-3)
    angle = 4 * math.atan(0.3)
    number = chords(1e-3, 1 / math.sin(angle / 2), angle)  # the arc has a chord of 2
    joints = contacts_of(scene)
    between = (joints.first != 0) & (joints.second != 0) & (joints.extent > 0)
    assert between.sum() == number > 5


def test_gaps_within_the_tolerance_are_closed(sheet):
    def make(space):
        space.add_lwpolyline([*STONE, (0, 0.001)])  # the polyline is not closed
        ring = [(0.5, 1.001), (3, 1.001), (3, 2), (0.5, 2)]
        for a, b in zip(ring, [*ring[1:], ring[0]], strict=True):
            space.add_line((a[0] + 0.001, a[1]), b, dxfattribs={"layer": "upper"})

    path = sheet(make)
    scene = read(path, tolerance=0.002)
    assert scene.tolerance == 0.002
    assert len(movable(scene)) == 2
    assert len(contacts_of(scene).extent) == 2
    with pytest.raises(mo.CaseError, match=r"5 outlines are open \(LWPOLYLINE \w+ on layer '0' .* 0\.001 "):
        read(path)


@pytest.mark.parametrize(
    ("loose", "tolerances"),
    [
        (0, {"tolerance": 0.0025}),
        (0, {"tolerance": 0.0025, "outline_tolerance": 1e-4}),
        (0.0005, {"tolerance": 0.0025, "outline_tolerance": 0.001}),
    ],
)
def test_stones_of_loose_lines_may_stand_nearer_than_the_tolerance(sheet, loose, tolerances):
    """Two stones of 1 × 1 are on one layer, 2 mm apart. Each consists of four lines that end short of its
    corners.

    Both beds end at the joint between the stones, in the middle of the gap, at x = 1.001.
    """

    def make(space):
        for x in (0, 1.002):
            ring = np.array([(x, 0), (x + 1, 0), (x + 1, 1), (x, 1)], dtype=float)
            for a, b in itertools.pairwise([*ring, ring[0]]):
                space.add_line(a, b - loose * (b - a))

    path = sheet(make)
    scene = read(path, **tolerances)
    assert scene.tolerance == 0.0025
    assert [area_of(scene, number) for number in (0, 1)] == pytest.approx([1, 1], abs=2 * loose + 1e-12)
    lengths = [1, 1.001, 1.001]
    assert sorted(contacts_of(scene).extent) == pytest.approx(lengths, abs=2 * loose + 2e-6)
    # Without an outline tolerance, the ends of both stones are within the tolerance, and nothing is guessed.
    if loose:
        with pytest.raises(mo.CaseError, match=r"ends of curves touch .* \(LINE \w+ on layer '0'"):
            read(path, tolerance=0.0025)


def test_holes_and_what_stands_in_them(sheet):
    """An outline inside another is a hole, an outline inside the hole is a block, and so on. A hole drawn
    twice is filled."""
    rings = [
        [(0, 0), (10, 0), (10, 10), (0, 10)],
        [(1, 1), (9, 1), (9, 9), (1, 9)],
        [(2, 1), (4, 1), (4, 3), (2, 3)],
        [(2.5, 1.5), (3.5, 1.5), (3.5, 2.5), (2.5, 2.5)],
        [(20, 0), (30, 0), (30, 9), (20, 9)],
        [(21, 1), (22, 1), (22, 2), (21, 2)],
        [(22, 2), (21, 2), (21, 1), (22, 1)],
    ]
    ground = [(-9, -1), (40, -1), (40, 0), (-9, 0)]

    def make(space):
        polylines(*rings)(space)
        polylines(ground, layer="fixed")(space)

    scene = read(sheet(make, floor=False))
    areas = [area_of(scene, number) for number in range(4)]
    assert areas == pytest.approx([100 - 64, 4 - 1, 90 - 1, 1])
    assert movable(scene)[0].live_per_weight == (1.0, 0.0)
    # Two stones are on the ground, one stone is in a hole, and the filling has four sides.
    assert len(contacts_of(scene).extent) == 2 + 1 + 4


def test_texts_name_blocks(sheet):
    """A text names a block if it is inside the block and no other block has it. Otherwise, the name is the
    layer and handle."""

    def make(space):
        polylines(STONE, [(0, 1), (4, 1), (4, 2), (0, 2)], [(0, 2), (4, 2), (4, 3), (0, 3)])(space)
        space.add_text("key  stone", height=0.1).set_placement((1, 0.5))
        space.add_mtext("granite", dxfattribs={"layer": "notes"}).set_location((1, 1.5))
        space.add_text("granite", height=0.1).set_placement((1, 2.5))
        space.add_text("outside", height=0.1).set_placement((20, 20))

    names = [block.name for block in movable(read(sheet(make)))]
    assert names[0] == "key stone"
    assert all(name.startswith("stone-") for name in names[1:])
    assert len(set(names)) == 3


def test_layers_that_are_read(sheet):
    """If layers are named, curves on other layers are ignored. Curves on layers that are off or frozen are
    always ignored."""

    def make(space):
        polylines(STONE)(space)
        space.add_spline([(0, 0), (1, 1), (2, 0)], dxfattribs={"layer": "frame"})
        space.add_line((0, 0), (1, 1), dxfattribs={"layer": "off"})
        layers = space.doc.layers
        layers.add("off").off()
        layers.add("frozen").freeze()
        space.add_line((0, 0), (1, 1), dxfattribs={"layer": "Frozen"})

    path = sheet(make)
    assert len(read(path, layers=["STONE", "supports"]).blocks) == 2
    with pytest.raises(mo.CaseError, match=r"SPLINE \w+ on layer 'frame'"):
        read(path)
    with pytest.raises(mo.CaseError, match="'gone'"):
        read(path, layers=["gone", "stone"])
    turned = read(path, layers=["STONE", "supports"], fixed_layers=["ston"])
    assert [block.fixed for block in turned.blocks] == [False, True]


def test_units_are_scaled_only_if_asked_for(sheet):
    def make(space):
        polylines(STONE)(space)
        space.add_text("A", height=0.1).set_placement((1, 0.5))

    path = sheet(make, INSUNITS=4)
    assert max(read(path).blocks[1].vertices) == (4.0, 1.0)
    in_metres = read(path, to_metres=True).blocks[1]
    assert max(in_metres.vertices) == pytest.approx((0.004, 0.001))
    assert in_metres.name == "A"
    with pytest.raises(mo.CaseError, match="INSUNITS"):
        read(sheet(make, INSUNITS=0), to_metres=True)


def test_stones_of_any_shape_come_back(tmp_path):
    """The stones have a notch, a hole that another block fills, two parts that touch, and names with unusual
    characters."""
    hole, around = [(1, 1), (2, 1), (2, 2), (1, 2)], [(0, 0), (4, 0), (4, 3), (0, 3)]
    notched = [[(4, 0), (6, 0), (6, 1), (4, 1)], [(4, 1), (5, 1), (5, 3), (4, 3)]]
    scene = mo.Scene(
        joints={"friction": 0.5},
        blocks=[
            mo.Block(name="100 %%d", vertices=hole, unit_weight=2),
            mo.Block(name="Füllung ½", vertices=around, holes=[hole], unit_weight=2),
            mo.Block(name="L", parts=notched, unit_weight=2),
            mo.Block(name="floor", vertices=FLOOR, fixed=True),
        ],
    )
    mo.write_dxf(scene, tmp_path / "stones.dxf")
    back = read(tmp_path / "stones.dxf")
    before, after = geometry(scene), geometry(back)
    area = dict(zip([block.name for block in back.blocks], after.size, strict=True))
    assert area == pytest.approx({"100 %%d": 1, "Füllung ½": 11, "L": 4, "floor": 18})
    assert before.size.sum() == pytest.approx(after.size.sum())
    assert [block.name for block in back.blocks if block.fixed] == ["floor"]
    assert len(contacts_of(back).extent) == len(contacts_of(scene).extent)


@pytest.mark.parametrize("degrees", [200.0, 300.0, 360.0])
def test_long_arcs_keep_their_side(sheet, degrees):
    """The segment of a circle has the area r²/2 (θ - sin θ). Chords reduce it by up to the sagitta times
    their length."""

    def make(space):
        ends = [(math.cos(math.radians(a)), 3 + math.sin(math.radians(a))) for a in (0, degrees)]
        space.add_arc((0, 3), 1, 0, degrees)
        if degrees < 360:
            space.add_line(*ends)

    angle = math.radians(degrees)
    whole = (angle - math.sin(angle)) / 2
    assert whole - 1e-4 * angle < area_of(read(sheet(make), sagitta=1e-4)) < whole

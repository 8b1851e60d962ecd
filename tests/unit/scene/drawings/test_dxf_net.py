"""Drawings of nets of joint lines, whose cells are the stones, and errors of drawings and scenes."""

import math
import re
from itertools import pairwise

import numpy as np
import pytest
import shapely
from scenes import WALLS
from scenes_in_space import box_on_floor
from sheets import FLOOR, STONE, polylines, read

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.walls import Facade

FACADE = Facade(
    openings=(1, 2), block=(0.5, 0.25), jamb=2, opening=(2, 4), sill=1, spandrel=2, unit_weight=2.0
).blocks()


def long_lines(polygons):
    """Yield straight lines along all sides of polygons, merged to their greatest length."""
    sides = shapely.union_all([polygon.boundary for polygon in polygons])
    for axis in (0, 1):
        runs = {}
        for part in shapely.get_parts(sides):
            ends = shapely.get_coordinates(part)
            for one, other in pairwise(ends):
                if one[1 - axis] == other[1 - axis]:
                    runs.setdefault(one[1 - axis], []).append(shapely.LineString([one, other]))
        for at in runs.values():
            for line in shapely.get_parts(shapely.line_merge(shapely.union_all(at))):
                yield shapely.get_coordinates(line)[[0, -1]]


def facade(change=lambda line: line, windows="window"):
    """Return a function that draws a façade: its joints as lines, and its openings and its base as
    outlines."""
    stones = [shapely.Polygon(block.vertices) for block in FACADE if not block.fixed]
    holes = [list(ring.coords)[:-1] for ring in shapely.union_all(stones).interiors]

    def make(space):
        for line in long_lines(stones):
            space.add_line(*change(line), dxfattribs={"layer": "joints"})
        polylines(*holes, layer=windows)(space)
        polylines(FACADE[-1].vertices, layer="fixed")(space)

    return make


def outlines(scene):
    return sorted(shapely.normalize(shapely.Polygon(block.vertices)).wkt for block in scene.blocks)


def test_a_facade_is_that_of_closed_outlines(sheet):
    rings = [block.vertices for block in FACADE if not block.fixed]

    def whole(space):
        polylines(*rings)(space)
        polylines(FACADE[-1].vertices, layer="fixed")(space)

    drawn, net = read(sheet(whole, floor=False)), read(sheet(facade(), floor=False), net=True)
    assert outlines(net) == outlines(drawn)
    joints = [assemble(scene).joints for scene in (drawn, net)]
    np.testing.assert_array_equal(*(np.sort(found.extent) for found in joints))
    one, other = (mo.solve(scene, "static").load_factor for scene in (drawn, net))
    assert other == pytest.approx(one, rel=1e-9)


def test_openings_are_blocks_but_for_their_layer(sheet):
    path = sheet(facade(windows="panes"), floor=False)
    assert len(read(path, net=True).blocks) == len(FACADE) + 2
    assert len(read(path, net=True, window_layers=["Pane"]).blocks) == len(FACADE)
    with pytest.raises(mo.CaseError, match="outlines are open"):
        read(path)


def test_lines_of_windows_that_enclose_none_are_no_stone_in_silence(sheet):
    """Jambs and a lintel, as doors are often drawn, enclose no cell and raise an error. So do layers of
    windows in a drawing that is not a net."""

    def make(space):
        facade(lambda line: line, "panes")(space)
        space.add_lwpolyline([(1, 0), (1, 0.2), (1.2, 0.2), (1.2, 0)], dxfattribs={"layer": "Doors"})

    path = sheet(make, floor=False)
    with pytest.raises(mo.CaseError, match=r"LWPOLYLINE \w+ on layer 'Doors' is not part of a closed"):
        read(path, net=True)
    with pytest.raises(mo.OptionError, match=r"'window_layers' \(--window-layer\) .*--net"):
        read(path, window_layers=["Doors"])


@pytest.mark.parametrize("off", [-0.004, 0.004])
def test_lines_that_miss_each_other_by_a_little(sheet, off):
    """Lines that are too short or too long at both ends need an outline tolerance."""

    def change(line):
        way = line[1] - line[0]
        return line + off * np.array([-way, way]) / np.hypot(*way)

    path = sheet(facade(change), floor=False)
    assert len(read(path, net=True, outline_tolerance=0.01).blocks) == len(FACADE)
    missed = r"lines end inside a block \(LINE \w+ on .*: set 'outline_tolerance' .* to ([\d.]+) to close"
    with pytest.raises(mo.CaseError, match=missed) as refused:
        read(path, net=True)
    advised = float(re.search(missed, str(refused.value))[1])
    # Two short lines that should meet at a corner of the façade are √2 times as far apart.
    assert advised == pytest.approx(abs(off) * (math.sqrt(2) if off < 0 else 1), rel=0.01)
    assert len(read(path, net=True, outline_tolerance=advised).blocks) == len(FACADE)


def test_a_line_that_ends_far_from_others_needs_no_tolerance(sheet):
    """No tolerance is advised for a joint that ends in the middle of a block."""

    def make(space):
        facade()(space)
        space.add_line((-1, 0.6), (0.25, 0.75), dxfattribs={"layer": "joints"})

    with pytest.raises(mo.CaseError, match=r"ends inside a block .*: extend the line, or use") as refused:
        read(sheet(make, floor=False), net=True)
    assert "outline_tolerance" not in str(refused.value)


def test_layers_are_left_out(sheet):
    def make(space):
        facade()(space)
        space.add_line((-1, 0.6), (0.7, 0.7), dxfattribs={"layer": "Cracks"})

    path = sheet(make, floor=False)
    with pytest.raises(mo.CaseError, match=r"'Cracks' ends inside a block .*'without_layers'"):
        read(path, net=True)
    assert len(read(path, net=True, without_layers=["cracks"]).blocks) == len(FACADE)
    unknown = r"'without_layers' \(--without-layer\): layer 'crack' is empty or does not exist"
    with pytest.raises(mo.CaseError, match=unknown):
        read(path, net=True, without_layers=["crack"])


def test_voussoirs_between_arcs_and_radial_lines(sheet):
    count = 9

    def make(space):
        space.add_arc((0, 0), 5, 0, 180)
        space.add_arc((0, 0), 4, 0, 180, dxfattribs={"layer": "Openings"})
        space.add_line((-4, 0), (4, 0), dxfattribs={"layer": "Openings"})
        for angle in np.linspace(0, math.pi, count + 1):
            way = np.array([math.cos(angle), math.sin(angle)])
            space.add_line(4 * way, 5 * way)
        space.add_text("key", height=0.1).set_placement((0.1, 4.4))

    blocks = [block for block in read(sheet(make), net=True, live=(0, 0)).blocks if not block.fixed]
    assert len(blocks) == count
    areas = [shapely.Polygon(block.vertices).area for block in blocks]
    assert areas == pytest.approx([math.pi * 9 / 2 / count] * count, rel=5e-3)
    assert {"key", "0-1", "0-2"} < {block.name for block in blocks}


def test_a_stone_in_a_stone_fills_a_hole(sheet):
    around = [(0, 0), (4, 0), (4, 3), (0, 3)]
    inner = [(1, 1), (2, 1), (2, 2), (1, 2)]
    scene = read(sheet(polylines(around, inner)), net=True)
    stones = {len(block.holes): block for block in scene.blocks if not block.fixed}
    assert sorted(stones) == [0, 1]
    assert len(assemble(scene).joints.first) == 5


ON = {"layer": "stone"}
UPRIGHT = {"layer": "stone", "extrusion": (0, 1, 0)}
#: Lines of two triangles with a common side.
NET = [((0, 0), (1, 0)), ((1, 0), (1, 1)), ((1, 1), (0, 0)), ((1, 0), (2, 0)), ((2, 0), (1, 1))]
#: Control points of a periodic spline.
RING = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]

WRONG = {
    "crosses itself": polylines([(0, 0), (4, 0), (0, 1), (4, 1)]),
    "no area": polylines([(0, 0), (4, 0), (2, 0)]),
    "open": lambda space: space.add_lwpolyline(STONE, dxfattribs=ON),
    "a lone line": lambda space: space.add_line((0, 0), (1, 0), dxfattribs=ON),
    "a point": lambda space: space.add_line((1, 1), (1, 1), dxfattribs=ON),
    "a net": lambda space: [space.add_line(a, b, dxfattribs=ON) for a, b in NET],
    "a reference": lambda space: space.add_blockref("stones", (0, 0), dxfattribs=ON),
    "an upright ellipse": lambda space: space.add_ellipse((0, 2), (1, 0, 0), 0.5, dxfattribs=UPRIGHT),
    "a spline without points": lambda space: space.add_spline(dxfattribs=ON),
    "a periodic spline": lambda space: space.add_spline(dxfattribs=ON).set_closed(RING),
    "a filled area": lambda space: space.add_solid(STONE, dxfattribs=ON),
    "upright": lambda space: space.add_lwpolyline(STONE, close=True, dxfattribs=UPRIGHT),
    "in space": lambda space: space.add_polyline3d([*RING[:2], (1, 0, 1)], close=True, dxfattribs=ON),
    "a mesh": lambda space: space.add_polymesh((3, 3), dxfattribs=ON),
}


@pytest.mark.parametrize("make", WRONG.values(), ids=WRONG)
def test_what_is_no_block_is_named_by_layer_and_handle(sheet, make):
    with pytest.raises(mo.CaseError, match=r"sheet\.dxf: (2 ends .*\()?[A-Z]+ [0-9A-F]+ on layer 'stone'"):
        read(sheet(make))


def test_drawings_without_blocks_or_supports(sheet):
    with pytest.raises(mo.CaseError, match=r"sheet\.dxf: "):
        read(sheet(lambda space: space.add_text("A"), floor=False))
    with pytest.raises(mo.CaseError, match=r"sheet\.dxf: .*stone"):
        read(sheet(polylines(STONE), floor=False))


WRONG_VALUES = {
    "friction": -1,
    "unit_weight": "heavy",
    "live": (1,),
    "tolerance": 0,
    "sagitta": -1,
    "layers": [],
}


@pytest.mark.parametrize("key", WRONG_VALUES)
def test_wrong_values_are_named(sheet, key):
    with pytest.raises(mo.CaseError, match=f"'{key}'"):
        read(sheet(polylines(STONE)), **{key: WRONG_VALUES[key]})


@pytest.mark.parametrize(
    "make",
    [
        lambda space: space.add_circle((0, 1), 1),
        lambda space: space.add_lwpolyline([(0, 0, 1), (1, 0, 0)], format="xyb", close=True),
        lambda space: space.add_ellipse((0, 1), (1, 0), 0.5),
        lambda space: space.add_spline([(0, 0), (1, 1), (2, 0), (0, 0)]),
    ],
)
def test_a_sagitta_too_small_is_refused(sheet, make):
    with pytest.raises(mo.CaseError, match=r"[A-Z]+ \w+ on layer '0'.* 4000 chords.*sagitta"):
        read(sheet(make), sagitta=1e-12)


def test_files_that_are_no_dxf(sheet, tmp_path):
    path = sheet(polylines(STONE))
    without_model_space = path.read_bytes().replace(b"\nModel\n", b"\nOther\n")
    of_binary = b"AutoCAD Binary DXF\r\n"
    for content in (b"", b"\x00\xff" * 500, b"0\nSECTION\n2\nENTITIES\n", of_binary, without_model_space):
        path.write_bytes(content)
        with pytest.raises(mo.CaseError, match=r"sheet\.dxf: the file is not valid DXF"):
            read(path)


def test_paths_that_are_no_dxf(tmp_path):
    (tmp_path / "folder.dxf").mkdir()
    for path in (tmp_path / "folder.dxf", tmp_path / "missing.dxf", tmp_path / "wall.dwg", 5):
        with pytest.raises(mo.CaseError):
            read(path)


def test_without_ezdxf_the_extra_is_named(sheet, without):
    path = sheet(polylines(STONE))
    without("ezdxf")
    with pytest.raises(mo.OptionError, match=r"\.\[drawings\]"):
        read(path)


def test_what_cannot_be_drawn_is_refused(tmp_path):
    apart = mo.Block(name="apart", parts=[STONE, [(5, 0), (6, 0), (6, 1)]], weight=1)
    floor = mo.Block(name="floor", vertices=FLOOR, fixed=True)
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[apart, floor])
    wall = mo.load(WALLS[0])
    for drawn, name, error, named in (
        (scene, "apart.dxf", mo.CaseError, "'apart'"),
        ("wall", "wall.dxf", mo.CaseError, None),
        (wall, "wall.dwg", mo.CaseError, None),
        (wall, "gone/wall.dxf", mo.MasonryError, "gone"),
        (box_on_floor(), "solids.dxf", mo.OptionError, "solids"),
    ):
        with pytest.raises(error, match=named):
            mo.write_dxf(drawn, tmp_path / name)
    assert not list(tmp_path.iterdir())

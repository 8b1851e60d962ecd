"""DXF drawings that make no scene, and scenes that make no drawing: what is named."""

import sys

import pytest
from scenes import WALLS
from sheets import FLOOR, STONE, polylines, read

import masonry_opt as mo

WRONG = {
    "crosses itself": polylines([(0, 0), (4, 0), (0, 1), (4, 1)]),
    "no area": polylines([(0, 0), (4, 0), (2, 0)]),
    "twice": polylines(STONE, STONE),
    "open": lambda space: space.add_lwpolyline(STONE, dxfattribs={"layer": "stone"}),
    "a lone line": lambda space: space.add_line((0, 0), (1, 0), dxfattribs={"layer": "stone"}),
    "a point": lambda space: space.add_line((1, 1), (1, 1), dxfattribs={"layer": "stone"}),
    "a net": lambda space: [
        space.add_line(a, b, dxfattribs={"layer": "stone"})
        for a, b in [((0, 0), (1, 0)), ((1, 0), (1, 1)), ((1, 1), (0, 0)), ((1, 0), (2, 0)), ((2, 0), (1, 1))]
    ],
    "a reference": lambda space: space.add_blockref("stones", (0, 0), dxfattribs={"layer": "stone"}),
    "an ellipse out of the plane": lambda space: space.add_ellipse(
        (0, 2), (1, 0, 0), 0.5, dxfattribs={"layer": "stone", "extrusion": (0, 1, 0)}
    ),
    "a spline without points": lambda space: space.add_spline(dxfattribs={"layer": "stone"}),
    "a periodic spline": lambda space: space.add_spline(dxfattribs={"layer": "stone"}).set_closed(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    ),
    "a filled area": lambda space: space.add_solid(STONE, dxfattribs={"layer": "stone"}),
    "upright": lambda space: space.add_lwpolyline(
        STONE, close=True, dxfattribs={"layer": "stone", "extrusion": (0, 1, 0)}
    ),
    "in space": lambda space: space.add_polyline3d(
        [(0, 0, 0), (1, 0, 0), (1, 0, 1)], close=True, dxfattribs={"layer": "stone"}
    ),
    "a mesh": lambda space: space.add_polymesh((3, 3), dxfattribs={"layer": "stone"}),
}


@pytest.mark.parametrize("make", WRONG.values(), ids=WRONG)
def test_what_is_no_block_is_named_by_layer_and_handle(sheet, make):
    with pytest.raises(mo.CaseError, match=r"sheet\.dxf: [A-Z]+ [0-9A-F]+ on layer 'stone'"):
        read(sheet(make))


def test_drawings_without_blocks_or_supports(sheet):
    with pytest.raises(mo.CaseError, match=r"sheet\.dxf: "):
        read(sheet(lambda space: space.add_text("A"), floor=False))
    with pytest.raises(mo.CaseError, match=r"sheet\.dxf: .*stone"):
        read(sheet(polylines(STONE), floor=False))


@pytest.mark.parametrize(
    "wrong",
    [
        {"friction": -1},
        {"unit_weight": "heavy"},
        {"live": (1,)},
        {"tolerance": 0},
        {"sagitta": -1},
        {"layers": []},
    ],
)
def test_wrong_values_are_named(sheet, wrong):
    with pytest.raises(mo.CaseError, match=f"'{next(iter(wrong))}'"):
        read(sheet(polylines(STONE)), **wrong)


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


@pytest.mark.parametrize(
    "content", [b"", b"\x00\xff" * 500, b"0\nSECTION\n2\nENTITIES\n", b"AutoCAD Binary DXF\r\n"]
)
def test_files_that_are_no_dxf(tmp_path, content):
    path = tmp_path / "broken.dxf"
    path.write_bytes(content)
    with pytest.raises(mo.CaseError, match=r"broken\.dxf: "):
        read(path)


def test_a_drawing_without_a_model_space(sheet):
    path = sheet(polylines(STONE))
    path.write_bytes(path.read_bytes().replace(b"\nModel\n", b"\nOther\n"))
    with pytest.raises(mo.CaseError, match=r"sheet\.dxf: not valid DXF"):
        read(path)


def test_paths_that_are_no_dxf(tmp_path):
    (tmp_path / "folder.dxf").mkdir()
    for path in (tmp_path / "folder.dxf", tmp_path / "missing.dxf", tmp_path / "wall.dwg", 5):
        with pytest.raises(mo.CaseError):
            read(path)


def test_without_ezdxf_the_extra_is_named(sheet, monkeypatch):
    path = sheet(polylines(STONE))
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    with pytest.raises(mo.OptionError, match=r"\.\[drawings\]"):
        read(path)


def test_what_cannot_be_drawn_is_refused(tmp_path):
    apart = mo.Block(name="apart", parts=[STONE, [(5, 0), (6, 0), (6, 1)]], weight=1)
    floor = mo.Block(name="floor", vertices=FLOOR, fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=[apart, floor])
    with pytest.raises(mo.CaseError, match="'apart'"):
        mo.write_dxf(scene, tmp_path / "apart.dxf")
    with pytest.raises(mo.CaseError):
        mo.write_dxf("wall", tmp_path / "wall.dxf")
    wall = mo.load(WALLS[0])
    with pytest.raises(mo.CaseError):
        mo.write_dxf(wall, tmp_path / "wall.dwg")
    with pytest.raises(mo.MasonryError, match=r"gone"):
        mo.write_dxf(wall, tmp_path / "gone" / "wall.dxf")
    assert not list(tmp_path.iterdir())

"""References to block definitions in DXF drawings: the entities that they place are read as if drawn."""

import math

import ezdxf
import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.scene.drawings import block_references

GIVEN = {"friction": 0.7, "unit_weight": 20.0, "live": (1, 0)}
FLOOR = [(-1, -1), (9, -1), (9, 0), (-1, 0)]
BRICK = [(0, 0), (2, 0), (2, 1), (0, 1)]


def document_with(**definitions):
    """Return a drawing with a floor, and with a block definition for each name and its outlines by layer."""
    document = ezdxf.new()
    document.modelspace().add_lwpolyline(FLOOR, close=True, dxfattribs={"layer": "fixed"})
    for name, outlines in definitions.items():
        definition = document.blocks.new(name)
        for layer, ring in outlines:
            definition.add_lwpolyline(ring, close=True, dxfattribs={"layer": layer})
    return document


def read(document, tmp_path, **options):
    path = tmp_path / "a.dxf"
    document.saveas(path)
    return mo.read_dxf(path, **GIVEN | options)


def corners(scene):
    return sorted(
        sorted((round(x, 9), round(y, 9)) for x, y in block.vertices)
        for block in scene.blocks
        if not block.fixed
    )


def test_placed_stones_are_those_drawn_one_by_one(tmp_path):
    """A stone is moved, rotated by 90°, mirrored and scaled. The mirrored stone has notches on its left."""
    notched = [(0, 0), (2, 0), (2, 1), (0.5, 1), (0.5, 0.5), (0, 0.5)]
    document = document_with(brick=[("0", BRICK)], notched=[("0", notched)])
    space = document.modelspace()
    space.add_blockref("brick", (0, 0), {"layer": "stones"})
    space.add_blockref("brick", (4, 0), {"layer": "stones", "rotation": 90})
    space.add_blockref("notched", (6, 0), {"layer": "stones", "xscale": -1})
    space.add_blockref("brick", (6, 0), {"layer": "stones", "xscale": 0.5, "yscale": 2})
    wanted = document_with()
    for ring in (
        BRICK,
        [(4, 0), (4, 2), (3, 2), (3, 0)],
        [(6 - x, y) for x, y in notched],
        [(6, 0), (7, 0), (7, 2), (6, 2)],
    ):
        wanted.modelspace().add_lwpolyline(ring, close=True, dxfattribs={"layer": "stones"})
    scene, drawn = read(document, tmp_path), read(wanted, tmp_path)
    assert corners(scene) == corners(drawn)
    assert all(block.name.startswith("stones-") for block in scene.blocks if not block.fixed)
    assert mo.solve(scene, "static").load_factor == pytest.approx(mo.solve(drawn, "static").load_factor)


def test_definitions_may_contain_references_and_rows_of_references(tmp_path):
    """A course of two bricks is placed three times. A row of three bricks is one reference."""
    document = document_with(brick=[("0", BRICK)], course=[])
    for x in (0, 2):
        document.blocks.get("course").add_blockref("brick", (x, 0))
    space = document.modelspace()
    for y in (0, 1, 2):
        space.add_blockref("course", (0, y), {"layer": "stones"})
    row = {"layer": "row", "row_count": 3, "row_spacing": 1, "column_count": 1}
    space.add_blockref("brick", (6, 0), row)
    scene = read(document, tmp_path)
    moving = [block for block in scene.blocks if not block.fixed]
    assert len(moving) == 9
    assert len({block.name for block in moving}) == 9
    assert sum(block.name.startswith("row-") for block in moving) == 3
    assert len(read(document, tmp_path, without_layers=["row"]).blocks) == 7


def test_layers_and_attributes_of_placed_entities(tmp_path):
    """Entities on layer "0" are on the layer of the reference, others keep theirs; an attribute is a name."""
    document = document_with(stone=[("0", BRICK)], support=[("fixed", BRICK)], mark=[("marks", BRICK)])
    space = document.modelspace()
    space.add_blockref("stone", (0, 0), {"layer": "stones"}).add_attrib("NO", "key 7", (1, 0.5))
    space.add_blockref("support", (4, 0), {"layer": "stones"})
    space.add_blockref("mark", (0.1, 0.1), {"layer": "frozen", "xscale": 0.5, "yscale": 0.5})
    space.add_blockref("stone", (6, 0), {"layer": "off"}).dxf.invisible = 1
    document.layers.add("frozen").freeze()
    scene = read(document, tmp_path)
    assert {block.name for block in scene.blocks if not block.fixed} == {"key 7"}
    assert [block.fixed for block in scene.blocks].count(True) == 2
    assert not any(block.holes for block in scene.blocks)


@pytest.mark.parametrize("kind", ["empty", "of itself"])
def test_references_that_place_nothing_are_named(tmp_path, kind):
    """A definition without entities, as that of another file, and a definition that contains itself."""
    document = document_with(stone=[])
    if kind == "of itself":
        document.blocks.get("stone").add_blockref("stone", (1, 0))
    document.modelspace().add_blockref("stone", (3, 0), {"layer": "stones"})
    with pytest.raises(mo.CaseError, match=r"INSERT .* on layer 'stones' .*is a reference .* empty"):
        read(document, tmp_path)


def test_references_that_grow_exponentially_are_refused(tmp_path, monkeypatch):
    """Each of three definitions places the next one ten times: a thousand stones."""
    monkeypatch.setattr(block_references, "_MOST_PLACED", 500)
    document = document_with(a3=[("0", BRICK)], **{f"a{level}": [] for level in range(3)})
    for level in range(3):
        for number in range(10):
            document.blocks.get(f"a{level}").add_blockref(f"a{level + 1}", (2 * number, 0))
    document.modelspace().add_blockref("a0", (0, 0))
    with pytest.raises(mo.CaseError, match=r"block reference .* places more than 500 entities"):
        read(document, tmp_path)


@pytest.mark.parametrize("version", ["R12", "R2010"])
def test_touching_stones_with_arcs_may_be_stretched(tmp_path, version):
    """Half of a semicircular arch is placed twice, mirrored and stretched upwards by 1.5.

    The stones are compared with polygons whose corners are on the two ellipses, in closed form.
    """
    stretch, count = 1.5, 6

    def on_circle(radius, angle):
        return radius * math.cos(angle), radius * math.sin(angle)

    document = ezdxf.new(version)
    add = {"R12": "add_polyline2d", "R2010": "add_lwpolyline"}[version]
    floor = [(-3, -1), (3, -1), (3, 0), (-3, 0)]
    getattr(document.modelspace(), add)(floor, close=True, dxfattribs={"layer": "fixed"})
    definition = document.blocks.new("HALF")
    bulge = math.tan(math.pi / count / 4)
    for number in range(count // 2):
        low, high = (math.pi * (number + side) / count for side in (0, 1))
        inner = [(*on_circle(1, high), -bulge), (*on_circle(1, low), 0)]
        outer = [(*on_circle(1.3, low), bulge), (*on_circle(1.3, high), 0)]
        getattr(definition, add)([*inner, *outer], format="xyb", close=True)
    for side in (1, -1):
        scales = {"xscale": side, "yscale": stretch, "layer": "stones"}
        document.modelspace().add_blockref("HALF", (0, 0), dxfattribs=scales)
    path = tmp_path / "a.dxf"
    document.saveas(path)
    scene = mo.read_dxf(path, friction=0.6, unit_weight=20, live=(1, 0), sagitta=1e-5)
    blocks = [mo.Block(name="floor", vertices=floor, fixed=True)]
    for number in range(count):
        angles = math.pi * (number + np.linspace(0, 1, 100)) / count
        points = [on_circle(1.3, angle) for angle in angles] + [on_circle(1, angle) for angle in angles[::-1]]
        corners = [(x, stretch * y) for x, y in points]
        blocks.append(mo.Block(name=f"v{number}", vertices=corners, unit_weight=20, live_per_weight=(1, 0)))
    drawn = mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=blocks)
    assert len(scene.blocks) == len(drawn.blocks)
    load_factors = [mo.solve(each, "static").required() for each in (scene, drawn)]
    assert load_factors[0] == pytest.approx(load_factors[1], rel=1e-4)

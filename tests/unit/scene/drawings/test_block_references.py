"""References to block definitions in DXF drawings: the entities that they place are read as if drawn."""

import ezdxf
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

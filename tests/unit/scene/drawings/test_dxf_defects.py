"""Drawings as exported: stones drawn twice, a frame around all stones, and supports by their height."""

import ezdxf
import pytest

import masonry_opt as mo


def drawn(path, *rings, layer="stones"):
    document = ezdxf.new()
    for name, ring in rings:
        document.modelspace().add_lwpolyline(ring, close=True, dxfattribs={"layer": name or layer})
    document.saveas(path)
    return path


def brick(x, y):
    return "", [(x, y), (x + 2, y), (x + 2, y + 1), (x, y + 1)]


GIVEN = {"friction": 0.7, "unit_weight": 20.0, "live": (1, 0)}


def test_all_stones_drawn_twice_are_named_at_once_with_both_copies(tmp_path):
    path = drawn(tmp_path / "a.dxf", *[brick(0, y) for y in (0, 1, 2, 0, 1, 2)])
    with pytest.raises(mo.CaseError) as refusal:
        mo.read_dxf(path, **GIVEN)
    message = str(refusal.value)
    assert message.count("has the same outline as") == 3
    assert message.count("LWPOLYLINE") == 6
    assert message.endswith("delete one of each pair")


def test_a_frame_around_all_stones_is_named_with_its_remedy(tmp_path):
    frame = "frame", [(-9, -9), (9, -9), (9, 9), (-9, 9)]
    path = drawn(tmp_path / "a.dxf", frame, brick(0, 0), brick(0, 1))
    with pytest.raises(mo.CaseError, match=r"on layer 'frame' surrounds all .*\(--without-layer\)"):
        mo.read_dxf(path, **GIVEN)
    scene = mo.read_dxf(path, **GIVEN, without_layers=["frame"], fixed_below=0.5)
    assert [block.fixed for block in scene.blocks] == [True, False]


@pytest.mark.parametrize("height", [0.0, 0.5])
def test_blocks_below_a_height_are_supports(tmp_path, height):
    """The stone on top, 2 wide and 1 high, slides at λ = μ = 0.7 before it overturns at λ = 2."""
    scene = mo.read_dxf(drawn(tmp_path / "a.dxf", brick(0, 1), brick(0, 0)), **GIVEN, fixed_below=height)
    assert [block.fixed for block in scene.blocks] == [False, True]
    assert mo.solve(scene, "static").required() == pytest.approx(0.7, rel=1e-6)
    with pytest.raises(mo.CaseError, match="--fixed-below"):
        mo.read_dxf(tmp_path / "a.dxf", **GIVEN, fixed_below=-1.0)

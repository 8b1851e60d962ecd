"""Numbers and counts as they are printed and written: no sign before a zero, one of a thing as one."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from scenes import block_on_floor, overhanging, run_command, small_wall, two_blocks

import masonry_opt as mo

#: A zero with a sign, and one of what is said to be many.
SIGNED = re.compile(r"(?<![\w.])-0(\.0*)?(e[+-]\d+)?(?![\w.])")
MANY = re.compile(r"(?<![\d.e+-])1 (?!is\b|was\b|has\b|hinges\b|slides\b|separates\b|crushes\b)[a-z]+s\b")


def mirrored():
    """Two blocks with their coordinates below zero, and with a sign before each zero."""
    scene = two_blocks()
    blocks = [
        block.model_copy(
            update={"vertices": [(-x, y) for x, y in block.vertices], "live": (-block.live[0], -0.0)}
        )
        for block in scene.blocks
    ]
    return mo.Scene.model_validate(scene.model_dump() | {"blocks": [block.model_dump() for block in blocks]})


SCENES = {
    "mirrored": mirrored,
    "no friction": lambda: block_on_floor(friction=0.0),
    "slides": lambda: block_on_floor(4, 2, 0.5),
    "falls": overhanging,
    "wall": lambda: small_wall(2, 2),
    "tilted": lambda: mo.Scene.model_validate(
        block_on_floor(friction=0.0, live=(0, 0)).model_dump() | {"tilt": "left"}
    ),
}


@pytest.mark.parametrize("method", ["static", "mcp", "nonassociative"])
@pytest.mark.parametrize("name", SCENES)
def test_results_have_no_signed_zero_and_count_one_as_one(name, method):
    result = mo.solve(SCENES[name](), method)
    for frame in (result.joints, result.blocks, result.history):
        numbers = frame.select_dtypes("float64").to_numpy()
        assert not (np.signbit(numbers) & (numbers == 0)).any()
    told = [result.summary, result.details, result.to_json(), repr(result.load_factor)]
    assert [text for text in told if SIGNED.search(text)] == []
    assert not MANY.search(result.details)


def test_scenes_have_no_signed_zero(tmp_path):
    for name in ("a.toml", "a.json"):
        mo.save(mirrored(), tmp_path / name)
        assert not SIGNED.search((tmp_path / name).read_text("utf-8"))


def test_a_load_factor_of_many_digits_is_short(tmp_path):
    """λ = 0.5 · 10²⁴ exactly: eight digits and a power of ten, in words as in JSON."""
    scene = block_on_floor(live=(1e-24, 0.0))
    result = mo.solve(scene, "static")
    assert result.load_factor == pytest.approx(0.5e24, rel=1e-6)
    for text in (result.details, result.plot().axes[0].get_title(), result._repr_html_()):
        assert not re.search(r"\d{12}", text)
    (printed,) = re.findall(r"λ = (\S+)", result.summary.splitlines()[1])
    assert float(printed) == pytest.approx(result.load_factor, rel=1e-6)
    assert json.loads(result.to_json())["load_factor"] == result.load_factor


@pytest.mark.parametrize(("holes", "said"), [(0, "0 holes"), (1, "1 hole"), (2, "2 holes")])
def test_a_drawing_with_one_hole_has_one_hole(monkeypatch, capsys, tmp_path, holes, said):
    ezdxf = pytest.importorskip("ezdxf", reason="needs the extra 'drawings'")
    drawing = ezdxf.new()
    rings = {"wall": [(0, 0, 9, 3)] + [(1 + 3 * k, 1, 2 + 3 * k, 2) for k in range(holes)]}
    rings["fixed"] = [(-1, -1, 10, 0)]
    for layer, boxes in rings.items():
        for x0, y0, x1, y1 in boxes:
            corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
            drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
    drawing.saveas(tmp_path / "a.dxf")
    given = ("--friction", "0.5", "--unit-weight", "1", "--live", "1,0")
    code, out, _ = run_command(
        monkeypatch, capsys, "convert", tmp_path / "a.dxf", tmp_path / "a.toml", *given
    )
    assert code == 0
    assert f"2 blocks (1 fixed), {said}, 1 joint\n" in out

"""Defects of exported drawings: copies, frames, open outlines, unread layers, unlikely units and supports by
height."""

import math
import re
import warnings

import ezdxf
import pytest
from scenes import run_command
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.errors import DrawingWarning
from masonry_opt.scene.geometry import geometry

FLOOR = "fixed", [(-1, -1), (3, -1), (3, 0), (-1, 0)]
GIVEN = {"friction": 0.7, "unit_weight": 20.0, "live": (1, 0)}


def drawn(path, *rings, layer="stones", unit=0, closed=True):
    document = ezdxf.new()
    document.units = unit
    for name, ring in rings:
        document.modelspace().add_lwpolyline(ring, close=closed, dxfattribs={"layer": name or layer})
    document.saveas(path)
    return path


def brick(x, y, layer=""):
    return layer, [(x, y), (x + 2, y), (x + 2, y + 1), (x, y + 1)]


def turned(brick, start, step):
    """Return a brick whose outline begins at another corner, or runs in the other direction."""
    layer, ring = brick
    return layer, [ring[(start + step * number) % 4] for number in range(4)]


@pytest.mark.parametrize(("start", "step"), [(0, 1), (2, 1), (1, -1)])
def test_copies_are_left_out_and_named(tmp_path, start, step):
    """A copy may begin at another corner or run in the other direction. Three copies of a stone are one
    block."""
    stones = [brick(0, y) for y in (0, 1)]
    copies = [turned(stone, start, step) for stone in (*stones, stones[1])]
    path = drawn(tmp_path / "a.dxf", FLOOR, *stones, *copies)
    with pytest.warns(DrawingWarning, match="3 outlines are drawn twice, and copies were left out") as caught:
        scene = mo.read_dxf(path, **GIVEN)
    (warning,) = caught
    assert str(warning.message).count("on layer 'stones' repeats LWPOLYLINE") == 3
    assert len(scene.blocks) == 3
    # The stones are 2 wide and 2 high together: they slide at λ = μ = 0.7 before they overturn at λ = 1.
    assert mo.solve(scene, "static").required() == pytest.approx(0.7, rel=1e-6)


def test_a_stone_that_is_also_drawn_as_support_is_a_support(tmp_path):
    path = drawn(tmp_path / "a.dxf", brick(0, 0), brick(0, 1), brick(0, 0, "support"))
    with pytest.warns(DrawingWarning, match="on layer 'stones' repeats LWPOLYLINE .* on layer 'support'"):
        scene = mo.read_dxf(path, **GIVEN)
    assert sorted(block.fixed for block in scene.blocks) == [False, True]


def test_a_hole_may_be_drawn_with_its_filling_and_further_copies(tmp_path):
    """A hole that is drawn three times has one filling, and one outline is reported as a copy."""
    around = "", [(0, 0), (4, 0), (4, 3), (0, 3)]
    path = drawn(tmp_path / "a.dxf", FLOOR, around, *[brick(1, 1)] * 3)
    with pytest.warns(DrawingWarning, match="1 outline is drawn twice"):
        scene = mo.read_dxf(path, **GIVEN)
    assert [len(block.holes) for block in scene.blocks] == [0, 1, 0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(mo.read_dxf(drawn(path, FLOOR, around, *[brick(1, 1)] * 2), **GIVEN).blocks) == 3


@pytest.mark.parametrize(
    ("left", "low", "right", "high"),
    [(0, 0, 0.96, 1), (0.3, 0, 1, 1), (-0.1, 0, 1, 1), (0.002, 0.002, 0.998, 0.998)],
)
def test_a_copy_of_another_size_is_named(tmp_path, left, low, right, high):
    """The smaller outline would be a hole, and only a strip or a thin ring of the stone would remain."""
    copy = ("", [(left, low), (right, low), (right, high), (left, high)])
    path = drawn(tmp_path / "a.dxf", FLOOR, ("", [(0, 0), (1, 0), (1, 1), (0, 1)]), copy)
    with pytest.raises(mo.CaseError, match=r"LWPOLYLINE .* is a smaller copy of LWPOLYLINE .*delete one"):
        mo.read_dxf(path, **GIVEN)


@pytest.mark.parametrize("door", [(0.3, 0, 0.7, 0.8), (0.1, 0.1, 0.9, 0.9)])
def test_doors_and_large_windows_are_holes(tmp_path, door):
    """A door shares a side with the outline of its wall. A large window leaves a ring of the wall."""
    left, low, right, high = door
    hole = ("", [(left, low), (right, low), (right, high), (left, high)])
    path = drawn(tmp_path / "a.dxf", FLOOR, ("", [(0, 0), (1, 0), (1, 1), (0, 1)]), hole)
    size = geometry(mo.read_dxf(path, **GIVEN)).size
    assert min(size) == pytest.approx(1 - (right - left) * (high - low), rel=1e-6)


def test_lines_drawn_twice_are_read_once(tmp_path):
    """The four sides of a stone are separate lines. Each is drawn twice, the second time in the other
    direction."""
    (_, ring) = brick(0, 0)
    sides = [("", [ring[number - 1], ring[number]]) for number in range(4)]
    path = drawn(tmp_path / "a.dxf", *sides, *((name, side[::-1]) for name, side in sides), closed=False)
    document = ezdxf.readfile(path)
    document.modelspace().add_lwpolyline(FLOOR[1], close=True, dxfattribs={"layer": "fixed"})
    document.saveas(path)
    with pytest.warns(DrawingWarning, match="4 outlines are drawn twice"):
        assert len(mo.read_dxf(path, **GIVEN).blocks) == 2


def test_all_defects_are_named_at_once_by_kind_and_place(tmp_path):
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0), ("", [(0, 5), (4, 5), (0, 6), (4, 6)]))
    document = ezdxf.readfile(path)
    space = document.modelspace()
    space.add_lwpolyline(brick(8, 0)[1])
    space.add_lwpolyline(brick(8, 3)[1])
    space.add_lwpolyline([(5, 5), (6, 5), (5.5, 5)], close=True)
    space.add_blockref("stone", (7, 7))
    document.saveas(path)
    with pytest.raises(mo.CaseError) as refusal:
        mo.read_dxf(path, **GIVEN)
    reference, opened, crossing, empty = str(refusal.value).splitlines()
    assert "definition that is empty or cannot be placed near (7, 7)" in reference
    assert "2 outlines are open (LWPOLYLINE" in opened
    assert "near (8, 0), 1 from the nearest free end; LWPOLYLINE" in opened
    # The diagonals of the outline of 4 × 1 cross at its middle.
    assert "on layer 'stones' crosses itself near (2, 5.5)" in crossing
    assert "has no area near (5, 5): delete outlines without area" in empty


@pytest.mark.parametrize("option", ["tolerance", "outline_tolerance"])
@pytest.mark.parametrize("value", [0.6, 1.5, 30.0])
def test_a_tolerance_larger_than_a_stone_is_named_instead_of_the_stone(tmp_path, option, value):
    """The outline of the pebble, 0.5 wide, has an area, although not within the tolerance. The message
    advises a tolerance with which the drawing can be read."""
    pebble = "", [(0, 2), (0.5, 2), (0.5, 2.5), (0, 2.5)]
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0), brick(0, 1), pebble)
    with pytest.raises(mo.CaseError) as refusal:
        mo.read_dxf(path, **GIVEN, **{option: value})
    (line,) = str(refusal.value).splitlines()
    assert f"no area within '{option}' {value:g}" in line
    assert "the thickness of the thinnest outline is 0.5, so set" in line
    assert "delete outlines" not in line
    advised = float(re.search(rf"set '{option}' to less than ([\d.]+),", line)[1])
    assert len(mo.read_dxf(path, **GIVEN, **{option: 0.99 * advised}).blocks) == 4


def test_a_curve_of_short_chords_limits_the_advised_tolerance(tmp_path):
    """All 100 chords of a circle of radius 1, 0.0628 long, are shorter than the tolerance."""
    corners = [(math.cos(math.pi * n / 50), 2 + math.sin(math.pi * n / 50)) for n in range(100)]
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0), ("", corners))
    with pytest.raises(mo.CaseError, match=r"has no area within 'tolerance' 0.08 near \(1, 2\)") as refusal:
        mo.read_dxf(path, **GIVEN, tolerance=0.08)
    advised = float(re.search(r"set 'tolerance' to less than ([\d.]+),", str(refusal.value))[1])
    assert 0.06 < advised < 2 * math.sin(math.pi / 100)
    assert len(mo.read_dxf(path, **GIVEN, tolerance=0.99 * advised).blocks) == 3


@pytest.mark.parametrize("outside", [[], [("title", [(12, -9), (20, -9), (20, -5), (12, -5)])]])
@pytest.mark.parametrize("supports", ["fixed", "plinth"])
@pytest.mark.parametrize("mortar", [0.0, 0.1])
def test_a_frame_around_all_stones_is_named_with_its_remedy(tmp_path, outside, supports, mortar):
    """The title block may be outside the frame. Supports are identified by their layer or by their height."""
    frame = "frame", [(-9, -9), (9, -9), (9, 9), (-9, 9)]
    stones = brick(0, 0, supports), brick(0, 1 + mortar), brick(0, 2 + 2 * mortar)
    path = drawn(tmp_path / "a.dxf", *outside, frame, *stones)
    for height in (None, 0.5):
        with pytest.raises(
            mo.CaseError, match=r"on layer 'frame' is a frame around 3 .*--without-layer frame"
        ):
            mo.read_dxf(path, **GIVEN, fixed_below=height)
    omitted = ["frame", *(layer for layer, _ in outside)]
    scene = mo.read_dxf(path, **GIVEN, without_layers=omitted, fixed_below=0.5)
    assert [block.fixed for block in scene.blocks] == [True, False, False]


def test_a_frame_on_the_layer_of_the_stones_must_be_deleted(tmp_path):
    frame = "", [(-9, -9), (9, -9), (9, 9), (-9, 9)]
    path = drawn(tmp_path / "a.dxf", frame, FLOOR, brick(0, 0))
    with pytest.raises(
        mo.CaseError, match=r"a frame .* if none of its other outlines are stones; if some are, del"
    ):
        mo.read_dxf(path, **GIVEN)


def test_a_net_may_have_a_frame(tmp_path):
    frame = "frame", [(-9, -9), (9, -9), (9, 9), (-9, 9)]
    path = drawn(tmp_path / "a.dxf", frame, FLOOR, brick(0, 0), brick(0, 1))
    with pytest.raises(mo.CaseError, match=r"on layer 'frame' is a frame .*--without-layer frame"):
        mo.read_dxf(path, **GIVEN, net=True)
    assert len(mo.read_dxf(path, **GIVEN, net=True, without_layers=["frame"]).blocks) == 3


def test_a_stone_with_holes_is_no_frame(tmp_path):
    """A perforated stone is on a floor, and most outlines are its holes."""
    holes = [("", [(x, 0.2), (x + 0.2, 0.2), (x + 0.2, 0.8), (x, 0.8)]) for x in (0.2, 0.6, 1.0, 1.4)]
    scene = mo.read_dxf(drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0), *holes), **GIVEN)
    assert [len(block.holes) for block in scene.blocks] == [0, 4]


@pytest.mark.parametrize(
    ("unit", "factor", "size"),
    [(6, 3000, "as much as 12000 m"), (4, 0.003, "only 1.2e-05 m"), (4, 3, "only 0.012 m"), (4, 3000, "")],
)
def test_units_that_do_not_fit_the_size_are_doubted(tmp_path, unit, factor, size):
    """The drawing is 4 times the factor wide."""
    rings = [(layer, [(factor * x, factor * y) for x, y in ring]) for layer, ring in (FLOOR, brick(0, 0))]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mo.read_dxf(drawn(tmp_path / "a.dxf", *rings, unit=unit), **GIVEN)
    assert [str(warning.message).count(f"so it is {size} wide") for warning in caught] == [1] * bool(size)


@pytest.mark.parametrize(
    ("unit", "courses", "warned"),
    [(6, 9, False), (6, 10, False), (5, 10, False), (15, 9, False), (15, 10, True)],
)
def test_units_that_make_stones_too_large_are_doubted(tmp_path, unit, courses, warned):
    """Stones of 2 × 1 units are 20 m × 10 m in decametres (code 15). A few blocks may be whole walls."""
    path = drawn(tmp_path / "a.dxf", FLOOR, *(brick(0, y) for y in range(courses)), unit=unit)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mo.read_dxf(path, **GIVEN)
    found = [str(warning.message) for warning in caught]
    assert len(found) == warned
    assert all(
        "so half of its blocks are at least 10 m wide and high: correct the unit" in one for one in found
    )


@pytest.mark.parametrize(
    ("unit", "options", "size"),
    [
        (0, (), "2 × 3 (unit of length not known)"),
        (6, (), "2 × 3 m"),
        (14, (), "2 × 3 decimetres = 0.2 × 0.3 m"),
        (14, ("--to-metres",), "0.2 × 0.3 m"),
        (14, ("--thickness", "4"), "2 × 4 × 3 decimetres = 0.2 × 0.4 × 0.3 m"),
    ],
)
def test_the_command_prints_the_size_with_its_unit(tmp_path, command, unit, options, size):
    path = drawn(tmp_path / "a.dxf", FLOOR, *(brick(0, y) for y in range(3)), unit=unit)
    output = command(
        "convert", path, tmp_path / "a.toml", "--friction", "0.7", "--unit-weight", "20", *options
    )
    assert f"\nsize without supports: {size}\n" in output


@pytest.mark.parametrize(
    ("reason", "advice", "keys"),
    [
        ("not named with --layer", "add the layer to 'layers' (--layer)", {"layers": ["stones"]}),
        (
            "--without-layer",
            "remove the layer from 'without_layers' (--without-layer)",
            {"without_layers": ["fixed"]},
        ),
        ("frozen", "thaw the layer, or turn it on, in the drawing", {}),
        ("off", "thaw the layer, or turn it on, in the drawing", {}),
        ("no outlines", "draw the supports on the layer as closed outlines", {}),
    ],
)
def test_a_layer_of_supports_that_was_not_read_is_named_with_a_remedy(tmp_path, reason, advice, keys):
    path = drawn(tmp_path / "a.dxf", brick(0, 0), *(() if reason == "no outlines" else [FLOOR]))
    document = ezdxf.readfile(path)
    layer = document.layers.add("fixed")
    if reason == "no outlines":
        document.modelspace().add_text("on rock", dxfattribs={"layer": "fixed"})
    elif reason == "frozen":
        layer.freeze()
    elif reason == "off":
        layer.off()
    document.saveas(path)
    with pytest.raises(mo.CaseError) as refusal:
        mo.read_dxf(path, **GIVEN, **keys)
    assert str(refusal.value).endswith(f"because layer 'fixed' was not read ({reason}): {advice}")


def test_a_frozen_layer_that_is_to_be_read_is_refused(tmp_path):
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0))
    document = ezdxf.readfile(path)
    document.layers.add("fixed").freeze()
    document.saveas(path)
    with pytest.raises(mo.CaseError, match=r"'layers' \(--layer\): layer 'fixed' is frozen: thaw the layer"):
        mo.read_dxf(path, **GIVEN, layers=["stones", "fixed"])


def test_the_command_lists_layers_and_prints_warnings(tmp_path, monkeypatch, capsys):
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0), brick(0, 0), brick(8, 8, "off"), brick(8, 8, "ice"))
    document = ezdxf.readfile(path)
    space = document.modelspace()
    space.add_line((0, 0), (9, 9), dxfattribs={"layer": "cracks"})
    space.add_text("plan", dxfattribs={"layer": "notes"})
    document.layers.add("off").off()
    document.layers.add("ice").freeze()
    document.saveas(path)
    options = "--friction", "0.7", "--unit-weight", "20", "--live", "1,0", "--without-layer", "cracks"
    code, out, err = run_command(monkeypatch, capsys, "convert", path, tmp_path / "a.toml", *options)
    assert code == 0
    _, size, read, not_read = out.splitlines()
    assert size == "size without supports: 2 × 1 (unit of length not known)"
    assert read == "layers read: fixed (1 curve, supports), stones (2 curves)"
    assert not_read == (
        "layers not read: off (off), ice (frozen), cracks (--without-layer), notes (no outlines)"
    )
    assert "warning: " in err
    assert "1 outline is drawn twice, and copies were left out" in err


def test_the_command_names_the_block_and_the_layer_of_each_hole(tmp_path, command):
    """A circle that marks an anchor would become a hole in its stone."""
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0), brick(0, 1))
    document = ezdxf.readfile(path)
    circle = document.modelspace().add_circle((1, 1.5), 0.1, dxfattribs={"layer": "anchors"})
    document.saveas(path)
    scene = mo.read_dxf(path, **GIVEN)
    (stone,) = [block.name for block in scene.blocks if block.holes]
    out = command("convert", path, tmp_path / "a.toml", "--friction", "0.7", "--unit-weight", "20")
    assert f"holes: CIRCLE {circle.dxf.handle} on layer 'anchors' in block '{stone}'" in out.splitlines()


def test_the_advised_tolerance_is_the_thickness_of_a_curved_overlap(tmp_path):
    """A half ring around an arch of radius 4 overlaps the arch by 0.02.

    The lines that enclose the common region, also a half ring, are 4.0 apart.
    """
    bulge = 1.0  # half a circle
    rings = {
        "floor fixed": [(-9, -1, 0), (9, -1, 0), (9, 0, 0), (-9, 0, 0)],
        "inner": [(4, 0, bulge), (-4, 0, 0), (-3, 0, -bulge), (3, 0, 0)],
        "outer": [(5, 0, bulge), (-5, 0, 0), (-3.98, 0, -bulge), (3.98, 0, 0)],
    }
    document = ezdxf.new()
    for layer, ring in rings.items():
        document.modelspace().add_lwpolyline(ring, format="xyb", close=True, dxfattribs={"layer": layer})
    document.saveas(tmp_path / "a.dxf")
    scene = mo.read_dxf(tmp_path / "a.dxf", **GIVEN)
    with pytest.raises(mo.CaseError, match="overlap over an area") as refusal:
        mo.solve(scene, "static")
    advised = float(re.search("'contact_tolerance' to ([0-9.]+)", str(refusal.value))[1])
    # The advice is an upper bound: π times the area over half the perimeter.
    assert 0.02 <= advised <= 1.01 * math.pi * 0.02
    # Each half ring touches the floor with both ends, and the other half ring.
    assert len(contacts_of(scene.replace(contact_tolerance=advised)).extent) >= 5


@pytest.mark.parametrize("height", [0.0, 0.5])
def test_blocks_below_a_height_are_supports(tmp_path, height):
    """The stone on top, 2 wide and 1 high, slides at λ = μ = 0.7 before it overturns at λ = 2."""
    scene = mo.read_dxf(drawn(tmp_path / "a.dxf", brick(0, 1), brick(0, 0)), **GIVEN, fixed_below=height)
    assert [block.fixed for block in scene.blocks] == [False, True]
    assert mo.solve(scene, "static").required() == pytest.approx(0.7, rel=1e-6)
    with pytest.raises(mo.CaseError, match="--fixed-below"):
        mo.read_dxf(tmp_path / "a.dxf", **GIVEN, fixed_below=-1.0)


def test_the_command_names_the_option_that_closes_gaps(tmp_path, command):
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0.01))
    options = "--friction", "0.7", "--unit-weight", "20"
    message = command.refused("convert", path, tmp_path / "a.toml", *options)
    assert "set 'tolerance' (--tolerance) to 0.011" in message
    assert command("convert", path, tmp_path / "a.toml", *options, "--tolerance", "0.011")


def test_an_outline_far_away_is_not_blamed_on_the_others(tmp_path):
    """The default tolerance is a millionth of the drawing, so it is larger than the stones."""
    far = ("", [(1e7, 0), (1e7 + 1, 0), (1e7 + 1, 1), (1e7, 1)])
    with pytest.raises(mo.CaseError) as error:
        mo.read_dxf(drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0), far), **GIVEN)
    assert "3 outlines are smaller than the tolerance 10" in str(error.value)
    advice = "if the tolerance is too large because some outlines are far away, delete the distant outlines"
    assert advice in str(error.value)


@pytest.mark.parametrize("number", [1, 4])
def test_a_short_side_does_not_tilt_another_side(tmp_path, number):
    """A corner that is on a side of the brick, next to another corner, is the one to remove."""
    ring = [(0, 0), (2, 0), (2, 1), (0, 1)]
    ring.insert(number, (0.001, 0) if number == 1 else (0, 0.001))
    path = drawn(tmp_path / "a.dxf", FLOOR, ("", ring))
    scene = mo.read_dxf(path, **GIVEN, outline_tolerance=0.01)
    (block,) = [block for block in scene.blocks if not block.fixed]
    assert sorted(block.vertices) == [(0, 0), (0, 1), (2, 0), (2, 1)]
    assert mo.solve(scene, "static").load_factor == pytest.approx(0.7)


def lines_of(path, *chains):
    """Write a drawing of open polylines on layer "stones", with the floor, and return the path."""
    drawn(path, FLOOR)
    document = ezdxf.readfile(path)
    for chain in chains:
        document.modelspace().add_lwpolyline(chain, dxfattribs={"layer": "stones"})
    document.saveas(path)
    return path


@pytest.mark.parametrize(
    ("corners", "advice"),
    [
        # The flag "closed" is missing.
        ([(0, 0), (4000, 0), (4000, 2000), (0, 2000)], "set the flag 'closed' of polylines"),
        # The last corner misses the first one.
        ([(0, 0), (4000, 0), (4000, 2000), (0, 2000), (0, 30)], "set 'outline_tolerance'"),
        # A single line of four is left.
        ([(0, 0), (4000, 0)], "draw the missing sides"),
    ],
)
def test_the_remedy_of_an_open_outline_depends_on_its_gap(tmp_path, corners, advice):
    """A tolerance as large as a side of the stone would leave no stone."""
    every = {"set the flag 'closed' of polylines", "set 'outline_tolerance'", "draw the missing sides"}
    with pytest.raises(mo.CaseError) as refusal:
        mo.read_dxf(lines_of(tmp_path / "a.dxf", corners), **GIVEN)
    assert [text for text in every if text in str(refusal.value)] == [advice]
    assert "e+03" not in str(refusal.value)


def test_the_advised_outline_tolerance_closes_all_gaps(tmp_path):
    """Three bricks miss their first corner by 0.001, 0.003 and 0.02. The tallest one has λ = 0.5/1.25."""
    chains = [
        [(x, 0), (x + 0.5, 0), (x + 0.5, height), (x, height), (x, gap)]
        for x, height, gap in ((0, 0.5, 0.001), (1, 1.25, 0.003), (2, 0.5, 0.02))
    ]
    path = lines_of(tmp_path / "a.dxf", *chains)
    message = r"3 outlines are open .*set 'outline_tolerance' \(--outline-tolerance\) to ([\d.]+) to close"
    with pytest.raises(mo.CaseError, match=message) as refusal:
        mo.read_dxf(path, **GIVEN)
    advised = float(re.search(message, str(refusal.value))[1])
    assert 0.02 < advised < 0.021
    scene = mo.read_dxf(path, outline_tolerance=advised, **GIVEN)
    assert mo.solve(scene, "static").required() == pytest.approx(0.4, rel=1e-6)


def test_near_copies_of_a_stone_may_be_removed(tmp_path):
    """Two copies that are 0.01 apart overlap almost entirely. One of them is superfluous."""
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0), brick(0.01, 0))
    with pytest.raises(mo.CaseError, match="or remove one of them if both are the same stone"):
        mo.solve(mo.read_dxf(path, **GIVEN))


def test_polylines_without_the_flag_closed_beside_each_other_are_each_named(tmp_path):
    """Neighbours are nearer than the own ends of a polyline, so both remedies are named."""
    stones = [[(x, 0), (x + 39, 0), (x + 39, 19), (x, 19)] for x in (0, 40)]
    with pytest.raises(mo.CaseError, match=r"2 outlines are open .*set the flag 'closed' of polylines"):
        mo.read_dxf(lines_of(tmp_path / "a.dxf", *stones), **GIVEN)


def test_a_drawing_in_the_paper_space_is_found(tmp_path):
    document = ezdxf.new()
    for layout, corners in (("Layout1", FLOOR[1]), ("Layout1", brick(0, 0)[1])):
        document.layout(layout).add_lwpolyline(corners, close=True)
    document.saveas(tmp_path / "a.dxf")
    message = "the model space is empty, but layout 'Layout1' in the paper space has 2 entities: move the bl"
    for keys in ({}, {"layers": ["stones"]}):
        with pytest.raises(mo.CaseError, match=message):
            mo.read_dxf(tmp_path / "a.dxf", **GIVEN, **keys)


def test_a_drawing_whose_layers_are_all_hidden_is_not_called_empty(tmp_path):
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0))
    document = ezdxf.readfile(path)
    for name in ("fixed", "stones"):
        document.layers.add(name).off()
    document.saveas(path)
    with pytest.raises(mo.CaseError, match="all entities of the model space, or their layers, are hid"):
        mo.read_dxf(path, **GIVEN)


@pytest.mark.parametrize("keys", [{"live": (1, 0, 0)}, {"live_layers": {"stones": (1, 0, 0)}}])
def test_three_components_of_a_live_load_need_a_thickness(tmp_path, keys):
    path = drawn(tmp_path / "a.dxf", FLOOR, brick(0, 0))
    key = next(iter(keys))
    with pytest.raises(mo.CaseError, match=rf"a\.dxf: '{key}' .* has three components, .*set 'thickness'"):
        mo.read_dxf(path, **GIVEN | keys)
    assert mo.read_dxf(path, **GIVEN | keys, thickness=1.0).dimension == 3


@pytest.mark.parametrize("version", ["R12", "R2000", "R2018"])
def test_names_with_characters_of_other_alphabets(tmp_path, version):
    """Files of old versions write characters that their encoding lacks as codes such as \\U+77f3."""
    document = ezdxf.new(version)
    space = document.modelspace()
    for layer, (_, ring) in (("fixed", FLOOR), ("石 é", brick(0, 0)), ("hidden 石", brick(5, 5))):
        space.add_polyline2d(ring, close=True, dxfattribs={"layer": layer})
    document.layers.add("hidden 石").off()
    space.add_text("камень", dxfattribs={"insert": (0.5, 0.5), "layer": "石 é"})
    document.saveas(tmp_path / "a.dxf")
    scene = mo.read_dxf(tmp_path / "a.dxf", layers=["石 É", "fixed"], **GIVEN)
    assert [block.name for block in scene.blocks if not block.fixed] == ["камень"]
    with pytest.raises(mo.CaseError, match="layer 'hidden 石' is off"):
        mo.read_dxf(tmp_path / "a.dxf", layers=["hidden 石"], **GIVEN)

"""DXF drawings in which the ground is a single straight line."""

import warnings

import ezdxf
import pytest
from scenes import run_command

import masonry_opt as mo
from masonry_opt.errors import DrawingWarning

#: Each line that is read as a support causes a warning, which two tests check.
pytestmark = pytest.mark.filterwarnings("ignore::masonry_opt.errors.DrawingWarning")

GIVEN = {"friction": 0.6, "unit_weight": 2.0, "live": (1, 0)}
#: A stack of three stones, 2 wide and 3 high: it slides at λ = μ, and overturns at λ = (2/2) / (3/2) = 2/3.
STACK = [[(0, i), (2, i), (2, i + 1), (0, i + 1)] for i in range(3)]
GROUND = ((-1, 0), (4, 0))


def drawing(tmp_path, lines, stones=STACK, layer="ground", close=True):
    """Write a drawing with stones on the layer "stones" and lines on another layer, and return its path."""
    document = ezdxf.new("R2010")
    space = document.modelspace()
    for stone in stones:
        if close:
            space.add_lwpolyline(stone, close=True, dxfattribs={"layer": "stones"})
            continue
        for start, end in zip(stone, [*stone[1:], stone[0]], strict=True):
            space.add_line(start, end, dxfattribs={"layer": "stones"})
    for points in lines:
        space.add_lwpolyline(points, dxfattribs={"layer": layer})
    path = tmp_path / "a.dxf"
    document.saveas(path)
    return path


def refusal(path, **more):
    with pytest.raises(mo.CaseError) as error:
        mo.read_dxf(path, **(GIVEN | more))
    return str(error.value)


@pytest.mark.parametrize(
    "lines",
    [
        [GROUND],
        [GROUND[::-1]],
        [((-1, 0), (0.5, 0), (4, 0))],
        [((-1, 0), (0.5, 0)), ((0.5, 0), (4, 0))],
        [((-1, 0), (0.9, 0)), ((1.1, 0), (3, 0))],
    ],
    ids=["a line", "from right to left", "a polyline", "two pieces", "two lines"],
)
@pytest.mark.parametrize(("friction", "load_factor"), [(0.6, 0.6), (5.0, 2 / 3)])
def test_a_line_on_a_layer_of_supports_is_a_support(tmp_path, lines, friction, load_factor):
    scene = mo.read_dxf(drawing(tmp_path, lines, layer="Fixed"), **(GIVEN | {"friction": friction}))
    assert [block.fixed for block in scene.blocks[:3]] == [False] * 3
    assert all(block.fixed for block in scene.blocks[3:])
    assert mo.solve(scene, "static").required() == pytest.approx(load_factor, rel=1e-6)


def test_a_warning_names_the_lines_that_are_read_as_supports(tmp_path):
    """An axis line along the right side of a stack, on a layer of supports, is read as a wall."""
    floor = [(-1, -1), (4, -1), (4, 0), (-1, 0), (-1, -1)]
    path = drawing(tmp_path, [floor, ((2, 0.5), (2, 4))], layer="fixed")
    with pytest.warns(DrawingWarning) as warned:
        scene = mo.read_dxf(path, **GIVEN)
    (message,) = [str(warning.message) for warning in warned]
    assert message.startswith(f"{path}: 1 straight line is read as the surface of a support (LWPOLYLINE ")
    advice = "move lines that are not surfaces, such as axes, to a separate layer, and omit that layer with"
    assert f" on layer 'fixed' near (2, 0.5)): {advice} 'without_layers'" in message
    assert mo.solve(scene, "static").load_factor is None
    path = drawing(tmp_path, [((-1, 0), (0.9, 0)), ((1.1, 0), (3, 0))], layer="fixed")
    with pytest.warns(
        DrawingWarning, match=r"2 straight lines .* near \(-1, 0\); .* near \(1.1, 0\)\): move"
    ):
        mo.read_dxf(path, **GIVEN)


def test_a_drawing_with_a_closed_floor_has_no_warning(tmp_path):
    floor = [(-1, -1), (4, -1), (4, 0), (-1, 0), (-1, -1)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mo.read_dxf(drawing(tmp_path, [floor], layer="fixed"), **GIVEN)


def test_the_command_convert_prints_the_warning_about_lines(tmp_path, monkeypatch, capsys):
    path = drawing(tmp_path, [GROUND], layer="fixed")
    options = ["--friction", "0.6", "--unit-weight", "2", "--live", "1,0"]
    code, _, err = run_command(monkeypatch, capsys, "convert", path, tmp_path / "a.toml", *options)
    assert code == 0
    assert err.count("1 straight line is read as the surface of a support (LWPOLYLINE ") == 1


@pytest.mark.parametrize(
    ("lines", "stones"),
    [
        ([((-1, 0), (2, 0), (2, 3))], STACK),
        ([((-1, 0), (2, 0)), ((2, 0), (2, 3))], STACK),
        ([((-1, 0), (2.4, 0)), ((2.8, -0.5), (6, -0.5))], [STACK[0], [(3, -0.5), (5, -0.5), (5, 1), (3, 1)]]),
    ],
    ids=["floor and wall", "floor and wall in two lines", "a step"],
)
def test_the_message_about_another_ground_advises_a_closed_outline(tmp_path, lines, stones):
    message = refusal(drawing(tmp_path, lines, stones, layer="fixed"))
    assert " on layer 'fixed' is open near (-1, 0)" in message
    advice = (
        "a ground line must be a single straight line with all blocks on one side and no outline behind it"
    )
    assert f"{advice}, so draw any other ground as a closed outline" in message
    assert advice not in refusal(drawing(tmp_path, lines, stones, layer="other"))


@pytest.mark.parametrize(("push", "load_factor"), [((1, 0), 0.8 / 0.88), ((-1, 0), 0.4 / 1.12)])
def test_a_sloping_line_is_a_support(tmp_path, push, load_factor):
    """On a slope of 0.2, a block slides at λ = (μ ± 0.2) / (1 ∓ 0.2 μ)."""
    block = [(0, 0), (5, 1), (4.8, 2), (-0.2, 1)]
    path = drawing(tmp_path, [((-5, -1), (10, 2))], [block])
    scene = mo.read_dxf(path, **(GIVEN | {"live": push}), fixed_layers=["ground"])
    assert mo.solve(scene, "static").required() == pytest.approx(load_factor, rel=1e-6)


def test_the_slab_is_on_the_side_without_blocks(tmp_path):
    """A line to the right of a block becomes a slab, which holds the block. The floor is a closed outline."""
    floor = [(-9, -1), (9, -1), (9, 0), (-9, 0)]
    path = drawing(tmp_path, [((2, 0), (2, 3)), (*floor, floor[0])], layer="fixed")
    scene = mo.read_dxf(path, **GIVEN)
    (slab,) = [
        block
        for block in scene.blocks
        if block.fixed and len(block.vertices) == 4 and block.vertices[0][1] >= 0
    ]
    assert min(x for x, _ in slab.vertices) == pytest.approx(2)


def test_a_drawing_with_a_thickness_may_have_a_ground_line(tmp_path):
    path = drawing(tmp_path, [GROUND], layer="fixed")
    scene = mo.read_dxf(path, **(GIVEN | {"live": (1, 0, 0)}), thickness=0.5)
    assert mo.solve(scene, "static").required() == pytest.approx(0.6, rel=1e-5)


def test_a_net_may_have_a_ground_line(tmp_path):
    """The ground closes the lowest cell of the net."""
    joints = [((0, 0), (0, 3)), ((2, 0), (2, 3)), *(((0, z), (2, z)) for z in (1, 2, 3))]
    path = drawing(tmp_path, [GROUND], [], layer="fixed")
    document = ezdxf.readfile(path)
    for start, end in joints:
        document.modelspace().add_line(start, end, dxfattribs={"layer": "joints"})
    document.saveas(path)
    scene = mo.read_dxf(path, **GIVEN, net=True)
    assert [block.fixed for block in scene.blocks] == [False] * 3 + [True]
    assert mo.solve(scene, "static").required() == pytest.approx(0.6, rel=1e-6)


@pytest.mark.parametrize("close", [True, False])
@pytest.mark.parametrize("below", [0, 0.01])
def test_the_message_about_a_ground_line_names_the_option(tmp_path, close, below):
    """With the option that the message names, the line becomes a support. Defects of stones are in the same
    message."""
    path = drawing(tmp_path, [[(x, -below) for x, _ in GROUND]], close=close)
    message = refusal(path)
    assert "on layer 'ground' is a straight line next to the blocks near (-1, " in message
    assert (
        "if it is the ground, name its layer with 'fixed_layers' (--fixed-layer ground), so that" in message
    )
    if close:
        scene = mo.read_dxf(path, **GIVEN, fixed_layers=["ground"], contact_tolerance=0.02)
        assert mo.solve(scene, "static").required() == pytest.approx(0.6, rel=1e-6)
    else:
        assert "4 ends of curves touch several other ends" in message


def test_the_option_names_the_layers_of_all_supports(tmp_path):
    path = drawing(tmp_path, [GROUND])
    document = ezdxf.readfile(path)
    pier = [(7, 0), (8, 0), (8, 1), (7, 1)]
    document.modelspace().add_lwpolyline(pier, close=True, dxfattribs={"layer": "Fixed pier"})
    document.saveas(path)
    assert "(--fixed-layer Fixed pier --fixed-layer ground)" in refusal(path)


def test_a_ground_line_on_the_layer_of_the_stones_must_be_moved(tmp_path):
    message = refusal(drawing(tmp_path, [GROUND], layer="stones"))
    assert "if it is the ground, move it to a layer with 'fixed' in its name, so that it becomes" in message


@pytest.mark.parametrize(
    "line",
    [((-1, -2), (4, -2)), ((-1, 0.5), (4, 0.5)), ((-1, 0), (1, -0.5), (4, 0))],
    ids=["far", "within", "bent"],
)
def test_other_lines_are_open_outlines(tmp_path, line):
    message = refusal(drawing(tmp_path, [line]))
    assert "is open near (-1, " in message
    assert "ground, " not in message


@pytest.mark.parametrize(
    "line", [((-1, 0.5), (4, 0.5)), ((-1, 0), (1, -0.5), (4, 0))], ids=["within", "bent"]
)
def test_a_line_between_blocks_or_a_bent_line_is_no_support(tmp_path, line):
    assert "on layer 'fixed' is open near (-1, " in refusal(drawing(tmp_path, [line], layer="fixed"))


def test_lines_whose_ends_nearly_meet_are_sides_of_an_outline(tmp_path):
    sides = [((-1, 0), (4, 0)), ((4.04, 0), (4.04, -1)), ((4, -1), (-1, -1)), ((-1.04, -1), (-1.04, 0))]
    assert "4 outlines are open" in refusal(drawing(tmp_path, sides, layer="fixed"))


@pytest.mark.parametrize(
    "more",
    [((-2, -1), (5, -1), (5, 0), (-2, 0), (-2, -1)), ((-0.5, -0.1), (3.5, -0.1))],
    ids=["a floor", "a second line"],
)
def test_a_ground_that_is_drawn_twice_is_refused(tmp_path, more):
    """The ground is drawn as a line and as an outline. The slab below the line would be a hole in the
    outline."""
    message = refusal(drawing(tmp_path, [GROUND, more], layer="fixed"))
    assert "on layer 'fixed' is open near (-" in message


def test_a_line_without_blocks_is_no_support(tmp_path):
    assert "is open near" in refusal(drawing(tmp_path, [GROUND], [], layer="fixed"))


def test_a_drawing_without_movable_blocks_names_the_layers_that_were_not_read(tmp_path):
    """Stones that are drawn as hatches are not outlines."""
    path = drawing(tmp_path, [], [], layer="fixed")
    document = ezdxf.readfile(path)
    space = document.modelspace()
    space.add_lwpolyline([(-1, -1), (4, -1), (4, 0), (-1, 0)], close=True, dxfattribs={"layer": "fixed"})
    space.add_hatch(dxfattribs={"layer": "stones"}).paths.add_polyline_path(STACK[0], is_closed=True)
    document.saveas(path)
    message = refusal(path)
    assert message.startswith(f"{path}: every block is a support: draw the movable blocks as closed outlines")
    assert message.endswith("(layers of blocks: fixed; layers not read: stones (no outlines))")

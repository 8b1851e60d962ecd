"""The command `convert`: what it writes, and how it ends."""

import shlex

import ezdxf
import pytest
from meshes import box, obj
from scenes import WALLS, run_command

import masonry_opt as mo

NEEDED = ["--friction", "0.65", "--unit-weight", str(1 / 7)]


@pytest.fixture
def wall(tmp_path, monkeypatch, capsys):
    path = tmp_path / "wall.dxf"
    code, out, err = run_command(monkeypatch, capsys, "convert", WALLS[0], path)
    assert (code, err) == (0, "")
    assert "34 blocks (1 fixed)" in out
    return path


def test_a_drawing_becomes_a_case_file(wall, tmp_path, monkeypatch, capsys):
    for out in (tmp_path / "wall.toml", tmp_path / "wall_out.json"):
        code, told, err = run_command(monkeypatch, capsys, "convert", wall, out, *NEEDED, "--live", "1,0")
        assert (code, err) == (0, "")
        assert "83 joints" in told
        assert mo.solve(out, "static").required() == pytest.approx(0.64286, abs=5e-6)


def test_options_of_dxf(tmp_path, monkeypatch, capsys):
    """One stone of 4 m × 1 m drawn in millimetres; the other layers are not read."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = 4
    space = document.modelspace()
    stone = [(0, 0), (4000, 0), (4000, 1000), (0, 1000)]
    ground = [(-1000, -1000), (9000, -1000), (9000, 0), (-1000, 0)]
    for layer, ring in (("top", stone), ("rock", ground)):
        space.add_lwpolyline(ring, close=True, dxfattribs={"layer": layer})
    space.add_line((0, 0), (1, 1), dxfattribs={"layer": "axes"})
    document.saveas(tmp_path / "stone.dxf")
    options = shlex.split(
        "--friction 0.5 --unit-weight 20 --live-layer top=-0.5,0 --layer top --layer rock --fixed-layer rock "
        "--to-metres --tolerance 1e-5 --outline-tolerance 2e-5 --sagitta 0.01"
    )
    out = tmp_path / "stone.toml"
    code, _, err = run_command(monkeypatch, capsys, "convert", tmp_path / "stone.dxf", out, *options)
    assert (code, err) == (0, "")
    scene = mo.load(out)
    assert scene.tolerance == 1e-5
    assert scene.blocks[0].live_per_weight == (-0.5, 0.0)
    assert mo.solve(scene, "static").required() == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ([], "--friction"),
        (["--friction", "0.5"], "--unit-weight"),
        ([*NEEDED, "--live", "1;0"], "--live"),
        ([*NEEDED, "--live-layer", "blocks"], "--live-layer"),
        ([*NEEDED, "--along", "x"], "--along"),
        ([*NEEDED, "--fixed", "1-1"], "--fixed"),
        ([*NEEDED, "--layer", "gone"], "(--layer): nothing is drawn on 'gone'"),
        ([*NEEDED, "--live-layer", "gone=1,0"], "(--live-layer): no movable block is on 'gone'"),
        ([*NEEDED, "--fixed-layer", "rock"], "(--fixed-layer)"),
        ([*NEEDED, "--friction", "-1"], "'friction'"),
    ],
)
def test_wrong_options_are_named_and_nothing_is_written(wall, tmp_path, monkeypatch, capsys, options, named):
    out = tmp_path / "wall.toml"
    code, told, err = run_command(monkeypatch, capsys, "convert", wall, out, *options)
    assert (code, told) == (2, "")
    assert err.startswith("error: ")
    assert named in err
    assert not out.exists()


@pytest.mark.parametrize("name", ["case.toml", "case.json"])
@pytest.mark.parametrize("options", [[], NEEDED])
def test_a_case_file_given_for_a_drawing_is_told_what_can_be_done_with_it(
    tmp_path, monkeypatch, capsys, name, options
):
    case, out = tmp_path / name, tmp_path / "out.json"
    mo.save(mo.load(WALLS[0]), case)
    code, told, err = run_command(monkeypatch, capsys, "convert", case, out, *options)
    assert (code, told) == (2, "")
    assert f"masonry-opt solve {case}" in err
    assert ".dxf" in err
    assert not out.exists()


def test_a_drawing_with_a_thickness_becomes_solids(wall, tmp_path, monkeypatch, capsys):
    """The same load factor in its plane (the wall of Table 1, whose weights are unit weight times thickness),
    and blocks that can be pushed out of it."""
    out = tmp_path / "wall.toml"
    options = ["--friction", "0.65", "--unit-weight", "1", "--thickness", "0.5"]
    code, told, err = run_command(monkeypatch, capsys, "convert", wall, out, *options, "--live", "1,0")
    assert (code, err) == (0, "")
    assert "83 joints" in told
    solid = mo.load(out)
    assert solid.blocks[0].live_per_weight in ((1, 0, 0), (0, 0, 0))
    weight = sum(block.weight for block in solid.blocks if not block.fixed)
    assert weight == pytest.approx(0.5 * 6 * 5 * 4 * 1.75)  # six courses as long as five blocks
    run_command(monkeypatch, capsys, "convert", wall, out, *options, "--live", "0,1,0")
    assert mo.load(out).blocks[-1].live_per_weight in ((0, 1, 0), (0, 0, 0))


MESH = obj({"fixed": box((-1, 3), (-1, 2), (-1, 0)), "stone": box((0, 2), (0, 1), (0, 4))})


@pytest.mark.parametrize("beside", [False, True])
def test_a_mesh_becomes_a_case_file_that_holds_or_names_it(tmp_path, monkeypatch, capsys, beside):
    if beside:
        monkeypatch.setattr("masonry_opt.cli.files._MOST_CORNERS", 10)
    drawn, out = tmp_path / "stones" / "stone.obj", tmp_path / "stone.toml"
    drawn.parent.mkdir()
    drawn.write_bytes(MESH)
    options = shlex.split("--friction 0.9 --unit-weight 20 --live 1,0,0 --scale 0.5")
    code, told, err = run_command(monkeypatch, capsys, "convert", drawn, out, *options)
    assert (code, err) == (0, "")
    assert "1 joint" in told
    assert ('file = "stones/stone.obj"' in out.read_text()) == beside
    read = mo.read_mesh(drawn, friction=0.9, unit_weight=20, live=(1, 0, 0), scale=0.5)
    assert mo.load(out).blocks == read.blocks
    assert mo.solve(out, "static").required() == pytest.approx(2 / 4, rel=1e-6)
    drawn.unlink()
    if beside:
        with pytest.raises(mo.CaseError, match=r"stone\.obj: no such file"):
            mo.load(out)

"""The command line on a case in space."""

import json

import pytest
from scenes import CASES, run_command
from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.errors import OptionError


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "box.toml"
    mo.save(box_on_floor((2, 2, 1), 0.5), path)
    return path


def test_solve_tells_contact_points_and_law(monkeypatch, capsys, case):
    code, out, _ = run_command(monkeypatch, capsys, "solve", case, "--method", "static", "--verbose")
    assert code == 0
    assert "1 block, 1 joint, 4 contact points" in out
    assert "λ = 0.5000000" in out
    assert "by the cone" in out


def test_json_has_contact_points(monkeypatch, capsys, case):
    code, out, _ = run_command(monkeypatch, capsys, "solve", case, "--json")
    answer = json.loads(out)
    assert code == 0
    assert (answer["blocks"], answer["joints"], answer["size"]["contacts"]) == (1, 1, 4)
    assert sum(point["fz"] for point in answer["contact_results"]) == pytest.approx(1)
    assert {"vz", "wx"} <= set(answer["block_results"][0])


def test_check_agrees(monkeypatch, capsys, case):
    code, out, _ = run_command(monkeypatch, capsys, "check", case)
    assert code == 0
    assert "agree" in out


def test_a_curve_is_drawn(monkeypatch, capsys, case):
    asked = ("--method", "compliant", "-o", "curve=true", "--plot-kind", "curve", "--plot")
    code, out, _ = run_command(monkeypatch, capsys, "solve", case, *asked, case.with_suffix(".png"))
    assert code == 0
    assert "does not fall" in out
    assert case.with_suffix(".png").exists()
    assert run_command(monkeypatch, capsys, "solve", case, *asked, case.with_suffix(".html"))[0] == 0


def test_the_associative_reference_stands_beside_other_methods(monkeypatch, capsys, case):
    """Of a box, λ = μ = 0.5, 25 % above a reference of 0.4."""
    case.write_text(case.read_text() + '[reference]\nassociative = { value = 0.4, source = "none" }\n')
    for method in ("mcp", "static"):
        _, out, _ = run_command(monkeypatch, capsys, "solve", case, "--method", method)
        assert "0.4 (none), here +25.000 %" in out


@pytest.mark.parametrize(
    "arguments", [("solve", "--method", "static", "--plot"), ("draw",), ("export", "--method", "static")]
)
def test_pictures_pages_and_meshes_are_written(monkeypatch, capsys, case, arguments):
    command, *options = arguments
    name = case.with_suffix(".obj" if command == "export" else ".svg")
    view = () if command == "export" else ("--view=30,45",)
    given = (case, name, *options) if command == "export" else (case, *options, name, *view)
    assert run_command(monkeypatch, capsys, command, *given)[0] == 0
    text = name.read_text()
    assert "o fixed floor" in text if command == "export" else "<svg" in text


@pytest.mark.parametrize("view", ["30", "30,north", "30,91", "nan,0"])
@pytest.mark.parametrize("arguments", [("solve", "--plot"), ("draw",)])
def test_views_are_refused_before_anything_is_solved(monkeypatch, capsys, case, arguments, view):
    command, *options = arguments
    monkeypatch.setattr("masonry_opt.cli.solve.solve_scene", None)
    name = case.with_suffix(".png")
    code, _, said = run_command(monkeypatch, capsys, command, case, *options, name, f"--view={view}")
    assert code == OptionError.exit_code
    assert "view" in said
    assert not name.exists()


def test_a_plane_scene_has_no_view(monkeypatch, capsys, tmp_path):
    plane = CASES / "gilbert" / "two_blocks.toml"
    code, _, said = run_command(monkeypatch, capsys, "draw", plane, tmp_path / "a.png", "--view=30,45")
    assert code == OptionError.exit_code
    assert "plane" in said

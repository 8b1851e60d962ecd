"""Load cases and directions of earthquakes on the command line: what is printed, JSON, exit codes."""

import json

import pytest
from scenes import block_on_floor, run_command

import masonry_opt as mo

CASES = [
    {"name": "pushed", "live": {"live": 1.0}},
    {"name": "shaken", "earthquake": {"direction": "right", "coefficient": 2.0}},
]


@pytest.fixture
def path(tmp_path):
    """λ = 1/2 where it is pushed by its weight, half of that where it is shaken by twice."""
    plain = block_on_floor()
    mo.save(mo.Scene(joints=plain.joints, blocks=plain.blocks, load_cases=CASES), tmp_path / "case.toml")
    return tmp_path / "case.toml"


def test_all_are_solved_and_the_least_governs(monkeypatch, capsys, path):
    code, out, _ = run_command(monkeypatch, capsys, "solve", path, "--json", "--method", "static")
    answer = json.loads(out)
    assert code == 0
    assert answer["case"] == str(path)
    assert answer["governing"] == "shaken"
    assert answer["load_factor"] == pytest.approx(0.25)
    assert [one["load_case"] for one in answer["load_cases"]] == ["pushed", "shaken"]
    assert [one["load_factor"] for one in answer["load_cases"]] == pytest.approx([0.5, 0.25])
    code, out, _ = run_command(monkeypatch, capsys, "solve", path, "--quiet")
    assert (code, float(out)) == (0, pytest.approx(0.25))
    picture = path.with_name("governing.svg")
    code, out, _ = run_command(monkeypatch, capsys, "solve", path, "--plot", picture)
    assert code == 0
    assert "pushed" in out
    assert "'shaken' governs" in out
    assert picture.stat().st_size > 5000


def test_one_is_solved_by_its_name(monkeypatch, capsys, path):
    code, out, _ = run_command(monkeypatch, capsys, "solve", path, "--load-case", "pushed", "--json")
    answer = json.loads(out)
    assert (code, answer["load_case"], answer["load_factor"]) == (0, "pushed", pytest.approx(0.5))
    assert run_command(monkeypatch, capsys, "solve", path, "--load-case", "pulled")[0] == 2
    assert run_command(monkeypatch, capsys, "check", path, "--load-case", "pushed")[0] == 0
    for command in (("check", path), ("export", path, path.with_suffix(".mps")), ("compare", path)):
        code, _, err = run_command(monkeypatch, capsys, *command)
        assert code == 2
        assert "load cases" in err


def test_a_case_without_a_load_factor_ends_with_1(monkeypatch, capsys, path):
    of = mo.load(path)
    more = of.model_copy(
        update={"load_cases": [*of.load_cases, mo.LoadCase(name="down", live={"weight": 1})]}
    )
    mo.save(more, path)
    code, out, _ = run_command(monkeypatch, capsys, "solve", path, "--json", "--method", "static")
    answer = json.loads(out)
    assert (code, answer["governing"]) == (1, "shaken")
    assert answer["load_cases"][2]["load_factor"] is None


def test_directions(monkeypatch, capsys, path):
    picture = path.with_suffix(".png")
    code, out, _ = run_command(
        monkeypatch, capsys, "directions", path, "--load-case", "shaken", "--vertical=0,-0.5",
        "--method", "static", "--json", "--plot", picture,
    )  # fmt: skip
    answer = json.loads(out)
    assert code == 0
    rows = [(row["direction"], row["vertical"], row["load_factor"]) for row in answer["directions"]]
    assert [row[:2] for row in rows] == [("left", 0.0), ("right", 0.0), ("left", -0.5), ("right", -0.5)]
    assert [row[2] for row in rows] == pytest.approx([1 / 2, 1 / 2, 1 / 2.5, 1 / 2.5])
    assert answer["governing"] == "to the left, and 0.5 of that against gravity"
    assert picture.stat().st_size > 5000
    assert run_command(monkeypatch, capsys, "directions", path)[0] == 2
    assert run_command(monkeypatch, capsys, "directions", path, "--vertical=up")[0] == 2

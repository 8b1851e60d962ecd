"""Tests of load cases and directions of earthquakes on the command line: printed text, JSON and exit
codes."""

import pytest
from scenes import CASES as CASE_FILES
from scenes import block_on_floor

import masonry_opt as mo

CASES = [
    {"name": "pushed", "live": {"live": 1.0}},
    {"name": "shaken", "earthquake": {"direction": "right", "coefficient": 2.0}},
]


@pytest.fixture
def path(tmp_path):
    """Return a case file of a block: λ = 1/2 if its weight pushes it, 1/4 if an earthquake of coefficient
    2 does."""
    mo.save(block_on_floor().replace(load_cases=CASES), tmp_path / "case.toml")
    return tmp_path / "case.toml"


@pytest.mark.slow
def test_all_are_solved_and_the_least_governs(command, path):
    answer = command.json("solve", path, "--method", "static")
    assert answer["case"] == str(path)
    assert answer["governing"] == "shaken"
    assert answer["load_factor"] == pytest.approx(0.25)
    assert [one["load_case"] for one in answer["load_cases"]] == ["pushed", "shaken"]
    assert [one["load_factor"] for one in answer["load_cases"]] == pytest.approx([0.5, 0.25])
    assert float(command("solve", path, "--quiet")) == pytest.approx(0.25)
    picture = path.with_name("governing.svg")
    out = command("solve", path, "--plot", picture)
    assert "pushed" in out
    assert "'shaken' governs" in out
    assert picture.stat().st_size > 5000


def test_one_is_solved_by_its_name(command, path):
    answer = command.json("solve", path, "--load-case", "pushed")
    assert (answer["load_case"], answer["load_factor"]) == ("pushed", pytest.approx(0.5))
    command.refused("solve", path, "--load-case", "pulled")
    command("check", path, "--load-case", "pushed")
    for asked in (("check", path), ("export", path, path.with_suffix(".mps")), ("compare", path)):
        assert "load cases" in command.refused(*asked)


def test_a_case_without_a_load_factor_ends_with_1(command, path):
    of = mo.load(path)
    mo.save(of.replace(load_cases=[*of.load_cases, {"name": "down", "live": {"weight": 1}}]), path)
    answer = command.json("solve", path, "--method", "static", code=1)
    assert answer["governing"] == "shaken"
    assert answer["load_cases"][2]["load_factor"] is None


def test_directions(command, path):
    picture = path.with_suffix(".png")
    asked = ("--load-case", "shaken", "--vertical=0,-0.5", "--method", "static", "--plot", picture)
    answer = command.json("directions", path, *asked)
    rows = [(row["direction"], row["vertical"], row["load_factor"]) for row in answer["directions"]]
    assert [row[:2] for row in rows] == [("left", 0.0), ("right", 0.0), ("left", -0.5), ("right", -0.5)]
    assert [row[2] for row in rows] == pytest.approx([1 / 2, 1 / 2, 1 / 2.5, 1 / 2.5])
    assert answer["governing"] == "to the left, and 0.5 of that against gravity"
    assert picture.stat().st_size > 5000
    table = command("directions", path, *asked[:-2])
    assert "\n direction   vertical / horizontal" in table  # the directions are "left" and "right"
    command.refused("directions", path)
    command.refused("directions", path, "--vertical=up")


def test_reference_values_are_not_compared_with_load_factors_of_other_loads(command):
    """The reference value of a case belongs to its own live load, not to an earthquake or a load case."""
    case = CASE_FILES / "gilbert" / "two_blocks.toml"
    assert "\nreference " in command("solve", case, "--method", "static")
    assert "\nreference " not in command("directions", case, "--method", "static")
    in_case = mo.load(case).replace(load_cases=[{"name": "a", "live": {"live": 0.5}}])
    assert "reference" not in mo.solve(in_case, "static", load_case="a").summary

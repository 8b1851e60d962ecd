"""The page for solver people: its example runs, its numbers are those of the registry and of the scenes."""

import contextlib
import io
import re
import tomllib
from pathlib import Path

import pytest
from scenes import CASES

import masonry_opt as mo
from masonry_opt.exports.export import EPSILON
from masonry_opt.problem.assembly import assemble

PAGE = (Path(__file__).parents[2] / "docs" / "solver_people.md").read_text("utf-8")
MEASURED = Path(__file__).parents[2] / "benchmarks" / "README.md"
BEST_KNOWN = re.search(r"<!-- best known -->\n(.*?)<!-- /", MEASURED.read_text("utf-8"), re.DOTALL)[1]


@pytest.mark.parametrize("example", re.findall(r"^```python\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE))
def test_an_example_finds_the_published_load_factor(example, tmp_path, monkeypatch):
    (tmp_path / "cases").symlink_to(CASES)
    monkeypatch.chdir(tmp_path)
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(example, "solver_people.md", "exec"), {})
    assert out.getvalue() == "0.64286\n"


def test_best_known_values_are_those_of_the_registry():
    """Each case of it with its size, and no other (``refresh_solver_people.py`` writes them)."""
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in BEST_KNOWN.splitlines()[2:]]
    told = {name.strip("`"): cells for name, *cells in rows}
    entries = tomllib.loads((CASES / "best_known.toml").read_text("utf-8"))
    expected = {name: entry for name, entry in entries.items() if (CASES / name).is_file()}
    assert [f"{name}.toml" for name in told] == list(expected)
    for name, (blocks, joints, faces, load_factor, method) in told.items():
        entry, problem = expected[f"{name}.toml"], assemble(mo.load(CASES / f"{name}.toml")).problem
        assert [int(blocks), int(joints), int(faces)] == [problem.blocks, problem.joints, problem.faces]
        assert float(load_factor) == pytest.approx(entry["load_factor"], rel=1e-8)
        assert method == entry["method"]


def test_epsilon_is_the_one_told():
    assert EPSILON == 1e-6
    assert "ε = 10⁻⁶" in PAGE


def test_links_lead_to_programs_that_are_there():
    declared = re.findall(r"`(pyomo_\w+\.py)`", PAGE)
    assert declared
    for name in declared:
        assert (Path(__file__).parents[2] / "models" / name).is_file(), name

"""Tests of README and the page for solver people: examples run, links exist, and numbers equal the
registry's."""

import contextlib
import io
import re
from pathlib import Path

import pytest
from report.refresh_solver_people import table
from scenes import CASES

import masonry_opt as mo
from masonry_opt.exports.programs import EPSILON

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)


def test_python_example_prints_what_stands_below_it():
    (example,) = blocks("python")
    (printed,) = blocks("text")
    assert len(example.splitlines()) <= 10
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(example, "README.md", "exec"), {})
    assert out.getvalue() == printed


def test_what_the_command_says_is_what_it_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    said = README.split("and the blocks and joints that move:\n\n")[1].split("\n\n")[0]
    assert str(mo.solve("cases/gilbert/two_blocks.toml")) == "\n".join(
        line.removeprefix("    ") for line in said.splitlines()
    )


@pytest.mark.parametrize("number", [0, 1], ids=["wall", "blocks"])
def test_case_files_with_a_live_load_have_the_load_factors_shown(number, tmp_path):
    """The text before or after a case file states its load factor."""
    case = blocks("toml")[number]
    path = tmp_path / "case.toml"
    path.write_text(case, "utf-8")
    shown = re.findall(r"λ = (0\.\d+)\.\n$", README.partition(f"\n```toml\n{case}")[0])
    assert [f"{mo.solve(path, incremental=False).load_factor:.3g}"] == shown


def test_the_arch_without_live_load_is_answered_as_shown(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    Path("arch.toml").write_text(blocks("toml")[2], "utf-8")
    shown = README.split("(docs/stability.md) explains:\n\n")[1].split("\n\n")[0]
    lines = [line.removeprefix("    ") for line in shown.splitlines()]
    assert str(mo.solve("arch.toml")) == "\n".join(lines)


def test_pictures_and_pages_exist():
    linked = [link for link in re.findall(r"\]\(([^)]+)\)", README) if "://" not in link]
    assert linked
    for link in linked:
        assert (ROOT / link).exists(), link


PAGE = (Path(__file__).parents[2] / "docs" / "solver_people.md").read_text("utf-8")
MEASURED = Path(__file__).parents[2] / "benchmarks" / "README.md"
BEST_KNOWN = re.search(r"<!-- best known -->\n(.*?)<!-- /", MEASURED.read_text("utf-8"), re.DOTALL)[1]


EXAMPLES = re.findall(r"^```python\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)


def printed_by(example, folder, monkeypatch):
    """Return the standard output of an example of the page, run in a folder with the cases."""
    (folder / "cases").symlink_to(CASES)
    monkeypatch.chdir(folder)
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(example, "solver_people.md", "exec"), {})
    return out.getvalue()


@pytest.mark.parametrize("example", EXAMPLES[:-1])
def test_an_example_finds_the_published_load_factor(example, tmp_path, monkeypatch):
    assert printed_by(example, tmp_path, monkeypatch) == "0.64286\n"


def test_the_example_certifies_as_the_page_shows(tmp_path, monkeypatch):
    """The example prints the lines that the page shows, except for residuals, which are rounding errors."""
    (shown,) = re.findall(r"^```text\n(λ = .*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    first, last = (part.splitlines() for part in shown.split("...\n"))
    printed = printed_by(EXAMPLES[-1], tmp_path, monkeypatch).splitlines()
    assert printed[:3] == first[:3]
    assert printed[-2:] == last


@pytest.mark.slow
def test_best_known_values_are_those_of_the_registry():
    """The table is the one that ``refresh_solver_people.py`` writes: all of its cases with their sizes,
    and no other."""
    assert table(CASES) == BEST_KNOWN


def test_epsilon_is_the_one_told_and_links_lead_to_programs_that_are_there():
    assert EPSILON == 1e-6
    assert "ε = 10⁻⁶" in PAGE
    declared = re.findall(r"`(pyomo_\w+\.py)`", PAGE)
    assert declared
    for name in declared:
        assert (Path(__file__).parents[2] / "models" / name).is_file(), name

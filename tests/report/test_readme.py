"""The README: its example does what it says, its links lead somewhere, and it stays short."""

import contextlib
import io
import re
from pathlib import Path

import masonry_opt as mo

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)


def test_python_example_prints_what_stands_below_it():
    (example,) = blocks("python")
    (printed,) = blocks("text")
    assert len(example.splitlines()) <= 10
    assert len(README.splitlines()) <= 90
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(example, "README.md", "exec"), {})
    assert out.getvalue() == printed


def test_what_the_command_says_is_what_it_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    said = README.split("plain words what moves and at what load:\n\n")[1].split("\n\n")[0]
    assert str(mo.solve("cases/gilbert/two_blocks.toml")) == "\n".join(
        line.removeprefix("    ") for line in said.splitlines()
    )


def test_pictures_and_pages_exist():
    linked = [link for link in re.findall(r"\]\(([^)]+)\)", README) if "://" not in link]
    assert linked
    for link in linked:
        assert (ROOT / link).exists(), link

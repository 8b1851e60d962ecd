"""Commands write nothing but lines of progress to standard error, and leave no file open."""

import re
import subprocess
import sys

import pytest
from forks import in_forks
from scenes import CASES, axles_on_a_beam, block_on_floor

import masonry_opt as mo
from masonry_opt.cli import app

SMALL = str(CASES / "gilbert" / "two_blocks.toml")
#: Options of Python under which a file that is left open is reported on standard error.
STRICT = ("-W", "error", "-X", "dev")
#: Arguments of each command except "solve", and of the option --version.
COMMANDS = f"""
--version
check {SMALL}
draw {SMALL} picture.png
export {SMALL} program.lp
capacity block.toml --method static --plot curve.png
directions block.toml --method static
settle block.toml --support floor --direction 0,-1 --method static --plot page.html
least block.toml --vary block.A.weight=1:9 --load 1 --method static --samples 0
crossing axles.toml --method static --plot crossing.svg
report axles.toml --method static --out report.html
reproduce fig8 --out published
sweep block.toml --vary joints.friction=0.3,0.4 --method static --workers 2 --out swept
compare block.toml --methods static --models cvxpy --solvers highs --tolerances 1e-9 --out compared
convert block.toml drawing.dxf
"""
#: Line that some commands write every ten seconds.
PROGRESS = r"\d+ s: .*"
#: Lines of progress and of written files, by command. All other commands leave standard error empty.
LINES = dict.fromkeys(("capacity", "crossing", "directions", "least", "settle"), PROGRESS) | {
    "report": rf"{PROGRESS}|report: (crossing|page) \.\.\.",
    "reproduce": r"fig8: (.* \.\.\.|[\d.]+ s, written to published)",
    "sweep": "written: swept/.*",
    "compare": rf"{PROGRESS}|written: compared/.*",
}
#: Lines of Python after which each command leaves a file open, as the attribute of a class.
LEAVES_A_FILE_OPEN = """
class Document:
    pass

run_command = main

def main():
    Document.file = open(sys.executable, "rb")
    return run_command()
"""


def test_a_command_ends_without_a_word_on_standard_error(tmp_path):
    """No file is left open: Python would report it when it exits, where no exception can be raised."""
    run = "from masonry_opt.cli import main; main()"
    command = [sys.executable, *STRICT, "-c", run, "solve", SMALL, "--json"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout


@pytest.mark.slow
def test_all_other_commands_write_only_progress_to_standard_error(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mo.save(block_on_floor(), "block.toml")
    mo.save(axles_on_a_beam(0.6), "axles.toml")
    commands = {line.split()[0]: line.split() for line in COMMANDS.strip().splitlines()}
    assert commands.keys() - {"--version"} == app.COMMANDS.keys() - {"solve"}
    imported = ("masonry_opt.analysis", "masonry_opt.drawing.figure", "cvxpy", "pyomo.environ")
    for name, (code, out, error) in in_forks(commands, tmp_path, imported, options=STRICT).items():
        assert code == 0, (name, error)
        assert out, name
        expected = re.compile(LINES.get(name, "(?!)"))
        assert [line for line in error.splitlines() if not expected.fullmatch(line)] == [], name


@pytest.mark.slow
def test_a_file_that_a_command_leaves_open_is_reported(tmp_path):
    """Python reports the file at the exit of a fork, so that the test of all other commands would fail."""
    commands = {"version": ["--version"]}
    ended = in_forks(commands, tmp_path, ["masonry_opt"], options=STRICT, before=LEAVES_A_FILE_OPEN)
    assert "ResourceWarning: unclosed file" in ended["version"][2]

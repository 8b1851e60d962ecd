"""Commands write no warning of Python or NumPy to standard error, and leave no file open."""

import re
import subprocess
import sys

import pytest
from scenes import CASES, axles_on_a_beam, block_on_floor

import masonry_opt as mo

SMALL = str(CASES / "gilbert" / "two_blocks.toml")
#: Each command starts Python anew, which takes seconds: most of these tests are slow.
ENDING = {
    "version": ["--version"],
    "solve": ["solve", SMALL, "--json"],
    "check": ["check", SMALL],
    "draw": ["draw", SMALL, "picture.png"],
    "export": ["export", SMALL, "program.lp"],
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == "solve" else pytest.mark.slow) for name in ENDING]
)
def test_a_command_ends_without_a_word_on_standard_error(tmp_path, name):
    """No file is left open: Python would report it when it exits, where no exception can be raised."""
    run = "from masonry_opt.cli import main; main()"
    command = [sys.executable, "-W", "error", "-X", "dev", "-c", run, *ENDING[name]]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout


#: Commands that run in one process, because starting Python for each of them would take long.
TOGETHER = """
capacity block.toml --method static --plot curve.png
directions block.toml --method static
settle block.toml --support floor --direction 0,-1 --method static --plot page.html
least block.toml --vary block.A.weight=1:9 --load 1 --method static --samples 0
crossing axles.toml --method static --plot crossing.svg
report axles.toml --method static --out report.html
sweep block.toml --vary joints.friction=0.3,0.4 --method static --workers 2 --out swept
compare block.toml --methods static --models cvxpy --solvers highs --tolerances 1e-9 --out compared
convert block.toml drawing.dxf
"""


@pytest.mark.slow
def test_all_commands_end_without_a_word_on_standard_error(tmp_path):
    """Standard error contains only lines of progress and of written files: no warning of Python or NumPy."""
    mo.save(block_on_floor(), tmp_path / "block.toml")
    mo.save(axles_on_a_beam(0.6), tmp_path / "axles.toml")
    run = """
import io, sys
from contextlib import redirect_stdout
from masonry_opt.cli import main
if __name__ == "__main__":
    for line in sys.argv[1].strip().splitlines():
        sys.argv = ["masonry-opt", *line.split()]
        with redirect_stdout(io.StringIO()):
            try:
                main()
            except SystemExit as end:
                if end.code:
                    sys.exit(f"{line}: {end.code}")
"""
    (tmp_path / "run.py").write_text(run)
    command = [sys.executable, "-W", "error", "-X", "dev", "run.py", TOGETHER]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    known = re.compile(r"written: |report: |\d+ s: ")
    assert [line for line in ended.stderr.splitlines() if not known.match(line)] == []

"""Tests of Ctrl-C: a command ends in one line and exit code 130, or in the lowest state of a search."""

import signal
import subprocess
import sys
from importlib import import_module

import pytest
from scenes import CASES

from masonry_opt.solvers.cvxpy_engine import CvxpyEngine

WALL_1 = CASES / "ferris_tinloi" / "wall_1.toml"


@pytest.mark.parametrize("swallowed", [False, True])
@pytest.mark.parametrize(
    ("method", "program", "words"),
    [("static", 1, "no load factor was found"), ("nonassociative", 4, "iteration 2: λ = 0.6")],
)
def test_ctrl_c_ends_with_what_is_known(watched, press_ctrl_c, command, method, program, words, swallowed):
    """The solver is interrupted while it runs, and may swallow the interrupt."""

    def interrupted(*_):
        if len(solved) == program:
            press_ctrl_c(swallowed)

    solved = watched(CvxpyEngine, "solve", interrupted)
    message = command.refused("solve", WALL_1, "--method", method, "--no-incremental", code=130)
    assert message.startswith("error: interrupted")
    assert words in message
    assert message.count("\n") == 1
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_in_other_commands(watched, press_ctrl_c, command):
    watched(CvxpyEngine, "solve", lambda _: press_ctrl_c())
    message = command.refused("check", WALL_1, code=130)
    assert message == "error: interrupted: nothing was found\n"


@pytest.mark.slow
def test_ctrl_c_ends_a_search_with_the_lowest_state_so_far(watched, press_ctrl_c, command):
    def interrupted(step):
        if getattr(step, "origin", "start") != "start":
            press_ctrl_c()

    watched(import_module("masonry_opt.cli.command"), "residuals_of_step", interrupted)
    wall_5 = CASES / "ferris_tinloi" / "wall_5.toml"
    answer = command.json("solve", wall_5, "--method", "coulomb", "-o", "search=60")
    assert answer["load_factor"] < 0.2138
    (searched,) = [said for said in answer["reasons"] if said["code"] == "searched"]
    assert searched["interrupted"]


#: A command that is interrupted 0.2 s after IPOPT has started a solve, which takes longer on wall 6.
IN_IPOPT = """
import os, signal, sys, threading
from masonry_opt import cli
from masonry_opt.methods.mpec import CasadiIpopt

solve = CasadiIpopt.solve
signal.signal(signal.SIGINT, signal.default_int_handler)  # a parent in the background ignores it

def interrupted(self, epsilon):
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    return solve(self, epsilon)

CasadiIpopt.solve = interrupted
sys.argv = ["masonry-opt", "solve", sys.argv[1], "--method", "mpec", "--no-incremental"]
cli.main()
"""


@pytest.mark.slow
def test_ctrl_c_in_ipopt_ends_with_what_is_known():
    wall_6 = CASES / "ferris_tinloi" / "wall_6.toml"
    command = [sys.executable, "-c", IN_IPOPT, str(wall_6)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert ended.returncode == 130, ended.stderr
    assert ended.stdout == ""
    assert "Traceback" not in ended.stderr
    # If IPOPT had begun, CasADi prints a line that it was stopped.
    last = ended.stderr.splitlines()[-1]
    assert last.startswith("error: interrupted: the last step was iteration ")
    assert last.endswith("not the collapse load factor; no file was written")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("library", "words"),
    [
        ("scipy", ""),
        ("highspy", ": no load factor was found; no file was written"),
    ],
)
def test_ctrl_c_while_the_libraries_load_is_a_message(library, words):
    """Libraries take seconds to load, both for the command and for the solve; an interrupt may come at any
    time."""
    program = f"""
import sys
class Interrupted:
    def find_spec(self, name, *_):
        if name == "{library}":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupted())
from masonry_opt.cli import main
main()
"""
    command = [sys.executable, "-c", program, "solve", str(WALL_1)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", f"error: interrupted{words}\n")

"""The phases that an analysis reports through ``phases`` as they begin, and that a terminal shows."""

from contextlib import contextmanager, redirect_stderr
from importlib import import_module

import pytest
from rich.progress import Progress
from scenes import CASES, WALLS, axles_on_a_beam, block_on_floor, small_wall
from screens import Screen

import masonry_opt as mo
from masonry_opt.errors import OptionError
from masonry_opt.reporting.terminal import residuals_of_step

TWO_BLOCKS = CASES / "gilbert" / "two_blocks.toml"
FIRST = ["reading blocks", "finding joints", "stability under the dead load"]


def phases_of(scene, method, **options):
    phases = []
    return mo.solve(scene, method, phases=phases.append, **options), phases


def test_each_sub_problem_is_told_before_it_is_solved():
    """Each sub-problem is reported before it is solved, and the last phase is the one of the exact forces."""
    order = []
    mo.solve(
        WALLS[0], "nonassociative", phases=order.append, progress=lambda step: order.append(step.iteration)
    )
    count = max(entry for entry in order if isinstance(entry, int))
    assert count > 3
    for number in range(1, count + 1):
        assert order.index(f"sub-problem {number}") + 1 == order.index(number)
    assert order[-1] == "exact forces"


def test_a_load_history_and_what_follows_it():
    assert phases_of(WALLS[0], "coulomb")[1] == [
        *FIRST,
        "incremental analysis",
        "method 'coulomb'",
        "incremental analysis",
        "exact state from the incremental forces",
        "exact state from the incremental forces: lower states, start 1",
        "exact state from the incremental forces: lower states, start 1, lowest λ so far 0.638982",
        "associative load factor, lowest λ so far 0.638982",
    ]


def test_an_interrupt_between_steps_goes_through():
    def interrupt(phase):
        if phase == "exact forces":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mo.solve(small_wall(), "nonassociative", phases=interrupt)


def test_phases_are_a_function():
    with pytest.raises(OptionError, match="phases"):
        mo.solve(block_on_floor(), phases="all")


def test_a_terminal_shows_phases_and_steps_and_output_stays_clean(watched, command, terminal):
    """A terminal shows each phase and each step, and standard output does not change.

    At each update of :class:`~rich.progress.Progress` the test waits until the terminal shows the text.
    """
    screen, shown = Screen(terminal=True), []
    asked = ("solve", TWO_BLOCKS, "--method", "nonassociative")
    before = command(*asked)

    def wait(*_, **line):
        shown.append(line["description"])
        assert screen.shows(shown[-1])

    watched(Progress, "update", wait)
    steps = watched(import_module("masonry_opt.cli.command"), "residuals_of_step")
    with redirect_stderr(screen):
        out = command(*asked)
    phases = {*FIRST, "sub-problem 1", "sub-problem 2", "exact forces"}
    assert all(any(phase in line for line in shown) for phase in phases)
    lines = [f"λ = {step.load_factor:.6f}{residuals_of_step(step)}" for (step,) in steps]
    for number, line in enumerate(lines, 1):
        assert f"two_blocks.toml: sub-problem {number}: iteration {number}: {line}" in shown
    assert out == before


@pytest.mark.usefixtures("terminal")
@pytest.mark.parametrize("how", [(), ("--quiet",)])
def test_nothing_is_shown_in_a_pipe_or_quietly(command, how):
    screen = Screen(terminal=bool(how))
    with redirect_stderr(screen):
        command("solve", TWO_BLOCKS, *how)
    assert screen.getvalue() == ""


ONE_PAIR = ("--models", "cvxpy", "--solvers", "highs", "--tolerances", "1e-9")
#: Arguments of commands that may take long, and a part of a line that each command shows.
LONG = {
    "capacity": (("case.toml",), "incremental analysis: load step 1"),
    "check": (("case.toml",), "comparing the static with the kinematic formulation"),
    "compare": (("case.toml", "--out", "out", "--repeats", "1", "--methods", "static", *ONE_PAIR), "static"),
    "crossing": (("axles.toml", "--method", "static"), "crossing: first axle at"),
    "directions": (("case.toml",), "directions: to the right: method 'coulomb'"),
    "export": (("solid.toml", "a.obj", "--method", "static"), "export: method 'static'"),
    "least": (("case.toml", "--vary", "joints.friction=0.1:0.4", "--load", "0.3"), "holds"),
    "settle": (("case.toml", "--support", "floor", "--direction", "0,-1"), "settle: reaction at rest"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LONG)
def test_commands_that_take_long_say_what_they_do(command, monkeypatch, tmp_path, name):
    """Commands that may take long show their phases on the changing line of a terminal, here a list."""
    monkeypatch.chdir(tmp_path)
    mo.save(block_on_floor(), "case.toml")
    mo.save(axles_on_a_beam(0.6), "axles.toml")
    mo.save(mo.extrude(block_on_floor(), 1.0), "solid.toml")
    shown = []

    @contextmanager
    def line_of(_, line):
        shown.append(line)
        yield shown.append

    monkeypatch.setattr(import_module("masonry_opt.cli.command"), "changing_line", line_of)
    arguments, words = LONG[name]
    command(name, *arguments, code=None)
    assert any(words in line for line in shown), shown


def test_further_starts_are_counted():
    """The search for lower states of two blocks takes several starts, and reports each start as it begins."""
    phases = phases_of(TWO_BLOCKS, "coulomb")[1]
    assert any("lower states, start 1" in phase for phase in phases)
    assert any("further starts: lower states, start 2" in phase for phase in phases)

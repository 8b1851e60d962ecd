"""What an analysis tells of its phases as they begin, before and between its steps."""

import io
import sys
import time

import pytest
from scenes import CASES, WALLS, block_on_floor, small_wall

import masonry_opt as mo
from masonry_opt.errors import OptionError
from masonry_opt.words.terminal import left_by

TWO_BLOCKS = CASES / "gilbert" / "two_blocks.toml"
FIRST = ["reading blocks", "finding joints", "does it stand under its dead load?"]


def phases_of(scene, method, **options):
    told = []
    return mo.solve(scene, method, phases=told.append, **options), told


def test_each_sub_problem_is_told_before_it_is_solved():
    """And those that its exact forces take, where it ends in them."""
    order = []
    mo.solve(
        WALLS[0], "nonassociative", phases=order.append, progress=lambda step: order.append(step.iteration)
    )
    count = max(entry for entry in order if isinstance(entry, int))
    assert count > 3
    for number in range(1, count + 1):
        assert order.index(f"sub-problem {number}") + 1 == order.index(number)
    assert order[-1] == "exact forces"


def test_a_push_and_what_follows_it():
    assert phases_of(WALLS[0], "mcp")[1] == [
        *FIRST,
        "load to expect",
        "pushed from rest",
        "method 'mcp'",
        "exact states nearby",
        "associative load factor",
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


class Screen(io.StringIO):
    """A stream that is a terminal, or is none, and tells when a text has been written to it."""

    encoding = "utf-8"

    def __init__(self, terminal):
        super().__init__()
        self.isatty = lambda: terminal

    def shows(self, text, seconds=20.0):
        end = time.monotonic() + seconds
        while text not in self.getvalue() and time.monotonic() < end:
            time.sleep(0.001)
        return text in self.getvalue()


@pytest.fixture
def environment(monkeypatch):
    for name in ("NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "150")


def test_a_terminal_shows_phases_and_steps_and_output_stays_clean(monkeypatch, command, environment):
    """It is waited for at each of them."""
    screen, seen = Screen(terminal=True), []

    def watched(*arguments, phases, progress, **options):
        def begun(phase):
            phases(phase)
            seen.append((phase, screen.shows(phase)))

        def follow(step):
            progress(step)
            line = f"λ = {step.load_factor:.6f}{left_by(step)}"
            seen.append((line, screen.shows(line)))

        return mo.solve(*arguments, phases=begun, progress=follow, **options)

    asked = ("solve", TWO_BLOCKS, "--method", "nonassociative", "--json")
    before = command(*asked)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr("masonry_opt.cli.solve.solve_scene", watched)
    out = command(*asked)
    assert all(shown for _, shown in seen)
    assert {text for text, _ in seen} >= {*FIRST, "sub-problem 1", "sub-problem 2", "exact forces"}
    assert "two_blocks.toml" in screen.getvalue()
    assert out.startswith("{")
    assert out.count("\n") == before.count("\n")


@pytest.mark.parametrize(("terminal", "how"), [(False, ()), (True, ("--quiet",))])
def test_nothing_is_shown_in_a_pipe_or_quietly(monkeypatch, command, environment, terminal, how):
    screen = Screen(terminal)
    monkeypatch.setattr(sys, "stderr", screen)
    command("solve", TWO_BLOCKS, *how)
    assert screen.getvalue() == ""

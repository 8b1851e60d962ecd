"""Tests that commands have the options of their functions, as signatures and docstrings define them."""

import gc
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
import typer
from scenes import run_command
from typer.testing import CliRunner

import masonry_opt as mo
from masonry_opt.cli.app import COMMANDS, load
from masonry_opt.cli.command import CommandArguments, command, reader
from masonry_opt.errors import OptionError


def study(  # noqa: PLR0913 - options of every kind
    scene: str,
    ratio: float = 1.5,
    *,
    count: int | None = None,
    deep: bool = False,
    incremental: bool = True,
    layers: Sequence[str] = (),
    live_layers: Mapping[str, float] | None = None,
    place: Sequence[float] = (1.0, 2.0),
    out: str | Path = Path("here"),
    progress: object = lambda _: None,
    **options: object,
) -> None:
    """Study a scene.

    Parameters
    ----------
    ratio: of ``width`` to height, see :func:`~masonry_opt.analysis.solve`. Whatever else it is.
    count, deep:
        How many there
        are. Not which.
    incremental: as of :func:`~masonry_opt.analysis.solve`.
    """


def two(text):
    x, y = map(float, text.split(","))
    return x, y


def run(*texts):
    """Return the result of a command of `study`, and the arguments with which the function would be
    called."""
    called = {}

    @command(
        study,
        live_layers=typer.Option(parser=lambda text: tuple(text.split("="))),
        place=typer.Option(parser=reader(two, "{}: write two numbers")),
    )
    def asked(arguments: CommandArguments, case: Path) -> None:
        """Exit code 0."""
        called.update(arguments.keywords_for(study), case=case)

    return CliRunner().invoke(asked, [*texts], env={"COLUMNS": "200"}), called


def test_what_was_typed_is_passed_on_and_nothing_else():
    given = {"case": Path("a.toml")}
    assert run("a.toml")[1] == given
    typed = "--ratio 1.5 --count 3 --deep --no-incremental --layer a --layer b --live-layer a=1 --out there"
    assert run("a.toml", *typed.split(), "--place", "3,4", "-o", "beta=.5")[1] == given | {
        "ratio": 1.5,
        "count": 3,
        "deep": True,
        "incremental": False,
        "layers": ["a", "b"],
        "live_layers": [("a", "1")],
        "out": Path("there"),
        "place": (3.0, 4.0),
        "beta": 0.5,
    }


@pytest.mark.parametrize("wrong", [("--place", "3"), ("--place", "3,x"), ("-o", "beta"), ("-o", "ratio=1")])
def test_texts_that_cannot_be_read_are_named(wrong):
    outcome, _ = run("a.toml", *wrong)
    assert isinstance(outcome.exception, OptionError)
    assert wrong[1].partition("=")[0] in str(outcome.exception)


@pytest.mark.parametrize("wrong", [(), ("--count", "x"), ("--no-deep",), ("--progress", "x")])
def test_what_the_signature_does_not_take_is_refused(wrong):
    assert run(*(("a.toml", *wrong) if wrong else ()))[0].exit_code == 2


def test_help_is_the_first_sentence_of_the_docstring_and_the_default_the_functions():
    output = run("--help")[0].stdout
    words = ("Of width to height, see solve.", "1.5", "How many there are.", "here", "1.0, 2.0", "Coulomb")
    assert all(word in output for word in words)
    assert not any(words in output for words in ("Whatever", "Not which", "progress", "scene"))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_of_every_command_says_what_it_is(name):
    found = load(name)
    assert found.help.startswith(COMMANDS[name])
    assert all(option.help for option in found.params)


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_of_commands_does_not_refer_to_classes(name):
    """Users of the command line do not know the classes of the Python interface."""
    texts = [option.help for option in load(name).params]
    within_sentences = {word for text in texts for word in re.findall(r"(?<=[a-z,;] )[A-Z]\w+", text)}
    assert within_sentences.isdisjoint(mo.__all__)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_into_eighty_columns_with_no_word_cut(name, monkeypatch, capsys):
    """No word is cut: Rich cuts words that are wider than their column, and marks the cut by dots."""
    monkeypatch.setattr("typer.rich_utils.MAX_WIDTH", 80)
    exit_code, output, _ = run_command(monkeypatch, capsys, name, "--help")
    assert exit_code == 0
    assert "--help" in output
    assert "…" not in output
    assert max(map(len, output.splitlines())) <= 80
    # Texts have at least a third of the width: a flag that is set by default shows its negated name only.
    assert "--incremental" not in output
    (line,) = [line for line in output.splitlines() if "--help " in line]
    assert line.index("Show this message") <= 53


@pytest.mark.parametrize("was_enabled", [True, False])
def test_loading_a_command_leaves_the_garbage_collector_as_it_was(was_enabled):
    """A program that imports the command line decides itself if garbage is collected, and which objects."""
    enabled, frozen = gc.isenabled(), gc.get_freeze_count()
    try:
        if not was_enabled:
            gc.disable()
        load("solve")
        assert gc.isenabled() == was_enabled
        assert gc.get_freeze_count() == frozen
    finally:
        if enabled:
            gc.enable()

"""Command line: results on standard output, everything else on standard error."""

import contextlib
import os
import sys
from collections.abc import Iterator
from importlib import import_module
from importlib.metadata import version as package_version
from io import TextIOWrapper
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperCommand, TyperGroup

from masonry_opt.errors import InterruptedByUserError, MasonryError, OptionError, OutputError, ReaderGoneError
from masonry_opt.reporting.terminal import print_text, results_alone

#: Module of each command whose module has another name than the command. A module is loaded when its command
#: runs.
_MODULES = {"check": "solve", "compare": "many", "sweep": "many"}
_MODULES |= dict.fromkeys(("convert", "draw", "export"), "files")
_MODULES |= dict.fromkeys(("capacity", "crossing", "directions", "least", "report", "settle"), "studies")

#: Help text of each command, in the order in which ``--help`` lists the commands.
COMMANDS = {
    "solve": "Find the load factor at which CASE collapses, for all its load cases or for a named one.",
    "check": "Cross-check the static and kinematic formulations, and CVXPY against Pyomo.",
    "draw": "Draw CASE to FILE without solving it: blocks, supports, joints, small gaps, loads.",
    "export": "Write CASE to FILE as an optimisation program for other solvers, or as solids for other "
    "programs.",
    "capacity": "Follow the mechanism of CASE after the onset of collapse, down to λ = 0.",
    "convert": "Make a case file from a drawing: blocks, supports, friction, weights, live loads.",
    "compare": "Time methods and solvers on scenes, check their answers, write tables, charts and a report.",
    "directions": "Find the seismic coefficient at which CASE collapses, for earthquakes from all sides.",
    "crossing": "Move the axles of CASE over its road, and find the position with the least load factor.",
    "least": "Find the least value of a number of CASE at which CASE is stable, or carries a load.",
    "report": "Write one page on CASE: its inputs, its results, and checks made and not made.",
    "reproduce": "Recompute results of the paper from the case files in cases/, or else in the package.",
    "settle": "Find the least and the greatest reaction of a support of CASE, in one direction, with which "
    "CASE is stable.",
    "sweep": "Solve CASE for every combination of values of its numbers, or for values drawn from "
    "distributions.",
}

#: Current names of renamed options, by their former names.
FORMER_OPTIONS = {"--expected": "--incremental", "--no-expected": "--no-incremental"}


class _Commands(TyperGroup):
    """Group of commands; the module of a command is loaded only when the command is called."""

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        self.commands = {name: TyperCommand(name, help=does) for name, does in COMMANDS.items()}

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the name of a command, the loaded command, and the remaining arguments.

        Raises OptionError if an option has the name that it had in former versions.
        """
        name, _, others = super().resolve_command(ctx, args)
        for option in others:
            if option in FORMER_OPTIONS:
                raise OptionError(f"option '{option}' is now called '{FORMER_OPTIONS[option]}'")
        return name, load(str(name)), others


def load(name: str) -> Any:
    """Load and return a command with all its options."""
    try:
        module = import_module(f"masonry_opt.cli.{_MODULES.get(name, name)}")
    except KeyboardInterrupt:
        raise InterruptedByUserError("interrupted") from None
    command: Any = typer.main.get_command(getattr(module, name))
    # Join the lines of each paragraph, so that help texts are wrapped at the width of the terminal.
    paragraphs = [" ".join(paragraph.split()) for paragraph in command.help.split("\n\n")]
    command.help = "\n\n".join([COMMANDS[name], *paragraphs])
    # Output that a command prints without print_text or print_result goes to standard error.
    command.invoke = results_alone()(command.invoke)
    return command


app = typer.Typer(cls=_Commands, add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)


@app.callback(invoke_without_command=True)
def about(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    """At what load does this masonry collapse? Limit analysis of rigid blocks with Coulomb joints."""
    if version:
        print_text(package_version("masonry_opt"))
        raise typer.Exit


def main() -> None:
    """Run the command line. Each foreseeable error ends with one message and an exit code."""
    if sys.stdout is None:  # the caller has closed it
        _end("standard output is closed: redirect it to a file or a pipe", OutputError.exit_code)
    with _results_apart():
        _run()


@contextlib.contextmanager
def _results_apart() -> Iterator[None]:
    """Write results to a separate file descriptor within a context.

    Libraries that write to file descriptor 1 then write to standard error.
    """
    standard_output = sys.__stdout__
    if standard_output is None or standard_output is not sys.stdout:  # a test has replaced it
        yield
        return
    results = os.fdopen(os.dup(1), "w", encoding=standard_output.encoding)
    os.dup2(os.open(os.devnull, os.O_WRONLY) if sys.stderr is None else 2, 1)
    sys.stdout = results
    try:
        yield
    finally:
        sys.stdout = standard_output
        # After a failed write, closing the stream fails again. The first failure was already reported.
        with contextlib.suppress(OSError):
            results.close()


def _run() -> None:
    """Run the command that was typed, and end with one message if it raises an error of this package."""
    _escape_unencodable()
    try:
        _run_and_flush()
    except (ReaderGoneError, BrokenPipeError):
        _end(None, ReaderGoneError.exit_code)
    except MasonryError as error:
        _end(str(error), error.exit_code)
    except OSError as error:
        _end(f"the output cannot be written: {error.strerror}", OutputError.exit_code)
    except MemoryError:
        _end("the scene does not fit in memory: split it into smaller scenes", MasonryError.exit_code)
    except KeyboardInterrupt:
        _end("interrupted", InterruptedByUserError.exit_code)
    except SystemExit as end:
        if end.code == InterruptedByUserError.exit_code:  # Typer exits with this code after Ctrl-C
            _end("interrupted: files already written are complete", InterruptedByUserError.exit_code)
        raise


def _escape_unencodable() -> None:
    """Configure output streams to write characters that they cannot encode as escape sequences."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _run_and_flush() -> None:
    """Run the app, and flush standard output before it exits, so that write errors are raised."""
    try:
        app()
    except SystemExit:
        sys.stdout.flush()
        raise


def _end(message: str | None, code: int) -> NoReturn:
    """Print a message, if given, on standard error, and exit with an exit code."""
    with contextlib.suppress(OSError):
        if message is not None and sys.stderr is not None:
            print(f"error: {message}", file=sys.stderr, flush=True)
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        # Python flushes standard output again when it exits; the null device prevents a second error.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(code)

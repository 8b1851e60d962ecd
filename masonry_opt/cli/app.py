"""Command line: results on standard output, everything else on standard error."""

import contextlib
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from io import TextIOWrapper
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperCommand, TyperGroup

from masonry_opt.cli.imports import garbage_collection_paused
from masonry_opt.cli.slips import with_remedies
from masonry_opt.errors import InterruptedByUserError, MasonryError, OptionError, OutputError, ReaderGoneError
from masonry_opt.reporting.terminal import print_text, print_warnings, results_alone

#: Map from a command to its module, if the module has a different name. A module is imported only when its
#: command runs.
_MODULES = {"check": "solve", "compare": "many", "sweep": "many"}
_MODULES |= dict.fromkeys(("convert", "draw", "export"), "files")
_MODULES |= dict.fromkeys(("capacity", "crossing", "directions", "least", "report", "settle"), "studies")

#: Help text of each command, in the order in which ``--help`` lists the commands.
COMMANDS = {
    "solve": "Find the collapse load factor of the scene in CASE, for all load cases or for a selected one.",
    "check": "Check that the static and the kinematic load factor of CASE agree, in CVXPY and in Pyomo.",
    "draw": "Draw the blocks, supports, joints, small gaps and loads of CASE to FILE, without solving CASE.",
    "export": "Write CASE to FILE as an optimisation problem for other solvers, or as solids for other "
    "software.",
    "capacity": "Follow the mechanism of CASE after the onset of collapse, down to λ = 0.",
    "convert": "Convert a drawing to a case file with blocks, supports, friction, weights and live loads.",
    "compare": "Compare times and answers of methods and solvers on scenes, and write tables and a report.",
    "directions": "Find the seismic coefficient of CASE at collapse, for earthquakes from each direction.",
    "crossing": "Move the axles of CASE over its road, and find the position with the least load factor.",
    "least": "Find the least value of a parameter of CASE at which CASE is stable, or carries a given load.",
    "report": "Write a page about CASE: its inputs, its results, and the checks that were made or omitted.",
    "reproduce": "Recompute the paper's results from the case files in the folder cases/ or in the package.",
    "settle": "Find the least and the greatest reaction of a support at which CASE is stable.",
    "sweep": "Solve CASE for all combinations of values of its parameters, or for random values.",
}

#: Metavar of an option that takes no value. By default Typer prints "<bool>", as if it took a value.
NO_VALUE = ""

#: Map from the former name of each renamed option to its current name.
FORMER_OPTIONS = {"--expected": "--incremental", "--no-expected": "--no-incremental"}


class _Commands(TyperGroup):
    """Group of commands that loads the module of a command only when the command is called."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands = {name: TyperCommand(name, help=does) for name, does in COMMANDS.items()}

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the name of a command, the loaded command, and the remaining arguments.

        Raises OptionError, with the present name, if an option has a name of a former version.
        """
        name, _, remaining = super().resolve_command(ctx, args)
        for option in remaining:
            if option in FORMER_OPTIONS:
                raise OptionError(f"option '{option}' is now called '{FORMER_OPTIONS[option]}'")
        return name, load(str(name)), remaining


def load(name: str) -> Any:
    """Load and return a command with all its options."""
    try:
        with garbage_collection_paused():
            module = import_module(f"masonry_opt.cli.{_MODULES.get(name, name)}")
    except KeyboardInterrupt:
        raise InterruptedByUserError("interrupted") from None
    command: Any = typer.main.get_command(getattr(module, name))
    # Join the lines of each paragraph, so that help texts are wrapped at the width of the terminal.
    paragraphs = [" ".join(paragraph.split()) for paragraph in command.help.split("\n\n")]
    command.help = "\n\n".join([COMMANDS[name], *paragraphs])
    command.format_help = _negated_in_help(command)
    command.parse_args = with_remedies(command)
    # Standard output is reserved for print_text and print_result. All other output of a command goes to
    # standard error.
    command.invoke = results_alone()(command.invoke)
    return command


def _negated_in_help(command: Any) -> Callable[..., None]:
    """Return a function that writes the help, with only one name for each flag that is True by default.

    The name is the negated one: the help contains --no-incremental, but not --incremental. With both names of
    a flag, little width would remain for the texts on a terminal of 80 columns.
    """
    write = command.format_help
    flags = [option for option in command.params if option.secondary_opts and option.default is True]

    def format_help(*formatting: Any) -> None:
        """Write the help with only the negated name (--no-...) of each flag, then restore both names."""
        names = [(flag.opts, flag.secondary_opts) for flag in flags]
        for flag, (_, negated) in zip(flags, names, strict=True):
            flag.opts, flag.secondary_opts = negated, []
        try:
            write(*formatting)
        finally:
            for flag, both in zip(flags, names, strict=True):
                flag.opts, flag.secondary_opts = both

    return format_help


app = typer.Typer(cls=_Commands, add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)


@app.callback(invoke_without_command=True)
def about(
    version: Annotated[bool, typer.Option("--version", metavar=NO_VALUE, help="Print the version.")] = False,
) -> None:
    """Find the load at which masonry collapses, by limit analysis of rigid blocks with Coulomb friction."""
    if version:
        import masonry_opt

        print_text(masonry_opt.__version__)
        raise typer.Exit


def main() -> None:
    """Run the command line. An error that a user can correct is reported by one message and an exit code."""
    if sys.stdout is None:  # the calling program has closed standard output
        _end("standard output is closed: redirect it to a file or a pipe", OutputError.exit_code)
    with _results_apart():
        _run()


@contextlib.contextmanager
def _results_apart() -> Iterator[None]:
    """Keep the messages of libraries out of standard output during a ``with`` block.

    Libraries that write to file descriptor 1 then write to standard error.
    """
    standard_output = sys.__stdout__
    if standard_output is None or standard_output is not sys.stdout:  # a test has replaced standard output
        yield
        return
    results = os.fdopen(os.dup(1), "w", encoding=standard_output.encoding)
    os.dup2(os.open(os.devnull, os.O_WRONLY) if sys.stderr is None else 2, 1)
    sys.stdout = results
    try:
        yield
    finally:
        sys.stdout = standard_output
        # After a failed write, closing the stream fails too. The second error is ignored, because the first
        # error was already reported.
        with contextlib.suppress(OSError):
            results.close()


def _run() -> None:
    """Run the command that the user typed, and report an error of this package in one message."""
    _escape_unencodable()
    try:
        _run_and_flush()
    except (ReaderGoneError, BrokenPipeError):
        _end(None, ReaderGoneError.exit_code)
    except MasonryError as error:
        _end(error.message, error.exit_code, error.warnings)
    except OSError as error:
        _end(f"the output cannot be written: {error.strerror}", OutputError.exit_code)
    except MemoryError:
        _end("the scene does not fit in memory: split it into smaller scenes", MasonryError.exit_code)
    except KeyboardInterrupt:
        _end("interrupted", InterruptedByUserError.exit_code)
    except SystemExit as end:
        if end.code == InterruptedByUserError.exit_code:  # Typer exits with this code after Ctrl-C
            _end("interrupted: all files that were written are complete", InterruptedByUserError.exit_code)
        raise


def _escape_unencodable() -> None:
    """Configure output streams to print an escape sequence for each character that they cannot encode."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _run_and_flush() -> None:
    """Run the app, then flush standard output, so that the caller can handle the error of a failed write."""
    try:
        app()
    except SystemExit:
        sys.stdout.flush()
        raise


def _end(message: str | None, code: int, warnings: Sequence[str] = ()) -> NoReturn:
    """End the program with an exit code. Print warnings and the message, unless None, on standard error."""
    with contextlib.suppress(OSError):
        if message is not None and sys.stderr is not None:
            print_warnings(warnings)
            print(f"error: {message}", file=sys.stderr, flush=True)
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        # Python flushes standard output again when it exits. Redirect the output to the null device, so that
        # the second flush does not fail.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(code)

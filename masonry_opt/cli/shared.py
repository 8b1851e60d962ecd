"""What commands share: options, how texts are read, what is shown meanwhile, and how a command ends."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from inspect import Parameter, signature
from json import loads as parse_json
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from masonry_opt.errors import InterruptedByUserError, OptionError, OutputError
from masonry_opt.files import WRITER
from masonry_opt.methods.registry import METHODS
from masonry_opt.words.terminal import print_text

Case = Annotated[Path, typer.Argument(help="Case file (.toml or .json).", show_default=False)]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="Draw the answer (.png, .svg, .pdf).")]
PlotOrPage = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Draw the answer (.png, .svg, .pdf, .html).")
]
Table = Annotated[bool, typer.Option("--table", help="Print every state or position too.")]


def numbers(refusal: str, count: int | None = None) -> Callable[[str], tuple[float, ...]]:
    """What reads numbers with commas between. Of anything else, or another count, it raises OptionError: the
    refusal, with the text in it."""

    def parse(text: str) -> tuple[float, ...]:
        try:
            found = tuple(map(float, text.split(",")))
        except ValueError:
            found = ()
        if not found or count not in (None, len(found)):
            raise OptionError(refusal.format(text))
        return found

    return parse


#: Options of parameters that mean the same in every function.
SHARED = {
    "method": typer.Option(help=f"One of: {', '.join(METHODS)}."),
    "load_case": typer.Option(metavar="NAME", help="The load case of CASE, where it has any."),
    "options": typer.Option("--option", "-o", help="The method's own, as NAME=VALUE; may be repeated."),
    "names": typer.Option("--names", help="Write the blocks' names into the picture."),
    "force": typer.Option("--force", help=f"Replace also what {WRITER} did not write."),
    "view": typer.Option(
        metavar="AZIMUTH,ELEVATION",
        help="Of solids: from where they are seen, in degrees.",
        parser=numbers("--view {}: write azimuth and elevation as in --view=-60,22", 2),
    ),
}

LoadCaseName = Annotated[str | None, SHARED["load_case"]]
Force = Annotated[bool, SHARED["force"]]


def method_options(texts: Sequence[str], function: Callable[..., Any]) -> dict[str, Any]:
    """Options of a method from texts NAME=VALUE, for a function that passes them on.

    Raises OptionError if a text has another form, or names an argument of the function itself.
    """
    options = dict(map(_name_and_value, texts))
    for name, argument in signature(function).parameters.items():
        if argument.kind is not Parameter.VAR_KEYWORD and name in options:
            raise OptionError(
                f"option '{name}': it is not the method's but the command's own, if any: see --help"
            )
    return options


def _name_and_value(text: str) -> tuple[str, Any]:
    """Name and value of NAME=VALUE: a number, true, a list, ... as in JSON; else the text as it is."""
    name, equals, value = text.partition("=")
    if not equals:
        raise OptionError(f"option '{text}': write it as NAME=VALUE, such as beta=0.5")
    for parse in (parse_json, float):  # float also reads .5
        try:
            return name, parse(value)
        except ValueError:
            continue
    return name, value


@contextlib.contextmanager
def waiting(line: str) -> Iterator[Callable[[str], None]]:
    """Show a line until the end, and yield what changes it. Ctrl-C ends with nothing found."""
    with Console(stderr=True).status(line) as status:
        try:
            yield status.update
        except KeyboardInterrupt:
            raise InterruptedByUserError("interrupted: nothing was found") from None


@contextlib.contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn errors of writing a file into those of this package."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from None


def tell(
    text: str, found: Any, usable: bool, plot: Path | None, drawing: Mapping[str, Any], say: Any = print_text
) -> None:
    """Print what was found, draw it where a file is given, and end with 1 if it is no usable answer."""
    say(text)
    if plot is not None:
        with writing(plot):
            found.save(plot, **drawing)
    if not usable:
        raise typer.Exit(1)


@contextlib.contextmanager
def interrupts() -> Iterator[Callable[[], None]]:
    """Remember Ctrl-C, which a solver may catch to stop itself alone, and yield a function that raises
    KeyboardInterrupt if there was one."""
    pressed = False

    def remember(*_: object) -> None:
        nonlocal pressed
        pressed = True
        raise KeyboardInterrupt

    def check() -> None:
        if pressed:
            raise KeyboardInterrupt

    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # else the caller has its own, or ignores it
        signal.signal(signal.SIGINT, remember)
    try:
        yield check
    finally:
        if before is signal.default_int_handler:
            signal.signal(signal.SIGINT, before)

"""Commands from functions: their parameters, with types, defaults and help, as options; what they share."""

import contextlib
import inspect
import math
import re
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from functools import partial
from inspect import Parameter
from json import loads as parse_json
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer
from rich.console import Console
from rich.markup import escape
from typer.models import OptionInfo

from masonry_opt.analysis import solve
from masonry_opt.effort import Phases
from masonry_opt.errors import InterruptedByUserError, OptionError
from masonry_opt.files import WRITER, writing
from masonry_opt.methods.registry import METHODS
from masonry_opt.words.sentences import numeral
from masonry_opt.words.terminal import changing_line, left_by, print_text, print_warnings

Function = Callable[..., Any]
T = TypeVar("T")

#: Parameters that a command asks for in its own way: what a function is of.
_SUBJECTS = {"self", "scene", "scenes", "path", "result", "make"}
_TYPES: dict[str, type] = {"bool": bool, "int": int, "float": float}


def reader(read: Callable[[str], T], refusal: str) -> Callable[[str], T]:
    """What reads a text by a function; where that raises ValueError it raises OptionError: the refusal, with
    the text in it."""

    def parse(text: str) -> T:
        try:
            return read(text)
        except ValueError:
            raise OptionError(refusal.format(text)) from None

    return parse


def numbers(refusal: str) -> Callable[[str], tuple[float, ...]]:
    """What reads numbers with commas between; see ``reader``."""
    return reader(lambda text: tuple(map(float, text.split(","))), refusal)


@partial(reader, refusal="--view {}: write azimuth and elevation as in --view=-60,22")
def _angles(text: str) -> tuple[float, float]:
    azimuth, elevation = map(float, text.split(","))
    return azimuth, elevation


_VIEW = "Of solids: from where they are seen, in degrees."
_DRAW = "Draw the answer (.png, .svg, .pdf{})."
PICTURE = typer.Option(metavar="FILE", help=_DRAW.format(""))

#: Options, and an argument, of parameters that mean the same in every function.
_SHARED: dict[str, Any] = {
    "case": typer.Argument(help="Case file (.toml or .json).", show_default=False),
    "json": typer.Option("--json", help="Print one JSON object."),
    "plot": typer.Option(metavar="FILE", help=_DRAW.format(", .html")),
    "table": typer.Option("--table", help="Print every state or position too."),
    "method": typer.Option(help=f"One of: {', '.join(METHODS)}."),
    "load_case": typer.Option(metavar="NAME", help="The load case of CASE, where it has any."),
    "options": typer.Option("--option", "-o", help="The method's own, as NAME=VALUE; may be repeated."),
    "names": typer.Option("--names", help="Write the blocks' names into the picture."),
    "force": typer.Option("--force", help=f"Replace also what {WRITER} did not write."),
    "view": typer.Option(metavar="AZIMUTH,ELEVATION", help=_VIEW, parser=_angles),
}


class Given(dict[str, Any]):
    """Arguments that were typed, by parameter; where none was, the functions' own defaults hold."""

    called: Mapping[str, str] = {}  #: Options by parameter, as the command line has them.

    def take(self, function: Function) -> dict[str, Any]:
        """Those of a function, which are then no longer here."""
        return {name: self.pop(name) for name in inspect.signature(function).parameters if name in self}

    def rest(self, function: Function) -> dict[str, Any]:
        """What is left, and the method's options, for a function that passes these on. Raises OptionError if
        one has another form, or is an argument of the function itself."""
        options = dict(map(_name_and_value, self.pop("options", ())))
        for of in (solve, function):  # to the first of which the other passes the rest
            if own := inspect.signature(of).parameters.keys() & options:
                whose = "it is not the method's but the command's own, if any: see --help"
                raise OptionError(f"option '{min(own)}': {whose}")
        return self | options


def command(
    *functions: Function, labels: Sequence[str] = (), leave: str = "", **asked: Any
) -> Callable[[Function], typer.Typer]:
    """Make a typer app of a function that is called with what was typed of other functions' parameters
    (:class:`Given`), and with options of its own, which take the place of those of the same name. The command
    ends with 1 if it returns False.

    Labels, by function, begin the help of an option that not all of these take; then none is required. What
    ``leave`` names becomes no option. Asked typer options tell of parameters what signatures do not say; a
    ``parser`` reads one text.
    """
    told = _SHARED | asked

    def made(own: Function) -> typer.Typer:
        options = dict(inspect.signature(own, eval_str=True).parameters)
        del options[next(iter(options))]
        for name, one in options.items():
            options[name] = one.replace(annotation=Annotated[one.annotation, told[name]])
        parsers: dict[str, Function | None] = {}
        for one in (one for of in functions for one in inspect.signature(of).parameters.values()):
            called = one.default is not one.empty and callable(one.default)  # as the function runs
            if not called and one.name not in {*options, *_SUBJECTS, *leave.split()}:
                info: OptionInfo = copy(told.get(one.name) or typer.Option())
                parsers[one.name], info.parser = info.parser, None
                info.help = info.help or escape(_help(one, functions, labels))
                options[one.name] = _option(one, info, bool(parsers[one.name]), not labels)

        def run(ctx: typer.Context, **typed: Any) -> None:
            given = Given()
            given.called = {str(option.name): option.opts[-1] for option in ctx.command.params}
            for name in [name for name in parsers if name in typed]:
                value, parse = typed.pop(name), parsers[name] or (lambda text: text)
                if ctx.get_parameter_source(name).name != "DEFAULT":  # type: ignore[union-attr]
                    given[name] = [*map(parse, value)] if isinstance(value, list) else parse(value)
            if own(given, **typed) not in (None, True):
                raise typer.Exit(1)

        context = Parameter("ctx", Parameter.KEYWORD_ONLY, annotation=typer.Context)
        keywords = [one.replace(kind=Parameter.KEYWORD_ONLY) for one in options.values()]
        run.__signature__ = inspect.Signature([context, *keywords])  # type: ignore[attr-defined]
        app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
        app.command(own.__name__, help=inspect.getdoc(own))(run)
        return app

    return made


def _option(one: Parameter, info: OptionInfo, read: bool, required: bool) -> Parameter:
    """A parameter as typer has it. What takes several is repeated, in the singular, or read of one text."""
    said, default = inspect.formatannotation(one.annotation).strip("'"), one.default
    mapping = one.kind is one.VAR_KEYWORD or "Mapping" in said
    repeated = mapping or (not read and bool(re.search("Sequence|Iterable", said)))
    kind: Any = Path if "Path" in said else _TYPES.get(said.removesuffix(" | None"), str)
    if info.default is ... and (repeated or default is False):
        name = "--" + one.name.replace("_", "-")
        info.default = name.removesuffix("s") if repeated else name  # said, or typer adds --no-...
    if one.kind is one.VAR_KEYWORD or (not required if default is one.empty else repeated):
        default = None
    elif isinstance(default, tuple):
        default = ",".join(map(str, default))
    kind = list[kind] if repeated else kind
    annotation = Annotated[kind | None if default is None else kind, info]  # type: ignore[valid-type]
    return one.replace(annotation=annotation, default=default, kind=one.KEYWORD_ONLY)


def _help(one: Parameter, functions: Sequence[Function], labels: Sequence[str]) -> str:
    """What begins and ends an option's help, and between the first sentence that a docstring says of it."""
    taking = [one.name in inspect.signature(of).parameters for of, _ in zip(functions, labels, strict=False)]
    of = [label for label, takes in zip(labels, taking, strict=True) if takes and label]
    said = next(filter(None, (_said(one.name, function) for function in (*functions, solve))), "")
    if of and not all(taking):
        return f"{', '.join(of)}: {said}"
    return said[:1].upper() + said[1:] + (" Needed." if labels and one.default is one.empty else "")


def _said(name: str, function: Function) -> str:
    """First sentence that a function's docstring says of a parameter; of what is as elsewhere nothing."""
    told = (inspect.getdoc(function) or "").partition("\nParameters\n----------\n")[2].partition("\n\n")[0]
    for names, said in re.findall(r"^(\S[^:\n]*):\s+(.*(?:\n .*)*)", told, re.MULTILINE):
        if name in re.split(r"[,\s*]+", names) and not re.match("as (of|in) |of :func:", said, re.IGNORECASE):
            plain = re.sub(r":\w+:`[~.]*(?:\w+\.)*(\w+)`", r"\1", " ".join(said.split())).replace("``", "")
            return re.split(r"(?<=\.) ", plain)[0]
    return ""


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
def waiting(line: str, quiet: bool = False, kept: str = "nothing was found") -> Iterator["Work"]:
    """Show a line on a terminal until the end, with the time since it began, and yield what changes it.

    Ctrl-C ends the command with what is kept. Nothing is shown if ``quiet``.
    """
    with changing_line(Console(stderr=True, quiet=quiet), line) as show:
        try:
            yield Work(show, line)
        except KeyboardInterrupt:
            raise InterruptedByUserError(f"interrupted: {kept}") from None


class Work:
    """The line that says what a command is doing, and the steps that it has shown."""

    def __init__(self, show: Phases, name: str) -> None:
        self._show, self._name = show, name
        self.steps: list[str] = []  #: steps of the method with a load factor, in words
        self._last = ""

    def show(self, line: str) -> None:
        """Show a line."""
        self._show(line)

    def phase(self, words: str) -> None:
        """Show the phase that begins, and the last step before it."""
        self._show(f"{self._name}: {words}{f' (last {self._last})' if self._last else ''}")

    def step(self, step: Any) -> None:
        """Show a step of a method, if it has a load factor."""
        if not math.isfinite(step.load_factor):
            return
        number = len(self.steps) + 1
        self.steps.append(f"{_name_of(step)} {number}: λ = {numeral(step.load_factor, '.6f')}")
        self._last = self.steps[-1] + left_by(step)
        self._show(f"{self._name}: {self._last}")


def _name_of(step: object) -> str:
    """Return the name of a kind of step in words, such as "relaxation step"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(step).__name__).lower()


def print_json(answer: Any) -> None:
    """Print an answer as one JSON object on standard output, and its warnings on standard error."""
    print_text(answer.to_json())
    print_warnings(answer.warning_sentences)


def save(found: Any, plot: Path | None, drawing: Mapping[str, Any]) -> None:
    """Draw what was found, where a file is given."""
    if plot is not None:
        with writing(plot):
            found.save(plot, **drawing)


@contextlib.contextmanager
def interrupts() -> Iterator[Callable[[], None]]:
    """Remember Ctrl-C, which a solver may catch to stop itself alone, and yield what raises it again."""
    pressed = False

    def remember(*_: object) -> None:
        nonlocal pressed
        pressed = True
        raise KeyboardInterrupt

    def check() -> None:
        if pressed:
            raise KeyboardInterrupt

    callers = signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    with contextlib.nullcontext() if callers else handled(signal.SIGINT, remember):
        yield check


def ended_by_kill() -> contextlib.AbstractContextManager[None]:
    """Within it `kill` and `timeout` act as Ctrl-C does: else runs under way would go on alone."""
    return handled(signal.SIGTERM, signal.default_int_handler)


@contextlib.contextmanager
def handled(number: int, handler: Callable[..., Any]) -> Iterator[None]:
    before = signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, before)

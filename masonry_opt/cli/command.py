"""Commands made from functions: parameters become options, with types, defaults and help.

The help of an option is the first sentence on the parameter in the docstring of the function.
"""

import contextlib
import inspect
import math
import re
import signal
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
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
from masonry_opt.cli.app import NO_VALUE
from masonry_opt.effort import Phases
from masonry_opt.errors import DrawingWarning, InterruptedByUserError, LongAnalysisWarning, OptionError
from masonry_opt.files import WRITER, writing
from masonry_opt.methods.registry import METHODS
from masonry_opt.reporting.sentences import numeral
from masonry_opt.reporting.terminal import changing_line, print_text, print_warnings, residuals_of_step

Function = Callable[..., Any]
T = TypeVar("T")

#: Names of parameters that do not become options, because each command defines its own arguments for them.
_SUBJECTS = {"self", "scene", "scenes", "path", "result", "make"}
#: Map from the annotation of a parameter to the type of its option. For other annotations, options are text.
_TYPES: dict[str, type] = {"bool": bool, "int": int, "float": float}


def reader(read: Callable[[str], T], refusal: str) -> Callable[[str], T]:
    """Return a function that parses text as ``read`` does, but raises OptionError in place of ValueError.

    ``refusal`` is the message of the error. The parsed text is inserted at the braces of the message.
    """

    def parse(text: str) -> T:
        try:
            return read(text)
        except ValueError:
            raise OptionError(refusal.format(text)) from None

    return parse


def numbers(refusal: str) -> Callable[[str], tuple[float, ...]]:
    """Return a function that parses numbers separated by commas, and raises OptionError for other text."""
    return reader(lambda text: tuple(map(float, text.split(","))), refusal)


@partial(reader, refusal="--view {}: write azimuth and elevation as in --view=-60,22")
def _angles(text: str) -> tuple[float, float]:
    """Parse the azimuth and the elevation of a view, in degrees."""
    azimuth, elevation = map(float, text.split(","))
    return azimuth, elevation


def _movement(text: str) -> tuple[str, tuple[float, ...]]:
    """Parse the name of a support and its movement: x, y and optionally a rotation.

    Raises OptionError if the text does not have this form.
    """
    name, colon, movement = text.rpartition(":")
    try:
        parts = tuple(map(float, movement.split(",")))
    except ValueError:
        parts = ()
    if not (colon and name and len(parts) in (2, 3)):
        raise OptionError(
            f"--settled {text}: write NAME:X,Y or NAME:X,Y,ROTATION with the name of a support, such as "
            "pier:0,-0.02"
        )
    return name, parts


_VIEW = "Azimuth and elevation of the viewer in degrees, for a scene in space."
_DRAW = "Draw the answer to FILE (.png, .svg, .pdf{})."
PICTURE = typer.Option(metavar="FILE", help=_DRAW.format(""))
#: Arguments ``subject`` and ``needed`` of :func:`refuse_without` for options that apply only to a picture.
PICTURE_NEEDS = ("a picture", "--plot FILE")

#: Command-line options for parameters that have the same meaning in all functions.
_SHARED: dict[str, Any] = {
    "case": typer.Argument(metavar="CASE", help="Case file (.toml or .json).", show_default=False),
    "json": typer.Option("--json", help="Print one JSON object."),
    "plot": typer.Option(metavar="FILE", help=_DRAW.format(", .html")),
    "method": typer.Option(help=f"One of: {', '.join(METHODS)}."),
    "load_case": typer.Option(metavar="NAME", help="Name of a load case, if CASE has load cases."),
    "options": typer.Option(
        "--option", "-o", metavar="NAME=VALUE", help="Option of the method, as NAME=VALUE; may be repeated."
    ),
    "names": typer.Option("--names", help="Write the blocks' names into the picture."),
    "force": typer.Option("--force", help=f"Replace existing files even if {WRITER} did not write them."),
    "incremental": typer.Option(
        help="Omit the incremental load factor. Coulomb methods compute it for up to 3000 joints, and in "
        "space for up to 3000 contact points.",
        show_default=False,
    ),
    "settled": typer.Option(
        metavar="NAME:X,Y[,ROT]",
        help="Movement of support NAME before the live load acts, in the length unit of CASE, with an "
        "optional rotation in radians; may be repeated.",
        parser=_movement,
    ),
    "view": typer.Option(metavar="AZIM,ELEV", help=_VIEW, parser=_angles),
}


class CommandArguments(dict[str, Any]):
    """Arguments from the command line for the functions that a command calls, by parameter name.

    The dictionary contains only arguments that the user typed, and no arguments of the command itself. The
    functions use their defaults for missing arguments.
    """

    called: Mapping[str, str] = {}  #: Name of the command-line option for each parameter name.

    def take(self, function: Function) -> dict[str, Any]:
        """Return the arguments that a function accepts, and remove these arguments from this dictionary."""
        return {name: self.pop(name) for name in inspect.signature(function).parameters if name in self}

    def keywords_for(self, function: Function) -> dict[str, Any]:
        """Return keyword arguments for a function: the arguments typed by the user and the method's options.

        The function passes the options of the method on to ``solve``. Raises OptionError if an option of the
        method does not have the form NAME=VALUE, or is a parameter of ``function`` or of ``solve``.
        """
        options = dict(map(_name_and_value, self.pop("options", ())))
        # Refuse options of the command that are passed through --option. The exception is "time_limit", which
        # is also an option of method "global".
        for taking in (solve, function):
            own = inspect.signature(taking).parameters.keys() & (options.keys() - {"time_limit"})
            if own:
                raise OptionError(
                    f"'{min(own)}' is not an option of the method and cannot follow --option: --help lists "
                    "the options of the command"
                )
        return self | options


def refuse_without(arguments: CommandArguments, ignored: Iterable[str], subject: str, needed: str) -> None:
    """Raise OptionError if the user typed options that have no effect without another option.

    Parameters
    ----------
    arguments: The arguments of the command. Their attribute ``called`` contains the names of the options.
    ignored: Names of the parameters that would be ignored.
    subject: What the options apply to, such as "a picture".
    needed: The missing option with its value, such as "--plot FILE".
    """
    names = [arguments.called[name] for name in ignored]
    if names:
        listed = " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
        verb = "applies" if len(names) == 1 else "apply"
        raise OptionError(f"{listed} {verb} to {subject}: add {needed}, or omit {listed}")


def command(
    *functions: Function, labels: Sequence[str] = (), leave: str = "", **own_infos: Any
) -> Callable[[Function], typer.Typer]:
    """Return a decorator that converts a function to a command, which is a Typer app.

    The command has the options of the decorated function and of the functions in ``functions``. The decorated
    function is called with the arguments for the other functions (:class:`CommandArguments`), and with its
    own options, which replace options of equal name. The command ends with exit code 1 if the function
    returns False.

    Parameters
    ----------
    functions: Functions whose parameters become options.
    labels: A label for each function, at the beginning of the help of options that not all functions take.
        With labels no option is required.
    leave: Names of parameters, separated by spaces, that do not become options.
    own_infos: Typer options by parameter name: help texts, names and parsers that signatures do not contain.
    """
    infos = _SHARED | own_infos

    def decorator(own: Function) -> typer.Typer:
        """Make a Typer app of the decorated function."""
        options = dict(inspect.signature(own, eval_str=True).parameters)
        # The first parameter receives the CommandArguments, so it does not become an option.
        del options[next(iter(options))]
        for name, parameter in options.items():
            info = copy(infos[name])
            if parameter.annotation is bool:
                info.metavar = NO_VALUE
            options[name] = parameter.replace(annotation=Annotated[parameter.annotation, info])
        parsers: dict[str, Function | None] = {}
        for parameter in _parameters(functions):
            # A parameter whose default is a function, such as progress, is a callback and not an option.
            is_callback = parameter.default is not parameter.empty and callable(parameter.default)
            name = parameter.name
            if not is_callback and name not in {*options, *_SUBJECTS, *leave.split()}:
                info = copy(infos.get(name) or typer.Option())
                parsers[name], info.parser = info.parser, None
                info.help = info.help or escape(_help(parameter, functions, labels))
                options[name] = _option(parameter, info, bool(parsers[name]), not labels)

        def run(ctx: typer.Context, **typed: Any) -> None:
            """Call the decorated function with the arguments that the user typed."""
            arguments = CommandArguments()
            arguments.called = {str(option.name): option.opts[-1] for option in ctx.command.params}
            for name in [name for name in parsers if name in typed]:
                value, parse = typed.pop(name), parsers[name] or (lambda text: text)
                if ctx.get_parameter_source(name).name != "DEFAULT":  # type: ignore[union-attr]
                    arguments[name] = [*map(parse, value)] if isinstance(value, list) else parse(value)
            with _warnings_printed():
                succeeds = own(arguments, **typed) in (None, True)
            if not succeeds:
                raise typer.Exit(1)

        context = Parameter("ctx", Parameter.KEYWORD_ONLY, annotation=typer.Context)
        keywords = [parameter.replace(kind=Parameter.KEYWORD_ONLY) for parameter in options.values()]
        run.__signature__ = inspect.Signature([context, *keywords])  # type: ignore[attr-defined]
        app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
        app.command(own.__name__, help=inspect.getdoc(own))(run)
        return app

    return decorator


def _parameters(functions: Sequence[Function]) -> Iterator[Parameter]:
    """Iterate over the parameters of all functions, in the order of the functions."""
    for function in functions:
        yield from inspect.signature(function).parameters.values()


def _option(parameter: Parameter, info: OptionInfo, has_parser: bool, required: bool) -> Parameter:
    """Return a parameter with the annotation from which Typer creates an option.

    A parameter with several values becomes an option that may be repeated, and whose name has no plural "s".
    If a parser reads all values from one text, the option is not repeated.
    """
    annotated, default = inspect.formatannotation(parameter.annotation).strip("'"), parameter.default
    mapping = parameter.kind is parameter.VAR_KEYWORD or "Mapping" in annotated
    repeated = mapping or (not has_parser and bool(re.search("Sequence|Iterable", annotated)))
    kind: Any = Path if "Path" in annotated else _TYPES.get(annotated.removesuffix(" | None"), str)
    if info.default is ... and (repeated or default is False):
        name = "--" + parameter.name.replace("_", "-")
        info.default = name.removesuffix("s") if repeated else name  # otherwise Typer also adds --no-NAME
    no_default = not required if default is parameter.empty else repeated
    if parameter.kind is parameter.VAR_KEYWORD or no_default:
        default = None
    elif isinstance(default, tuple):
        # Append the default values to the help text. Click would print them in brackets, which users could
        # mistake for a part of the value.
        info.help = f"{info.help} Default: {', '.join(map(str, default))}."
        default = ",".join(map(str, default))
        info.show_default = False
    if kind is bool:
        info.metavar = NO_VALUE
    if repeated and "may be repeated" not in str(info.help):
        info.help = f"{info.help} The option may be repeated."
    kind = list[kind] if repeated else kind
    annotation = Annotated[kind | None if default is None else kind, info]  # type: ignore[valid-type]
    return parameter.replace(annotation=annotation, default=default, kind=parameter.KEYWORD_ONLY)


def _help(parameter: Parameter, functions: Sequence[Function], labels: Sequence[str]) -> str:
    """Return the help text of an option, which is the first sentence about its parameter in a docstring.

    If only some functions have the parameter, the labels of these functions come first.
    """
    name, labelled = parameter.name, [*zip(functions, labels, strict=False)]
    taking = [name in inspect.signature(function).parameters for function, _ in labelled]
    own_labels = [label for (_, label), takes in zip(labelled, taking, strict=True) if takes and label]
    sentences = (_first_sentence(name, function) for function in (*functions, solve))
    sentence = re.sub("^True (if|to) ", "", next(filter(None, sentences), ""))
    sentence = sentence[:1].upper() + sentence[1:]
    if own_labels and not all(taking):
        label = ", ".join(own_labels)
        return f"{label[:1].upper()}{label[1:]}: {sentence}"
    return sentence + (" Required." if labels and parameter.default is parameter.empty else "")


def _first_sentence(name: str, function: Function) -> str:
    """Return the first sentence about a parameter in the docstring of a function.

    Returns "" if the docstring does not describe the parameter, or refers to another function.
    """
    section = (inspect.getdoc(function) or "").partition("\nParameters\n----------\n")[2]
    section = re.split(r"\n\n(?=\S)", section)[0]  # up to the first unindented paragraph
    for names, text in re.findall(r"^(\S[^:\n]*):\s+(.*(?:\n .*)*)", section, re.MULTILINE):
        if name in re.split(r"[,\s*]+", names) and not re.match("as (of|in) |of :func:", text, re.IGNORECASE):
            plain = re.sub(r":\w+:`[~.]*(?:\w+\.)*(\w+)`", r"\1", " ".join(text.split())).replace("``", "")
            return re.split(r"(?<=\.) ", plain)[0]
    return ""


def _name_and_value(text: str) -> tuple[str, Any]:
    """Parse a text NAME=VALUE.

    The value is parsed as JSON or as a float if possible; otherwise it stays text.
    """
    name, equals, value = text.partition("=")
    if not equals:
        raise OptionError(f"option '{text}': write it as NAME=VALUE, such as beta=0.5")
    for parse in (parse_json, float):  # float also accepts .5, which is not valid JSON
        try:
            return name, parse(value)
        except ValueError:
            continue
    return name, value


@contextlib.contextmanager
def waiting(line: str, quiet: bool = False, if_interrupted: str = "nothing was found") -> Iterator["Work"]:
    """Show a progress line with the elapsed time during a ``with`` block.

    The block receives a Work, with which it can change the text of the line.

    Ctrl-C raises InterruptedByUserError with the text of the KeyboardInterrupt, if it has one, else with
    ``if_interrupted``. If ``quiet`` is True, no line is shown.
    """
    with changing_line(Console(stderr=True, quiet=quiet), line) as show:
        try:
            yield Work(show, line)
        except KeyboardInterrupt as stop:
            raise InterruptedByUserError(f"interrupted: {str(stop) or if_interrupted}") from None


@contextlib.contextmanager
def _warnings_printed() -> Iterator[None]:
    """Print warnings about drawings and long analyses on standard error, without their source lines.

    Each warning is printed when it occurs for the first time in a command.
    """

    printed: set[str] = set()

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        """Print a warning that has not been printed before."""
        if str(message) not in printed:
            print_warnings([str(message)])
        printed.add(str(message))

    with warnings.catch_warnings():
        for category in (DrawingWarning, LongAnalysisWarning):
            warnings.simplefilter("always", category)
        warnings.showwarning = show
        yield


class Work:
    """Progress line of a command, with a list of all steps that the line has shown."""

    def __init__(self, show: Phases, name: str) -> None:
        self._show, self._name = show, name
        self.steps: list[str] = []  #: steps of the method that have a load factor, as text
        self._last_step = ""  #: text of the most recent step, with its residual
        self._phase = ""  #: name of the current phase, followed by a colon

    def show(self, line: str) -> None:
        """Replace the text of the line."""
        self._show(line)

    def phase(self, words: str) -> None:
        """Show the name of the phase that begins now, and the most recent step of the method."""
        last = f" (last {self._last_step})" if self._last_step else ""
        self._phase = f"{words}: "
        self._show(f"{self._name}: {words}{last}")

    def step(self, step: Any) -> None:
        """Show a step of a method if the step has a load factor."""
        if not math.isfinite(step.load_factor):
            return
        number = len(self.steps) + 1
        self.steps.append(f"{_step_name(step)} {number}: λ = {numeral(step.load_factor, '.6f')}")
        self._last_step = self.steps[-1] + residuals_of_step(step)
        self._show(f"{self._name}: {self._phase}{self._last_step}")


def _step_name(step: object) -> str:
    """Return the class name of a step as separate words, such as "relaxation step"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(step).__name__).lower()


def print_json(answer: Any) -> None:
    """Print an answer as one JSON object on standard output, and its warnings on standard error."""
    print_text(answer.to_json())
    print_warnings(answer.warning_sentences)


def save(answer: Any, plot: Path | None, drawing: Mapping[str, Any]) -> None:
    """Save the picture of an answer to the file ``plot``, unless ``plot`` is None."""
    if plot is not None:
        with writing(plot):
            answer.save(plot, **drawing)


@contextlib.contextmanager
def interrupts() -> Iterator[Callable[[], None]]:
    """Yield a function that raises KeyboardInterrupt if Ctrl-C was pressed in the ``with`` block.

    The function is needed because a solver may catch KeyboardInterrupt and stop only itself.
    """
    pressed = False

    def remember(*_: object) -> None:
        """Record that Ctrl-C was pressed, and raise KeyboardInterrupt."""
        nonlocal pressed
        pressed = True
        raise KeyboardInterrupt

    def check() -> None:
        """Raise KeyboardInterrupt if Ctrl-C was pressed."""
        if pressed:
            raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:  # the caller has its own handler
        yield check
        return
    with handled(signal.SIGINT, remember):
        yield check


def ended_by_kill() -> contextlib.AbstractContextManager[None]:
    """Return a context manager in which SIGTERM (from `kill` or `timeout`) has the effect of Ctrl-C.

    Worker processes then end too.
    """
    return handled(signal.SIGTERM, signal.default_int_handler)


@contextlib.contextmanager
def handled(number: int, handler: Callable[..., Any]) -> Iterator[None]:
    """Set the handler of a signal for a ``with`` block, and restore the previous handler afterwards."""
    previous = signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, previous)

"""Options of a method as they are written on the command line, and options that commands share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from inspect import Parameter, signature
from json import loads as parse_json
from typing import Annotated, Any

import typer

from masonry_opt.errors import OptionError
from masonry_opt.files import WRITER

#: Of every command that replaces what it wrote before.
Force = Annotated[bool, typer.Option("--force", help=f"Replace also what {WRITER} did not write.")]

#: Of every command that draws.
View = Annotated[
    str | None,
    typer.Option(metavar="AZIMUTH,ELEVATION", help="Of solids: from where they are seen, in degrees."),
]

#: Of every command that solves by a method.
OwnOptions = Annotated[
    list[str] | None,
    typer.Option("--option", "-o", help="The method's own, as NAME=VALUE; may be repeated."),
]

#: Of every command that solves as ``solve`` does, which says more of them.
Model = Annotated[str | None, typer.Option(help="As of solve.")]
SolverName = Annotated[str | None, typer.Option(help="As of solve.")]
Tolerance = Annotated[float | None, typer.Option(help="As of solve.", show_default=False)]

#: Of every command that can answer a program.
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]

#: Of every command that takes a scene as one of its load cases has it.
LoadCaseName = Annotated[
    str | None,
    typer.Option("--load-case", metavar="NAME", help="The load case of CASE, where it has any."),
]


def angles(view: str | None) -> tuple[float, float] | None:
    """Azimuth and elevation from a text; raises OptionError if it has another form."""
    if view is None:
        return None
    try:
        azimuth, elevation = map(float, view.split(","))
    except ValueError:
        raise OptionError(f"--view {view}: write azimuth and elevation as in --view=-60,22") from None
    return azimuth, elevation


def method_options(texts: Sequence[str] | None, function: Callable[..., Any]) -> dict[str, Any]:
    """Options of a method from texts NAME=VALUE, for a function that passes them on.

    Raises OptionError if a text has another form, or names an argument of the function itself.
    """
    options = dict(map(_name_and_value, texts or []))
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

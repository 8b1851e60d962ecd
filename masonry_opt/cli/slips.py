"""Add remedies to Typer's messages about wrong arguments, which only say what is wrong."""

import re
from collections.abc import Callable
from typing import Any

import typer

#: Base class of Typer's errors about wrong arguments. Typer exports only some of its subclasses.
_UsageError: Any = typer.BadParameter.__base__

#: Pairs: a pattern that matches an error message, and a remedy that replaces the message.
_REPLACING_REMEDIES = (
    (r"valid (number|float)", "write one number without a unit, with a point before decimals, such as 0.5"),
    (r"valid int", "write one whole number, such as 5"),
)

#: Pairs: a pattern that matches an error message, and a remedy that is appended to the message.
_APPENDED_REMEDIES = (
    (r"No such option: -\.?\d", "write several numbers with commas and without spaces, such as 0,-1"),
    (r"unexpected extra argument", "enclose text that contains spaces in quotation marks"),
)


def with_remedies(command: Any) -> Callable[..., Any]:
    """Wrap the parser of a command's arguments, so that its error messages say how to correct mistakes."""
    parse = command.parse_args

    def parse_args(ctx: Any, typed: list[str]) -> Any:
        """Parse the arguments of a command."""
        try:
            return parse(ctx, typed)
        except _UsageError as error:
            _add_remedy(error, command)
            raise

    return parse_args


def _add_remedy(error: Any, command: Any) -> None:
    """Complete or replace the message of an error if this module has a remedy for the mistake."""
    message = str(error.message)
    option = str(getattr(error, "option_name", "")).removeprefix("--").replace("-", "_")
    takes_options = any("--option" in parameter.opts for parameter in command.params)
    if "No such option" in message and takes_options and option in _method_options():
        error.possibilities = None
        error.message = f"{message}; '{option}' is an option of the method, written as -o {option}=VALUE"
        return
    appended = ((pattern, f"{message}; {remedy}") for pattern, remedy in _APPENDED_REMEDIES)
    for pattern, changed in (*_REPLACING_REMEDIES, *appended):
        if re.search(pattern, message):
            error.message = changed
            return


def _method_options() -> set[str]:
    """Return the names of the options of all methods."""
    from masonry_opt.methods.registry import METHODS

    return {name for method in METHODS.values() if method.options for name in method.options.model_fields}

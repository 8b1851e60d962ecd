"""Options of a method as they are written on the command line."""

from __future__ import annotations

from json import loads as parse_json
from typing import Any

from masonry_opt.errors import OptionError


def name_and_value(text: str) -> tuple[str, Any]:
    """The name and value of NAME=VALUE: a number, true, a list, ... as in JSON; else the text as it is.

    Raises OptionError if there is no "=".
    """
    name, equals, value = text.partition("=")
    if not equals:
        raise OptionError(f"option '{text}': write it as NAME=VALUE, such as beta=0.5")
    for parse in (parse_json, float):  # float also reads .5
        try:
            return name, parse(value)
        except ValueError:
            continue
    return name, value

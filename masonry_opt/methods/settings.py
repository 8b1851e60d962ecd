"""Define the base class of settings classes, which checks the value of each field."""

import math
import reprlib
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cache
from numbers import Integral, Real
from typing import Any, get_args, get_origin, get_type_hints

from masonry_opt.errors import OptionError

#: Key in the metadata of a dataclass field. The entry is the check that numbers in the field must pass.
_CHECK = "check"


@dataclass(frozen=True)
class _Check:
    """Condition on the numbers in a field, and the words that describe it in error messages."""

    passes: Callable[[float], bool]
    words: str


_ABOVE_ZERO = _Check(lambda number: number > 0, "above 0")
_ABOVE_ONE = _Check(lambda number: number > 1, "above 1")
_ZERO_OR_MORE = _Check(lambda number: number >= 0, "of 0 or more")


def zero_or_more(default: Any) -> Any:
    """Return a field of a settings class whose numbers must be at least zero. A tuple may be empty."""
    return field(default=default, metadata={_CHECK: _ZERO_OR_MORE})


def above_one(default: float) -> Any:
    """Return a field of a settings class whose numbers must be larger than one."""
    return field(default=default, metadata={_CHECK: _ABOVE_ONE})


@dataclass(frozen=True)
class Settings:
    """Base class of frozen dataclasses whose fields are numbers that control an algorithm.

    The numbers must be finite, and larger than zero unless a field states another check. A field of type
    ``int`` must be a whole number. A field of type ``tuple[float, float]`` is a range.
    """

    def __post_init__(self) -> None:
        """Raise OptionError if the value of a field has a wrong type or is not permitted."""
        settings: Any = type(self)  # annotated as Any, because mypy regards the class as not hashable
        for name, kind, check in _fields_to_check(settings):
            value = getattr(self, name)
            if not _is_valid(value, kind, check):
                needed, actual = _needed(kind, check), reprlib.repr(value)
                raise OptionError(f"{settings.__name__}: '{name}' must be {needed} (found {actual})")


@cache
def _fields_to_check(settings: type[Settings]) -> list[tuple[str, Any, _Check]]:
    """Return the name, the type and the check of each field of a settings class."""
    types = get_type_hints(settings)
    return [
        (setting.name, types[setting.name], setting.metadata.get(_CHECK, _ABOVE_ZERO))
        for setting in fields(settings)
    ]


def _is_range(kind: Any) -> bool:
    return kind == tuple[float, float]


def _is_valid(value: Any, kind: Any, check: _Check) -> bool:
    """Return True if a value has the type of its field and its numbers are in the permitted range."""
    if get_origin(kind) is tuple:
        inner = get_args(kind)[0]
        if not isinstance(value, tuple) or not all(_is_valid(item, inner, check) for item in value):
            return False
        if _is_range(kind):
            return len(value) == 2 and value[0] <= value[1]
        return bool(value) or check is _ZERO_OR_MORE
    if isinstance(value, bool) or not isinstance(value, Integral if kind is int else Real):
        return False
    return math.isfinite(value) and check.passes(float(value))


def _needed(kind: Any, check: _Check) -> str:
    """Return the part of an error message that states which values a field can have."""
    if _is_range(kind):
        return f"a tuple of two finite numbers {check.words}, the smaller number first"
    if get_origin(kind) is tuple:
        entries = "finite numbers" if get_args(kind)[0] is float else "tuples of finite numbers"
        return f"a tuple of {entries} {check.words}"
    return f"a {'whole' if kind is int else 'finite'} number {check.words}"

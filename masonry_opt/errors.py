"""Errors that a user can correct, and functions that format parts of messages.

The command line shows each error as one message without a traceback.
"""

from collections.abc import Sequence
from math import ceil, floor, log10


def printable(text: str) -> str:
    """Return a text in which characters that cannot be printed are escaped; line ends stay as they are.

    Text of a case file or path therefore cannot move the cursor of a terminal, change colours or the
    direction of writing, or fail to be encoded.
    """
    return "".join(
        character if character == "\n" or character.isprintable() else ascii(character)[1:-1]
        for character in text
    )


def rounded(value: float, digits: int = 3) -> str:
    """Return a number as text, rounded to a given number of significant digits: 12300 instead of 1.23e+04."""
    return f"{float(f'{value:.{digits}g}'):g}"


def rounded_up(value: float, digits: int = 4) -> str:
    """Return a positive number as text, rounded up to a given number of significant digits.

    Upper bounds are rounded up, because a printed bound must not be smaller than the bound.
    """
    unit = 10.0 ** (floor(log10(value)) + 1 - digits)
    return rounded(ceil(value / unit) * unit, digits)


def rounded_down(value: float, digits: int = 3) -> str:
    """Return a positive number as text, rounded down to a given number of significant digits.

    A value that must stay below a limit is advised with the limit rounded down.
    """
    unit = 10.0 ** (floor(log10(value)) + 1 - digits)
    return rounded(floor(value / unit) * unit, digits)


def counted(number: int, noun: str, plural: str = "") -> str:
    """Return a number with a noun in singular or plural, such as "1 hole" or "2 holes".

    ``plural`` is the plural of a noun that does not form its plural with -s, such as "entities".
    """
    return f"{number} {noun if number == 1 else plural or f'{noun}s'}"


def remainder(count: int, most: int, noun: str = "") -> str:
    """Return a text with the number of omitted items, such as "and 3 more" or "and 1 more row".

    ``count`` is the number of all items, of which the first ``most`` are not omitted. The text is empty if no
    item is omitted. ``noun`` is the name of an item in the singular.
    """
    omitted = count - most
    if omitted <= 0:
        return ""
    return f"and {counted(omitted, f'more {noun}')}" if noun else f"and {omitted} more"


def shortened(items: Sequence[str], most: int, noun: str = "") -> list[str]:
    """Return the first ``most`` items and, if items are omitted, a text with the number of omitted items.

    See :func:`remainder` for the text and for ``noun``.
    """
    return [*items[:most], *filter(None, [remainder(len(items), most, noun)])]


def listed(items: Sequence[str], most: int, noun: str = "") -> str:
    """Return a text with the first ``most`` items and the number of omitted items; see :func:`remainder`."""
    return " ".join(filter(None, (", ".join(items[:most]), remainder(len(items), most, noun))))


class MasonryError(Exception):
    """Base class of this package's errors; each message is printable and states a remedy.

    Attributes
    ----------
    message: the message without warnings. The text of the error, ``str(error)``, also has the warnings.
    warnings: warnings about the scene that may explain the error, as sentences.
    """

    exit_code = 2  #: exit code of the command line

    def __init__(self, message: object, warnings: Sequence[str] = ()) -> None:
        self.message = printable(str(message))
        self.warnings = tuple(map(printable, dict.fromkeys(warnings)))
        super().__init__("; ".join([self.message, *(f"warning: {sentence}" for sentence in self.warnings)]))


class LongAnalysisWarning(UserWarning):
    """Warning that an analysis will take many minutes; the message names a faster method."""


class DrawingWarning(UserWarning):
    """Warning that part of a drawing was changed when it was read, or that its unit of length is doubtful.

    The message states the change, or why the unit is doubtful.
    """


class CaseError(MasonryError, ValueError):
    """Raised if a case file or scene has an error; the message names the file, key or block, and a remedy."""

    # The base class ValueError is needed, because pydantic converts every ValueError that a validator raises
    # to a validation error.


class OptionError(MasonryError):
    """Raised if a method, model, solver or option is unknown, wrong or not available for a scene."""


class OutputError(MasonryError):
    """Raised if output cannot be written; the message states the path and the reason."""


class ReaderGoneError(OutputError):
    """Raised if the program that reads standard output, such as `head`, closes it; no message is printed."""

    exit_code = 128 + 13  #: exit code of programs that the signal SIGPIPE terminates


class NoLoadFactorError(MasonryError):
    """Raised if a required load factor does not exist or is unknown; the message states the reason."""

    exit_code = 1


class TimeLimitError(MasonryError):
    """Raised if the time limit ends an analysis without a result; the message states in which phase."""

    exit_code = 1


class NoRunSolvedError(MasonryError):
    """Raised if no run of a study returned a result; the message states the most frequent reason."""

    exit_code = 1


class InterruptedByUserError(MasonryError):
    """Raised if the user stops the run; the message states the results obtained so far."""

    exit_code = 130

"""Errors that a user can correct, and functions that format parts of messages.

The command line shows each error as one message without a traceback.
"""

from math import ceil, floor, log10


def printable(text: str) -> str:
    """Return a text in which all characters except printable ones and line ends are escaped.

    Text of a case file or path therefore cannot move the cursor of a terminal, change colours or the
    direction of writing, or fail to be encoded.
    """
    return "".join(
        character if character == "\n" or character.isprintable() else ascii(character)[1:-1]
        for character in text
    )


def rounded_up(value: float, digits: int = 4) -> str:
    """Return a positive number, rounded up to some significant digits, as text.

    Upper bounds are printed so, because they must not appear smaller.
    """
    unit = 10.0 ** (floor(log10(value)) + 1 - digits)
    return f"{ceil(value / unit) * unit:.{digits}g}"


def counted(number: int, noun: str) -> str:
    """Return a number with its noun in singular or plural, such as "1 hole" or "2 holes"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


class MasonryError(Exception):
    """Base class of errors whose message states what to do; the message is printable."""

    exit_code = 2  #: exit code of the command line

    def __init__(self, message: object) -> None:
        super().__init__(printable(str(message)))


class CaseError(MasonryError, ValueError):
    """A case file or scene is wrong; the message names the file, the key or block, and the remedy."""

    # Pydantic converts a ValueError in a validator to a validation error of the record.


class OptionError(MasonryError):
    """A method, model, solver or option is wrong or not available here."""


class OutputError(MasonryError):
    """An output could not be written; the message states the path and the reason."""


class ReaderGoneError(OutputError):
    """The reader of standard output closed it. This is no failure, and nothing is printed."""

    exit_code = 128 + 13  #: exit code of programs that the signal SIGPIPE ends


class NoLoadFactorError(MasonryError):
    """A load factor is needed, and the scene has none; the message states the reason."""

    exit_code = 1


class NoRunSolvedError(MasonryError):
    """No run of a study was solved: all were refused or crashed; the message states the reason."""

    exit_code = 1


class InterruptedByUserError(MasonryError):
    """The user stopped the run; the message states the results obtained before."""

    exit_code = 130

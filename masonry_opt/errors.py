"""Errors that a user can put right, each shown as one message without a traceback; and parts of messages."""

from math import ceil, floor, log10


def printable(text: str) -> str:
    """The text with everything but printable characters and line ends written as escapes: what a case file
    or path holds must not move a terminal's cursor, colour it, turn writing round, or fail to be encoded."""
    return "".join(one if one == "\n" or one.isprintable() else ascii(one)[1:-1] for one in text)


def rounded_up(value: float, digits: int = 4) -> str:
    """A positive number rounded up to so many digits, for what must not be less."""
    unit = 10.0 ** (floor(log10(value)) + 1 - digits)
    return f"{ceil(value / unit) * unit:.{digits}g}"


def counted(number: int, noun: str) -> str:
    """A number of things: "1 hole", "2 holes"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


class MasonryError(Exception):
    """Base of the errors whose message tells a user what to do; the message is printable."""

    exit_code = 2  #: What the command line ends with.

    def __init__(self, message: object) -> None:
        super().__init__(printable(str(message)))


class CaseError(MasonryError, ValueError):
    """A case file or scene is wrong; the message names the file, the key or block, and the remedy."""

    # A ValueError too, so that a record built inside one of pydantic's validators is refused there.


class OptionError(MasonryError):
    """A method, model, solver or option is wrong or not available here."""


class OutputError(MasonryError):
    """What was asked for could not be written; the message says where and why."""


class ReaderGoneError(OutputError):
    """The reader of standard output closed it: nothing is wrong, and nothing is printed."""

    exit_code = 128 + 13  #: As of programs that the signal SIGPIPE ends.


class NoLoadFactorError(MasonryError):
    """What was asked for needs a load factor and the scene has none; the message says why."""

    exit_code = 1


class NoRunSolvedError(MasonryError):
    """No run of a study was solved: all were refused, crashed or died; the message says why."""

    exit_code = 1


class InterruptedByUserError(MasonryError):
    """The user stopped the run; the message says what was found until then."""

    exit_code = 130

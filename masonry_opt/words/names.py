"""Names of blocks and joints in sentences, and the verbs that go with them."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

_NAMED = 5  #: Items of a list that are named; the rest is counted.
_LABEL = 16  #: Width of the labels of lines.
WARNING = "warning: "  #: Begins each line that states a warning.


def labelled(lines: Mapping[str, object]) -> str:
    """A line for each label of which something is said, with that; further lines of one under its first."""
    between = "\n" + " " * (_LABEL + 1)
    told = {label: str(words).replace("\n", between) for label, words in lines.items() if words}
    return "\n".join(f"{label:<{_LABEL}} {words}" for label, words in told.items())


def warning_lines(sentences: Iterable[str]) -> list[str]:
    """Return warnings as the lines that every command prints, each sentence once."""
    return [f"{WARNING}{sentence}" for sentence in dict.fromkeys(sentences)]


def blocks(names: list[str]) -> str:
    return f"{'block' if len(names) == 1 else 'blocks'} {some([repr(name) for name in names])}"


def some(names: list[str]) -> str:
    """The first five, and how many more."""
    return ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")


def pairs(v: dict[str, Any], told: Sequence[str] = ()) -> str:
    """The pairs of blocks, each with what is told of it in brackets."""
    brackets = [f" ({words})" for words in told] or [""] * len(v["pairs"])
    return some([f"{a!r}–{b!r}{words}" for (a, b), words in zip(v["pairs"], brackets, strict=True)])


def verb(number: int, word: str) -> str:
    """A verb as a number of things does it: "1 slides", "2 slide" without the number."""
    ending = "es" if word.endswith(("ch", "sh")) else "s"
    return f"{word}{ending if number == 1 else ''}"


def do(v: dict[str, Any], word: str) -> str:
    return f"{blocks(v['blocks'])} {verb(len(v['blocks']), word)}"

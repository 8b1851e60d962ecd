"""Write names of blocks and joints, and verbs that agree with their number, as parts of sentences."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from masonry_opt.errors import listed

_MOST_LISTED_NAMES = 5  #: Largest number of names that a text lists; the remaining names are only counted.
_LABEL_WIDTH = 16  #: Width of the labels at the beginning of lines, in characters.
WARNING = "warning: "  #: Prefix of each line that states a warning.
#: Phrase after a force in a text. A report replaces this phrase with the user's unit of force, if specified.
FORCE_UNIT = "in the force unit of the case"


def labelled(lines: Mapping[str, object]) -> str:
    """Return one line for each label, with the label and its text. Labels without text are omitted.

    If the text of a label has several lines, they begin in the same column.
    """
    line_break = "\n" + " " * (_LABEL_WIDTH + 1)
    texts = {label: str(words).replace("\n", line_break) for label, words in lines.items() if words}
    return "\n".join(f"{label:<{_LABEL_WIDTH}} {words}" for label, words in texts.items())


def warning_lines(sentences: Iterable[str]) -> list[str]:
    """Return warnings as lines with the prefix "warning: ", without repetitions."""
    return [f"{WARNING}{sentence}" for sentence in dict.fromkeys(sentences)]


def unbroken_values(page: str) -> str:
    """Return an HTML page in which no line is broken before or after the equals sign of a load factor."""
    return page.replace("λ = ", "λ\u00a0=\u00a0")


def blocks(names: list[str]) -> str:
    """Return the names of blocks after the word "block" or "blocks", such as "blocks 'A', 'B'"."""
    return f"{'block' if len(names) == 1 else 'blocks'} {some([repr(name) for name in names])}"


def some(names: list[str]) -> str:
    """Return a text with some of the names: the first five, and the number of the remaining names."""
    return listed(names, _MOST_LISTED_NAMES)


def pairs(v: dict[str, Any], remarks: Sequence[str] = ()) -> str:
    """Return a text that lists the pairs of blocks that a reason names, such as "'A'–'B', 'B'–'C'".

    ``remarks`` are texts that follow the pairs in brackets, one for each pair; by default there are none.
    """
    brackets = [f" ({remark})" for remark in remarks] or [""] * len(v["pairs"])
    return some([f"{a!r}–{b!r}{bracket}" for (a, b), bracket in zip(v["pairs"], brackets, strict=True)])


def verb(number: int, word: str) -> str:
    """Return a verb that agrees with a number of subjects: "slides" for 1, else "slide"."""
    ending = "es" if word.endswith(("ch", "sh")) else "s"
    return f"{word}{ending if number == 1 else ''}"


def do(v: dict[str, Any], word: str) -> str:
    """Return a clause about the blocks that a reason names, such as "block 'A' hangs"."""
    return f"{blocks(v['blocks'])} {verb(len(v['blocks']), word)}"

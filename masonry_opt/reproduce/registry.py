"""What ``reproduce`` can rebuild. Adding an example is one entry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from masonry_opt.errors import OptionError
from masonry_opt.reproduce.arch import fig9
from masonry_opt.reproduce.example import Progress, Report
from masonry_opt.reproduce.rib import rib
from masonry_opt.reproduce.table1 import table1


@dataclass(frozen=True)
class Example:
    """An example of the paper.

    Attributes
    ----------
    title: what it shows.
    run: rebuilds it, given the folder of case files and a place for progress lines.
    also: further names, such as those of figures that it holds beside the one that names it.
    """

    title: str
    run: Callable[[Path, Progress], Report]
    also: tuple[str, ...] = ()


#: In the order of the paper.
EXAMPLES: dict[str, Example] = {
    "fig9": Example("Fig. 9: least thickness of a semicircular arch", fig9),
    "rib": Example("Section 5.2: arch rib of Pippard & Ashby", rib),
    "table1": Example("Table 1: walls of Ferris & Tin-Loi", table1),
}


def find_examples(name: str) -> list[str]:
    """Names of the examples that a user means: one, or ``all``. Raises OptionError if there is none."""
    if name == "all":
        return list(EXAMPLES)
    for known, example in EXAMPLES.items():
        if name == known or name in example.also:
            return [known]
    raise OptionError(f"nothing to reproduce is named '{name}'; choose from: {', '.join(EXAMPLES)}, all")

"""A reader of AMPL's NL files in text form, limited to linear rows and complementary pairs.

The format is described in D. M. Gay, Writing .nl Files (2005). Ten lines of counts come first. Segments
follow, each of which begins with a letter.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class NlFile:
    """A linear program or complementarity problem with the names of its rows and columns."""

    rows: list[str]  # names, without the objective
    columns: list[str]
    matrix: np.ndarray  # shape (rows, columns)
    equal: dict[int, float]  # right-hand sides of the rows that are equations
    #: Column of each complementary row, and its bounds: 1 for a lower bound plus 2 for an upper bound.
    pairs: dict[int, tuple[int, int]]
    lower: np.ndarray  # lower bounds of the columns
    upper: np.ndarray
    counts: list[list[int]]  # the numbers in each line of the header


def read_nl(path: Path) -> NlFile:  # noqa: C901, PLR0912 - the parts of the file in their order
    """Read an ``.nl`` file, and the names from the ``.row`` and ``.col`` files in its folder."""
    lines = [line.split("#")[0].split() for line in path.read_text().splitlines()]
    assert lines[0][0] == "g3"  # "g" marks a file in text form
    counts = [[int(word) for word in line] for line in lines[1:10]]
    columns, rows = counts[0][:2]
    matrix, equal, pairs = np.zeros((rows, columns)), {}, {}
    bounds = np.tile([[-np.inf], [np.inf]], columns)
    rest = iter(lines[10:])
    for head, *words in rest:
        kind, number = head[0], int(head[1:] or 0)
        match kind:
            case "C" | "O":
                assert next(rest) == ["n0"]  # no row has a nonlinear part
            case "r":
                for row in range(rows):
                    code, *numbers = next(rest)
                    if code == "5":
                        pairs[row] = (int(numbers[1]) - 1, int(numbers[0]))
                    elif code == "4":
                        equal[row] = float(numbers[0])
            case "b":
                for column in range(columns):
                    code, *numbers = next(rest)
                    assert code in "0123"
                    if code in "02":
                        bounds[0, column] = float(numbers[0])
                    if code in "01":
                        bounds[1, column] = float(numbers[-1])
            case "J":
                for _ in range(int(words[0])):
                    column, entry = next(rest)
                    matrix[number, int(column)] = float(entry)
            case "G" | "k" | "x":
                for _ in range(int(words[0]) if words else number):
                    next(rest)
            case _:
                raise AssertionError(f"segment {head}")
    names = [path.with_suffix(end).read_text(encoding="utf-8").splitlines() for end in (".row", ".col")]
    assert (len(names[0]), len(names[1])) == (rows + counts[0][2], columns)
    return NlFile(names[0][:rows], names[1], matrix, equal, pairs, *bounds, counts)

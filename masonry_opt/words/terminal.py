"""Results as text for a terminal."""

import io
import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from typing import TYPE_CHECKING, TextIO

from rich import box
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Column, Table
from rich.text import Text

from masonry_opt.errors import OutputError, ReaderGoneError, printable
from masonry_opt.words.names import WARNING, warning_lines

if TYPE_CHECKING:
    import pandas as pd

#: Columns shown as small numbers.
_RESIDUALS = ("difference", "equilibrium", "yield", "flow", "kinematics", "virtual_work", "complementarity")

#: A row of the table of load factors: two spaces, then a name. Continuation lines have more spaces.
_LOAD_FACTOR_ROW = re.compile(r"  \w")

#: Where results are printed while standard output is kept for them; else standard output.
_results: TextIO | None = None


@contextmanager
def results_alone() -> Iterator[None]:
    """Keep standard output for what is printed below: all else, as by solvers, goes to standard error."""
    global _results
    _results = sys.stdout
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        _results = None


def print_text(text: str) -> None:
    """Print text at once; OutputError if the disk is full, ReaderGoneError if the output is closed."""
    with _printing():
        print(text, file=_results, flush=True)


def print_result(text: str, bold_line: int | None = 1) -> None:
    """Print the lines of a result, and the lines of its warnings on standard error.

    On a terminal load factors are bold and warnings yellow. ``bold_line`` is the number of a line that stands
    out too, counted from 0; None if there is none.
    """
    lines = text.split("\n")
    results = [line for line in lines if not line.startswith(WARNING)]
    _print_lines(results, bold_line)
    print_warnings(line.removeprefix(WARNING) for line in lines if line.startswith(WARNING))


def _print_lines(lines: Sequence[str], bold_line: int | None) -> None:
    """Print lines of a result on standard output."""
    console = Console(highlight=False, file=_results)
    if not console.is_terminal or console.no_color:
        print_text("\n".join(lines))
        return
    texts = [Text(line) for line in lines]
    for number, text in enumerate(texts):
        if number == bold_line or _LOAD_FACTOR_ROW.match(text.plain):
            text.stylize("bold")
    with _printing():
        console.print(Text("\n").join(texts), soft_wrap=True)


def print_warnings(sentences: Iterable[str]) -> None:
    """Print warnings on standard error, on a terminal in yellow."""
    console = Console(stderr=True)
    for line in warning_lines(sentences):
        console.print(printable(line), markup=False, highlight=False, soft_wrap=True, style="bold yellow")


@contextmanager
def changing_line(console: Console, line: str) -> Iterator[Callable[[str], None]]:
    """On a terminal show a line with the time since it began, until the end; yield what changes it."""
    if not console.is_terminal:
        yield lambda _: None
        return
    # On a narrow terminal the line is cut, not broken.
    text = TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, ratio=1))
    columns = SpinnerColumn(), TimeElapsedColumn(), text
    with Progress(*columns, console=console, transient=True, expand=True) as shown:
        task = shown.add_task(line, total=None)
        yield lambda line: shown.update(task, description=line)


def left_by(step: object) -> str:
    """Residuals and seconds of a step of a method, as far as it has any: ", mismatch 4.2e-02, 16.4 s"."""
    left = [f", {name} {getattr(step, name):.1e}" for name in ("gap", "mismatch") if hasattr(step, name)]
    return "".join([*left, f", {getattr(step, 'seconds', math.nan):.1f} s"]) if left else ""


@contextmanager
def _printing() -> Iterator[None]:
    """Turn errors of printing into those of this package."""
    try:
        yield
    except BrokenPipeError:
        raise ReaderGoneError("standard output was closed") from None
    except OSError as error:
        raise OutputError(f"standard output cannot be written: {error.strerror}") from None


def frame_text(frame: "pd.DataFrame", title: str) -> str:
    """A frame as a table with a title."""
    from pandas.api.types import is_numeric_dtype

    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for column in frame.columns:
        numeric = is_numeric_dtype(frame[column])
        table.add_column(str(column), justify="right" if numeric else "left")
    for record in frame.to_dict("records"):
        table.add_row(*(_cell(str(column), value) for column, value in record.items()))
    # A fixed width, wide enough for every column: what is piped or pasted reads as what is seen.
    text = io.StringIO()
    Console(file=text, width=150).print(table)
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines()) + "\n"


def _cell(column: str, value: object) -> str:
    """Return a value as tables show it; the name of its column decides how many digits matter."""
    # The list of commands imports this module, and sentences import the problem with much of SciPy.
    from masonry_opt.words.sentences import numeral

    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "–"
    spec = ".1e" if column in _RESIDUALS else "+.3f" if "%" in column else ".2f" if "(s)" in column else ".5f"
    return numeral(value, spec)

"""Print results, warnings and tables on a terminal."""

import io
import math
import re
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from typing import TYPE_CHECKING, Any, TextIO

from rich import box
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Column, Table
from rich.text import Text

from masonry_opt.errors import OutputError, ReaderGoneError, printable
from masonry_opt.reporting.names import WARNING, warning_lines

if TYPE_CHECKING:
    import pandas as pd

#: Names of table columns with residuals, which are printed in scientific notation with two digits.
_RESIDUAL_COLUMNS = (
    "difference",
    "equilibrium",
    "yield",
    "flow",
    "kinematics",
    "virtual_work",
    "complementarity",
)
#: Number formats of columns, by a part of the column's name. Other numbers have five decimals.
_FORMATS = {"%": "+.3f", "(s)": ".2f", "(°)": "g", "vertical / horizontal": "g"}

#: Seconds between two lines of progress, if the output is a file or a pipe instead of a terminal. A smaller
#: value makes logs longer.
SECONDS_BETWEEN_LINES = 10.0

#: Pattern of a row of the table of load factors, which begins with exactly two spaces and a name.
_LOAD_FACTOR_ROW = re.compile(r"  \w")

#: Largest indentation of continuation lines, in characters, if a line is wrapped to the width of a terminal.
#: With a larger value, continuation lines may have only a few characters.
_DEEPEST_COLUMN = 40
#: A line with more gaps (of two or more spaces) than this number is a row of a table, and is not wrapped.
_MOST_GAPS = 2

#: Stream to which results are printed while standard output is redirected; None stands for standard output.
_results: TextIO | None = None


@contextmanager
def results_alone() -> Iterator[None]:
    """Reserve standard output for the functions of this module, and send all other output to standard error.

    Solvers, for example, may write to standard output.
    """
    global _results
    _results = sys.stdout
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        _results = None


def print_text(text: str) -> None:
    """Print text on standard output, and flush the output.

    Raises ReaderGoneError if the output is closed, and OutputError if it cannot be written.
    """
    with _printing():
        print(text, file=_results, flush=True)


def print_result(text: str, bold_line: int | None = 1) -> None:
    """Print the lines of a result on standard output, and its warnings on standard error.

    On a terminal, load factors are bold and warnings are yellow. The line with number ``bold_line``, counted
    from 0, is bold too, unless ``bold_line`` is None.
    """
    lines = text.split("\n")
    results = [line for line in lines if not line.startswith(WARNING)]
    _print_lines(results, bold_line)
    print_warnings(line.removeprefix(WARNING) for line in lines if line.startswith(WARNING))


def _print_lines(lines: Sequence[str], bold_line: int | None) -> None:
    """Print lines of a result on standard output. If the output is a terminal, wrap the lines to fit."""
    console = Console(highlight=False, file=_results)
    if not console.is_terminal:
        print_text("\n".join(lines))
        return
    texts = [Text(_wrapped(line, console.width)) for line in lines]
    if console.no_color:
        print_text("\n".join(text.plain for text in texts))
        return
    for number, text in enumerate(texts):
        if number == bold_line or _LOAD_FACTOR_ROW.match(text.plain):
            text.stylize("bold")
    with _printing():
        console.print(Text("\n").join(texts), soft_wrap=True)


def _wrapped(line: str, width: int) -> str:
    """Wrap a line between words, and align its continuation lines with the text after its last gap.

    A gap is a sequence of at least two spaces. Gaps that end beyond ``_DEEPEST_COLUMN`` have no effect.
    Lines of tables are not wrapped.
    """
    gaps = [gap.end() for gap in re.finditer(r" {2,}(?=\S)", line)]
    begins = len(line) - len(line.lstrip())
    of_table = len(gaps) > _MOST_GAPS + (begins > 1) or begins > _DEEPEST_COLUMN or " " not in line.strip()
    if len(line) <= width or of_table:
        return line
    column = max((gap for gap in gaps if gap <= _DEEPEST_COLUMN), default=0)
    look: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    return textwrap.fill(line, width, subsequent_indent=" " * column, **look)


def print_warnings(sentences: Iterable[str]) -> None:
    """Print warnings on standard error; on a terminal they are yellow."""
    console = Console(stderr=True)
    for line in warning_lines(sentences):
        look: dict[str, Any] = {"markup": False, "highlight": False, "style": "bold yellow"}
        console.print(printable(line), soft_wrap=not console.is_terminal, **look)


@contextmanager
def changing_line(console: Console, line: str) -> Iterator[Callable[[str], None]]:
    """Show a line with its text and the elapsed time, and yield a function that changes the text.

    On a terminal the line is removed at the end. Elsewhere, as in a file or a pipe, the present text is
    written as a line of its own every ten seconds.
    """
    if not console.is_terminal:
        with _repeated_lines(console, line) as change:
            yield change
        return
    # On a narrow terminal the line is truncated instead of wrapped.
    text = TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, ratio=1))
    columns = SpinnerColumn(), TimeElapsedColumn(), text
    with Progress(*columns, console=console, transient=True, expand=True) as progress:
        task = progress.add_task(line, total=None)
        yield lambda line: progress.update(task, description=line)


@contextmanager
def _repeated_lines(console: Console, line: str) -> Iterator[Callable[[str], None]]:
    """Write the current text and the elapsed time as a line at regular intervals."""
    began, ended, text = time.monotonic(), threading.Event(), [line]

    def change(line: str) -> None:
        text[:] = [line]

    def write() -> None:
        while not ended.wait(SECONDS_BETWEEN_LINES):
            elapsed = round(time.monotonic() - began)
            console.print(printable(f"{elapsed} s: {text[0]}"), markup=False, highlight=False, soft_wrap=True)

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    try:
        yield change
    finally:
        ended.set()
        writer.join()


def residuals_of_step(step: object) -> str:
    """Return the residuals and the time of a step as text, such as ", mismatch 4.2e-02, 16.4 s".

    The text is empty for a step without residuals.
    """
    residuals = [f", {name} {getattr(step, name):.1e}" for name in ("gap", "mismatch") if hasattr(step, name)]
    return "".join([*residuals, f", {getattr(step, 'seconds', math.nan):.1f} s"]) if residuals else ""


@contextmanager
def _printing() -> Iterator[None]:
    """Raise ReaderGoneError or OutputError if printing within the context fails."""
    try:
        yield
    except BrokenPipeError:
        raise ReaderGoneError("standard output was closed") from None
    except OSError as error:
        raise OutputError(f"standard output cannot be written: {error.strerror}") from None


def frame_text(frame: "pd.DataFrame", title: str) -> str:
    """Return a pandas frame as a table with a title."""
    from pandas.api.types import is_numeric_dtype

    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for column in frame.columns:
        numeric = is_numeric_dtype(frame[column])
        table.add_column(str(column), justify="right" if numeric else "left")
    for record in frame.to_dict("records"):
        # Cells are Text objects, because Rich would interpret square brackets in a string as markup.
        table.add_row(*(Text(_cell(str(column), value)) for column, value in record.items()))
    # The width is fixed, so that a table looks the same in a pipe, in a file and on a terminal. Without
    # ``force_jupyter``, Rich shows the table as an output of a notebook's cell, and the text is empty.
    # Without ``force_terminal``, the text has codes of colours if FORCE_COLOR is set, as in notebooks.
    text = io.StringIO()
    Console(file=text, width=150, force_jupyter=False, force_terminal=False).print(table)
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines()) + "\n"


def _cell(column: str, value: object) -> str:
    """Return a value as the text of a table cell, in a number format that depends on the column."""
    # Import ``sentences`` only here: it loads much of SciPy, which would delay the list of commands (--help).
    from masonry_opt.reporting.sentences import numeral

    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "–"
    if column in _RESIDUAL_COLUMNS:
        return numeral(value, ".1e")
    return numeral(value, next((spec for part, spec in _FORMATS.items() if part in column), ".5f"))

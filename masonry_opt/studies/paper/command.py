"""The command `masonry-opt reproduce`."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from masonry_opt.report.terminal import changing_line, print_text
from masonry_opt.solvers.registry import find_entry
from masonry_opt.studies.cases import CASES_HELP, case_folder
from masonry_opt.studies.paper.example import ProgressLine
from masonry_opt.studies.paper.folder import open_folder, write_report
from masonry_opt.studies.paper.registry import EXAMPLES, find_examples
from masonry_opt.studies.paper.text import report_text

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def reproduce(
    example: Annotated[
        str, typer.Argument(help=f"One of: {', '.join(EXAMPLES)}; or all of the paper's.")
    ] = "all",
    out: Annotated[Path, typer.Option(help="Folder for tables, pictures and the index page.")] = Path(
        "results"
    ),
    cases: Annotated[Path | None, typer.Option(help=CASES_HELP, show_default=False)] = None,
) -> None:
    """Rebuild results of the paper from the case files, published values beside ours.

    Exit code 0: every value is within its tolerance; 1: one is not; 2: wrong example or folder, or an extra
    is missing.
    """
    errors, missed = Console(stderr=True), False
    names, folder = find_examples(example), case_folder(cases)
    # Said now, not after minutes.
    if any(EXAMPLES[name].mpec for name in names):
        find_entry("pyomo", "casadi")
    open_folder(out)
    for name in names:
        start = time.perf_counter()
        with _progress(errors, name) as progress:
            report = EXAMPLES[name].run(folder, progress)
            seconds = time.perf_counter() - start
            page = write_report(out, name, report, seconds)[-1]
        # Each example is printed and on disk before the next begins: an interrupt loses one at most.
        print_text(report_text(EXAMPLES[name].title, report))
        errors.print(f"{name}: {seconds:.1f} s, written to {page}", markup=False, highlight=False)
        missed = missed or bool(report.missed)
    if missed:
        raise typer.Exit(1)


@contextlib.contextmanager
def _progress(console: Console, name: str) -> Iterator[ProgressLine]:
    """What is being done and for how long: on a terminal one line that changes, else a line for each part."""
    if not console.is_terminal:
        start = time.perf_counter()
        yield lambda line: print(
            f"{name}, {time.perf_counter() - start:.0f} s: {line}", file=sys.stderr, flush=True
        )
        return
    with changing_line(console, name) as show:
        yield lambda line: show(f"{name}: {line}")

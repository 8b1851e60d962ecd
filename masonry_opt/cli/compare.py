"""The command `masonry-opt compare`."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

import masonry_opt as mo
from masonry_opt.cli.shared import numbers
from masonry_opt.cli.signatures import Given, command
from masonry_opt.errors import InterruptedByUserError
from masonry_opt.studies.compare.report import OUT
from masonry_opt.studies.process import ended_by_kill
from masonry_opt.studies.writing import NEEDED
from masonry_opt.words.terminal import print_text

_SCENES = typer.Argument(metavar="CASE...", help="Case files, or names of those in --cases.")
_SOLVERS = "Also: highs-hipo, and what CVXPY finds: osqp, scs, ..."


def _names(text: str) -> list[str]:
    names = [name.strip().lower() for name in text.split(",") if name.strip()]
    return list(dict.fromkeys(names))


@command(
    mo.compare,
    methods=typer.Option(help="Separated by commas; also: global.", parser=_names),
    solvers=typer.Option(help=_SOLVERS, parser=_names),
    models=typer.Option(help="Modelling languages.", parser=_names),
    tolerances=typer.Option(
        parser=numbers("--tolerances '{}': numbers separated by commas, such as 1e-6,1e-9")
    ),
    repeats=typer.Option(min=1),
    time_limit=typer.Option(min=0.1),
    memory_limit=typer.Option(min=1),
    cases=typer.Option(help="Folder of the case files. Default: cases/ here, or else those of the package."),
)
def compare(given: Given, scenes: Annotated[list[str] | None, _SCENES] = None) -> None:
    """An interrupted comparison continues where it stopped. Exit code 0: done; 1: every run crashed or died;
    130: interrupted; 2: wrong case file or option.
    """
    errors = Console(stderr=True)
    with errors.status("comparing") as status, ended_by_kill():
        comparison = mo.compare(scenes or [], progress=lambda line: status.update(escape(line)), **given)
    print_text(str(comparison))
    folder = given.get("out", OUT)
    page = folder / "report.html"
    errors.print(
        f"written: {page}, tables and pictures beside it"
        if page.exists()
        else f"written: {folder / 'summary.csv'}; {NEEDED}",
        markup=False,
        soft_wrap=True,
    )
    if comparison.interrupted:
        raise InterruptedByUserError("interrupted: the same command continues where it stopped")

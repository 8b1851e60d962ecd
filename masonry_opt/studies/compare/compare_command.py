"""The command `masonry-opt compare`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

from masonry_opt.errors import InterruptedByUserError, OptionError
from masonry_opt.solvers.registry import LANGUAGES
from masonry_opt.studies.cases import CASES_HELP
from masonry_opt.studies.compare.answer import RunLimits
from masonry_opt.studies.compare.comparison import METHODS, OUT, SOLVERS, TOLERANCES
from masonry_opt.studies.compare.comparison import compare as compare_scenes
from masonry_opt.studies.process import ended_by_kill
from masonry_opt.studies.writing import NEEDED
from masonry_opt.words.terminal import print_text

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def compare(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="CASE...", help="Case files, or names of those in --cases.")
    ] = None,
    methods: Annotated[str, typer.Option(help="Separated by commas; also: global.")] = ",".join(METHODS),
    solvers: Annotated[
        str,
        typer.Option(
            help="Also: highs-hipo, piqp (in the extra 'solvers'), and what CVXPY finds: osqp, scs, ..."
        ),
    ] = ",".join(SOLVERS),
    models: Annotated[str, typer.Option(help="Modelling languages.")] = ",".join(LANGUAGES),
    tolerances: Annotated[str, typer.Option(help="Asked of the solvers, such as 1e-4,1e-7.")] = ",".join(
        map(str, TOLERANCES)
    ),
    repeats: Annotated[int, typer.Option(min=1, help="Runs of each; times are medians.")] = RunLimits.repeats,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds a run.")] = RunLimits.time,
    memory_limit: Annotated[
        float, typer.Option(min=1, help="MB a run, libraries included.")
    ] = RunLimits.memory,
    cases: Annotated[Path | None, typer.Option(help=CASES_HELP, show_default=False)] = None,
    update_best_known: Annotated[
        bool, typer.Option("--update-best-known", help="Write lower exact states to best_known.toml.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of results and report.")] = OUT,
) -> None:
    """Time methods and solvers on scenes, judge their answers, write tables, charts and a report.

    An interrupted comparison continues where it stopped. Exit code 0: done; 1: every run crashed or died;
    130: interrupted; 2: wrong case file or option.
    """
    errors = Console(stderr=True)
    with errors.status("comparing") as status, ended_by_kill():
        comparison = compare_scenes(
            scenes or [],
            methods=_split(methods),
            models=_split(models),
            solvers=_split(solvers),
            tolerances=_numbers(tolerances),
            repeats=repeats,
            time_limit=time_limit,
            memory_limit=memory_limit,
            out=out,
            update_best_known=update_best_known,
            cases=cases,
            progress=lambda line: status.update(escape(line)),
        )
    print_text(str(comparison))
    page = out / "report.html"
    errors.print(
        f"written: {page}, tables and pictures beside it"
        if page.exists()
        else f"written: {out / 'summary.csv'}; {NEEDED}",
        markup=False,
        soft_wrap=True,
    )
    if comparison.interrupted:
        raise InterruptedByUserError("interrupted: the same command continues where it stopped")


def _split(text: str) -> list[str]:
    names = [name.strip().lower() for name in text.split(",") if name.strip()]
    return list(dict.fromkeys(names))


def _numbers(text: str) -> list[float]:
    try:
        return [float(name) for name in _split(text)]
    except ValueError:
        raise OptionError(f"--tolerances '{text}': numbers separated by commas, such as 1e-6,1e-9") from None

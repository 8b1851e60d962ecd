"""Commands `masonry-opt sweep` and `masonry-opt compare`."""

from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

import masonry_opt as mo
from masonry_opt.cli.command import CommandArguments, command, ended_by_kill, numbers, reader, waiting
from masonry_opt.errors import InterruptedByUserError, OptionError, counted
from masonry_opt.files import WRITER
from masonry_opt.reporting.terminal import print_result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.studies.compare.comparison import DEFAULT_FOLDER
from masonry_opt.studies.many.draws import JOINT_GROUPS, parse
from masonry_opt.studies.many.sweep import summary_text
from masonry_opt.studies.writing import MISSING_LIBRARY_MESSAGE

#: Largest number of values that --vary accepts for one parameter of the scene. More values raise an error.
_MOST_VALUES = 100_000
_FORMS = "NAME=FROM:TO:COUNT or NAME=VALUE,VALUE,..."  #: Forms of the value of option --vary.
_VARY_EXAMPLE = "such as joints.friction=0.3:0.8:11"  #: Example of the option --vary.
#: Help of the option --vary. A narrow terminal would cut an example off, so only the help text of the command
#: contains an example.
_VARY = "Name and values of a parameter of CASE, in a form shown above; may be repeated."
#: Help of the option --sample.
_SAMPLE = (
    "Instead of --vary: name and distribution of a parameter of CASE, in a form shown above; may be repeated."
)
_SOLVERS = (
    "Solvers, separated by commas. Besides the default solvers, highs-hipo and installed solvers of CVXPY, "
    "such as osqp, are possible."
)
_TOLERANCES = "--tolerances '{}': write numbers separated by commas, such as 1e-6,1e-9"


@partial(reader, refusal=f"--vary '{{}}': write it as {_FORMS}, {_VARY_EXAMPLE}")
def _vary(text: str) -> tuple[str, list[float]]:
    """Parse the text of option --vary: the name of a parameter of the scene, and its values.

    Raises ValueError if the text does not have one of the two forms.
    """
    name, _, value_text = text.partition("=")
    if ":" not in value_text:
        values = [float(value) if set(value) & set(".eE") else int(value) for value in value_text.split(",")]
    else:
        first, last, count = value_text.split(":")
        if not 1 <= int(count) <= _MOST_VALUES:
            raise ValueError
        # Rounding to 12 digits avoids values such as 0.35000000000000003 in tables.
        values = [float(f"{value:.12g}") for value in np.linspace(float(first), float(last), int(count))]
    if not name:
        raise ValueError
    return name, values


@command(
    mo.sweep,
    mo.sample,
    mo.solve,
    labels=("", "With --sample"),
    leave="settled",
    vary=typer.Option("--vary", metavar="NAME=VALUES", help=_VARY, parser=_vary),
    distributions=typer.Option("--sample", metavar="NAME=DISTRIBUTION", help=_SAMPLE, parser=parse),
    n=typer.Option("-n", "--runs", min=1),
    seed=typer.Option(min=0),
    by=typer.Option(help=f"With --sample: which joints share one random value ({', '.join(JOINT_GROUPS)})."),
    workers=typer.Option(min=1),
    force=typer.Option(
        "--force", help=f"Replace the table of another study, and existing files that {WRITER} did not write."
    ),
    out=typer.Option(help="Folder to which the table and the charts are written."),
)
def sweep(arguments: CommandArguments, case: Path, out: Path, load_case: str | None = None) -> None:
    """Write the results of all runs to a table (runs.csv) and charts; --sample also prints statistics of λ.

    Values: --vary NAME=FROM:TO:COUNT or --vary NAME=VALUE,VALUE,..., such as joints.friction=0.3:0.8:11 or
    arch.thickness=0.3,0.4.

    Distributions: --sample NAME=lognormal:MEAN:DEVIATION (the standard deviation as a number, or as a
    percentage of the mean such as 15%), NAME=normal:MEAN:DEVIATION or NAME=uniform:LEAST:GREATEST.

    Repeat the command to continue an interrupted sweep where it stopped. Exit code 0: the sweep is complete;
    1: no run was solved, and the message says why; 130: interrupted; 2: wrong case file, name or option.
    """
    vary, drawn = arguments.pop("vary", None), arguments.pop("distributions", None)
    if bool(vary) == bool(drawn):
        raise OptionError("give either --vary NAME=FROM:TO:COUNT, or --sample NAME=lognormal:MEAN:DEVIATION")
    of_sample = signature(mo.sample).parameters.keys() - signature(mo.sweep).parameters.keys()
    refused = [arguments.called[name] for name in arguments if name in of_sample]
    if vary and refused:
        raise OptionError(
            f"{', '.join(refused)} cannot be used with --vary: use --sample instead of --vary, or omit "
            "every option that needs --sample"
        )
    values = dict(vary or drawn)
    if len(values) < len(vary or drawn):
        raise OptionError(
            f"{'--vary' if vary else '--sample'} names a parameter twice: name each parameter only once"
        )
    run: Any = mo.sweep if vary else mo.sample
    options = arguments.keywords_for(run)
    scene = as_scene(case, load_case)
    errors = Console(stderr=True)
    columns = (TextColumn("sweep"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as bar:
        task = bar.add_task("sweep", total=None)

        def progress(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        try:
            with ended_by_kill():
                answer = run(scene, values, out=out, progress=progress, **options)
        except KeyboardInterrupt:
            complete = counted(int(bar.tasks[0].completed), "complete run")
            raise InterruptedByUserError(
                f"interrupted: {complete} in the table; repeat the command to continue the sweep"
            ) from None
    print_result(summary_text(answer, list(values)) if vary else str(answer), bold_line=1 if vary else None)
    charts = (
        ", with charts in the same folder"
        if (out / "charts.html").exists()
        else f"; {MISSING_LIBRARY_MESSAGE}"
    )
    errors.print(f"written: {out / 'runs.csv'}{charts}", markup=False, soft_wrap=True)


def _names(text: str) -> list[str]:
    """Parse names that are separated by commas, and return the names in lower case without repetitions."""
    return [*dict.fromkeys(name.strip().lower() for name in text.split(",") if name.strip())]


@command(
    mo.compare,
    methods=typer.Option(
        help="Methods, separated by commas. Methods that do not run by default, such as global, are allowed.",
        parser=_names,
    ),
    solvers=typer.Option(help=_SOLVERS, parser=_names),
    models=typer.Option(help="Modelling languages.", parser=_names),
    tolerances=typer.Option(parser=numbers(_TOLERANCES)),
    repeats=typer.Option(min=1),
    time_limit=typer.Option(min=0.1),
    memory_limit=typer.Option(min=1),
    cases=typer.Option(
        help="Folder of the case files. Default: ./cases if it contains the cases of the paper; otherwise "
        "the folder in the package."
    ),
    scenes=typer.Argument(metavar="CASE", help="Case files, or names of cases in the folder --cases."),
)
def compare(arguments: CommandArguments, scenes: list[str] | None = None) -> None:
    """Run each method with each solver on each scene.

    To continue an interrupted comparison, repeat the command.

    Exit code 0: the comparison is complete; 1: every run crashed or was killed; 130: interrupted; 2: wrong
    case file or option.
    """
    with waiting("comparing") as work, ended_by_kill():
        comparison = mo.compare(scenes or [], progress=work.show, **arguments)
    print_result(str(comparison), bold_line=None)
    folder = arguments.get("out", DEFAULT_FOLDER)
    page, table = folder / "report.html", folder / "summary.csv"
    written = (
        f"{page}; tables and pictures are in the same folder"
        if page.exists()
        else f"{table}; {MISSING_LIBRARY_MESSAGE}"
    )
    Console(stderr=True).print(f"written: {written}", markup=False, soft_wrap=True)
    if comparison.interrupted:
        raise InterruptedByUserError("interrupted: repeat the command to continue the comparison")

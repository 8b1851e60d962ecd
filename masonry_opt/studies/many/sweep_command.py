"""The command `masonry-opt sweep`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from masonry_opt.command_options import LoadCaseName, Model, OwnOptions, SolverName, Tolerance, method_options
from masonry_opt.errors import InterruptedByUserError, OptionError, counted
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.scene.case_file import as_scene
from masonry_opt.studies.many.distributions import parse
from masonry_opt.studies.many.draws import BY, SEQUENCES
from masonry_opt.studies.many.sample import RUNS
from masonry_opt.studies.many.sample import sample as sample_scene
from masonry_opt.studies.many.sweep import said
from masonry_opt.studies.many.sweep import sweep as sweep_scene
from masonry_opt.studies.process import ended_by_kill
from masonry_opt.studies.writing import NEEDED
from masonry_opt.words.terminal import print_text

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)

#: Most values of one number.
_MOST_VALUES = 100_000


@app.command()
def sweep(
    case: Annotated[Path, typer.Argument(help="Case file (.toml or .json).", show_default=False)],
    out: Annotated[Path, typer.Option(help="Folder of the table and charts.", show_default=False)],
    vary: Annotated[
        list[str] | None,
        typer.Option(
            help="NAME=FROM:TO:COUNT or NAME=VALUE,VALUE,... of a number of the case, such as "
            "joints.friction=0.3:0.8:11 or arch.thickness=0.3,0.4; may be repeated.",
            show_default=False,
        ),
    ] = None,
    sample: Annotated[
        list[str] | None,
        typer.Option(
            help="In place of --vary, NAME=lognormal:MEAN:DEVIATION (of the number itself; or 15% of the "
            "mean), NAME=normal:MEAN:DEVIATION or NAME=uniform:LEAST:GREATEST; may be repeated.",
            show_default=False,
        ),
    ] = None,
    runs: Annotated[
        int | None,
        typer.Option(
            "-n", "--runs", min=1, help=f"With --sample: runs. Default: {RUNS}.", show_default=False
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="With --sample: of the draws. Default: 0.", show_default=False),
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(
            help=f"With --sample, of properties of joints: {', '.join(BY)}. Default: {BY[0]}.",
            show_default=False,
        ),
    ] = None,
    correlation: Annotated[
        float | None,
        typer.Option(help="With --by: between joints (of one course).", show_default=False),
    ] = None,
    sequence: Annotated[
        str | None,
        typer.Option(help=f"With --sample: {', '.join(SEQUENCES)}. Default: by how many numbers are drawn."),
    ] = None,
    load_case: LoadCaseName = None,
    method: Annotated[str, typer.Option(help=f"One of: {', '.join(METHODS)}.")] = DEFAULT,
    model: Model = None,
    solver: SolverName = None,
    tolerance: Tolerance = None,
    expected: Annotated[
        bool, typer.Option(help="Also the load to expect of each run, a column of the table.")
    ] = True,
    option: OwnOptions = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes. Default: one a core.", show_default=False)
    ] = None,
    dask: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, in place of processes.")
    ] = None,
    parquet: Annotated[bool, typer.Option("--parquet", help="Also runs.parquet.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace a table that has other runs.")] = False,
) -> None:
    """Solve CASE for every combination of values of its numbers, or for values drawn from distributions.

    Writes a table (runs.csv) and charts; of drawn values also what they say of the load factor.

    An interrupted sweep goes on where it stopped. Exit code 0: done, whatever the runs found; 130:
    interrupted; 2: wrong case file, name or option.
    """
    if bool(vary) == bool(sample):
        raise OptionError("give --vary NAME=FROM:TO:COUNT or --sample NAME=lognormal:MEAN:DEVIATION")
    given = {"n": runs, "seed": seed, "by": by, "correlation": correlation, "sequence": sequence}
    drawing: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    if vary and drawing:
        named = ", ".join("--runs" if name == "n" else f"--{name}" for name in drawing)
        raise OptionError(f"{named}: goes with --sample, not with --vary, whose values are given")
    values, distributions = dict(map(_values, vary or [])), dict(map(parse, sample or []))
    if len(values) + len(distributions) < len(vary or sample or []):
        raise OptionError(f"{'--vary' if vary else '--sample'}: a number is named twice")
    common: dict[str, Any] = {
        "method": method,
        "model": model,
        "solver": solver,
        "tolerance": tolerance,
        "expected": expected,
        "out": out,
        "parquet": parquet,
        "force": force,
        "workers": workers,
        "dask": dask,
        **method_options(option, sample_scene if sample else sweep_scene),
    }
    scene = as_scene(case, load_case)
    errors, done = Console(stderr=True), 0
    columns = (TextColumn("sweep"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as bar:
        shown = bar.add_task("sweep", total=None)

        def progress(count: int, of: int) -> None:
            nonlocal done
            done = count
            bar.update(shown, completed=count, total=of)

        try:
            with ended_by_kill():
                if sample:
                    told = str(sample_scene(scene, distributions, progress=progress, **drawing, **common))
                else:
                    told = said(sweep_scene(scene, values, progress=progress, **common), list(values))
        except KeyboardInterrupt:
            raise InterruptedByUserError(
                f"interrupted: {counted(done, 'run')} kept, and the same command goes on from there"
            ) from None
    print_text(told)
    beside = ", charts beside it" if (out / "charts.html").exists() else f"; {NEEDED}"
    errors.print(f"written: {out / 'runs.csv'}{beside}", markup=False, soft_wrap=True)


def _values(text: str) -> tuple[str, list[float]]:
    """A number's name and its values."""
    name, equals, given = text.partition("=")
    try:
        if ":" in given:
            first, last, count = given.split(":")
            if not 1 <= int(count) <= _MOST_VALUES:
                raise ValueError
            # Rounded to what is written in a table: 0.35, not 0.35000000000000003.
            values = [float(f"{value:.12g}") for value in np.linspace(float(first), float(last), int(count))]
        else:
            values = [float(value) if set(value) & set(".eE") else int(value) for value in given.split(",")]
        if not equals or not name:
            raise ValueError
    except ValueError:
        raise OptionError(
            f"--vary '{text}': write it as NAME=FROM:TO:COUNT or NAME=VALUE,VALUE,..., such as "
            "joints.friction=0.3:0.8:11"
        ) from None
    return name, values

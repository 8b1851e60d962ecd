"""The command `masonry-opt crossing`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from masonry_opt.command_options import (
    Force,
    Json,
    LoadCaseName,
    Model,
    OwnOptions,
    SolverName,
    Tolerance,
    method_options,
)
from masonry_opt.errors import InterruptedByUserError, OutputError, counted
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.studies.crossing.crossing import crossing as cross
from masonry_opt.words.sentences import numeral
from masonry_opt.words.terminal import frame_text, print_text

#: Columns of the table that are printed.
_TOLD = ["axles", "direction", "position", "load_factor", "mechanism", "status"]

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def crossing(
    case: Annotated[Path, typer.Argument(help="Case file (.toml or .json).", show_default=False)],
    axles: Annotated[
        str | None, typer.Option(metavar="NAME", help="One group of the case. Default: all.")
    ] = None,
    load_case: LoadCaseName = None,
    method: Annotated[str, typer.Option(help=f"One of: {', '.join(METHODS)}.")] = DEFAULT,
    model: Model = None,
    solver: SolverName = None,
    tolerance: Tolerance = None,
    expected: Annotated[bool, typer.Option(help="At the worst position also the load to expect.")] = True,
    json: Json = False,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Draw λ by position and the mechanism (.png, .svg, .pdf), or a page (.html)."
        ),
    ] = None,
    force: Force = False,
    table: Annotated[bool, typer.Option("--table", help="Print λ at every position solved too.")] = False,
    option: OwnOptions = None,
) -> None:
    """Move the axles of CASE over its road: the load factor by position, and the worst.

    Exit code 0: there is a load factor; 1: there is none, the status says why; 2: wrong case file or option;
    130: interrupted, with what was found by then.
    """
    if plot is not None:
        from masonry_opt.drawing.figure import refuse_file

        refuse_file(plot, force)
    with Console(stderr=True).status("crossing") as status:

        def progress(position: float, load_factor: float) -> None:
            said = numeral(load_factor, ".6f") if math.isfinite(load_factor) else "none"
            status.update(f"first axle at {position:.4g}: λ = {said}")

        try:
            found = cross(
                case,
                axles,
                method=method,
                model=model,
                solver=solver,
                tolerance=tolerance,
                expected=expected,
                load_case=load_case,
                progress=progress,
                **method_options(option, cross),
            )
        except KeyboardInterrupt:
            raise InterruptedByUserError("interrupted: nothing was found") from None
    print_text(found.to_json() if json else str(found))
    if table and not json and found.passages:
        print_text(frame_text(found.table[_TOLD], "positions"))
    if plot is not None and found.passages:
        try:
            found.save(plot, force)
        except OSError as error:
            raise OutputError(f"{plot}: cannot be written: {error.strerror}") from None
    if found.interrupted:
        raise InterruptedByUserError(f"interrupted: {counted(len(found.table), 'position')} solved")
    if found.load_factor is None:
        raise typer.Exit(1)

"""The command `masonry-opt directions`."""

from __future__ import annotations

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
    method_options,
)
from masonry_opt.drawing.figure import refuse_picture
from masonry_opt.errors import OptionError, OutputError, printable
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.studies.load_cases.directions import EVERY
from masonry_opt.studies.load_cases.directions import directions as solve_directions
from masonry_opt.words.terminal import changing_line, print_result, print_text

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def directions(
    case: Annotated[Path, typer.Argument(help="Case file (.toml or .json).", show_default=False)],
    every: Annotated[float, typer.Option(help="In space: degrees between directions in plan.")] = EVERY,
    vertical: Annotated[
        str | None,
        typer.Option(
            metavar="RATIO[,RATIO]",
            help="Vertical part over the horizontal one, positive with gravity, as in --vertical=0.3,-0.3. "
            "Default: that of the case's own earthquake, else 0.",
        ),
    ] = None,
    load_case: LoadCaseName = None,
    method: Annotated[str, typer.Option(help=f"One of: {', '.join(METHODS)}.")] = DEFAULT,
    model: Model = None,
    solver: SolverName = None,
    expected: Annotated[bool, typer.Option(help="As of solve.")] = True,
    option: OwnOptions = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw them as a polar chart (.png, .svg, .pdf).")
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Find the seismic coefficient at which CASE collapses, for earthquakes from all sides.

    Exit code 0: there is one for each direction; 1: for some there is none; 2: wrong case file or option.
    """
    if plot is not None:  # refused now, not after the solves
        refuse_picture(plot, force)
    name = printable(case.name)
    with changing_line(Console(stderr=True), name) as show:
        found = solve_directions(
            case,
            method,
            every=every,
            vertical=_ratios(vertical),
            load_case=load_case,
            model=model,
            solver=solver,
            expected=expected,
            phases=lambda phase: show(f"{name}: {phase}"),
            **method_options(option, solve_directions),
        )
    if json:
        print_text(found.to_json())
    else:
        print_result(found.summary)
    if plot is not None:
        try:
            found.save(plot, force)
        except OSError as error:
            raise OutputError(f"{plot}: cannot be written: {error.strerror}") from None
    if not found.usable:
        raise typer.Exit(1)


def _ratios(text: str | None) -> list[float] | None:
    try:
        return None if text is None else [float(ratio) for ratio in text.split(",")]
    except ValueError:
        raise OptionError(
            f"--vertical {text}: write one number or several, as in --vertical=0.3,-0.3"
        ) from None

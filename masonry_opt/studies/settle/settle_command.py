"""The command `masonry-opt settle`."""

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
    Tolerance,
    View,
    angles,
    method_options,
)
from masonry_opt.drawing.view import refuse_view
from masonry_opt.errors import InterruptedByUserError, OptionError, OutputError
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.scene.case_file import load
from masonry_opt.studies.settle.settle import settle as find
from masonry_opt.words.terminal import print_text

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def settle(
    case: Annotated[Path, typer.Argument(help="Case file (.toml or .json).", show_default=False)],
    support: Annotated[
        list[str],
        typer.Option(help="Name of a fixed block; of several, once for each.", show_default=False),
    ],
    direction: Annotated[
        str, typer.Option(metavar="X,Y[,Z]", help="In which it settles, such as 0,-1.", show_default=False)
    ],
    turns: Annotated[bool, typer.Option("--turns", help="Each support may turn too.")] = False,
    load_case: LoadCaseName = None,
    method: Annotated[str, typer.Option(help=f"One of: {', '.join(METHODS)}.")] = DEFAULT,
    model: Model = None,
    solver: SolverName = None,
    tolerance: Tolerance = None,
    expected: Annotated[bool, typer.Option(help="Also the reactions to expect.")] = True,
    json: Json = False,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Draw what moves at one end (.png, .svg, .pdf), or a page of both (.html)."
        ),
    ] = None,
    greatest: Annotated[
        bool, typer.Option("--greatest", help="With --plot: at the greatest reaction, not the least.")
    ] = False,
    view: View = None,
    force: Force = False,
    option: OwnOptions = None,
) -> None:
    """Find the least and the greatest reaction of a support of CASE, in one direction, with which it stands.

    Exit code 0: both were found, or that there is no end; 1: no reaction holds CASE, or an end was not found;
    2: wrong case file or option.
    """
    seen_from = angles(view)
    if plot is not None:
        from masonry_opt.drawing.figure import refuse_file

        refuse_file(plot, force)
        refuse_view(load(case), seen_from)
    elif greatest or force or view is not None:
        raise OptionError("--greatest, --view and --force say how to draw: give --plot FILE too")
    with Console(stderr=True).status("settle") as status:
        try:
            found = find(
                case,
                support,
                _numbers(direction),
                turns=turns,
                load_case=load_case,
                method=method,
                model=model,
                solver=solver,
                tolerance=tolerance,
                expected=expected,
                phases=lambda words: status.update(f"settle: {words}"),
                **method_options(option, find),
            )
        except KeyboardInterrupt:
            raise InterruptedByUserError("interrupted: nothing was found") from None
    print_text(found.to_json() if json else str(found))
    if plot is not None:
        try:
            found.save(plot, "greatest" if greatest else "least", force=force, view=seen_from)
        except OSError as error:
            raise OutputError(f"{plot}: cannot be written: {error.strerror}") from None
    if not found.usable:
        raise typer.Exit(1)


def _numbers(text: str) -> list[float]:
    """The numbers of a text such as 0,-1."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise OptionError(f"--direction {text}: write it as X,Y or X,Y,Z, such as 0,-1") from None

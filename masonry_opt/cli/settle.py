"""The command `masonry-opt settle`."""

from __future__ import annotations

from typing import Annotated

import typer

from masonry_opt.cli.options import Case, Json, PlotOrPage, numbers
from masonry_opt.cli.running import waiting, writing
from masonry_opt.cli.signatures import Given, command
from masonry_opt.drawing.view import refuse_view
from masonry_opt.errors import OptionError
from masonry_opt.scene.case_file import load
from masonry_opt.studies.settle.settle import Settlement
from masonry_opt.studies.settle.settle import settle as find
from masonry_opt.studies.writing import refuse_saving
from masonry_opt.words.terminal import print_text

_GREATEST = "With --plot: at the greatest reaction, not the least."


@command(
    find,
    Settlement.save,
    leave="end kind",
    direction=typer.Option(
        metavar="X,Y[,Z]", parser=numbers("--direction {}: write it as X,Y or X,Y,Z, such as 0,-1")
    ),
)
def settle(
    given: Given,
    case: Case,
    json: Json = False,
    plot: PlotOrPage = None,
    greatest: Annotated[bool, typer.Option("--greatest", help=_GREATEST)] = False,
) -> None:
    """Exit code 0: both were found, or that there is no end; 1: no reaction holds CASE, or an end was not found;
    2: wrong case file or option.
    """
    drawing = given.take(Settlement.save)
    if plot is not None:
        refuse_saving(plot, drawing.get("force", False))
        refuse_view(load(case), drawing.get("view"))
    elif greatest or drawing:
        raise OptionError("--greatest, --view and --force say how to draw: give --plot FILE too")
    with waiting("settle") as show:
        found = find(case, phases=lambda words: show(f"settle: {words}"), **given.rest())
    print_text(found.to_json() if json else str(found))
    if plot is not None:
        with writing(plot):
            found.save(plot, "greatest" if greatest else "least", **drawing)
    if not found.usable:
        raise typer.Exit(1)

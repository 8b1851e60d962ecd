"""The command `masonry-opt directions`."""

from __future__ import annotations

import typer
from rich.console import Console

from masonry_opt.analysis import solve
from masonry_opt.cli.options import Case, Json, Plot, numbers
from masonry_opt.cli.running import writing
from masonry_opt.cli.signatures import Given, command
from masonry_opt.drawing.figure import refuse_picture
from masonry_opt.errors import printable
from masonry_opt.studies.load_cases.cases import Cases
from masonry_opt.studies.load_cases.directions import directions as solve_directions
from masonry_opt.words.terminal import changing_line, print_result, print_text


@command(
    solve_directions,
    solve,
    Cases.save,
    leave="tolerance",
    vertical=typer.Option(
        metavar="RATIO[,RATIO]",
        help="Vertical part over the horizontal one, positive with gravity, as in --vertical=0.3,-0.3. "
        "Default: that of the case's own earthquake, else 0.",
        parser=numbers("--vertical {}: write one number or several, as in --vertical=0.3,-0.3"),
    ),
)
def directions(given: Given, case: Case, plot: Plot = None, json: Json = False) -> None:
    """Exit code 0: there is one for each direction; 1: for some there is none; 2: wrong case file or option."""
    drawing = given.take(Cases.save)
    if plot is not None:  # refused now, not after the solves
        refuse_picture(plot, **drawing)
    name = printable(case.name)
    with changing_line(Console(stderr=True), name) as show:
        found = solve_directions(case, phases=lambda phase: show(f"{name}: {phase}"), **given.rest())
    if json:
        print_text(found.to_json())
    else:
        print_result(found.summary)
    if plot is not None:
        with writing(plot):
            found.save(plot, **drawing)
    if not found.usable:
        raise typer.Exit(1)

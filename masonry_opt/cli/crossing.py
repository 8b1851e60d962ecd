"""The command `masonry-opt crossing`."""

from __future__ import annotations

import math

import typer

from masonry_opt.cli.options import Case, Json, PlotOrPage, Table
from masonry_opt.cli.running import waiting, writing
from masonry_opt.cli.signatures import Given, command
from masonry_opt.errors import InterruptedByUserError, counted
from masonry_opt.studies.crossing.crossing import Crossing
from masonry_opt.studies.crossing.crossing import crossing as cross
from masonry_opt.studies.writing import refuse_saving
from masonry_opt.words.sentences import numeral
from masonry_opt.words.terminal import frame_text, print_text

#: Columns of the table that are printed.
_TOLD = ["axles", "direction", "position", "load_factor", "mechanism", "status"]


@command(
    cross,
    Crossing.save,
    leave="position",
    axles=typer.Option(metavar="NAME", help="One group of the case. Default: all.", parser=str),
)
def crossing(
    given: Given, case: Case, plot: PlotOrPage = None, table: Table = False, json: Json = False
) -> None:
    """Exit code 0: there is a load factor; 1: there is none, the status says why; 2: wrong case file or option;
    130: interrupted, with what was found by then.
    """
    drawing = given.take(Crossing.save)
    if plot is not None:
        refuse_saving(plot, **drawing)
    with waiting("crossing") as show:

        def progress(position: float, load_factor: float) -> None:
            said = numeral(load_factor, ".6f") if math.isfinite(load_factor) else "none"
            show(f"first axle at {position:.4g}: λ = {said}")

        found = cross(case, progress=progress, **given.rest())
    print_text(found.to_json() if json else str(found))
    if table and not json and found.passages:
        print_text(frame_text(found.table[_TOLD], "positions"))
    if plot is not None and found.passages:
        with writing(plot):
            found.save(plot, **drawing)
    if found.interrupted:
        raise InterruptedByUserError(f"interrupted: {counted(len(found.table), 'position')} solved")
    if found.load_factor is None:
        raise typer.Exit(1)

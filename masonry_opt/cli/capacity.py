"""The command `masonry-opt capacity`."""

from __future__ import annotations

import csv
import json as json_module
from pathlib import Path
from typing import Annotated

import typer

import masonry_opt as mo
from masonry_opt.cli.shared import Case, Json, Plot, Table, numbers, tell
from masonry_opt.cli.signatures import Given, command
from masonry_opt.drawing.figure import refuse_picture
from masonry_opt.errors import OptionError
from masonry_opt.words.terminal import frame_text

_POINT = typer.Option(
    metavar="X,Y",
    help="With --block: a point of it. Default: its centroid.",
    parser=numbers("--point {}: write it as X,Y, such as 0.5,2", 2),
)
_SPECTRUM = "Check against a spectrum: lines of period (s), acceleration (g)."


@command(
    mo.solve,
    mo.capacity,
    mo.Capacity.check,
    mo.Capacity.save,
    labels=("", "", "With --spectrum", ""),
    leave="model solver tolerance expected ultimate secant row",
    point=_POINT,
)
def capacity(
    given: Given,
    case: Case,
    spectrum: Annotated[Path | None, typer.Option(metavar="FILE", help=_SPECTRUM)] = None,
    plot: Plot = None,
    table: Table = False,
    json: Json = False,
) -> None:
    """Exit code 0: the curve comes down to λ = 0; 1: it stops before, or there is no load factor; 2: wrong
    case file or option.
    """
    drawing, checking = given.take(mo.Capacity.save), given.take(mo.Capacity.check)
    following = given.take(mo.capacity)
    if plot is not None:
        refuse_picture(plot, **drawing)
    periods = None if spectrum is None else _spectrum(spectrum)
    found = mo.capacity(mo.solve(case, expected=False, **given.rest()), **following)
    check = None if periods is None else found.check(periods, **checking)
    if json:
        told = found.as_dict() | {"check": check.as_dict() if check else None}
        text = json_module.dumps(told, allow_nan=False, ensure_ascii=False)
    else:
        states = [frame_text(found.table.drop(columns="pairs"), "states")] if table else []
        text = "\n".join([str(found), *([str(check)] if check else []), *states])
    tell(text, found, found.reaches_zero, plot, drawing)


def _spectrum(path: Path) -> list[tuple[float, float]]:
    pairs: list[tuple[float, float]] = []
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            lines = csv.reader(stream)
            for line in lines:
                if line and not line[0].startswith("#"):
                    period, acceleration = map(float, line)
                    pairs.append((period, acceleration))
    except OSError as error:
        raise OptionError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise OptionError(f"{path}: is no text") from None
    except (ValueError, csv.Error):
        raise OptionError(
            f"{path}: line {lines.line_num}: a spectrum has a period (s) and an acceleration (g) on each "
            "line, as in 0.15,0.45; begin other lines with #"
        ) from None
    return pairs

"""The command `masonry-opt capacity`."""

from __future__ import annotations

import csv
import json as json_module
from pathlib import Path
from typing import Annotated

import typer

from masonry_opt.analysis import solve
from masonry_opt.command_options import Force, Json, LoadCaseName, OwnOptions, method_options
from masonry_opt.drawing.figure import refuse_picture
from masonry_opt.errors import OptionError
from masonry_opt.finite_motion.capacity import STEPS
from masonry_opt.finite_motion.capacity import capacity as follow
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.scene.case_file import as_scene
from masonry_opt.words.terminal import frame_text, print_text

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def capacity(
    case: Annotated[Path, typer.Argument(help="Case file (.toml or .json).", show_default=False)],
    method: Annotated[str, typer.Option(help=f"Of the onset: {', '.join(METHODS)}.")] = DEFAULT,
    load_case: LoadCaseName = None,
    block: Annotated[
        str | None, typer.Option(help="Block whose displacement is told. Default: the live load's.")
    ] = None,
    point: Annotated[
        str | None, typer.Option(metavar="X,Y", help="With --block: a point of it. Default: its centroid.")
    ] = None,
    steps: Annotated[int, typer.Option(help="States down to λ = 0, about.")] = STEPS,
    spectrum: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Check against a spectrum: lines of period (s), acceleration (g)."),
    ] = None,
    gravity: Annotated[float, typer.Option(help="With --spectrum: in lengths of the case per s².")] = 9.81,
    behaviour_factor: Annotated[float, typer.Option(help="With --spectrum: q.")] = 2.0,
    confidence_factor: Annotated[float, typer.Option(help="With --spectrum: FC.")] = 1.35,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the curve (.png, .svg, .pdf).")
    ] = None,
    force: Force = False,
    option: OwnOptions = None,
    table: Annotated[bool, typer.Option("--table", help="Print the states too.")] = False,
    json: Json = False,
) -> None:
    """Follow the mechanism of CASE after the onset of collapse, down to λ = 0.

    Exit code 0: the curve comes down to λ = 0; 1: it stops before, or there is no load factor; 2: wrong case
    file or option.
    """
    if plot is not None:
        refuse_picture(plot, force)
    place, periods = _point(point), None if spectrum is None else _spectrum(spectrum)
    result = solve(as_scene(case, load_case), method, expected=False, **method_options(option, solve))
    found = follow(result, block=block, point=place, steps=steps)
    check = None
    if periods is not None:
        check = found.check(
            periods,
            gravity=gravity,
            behaviour_factor=behaviour_factor,
            confidence_factor=confidence_factor,
        )
    if plot is not None:
        found.save(plot, force=force)
    if json:
        told = found.as_dict() | {"check": check.as_dict() if check else None}
        print_text(json_module.dumps(told, allow_nan=False, ensure_ascii=False))
    else:
        print_text(str(found) + (f"\n{check}" if check else ""))
        if table:
            print_text(frame_text(found.table.drop(columns="pairs"), "states"))
    if not found.reaches_zero:
        raise typer.Exit(1)


def _point(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    try:
        x, y = map(float, text.split(","))
    except ValueError:
        raise OptionError(f"--point {text}: write it as X,Y, such as 0.5,2") from None
    return x, y


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

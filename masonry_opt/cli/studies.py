"""The commands `masonry-opt capacity`, `crossing`, `directions`, `least`, `report` and `settle`."""

import csv
import json as json_module
import math
from functools import partial
from pathlib import Path
from typing import Any

import typer
from rich.console import Console

import masonry_opt as mo
from masonry_opt.cli.command import (
    PICTURE,
    Given,
    command,
    interrupts,
    numbers,
    print_json,
    reader,
    save,
    waiting,
)
from masonry_opt.drawing.figure import refuse_file, refuse_picture
from masonry_opt.drawing.solids import refuse_view
from masonry_opt.effort import Phases
from masonry_opt.errors import InterruptedByUserError, OptionError, counted, printable
from masonry_opt.files import writing
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.load_cases.cases import Cases
from masonry_opt.studies.many.least import Trial
from masonry_opt.studies.many.parameters import Parameters
from masonry_opt.studies.report.report import refuse_report
from masonry_opt.words.sentences import numeral
from masonry_opt.words.terminal import frame_text, print_result, print_text, print_warnings

_AXLES = typer.Option(metavar="NAME", help="One group of the case. Default: all.", parser=str)
_IN_CASE = typer.Option(metavar="NAME", help="One load case. Default: all in which axles cross.")
_VERTICAL = typer.Option(
    metavar="RATIO[,RATIO]",
    help="Vertical part over the horizontal one, positive with gravity, as in --vertical=0.3,-0.3. Default: "
    "that of the case's own earthquake, else 0.",
    parser=numbers("--vertical {}: write one number or several, as in --vertical=0.3,-0.3"),
)
_direction = numbers("--direction {}: write it as X,Y or X,Y,Z, such as 0,-1")
_point = numbers("--point {}: write it as X,Y or X,Y,Z, such as 0.5,2")
_OF_BLOCK = "With --block: a point of it. Default: its centroid."
_SPECTRUM = "Check against a spectrum: lines of period (s), acceleration (g)."
_PAGE = "The page (.html). Default: CASE_report.html, here."


@command(
    mo.solve,
    mo.capacity,
    mo.Capacity.check,
    mo.Capacity.save,
    labels=("", "", "With --spectrum", ""),
    leave="model solver tolerance incremental ultimate secant row",
    point=typer.Option(metavar="X,Y[,Z]", help=_OF_BLOCK, parser=_point),
    spectrum=typer.Option(metavar="FILE", help=_SPECTRUM),
    plot=PICTURE,
)
def capacity(
    given: Given,
    case: Path,
    spectrum: Path | None = None,
    plot: Path | None = None,
    table: bool = False,
    json: bool = False,
) -> bool:
    """Exit code 0: the curve comes down to λ = 0; 1: it stops before, or there is no load factor; 2: wrong
    case file or option."""
    drawing, checking = given.take(mo.Capacity.save), given.take(mo.Capacity.check)
    following = given.take(mo.capacity)
    if plot is not None:
        refuse_picture(plot, **drawing)
    periods = None if spectrum is None else _spectrum(spectrum)
    with waiting("capacity", json) as work:
        steps: dict[str, Any] = {"phases": work.phase, "progress": work.step}
        onset = mo.solve(case, incremental=False, **steps, **given.rest(mo.solve))
        work.phase("following the mechanism")
        found = mo.capacity(onset, **following)
    check = None if periods is None else found.check(periods, **checking)
    if json:
        told = found.as_dict() | {"check": check.as_dict() if check else None}
        print_text(json_module.dumps(told, allow_nan=False, ensure_ascii=False))
        print_warnings(found.warning_sentences)
    else:
        states = [frame_text(found.table.drop(columns="pairs"), "states")] if table else []
        print_result("\n".join([str(found), *([str(check)] if check else []), *states]), bold_line=None)
    save(found, plot, drawing)
    return found.reaches_zero


@command(mo.crossing, mo.solve, mo.Crossing.save, leave="position", axles=_AXLES, load_case=_IN_CASE)
def crossing(
    given: Given, case: Path, plot: Path | None = None, table: bool = False, json: bool = False
) -> bool:
    """Exit code 0: there is a load factor; 1: there is none, the status says why; 2: wrong case file or
    option; 130: interrupted, with what was found by then."""
    drawing = given.take(mo.Crossing.save)
    if plot is not None:  # refused now, not after the solves
        refuse_file(plot, **drawing)
    with waiting("crossing", json) as work:

        def progress(position: float, load_factor: float) -> None:
            said = numeral(load_factor, ".6f") if math.isfinite(load_factor) else "none"
            work.show(f"crossing: first axle at {position:.4g}: λ = {said}")

        found = mo.crossing(case, progress=progress, phases=work.phase, **given.rest(mo.crossing))
    states = "\n" + frame_text(found.told, "positions") if table and found.passages else ""
    if json:
        print_json(found)
    else:
        print_result(f"{found}{states}", bold_line=None)
    save(found, plot if found.passages else None, drawing)
    if found.interrupted:
        raise InterruptedByUserError(f"interrupted: {counted(len(found.table), 'position')} solved")
    return found.load_factor is not None


@command(mo.directions, mo.solve, Cases.save, leave="tolerance", vertical=_VERTICAL, plot=PICTURE)
def directions(given: Given, case: Path, plot: Path | None = None, json: bool = False) -> bool:
    """Exit code 0: there is one for each direction; 1: for some there is none; 2: wrong case file or
    option."""
    drawing = given.take(Cases.save)
    if plot is not None:
        refuse_picture(plot, **drawing)
    options = given.rest(mo.directions)
    with waiting("directions", json) as work:
        found = mo.directions(case, phases=work.phase, progress=work.step, **options)
    if json:
        print_json(found)
    else:
        print_result(found.summary)
    save(found, plot, drawing)
    return found.usable


@command(
    mo.least,
    leave="lower upper",
    vary=typer.Option(help="The number, and between what it is sought: arch.thickness=0.05:0.3."),
    most=typer.Option("--most", help="The greatest value instead, of what makes a scene weaker."),
)
def least(
    given: Given, case: Path, vary: str, most: bool = False, load_case: str | None = None, json: bool = False
) -> None:
    """Exit code 0: found, with both ends solved; 1: whether the scene holds could not be decided; 2: it holds
    or fails at both ends, or the case file or an option is wrong."""
    name, lower, upper = _between(vary)
    parameters = Parameters(as_scene(case, load_case))
    parameters.check_names({name: lower})
    search = mo.most if most else mo.least
    with waiting(f"{name}: {lower:g} to {upper:g}", json) as work:

        def progress(trial: Trial) -> None:
            does = "holds" if trial.holds else "fails"
            work.show(f"{name} = {trial.value:.9g}: {does} ({numeral(trial.number, '.9g')})")

        options = given.rest(search)
        found = search(lambda value: parameters.at({name: value}), lower, upper, progress=progress, **options)
    if json:
        print_json(found)
    else:
        print_result(f"{'number':<16} {name}\n{found}", bold_line=None)


@command(
    mo.settle,
    mo.solve,
    mo.Settlement.save,
    leave="end kind",
    direction=typer.Option(metavar="X,Y[,Z]", parser=_direction),
    greatest=typer.Option("--greatest", help="With --plot: at the greatest reaction, not the least."),
)
def settle(
    given: Given, case: Path, json: bool = False, plot: Path | None = None, greatest: bool = False
) -> bool:
    """Exit code 0: both were found, or that there is no end; 1: no reaction holds CASE, or an end was not
    found; 2: wrong case file or option."""
    drawing = given.take(mo.Settlement.save)
    if plot is not None:
        refuse_file(plot, drawing.get("force", False))
        refuse_view(mo.load(case), drawing.get("view"))
    elif greatest or drawing:
        raise OptionError("--greatest, --view and --force say how to draw: give --plot FILE too")
    with waiting("settle", json) as work:
        found = mo.settle(case, phases=work.phase, **given.rest(mo.settle))
    if json:
        print_json(found)
    else:
        print_result(str(found), bold_line=None)
    save(found, plot, drawing | {"end": "greatest" if greatest else "least"})
    return found.usable


@command(mo.solve, mo.report, leave="answer", out=typer.Option(metavar="FILE", help=_PAGE))
def report(given: Given, case: Path, load_case: str | None = None, out: Path | None = None) -> bool:
    """Solves all load cases unless one is named, and moves the axles, if there are any.

    Exit code 0: there are load factors; 1: one is missing, and the page says why; 2: wrong case file or
    option; 130: interrupted, and no page written.
    """
    page, writes = out or Path(f"{case.stem}_report.html"), given.take(mo.report)
    refuse_report(page, **writes)
    errors = Console(stderr=True)
    with waiting("report", kept="no page written") as work, interrupts() as check_interrupt:

        def begins(part: str) -> None:
            work.phase(part)
            if not errors.is_terminal:
                errors.print(f"report: {part} ...", markup=False, soft_wrap=True)

        try:
            answers = _answers(as_scene(case, load_case), begins, work.show, given.rest(mo.solve))
            check_interrupt()  # a search or crossing that it ended has an answer: what was found by then
        except KeyboardInterrupt:
            raise InterruptedByUserError("interrupted: no page written") from None
        begins("page")
        with writing(page):
            mo.report(answers, page, **writes)
    print_result(printable("\n\n".join([*map(str, answers), str(page)])), bold_line=None)
    return all(one.load_factor is not None if isinstance(one, mo.Crossing) else one.usable for one in answers)


def _answers(scene: Scene, begins: Phases, show: Phases, options: dict[str, Any]) -> list[Any]:
    """What a report is of: load cases, those in which axles cross, or the scene itself."""
    cases = scene.load_cases if scene.load_case is None else []
    answers: list[Any] = []
    if cases and not all(one.moves for one in cases):
        begins("load cases")
        answers.append(mo.solve_cases(scene, phases=show, **options))
    scenes = [scene.with_load_case(case) for case in cases] or [scene]
    if scene.axles and any(one.factor_of_axles for one in scenes):
        begins("crossing")
        answers.append(mo.crossing(scene, progress=lambda x, _: show(f"first axle at {x:.4g}"), **options))
    if not answers:
        begins("collapse")
        answers.append(mo.solve(scene, phases=show, **options))
    return answers


@partial(reader, refusal="--vary {}: write it as NAME=LOWER:UPPER, such as arch.thickness=0.05:0.3")
def _between(text: str) -> tuple[str, float, float]:
    name, _, ends = text.partition("=")
    lower, upper = map(float, ends.split(":"))
    return name.strip(), lower, upper


def _spectrum(path: Path) -> list[tuple[float, float]]:
    try:
        lines = csv.reader(path.read_text("utf-8").splitlines())
        told = (line for line in lines if line and not line[0].startswith("#"))
        return [(float(period), float(acceleration)) for period, acceleration in told]
    except OSError as error:
        raise OptionError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise OptionError(f"{path}: is no text") from None
    except (ValueError, csv.Error):
        needs = "a spectrum has a period (s) and an acceleration (g) on each line, as in 0.15,0.45"
        others = "begin other lines with #"
        raise OptionError(f"{path}: line {lines.line_num}: {needs}; {others}") from None

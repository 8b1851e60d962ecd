"""Commands `masonry-opt capacity`, `crossing`, `directions`, `least`, `report` and `settle`."""

import contextlib
import csv
import itertools
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
    PICTURE_NEEDS,
    CommandArguments,
    command,
    interrupts,
    numbers,
    print_json,
    reader,
    refuse_without,
    save,
    waiting,
)
from masonry_opt.deadline import TimeLimitReached, limited
from masonry_opt.drawing.figure import refuse_file, refuse_picture
from masonry_opt.drawing.solids import refuse_view
from masonry_opt.effort import Phases
from masonry_opt.errors import InterruptedByUserError, OptionError, counted, printable
from masonry_opt.files import writing
from masonry_opt.finite_motion.curve_input import curve_forces, refuse_parts_not_followed
from masonry_opt.problem.assembly import assemble
from masonry_opt.reporting.sentences import numeral
from masonry_opt.reporting.terminal import frame_text, print_result, print_text, print_warnings
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.load_cases.cases import Cases
from masonry_opt.studies.many.parameters import Parameters
from masonry_opt.studies.many.trial import Trial
from masonry_opt.studies.report.report import refuse_report

#: Text that the progress line of ``crossing`` shows for a position of the axles without a load factor. The
#: key is True if the scene carries any multiple of the live load there, and False if λ is unknown.
_NOT_FINITE = {True: "any", False: "unknown"}
_AXLES = typer.Option(
    metavar="NAME", help="Name of a group of axles in CASE. Default: all groups.", parser=str
)
_IN_CASE = typer.Option(
    metavar="NAME", help="Name of a load case in CASE. Default: all load cases with axles."
)
_VERTICAL = typer.Option(
    metavar="RATIO[,RATIO]",
    help="Vertical seismic force divided by the horizontal seismic force. Positive ratios act downwards. "
    "Several ratios are separated by commas, as in --vertical=0.3,-0.3. Default: the ratio of the earthquake "
    "of CASE, or 0 if CASE has no earthquake.",
    parser=numbers("--vertical {}: write one number or several, as in --vertical=0.3,-0.3"),
)
_direction = numbers("--direction {}: write it as X,Y or X,Y,Z, such as 0,-1")
_point = numbers("--point {}: write it as X,Y or X,Y,Z, such as 0.5,2")
_POINT_HELP = "With --block: point whose displacement is followed. Default: centroid of the block."
_BLOCK_HELP = "Block whose displacement is followed. Default: the points at which the live load acts."
_TRIAL_LIMIT = "With --load: time limit in seconds for each value of the parameter."
_SPECTRUM = (
    "CSV file of the spectrum for a seismic check: each line has a period (s) and an acceleration (g)."
)
_REPORT_FILE_HELP = "Page to write (.html). Default: CASE_report.html in the current folder."


@command(
    mo.solve,
    mo.capacity,
    mo.Capacity.check,
    mo.Capacity.save,
    labels=("", "", "With --spectrum", ""),
    leave="model solver tolerance incremental ultimate secant row",
    block=typer.Option(metavar="NAME", help=_BLOCK_HELP),
    point=typer.Option(metavar="X,Y[,Z]", help=_POINT_HELP, parser=_point),
    table=typer.Option("--table", help="Print every state of the curve too."),
    spectrum=typer.Option(metavar="FILE", help=_SPECTRUM),
    plot=PICTURE,
)
def capacity(
    arguments: CommandArguments,
    case: Path,
    spectrum: Path | None = None,
    plot: Path | None = None,
    table: bool = False,
    json: bool = False,
) -> bool:
    """Compute the capacity curve of CASE: λ over the displacement of the mechanism.

    Exit code 0: the capacity curve reaches λ = 0; 1: it ends at a larger λ; 2: wrong input. Exit code 1 also
    means that the scene has no load factor, or that the time limit was reached.
    """
    drawing, checking = arguments.take(mo.Capacity.save), arguments.take(mo.Capacity.check)
    following = arguments.take(mo.capacity)
    if plot is not None:
        refuse_picture(plot, **drawing)
    else:
        refuse_without(arguments, drawing, *PICTURE_NEEDS)
    if spectrum is None:
        refuse_without(arguments, checking, "a check against a spectrum", "--spectrum FILE")
    periods = None if spectrum is None else _spectrum(spectrum)
    scene = as_scene(case, arguments.pop("load_case", None))
    with waiting("capacity") as work:
        # Refuse an impossible curve before the long analysis. Two errors are left to ``solve``: a missing
        # live load, and a time limit that ends the search for joints.
        with contextlib.suppress(TimeLimitReached), limited(arguments.get("time_limit")):
            assembly = assemble(scene)
            if assembly.problem.live.any():
                curve_forces(assembly, **following)
            else:
                refuse_parts_not_followed(assembly)
        steps: dict[str, Any] = {"phases": work.phase, "progress": work.step}
        onset = mo.solve(scene, incremental=False, **steps, **arguments.keywords_for(mo.solve))
        work.show("capacity: following the mechanism")

        def progress(number: int, load_factor: float) -> None:
            work.show(f"capacity: state {number} of the curve: λ = {numeral(load_factor, '.6f')}")

        curve = mo.capacity(onset, progress=progress, **following)
    check = None if periods is None else curve.check(periods, **checking)
    if json:
        answer = curve.as_dict() | {"check": check.as_dict() if check else None}
        print_text(json_module.dumps(answer, allow_nan=False, ensure_ascii=False))
        print_warnings((*curve.warning_sentences, *(check.warning_sentences if check else ())))
    else:
        texts = [str(curve)]
        if check:
            texts.append(str(check))
        if table:
            texts.append(frame_text(curve.table.drop(columns="pairs"), "states"))
        print_result("\n".join(texts), bold_line=None)
    save(curve, plot, drawing)
    return curve.reaches_zero and not onset.time_limit_reached


@command(
    mo.crossing,
    mo.solve,
    mo.Crossing.save,
    leave="position",
    axles=_AXLES,
    load_case=_IN_CASE,
    table=typer.Option("--table", help="Print λ at every position too."),
)
def crossing(
    arguments: CommandArguments, case: Path, plot: Path | None = None, table: bool = False, json: bool = False
) -> bool:
    """Solve CASE with axles at each position on the road, and print the position with the lowest λ.

    Exit code 0: a load factor exists; 1: no load factor exists; 2: wrong input; 130: interrupted. Exit code 1
    also means that the crossing was stopped by its time limit. With --required-factor, exit code 0: the load
    factor is sufficient; 1: too small or not decided. --time-limit is the time of the whole crossing. A
    stopped or interrupted crossing prints the worst of the positions that were solved.
    """
    drawing = arguments.take(mo.Crossing.save)
    if plot is not None:  # report an unusable path before the scene is solved
        refuse_file(plot, **drawing)
    else:
        refuse_without(arguments, drawing, *PICTURE_NEEDS)
    with waiting("crossing") as work:

        def progress(position: float, load_factor: float) -> None:
            value = (
                numeral(load_factor, ".6f") if math.isfinite(load_factor) else _NOT_FINITE[load_factor > 0]
            )
            work.show(f"crossing: first axle at {position:.4g}: λ = {value}")

        answer = mo.crossing(
            case, progress=progress, phases=work.phase, **arguments.keywords_for(mo.crossing)
        )
    positions = "\n" + frame_text(answer.notebook_table, "positions") if table and answer.passages else ""
    if json:
        print_json(answer)
    else:
        print_result(f"{answer}{positions}", bold_line=None)
    save(answer, plot if answer.passages else None, drawing)
    if answer.time_limit_reached:
        return False
    if answer.interrupted:
        raise InterruptedByUserError(f"interrupted: {counted(len(answer.table), 'position')} solved")
    return answer.load_factor is not None if answer.passed is None else answer.passed


@command(mo.directions, mo.solve, Cases.save, leave="tolerance", vertical=_VERTICAL, plot=PICTURE)
def directions(arguments: CommandArguments, case: Path, plot: Path | None = None, json: bool = False) -> bool:
    """Compute the load factor of an earthquake in each direction, and print all load factors.

    Exit code 0: each direction has a load factor; 1: a load factor is missing; 2: wrong input. Exit code 1
    also means that the time limit ended the analysis of a direction.
    """
    drawing = arguments.take(Cases.save)
    if plot is not None:
        refuse_picture(plot, **drawing)
    else:
        refuse_without(arguments, drawing, *PICTURE_NEEDS)
    options = arguments.keywords_for(mo.directions)
    with waiting("directions") as work:
        answer = mo.directions(case, phases=work.phase, progress=work.step, **options)
    if json:
        print_json(answer)
    else:
        print_result(answer.summary)
    save(answer, plot, drawing)
    return answer.usable and not answer.time_limit_reached


@command(
    mo.least,
    leave="lower upper",
    vary=typer.Option(
        metavar="NAME=FROM:TO",
        help="Parameter of CASE and the range to search, such as arch.thickness=0.05:0.3.",
    ),
    most=typer.Option(
        "--most",
        help="Find the greatest instead of the least value at which the scene is stable or carries --load. "
        "Use this option if larger values weaken the scene.",
    ),
    time_limit=typer.Option(min=0.1, help=_TRIAL_LIMIT),
)
def least(
    arguments: CommandArguments,
    case: Path,
    vary: str,
    most: bool = False,
    load_case: str | None = None,
    time_limit: float | None = None,
    json: bool = False,
) -> None:
    """Search a range for the value of a parameter at which CASE is just stable, or just carries the load.

    Exit code 0: the value was found; 1: an analysis could not decide whether a scene is stable, or carries
    the load; 2: wrong input. Exit code 2 also means that both ends of the range have the same answer: the
    range then contains no limit.
    """
    name, lower, upper = _between(vary)
    parameters = Parameters(as_scene(case, load_case))
    parameters.check_names({name: lower})
    search = mo.most if most else mo.least
    with waiting(f"{name}: {lower:g} to {upper:g}") as work:

        def progress(trial: Trial) -> None:
            does = "holds" if trial.holds else "fails"
            work.show(f"{name} = {trial.value:.9g}: {does} ({numeral(trial.number, '.9g')})")

        options = arguments.keywords_for(search)
        if time_limit is not None:
            options["time_limit"] = time_limit

        def scene_of(value: float) -> Scene:
            return parameters.at({name: value})

        threshold = search(scene_of, lower, upper, progress=progress, **options)
    if json:
        print_json(threshold)
    else:
        print_result(f"{'parameter':<16} {name}\n{threshold}", bold_line=None)


@command(
    mo.settle,
    mo.solve,
    mo.Settlement.save,
    leave="end kind settled",
    support=typer.Option(metavar="NAME"),
    direction=typer.Option(metavar="X,Y[,Z]", parser=_direction),
    greatest=typer.Option(
        "--greatest", help="With --plot: draw the mechanism at the greatest instead of the least reaction."
    ),
)
def settle(
    arguments: CommandArguments,
    case: Path,
    json: bool = False,
    plot: Path | None = None,
    greatest: bool = False,
) -> bool:
    """Compute the least and the greatest reaction of a support that settles, and print both.

    Exit code 0: both reactions were found; 1: a reaction is missing; 2: wrong case file or option. A reaction
    that is proven to be unlimited counts as found. Exit code 1 also means that CASE is unstable for every
    value of the reaction, or that the time limit was reached.
    """
    drawing = arguments.take(mo.Settlement.save)
    if plot is not None:
        refuse_file(plot, drawing.get("force", False))
        refuse_view(mo.load(case), drawing.get("view"))
    else:
        refuse_without(arguments, [*drawing, *(["greatest"] if greatest else [])], *PICTURE_NEEDS)
    with waiting("settle") as work:
        answer = mo.settle(case, phases=work.phase, **arguments.keywords_for(mo.settle))
    if json:
        print_json(answer)
    else:
        print_result(str(answer), bold_line=None)
    save(answer, plot, drawing | {"end": "greatest" if greatest else "least"})
    return answer.usable and not answer.time_limit_reached


@command(mo.solve, mo.report, leave="answer", out=typer.Option(metavar="FILE", help=_REPORT_FILE_HELP))
def report(
    arguments: CommandArguments, case: Path, load_case: str | None = None, out: Path | None = None
) -> bool:
    """Solve all load cases, or only the named load case, and report the results.

    If CASE has axles, they move over the road.

    Exit code 0: all load factors were found; 1: a load factor is missing or the time limit was reached, and
    the page says so; 2: wrong case file or option; 130: interrupted, and no page was written.
    """
    page, writes = out or Path(f"{case.stem}_report.html"), arguments.take(mo.report)
    refuse_report(page, **writes)
    errors = Console(stderr=True)
    with waiting("report", if_interrupted="no page was written") as work, interrupts() as check_interrupt:

        def begins(part: str) -> None:
            work.phase(part)
            if not errors.is_terminal:
                errors.print(f"report: {part} ...", markup=False, soft_wrap=True)

        try:
            answers = _answers(as_scene(case, load_case), begins, work.show, arguments.keywords_for(mo.solve))
            check_interrupt()  # no page is written after Ctrl-C, even if the solver returned an answer
        except KeyboardInterrupt:
            raise InterruptedByUserError("interrupted: no page was written") from None
        begins("page")
        with writing(page):
            mo.report(answers, page, **writes)
    print_result(printable("\n\n".join([*map(str, answers), str(page)])), bold_line=None)
    return all(map(_is_complete, answers))


def _is_complete(answer: Any) -> bool:
    """Return True if an answer is usable, and the time limit did not end its analysis.

    A crossing is usable if any position has a load factor.
    """
    usable = answer.load_factor is not None if isinstance(answer, mo.Crossing) else answer.usable
    return usable and not answer.time_limit_reached


def _answers(scene: Scene, begins: Phases, show: Phases, options: dict[str, Any]) -> list[Any]:
    """Return the answers that a report lists.

    The list has one answer for all load cases and one answer for the crossing of all axles. If the scene has
    neither, the list has the answer of a single analysis.
    """
    cases = scene.load_cases if scene.load_case is None else []
    answers: list[Any] = []
    if cases and not all(case.moves for case in cases):
        begins("load cases")
        answers.append(mo.solve_cases(scene, phases=show, **options))
    scenes = [scene.with_load_case(case) for case in cases] or [scene]
    if scene.axles and any(case_scene.factor_of_axles for case_scene in scenes):
        begins("crossing")
        count = itertools.count(1)

        def progress(position: float, _: float) -> None:
            show(f"crossing: first axle at {position:.4g}; positions solved so far: {next(count)}")

        answers.append(
            mo.crossing(scene, progress=progress, phases=lambda words: show(f"crossing: {words}"), **options)
        )
    if not answers:
        begins("collapse")
        answers.append(mo.solve(scene, phases=show, **options))
    return answers


@partial(reader, refusal="--vary {}: write it as NAME=LOWER:UPPER, such as arch.thickness=0.05:0.3")
def _between(text: str) -> tuple[str, float, float]:
    """Parse the name of a parameter and its range from text such as "arch.thickness=0.05:0.3"."""
    name, _, ends = text.partition("=")
    lower, upper = map(float, ends.split(":"))
    return name.strip(), lower, upper


def _spectrum(path: Path) -> list[tuple[float, float]]:
    """Read a spectrum from a CSV file, as pairs of a period (s) and an acceleration (g).

    Raises OptionError if the file cannot be read, or is not a spectrum.
    """
    try:
        lines = csv.reader(path.read_text("utf-8").splitlines())
        pairs = (line for line in lines if line and not line[0].startswith("#"))
        return [(float(period), float(acceleration)) for period, acceleration in pairs]
    except OSError as error:
        raise OptionError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise OptionError(f"{path} is not a text file") from None
    except (ValueError, csv.Error):
        raise OptionError(
            f"{path}: line {lines.line_num}: each line of a spectrum needs a period (s) and an acceleration "
            "(g), as in 0.15,0.45; begin comment lines with #"
        ) from None

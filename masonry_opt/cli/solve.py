"""The commands `masonry-opt solve` and `check`."""

from pathlib import Path
from typing import Any

import typer

import masonry_opt as mo
from masonry_opt.analysis import solve as solve_scene
from masonry_opt.cli.command import Given, command, interrupts, print_json, save, waiting
from masonry_opt.errors import InterruptedByUserError, OptionError, printable
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.scene.case_file import as_scene
from masonry_opt.words.sentences import numeral
from masonry_opt.words.terminal import print_result, print_text, print_warnings

_DRAWN = "least", "incremental"  #: Load factors whose mechanism can be drawn.
_SHOWN = "What a picture shows: mechanism, thrust, utilisation, curve."
_HOW = "Also print how it was found: residuals, solvers, seconds."
_WHOSE = (
    "Mechanism that --plot draws: least (default: of the lowest found), incremental (incremental collapse)."
)


@command(
    solve_scene,
    mo.Result.save,
    kind=typer.Option("--plot-kind", metavar="KIND", help=_SHOWN),
    verbose=typer.Option("--verbose", "-v", help=_HOW),
    quiet=typer.Option("--quiet", "-q", help="Print the load factor alone, warnings on standard error."),
    mechanism=typer.Option(metavar="WHICH", help=_WHOSE),
)
def solve(
    given: Given,
    case: Path,
    load_case: str | None = None,
    json: bool = False,
    verbose: bool = False,
    quiet: bool = False,
    plot: Path | None = None,
    mechanism: str | None = None,
) -> bool:
    """Exit code 0: there is one (of every load case); 1: there is none, the status says why; 2: wrong case
    file or option."""
    if json + verbose + quiet > 1:
        raise OptionError("--json, --verbose and --quiet say each what is printed: give one of them")
    drawing = given.take(mo.Result.save)
    if plot is None and (drawing or mechanism is not None):
        said = "--plot-kind, --mechanism, --names, --view and --force say how to draw"
        raise OptionError(f"{said}: give --plot FILE too")
    if mechanism not in (None, *_DRAWN):
        raise OptionError(f"--mechanism '{mechanism}' is unknown; choose from: {', '.join(_DRAWN)}")
    method = METHODS.get(given.get("method", DEFAULT))
    if mechanism == _DRAWN[1] and (not given.get("incremental", True) or (method and method.associative)):
        raise OptionError(
            f"--mechanism {mechanism}: goes with a Coulomb method, and not with --no-incremental"
        )
    scene, drawing = as_scene(case, load_case), {"kind": "mechanism"} | drawing
    if plot is not None:  # refused now, not after the solve
        from masonry_opt.drawing.page import refuse_saving

        refuse_saving(scene, plot, **drawing)
    options = given.rest(solve_scene)
    if drawing["kind"] == "curve" and not options.get("curve"):
        raise OptionError("--plot-kind curve needs --method incremental and --option curve=true")
    with waiting(printable(case.name), quiet or json) as work, interrupts() as check_interrupt:

        def progress(step: Any) -> None:
            check_interrupt()
            work.step(step)

        try:
            if scene.load_cases and load_case is None:
                answer: Any = mo.solve_cases(scene, progress=progress, phases=work.phase, **options)
            else:
                answer = solve_scene(scene, progress=progress, phases=work.phase, **options)
            # Of load cases the governing one is drawn.
            result = answer if isinstance(answer, mo.Result) else answer.to_draw
            if not result.solution.interrupted:  # else it is the lowest state of a search
                check_interrupt()
        except KeyboardInterrupt:
            last = "no load factor was found"
            if work.steps:
                last = f"the last was {work.steps[-1]}, not the answer"
            raise InterruptedByUserError(f"interrupted: {last}; no file written") from None
    if json:
        print_json(answer)
    elif not quiet:
        print_result(answer.details if verbose else answer.summary)
    elif result.status.usable:
        print_text(numeral(result.required(), ".10g"))
        print_warnings(answer.warning_sentences)
    drawn = result.at_incremental if mechanism == _DRAWN[1] else None
    save(drawn or result, plot, drawing)
    if quiet:
        result.required()
    return answer.usable


@command(mo.check)
def check(given: Given, case: Path, load_case: str | None = None) -> bool:
    """Exit code 0: they agree; 1: they do not, or there is no load factor; 2: wrong case file."""
    with waiting("static and kinematic, CVXPY and Pyomo"):
        report = mo.check(as_scene(case, load_case), **given)
    print_result(str(report))
    return report.passed

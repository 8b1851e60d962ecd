"""Commands `masonry-opt solve` and `masonry-opt check`."""

from pathlib import Path
from typing import Any

import typer

import masonry_opt as mo
from masonry_opt.analysis import solve as solve_scene
from masonry_opt.cli.command import (
    PICTURE_NEEDS,
    CommandArguments,
    command,
    interrupts,
    print_json,
    refuse_without,
    save,
    waiting,
)
from masonry_opt.errors import InterruptedByUserError, OptionError, printable
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.reporting.sentences import numeral
from masonry_opt.reporting.terminal import print_result, print_text, print_warnings
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.mistakes import instead_of

#: Values of option --mechanism: names of the load factors whose mechanism can be drawn.
_MECHANISMS = "least", "incremental"
_PLOT_KIND_HELP = (
    "Content of the picture: mechanism, thrust, utilisation or curve. Default: mechanism, or thrust if CASE "
    "is stable without live load."
)
_VERBOSE_HELP = "Print residuals, solvers and computing times in addition to the summary."
_MECHANISM_HELP = "Mechanism to draw: least (default, at the lowest load factor found) or incremental."


@command(
    solve_scene,
    mo.Result.save,
    kind=typer.Option("--plot-kind", metavar="KIND", help=_PLOT_KIND_HELP, show_default=False),
    verbose=typer.Option("--verbose", "-v", help=_VERBOSE_HELP),
    quiet=typer.Option("--quiet", "-q", help="Print only the load factor, and warnings on standard error."),
    mechanism=typer.Option(metavar="WHICH", help=_MECHANISM_HELP),
)
def solve(
    arguments: CommandArguments,
    case: Path,
    json: bool = False,
    verbose: bool = False,
    quiet: bool = False,
    plot: Path | None = None,
    mechanism: str | None = None,
) -> bool:
    """Solve CASE, and print a summary of each result.

    Exit code 0: every load case has a load factor; 1: a load factor is missing, or the analysis was stopped;
    2: wrong input. If CASE has no live load, the command decides whether CASE is stable under its dead load.
    Exit code 0: stable; 1: unstable or undecided.
    """
    if json + verbose + quiet > 1:
        raise OptionError("--json, --verbose and --quiet exclude each other: give only one of the three")
    drawing = arguments.take(mo.Result.save)
    _refuse_drawing_options(arguments, drawing, plot, mechanism)
    load_case = arguments.pop("load_case", None)
    scene = as_scene(case, load_case)
    if plot is not None:  # report an unusable path before the scene is solved
        from masonry_opt.drawing.page import refuse_saving

        refuse_saving(scene, plot, **{"kind": "mechanism"} | drawing)
    options = arguments.keywords_for(solve_scene)
    if drawing.get("kind") == "curve" and not options.get("curve"):
        raise OptionError("--plot-kind curve needs --method incremental and --option curve=true")
    function = mo.solve_cases if scene.load_cases and load_case is None else solve_scene
    answer = _solved(function, scene, options, printable(case.name), quiet)
    result = _drawn_result(answer)
    if json:
        print_json(answer)
    elif not quiet:
        print_result(answer.details if verbose else answer.summary)
    elif answer.usable or result.load_factor is not None:
        is_stable = result.stability is not None
        print_text(str(result.status) if is_stable else numeral(result.required(), ".10g"))
        print_warnings(answer.warning_sentences)
    at_incremental = result.at_incremental if mechanism == "incremental" else None
    usual_kind = "mechanism"
    if result.stability is not None:
        # A stable scene without live load has no mechanism, so its thrust is drawn by default.
        usual_kind = "thrust"
        _refuse_mechanism(result, mechanism is not None or drawing.get("kind") == "mechanism")
    save(at_incremental or result, plot, {"kind": usual_kind} | drawing)
    if quiet and not result.stability:
        result.required()
    return answer.usable and not answer.time_limit_reached


def _refuse_drawing_options(
    arguments: CommandArguments, drawing: dict[str, Any], plot: Path | None, mechanism: str | None
) -> None:
    """Raise OptionError for picture options without --plot, and for a mechanism that cannot be drawn."""
    if plot is None:
        refuse_without(
            arguments, [*drawing, *(["mechanism"] if mechanism is not None else [])], *PICTURE_NEEDS
        )
    if mechanism not in (None, *_MECHANISMS):
        raise OptionError(f"--mechanism '{mechanism}' is unknown{instead_of(mechanism, _MECHANISMS)}")
    method = METHODS.get(arguments.get("method", DEFAULT))
    has_incremental = arguments.get("incremental", True) and not (method and method.associative)
    if mechanism == "incremental" and not has_incremental:
        raise OptionError(
            f"--mechanism {mechanism} needs the incremental load factor: choose a Coulomb method, and omit "
            "--no-incremental"
        )


def _refuse_mechanism(result: mo.Result, is_requested: bool) -> None:
    """Raise OptionError if the user requested the mechanism of a stable scene, which has no mechanism."""
    if is_requested:
        scene, remedy = f"{result.case}: the scene", "use --plot-kind thrust or utilisation to draw forces"
        raise OptionError(f"{scene} is stable under its dead load and has no mechanism: {remedy}")


def _solved(function: Any, scene: mo.Scene, options: dict[str, Any], name: str, quiet: bool) -> Any:
    """Solve a scene with a function such as ``solve``, and show a progress line on standard error.

    If ``quiet`` is True, no line is shown. Raises InterruptedByUserError if Ctrl-C ended the computation
    without an answer.
    """
    with waiting(name, quiet) as work, interrupts() as check_interrupt:

        def show_step(step: Any) -> None:
            check_interrupt()
            work.step(step)

        try:
            answer = function(scene, progress=show_step, phases=work.phase, **options)
            # If Ctrl+C interrupted a search, the answer is the state with the lowest load factor so far. Any
            # other interrupted analysis has no answer, so the interrupt is raised again.
            if not _drawn_result(answer).solution.interrupted:
                check_interrupt()
        except KeyboardInterrupt:
            last = "no load factor was found"
            if work.steps:
                last = f"the last step was {work.steps[-1]}, but its λ is not the collapse load factor"
            raise InterruptedByUserError(f"interrupted: {last}; no file was written") from None
    return answer


def _drawn_result(answer: Any) -> mo.Result:
    """Return the result to draw. For several load cases, this is the result of the governing load case."""
    return answer if isinstance(answer, mo.Result) else answer.to_draw


@command(mo.check)
def check(arguments: CommandArguments, case: Path, load_case: str | None = None) -> bool:
    """Compare four solutions of the associative problem of CASE, and print their differences.

    Exit code 0: the load factors agree; 1: they differ, or no load factor exists; 2: wrong case file.
    """
    with waiting("comparing the static with the kinematic formulation, and CVXPY with Pyomo"):
        report = mo.check(as_scene(case, load_case), **arguments)
    print_result(str(report))
    return report.passed

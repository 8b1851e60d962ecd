"""The command line: results on standard output, everything else on standard error."""

from __future__ import annotations

import contextlib
import math
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.metadata import version as package_version
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console
from typer.core import TyperGroup

from masonry_opt.analysis import solve as solve_scene
from masonry_opt.command_options import Force, Json, LoadCaseName, OwnOptions, View, angles, method_options
from masonry_opt.errors import (
    InterruptedByUserError,
    MasonryError,
    OptionError,
    OutputError,
    ReaderGoneError,
    printable,
)
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.solvers.registry import MODELS, TOLERANCE
from masonry_opt.words.sentences import numeral
from masonry_opt.words.terminal import changing_line, left_by, print_result, print_text, results_alone

#: Commands that are loaded when they are called: by name, where their typer app is.
_LOADED = {
    "capacity": "masonry_opt.finite_motion.command",
    "convert": "masonry_opt.convert",
    "compare": "masonry_opt.studies.compare.compare_command",
    "directions": "masonry_opt.studies.load_cases.directions_command",
    "crossing": "masonry_opt.studies.crossing.crossing_command",
    "least": "masonry_opt.studies.many.least_command",
    "reproduce": "masonry_opt.studies.reproduce",
    "settle": "masonry_opt.studies.settle.settle_command",
    "sweep": "masonry_opt.studies.many.sweep_command",
}


class _Commands(TyperGroup):
    """The commands of this file, and those that are loaded when they are called."""

    def list_commands(self, ctx: Any) -> list[str]:
        return [*super().list_commands(ctx), *_LOADED]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name in _LOADED:
            return typer.main.get_command(import_module(_LOADED[cmd_name]).app)
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        # What a command prints by other ways is no result.
        found: Any = super().resolve_command(ctx, args)
        found[1].invoke = results_alone()(found[1].invoke)
        return found


app = typer.Typer(
    cls=_Commands,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)

#: Load factors whose mechanism can be drawn.
_DRAWN = "least", "expected"

Case = Annotated[Path, typer.Argument(help="Case file (.toml or .json).", show_default=False)]


@app.callback(invoke_without_command=True)
def about(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    """At what load does this masonry collapse? Limit analysis of rigid blocks with Coulomb joints."""
    if version:
        print_text(package_version("masonry_opt"))
        raise typer.Exit


@app.command()
def solve(
    case: Case,
    method: Annotated[str, typer.Option(help=f"One of: {', '.join(METHODS)}.")] = DEFAULT,
    model: Annotated[
        str | None,
        typer.Option(help=f"In what it is declared: {', '.join(MODELS)}. Default: the method's first."),
    ] = None,
    solver: Annotated[
        str | None,
        typer.Option(
            help="Of methods of linear programs: clarabel, highs, highs-ipm, ... Default: the method's."
        ),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            help=f"Feasibility and gap asked of such a solver. Default: {TOLERANCE:g}.",
            show_default=False,
        ),
    ] = None,
    expected: Annotated[
        bool, typer.Option(help="Beside a Coulomb answer, also the load to expect (up to 8000 joints).")
    ] = True,
    load_case: LoadCaseName = None,
    json: Json = False,
    verbose: Annotated[
        bool,
        typer.Option(
            "--verbose", "-v", help="Also print how it was found: residuals, programs, solvers, seconds."
        ),
    ] = False,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Print the load factor alone; without one, an error.")
    ] = False,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the result (.png, .svg, .pdf, .html).")
    ] = None,
    plot_kind: Annotated[
        str | None,
        typer.Option(
            metavar="KIND", help="What a picture shows: mechanism (default), thrust, utilisation, curve."
        ),
    ] = None,
    mechanism: Annotated[
        str | None,
        typer.Option(
            metavar="WHICH", help=f"Whose mechanism --plot draws: {', '.join(_DRAWN)}. Default: {_DRAWN[0]}."
        ),
    ] = None,
    names: Annotated[bool, typer.Option("--names", help="With --plot: write the blocks' names.")] = False,
    view: View = None,
    force: Force = False,
    option: OwnOptions = None,
) -> None:
    """Find the load factor at which CASE collapses, of all its load cases unless one is named.

    Exit code 0: there is one (of every load case); 1: there is none, the status says why; 2: wrong case file
    or option.
    """
    if json + verbose + quiet > 1:
        raise OptionError("--json, --verbose and --quiet say each what is printed: give one of them")
    if plot is None and (names or force or any(how is not None for how in (plot_kind, mechanism, view))):
        raise OptionError(
            "--plot-kind, --mechanism, --names, --view and --force say how to draw: give --plot FILE too"
        )
    if mechanism not in (None, *_DRAWN):
        raise OptionError(f"--mechanism '{mechanism}' is unknown; choose from: {', '.join(_DRAWN)}")
    if mechanism == _DRAWN[1] and (not expected or (method in METHODS and METHODS[method].associative)):
        raise OptionError(f"--mechanism {mechanism}: goes with a Coulomb method, and not with --no-expected")
    kind, seen_from = plot_kind or "mechanism", angles(view)
    scene = as_scene(case, load_case)
    if plot is not None:  # refused now, not after the solve
        from masonry_opt.drawing.saved import refuse_saving

        refuse_saving(scene, plot, kind, names, force, seen_from)
    options = method_options(option, solve_scene)
    if kind == "curve" and not options.get("curve"):
        raise OptionError("--plot-kind curve needs --method compliant and --option curve=true")
    errors = Console(stderr=True)
    steps: list[str] = []
    told: list[str] = []
    errors.quiet = quiet
    name = printable(case.name)
    with changing_line(errors, name) as show, _interrupts() as check_interrupt:

        def begun(phase: str) -> None:
            show(f"{name}: {phase}{f' (last {told[-1]})' if told else ''}")

        def progress(step: Any) -> None:
            check_interrupt()
            if math.isfinite(step.load_factor):
                what = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(step).__name__).lower()
                steps.append(f"{what} {len(steps) + 1}: λ = {numeral(step.load_factor, '.6f')}")
                told.append(steps[-1] + left_by(step))
                show(f"{name}: {told[-1]}")

        try:
            solved = _solves_all() if scene.load_cases and load_case is None else solve_scene
            answer = solved(
                scene,
                method,
                model=model,
                solver=solver,
                tolerance=tolerance,
                expected=expected,
                progress=progress,
                phases=begun,
                **options,
            )
            # Of load cases the governing one is drawn.
            result = answer if isinstance(answer, Result) else answer.to_draw
            if not result.solution.interrupted:  # else it is the lowest state of a search
                check_interrupt()
        except KeyboardInterrupt:
            last = f"the last was {steps[-1]}, not the answer" if steps else "before the first λ"
            raise InterruptedByUserError(f"interrupted: {last}; nothing was written") from None
    if json:
        print_text(answer.to_json())
    elif not quiet:
        print_result(answer.details if verbose else answer.summary)
    elif result.status.usable:
        print_text(numeral(result.required(), ".10g"))
    if plot is not None:
        drawn = result.at_expected if mechanism == _DRAWN[1] else result
        with _writing(plot):
            (drawn or result).save(plot, kind, names, force, seen_from)
    if quiet:
        result.required()
    if not answer.usable:
        raise typer.Exit(1)


def _solves_all() -> Callable[..., Any]:
    """What solves all load cases: of the studies, which are loaded by name."""
    return import_module("masonry_opt.studies.load_cases.cases").solve_cases


@app.command()
def check(case: Case, load_case: LoadCaseName = None) -> None:
    """Hold static against kinematic and CVXPY against Pyomo on CASE.

    Exit code 0: they agree; 1: they do not, or there is no load factor; 2: wrong case file.
    """
    from masonry_opt.duality import check as check_duality

    report = check_duality(as_scene(case, load_case))
    print_result(str(report))
    if not report.passed:
        raise typer.Exit(1)


@app.command()
def draw(
    case: Case,
    file: Annotated[Path, typer.Argument(help="File to write (.png, .svg, .pdf).", show_default=False)],
    names: Annotated[bool, typer.Option("--names", help="Write the blocks' names.")] = False,
    load_case: LoadCaseName = None,
    view: View = None,
    force: Force = False,
) -> None:
    """Draw CASE to FILE before solving it: blocks, supports, joints found, small gaps, loads.

    Prints how many there are, and what looks unintended. Without --load-case loads are drawn as given.
    """
    from masonry_opt.drawing.figure import refuse_picture
    from masonry_opt.drawing.found import counts, doubts
    from masonry_opt.drawing.pictures import scene_picture
    from masonry_opt.drawing.view import refuse_view
    from masonry_opt.problem.assembly import assemble

    refuse_picture(file, force)
    scene, seen_from = as_scene(case, load_case), angles(view)
    refuse_view(scene, seen_from)
    assembly = assemble(scene, floating=True)
    with _writing(file):
        scene_picture(assembly, names, seen_from).save(file, force)
    warnings = [f"warning: {sentence}" for sentence in doubts(assembly)]
    print_text(printable("\n".join([f"{file}: {counts(assembly)}", *warnings])))


@app.command()
def export(
    case: Case,
    file: Annotated[
        Path,
        typer.Argument(
            help="File to write (.lp, .mps, .nl; of solids .obj, .glb, .gltf, .json).", show_default=False
        ),
    ],
    method: Annotated[
        str | None,
        typer.Option(
            help="Of programs static (default), kinematic or global (any file), mpec or mcp (.nl); of solids "
            "the one whose mechanism and forces to write (default: blocks at rest).",
            show_default=False,
        ),
    ] = None,
    load_case: LoadCaseName = None,
    force: Force = False,
) -> None:
    """Write the program that a method declares for CASE to FILE, for other solvers; or solids, for others.

    Beside a .nl file stand the names of its rows and columns (.row, .col). Prints the files written.
    """
    from masonry_opt.exports.export import export as write
    from masonry_opt.exports.solid_files import SOLID_ENDS

    solids, scene = file.suffix.lower() in SOLID_ENDS, as_scene(case, load_case)
    what = solve_scene(scene, method, expected=False) if solids and method else scene
    print_text(
        "\n".join(printable(str(path)) for path in write(what, file, None if solids else method, force))
    )


@contextlib.contextmanager
def _writing(path: Path) -> Iterator[None]:
    """Turn errors of writing a file into those of this package."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from None


@contextlib.contextmanager
def _interrupts() -> Iterator[Callable[[], None]]:
    """Remember Ctrl-C, which a solver may catch to stop itself alone, and yield a function that raises
    KeyboardInterrupt if there was one."""
    pressed = False

    def remember(*_: object) -> None:
        nonlocal pressed
        pressed = True
        raise KeyboardInterrupt

    def check() -> None:
        if pressed:
            raise KeyboardInterrupt

    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # else the caller has its own, or ignores it
        signal.signal(signal.SIGINT, remember)
    try:
        yield check
    finally:
        if before is signal.default_int_handler:
            signal.signal(signal.SIGINT, before)


def main() -> None:
    """Run the command line; every foreseeable mistake ends as one message and an exit code."""
    if sys.stdout is None:  # closed by the caller
        _end("standard output is closed: give it a file or a pipe", OutputError.exit_code)
    if (own := sys.__stdout__) is not None and own is sys.stdout:
        # What libraries write to the descriptor goes to standard error: results have another.
        results = os.fdopen(os.dup(1), "w", encoding=own.encoding)
        os.dup2(os.open(os.devnull, os.O_WRONLY) if sys.stderr is None else 2, 1)
        sys.stdout = results
    for stream in (sys.stdout, sys.stderr):
        # What a stream cannot encode (a file's name in foreign bytes) is written as an escape.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        try:
            app()
        except SystemExit:
            sys.stdout.flush()
            raise
    except (ReaderGoneError, BrokenPipeError):
        _end(None, ReaderGoneError.exit_code)
    except MasonryError as error:
        _end(str(error), error.exit_code)
    except OSError as error:
        _end(f"the output cannot be written: {error.strerror}", OutputError.exit_code)
    except MemoryError:
        _end("the scene does not fit in memory: split it", MasonryError.exit_code)
    except KeyboardInterrupt:
        _end("interrupted", InterruptedByUserError.exit_code)
    except SystemExit as end:
        if end.code == InterruptedByUserError.exit_code:  # typer's word for Ctrl-C in a command
            _end("interrupted: files already written are whole", InterruptedByUserError.exit_code)
        raise


def _end(message: str | None, code: int) -> NoReturn:
    """One line on standard error, if there is anything to say, and out."""
    with contextlib.suppress(OSError):
        if message is not None and sys.stderr is not None:
            print(f"error: {message}", file=sys.stderr, flush=True)
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        # Python flushes once more as it ends: let what cannot be written go nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(code)

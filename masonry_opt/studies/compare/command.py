"""The command `masonry-opt compare`."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from masonry_opt.errors import InterruptedByUserError, OptionError, printable
from masonry_opt.studies.compare.case_scenes import CaseScene, find_scenes
from masonry_opt.studies.compare.comparison import Limits
from masonry_opt.studies.compare.comparison import compare as run_comparison
from masonry_opt.studies.compare.made_scenes import write_atlas, write_random
from masonry_opt.studies.compare.plan import plan

#: What is compared when nothing is named: every method that a wall of Table 1 takes seconds for, with the
#: solvers of the package, at a loose and at the package's own tolerance.
_METHODS = "static,kinematic,nonassociative,mpec,refined"
_MODELS = "cvxpy,pyomo"
_SOLVERS = "clarabel,highs,highs-ipm"
_TOLERANCES = "1e-6,1e-9"


def compare(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="CASE...", help="Case files, or names of those in --cases.")
    ] = None,
    atlas: Annotated[
        bool, typer.Option("--atlas", help="Also the scenes of the failure atlas, with their right answers.")
    ] = False,
    random: Annotated[int, typer.Option(min=0, help="Also so many random scenes, by seed.")] = 0,
    methods: Annotated[str, typer.Option(help="Separated by commas; also: global.")] = _METHODS,
    solvers: Annotated[
        str,
        typer.Option(
            help="Also: highs-hipo, piqp (both in the extra 'solvers'), and what CVXPY finds: osqp, scs, ..."
        ),
    ] = _SOLVERS,
    models: Annotated[str, typer.Option(help="Modelling languages.")] = _MODELS,
    tolerances: Annotated[str, typer.Option(help="Asked of the solvers, such as 1e-4,1e-7.")] = _TOLERANCES,
    repeats: Annotated[int, typer.Option(min=1, help="Runs of each; times are medians.")] = 3,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds a run.")] = 60.0,
    memory_limit: Annotated[float, typer.Option(min=1, help="MB a run, libraries included.")] = 4000.0,
    cases: Annotated[Path, typer.Option(help="Folder of the case files.")] = Path("cases"),
    update_best_known: Annotated[
        bool, typer.Option("--update-best-known", help="Write lower exact states to best_known.toml.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of results and report.")] = Path("results/compare"),
) -> None:
    """Time methods and solvers on scenes, judge their answers, write tables, charts and a report.

    An interrupted comparison continues where it stopped. Exit code 0: done; 130: interrupted; 2: wrong
    case file or option.
    """
    # Charts and pages are slow to import and no other command needs them.
    from masonry_opt.studies.compare.report import summary_text, write_report

    asked = plan(_split(methods), _split(models), _split(solvers), _tolerances(tolerances))
    compared = _scenes(scenes or [], cases, atlas, random, out / "scenes")
    errors = Console(stderr=True)
    with errors.status("comparing") as status, _ended_by_kill():
        limits = Limits(time_limit, memory_limit, repeats)
        comparison = run_comparison(
            compared,
            asked,
            limits,
            out,
            lambda line: status.update(line.replace("[", r"\[")),
            update_best_known,
        )
        status.update("report")
        written = write_report(comparison, out)
    print(printable(summary_text(comparison)))
    errors.print(f"written: {', '.join(map(str, written))}", markup=False, soft_wrap=True)
    if comparison.interrupted:
        raise InterruptedByUserError("interrupted: the same command continues where it stopped")


@contextlib.contextmanager
def _ended_by_kill() -> Iterator[None]:
    """Within it `kill` and `timeout` do what Ctrl-C does: else the run under way would go on by itself."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _scenes(names: list[str], cases: Path, atlas: bool, random: int, folder: Path) -> tuple[CaseScene, ...]:
    if not (names or atlas or random):
        raise OptionError("nothing to compare: name case files, --atlas or --random")
    expected = write_atlas(folder, cases) if atlas else {}
    return find_scenes([*names, *expected, *write_random(folder, random)], cases, expected)


def _split(text: str) -> list[str]:
    names = [name.strip().lower() for name in text.split(",") if name.strip()]
    return list(dict.fromkeys(names))


def _tolerances(text: str) -> list[float]:
    try:
        return [float(name) for name in _split(text)]
    except ValueError:
        raise OptionError(f"--tolerances '{text}': numbers separated by commas, such as 1e-6,1e-9") from None

"""The comparison as a Python function: what the command `masonry-opt compare` calls, too."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from masonry_opt.errors import MasonryError, OptionError
from masonry_opt.studies.cases import case_folder
from masonry_opt.studies.compare.case_scenes import find_scenes
from masonry_opt.studies.compare.comparison import Comparison, RunLimits, run_plan
from masonry_opt.studies.compare.plan import plan

#: What is compared when nothing is named: every method that a wall of Table 1 takes seconds for, with the
#: solvers of the package, at a loose and at the package's own tolerance.
METHODS = ("static", "kinematic", "nonassociative", "mcp", "mpec", "refined")
MODELS = ("cvxpy", "pyomo")
SOLVERS = ("clarabel", "highs", "highs-ipm")
TOLERANCES = (1e-6, 1e-9)

#: Of a run: times it is made, seconds and MB.
REPEATS, TIME_LIMIT, MEMORY_LIMIT = 3, 60.0, 4000.0

#: Folder of results and report.
OUT = Path("results/compare")


class NoRunEndedError(MasonryError):
    """Every run of a comparison crashed or died; the message says how most of them did."""

    exit_code = 1


def compare(
    scenes: str | Path | Sequence[str | Path] = (),
    *,
    methods: str | Sequence[str] = METHODS,
    models: str | Sequence[str] = MODELS,
    solvers: str | Sequence[str] = SOLVERS,
    tolerances: Sequence[float] = TOLERANCES,
    repeats: int = REPEATS,
    time_limit: float = TIME_LIMIT,
    memory_limit: float = MEMORY_LIMIT,
    out: str | Path = OUT,
    update_best_known: bool = False,
    cases: str | Path | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Comparison:
    """Time methods and solvers on scenes, judge their answers, write tables, charts and a page.

    Runs that ``out`` holds already are not made again: an interrupted comparison (Ctrl-C) is reported with
    what it has, and continues when it is called again.

    Parameters
    ----------
    scenes: case files, or names of those in the folder ``cases``.
    cases: folder of the case files; see :func:`~masonry_opt.studies.cases.case_folder`.
    tolerances: asked of the solvers that take one.
    repeats: runs of each; times are medians.
    time_limit, memory_limit: seconds and MB (10⁶ bytes, libraries included) that a run may take.
    out: folder of results and report.
    update_best_known: write lower exact Coulomb states to the registry ``best_known.toml``.
    progress: called with a line before each run.

    Raises
    ------
    CaseError
        If a case file or a registry is missing or wrong.
    OptionError
        If a name is unknown, a number is out of range, or nothing is left to compare.
    OutputError
        If ``out`` cannot be written.
    NoRunEndedError
        If every run crashed or died; the report is written all the same.
    """
    # Charts and pages are slow to import: only when they are needed.
    from masonry_opt.studies.compare.report import summary_text, write_report

    if repeats < 1:
        raise OptionError(f"repeats must be at least 1, not {repeats}")
    planned = plan(
        _listed("methods", methods), _listed("models", models), _listed("solvers", solvers), tolerances
    )
    folder, out = case_folder(None if cases is None else Path(cases)), Path(out)
    named = _listed("scenes", scenes)
    if not named:
        raise OptionError("nothing to compare: name case files")
    compared = find_scenes(named, folder)
    limits = RunLimits(time_limit, memory_limit, repeats)
    comparison = run_plan(compared, planned, limits, out, progress, update_best_known)
    progress("report")
    write_report(comparison, out)
    if comparison.failure and not comparison.interrupted:
        raise NoRunEndedError(f"no run ended: {comparison.failure}; see {out / 'summary.csv'}")
    return replace(comparison, text=summary_text(comparison))


def _listed(what: str, names: str | Path | Sequence[Any]) -> Sequence[Any]:
    """Names; a name by itself is a list of one."""
    if isinstance(names, str | Path):
        return [names]
    if not isinstance(names, Sequence):
        raise OptionError(f"{what} must be a list of names (found {names!r})")
    return names

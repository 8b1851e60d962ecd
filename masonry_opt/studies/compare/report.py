"""``compare``, and its files: results.csv, summary.csv, pictures, report.html."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from masonry_opt.errors import MasonryError, OptionError
from masonry_opt.scene.case_file import case_folder
from masonry_opt.solvers.registry import LANGUAGES
from masonry_opt.studies.compare.best_known import FILE
from masonry_opt.studies.compare.comparison import Comparison, RunLimits, run_plan
from masonry_opt.studies.compare.plan import find_scenes, plan
from masonry_opt.studies.runner import CRASHED, DIED
from masonry_opt.studies.writing import csv_text, write_files

#: Defaults: the methods that take seconds on a wall of Table 1, the solvers of the package, a loose tolerance
#: and the package's own.
METHODS = ("static", "kinematic", "nonassociative", "mcp", "mpec", "refined")
SOLVERS = ("clarabel", "highs", "highs-ipm")
TOLERANCES = (1e-6, 1e-9)

#: Folder of results and report.
OUT = Path("results/compare")


class NoRunEndedError(MasonryError):
    """Every run of a comparison crashed or died."""

    exit_code = 1


def compare(
    scenes: str | Path | Sequence[str | Path] = (),
    *,
    methods: str | Sequence[str] = METHODS,
    models: str | Sequence[str] = LANGUAGES,
    solvers: str | Sequence[str] = SOLVERS,
    tolerances: Sequence[float] = TOLERANCES,
    repeats: int = RunLimits.repeats,
    time_limit: float = RunLimits.time,
    memory_limit: float = RunLimits.memory,
    out: str | Path = OUT,
    cases: str | Path | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Comparison:
    """Time methods and solvers on scenes, judge their answers, write tables, charts and a page.

    Runs that ``out`` holds already are not made again: an interrupted comparison (Ctrl-C) is reported with
    what it has, and continues when it is called again.

    Raises CaseError if a case file or a registry is missing or wrong; OptionError if an argument is wrong,
    nothing is left to compare, or ``out`` holds other runs; OutputError if ``out`` cannot be written;
    NoRunEndedError if every run crashed or died (the report is written nevertheless).

    Parameters
    ----------
    scenes: case files, or names of those in the folder ``cases``.
    cases: folder of the case files; see :func:`~masonry_opt.scene.case_file.case_folder`.
    tolerances: asked of the solvers that take one.
    repeats: runs of each; times are medians.
    time_limit, memory_limit: seconds and MB (10⁶ bytes, libraries included) that a run may take.
    out: folder of results and report.
    progress: called with a line before each run.
    """
    if repeats < 1:
        raise OptionError(f"repeats must be at least 1, not {repeats}")
    planned = plan(
        _listed("methods", methods), _listed("models", models), _listed("solvers", solvers), tolerances
    )
    folder, out = case_folder(None if cases is None else Path(cases)), Path(out)
    named = _listed("scenes", scenes)
    if not named:
        raise OptionError("nothing to compare: name case files")
    limits, registry = RunLimits(time_limit, memory_limit, repeats), folder / FILE
    found = find_scenes(named, folder)
    comparison = run_plan(found, planned, limits, out, progress, registry)
    progress("report")
    write_report(comparison, out)
    ended = comparison.results["ended"]
    if len(ended) and ended.isin((CRASHED, DIED)).all() and not comparison.interrupted:
        ends = Counter(zip(ended, comparison.results["message"], strict=True))
        (((how, why), count),) = ends.most_common(1)
        said = f"{count} of {len(ended)} {how}: {why}"
        raise NoRunEndedError(f"no run ended: {said}; see {out / 'summary.csv'}")
    return comparison


def _listed(what: str, names: str | Path | Sequence[Any]) -> Sequence[Any]:
    """Names; a name by itself is a list of one."""
    if isinstance(names, str | Path):
        return [names]
    if not isinstance(names, Sequence):
        raise OptionError(f"{what} must be a list of names (found {names!r})")
    return names


def write_report(comparison: Comparison, folder: Path) -> list[Path]:
    """Write results.csv, summary.csv and, where the extra "studies" is installed, charts (PNG and SVG) and
    report.html; returns their paths.

    Raises OutputError if the folder cannot be written.
    """
    files: dict[str, str | bytes] = {
        "results.csv": csv_text(comparison.results),
        "summary.csv": csv_text(comparison.summary),
    }
    with contextlib.suppress(OptionError):  # the tables need no extra
        # Charts and pages are slow to import: only when they are needed.
        from masonry_opt.studies.charts import pictures
        from masonry_opt.studies.compare.charts import charts
        from masonry_opt.studies.compare.page import page

        drawn = charts(comparison.summary)
        files |= pictures(drawn) | {"report.html": page(comparison, drawn)}
    return write_files(folder, files)

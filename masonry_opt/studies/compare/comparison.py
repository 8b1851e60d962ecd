"""A comparison of methods and solvers: makes the runs that are missing, keeps each, judges all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.errors import MasonryError, OptionError
from masonry_opt.solvers.registry import LANGUAGES
from masonry_opt.studies.cases import case_folder
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.answer import REPEATED_BELOW, Comparison, RunLimits
from masonry_opt.studies.compare.best_known import best_known, improve, lowest_exact, merged
from masonry_opt.studies.compare.judge import ANSWER, ASSOCIATIVE, COULOMB, question_of
from masonry_opt.studies.compare.plan import CaseScene, Pair, RunPlan, find_scenes, plan
from masonry_opt.studies.compare.runs import (
    COLUMNS,
    bound_scene,
    key_of,
    row_of,
    run_pair,
    scene_to_expect,
)
from masonry_opt.studies.journal import Journal, digest
from masonry_opt.studies.machine import versions_hash
from masonry_opt.studies.runner import CRASHED, DIED, FINISHED, MEMORY_LIMIT, TIME_LIMIT, run_alone

#: Defaults: the methods that take seconds on a wall of Table 1, the solvers of the package, a loose tolerance
#: and the package's own.
METHODS = ("static", "kinematic", "nonassociative", "mcp", "mpec", "refined")
SOLVERS = ("clarabel", "highs", "highs-ipm")
TOLERANCES = (1e-6, 1e-9)

#: Folder of results and report.
OUT = Path("results/compare")

#: Seconds that what is computed once for a scene may take at least.
_SCENE_TIME = 120.0


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
        If an argument is wrong, nothing is left to compare, or ``out`` holds other runs.
    OutputError
        If ``out`` cannot be written.
    NoRunEndedError
        If every run crashed or died; the report is written nevertheless.
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
    limits = RunLimits(time_limit, memory_limit, repeats)
    comparison = run_plan(find_scenes(named, folder), planned, limits, out, progress, update_best_known)
    progress("report")
    write_report(comparison, out)
    ended = comparison.results["ended"]
    if len(ended) and ended.isin((CRASHED, DIED)).all() and not comparison.interrupted:
        ends = Counter(zip(ended, comparison.results["message"], strict=True))
        (((how, why), count),) = ends.most_common(1)
        said = f"{count} of {len(ended)} {how}: {why}"
        raise NoRunEndedError(f"no run ended: {said}; see {out / 'summary.csv'}")
    return replace(comparison, text=summary_text(comparison))


def _listed(what: str, names: str | Path | Sequence[Any]) -> Sequence[Any]:
    """Names; a name by itself is a list of one."""
    if isinstance(names, str | Path):
        return [names]
    if not isinstance(names, Sequence):
        raise OptionError(f"{what} must be a list of names (found {names!r})")
    return names


def run_plan(
    scenes: Sequence[CaseScene],
    plan: RunPlan,
    limits: RunLimits,
    folder: Path,
    progress: Callable[[str], None],
    update_best_known: bool = False,
) -> Comparison:
    """Make the runs that ``folder`` does not hold yet, and judge all (see :func:`compare`)."""
    known = best_known(scenes)
    notes: list[str] = []
    made = _JournalRuns(Journal(folder, {"columns": digest(COLUMNS)}), limits, progress, notes)
    bounds: dict[str, CertifiedBounds] = {}
    to_expect: dict[str, float | None] = {}
    coulomb = any(question_of(pair.method) == COULOMB for pair in plan.pairs)
    rows: list[dict[str, Any]] = []
    interrupted = False
    try:
        for scene in scenes:
            known_without = scene.expected.get(ASSOCIATIVE, ANSWER) != ANSWER  # then there is no λ to bound
            if not known_without and (found := made.once(scene, "certified bounds", bound_scene)):
                bounds[scene.name] = CertifiedBounds(**found)
            if coulomb and (found := made.once(scene, "load to expect", scene_to_expect)):
                to_expect[scene.name] = found["load_factor"]
        for row in made.runs(scenes, plan.pairs):
            rows.append(row)  # those before an interrupt stay
    except KeyboardInterrupt:
        interrupted = True
        notes.append("interrupted: the same command continues where it stopped")
    if bent := sorted({row["scene"] for row in rows if row["crushing"] == "parabola"}):
        notes.append(
            "static and kinematic with a conic solver crush joints by the parabola, all other runs and the "
            f"certified bounds by chords inside it: no error is given for the former on {', '.join(bent)}"
        )
    found = lowest_exact(rows, known)
    notes += improve(scenes, found, update_best_known)
    best = merged(known, found)
    summary = frames.summary(rows, bounds, best, {scene.name: scene.expected for scene in scenes})
    if len(summary):
        summary["to_expect"] = summary["scene"].map(to_expect).astype(float)
    results = pd.DataFrame(rows, columns=COLUMNS)
    return Comparison(
        tuple(scenes), plan, limits, bounds, best, to_expect, results, summary, tuple(notes), interrupted
    )


@dataclass(frozen=True)
class _JournalRuns:
    """Runs read from a journal, or made and kept there; notes of what could not be made."""

    journal: Journal
    limits: RunLimits
    progress: Callable[[str], None]
    notes: list[str]

    def runs(self, scenes: Sequence[CaseScene], pairs: Sequence[Pair]) -> Iterator[dict[str, Any]]:
        versions, limits = versions_hash(), self.limits
        long: set[tuple[str, Pair]] = set()
        # Repeats come last: an interrupted comparison has made everything once.
        runs = [*product(range(1, limits.repeats + 1), scenes, pairs)]
        for number, (repeat, scene, pair) in enumerate(runs, start=1):
            if (scene.name, pair) in long:
                continue
            columns = key_of(scene, pair, repeat, versions)
            key = " · ".join(map(str, columns.values()))
            row = self.journal.find(key)
            if row is None or _ended_by_less(row, limits):
                tolerance = "" if pair.tolerance is None else f" · {pair.tolerance:.0e}"
                self.progress(f"{number}/{len(runs)} {scene.name} · {pair.label}{tolerance}")
                end = run_alone(partial(run_pair, scene.path, pair, limits.time), limits.time, limits.memory)
                row = row_of(columns, end, limits.time, limits.memory)
                if end.how != DIED:  # the system may have killed it
                    self.journal.add(key, row)
            if row["wall"] > REPEATED_BELOW or row["ended"] != FINISHED:
                long.add((scene.name, pair))
            yield row

    def once(
        self, scene: CaseScene, what: str, function: Callable[[Path], dict[str, Any]]
    ) -> dict[str, Any] | None:
        """What a function finds of a case file, read or computed; None, and a note, where that failed."""
        key, limits = f"{what} · {scene.content}", self.limits
        found = self.journal.find(key)
        if found is None:
            self.progress(f"{what} of {scene.name}")
            end = run_alone(partial(function, scene.path), max(limits.time, _SCENE_TIME), limits.memory)
            if end.how != FINISHED:
                self.notes.append(f"{scene.name}: no {what}: {end.how}: {end.reason}")
                return None
            self.journal.add(key, found := end.value)
        return found


def _ended_by_less(row: dict[str, Any], limits: RunLimits) -> bool:
    """Whether a run was killed at a limit that is higher now."""
    now = {TIME_LIMIT: limits.time > row["time_limit"], MEMORY_LIMIT: limits.memory > row["memory_limit"]}
    return now.get(row["ended"], False)

"""A comparison of methods and solvers: makes the runs that are missing, keeps each, judges all."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.answer.thresholds import APART
from masonry_opt.errors import counted, printable
from masonry_opt.studies.compare import frames, runs
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.best_known import BestKnown, best_known, lower_states, lowest_exact, merged
from masonry_opt.studies.compare.judge import ANSWER, ASSOCIATIVE, COULOMB, TARGET, question_of
from masonry_opt.studies.compare.plan import CaseScene, Pair, RunPlan
from masonry_opt.studies.journal import Journal, digest
from masonry_opt.studies.machine import versions_hash
from masonry_opt.studies.runner import DIED, FINISHED, MEMORY_LIMIT, TIME_LIMIT, run_alone
from masonry_opt.studies.writing import in_words

#: Runs that take longer (seconds) are not repeated: their scatter is relatively small.
REPEATED_BELOW = 5.0

#: Seconds that what is computed once for a scene may take at least.
_SCENE_TIME = 120.0


@dataclass(frozen=True)
class RunLimits:
    """Seconds and MB that a run may take, and how often it is repeated."""

    time: float = 60.0
    memory: float = 4000.0
    repeats: int = 3


@dataclass(frozen=True)
class Comparison:
    """Results of a comparison; ``print`` shows the report.

    Attributes
    ----------
    bounds: certified bounds of the associative load factor, by scene name.
    best: lowest exact Coulomb state known, by scene name.
    to_expect: load factor to expect, by scene name, where Coulomb methods are compared; None: there is none.
    results: one row a run (see :data:`~.runs.COLUMNS`).
    summary: one row a scene and pair (see :func:`~.frames.summary`), with the load factor to expect.
    notes: further remarks, a line each.
    interrupted: whether runs are missing.
    """

    scenes: tuple[CaseScene, ...]
    plan: RunPlan
    limits: RunLimits
    bounds: dict[str, CertifiedBounds]
    best: dict[str, BestKnown]
    to_expect: dict[str, float | None]
    results: pd.DataFrame
    summary: pd.DataFrame
    notes: tuple[str, ...] = ()
    interrupted: bool = False

    def __str__(self) -> str:
        """The success table, scenes whose Coulomb load factors differ, combinations left out, notes."""
        lines = []
        if len(self.summary):
            columns = ("method", "model", "solver", "tolerance", "scenes", *frames.SUCCESS[1:])
            success = in_words(frames.success(self.summary), frames.FORMATS, columns)
            lines.append(success.rename(columns=frames.HEADINGS).to_string(index=False))
            lines.append(
                f"\n{counted(len(self.scenes), 'scene')}; success: certified or named correctly;\n"
                f"on target: certified, with an error of at most {TARGET[ASSOCIATIVE]:g} (associative), "
                f"{TARGET[COULOMB]:g} (Coulomb: gap to the best exact state);\n"
                "median time, largest error and violation (1e-10 at least): of the certified answers, each a "
                f"median of {counted(self.limits.repeats, 'run')} (of one where a run takes over "
                f"{REPEATED_BELOW:g} s)"
            )
        if len(apart := frames.spread(self.summary)):
            lines.append(f"\ncertified Coulomb λ more than {APART:.0%} apart:")
            lines.append(in_words(apart, frames.FORMATS).to_string(index=False))
        if self.plan.left_out:
            lines.append("\nnot applicable:")
            lines += [f"  {' · '.join(names)}: {reason}" for *names, reason in self.plan.left_out]
        if self.notes:
            lines += ["\nnotes:", *(f"  {note}" for note in self.notes)]
        return printable("\n".join(lines))


def run_plan(
    scenes: Sequence[CaseScene],
    plan: RunPlan,
    limits: RunLimits,
    folder: Path,
    progress: Callable[[str], None],
    registry: Path | None = None,
) -> Comparison:
    """Make the runs that ``folder`` does not hold yet, and judge all (see :func:`~.report.compare`), Coulomb
    states by those that ``registry`` has."""
    known = best_known(scenes, registry)
    notes: list[str] = []
    made = _JournalRuns(Journal(folder, {"columns": digest(runs.COLUMNS)}), limits, progress, notes)
    bounds: dict[str, CertifiedBounds] = {}
    to_expect: dict[str, float | None] = {}
    coulomb = any(question_of(pair.method) == COULOMB for pair in plan.pairs)
    rows: list[dict[str, Any]] = []
    interrupted = False
    try:
        for scene in scenes:
            known_without = scene.expected.get(ASSOCIATIVE, ANSWER) != ANSWER  # then there is no λ to bound
            if not known_without and (found := made.once(scene, "certified bounds", runs.bound_scene)):
                bounds[scene.name] = CertifiedBounds(**found)
            if coulomb and (found := made.once(scene, "load to expect", runs.scene_to_expect)):
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
    best = merged(known, lowest_exact(rows, known))
    notes += lower_states(known, best, registry)
    summary = frames.summary(rows, bounds, best, {scene.name: scene.expected for scene in scenes})
    if len(summary):
        summary["to_expect"] = summary["scene"].map(to_expect).astype(float)
    results = pd.DataFrame(rows, columns=runs.COLUMNS)
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
        asked = [*product(range(1, limits.repeats + 1), scenes, pairs)]
        for number, (repeat, scene, pair) in enumerate(asked, start=1):
            if (scene.name, pair) in long:
                continue
            which = (scene.name, scene.content, versions, *astuple(pair), repeat)
            columns = dict(zip(runs.KEY, which, strict=True))
            key = " · ".join(map(str, columns.values()))
            row = self.journal.find(key)
            if row is None or _ended_by_less(row, limits):
                tolerance = "" if pair.tolerance is None else f" · {pair.tolerance:.0e}"
                self.progress(f"{number}/{len(asked)} {scene.name} · {pair.label}{tolerance}")
                run = partial(runs.run_pair, scene.path, pair, limits.time)
                end = run_alone(run, limits.time, limits.memory)
                row = runs.row_of(columns, end, limits.time, limits.memory)
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

"""A comparison from its plan to judged rows: runs what is missing, keeps every run, can be interrupted."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.files import write_whole
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.best_known import BestKnown, best_known, improve, lowest_exact, merged
from masonry_opt.studies.compare.case_scenes import CaseScene
from masonry_opt.studies.compare.known_answers import ANSWER, ASSOCIATIVE
from masonry_opt.studies.compare.measure import FINISHED, Ended, run_limited
from masonry_opt.studies.compare.plan import Plan, PlannedRun
from masonry_opt.studies.compare.store import Store, row
from masonry_opt.studies.compare.worker import bound_scene, run_pair
from masonry_opt.studies.endings import CRASHED, DIED
from masonry_opt.studies.machine import versions_hash

#: A run that took longer (seconds), or was killed, is not repeated: its scatter is small beside it.
REPEATED_BELOW = 5.0

#: Seconds that the certified bounds of a scene may take at least.
_BOUNDS_TIME = 120.0


@dataclass(frozen=True)
class RunLimits:
    """Seconds and MB that a run may take, and how often it is repeated."""

    time: float
    memory: float
    repeats: int


@dataclass(frozen=True)
class Comparison:
    """What was measured, and what it is measured by.

    Attributes
    ----------
    scenes, plan, limits: what was compared.
    bounds: certified bounds of the associative load factor, by scene name.
    best: lowest exact Coulomb state known, by scene name.
    summary: one row a scene and pair (see :func:`~.frames.summary`).
    notes: what else a reader must know, a line each.
    interrupted: whether runs are missing.
    failure: if every run crashed or died, how most of them did; else "".
    text: what ``print`` and the command show.
    """

    scenes: tuple[CaseScene, ...]
    plan: Plan
    limits: RunLimits
    bounds: dict[str, CertifiedBounds]
    best: dict[str, BestKnown]
    summary: pd.DataFrame
    notes: tuple[str, ...]
    interrupted: bool
    failure: str
    text: str = field(default="", repr=False)

    def __str__(self) -> str:
        return self.text


def run_plan(
    scenes: Sequence[CaseScene],
    plan: Plan,
    limits: RunLimits,
    folder: Path,
    progress: Callable[[str], None],
    update_best_known: bool = False,
) -> Comparison:
    """Make the runs that ``folder`` does not hold yet, and judge all of the plan's.

    Parameters
    ----------
    folder: where ``results.csv`` and ``bounds.json`` are kept.
    progress: called with a line before each run.
    update_best_known: write lower exact states to the registries; else they are told in the notes.

    Raises
    ------
    OptionError
        If the folder holds a comparison with other columns.
    OutputError
        If the folder cannot be written.
    CaseError
        If a registry of best known states is wrong.
    """
    known = best_known(scenes)
    store = Store(folder / "results.csv")
    bounds: dict[str, CertifiedBounds] = {}
    rows: list[dict[str, Any]] = []
    notes: list[str] = []
    interrupted = False
    try:
        bounds, bound_notes = _bounds(scenes, folder / "bounds.json", limits, progress)
        notes += bound_notes
        for line in _measure(scenes, plan, limits, store, progress):
            rows.append(line)
    except KeyboardInterrupt:
        interrupted = True
        notes.append("interrupted: the same command continues where it stopped")
    if bent := sorted({line["scene"] for line in rows if line["crushing"] == "parabola"}):
        notes.append(
            "static and kinematic with a conic solver crush joints by the parabola itself, all else by "
            f"chords inside it, as the certified bounds do: of theirs no error is told, on {', '.join(bent)}"
        )
    found = lowest_exact(rows, known)
    notes += improve(scenes, found, update_best_known)
    best = merged(known, found)
    summary = frames.summary(rows, bounds, best, {scene.name: scene.expected for scene in scenes})
    return Comparison(
        tuple(scenes), plan, limits, bounds, best, summary, tuple(notes), interrupted, _failure(rows)
    )


def _failure(rows: Sequence[dict[str, Any]]) -> str:
    """How most runs ended, if all of them crashed or died; else ""."""
    if not rows or any(line["ended"] not in (CRASHED, DIED) for line in rows):
        return ""
    ((reason, count),) = Counter(f"{line['ended']}: {line['message']}" for line in rows).most_common(1)
    return f"{count} of {len(rows)} {reason}"


def _measure(
    scenes: Sequence[CaseScene], plan: Plan, limits: RunLimits, store: Store, progress: Callable[[str], None]
) -> Any:
    """Lines of all runs of the plan, as they are read or made."""
    by_name = {scene.name: scene for scene in scenes}
    runs = list(plan.runs(list(by_name), limits.repeats))
    versions = versions_hash()
    long: set[tuple[str, object]] = set()
    for number, run in enumerate(runs, start=1):
        scene = by_name[run.scene]
        if (run.scene, run.pair) in long:
            continue
        line = store.find(scene, run, versions, limits.time, limits.memory)
        if line is None:
            tolerance = "" if run.pair.tolerance is None else f" · {run.pair.tolerance:.0e}"
            progress(f"{number}/{len(runs)} {run.scene} · {run.pair.label}{tolerance}")
            ended = _solve(scene, run, limits)
            line = row(scene, run, versions, ended, limits.time, limits.memory)
            store.add(line)
        if line["wall"] > REPEATED_BELOW or line["ended"] != FINISHED:
            long.add((run.scene, run.pair))
        yield line


def _solve(scene: CaseScene, run: PlannedRun, limits: RunLimits) -> Ended:
    return run_limited(run_pair, (scene.path, run.pair, limits.time), limits.time, limits.memory)


def _bounds(
    scenes: Sequence[CaseScene], path: Path, limits: RunLimits, progress: Callable[[str], None]
) -> tuple[dict[str, CertifiedBounds], list[str]]:
    """Certified bounds of every scene, from the cache beside the results or computed; what failed."""
    try:
        cached = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        cached = {}
    found, notes = {}, []
    for scene in scenes:
        if scene.expected.get(ASSOCIATIVE, ANSWER) != ANSWER:
            continue  # nothing to bound
        if scene.content not in cached:
            progress(f"certified bounds of {scene.name}")
            time_limit = max(limits.time, _BOUNDS_TIME)
            ended = run_limited(bound_scene, (scene.path,), time_limit, limits.memory)
            if ended.how != FINISHED:
                notes.append(f"{scene.name}: no certified bounds: {ended.how}: {ended.reason}")
                continue
            cached[scene.content] = ended.value
            write_whole(path, json.dumps(cached, indent=1))
        found[scene.name] = CertifiedBounds(**cached[scene.content])
    return found, notes

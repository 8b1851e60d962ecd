"""One run of a comparison, and its row of results."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_opt.analysis import solve
from masonry_opt.answer.acceptance import LIMITS, Kind, over_load_factor
from masonry_opt.effort import PARTS
from masonry_opt.errors import MasonryError
from masonry_opt.methods.registry import METHODS
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.case_file import case_folder, load
from masonry_opt.solvers.registry import LANGUAGES
from masonry_opt.studies.compare.accuracy import certified_bounds
from masonry_opt.studies.compare.plan import Pair
from masonry_opt.studies.runner import TaskEnd

#: Columns that identify a run: a run with an equal key is not made again.
KEY = ("scene", "content", "versions", "method", "model", "solver", "tolerance", "repeat")

#: Residuals of a certificate.
RESIDUALS = ("equilibrium", "yield", "flow", "complementarity")

_WORDS = ("ended", "status", "kind", "existence", "crushing", "friction_law", "message")
_SECONDS = tuple(f"{part}_seconds" for part in PARTS)
_COUNTS = ("lp_solves", "nlp_solves", "iterations", "blocks", "joints")
_SIZE = ("rows", "columns", "nonzeros")

#: Columns of results.csv: λ and its certificate, seconds, memory in MB, counts, and the limits of the run.
#: ``wall`` is the solve by the clock; of a run that did not finish, the time of its process.
COLUMNS = (*KEY, *_WORDS, "load_factor", "bound", *RESIDUALS, "wall", *_SECONDS, "peak_memory", *_COUNTS)
COLUMNS += (*_SIZE, "time_limit", "memory_limit")

#: Share of a run's time limit that a method with a time limit of its own is given.
_OWN_LIMIT = 0.8

#: A case file of two blocks.
_WARM_UP = Path("gilbert", "two_blocks.toml")


def run_pair(path: Path, pair: Pair, time_limit: float) -> dict[str, Any]:
    """Solve a case file on one core; returns the columns that the result gives. A first solve of two blocks
    is not timed: libraries load parts of themselves at the first use."""
    _take_one_core()
    chosen: dict[str, Any] = {"model": pair.model, "solver": pair.solver, "tolerance": pair.tolerance}
    method = METHODS[pair.method]
    options: dict[str, Any] = {}
    if method.options and "time_limit" in method.options.model_fields:
        options["time_limit"] = _OWN_LIMIT * time_limit
    with contextlib.suppress(MasonryError, ArithmeticError, ValueError, AttributeError):
        # A solver that fails here fails again below, where it counts.
        small = case_folder() / _WARM_UP
        if method.own_tolerances:
            for model in LANGUAGES:
                solve(small, "static", model=model)
        else:
            solve(small, pair.method, **chosen)
    start = time.perf_counter()
    # Without the load to expect: the time measured is the method's own.
    result = solve(path, pair.method, expected=False, **chosen, **options)
    wall = time.perf_counter() - start
    told = result.as_dict()
    same = ("status", "kind", "crushing", "friction_law", "message", "load_factor", "bound", *_COUNTS)
    return (
        {name: told[name] for name in same}
        | {name: told["size"].get(name) for name in _SIZE}
        | {f"{part}_seconds": seconds for part, seconds in told["seconds"].items()}
        | (told["certificate"] or {})
        | {"existence": (told["infeasibility"] or {}).get("existence", ""), "wall": wall}
    )


def bound_scene(path: Path) -> dict[str, float]:
    """Certified bounds of a case file's associative load factor (see ``certified_bounds``)."""
    _take_one_core()
    bounds = certified_bounds(assemble(load(path)).problem)
    return {"lower": bounds.lower, "upper": bounds.upper}


def scene_to_expect(path: Path) -> dict[str, float | None]:
    """The load factor to expect of a case file, None if there is none."""
    _take_one_core()
    return {"load_factor": solve(path, "compliant").load_factor}


def _take_one_core() -> None:
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def row_of(key: Mapping[str, Any], end: TaskEnd, time_limit: float, memory_limit: float) -> dict[str, Any]:
    """The row of a run, by COLUMNS."""
    row: dict[str, Any] = dict.fromkeys(COLUMNS) | dict.fromkeys(_WORDS, "")
    row |= {"message": end.reason, "wall": end.seconds}
    row |= {name: value for name, value in (end.value or {}).items() if name in COLUMNS}
    row |= {"message": " ".join(row["message"].split()), "ended": end.how, "peak_memory": end.peak}
    return row | dict(key) | {"time_limit": time_limit, "memory_limit": memory_limit}


def pair_of(row: Mapping[str, Any]) -> Pair:
    return Pair(row["method"], row["model"], row["solver"], row["tolerance"])


def by_sides(row: Mapping[Any, Any]) -> bool:
    """Whether friction in space is limited by sides inside the cone."""
    return "polygon" in row["friction_law"]


def residuals_over_limit(row: Mapping[Any, Any], kind: Kind | None = None) -> dict[str, float | None]:
    """Residuals of a row with a load factor that exceed the limits of its kind of answer, or of another
    ``kind``; a residual that is missing or NaN exceeds them too."""
    left = {name: row[name] for name in RESIDUALS}
    if (energy := left["complementarity"]) is not None:
        left["complementarity"] = over_load_factor(energy, row["load_factor"])
    return LIMITS[kind or Kind(row["kind"])].failing(left)

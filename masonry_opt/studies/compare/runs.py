"""What a comparison runs: case files by pairs of a method and a solver; one run, and its row of results."""

import contextlib
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from masonry_opt.analysis import refuse_without_live_load, solve
from masonry_opt.answer.sense import warnings_of
from masonry_opt.effort import PARTS
from masonry_opt.errors import CaseError, MasonryError, OptionError
from masonry_opt.methods.registry import METHODS, HowToSolve
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.case_file import case_folder, load
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.registry import LANGUAGES, MODELS, find_solver, names
from masonry_opt.studies.compare.accuracy import certified_bounds
from masonry_opt.studies.runner import TaskEnd
from masonry_opt.studies.writing import digest
from masonry_opt.words.sentences import sentences

_NAMING = {"title", "source", "reference"}  #: Keys of a scene that do not change an answer.
#: Columns that identify a run: a run with an equal key is not made again.
KEY = ("scene", "content", "versions", "method", "model", "solver", "tolerance", "repeat")
RESIDUALS = ("equilibrium", "yield", "flow", "complementarity")  #: Residuals of a certificate.
_WORDS = ("ended", "status", "kind", "existence", "crushing", "friction_law", "message")
#: Columns of results.csv: λ and its certificate, seconds, memory in MB, counts, and the limits of the run.
#: ``wall`` is the solve by the clock; of a run that did not finish, the time of its process.
COLUMNS = (*KEY, *_WORDS, "load_factor", "bound", *RESIDUALS, "wall", *(f"{part}_seconds" for part in PARTS))
COLUMNS += ("peak_memory", "lp_solves", "nlp_solves", "iterations", "blocks", "joints")
COLUMNS += ("rows", "columns", "nonzeros", "time_limit", "memory_limit")

_OWN_LIMIT = 0.8  #: Share of a run's time limit that a method with a time limit of its own is given.
_WARM_UP = Path("gilbert", "two_blocks.toml")  #: A case file of two blocks.


@dataclass(frozen=True)
class RunLimits:
    """Seconds and MB that a run may take, and how often it is repeated."""

    time: float = 60.0
    memory: float = 4000.0
    repeats: int = 3


@dataclass(frozen=True)
class CaseScene:
    """A scene of a comparison."""

    name: str  #: folder and stem of its case file, such as "ferris_tinloi/wall_1"
    path: Path
    content: str  #: hash of its numbers (see :func:`content_of`)
    warnings: tuple[str, ...] = ()  #: warnings about probable mistakes in the scene, as sentences


def find_scenes(cases: Iterable[str | Path], folder: Path = Path("cases")) -> tuple[CaseScene, ...]:
    """Read and name the scenes of a comparison: paths of case files, or names of those in a folder
    ("ferris_tinloi/wall_1" or "wall_1").

    Raises CaseError if a case file is missing or wrong; OptionError if a scene has load cases, or two
    different files have one name."""
    scenes: dict[str, CaseScene] = {}
    for case in cases:
        path = _path(case, folder)
        scene = load(path)
        if scene.load_cases:
            raise OptionError(f"{path}: has load cases, which are not compared: leave it out")
        name = f"{path.resolve().parent.name}/{path.stem}"
        found = CaseScene(name, path, content_of(scene))
        before = scenes.setdefault(found.name, found)
        if before.content != found.content:
            raise OptionError(f"{before.path} and {path}: two scenes named '{found.name}': rename one")
    return tuple(scenes.values())


def checked(found: CaseScene) -> CaseScene:
    """Return a scene with its warnings.

    Raises CaseError if no method can solve it: joints are wrong, or no load but that of moving axles is live.
    """
    assembly = assemble(load(found.path))
    refuse_without_live_load(assembly)
    return replace(found, warnings=sentences(warnings_of(assembly, None)))


def content_of(scene: Scene) -> str:
    """Hash of what a scene's answer depends on, 12 hexadecimal digits. Keys at their defaults do not count: a
    key that a later version adds changes no hash."""
    return digest(scene.model_dump(exclude=_NAMING, exclude_defaults=True))[:12]


def _path(case: str | Path, folder: Path) -> Path:
    if not isinstance(case, str | Path):
        raise OptionError("compare takes case files, which each run reads: mo.save(scene, 'scene.toml')")
    path = Path(case)
    if path.exists() or path.suffix:
        return path
    files = {f"{file.parent.name}/{file.stem}": file for file in sorted(folder.glob("*/*.toml"))}
    named = [name for name, file in files.items() if str(case) in (file.stem, name)]
    if not named:
        raise CaseError(f"{case}: no such file, and no case in {folder}/ has that name")
    if len(named) > 1:
        raise OptionError(f"'{case}' may be {', '.join(named)}: name one in full")
    return files[named[0]]


@dataclass(frozen=True)
class Pair:
    """A method and the solver it runs with, at one tolerance (None: the method's or solver's own)."""

    method: str
    model: str
    solver: str
    tolerance: float | None


@dataclass(frozen=True)
class RunPlan:
    """The pairs of a comparison; and method, model and solver of combinations that cannot be, and why."""

    pairs: tuple[Pair, ...]
    left_out: tuple[tuple[str, str, str, str], ...]


def plan(
    methods: Sequence[str], models: Sequence[str], solvers: Sequence[str], tolerances: Sequence[float]
) -> RunPlan:
    """The admissible combinations, by the registries METHODS and SOLVERS. A method with tolerances of its own
    runs once, with its default solver if none of its solvers is named. Raises OptionError if a name is
    unknown, a tolerance is out of range, or nothing is left to run."""
    named = {"method": (methods, METHODS), "model": (models, MODELS), "solver": (solvers, names())}
    for what, (asked, known) in named.items():
        if unknown := [name for name in asked if name not in known]:
            raise OptionError(f"{what} '{unknown[0]}' is unknown; choose from: {', '.join(known)}")
    for tolerance in tolerances:
        find_solver(LANGUAGES[0], None, tolerance)  # refuses what is out of range
    pairs: list[Pair] = []
    left_out: list[tuple[str, str, str, str]] = []
    for combination in ((one, *rest) for one in methods for rest in _combinations(one, models, solvers)):
        try:
            how = HowToSolve(*combination)
        except OptionError as error:
            left_out.append((*combination, str(error)))
            continue
        takes_one = how.engine.entry.options and not how.chosen.own_tolerances
        pairs += [Pair(*combination, t) for t in (tolerances if takes_one else [None])]
    if not pairs:
        why = "; ".join(f"{', '.join(names)}: {reason}" for *names, reason in left_out)
        raise OptionError(f"nothing to compare: {why}")
    return RunPlan(tuple(dict.fromkeys(pairs)), tuple(left_out))


def _combinations(method: str, models: Sequence[str], solvers: Sequence[str]) -> list[tuple[str, str]]:
    """Models and solvers as named; of a method with tolerances of its own, those it has."""
    own = METHODS[method]
    if not own.own_tolerances:
        return [*product(models, solvers)]
    every = [(model, solver) for model, allowed in own.solvers.items() for solver in allowed]
    return [pair for pair in every if pair[1] in solvers] or every[:1]


def run_pair(path: Path, pair: Pair, time_limit: float) -> dict[str, Any]:
    """Solve a case file on one core; returns the columns that the result gives. A first solve of two blocks
    is not timed: libraries load parts of themselves at the first use."""
    _take_one_core()
    # Without the incremental load factor: the time measured is the method's own.
    chosen, own = asdict(pair) | {"incremental": False}, METHODS[pair.method].options
    limited = own and "time_limit" in own.model_fields
    options: dict[str, Any] = {"time_limit": _OWN_LIMIT * time_limit} if limited else {}
    with contextlib.suppress(MasonryError, ArithmeticError, ValueError, AttributeError):
        # A solver that fails here fails again below, where it counts.
        solve(case_folder() / _WARM_UP, **chosen)
    start = time.perf_counter()
    result = solve(path, **chosen, **options)
    wall = time.perf_counter() - start
    told = result.as_dict()
    told |= {f"{part}_seconds": seconds for part, seconds in told["seconds"].items()}
    told |= told["size"] | (told["certificate"] or {}) | {"wall": wall}
    told["existence"] = (told["infeasibility"] or {}).get("existence", "")
    return {name: told[name] for name in COLUMNS if name in told}


def bound_scene(path: Path) -> dict[str, float]:
    """Certified bounds of a case file's associative load factor (see ``certified_bounds``)."""
    _take_one_core()
    return asdict(certified_bounds(assemble(load(path)).problem))


def _take_one_core() -> None:
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def row_of(key: Mapping[str, Any], end: TaskEnd, limits: RunLimits) -> dict[str, Any]:
    """The row of a run, by COLUMNS."""
    row: dict[str, Any] = dict.fromkeys(COLUMNS) | dict.fromkeys(_WORDS, "")
    row |= {"message": end.reason, "wall": end.seconds} | (end.value or {})
    row |= {"message": " ".join(row["message"].split()), "ended": end.how, "peak_memory": end.peak}
    return row | dict(key) | {"time_limit": limits.time, "memory_limit": limits.memory}

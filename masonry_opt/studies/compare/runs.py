"""Runs of a comparison: combinations of case files, methods and solvers, and the row of one run."""

import contextlib
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from masonry_opt.analysis import solve
from masonry_opt.brief import brief
from masonry_opt.effort import PARTS
from masonry_opt.errors import CaseError, MasonryError, OptionError
from masonry_opt.methods.registry import METHODS, HowToSolve
from masonry_opt.problem.assembly import assemble
from masonry_opt.reporting.sentences import sentences
from masonry_opt.scene.case_file import case_folder, load
from masonry_opt.scene.mistakes import instead_of
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.sense import warnings_of
from masonry_opt.solvers.registry import LANGUAGES, MODELS, find_solver, names
from masonry_opt.studies.compare.accuracy import certified_bounds
from masonry_opt.studies.runner import TaskEnd
from masonry_opt.studies.writing import digest
from masonry_opt.suitability import refuse_without_live_load

_DESCRIPTIVE = {"title", "source", "reference"}  #: Keys of a scene that do not influence answers.
#: Columns that identify a run. A run is not made again if the journal has a run with equal values in these
#: columns.
KEY = ("scene", "content", "versions", "method", "model", "solver", "tolerance", "repeat")
CERTIFICATE_RESIDUALS = ("equilibrium", "yield", "flow", "complementarity")  #: Residuals of a certificate.
#: Columns of text; "" if unknown.
_TEXT_COLUMNS = ("ended", "status", "kind", "existence", "crushing", "friction_law", "message")
#: Columns of results.csv. Times are in seconds, and memory is in MB. The column ``load_factor_unit`` is the
#: unit of the :class:`LoadFactorScale` on which λ is compared. The column ``wall`` is the duration of the
#: solve, or of the process if the run did not finish. The columns ``rows``, ``columns`` and ``nonzeros`` are
#: the size of the linear program.
COMPARISON_COLUMNS = (
    *KEY,
    *_TEXT_COLUMNS,
    *("load_factor", "load_factor_unit", "bound", *CERTIFICATE_RESIDUALS),
    *("wall", *(f"{part}_seconds" for part in PARTS)),
    *("peak_memory", "lp_solves", "nlp_solves", "iterations", "blocks", "joints"),
    *("rows", "columns", "nonzeros", "time_limit", "memory_limit"),
)

_METHOD_TIME_SHARE = 0.8  #: Fraction of a run's time limit that is passed to the method as ``time_limit``.
#: Case file of two blocks, which is solved as a warm-up before timing.
_WARM_UP = Path("gilbert", "two_blocks.toml")


@dataclass(frozen=True)
class RunLimits:
    """Limits of time and memory of each run, and the number of repeats."""

    time: float = 60.0  #: seconds
    memory: float = 4000.0  #: MB (10⁶ bytes)
    repeats: int = 3


@dataclass(frozen=True)
class CaseScene:
    """One scene of a comparison: name, path of the case file, hash of the inputs, and warnings."""

    name: str  #: folder and stem of the case file, such as "ferris_tinloi/wall_1"
    path: Path
    content: str  #: hash of the inputs (see :func:`content_of`)
    warnings: tuple[str, ...] = ()  #: warnings about probable mistakes in the scene, as sentences


def find_scenes(cases: Iterable[str | Path], folder: Path = Path("cases")) -> tuple[CaseScene, ...]:
    """Read the scenes of a comparison, and return them with their names.

    An entry of ``cases`` is the path of a case file, or the name of a case file in ``folder``, such as
    "ferris_tinloi/wall_1" or "wall_1". Raises CaseError if a case file is missing or wrong. Raises
    OptionError if a scene has load cases, or if two different files have the same name.
    """
    scenes: dict[str, CaseScene] = {}
    for case in cases:
        path = _path(case, folder)
        scene = load(path)
        if scene.load_cases:
            raise OptionError(f"{path}: scenes with load cases cannot be compared: remove this case file")
        name = f"{path.resolve().parent.name}/{path.stem}"
        case_scene = CaseScene(name, path, content_of(scene))
        first = scenes.setdefault(name, case_scene)
        if first.content != case_scene.content:
            raise OptionError(f"{first.path} and {path}: both scenes are named '{name}': rename one of them")
    return tuple(scenes.values())


def checked(scene: CaseScene) -> CaseScene:
    """Look for probable mistakes in a scene, and return a copy of the scene with warnings about them.

    Raises CaseError if no method can solve the scene, for example if moving axles are the only live load.
    """
    assembly = assemble(load(scene.path))
    refuse_without_live_load(assembly)
    return replace(scene, warnings=sentences(warnings_of(assembly, None)))


def content_of(scene: Scene) -> str:
    """Return a hash (12 hexadecimal digits) of the inputs that influence the answers of a scene.

    Keys with default values are ignored, so that new keys of a later version do not change the hash.
    """
    return digest(scene.model_dump(exclude=_DESCRIPTIVE, exclude_defaults=True))[:12]


def _path(case: str | Path, folder: Path) -> Path:
    """Return the path of a case file that is specified by its path, or by its name in ``folder``.

    Raises CaseError if no case file has the name. Raises OptionError if several case files have the name, or
    if ``case`` is neither a text nor a path.
    """
    if not isinstance(case, str | Path):
        raise OptionError(
            "compare needs paths of case files: write the scene to a file with mo.save(scene, 'scene.toml')"
        )
    path = Path(case)
    if path.exists() or path.suffix:
        return path
    files = {f"{file.parent.name}/{file.stem}": file for file in sorted(folder.glob("*/*.toml"))}
    named = [name for name, file in files.items() if str(case) in (file.stem, name)]
    if not named:
        raise CaseError(f"{case}: this file does not exist, and no case file in {folder}/ has this name")
    if len(named) > 1:
        raise OptionError(f"the name '{case}' is ambiguous: write {' or '.join(named)}")
    return files[named[0]]


@dataclass(frozen=True)
class Pair:
    """Method and solver of a run, with the modelling language and the tolerance of the solver."""

    method: str
    model: str
    solver: str
    #: tolerance of the solver; None if the method chooses its tolerances, or if the solver has fixed
    #: tolerances
    tolerance: float | None


@dataclass(frozen=True)
class RunPlan:
    """Combinations of method, model, solver and tolerance that a comparison runs."""

    pairs: tuple[Pair, ...]
    #: Combinations that are not possible, as tuples of method, model, solver and reason.
    left_out: tuple[tuple[str, str, str, str], ...]

    __repr__ = brief


def plan(
    methods: Sequence[str], models: Sequence[str], solvers: Sequence[str], tolerances: Sequence[float]
) -> RunPlan:
    """Combine methods, models, solvers and tolerances, and return the possible and impossible combinations.

    A method with its own tolerances runs only once with each solver. If none of its solvers is named, it runs
    with its default solver. Raises OptionError if a name is unknown, if a tolerance is out of range, or if no
    combination exists.
    """
    named = {"method": (methods, METHODS), "model": (models, MODELS), "solver": (solvers, names())}
    for kind, (values, known) in named.items():
        unknown = [name for name in values if name not in known]
        if unknown:
            raise OptionError(f"{kind} '{unknown[0]}' is unknown{instead_of(unknown[0], known)}")
    for tolerance in tolerances:
        find_solver(LANGUAGES[0], None, tolerance)  # raises OptionError if the tolerance is out of range
    pairs: list[Pair] = []
    left_out: list[tuple[str, str, str, str]] = []
    for method in methods:
        for model, solver in _combinations(method, models, solvers):
            try:
                how = HowToSolve(method, model, solver)
            except OptionError as error:
                left_out.append((method, model, solver, str(error)))
                continue
            takes_tolerance = how.engine.entry.options and not how.chosen.own_tolerances
            applied = tolerances if takes_tolerance else [None]
            pairs += [Pair(method, model, solver, tolerance) for tolerance in applied]
    if not pairs:
        why = "; ".join(f"{', '.join(names)}: {reason}" for *names, reason in left_out)
        raise OptionError(f"nothing to compare: {why}")
    return RunPlan(tuple(dict.fromkeys(pairs)), tuple(left_out))


def _combinations(method: str, models: Sequence[str], solvers: Sequence[str]) -> list[tuple[str, str]]:
    """Return the pairs of a modelling language and a solver that a comparison considers for a method.

    A method with its own tolerances has a fixed list of pairs. The pairs whose solver is named are returned,
    or the first pair if none of its solvers is named.
    """
    entry = METHODS[method]
    if not entry.own_tolerances:
        return [*product(models, solvers)]
    own_pairs = [(model, solver) for model, allowed in entry.solvers.items() for solver in allowed]
    return [pair for pair in own_pairs if pair[1] in solvers] or own_pairs[:1]


def run_pair(path: Path, pair: Pair, time_limit: float) -> dict[str, Any]:
    """Solve a case file on one processor core, and return the columns of the result.

    A scene of two blocks is solved first without timing, because libraries load parts of their code only at
    their first use.
    """
    _use_one_core()
    # The incremental load factor is not computed, so that only the method itself is timed.
    chosen, option_model = asdict(pair) | {"incremental": False}, METHODS[pair.method].options
    has_time_limit = option_model and "time_limit" in option_model.model_fields
    options: dict[str, Any] = {"time_limit": _METHOD_TIME_SHARE * time_limit} if has_time_limit else {}
    with contextlib.suppress(MasonryError, ArithmeticError, ValueError, AttributeError):
        # Ignore errors of the warm-up, because a solver that fails will fail again in the timed solve.
        solve(case_folder() / _WARM_UP, **chosen)
    start = time.perf_counter()
    result = solve(path, **chosen, **options)
    wall = time.perf_counter() - start
    values = result.as_dict()
    values |= {f"{part}_seconds": seconds for part, seconds in values["seconds"].items()}
    values |= values["size"] | (values["certificate"] or {}) | {"wall": wall}
    values["load_factor_unit"] = result.assembly.problem.load_factor_scale.unit
    values["existence"] = (values["infeasibility"] or {}).get("existence", "")
    return {name: values[name] for name in COMPARISON_COLUMNS if name in values}


def bound_scene(path: Path) -> dict[str, float]:
    """Return certified bounds on the associative load factor of a case file; see ``certified_bounds``."""
    _use_one_core()
    return asdict(certified_bounds(assemble(load(path)).problem))


def _use_one_core() -> None:
    """Restrict this process to one processor core, if the operating system supports this."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def row_of(key: Mapping[str, Any], end: TaskEnd, limits: RunLimits) -> dict[str, Any]:
    """Return a row of the table of results, made from the key of a run and the outcome of its task."""
    row: dict[str, Any] = dict.fromkeys(COMPARISON_COLUMNS) | dict.fromkeys(_TEXT_COLUMNS, "")
    row |= {"message": end.reason, "wall": end.seconds} | (end.value or {})
    row |= {"message": " ".join(row["message"].split()), "ended": end.how, "peak_memory": end.peak}
    return row | dict(key) | {"time_limit": limits.time, "memory_limit": limits.memory}

"""The plan of a comparison: its scenes, which are case files, and its pairs of a method and a solver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.methods.registry import METHODS, HowToSolve
from masonry_opt.scene.case_file import load
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.registry import LANGUAGES, MODELS, find_solver, names
from masonry_opt.studies.journal import digest

#: Keys of a scene that do not change an answer.
_WORDS = {"title", "source", "reference"}


@dataclass(frozen=True)
class CaseScene:
    """A scene of a comparison.

    Attributes
    ----------
    name: folder and stem of its case file, such as "ferris_tinloi/wall_1".
    content: hash of its numbers (see :func:`content_of`).
    expected: claims known by hand, by question (see :func:`~.judge.known_claims`).
    """

    name: str
    path: Path
    content: str
    title: str
    expected: Mapping[str, str] = field(default_factory=dict)


def find_scenes(cases: Iterable[str | Path], folder: Path = Path("cases")) -> tuple[CaseScene, ...]:
    """Read and name the scenes of a comparison: paths of case files, or names of those in a folder
    ("ferris_tinloi/wall_1" or "wall_1").

    Raises CaseError if a case file is missing or wrong, OptionError if two different files have one name.
    """
    scenes: dict[str, CaseScene] = {}
    for case in cases:
        path = _path(case, folder)
        scene = load(path)
        if scene.load_cases:
            raise OptionError(f"{path}: has load cases, which are not compared: leave it out")
        name = f"{path.resolve().parent.name}/{path.stem}"
        found = CaseScene(name, path, content_of(scene), scene.title)
        before = scenes.setdefault(found.name, found)
        if before.content != found.content:
            raise OptionError(f"{before.path} and {path}: two scenes named '{found.name}': rename one")
    return tuple(scenes.values())


def content_of(scene: Scene) -> str:
    """Hash of what a scene's answer depends on, 12 hexadecimal digits.

    Keys at their defaults do not count: a key that a later version adds changes no hash. A live load given as
    a multiple of the block's weight has the hash of its force.
    """
    keys = scene.model_dump(exclude=_WORDS, exclude_defaults=True)
    # Not beside loads: one may give another weight, which the multiple follows.
    for block in [] if scene.loads else keys["blocks"]:
        if "weight" in block and "live" not in block and (times := block.pop("live_per_weight", None)):
            block["live"] = tuple(part * block["weight"] for part in times)
            block |= {"live_at": block["weight_at"]} if "weight_at" in block else {}
    return digest(keys)[:12]


def _path(case: str | Path, folder: Path) -> Path:
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


@dataclass(frozen=True, order=True)
class Pair:
    """A method and the solver it runs with, at one tolerance (None: the method's or solver's own)."""

    method: str
    model: str
    solver: str
    tolerance: float | None

    @property
    def label(self) -> str:
        """The pair without its tolerance."""
        return f"{self.method} · {self.model} · {self.solver}"


@dataclass(frozen=True)
class RunPlan:
    """The pairs of a comparison; and method, model and solver of combinations that cannot be, and why."""

    pairs: tuple[Pair, ...]
    left_out: tuple[tuple[str, str, str, str], ...]


def plan(
    methods: Sequence[str], models: Sequence[str], solvers: Sequence[str], tolerances: Sequence[float]
) -> RunPlan:
    """The admissible combinations, by the registries METHODS and SOLVERS.

    A method with tolerances of its own runs once, with its default solver if none of its solvers is named.

    Raises OptionError if a name is unknown, a tolerance is out of range, or nothing is left to run.
    """
    named = {"method": (methods, METHODS), "model": (models, MODELS), "solver": (solvers, names())}
    for what, (asked, known) in named.items():
        if unknown := [name for name in asked if name not in known]:
            raise OptionError(f"{what} '{unknown[0]}' is unknown; choose from: {', '.join(known)}")
    for tolerance in tolerances:
        find_solver(LANGUAGES[0], None, tolerance)  # refuses what is out of range
    pairs: list[Pair] = []
    left_out: list[tuple[str, str, str, str]] = []
    for method in methods:
        for model, solver in _combinations(method, models, solvers):
            try:
                how = HowToSolve(method, model, solver)
            except OptionError as error:
                left_out.append((method, model, solver, str(error)))
                continue
            takes_one = how.engine.entry.options and not how.chosen.own_tolerances
            pairs += [Pair(method, model, solver, t) for t in (tolerances if takes_one else [None])]
    if not pairs:
        why = "; ".join(f"{', '.join(names)}: {reason}" for *names, reason in left_out)
        raise OptionError(f"nothing to compare: {why}")
    return RunPlan(tuple(dict.fromkeys(pairs)), tuple(left_out))


def _combinations(method: str, models: Sequence[str], solvers: Sequence[str]) -> list[tuple[str, str]]:
    """Models and solvers as named; of a method with tolerances of its own, those it has."""
    own = METHODS[method]
    if not own.own_tolerances:
        return [(model, solver) for model in models for solver in solvers]
    every = [(model, solver) for model, allowed in own.solvers.items() for solver in allowed]
    return [pair for pair in every if pair[1] in solvers] or every[:1]

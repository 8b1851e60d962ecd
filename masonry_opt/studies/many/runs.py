"""One certified run of many: a scene with other values, solved, as a row of plain numbers and words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from masonry_opt.answer.acceptance import SMALLEST
from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import SAME
from masonry_opt.effort import Effort
from masonry_opt.methods.how_to_solve import HowToSolve
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.kept import Kept
from masonry_opt.scene.scene import Scene
from masonry_opt.session import Session
from masonry_opt.studies.journal import digest
from masonry_opt.studies.machine import versions
from masonry_opt.studies.many.parameters import Parameters
from masonry_opt.studies.runner import FINISHED, TaskEnd
from masonry_opt.words.sentences import message

#: Columns of a row beside the values, in order, and their types in a table. ``seconds`` alone depends on
#: machine and time.
COLUMNS = {
    "load_factor": "float64",
    **dict.fromkeys(("status", "reason"), "object"),
    **dict.fromkeys(("any_load", "exact"), "boolean"),
    "states": "Int64",
    **dict.fromkeys(("expected", "associative"), "float64"),
    **dict.fromkeys(("equilibrium", "yield", "flow", "complementarity"), "float64"),
    "mechanism": "object",
    **dict.fromkeys(("slides", "hinges", "separates", "crushes", "blocks", "joints"), "Int64"),
    "message": "object",
    "seconds": "float64",
}

#: Names of mechanisms. "separating": no joint does anything but come apart. "none": no joint does anything.
SLIDING, HINGING, CRUSHING, MIXED = "sliding", "hinging", "crushing", "mixed"
SEPARATING, NONE = "separating", "none"

_NAMES = {"slides": SLIDING, "hinges": HINGING, "crushes": CRUSHING}


@dataclass(frozen=True)
class Study:
    """What all runs share: the scene whose numbers change (None where every run brings its own), and how they
    are solved."""

    scene: Scene | None
    how: HowToSolve

    def identity(self) -> dict[str, str]:
        """Hashes of all that decides the rows, by name."""
        how = self.how
        options = {name: repr(value) for name, value in sorted(how.options.items())}
        return {
            "scene": "" if self.scene is None else _of_scene(self.scene),
            "method": digest((how.method, how.model, how.solver, how.tolerance, how.expected)),
            "options": digest(options),
            "versions": digest(versions()),
        }


@dataclass(frozen=True)
class StudyRun:
    """Values by name, and the scene that they make where the study has none."""

    values: Mapping[str, float]
    scene: Scene | None = None

    @property
    def key(self) -> str:
        """Hash of values and scene: the key of its row in a journal."""
        values = {name: float(value) for name, value in self.values.items()}
        return digest((values, None if self.scene is None else _of_scene(self.scene)))


class RunSolver:
    """Solves the runs of one study in one process, and keeps what does not change between them."""

    def __init__(self, study: Study) -> None:
        self._parameters = None if study.scene is None else Parameters(study.scene)
        self._session = Session(study.how, Kept(keeps=True))

    def __call__(self, run: StudyRun) -> dict[str, Any]:
        """The columns of a run's solution."""
        scene = run.scene
        if scene is None:
            assert self._parameters is not None  # the study has a scene where its runs have none
            scene = self._parameters.at(run.values)
        return columns(*self._session.answer(scene, lambda _: None, Effort()))


def row(run: StudyRun, end: TaskEnd) -> dict[str, Any]:
    """The row of a run: its values, then COLUMNS; of a run that did not finish, the reason."""
    without = {"status": end.how, "reason": end.how, "message": end.reason}
    found = end.value if end.how == FINISHED else without
    return dict(run.values) | dict.fromkeys(COLUMNS) | found | {"seconds": end.seconds}


def columns(assembly: Assembly, solution: Solution) -> dict[str, Any]:
    problem = assembly.problem
    row: dict[str, Any] = {
        "load_factor": solution.load_factor,
        "status": str(solution.status),
        "reason": str(solution.reasons[0].code) if solution.reasons else "",
        "any_load": solution.carries_any_load,
        "exact": solution.is_exact(problem),
        "states": solution.states_met,
        "expected": solution.expected_value,
        "associative": solution.associative_value,
        "blocks": problem.blocks,
        "joints": len(assembly.joints.first),
        "message": message(solution.reasons),
    }
    if solution.answer:
        row |= solution.answer.certificate.as_dict()
    return row | mechanism(assembly, solution)


def mechanism(assembly: Assembly, solution: Solution) -> dict[str, Any]:
    """Name of the mechanism, and how many joints slide, hinge, come apart and crush; empty without one."""
    if solution.d is None:
        return {}
    motion = joint_motion(assembly, solution)
    counts = {kind: int(getattr(motion, kind).sum()) for kind in (*_NAMES, "separates")}
    names = [name for kind, name in _NAMES.items() if counts[kind]]
    if not names:
        names = [SEPARATING if counts["separates"] else NONE]
    return {"mechanism": names[0] if len(names) == 1 else MIXED, **counts}


def _of_scene(scene: Scene) -> str:
    # Of generators too: two files may say the same blocks, and vary otherwise.
    case = None if scene.case is None else scene.case.model_dump_json()
    load_case = None if scene.load_case is None else scene.load_case.model_dump_json()
    return digest((scene.model_dump_json(), case, *filter(None, [load_case])))


def at_least(frame: pd.DataFrame) -> pd.Series:
    """Whether each run has the least load factor, within SAME, shape (runs,)."""
    values = frame["load_factor"]
    least = values.min()
    return values <= least + SAME * max(abs(least), SMALLEST)

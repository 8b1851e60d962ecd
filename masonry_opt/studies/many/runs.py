"""One certified run of many: a scene with other values, solved, as a row of plain numbers and words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from masonry_opt.analysis import prepare
from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.solution import Solution
from masonry_opt.effort import Effort
from masonry_opt.errors import CaseError
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.journal import digest
from masonry_opt.studies.machine import versions
from masonry_opt.studies.many.parameters import Parameters
from masonry_opt.studies.runner import FINISHED, End
from masonry_opt.words.sentences import message

#: Columns of a row beside the values, in order. ``seconds`` alone depends on machine and time.
COLUMNS = (
    "load_factor",
    "status",
    "reason",
    "any_load",
    "exact",
    "states",
    "associative",
    "equilibrium",
    "yield",
    "flow",
    "complementarity",
    "mechanism",
    "slides",
    "hinges",
    "separates",
    "crushes",
    "blocks",
    "joints",
    "message",
    "seconds",
)

#: Kinds of the columns of a table that are no real numbers.
KINDS = {
    **dict.fromkeys(("status", "reason", "mechanism", "message"), "object"),
    **dict.fromkeys(("states", "slides", "hinges", "separates", "crushes", "blocks", "joints"), "Int64"),
    **dict.fromkeys(("any_load", "exact"), "boolean"),
}

#: Names of mechanisms. Joints that come apart give it its name where no other moves, and "none" is one whose
#: blocks move without a joint that slides, opens or crushes.
SLIDING, HINGING, CRUSHING, MIXED = "sliding", "hinging", "crushing", "mixed"
SEPARATING, NONE = "separating", "none"

_NAMES = {"slides": SLIDING, "hinges": HINGING, "crushes": CRUSHING}


@dataclass(frozen=True)
class Study:
    """What all runs share: sent to every worker once.

    Attributes
    ----------
    scene: whose numbers change; None where every run brings a scene of its own.
    method, model, solver, tolerance, options: as of :func:`~masonry_opt.analysis.solve`.
    """

    scene: Scene | None
    method: str = DEFAULT
    model: str | None = None
    solver: str | None = None
    tolerance: float | None = None
    options: Mapping[str, Any] = field(default_factory=dict)

    def identity(self) -> dict[str, str]:
        """Hashes of what decides the rows, by what they are of."""
        options = {name: repr(value) for name, value in sorted(self.options.items())}
        return {
            "scene": "" if self.scene is None else _of_scene(self.scene),
            "method": digest((self.method, self.model, self.solver, self.tolerance)),
            "options": digest(options),
            "versions": digest(versions()),
        }


@dataclass(frozen=True)
class Run:
    """One run: values by name, and the scene that they make where the study has none."""

    values: Mapping[str, float]
    scene: Scene | None = None

    @property
    def key(self) -> str:
        """Hash of its values and scene: its row in a journal."""
        values = {name: float(value) for name, value in self.values.items()}
        return digest((values, None if self.scene is None else _of_scene(self.scene)))


class Solves:
    """The solves of one study, one run after the other, in one process: what does not change is kept."""

    def __init__(self, study: Study) -> None:
        self._parameters = None if study.scene is None else Parameters(study.scene)
        self._session = prepare(
            study.method,
            model=study.model,
            solver=study.solver,
            tolerance=study.tolerance,
            keeps=True,
            **study.options,
        )

    def __call__(self, run: Run) -> dict[str, Any]:
        """What the row of a run keeps of its solution."""
        scene = run.scene
        if scene is None:
            if self._parameters is None:
                raise CaseError("the run has no scene")
            scene = self._parameters.at(run.values)
        return columns(*self._session.answer(scene, lambda _: None, Effort()))


def row(run: Run, end: End) -> dict[str, Any]:
    """The row of a run: its values, then COLUMNS. One that did not finish says why."""
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
        "associative": solution.associative_value,
        "blocks": problem.blocks,
        "joints": problem.joints,
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
    return digest((scene.model_dump_json(), case))

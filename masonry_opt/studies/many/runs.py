"""One certified run of many: a scene with other values, solved, as a row of plain numbers and words."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from masonry_opt.analysis import prepare
from masonry_opt.answer.solution import Solution
from masonry_opt.effort import Effort
from masonry_opt.errors import CaseError, MasonryError
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.endings import CRASHED, DIED, REFUSED
from masonry_opt.studies.many.mechanism import mechanism
from masonry_opt.studies.many.parameters import Parameters
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


@dataclass(frozen=True)
class Study:
    """What all runs share: sent to every worker once.

    Attributes
    ----------
    scene: whose numbers change; None where every task brings a scene of its own.
    method, model, solver, tolerance, options: as of :func:`~masonry_opt.analysis.solve`.
    """

    scene: Scene | None
    method: str = DEFAULT
    model: str | None = None
    solver: str | None = None
    tolerance: float | None = None
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Task:
    """One run: values by name, and the scene that they make where the study has none."""

    values: Mapping[str, float]
    scene: Scene | None = None


class Runner:
    """Makes the runs of one study, one after the other, in one process."""

    def __init__(self, study: Study) -> None:
        self.study = study
        self._parameters = None if study.scene is None else Parameters(study.scene)
        self._session = prepare(
            study.method,
            model=study.model,
            solver=study.solver,
            tolerance=study.tolerance,
            keeps=True,
            **study.options,
        )

    def run(self, task: Task) -> dict[str, Any]:
        """The row of a task: its values, then COLUMNS. What fails is said in ``status`` and ``message``."""
        began = time.perf_counter()
        row = dict(task.values) | dict.fromkeys(COLUMNS)
        try:
            row |= columns(*self._solved(task))
        except MasonryError as error:
            row = refused(task, error)
        except Exception as error:  # whatever it is, it is this run's result, and the others go on
            row = _without_result(task, CRASHED, f"{type(error).__name__}: {error}")
        return row | {"seconds": time.perf_counter() - began}

    def _solved(self, task: Task) -> tuple[Assembly, Solution]:
        scene = task.scene
        if scene is None:
            if self._parameters is None:
                raise CaseError("the run has no scene")
            scene = self._parameters.at(task.values)
        return self._session.answer(scene, lambda _: None, Effort())


def refused(task: Task, error: MasonryError) -> dict[str, Any]:
    """The row of a task that an error of its user's ended."""
    return _without_result(task, REFUSED, str(error))


def died(task: Task, how: str) -> dict[str, Any]:
    """The row of a task whose workers died, and how."""
    return _without_result(task, DIED, how)


def _without_result(task: Task, status: str, message: str) -> dict[str, Any]:
    said = {"status": status, "reason": status, "message": message, "seconds": 0.0}
    return dict(task.values) | dict.fromkeys(COLUMNS) | said


def columns(assembly: Assembly, solution: Solution) -> dict[str, Any]:
    """What a row keeps of a solution."""
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

"""``solve``: a scene, a method and a solver to a result."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from masonry_opt.answer.acceptance import failing_residuals, refused
from masonry_opt.answer.result import Result, make_result
from masonry_opt.answer.solution import Finding
from masonry_opt.answer.status import Status
from masonry_opt.effort import Stopwatch
from masonry_opt.errors import CaseError, OptionError
from masonry_opt.explain.diagnosis import (
    DeadLoadUndecided,
    falling_mechanism,
    locking_joints,
    moving_blocks,
)
from masonry_opt.methods.registry import IPOPT, METHODS, Method, Progress, Task
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.scene.case_file import load
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.registry import LANGUAGES, TOLERANCE, Solver, find_solver

#: A load factor this little below zero is zero.
_NEGATIVE = 1e-6


def solve(
    scene: Scene | str | Path,
    method: str = "nonassociative",
    *,
    model: str | None = None,
    solver: str | None = None,
    tolerance: float | None = None,
    progress: Progress = lambda _: None,
    **options: Any,
) -> Result:
    """Find the load factor at which a scene collapses.

    Parameters
    ----------
    scene:
        A scene, or the path of a case file.
    method:
        "static" or "kinematic" (associative: one linear program), "nonassociative" (Coulomb: the
        loop), "mpec" (the least load factor near the loop's, by IPOPT), "refined" (an exact state of
        Coulomb friction, by linear programs from the loop's or the MPEC's), or "global" (what can be
        proven of the least one, on small scenes).
    model:
        Modelling language: "cvxpy" (the default where a method is declared in it) or "pyomo".
    solver:
        "clarabel" (CVXPY's default), "highs" (simplex; Pyomo's default), "highs-ipm" (Pyomo's default
        for the loop), or any solver that CVXPY finds.
    tolerance:
        Feasibility and gap tolerance asked of a solver of linear programs (default 1e-9).
    progress:
        Called with every step: :class:`~.finding.Iteration` of the loop, :class:`~.mpec.Relaxation`,
        :class:`~.refined.Refinement`.
    **options:
        The method's own: :class:`~.loop_options.LoopOptions`, :class:`~.mpec.MpecOptions`,
        :class:`~.refined.RefinedOptions`, :class:`~.global_bounds.GlobalOptions`.

    Returns
    -------
    Result
        Whose ``status`` says whether there is a load factor.

    Raises
    ------
    CaseError
        If the case file or scene is wrong, or nothing carries a live load.
    OptionError
        If a method, model, solver or option is unknown or not available, or the method does not know
        dilatancy that falls with stress.
    """
    chosen, own_options = _choose(method, options)
    asked = _solver(method, chosen, model, solver, tolerance)
    watch = Stopwatch()
    with watch.measure("scene"):
        scene = scene if isinstance(scene, Scene) else load(scene)
        assembly = assemble(scene)
    problem = assembly.problem
    if not problem.live_norm:
        raise CaseError(
            f"{scene.origin}: no block carries a live load: give one 'live = [fx, fy]' "
            "(a [wall]: 'live', as a multiple of its weight)"
        )
    if chosen.fixed_dilatancy and problem.dilatancy_depends_on_stress:
        raise OptionError(
            f"method '{method}' does not know dilatancy that falls with stress: use 'nonassociative', or "
            "leave 'dilatancy_stress' out"
        )
    finding = _unless_it_stands(assembly, watch)
    if finding is None:
        finding = chosen.run(Task(problem, asked, watch, own_options, progress))
        if failing := failing_residuals(problem, finding, chosen.gate):
            finding = refused(finding, failing)
        if finding.load_factor is not None and finding.load_factor < -_NEGATIVE:
            finding = _held_by_wedging(assembly, finding)
        _name_locking_joints(assembly, finding)
    return make_result(
        assembly,
        finding,
        case=scene.origin if scene.origin != "scene" else scene.title or "scene",
        method=method,
        model=asked.language,
        solver=asked.name,
        seconds=watch.seconds,
    )


def _choose(method: str, options: dict[str, Any]) -> tuple[Method, Any]:
    if method not in METHODS:
        raise OptionError(f"method '{method}' is unknown; choose from: {', '.join(METHODS)}")
    chosen = METHODS[method]
    known = list(chosen.options.model_fields) if chosen.options else []
    for name in options:
        if name not in known:
            raise OptionError(
                f"method '{method}' has no option '{name}'; it has: {', '.join(known) or 'none'}"
            )
    try:
        return chosen, chosen.options(**options) if chosen.options else None
    except ValidationError as error:
        wrong = "; ".join(
            ": ".join([*(f"option '{name}'" for name in item["loc"][:1]), item["msg"]])
            for item in error.errors()
        )
        raise OptionError(f"method '{method}': {wrong}") from None


def _solver(
    method: str, chosen: Method, model: str | None, name: str | None, tolerance: float | None
) -> Solver:
    model = model or next(iter(chosen.solvers))
    if model in LANGUAGES and model not in chosen.solvers:
        raise OptionError(f"method '{method}' is declared in {', '.join(chosen.solvers)} only")
    allowed = chosen.solvers.get(model, ())
    name = name.lower() if name else (allowed[0] if allowed else None)
    if allowed and name not in allowed:
        raise OptionError(
            f"method '{method}' with model '{model}' takes solver: {', '.join(allowed)} (found '{name}')"
        )
    if tolerance is not None and chosen.fixed_tolerance:
        raise OptionError(f"method '{method}' has tolerances of its own: leave 'tolerance' out")
    if name in IPOPT:
        IPOPT[name].require()
        return Solver(name, "pyomo", name, {})
    return find_solver(model, name, TOLERANCE if tolerance is None else tolerance)


def _unless_it_stands(assembly: Assembly, watch: Stopwatch) -> Finding | None:
    """Why there is no load factor of a scene that does not stand under its dead load."""
    with watch.measure("dead_load"):
        try:
            falling = falling_mechanism(assembly.problem)
        except DeadLoadUndecided as word:
            return Finding(
                Status.SOLVER_FAILED,
                f"whether the scene stands under its dead load could not be decided ('{word}'): check "
                "for weights or lengths of very different size",
            )
    if falling is None:
        return None
    return Finding(Status.UNSTABLE, _falls(assembly, falling), d=falling)


def _held_by_wedging(assembly: Assembly, finding: Finding) -> Finding:
    """A load factor below zero of a scene whose dead load has a state of equilibrium."""
    message = (
        f"the load factor found is {finding.load_factor:.4g}, below zero: the dead load is carried by "
        "wedging alone, which the joints' flow rule does not sustain"
    )
    if finding.d is not None:
        message += f"; support what moves, {_blocks(assembly, moving_blocks(finding.d))}"
    return dataclasses.replace(finding, status=Status.UNSTABLE, message=message, load_factor=None)


def _name_locking_joints(assembly: Assembly, finding: Finding) -> None:
    """Add to the message of an unlimited load factor the joints that make it so."""
    joints = locking_joints(assembly.problem, finding.status, finding.q)
    if len(joints) == 0:
        return
    what = {
        Status.LOCKED: "the joints that slide there and have no room to open",
        Status.UNLIMITED: "the joints that carry it",
        Status.JAMMED: "the joints whose normal forces grow most",
    }[finding.status]
    name, found = [block.name for block in assembly.scene.blocks], assembly.joints
    pairs = [f"{name[found.first[joint]]!r}–{name[found.second[joint]]!r}" for joint in joints]
    finding.message += f"; {what}: {_some(pairs)}"


def _falls(assembly: Assembly, velocities: np.ndarray) -> str:
    blocks = _blocks(assembly, moving_blocks(velocities))
    return f"the dead load alone moves {blocks}: support what falls, or raise the friction of its joints"


def _blocks(assembly: Assembly, indices: np.ndarray) -> str:
    names = [repr(assembly.scene.blocks[assembly.movable[index]].name) for index in indices]
    return f"{'block' if len(names) == 1 else 'blocks'} {_some(names)}"


def _some(names: list[str]) -> str:
    """The first five, and how many more."""
    return ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")

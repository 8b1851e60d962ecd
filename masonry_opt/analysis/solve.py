"""``solve``: a scene, a method and a solver to a result."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from masonry_opt.analysis.associative import associative
from masonry_opt.analysis.diagnosis import DeadLoadUndecided, falling_mechanism, moving_blocks
from masonry_opt.analysis.finding import Finding
from masonry_opt.analysis.global_bounds import GlobalOptions, global_bounds
from masonry_opt.analysis.mpec import MpecOptions, mpec
from masonry_opt.analysis.nonassociative import LoopOptions, nonassociative
from masonry_opt.analysis.refined import RefinedOptions, jittered, refined
from masonry_opt.analysis.result import Result, make_result
from masonry_opt.analysis.status import Status
from masonry_opt.errors import CaseError, OptionError
from masonry_opt.models.interface import State
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.problem.certificate import rates
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.blocks import Record
from masonry_opt.scene.case_file import load
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.ipopt import (
    CasadiIpopt,
    ExecutableIpopt,
    Ipopt,
    require_casadi,
    require_executable,
)
from masonry_opt.solvers.registry import LANGUAGES, TOLERANCE, Solver, find_solver
from masonry_opt.timing import Stopwatch

Progress = Callable[[Any], None]

#: A load factor this little below zero is zero.
_NEGATIVE = 1e-6


@dataclasses.dataclass(frozen=True)
class _Task:
    """What a method is given."""

    problem: Problem
    solver: Solver
    watch: Stopwatch
    options: Any
    progress: Progress


@dataclasses.dataclass(frozen=True)
class _Method:
    """How a method is run.

    Attributes
    ----------
    run: the analysis.
    options: class of its own options; None if it has none.
    solvers: by language, those it can use, its default first; empty for any solver of linear programs.
        The first language is the method's default.
    fixed_tolerance: whether the method sets its own tolerances.
    """

    run: Callable[[_Task], Finding]
    options: type[Record] | None = None
    solvers: dict[str, tuple[str, ...]] = dataclasses.field(
        default_factory=lambda: {"cvxpy": (), "pyomo": ()}
    )
    fixed_tolerance: bool = False


def _static(task: _Task) -> Finding:
    return associative(task.problem, "static", task.solver, task.watch)


def _kinematic(task: _Task) -> Finding:
    return associative(task.problem, "kinematic", task.solver, task.watch)


def _nonassociative(task: _Task) -> Finding:
    return nonassociative(task.problem, task.solver, task.watch, task.options, task.progress)


def _loop(task: _Task, problem: Problem) -> Finding:
    """The loop with its defaults, as the start of another method."""
    solver = find_solver("cvxpy", None)
    return nonassociative(problem, solver, task.watch, LoopOptions(), task.progress)


def _mpec(task: _Task) -> Finding:
    options: MpecOptions = task.options
    before = Finding(Status.CONVERGED)
    if isinstance(options.start, Result):
        before = _of_same_scene(options.start, task.problem)
    elif options.start == "loop":
        before = _loop(task, task.problem)
        if before.q is None:
            before.message = f"the loop to start from failed: {before.message}"
            return before
    finding = mpec(
        task.problem,
        lambda model: _IPOPT[task.solver.name](model.program),
        _state(task.problem, before),
        options,
        task.watch,
        task.progress,
    )
    finding.flow_rule_matters = before.flow_rule_matters
    if not isinstance(options.start, Result):
        finding.lp_solves += before.lp_solves
        finding.iterations += before.iterations
    return finding


def _refined(task: _Task) -> Finding:
    options: RefinedOptions = task.options
    if options.start == "mpec":
        require_casadi()
    rng = np.random.default_rng(options.seed)

    def start(number: int) -> Finding:
        if number:
            return _loop(task, jittered(task.problem, options.spread, rng))
        if isinstance(options.start, Result):
            return _of_same_scene(options.start, task.problem)
        if options.start == "loop":
            return _loop(task, task.problem)
        return _mpec(
            dataclasses.replace(task, solver=Solver("casadi", "pyomo", "casadi", {}), options=MpecOptions())
        )

    return refined(task.problem, start, options, task.watch, task.progress)


def _global(task: _Task) -> Finding:
    upper = associative(task.problem, "static", find_solver("cvxpy", None), task.watch)
    if upper.load_factor is None:
        return upper
    start = _refined(dataclasses.replace(task, options=RefinedOptions(kicks=0)))
    found = global_bounds(task.problem, start, upper.load_factor, task.options, task.watch)
    found.lp_solves += upper.lp_solves
    found.flow_rule_matters = start.flow_rule_matters
    return found


def _of_same_scene(result: Result, problem: Problem) -> Finding:
    """A finding handed in, its solves not counted again."""
    finding = result.finding
    if finding.q is None or finding.d is None:
        raise OptionError("option 'start': the result has no forces to start from")
    if (finding.q.size, finding.d.size) != (3 * problem.joints, 3 * problem.blocks):
        raise OptionError("option 'start': the result is of another scene")
    return dataclasses.replace(finding, history=[], iterations=0, lp_solves=0, nlp_solves=0)


def _state(problem: Problem, finding: Finding) -> State | None:
    if finding.q is None or finding.d is None:
        return None
    p = rates(problem, finding.d, problem.dilatancy)
    return State(finding.load_factor or 0.0, finding.q, finding.d, p)


_IPOPT: dict[str, Callable[[Any], Ipopt]] = {"casadi": CasadiIpopt, "ipopt": ExecutableIpopt}

METHODS: dict[str, _Method] = {
    "static": _Method(_static),
    "kinematic": _Method(_kinematic),
    # A vertex has joints without normal force, which the loop then locks: prefer interior points.
    "nonassociative": _Method(_nonassociative, LoopOptions, {"cvxpy": (), "pyomo": ("highs-ipm", "highs")}),
    "mpec": _Method(_mpec, MpecOptions, {"pyomo": tuple(_IPOPT)}, fixed_tolerance=True),
    "refined": _Method(_refined, RefinedOptions, {"pyomo": ("highs",)}, fixed_tolerance=True),
    "global": _Method(_global, GlobalOptions, {"pyomo": ("highs",)}, fixed_tolerance=True),
}


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
        The method's own: :class:`~.nonassociative.LoopOptions`, :class:`~.mpec.MpecOptions`,
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
        If a method, model, solver or option is unknown or not available.
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
    finding = _unless_it_stands(assembly, watch)
    if finding is None:
        finding = chosen.run(_Task(problem, asked, watch, own_options, progress))
        if finding.load_factor is not None and finding.load_factor < -_NEGATIVE:
            finding = _held_by_wedging(finding)
    return make_result(
        assembly,
        finding,
        case=scene.origin if scene.origin != "scene" else scene.title or "scene",
        method=method,
        model=asked.language,
        solver=asked.name,
        seconds=watch.seconds,
    )


def _choose(method: str, options: dict[str, Any]) -> tuple[_Method, Any]:
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
    method: str, chosen: _Method, model: str | None, name: str | None, tolerance: float | None
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
    if name in _IPOPT:
        require = {"casadi": require_casadi, "ipopt": require_executable}
        require[name]()
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


def _held_by_wedging(finding: Finding) -> Finding:
    """A load factor below zero of a scene whose dead load has a state of equilibrium."""
    message = (
        f"the load factor found is {finding.load_factor:.4g}, below zero: the dead load is carried by "
        "wedging alone, which the joints' flow rule does not sustain"
    )
    return dataclasses.replace(finding, status=Status.UNSTABLE, message=message, load_factor=None)


def _falls(assembly: Assembly, velocities: Any) -> str:
    moving = moving_blocks(velocities)
    names = [repr(assembly.scene.blocks[assembly.movable[index]].name) for index in moving[:5]]
    more = f" and {len(moving) - 5} more" if len(moving) > 5 else ""
    blocks = "block" if len(moving) == 1 else "blocks"
    return (
        f"the dead load alone moves {blocks} {', '.join(names)}{more}: support what falls, or raise "
        "the friction of its joints"
    )

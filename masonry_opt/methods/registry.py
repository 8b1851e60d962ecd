"""The methods: what each does with a problem, its options, and the solvers it can use."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from masonry_opt.answer.acceptance import COULOMB, EXACT, Gate
from masonry_opt.answer.certificate import rates
from masonry_opt.answer.result import Result
from masonry_opt.answer.solution import Finding
from masonry_opt.answer.status import Status
from masonry_opt.effort import Stopwatch
from masonry_opt.errors import OptionError
from masonry_opt.methods.associative import associative
from masonry_opt.methods.global_search import GlobalOptions, global_bounds
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.loop.runs import nonassociative
from masonry_opt.methods.mpec import MpecOptions, mpec
from masonry_opt.methods.refined.search import RefinedOptions, jittered, refined
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State
from masonry_opt.scene.blocks import Record
from masonry_opt.solvers.ipopt import CasadiIpopt, ExecutableIpopt
from masonry_opt.solvers.registry import Solver, find_solver

Progress = Callable[[Any], None]


@dataclasses.dataclass(frozen=True)
class Task:
    """What a method is given."""

    problem: Problem
    solver: Solver
    watch: Stopwatch
    options: Any
    progress: Progress


@dataclasses.dataclass(frozen=True)
class Method:
    """How a method is run.

    Attributes
    ----------
    run: the analysis.
    options: class of its own options; None if it has none.
    solvers: by language, those it can use, its default first; empty for any solver of linear programs.
        The first language is the method's default.
    fixed_tolerance: whether the method sets its own tolerances.
    gate: residuals beyond which its load factor is not given out.
    fixed_dilatancy: whether it takes the joints' dilatancy for a constant, whatever their stress.
    """

    run: Callable[[Task], Finding]
    options: type[Record] | None = None
    solvers: dict[str, tuple[str, ...]] = dataclasses.field(
        default_factory=lambda: {"cvxpy": (), "pyomo": ()}
    )
    fixed_tolerance: bool = False
    gate: Gate = COULOMB
    fixed_dilatancy: bool = False


def _static(task: Task) -> Finding:
    return associative(task.problem, "static", task.solver, task.watch)


def _kinematic(task: Task) -> Finding:
    return associative(task.problem, "kinematic", task.solver, task.watch)


def _nonassociative(task: Task) -> Finding:
    return nonassociative(task.problem, task.solver, task.watch, task.options, task.progress)


def _loop(task: Task, problem: Problem) -> Finding:
    """The loop as the start of another method: accurate at any size, for the refinement needs to know which
    faces move."""
    solver, options = find_solver("cvxpy", None), LoopOptions(pace="paper")
    return nonassociative(problem, solver, task.watch, options, task.progress)


def _mpec(task: Task) -> Finding:
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
        IPOPT[task.solver.name],
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


def _refined(task: Task) -> Finding:
    options: RefinedOptions = task.options
    if options.start == "mpec":
        CasadiIpopt.require()
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


def _global(task: Task) -> Finding:
    upper = associative(task.problem, "static", find_solver("cvxpy", None), task.watch)
    if upper.load_factor is None and upper.status is not Status.LOCKED:
        return upper
    start = _refined(dataclasses.replace(task, options=RefinedOptions(kicks=0)))
    highest = upper.load_factor
    if highest is None:
        # Where dilatancy locks the associative flow, an exact state bounds λ instead.
        if start.stationary is None or start.load_factor is None:
            return upper
        highest = start.load_factor
    found = global_bounds(task.problem, start, highest, task.options, task.watch)
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


#: IPOPT by the name a user gives.
IPOPT: dict[str, type[CasadiIpopt] | type[ExecutableIpopt]] = {
    "casadi": CasadiIpopt,
    "ipopt": ExecutableIpopt,
}

#: Every method by name. Adding one is one entry.
METHODS: dict[str, Method] = {
    "static": Method(_static, gate=EXACT),
    "kinematic": Method(_kinematic, gate=EXACT),
    # A vertex has joints without normal force, which the loop then locks: prefer interior points.
    "nonassociative": Method(_nonassociative, LoopOptions, {"cvxpy": (), "pyomo": ("highs-ipm", "highs")}),
    "mpec": Method(
        _mpec, MpecOptions, {"pyomo": tuple(IPOPT)}, fixed_tolerance=True, gate=EXACT, fixed_dilatancy=True
    ),
    "refined": Method(
        _refined, RefinedOptions, {"pyomo": ("highs",)}, fixed_tolerance=True, fixed_dilatancy=True
    ),
    "global": Method(
        _global, GlobalOptions, {"pyomo": ("highs",)}, fixed_tolerance=True, fixed_dilatancy=True
    ),
}

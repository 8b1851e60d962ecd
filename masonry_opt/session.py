"""The way from scenes to results: assemble, check that the scene stands, run the method, accept.

Modules that declare or solve programs are imported where they are used: modelling languages take seconds.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from masonry_opt.answer.acceptance import SMALLEST, Kind
from masonry_opt.answer.answer import Found
from masonry_opt.answer.motion import moving_names
from masonry_opt.answer.reasons import Code, reason, size_of
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.effort import Effort
from masonry_opt.errors import CaseError, OptionError
from masonry_opt.methods.mcp.passes import PASSES_UP_TO, Passes
from masonry_opt.methods.registry import METHODS
from masonry_opt.methods.task import Method, Progress, Task
from masonry_opt.problem.assembly import Assembly, assemble, on_matrices_of
from masonry_opt.problem.kept import Kept
from masonry_opt.problem.problem import Problem
from masonry_opt.result import Result, make_result
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.registry import MATRICES, Solver, find_solver

#: Joints up to which the associative load factor is computed where a method leaves none: beyond, it takes
#: from some seconds to minutes.
_BESIDE_UP_TO = 8000

#: Methods whose answer is associative itself; the method whose answer is the load to expect.
ASSOCIATIVE, _EXPECTED = ("static", "kinematic"), "compliant"


@dataclass
class Session:
    """A method with its solver and options, to which scenes are given one after the other.

    Attributes
    ----------
    method, solver, options: as chosen; see :func:`~masonry_opt.analysis.prepare`.
    dead_load: the solver that decides whether a scene stands.
    expected: whether Coulomb methods tell the load to expect too.
    kept: geometry and compiled programs, if it keeps them for scenes that differ in joint properties alone;
        of those that differ in loads geometry, joints and matrices.
        No answer depends on earlier scenes; but their forces may show that a scene stands.
    """

    method: Method
    solver: Solver
    options: Any
    dead_load: Solver
    expected: bool = True
    kept: Kept = field(default_factory=Kept)
    _last: Assembly | None = None

    def solve(
        self, scene: Scene, progress: Progress = lambda _: None, effort: Effort | None = None
    ) -> Result:
        """The result of a scene; raises what :func:`~masonry_opt.analysis.solve` raises of scenes."""
        effort = effort or Effort()
        return self._result(*self.answer(scene, progress, effort), effort)

    def falls(self, assembly: Assembly, effort: Effort) -> Result | None:
        """The result of a scene that does not stand under its dead load; None if it stands."""
        solution = self._unless_it_stands(assembly, effort)
        return None if solution is None else self._result(assembly, solution, effort)

    def push(self, assembly: Assembly, progress: Progress, effort: Effort) -> Result:
        """The result of a scene that is known to stand; raises as ``solve``."""
        refuse_unsuited(self.method, assembly)
        return self._result(assembly, self.pushed(assembly, progress, effort), effort)

    def _result(self, assembly: Assembly, solution: Solution, effort: Effort) -> Result:
        method, solver = self.method.name, solution.solver
        if solver is None or solver.language == self.solver.language:
            solver = self.solver
        return make_result(
            assembly, solution, effort, method=method, model=solver.language, solver=solver.name
        )

    def answer(self, scene: Scene, progress: Progress, effort: Effort) -> tuple[Assembly, Solution]:
        """The same, as matrices and numbers without names and units."""
        effort.begins("finding joints")
        with effort.measure("scene"):
            assembly = self._assembled(scene)
        refuse_unsuited(self.method, assembly)
        solution = self._unless_it_stands(assembly, effort)
        return assembly, solution or self.pushed(assembly, progress, effort)

    def pushed(self, assembly: Assembly, progress: Progress, effort: Effort) -> Solution:
        """The solution of a scene that stands."""
        expected = self._to_expect(assembly, effort)
        effort.begins(f"method '{self.method.name}'")
        task = Task(assembly.problem, self.solver, self.options, effort, progress, self.kept, expected)
        solution = _found(self.method, task)
        solution.expected = expected
        solution.accept()
        _judge(assembly, task, solution)
        if solution.status is Status.SOLVER_FAILED:
            # Nothing bears out what forces and velocities say.
            solution.found = Found(curved=solution.found.curved)
        return solution

    def _assembled(self, scene: Scene) -> Assembly:
        assembly = on_matrices_of(self._last, scene) if self._last is not None else None
        if assembly is None:
            assembly = assemble(scene)
        if self.kept.keeps:
            self._last = assembly
        return assembly

    def _unless_it_stands(self, assembly: Assembly, effort: Effort) -> Solution | None:
        """The solution of a scene that does not stand under its dead load; None if it stands."""
        from masonry_opt.standing.diagnosis import DeadLoadUndecided, falling_mechanism

        problem, own, solver = assembly.problem, Effort(), self.dead_load
        effort.begins("does it stand under its dead load?")
        solution = Solution(Status.UNSTABLE, Kind.ASSOCIATIVE)
        with effort.measure("dead_load"):
            try:
                falling = falling_mechanism(problem, solver, own, self.kept)
            except DeadLoadUndecided as stopped:
                solution.end(Status.SOLVER_FAILED, Code.DEAD_LOAD_UNDECIDED, **stopped.values)
                return solution
            finally:
                # The result names the solver; its programs and time count as those of the check.
                effort.credit(own)
        if falling is None:
            return None
        from masonry_opt.standing.diagnosis import as_it_falls
        from masonry_opt.standing.holding import what_would_hold

        effort.begins("what falls, and what would hold it")
        with effort.measure("dead_load"):
            falling = as_it_falls(assembly, falling, own)
        solution.found = Found(d=falling, curved=problem.layout.round)
        solution.add(Code.FALLS, blocks=moving_names(assembly, falling))
        with effort.measure("dead_load"):
            solution.reasons += what_would_hold(assembly, falling, solver, own)
        return solution

    def _to_expect(self, assembly: Assembly, effort: Effort) -> Solution | None:
        """What method "compliant" finds, or why it is not asked; None where nobody wants to know. Its steps
        and time stand apart from those of the method."""
        if not self.expected or self.method.name in (*ASSOCIATIVE, _EXPECTED):
            return None
        method, problem = METHODS[_EXPECTED], assembly.problem
        if method.constant_dilatancy and problem.dilatancy_depends_on_stress:
            return Solution(Status.SOLVER_FAILED, Kind.COMPLIANT, [reason(Code.DILATANCY_FALLS)])
        if problem.joints > PASSES_UP_TO:
            why = reason(Code.NOT_EXPECTED, **size_of(problem))
            return Solution(Status.SOLVER_FAILED, Kind.COMPLIANT, [why])
        effort.begins("load to expect")
        solver = find_solver(MATRICES, None)
        effort.uses(solver.name, "load to expect")
        with effort.measure("expected"):
            solution = _found(method, Task(problem, solver, effort=Effort(effort.begins), kept=self.kept))
        _withdraw_unless_it_stands(assembly, solution)
        return solution


def refuse_unsuited(method: Method, assembly: Assembly) -> None:
    """Raise CaseError if nothing carries a live load, OptionError if no load case is named of a scene that
    has any, or the method does not know such joints, or solids."""
    problem, scene = assembly.problem, assembly.scene
    scene.refuse_without_case()
    if not problem.live_norm:
        case = scene.load_case
        named = f"load case '{case.name}': " if case is not None else ""
        if scene.factor_of_axles and (scene.axles or case is not None):
            raise CaseError(
                f"{scene.origin}: {named}its axles move, and nothing else is a live load: use crossing "
                "(in Python mo.crossing), which finds their worst position"
            )
        if case is not None:
            raise CaseError(
                f"{scene.origin}: {named}nothing that it makes live ({case}) loads a block: give another "
                "group of loads, or loads of these"
            )
        ways = (
            "'live = [fx, fy]', there or in a [[load]] (a [wall]: 'live_per_weight', a multiple of its "
            'weight), an [[edge_load]] of kind "live", an [earthquake], or \'tilt = "right"\' to tilt the '
            "ground"
        )
        if scene.dimension == 3:
            ways = "'live = [fx, fy, fz]', there or in a [[load]], 'live_per_weight', or 'tilt = [x, y, z]'"
        raise CaseError(f"{scene.origin}: no block carries a live load: give one {ways}")
    if method.constant_dilatancy and problem.dilatancy_depends_on_stress:
        raise OptionError(
            f"method '{method.name}' does not know dilatancy that falls with stress: use 'nonassociative', "
            "or leave 'dilatancy_stress' out"
        )
    if assembly.scene.dimension == 3 and not method.space:
        raise OptionError(
            f"{assembly.scene.origin}: its blocks are solids, which method '{method.name}' does not know: "
            "use another"
        )
    if problem.matrices.limited and not method.limited:
        roles = ", ".join(dict.fromkeys(f"'{force.role}'" for force in assembly.limited))
        raise OptionError(
            f"method '{method.name}' does not know forces of {roles}: use another, or leave these out"
        )
    if len(problem.crushing) and not method.crushing:
        raise OptionError(
            f"method '{method.name}' does not know joints of limited strength: use another, or leave "
            "'strength' out"
        )


def _withdraw_unless_it_stands(assembly: Assembly, solution: Solution) -> None:
    """Withdraw a load factor below zero, or of a scene that does not carry its dead load from rest."""
    found, statics = solution.load_factor, solution.kind is Kind.ASSOCIATIVE
    rests = found is not None and not statics and _rests(assembly.problem, solution, found)
    if found is not None and (found < -ZERO or not (statics or rests)):
        from masonry_opt.standing.no_load_factor import withdraw

        withdraw(assembly, solution, rests)


def _found(method: Method, task: Task) -> Solution:
    """What a method finds; a Coulomb method that finds no load factor is asked where the live load does no
    work, and at once where that was the load to expect."""
    before, expected = None, task.expected
    if expected is None or not expected.no_work:
        before = method.run(task)
        decided = (before.answer and not before.failing()) or before.proven_none
        if decided or before.kind is Kind.ASSOCIATIVE or task.problem.joints > _BESIDE_UP_TO:
            return before
        from masonry_opt.methods.associative import set_beside

        set_beside(task, before)
        if before.associative is None:
            return before
    from masonry_opt.methods.no_work import without_work

    return without_work(task, method.run, before) or before or method.run(task)


def _rests(problem: Problem, solution: Solution, load_factor: float) -> bool:
    """Whether a scene carries its dead load from rest: where forces there are known, or statics fix them, or
    as the load to expect tells; else contacts that give are asked, where the load factor is next to nothing
    or below, or a state like that was met."""
    if problem.settled is not None or problem.statics_fix_forces:
        return True
    expected = solution.expected
    if expected is not None and expected.status in (Status.CONVERGED, Status.UNSTABLE):
        return expected.status.usable
    return min(load_factor, solution.below_zero) > SMALLEST or Passes(problem).carry_dead_load()


def _judge(assembly: Assembly, task: Task, solution: Solution) -> None:
    """Set the associative load factor beside a Coulomb answer; without a load factor ≥ 0, explain why."""
    if solution.kind is not Kind.ASSOCIATIVE:
        # Which no Coulomb answer exceeds. (Where none is proven to exist, statics carry any multiple.)
        from masonry_opt.methods.associative import set_beside

        if not solution.proven_none and task.problem.joints <= _BESIDE_UP_TO:
            set_beside(task, solution)
    if solution.expected is not None:
        solution.expected.associative = solution.associative_value
    _withdraw_unless_it_stands(assembly, solution)
    if solution.load_factor is not None:
        return
    from masonry_opt.standing.no_load_factor import explain

    explain(assembly, solution, task.solver, task.effort, solution.kind is Kind.ASSOCIATIVE)
    expected = solution.expected
    if expected is not None and expected.load_factor is not None and solution.proven_none:
        # What contacts give before they lock is no collapse.
        expected.found, expected.status = Found(), solution.status
        expected.reasons = list(solution.reasons)

"""``solve``: assemble a scene, check that it stands, run a method, accept its answer.

Modules that declare or solve programs are imported where they are used: modelling languages take seconds.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.answer.acceptance import SMALLEST, Kind
from masonry_opt.answer.answer import Found
from masonry_opt.answer.motion import moving_names
from masonry_opt.answer.only_state import is_only_load_factor
from masonry_opt.answer.reasons import Code, Status, reason, size_of
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import SAME, ZERO, same
from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import CaseError, OptionError
from masonry_opt.methods.exact.settings import SEARCH
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis, analysis_of
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.registry import DEFAULT, METHODS, HowToSolve
from masonry_opt.methods.task import Method, Progress, Task
from masonry_opt.problem.assembly import Assembly, assemble, on_matrices_of
from masonry_opt.problem.problem import Problem
from masonry_opt.result import Result, make_result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.driver import Kept
from masonry_opt.solvers.registry import MATRICES, find_solver
from masonry_opt.standing.dead_load import DEAD_LOAD, carries

#: Joints up to which the associative load factor is computed beside: beyond, it takes 15 seconds to minutes.
_BESIDE_UP_TO = 40_000

#: Joints up to which a live load is asked for that does no work, where a method finds no load factor; and
#: those up to which contacts at rest are asked whether a scene stands: beyond, they take longer to fall.
_NO_WORK_UP_TO, _RESTS_UP_TO = 8000, 500

#: Work of the live load over the product of the sizes of load and motion, up to which it does no work. If
#: larger, ranges of a load factor are compared with more states of other mechanisms.
NO_WORK = 1e-3

_INCREMENTAL = "incremental"  #: The method whose answer is the incremental load factor.

#: Ways to give a live load, by dimension.
_WAYS = {
    2: "'live = [fx, fy]', there or in a [[load]] (a [wall]: 'live_per_weight', a multiple of its weight), "
    'an [[edge_load]] of kind "live", an [earthquake], or \'tilt = "right"\' to tilt the ground',
    3: "'live = [fx, fy, fz]', there or in a [[load]], 'live_per_weight', or 'tilt = [x, y, z]'",
}


@dataclass
class Session:
    """A way to solve, to which scenes are given one after the other."""

    how: HowToSolve  #: with which method, solver and options
    #: Compiled programs for scenes that differ in joint properties alone, matrices for those that differ in
    #: loads, if it keeps any. No answer depends on earlier scenes; their forces may show that one stands.
    kept: Kept = field(default_factory=Kept)
    _last: Assembly | None = None

    @property
    def method(self) -> Method:
        """The method."""
        return self.how.chosen

    def without_incremental(self) -> "Session":
        """Return a session that does not compute the incremental load factor."""
        return replace(self, how=replace(self.how, incremental=False))

    def solve(
        self, scene: Scene, progress: Progress = lambda _: None, effort: Effort | None = None
    ) -> Result:
        """The result of a scene; raises what :func:`~masonry_opt.analysis.solve` raises of scenes."""
        effort = effort or Effort()
        return self.result(*self.answer(scene, progress, effort), effort)

    def falls(self, assembly: Assembly, effort: Effort) -> Result | None:
        """The result of a scene that does not stand under its dead load; None if it stands."""
        solution = self._unless_it_stands(assembly, effort)
        return None if solution is None else self.result(assembly, solution, effort)

    def push(self, assembly: Assembly, progress: Progress, effort: Effort) -> Result:
        """The result of a scene that is known to stand; raises as ``solve``."""
        refuse_unsuited(self.method, assembly)
        return self.result(assembly, self.pushed(assembly, progress, effort), effort)

    def result(self, assembly: Assembly, solution: Solution, effort: Effort) -> Result:
        """A solution as a result."""
        own, other = self.how.engine, solution.solver
        solver = own if other is None or other.language == own.language else other
        return make_result(assembly, solution, effort, self.method.name, solver)

    def answer(self, scene: Scene, progress: Progress, effort: Effort) -> tuple[Assembly, Solution]:
        """The same, as matrices and numbers without names and units."""
        effort.begins("finding joints")
        with effort.measure("scene"):
            kept = None if self._last is None else on_matrices_of(self._last, scene)
            assembly = kept or assemble(scene)
        if self.kept.keeps:
            self._last = assembly
        refuse_unsuited(self.method, assembly)
        solution = self._unless_it_stands(assembly, effort)
        return assembly, solution or self.pushed(assembly, progress, effort)

    def pushed(self, assembly: Assembly, progress: Progress, effort: Effort) -> Solution:
        """The solution of a scene that stands."""
        problem, incremental = assembly.problem, self._to_expect(assembly, effort)
        effort.begins(f"method '{self.method.name}'")
        task = Task(problem, self.how.engine, self.how.own_options, effort, progress, self.kept, incremental)
        solution = replace(_found(self.method, task), incremental=incremental).accepted()
        solution = _judged(assembly, task, solution)
        if solution.status not in (Status.SOLVER_FAILED, Status.BELOW_ZERO):
            return solution
        # The forces and velocities are those of no answer.
        return replace(solution, found=Found(forms=solution.found.forms))

    def _unless_it_stands(self, assembly: Assembly, effort: Effort) -> Solution | None:
        """The solution of a scene that does not stand under its dead load; None if it stands."""
        problem, solver = assembly.problem, self.how.of_dead_load
        effort.begins("does it stand under its dead load?")
        solution = Solution(Status.UNSTABLE, Kind.ASSOCIATIVE)
        # The result names the solver; its programs and time count as those of the check.
        own = effort.beside()
        with effort.measure("dead_load"):
            if self._comes_to_rest(problem, own):
                return None
        # Imports a modelling language, which takes seconds.
        from masonry_opt.standing import diagnosis

        with effort.measure("dead_load"):
            try:
                falling = diagnosis.falling_mechanism(problem, solver, own, self.kept)
            except diagnosis.DeadLoadUndecided as stopped:
                return solution.ended(Status.SOLVER_FAILED, Code.DEAD_LOAD_UNDECIDED, **stopped.values)
        if falling is None:
            return None
        effort.begins("what falls, and what would hold it")
        with effort.measure("dead_load"):
            falling = diagnosis.as_it_falls(assembly, falling, Effort())
            falls = reason(Code.FALLS, blocks=moving_names(assembly, falling))
            holds = diagnosis.what_would_hold(assembly, falling, solver, Effort())
        found = Found(d=falling, forms=problem.by_cone.forms)
        return replace(solution, found=found, reasons=(falls, *holds))

    @property
    def _expects(self) -> bool:
        """Return True if the incremental load factor is computed in addition to the method's own."""
        return self.how.incremental and not self.method.associative and self.method.name != _INCREMENTAL

    def _comes_to_rest(self, problem: Problem, effort: Effort) -> bool:
        """Return True if the forces with which elastic contacts come to rest carry the dead load.

        They are computed for small scenes whose load history is needed anyway. Of many scenes the forces that
        are kept of those before show it at once.
        """
        pushed = self._expects or self.method.name == _INCREMENTAL
        small = problem.joints <= _RESTS_UP_TO and not problem.dilatancy_depends_on_stress
        if self.kept.keeps or not (pushed and small):
            return False
        rest = analysis_of(Task(problem, effort=effort, kept=self.kept)).preload_forces
        if rest is None or not carries(problem, rest):
            return False
        if problem.settled is None and problem.dead.any():
            effort.uses(find_solver(MATRICES, None).name, DEAD_LOAD)
        return True

    def _to_expect(self, assembly: Assembly, effort: Effort) -> Solution | None:
        """What method "incremental" finds, or why it is not asked; None where nobody wants to know. Its steps
        and time stand apart from those of the method."""
        if not self._expects:
            return None
        method, problem = METHODS[_INCREMENTAL], assembly.problem
        none = Solution(Status.SOLVER_FAILED, Kind.INCREMENTAL)
        if "dilatancy" in method.refuses and problem.dilatancy_depends_on_stress:
            return none.telling(reason(Code.DILATANCY_FALLS))
        if problem.joints > IncrementalSettings().most_joints:
            return none.telling(reason(Code.NOT_COMPUTED, **size_of(problem)))
        solver = find_solver(MATRICES, None)
        effort.uses(solver.name, "incremental analysis")
        with effort.measure("incremental"):
            solution = _found(method, Task(problem, solver, effort=Effort(effort.begins), kept=self.kept))
        return _unless_it_falls(assembly, solution)


def refuse_without_live_load(assembly: Assembly) -> None:
    """Raise CaseError if nothing carries a live load."""
    if not assembly.problem.live_norm:
        raise CaseError(f"{assembly.scene.origin}: {_without_live_load(assembly.scene)}")


def refuse_unsuited(method: Method, assembly: Assembly) -> None:
    """Raise CaseError if nothing carries a live load, OptionError if no load case is named of a scene that
    has any, or the method does not know such joints, or solids."""
    problem, scene = assembly.problem, assembly.scene
    scene.refuse_without_case()
    refuse_without_live_load(assembly)
    named = f"method '{method.name}'"
    if scene.dimension == 3 and "space" in method.refuses:
        raise OptionError(f"{scene.origin}: its blocks are solids, which {named} does not know: use another")
    roles = ", ".join(dict.fromkeys(f"'{force.role}'" for force in assembly.limited))
    dilatancy = "dilatancy that falls with stress: use 'nonassociative', or leave 'dilatancy_stress' out"
    strength = "joints of limited strength: use another, or leave 'strength' out"
    for what, there, said in (
        ("dilatancy", problem.dilatancy_depends_on_stress, dilatancy),
        ("forces", problem.matrices.limited, f"forces of {roles}: use another, or leave these out"),
        ("strength", len(problem.crushing), strength),
    ):
        if there and what in method.refuses:
            raise OptionError(f"{named} does not know {said}")


def _without_live_load(scene: Scene) -> str:
    """What is wrong, and what to do, where no block carries a live load."""
    case = scene.load_case
    named = f"load case '{case.name}': " if case is not None else ""
    if scene.factor_of_axles and (scene.axles or case is not None):
        moves = "its axles move, and nothing else is a live load: use crossing (in Python mo.crossing), which"
        return f"{named}{moves} finds their worst position"
    if case is not None:
        found = f"nothing that it makes live ({case}) loads a block"
        return f"{named}{found}: give another group of loads, or loads of these"
    return f"no block carries a live load: give one {_WAYS[scene.dimension]}"


def _unless_it_falls(assembly: Assembly, solution: Solution) -> Solution:
    """A solution without its load factor if that is below zero, or the dead load is not carried from rest."""
    found, statics = solution.load_factor, solution.kind is Kind.ASSOCIATIVE
    rests = found is not None and not statics and _rests(assembly.problem, solution, found)
    if solution.status is not Status.UNSTABLE and (found is None or (found >= -ZERO and (statics or rests))):
        return solution
    from masonry_opt.standing.existence import withdrawn

    return withdrawn(assembly, solution, rests)


def _found(method: Method, task: Task) -> Solution:
    """Return the solution of a method.

    If a Coulomb method finds no load factor, a collapse in which the live load does no work is looked for. It
    is looked for first if the incremental load factor is of such a collapse. The range of an incremental load
    factor is replaced by the exact load factor of such a collapse that lies in the range.
    """
    before, incremental = None, task.incremental
    if incremental is None or not incremental.has(Code.NO_WORK):
        before = method.run(task)
        # A method that seeks exact states answers by the load history only if it finds none.
        has_no_state = method.seeks_lowest and before.kind is Kind.INCREMENTAL
        if not has_no_state and _ends_without_work(task.problem, before):
            return _exact_without_work(task, method, before)
        falls = before.status is Status.UNSTABLE
        has_answer = before.answer is not None and not before.failing() and not has_no_state
        if has_answer or before.proven_none or falls or before.kind is Kind.ASSOCIATIVE or task.problem.joints > _NO_WORK_UP_TO:
            return before
        from masonry_opt.methods.associative import with_associative

        before = with_associative(task, before)
        if before.associative is None:
            return before
    from masonry_opt.methods.no_work import without_work

    return without_work(task, method.run, before) or before or method.run(task)


def _ends_without_work(problem: Problem, solution: Solution) -> bool:
    """Return True if a load history ends in a range, with a motion in which the live load does no work."""
    if not solution.has(Code.RANGE) or solution.followed_to_end or solution.d is None:
        return False
    sizes = np.linalg.norm(problem.live) * np.linalg.norm(solution.d)
    return bool(problem.live @ solution.d <= NO_WORK * sizes)


def _exact_without_work(task: Task, method: Method, before: Solution) -> Solution:
    """Return the exact collapse without work of the live load, or the solution before if there is none."""
    from masonry_opt.methods.no_work import without_work

    found = without_work(task, method.run, before)
    ends = before.values_of(Code.RANGE)
    if found is None or found.load_factor is None:
        return before
    is_within = ends["carried"] * (1 - SAME) <= found.load_factor <= ends["not_carried"] * (1 + SAME)
    return found if is_within else before


def _rests(problem: Problem, solution: Solution, load_factor: float) -> bool:
    """Return True if a scene carries its dead load from rest.

    The preload, if it is known, or statics that fix all forces show it; or else the incremental load factor.
    Elastic contacts are computed only if a load factor near zero was found.
    """
    if problem.settled is not None or problem.statics_fix_forces:
        return True
    incremental = solution.incremental
    if incremental is not None and incremental.status in (Status.CONVERGED, Status.UNSTABLE):
        return incremental.status.usable
    if min(load_factor, solution.below_zero) > SMALLEST:
        return True
    return IncrementalAnalysis(problem).preload_forces is not None


def _judged(assembly: Assembly, task: Task, solution: Solution) -> Solution:
    """A Coulomb answer with the associative load factor beside it; without a load factor ≥ 0, why."""
    by_statics, small = solution.kind is Kind.ASSOCIATIVE, task.problem.joints <= _BESIDE_UP_TO
    if small and not by_statics and not solution.proven_none:
        # Which no Coulomb answer exceeds. (Where none is proven to exist, statics carry any multiple.)
        from masonry_opt.methods.associative import with_associative

        solution = with_associative(task, solution)
    incremental = solution.incremental
    if incremental is not None:
        incremental = replace(incremental, associative=solution.associative_value)
    solution = _unless_it_falls(assembly, replace(solution, incremental=incremental))
    if solution.load_factor is not None:
        return _with_few_starts(task.problem, _with_only_state(task.problem, solution))
    from masonry_opt.standing.existence import explained

    solution = explained(assembly, solution, task.solver, task.effort, by_statics)
    if incremental is None or incremental.load_factor is None or not solution.proven_none:
        return solution
    # A load factor of elastic contacts that lock later is no collapse.
    incremental = replace(incremental, found=Found(), status=solution.status, reasons=solution.reasons)
    return replace(solution, incremental=replace(incremental, followed_to_end=False, peak=None))


def _with_only_state(problem: Problem, solution: Solution) -> Solution:
    """Return a solution that records if no other load factor above zero can be one of collapse."""
    load_factor = solution.load_factor
    if load_factor is None or solution.kind in (Kind.ASSOCIATIVE, Kind.INCREMENTAL):
        return solution
    return replace(solution, is_only_state=is_only_load_factor(problem, load_factor))


def _with_few_starts(problem: Problem, solution: Solution) -> Solution:
    """Return a solution with a reason if its three load factors agree after few starts.

    The agreement is little evidence where equilibrium does not fix the forces: other forces may lead to
    lower states. If all joints follow associative flow, all exact states have one load factor. The reason of
    a search states the number of its starts.
    """
    starts = solution.starts
    lowest, incremental, associative = solution.load_factor, solution.incremental, solution.associative
    if starts is None or starts >= SEARCH.few_starts or solution.has(Code.SEARCHED):
        return solution
    if lowest is None or associative is None or incremental is None or incremental.load_factor is None:
        return solution
    agree = same(lowest, incremental.load_factor) and same(lowest, associative)
    unique = problem.statics_fix_forces or np.array_equal(problem.dilatancy, problem.friction)
    if not agree or unique:
        return solution
    return solution.telling(reason(Code.FEW_STARTS, candidates=starts))


def solve(
    scene: Scene | str | Path,
    method: str = DEFAULT,
    *,
    model: str | None = None,
    solver: str | None = None,
    tolerance: float | None = None,
    incremental: bool = True,
    load_case: str | None = None,
    progress: Progress = lambda _: None,
    phases: Phases = lambda _: None,
    **options: Any,
) -> Result:
    """Find the load factor at which a scene collapses.

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    method: Name of the method. Methods for joints with Coulomb friction, which do not open as they slide:

        - "coulomb", the default: the lowest of several exact collapse states; the loop if dilatancy falls
          with stress.
        - "incremental": the load factor at which equilibrium is lost as the live load is raised from rest,
          with elastic contacts.
        - "nonassociative": the loop of linear programs by Gilbert, Casapulla and Ahmed (2006).
        - "mpec": a local minimum near the load factor of the loop, by IPOPT.
        - "global": the least load factor with a proven lower bound, on small scenes.

        Methods of classical limit analysis, in which joints open as they slide: "static" and "kinematic", one
        linear program each.
    model: Modelling language: "cvxpy" (the default of methods that are declared in it), "pyomo" or
        "matrices". Both languages declare "static", "kinematic" and "nonassociative". "coulomb" and
        "incremental" take "matrices".
    solver: For "static", "kinematic" and "nonassociative" one of "clarabel" (default with CVXPY), "highs"
        (simplex; default with Pyomo), "highs-ipm" (default of the loop with Pyomo), or another solver that
        CVXPY finds. The other methods have solvers of their own.
    tolerance: Feasibility and gap tolerance of the solver, for the same three methods (default 1e-9). With
        cones of friction in space the solver may miss the tolerance; the reasons of the result then say so.
    incremental: True if Coulomb methods compute the incremental load factor too (up to 3000 joints, in space
        contacts).
    load_case: Name of a load case of the scene; needed if the scene has load cases. :func:`solve_cases`
        solves all of them.
    progress: Function that is called with each step of the method:
        :class:`~.answer.load_history.LoadStep`, :class:`~.loop.run.Iteration` of the loop,
        :class:`~.mpec.RelaxationStep`, :class:`~.coulomb.search.LowerState` of the search,
        :class:`~.bracket.relaxation.BoundStep` of "global".
    phases: Function that is called with a few words as each phase begins, such as "finding joints".
    **options: Options of the method: fields of :class:`~.coulomb.method.CoulombOptions`,
        :class:`~.incremental.method.IncrementalOptions`, :class:`~.loop.options.LoopOptions`,
        :class:`~.mpec.MpecOptions`, :class:`~.bracket.bracket.GlobalOptions`.

    Returns
    -------
    Result
        Result of the analysis. Its ``status`` tells if there is a load factor.

    Raises
    ------
    CaseError
        If the case file or scene is wrong, or nothing carries a live load.
    OptionError
        If a method, model, solver, option or load case is unknown or not available, or the method does not
        know dilatancy that falls with stress, or no limited strength, or no solids.
    """
    for name, given in (("progress", progress), ("phases", phases)):
        if not callable(given):
            raise OptionError(f"{name} must be a function (found {given!r})")
    session = prepare(
        method, model=model, solver=solver, tolerance=tolerance, incremental=incremental, **options
    )
    effort = Effort(phases)
    effort.begins("reading blocks")
    with effort.measure("scene"):
        scene = as_scene(scene, load_case)
    return session.solve(scene, progress, effort)


def prepare(
    method: str = DEFAULT, *, keeps: bool = False, incremental: bool = True, **options: Any
) -> Session:
    """A session that solves scenes as :func:`solve` would, with its model, solver and tolerance among the
    options; it may keep geometry and compiled programs for scenes that differ in joint properties alone.
    Raises OptionError if one of these is unknown or not available, whatever the scene."""
    given = {name: options.pop(name, None) for name in ("model", "solver", "tolerance")}
    return Session(HowToSolve(method, **given, incremental=incremental, options=options), Kept(keeps))

"""Function ``solve``: assemble a scene, check its dead load, run a method and accept the method's answer.

Importing modelling languages takes seconds. Modules that declare or solve programs are therefore imported in
the functions that use them.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import CaseError, OptionError
from masonry_opt.finite_motion.settled_state import Movements, settled_scene
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis, analysis_of
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.registry import DEFAULT, METHODS, HowToSolve
from masonry_opt.methods.task import Method, Progress, Task
from masonry_opt.problem.assembly import Assembly, assemble, on_matrices_of
from masonry_opt.problem.problem import Problem
from masonry_opt.result import Result, make_result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.acceptance import SMALLEST, Kind
from masonry_opt.solution.answer import FinalState
from masonry_opt.solution.motion import moving_names
from masonry_opt.solution.only_state import is_only_load_factor
from masonry_opt.solution.reasons import Code, Status, reason, size_of
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import FEW_STARTS, SAME, ZERO, same
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.solvers.registry import MATRICES, find_solver
from masonry_opt.stability.dead_load import DEAD_LOAD, carries

#: Largest number of joints with which the associative load factor is computed in addition to a Coulomb
#: answer. With more joints the computation takes from 15 seconds to minutes.
_MOST_JOINTS_ASSOCIATIVE = 40_000
#: Largest number of joints with which a collapse without work of the live load is looked for, if a method
#: finds no load factor.
_MOST_JOINTS_NO_WORK = 8000
#: Largest number of joints with which forces of elastic contacts at rest are used to show that a scene is
#: stable under its dead load. In larger scenes that fall, the contacts take longer to show it.
_MOST_JOINTS_AT_REST = 500
#: Work of the live load, over the product of the sizes of load and motion, up to which the live load does no
#: work. With a larger value ranges of a load factor are compared with more states of other mechanisms.
NO_WORK = 1e-3
#: Name of the method whose answer is the incremental load factor.
_INCREMENTAL = "incremental"
#: Keys of a case file that define a live load, in words, by dimension.
_LIVE_LOAD_KEYS = {
    2: "'live = [fx, fy]', there or in a [[load]] (a [wall]: 'live_per_weight', a multiple of its weight), "
    'an [[edge_load]] of kind "live", an [earthquake], or \'tilt = "right"\' to tilt the ground',
    3: "'live = [fx, fy, fz]', there or in a [[load]], 'live_per_weight', or 'tilt = [x, y, z]'",
}


@dataclass
class Session:
    """Session that solves several scenes, one after the other, with one method and its options."""

    how: HowToSolve  #: method, solver and options
    #: Compiled programs for scenes that differ only in joint properties, and matrices for scenes that differ
    #: only in loads, if the session keeps any. Answers do not depend on earlier scenes. Forces of an earlier
    #: scene may show that a scene is stable.
    kept: ProgramCache = field(default_factory=ProgramCache)
    _last: Assembly | None = None

    @property
    def method(self) -> Method:
        """Method of the session."""
        return self.how.chosen

    def without_incremental(self) -> "Session":
        """Return a session that does not compute the incremental load factor."""
        return replace(self, how=replace(self.how, incremental=False))

    def solve(
        self, scene: Scene, progress: Progress = lambda _: None, effort: Effort | None = None
    ) -> Result:
        """Return the result of a scene. Raises the errors that :func:`solve` raises for scenes."""
        effort = effort or Effort()
        return self.result(*self.answer(scene, progress, effort), effort)

    def falls(self, assembly: Assembly, effort: Effort) -> Result | None:
        """Return the result of a scene that is unstable under its dead load; None if it is stable."""
        solution = self._solve_dead_load(assembly, effort)
        return None if solution is None else self.result(assembly, solution, effort)

    def push(self, assembly: Assembly, progress: Progress, effort: Effort) -> Result:
        """Return the result of a scene that is known to be stable under its dead load.

        Raises the errors that :func:`solve` raises for scenes.
        """
        refuse_unsuited(self.method, assembly)
        return self.result(assembly, self.pushed(assembly, progress, effort), effort)

    def result(self, assembly: Assembly, solution: Solution, effort: Effort) -> Result:
        """Return a solution as a result."""
        own, other = self.how.engine, solution.solver
        solver = own if other is None or other.language == own.language else other
        return make_result(assembly, solution, effort, self.method.name, solver)

    def answer(self, scene: Scene, progress: Progress, effort: Effort) -> tuple[Assembly, Solution]:
        """Return the assembly and the solution of a scene, without names and units."""
        effort.begins("finding joints")
        with effort.measure("scene"):
            on_last_matrices = None if self._last is None else on_matrices_of(self._last, scene)
            assembly = on_last_matrices or assemble(scene)
        if self.kept.keeps:
            self._last = assembly
        refuse_unsuited(self.method, assembly)
        solution = self._solve_dead_load(assembly, effort)
        return assembly, solution or self.pushed(assembly, progress, effort)

    def pushed(self, assembly: Assembly, progress: Progress, effort: Effort) -> Solution:
        """Return the solution of a scene that is stable under its dead load."""
        problem, incremental = assembly.problem, self._solve_incremental(assembly, effort)
        effort.begins(f"method '{self.method.name}'")
        task = Task(problem, self.how.engine, self.how.own_options, effort, progress, self.kept, incremental)
        solution = replace(_run_method(self.method, task), incremental=incremental).accepted()
        solution = _complete(assembly, task, solution)
        if solution.status not in (Status.SOLVER_FAILED, Status.BELOW_ZERO):
            return solution
        # The forces and velocities belong to no answer and are removed.
        return replace(solution, found=FinalState(forms=solution.found.forms))

    def _solve_dead_load(self, assembly: Assembly, effort: Effort) -> Solution | None:
        """Return the solution of a scene that is unstable under its dead load; None if it is stable."""
        problem, solver = assembly.problem, self.how.of_dead_load
        effort.begins("does it stand under its dead load?")
        solution = Solution(Status.UNSTABLE, Kind.ASSOCIATIVE)
        # The result names the solver of this check and adds its time, but does not count its programs.
        own_effort = effort.beside()
        with effort.measure("dead_load"):
            if self._is_carried_at_rest(problem, own_effort):
                return None
        from masonry_opt.stability import diagnosis

        with effort.measure("dead_load"):
            try:
                falling = diagnosis.falling_mechanism(problem, solver, own_effort, self.kept)
            except diagnosis.DeadLoadUndecided as error:
                return solution.ended(Status.SOLVER_FAILED, Code.DEAD_LOAD_UNDECIDED, **error.values)
        if falling is None:
            return None
        effort.begins("what falls, and what would hold it")
        with effort.measure("dead_load"):
            falling = diagnosis.as_it_falls(assembly, falling, Effort())
            falls = reason(Code.FALLS, blocks=moving_names(assembly, falling))
            remedies = diagnosis.what_would_hold(assembly, falling, solver, Effort())
        found = FinalState(d=falling, forms=problem.by_cone.forms)
        return replace(solution, found=found, reasons=(falls, *remedies))

    @property
    def _adds_incremental(self) -> bool:
        """Return True if the incremental load factor is computed in addition to that of the method."""
        return self.how.incremental and not self.method.associative and self.method.name != _INCREMENTAL

    def _is_carried_at_rest(self, problem: Problem, effort: Effort) -> bool:
        """Return True if the forces of elastic contacts at rest carry the dead load.

        The forces are computed only for small scenes whose load history is needed in any case. They are not
        computed if the session keeps programs: forces of earlier scenes then decide at once.
        """
        needs_load_history = self._adds_incremental or self.method.name == _INCREMENTAL
        is_small = problem.joints <= _MOST_JOINTS_AT_REST and not problem.dilatancy_depends_on_stress
        if self.kept.keeps or not (needs_load_history and is_small):
            return False
        forces = analysis_of(Task(problem, effort=effort, kept=self.kept)).preload_forces
        if forces is None or not carries(problem, forces):
            return False
        if problem.settled is None and problem.dead.any():
            effort.uses(find_solver(MATRICES, None).name, DEAD_LOAD)
        return True

    def _solve_incremental(self, assembly: Assembly, effort: Effort) -> Solution | None:
        """Return the solution of method "incremental"; if it is not run, a solution with the reason.

        None is returned if the incremental load factor is not asked for. The steps and time are separate from
        those of the session's method.
        """
        if not self._adds_incremental:
            return None
        method, problem = METHODS[_INCREMENTAL], assembly.problem
        not_run = Solution(Status.SOLVER_FAILED, Kind.INCREMENTAL)
        if "dilatancy" in method.refuses and problem.dilatancy_depends_on_stress:
            return not_run.telling(reason(Code.DILATANCY_FALLS))
        if problem.joints > IncrementalSettings().most_joints:
            return not_run.telling(reason(Code.NOT_COMPUTED, **size_of(problem)))
        solver = find_solver(MATRICES, None)
        effort.uses(solver.name, "incremental analysis")
        with effort.measure("incremental"):
            task = Task(problem, solver, effort=Effort(effort.begins), kept=self.kept)
            solution = _run_method(method, task)
        return _without_invalid_load_factor(assembly, solution)


def refuse_without_live_load(assembly: Assembly) -> None:
    """Raise CaseError if no block carries a live load."""
    if not assembly.problem.live_norm:
        raise CaseError(f"{assembly.scene.origin}: {_without_live_load(assembly.scene)}")


def refuse_unsuited(method: Method, assembly: Assembly) -> None:
    """Raise an error if a method cannot solve a scene.

    Raises
    ------
    CaseError
        If no block carries a live load.
    OptionError
        If the scene has load cases and none was named. If the method does not support solids, limited forces,
        limited strength, or dilatancy that falls with stress.
    """
    problem, scene = assembly.problem, assembly.scene
    scene.refuse_without_case()
    refuse_without_live_load(assembly)
    named = f"method '{method.name}'"
    if scene.dimension == 3 and "space" in method.refuses:
        raise OptionError(f"{scene.origin}: {named} does not support blocks that are solids: use another")
    roles = ", ".join(dict.fromkeys(f"'{force.role}'" for force in assembly.limited))
    dilatancy = "dilatancy that falls with stress: use 'nonassociative', or omit 'dilatancy_stress'"
    strength = "joints of limited strength: choose another method, or omit 'strength'"
    for feature, is_present, sentence in (
        ("dilatancy", problem.dilatancy_depends_on_stress, dilatancy),
        ("forces", problem.matrices.limited, f"forces of {roles}: choose another method, or omit them"),
        ("strength", len(problem.crushing), strength),
    ):
        if is_present and feature in method.refuses:
            raise OptionError(f"{named} does not support {sentence}")


def _without_live_load(scene: Scene) -> str:
    """Return the error message, with advice, for a scene in which no block carries a live load."""
    case = scene.load_case
    prefix = f"load case '{case.name}': " if case is not None else ""
    if scene.factor_of_axles and (scene.axles or case is not None):
        moves = "its only live loads are axles that move: use crossing (in Python mo.crossing), which"
        return f"{prefix}{moves} finds their worst position"
    if case is not None:
        fault = f"none of its live loads ({case}) acts on a block"
        return f"{prefix}{fault}: name another group of loads, or add loads to these groups"
    return f"no block carries a live load: give one {_LIVE_LOAD_KEYS[scene.dimension]}"


def _without_invalid_load_factor(assembly: Assembly, solution: Solution) -> Solution:
    """Return a solution; remove its load factor if the load factor is not valid.

    A load factor below zero is not valid. For Coulomb friction a load factor is also not valid if the scene
    does not carry its dead load from rest.
    """
    load_factor = solution.load_factor
    associative = solution.kind is Kind.ASSOCIATIVE
    rests = load_factor is not None and not associative and _rests(assembly.problem, solution, load_factor)
    is_valid = load_factor is None or (load_factor >= -ZERO and (associative or rests))
    if solution.status is not Status.UNSTABLE and is_valid:
        return solution
    from masonry_opt.stability.existence import withdrawn

    return withdrawn(assembly, solution, rests)


def _run_method(method: Method, task: Task) -> Solution:
    """Return the solution of a method.

    A collapse in which the live load does no work is looked for in three cases:

    - before the method runs, if the incremental load factor is that of such a collapse;
    - if a Coulomb method finds no load factor;
    - if a load history ends in a range, with a motion of such a collapse. The exact load factor then replaces
      the range if it is inside the range.
    """
    before, incremental = None, task.incremental
    if incremental is None or not incremental.has(Code.NO_WORK):
        before = method.run(task)
        # A method that seeks exact states gives the answer of the load history only if it finds no exact
        # state.
        has_no_state = method.seeks_lowest and before.kind is Kind.INCREMENTAL
        if not has_no_state and _ends_without_work(task.problem, before):
            return _exact_without_work(task, method, before)
        falls = before.status is Status.UNSTABLE
        has_answer = before.answer is not None and not before.failing() and not has_no_state
        is_decided = has_answer or before.proven_none or falls
        if is_decided or before.kind is Kind.ASSOCIATIVE or task.problem.joints > _MOST_JOINTS_NO_WORK:
            return before
        from masonry_opt.methods.associative import with_associative

        before = with_associative(task, before)
        if before.associative is None:
            return before
    from masonry_opt.methods.no_work import without_work

    return without_work(task, method.run, before) or before or method.run(task)


def _ends_without_work(problem: Problem, solution: Solution) -> bool:
    """Return True if a load history ends with a range of λ and a motion without work of the live load."""
    if not solution.has(Code.RANGE) or solution.followed_to_end or solution.d is None:
        return False
    sizes = np.linalg.norm(problem.live) * np.linalg.norm(solution.d)
    return bool(problem.live @ solution.d <= NO_WORK * sizes)


def _exact_without_work(task: Task, method: Method, before: Solution) -> Solution:
    """Return the exact state in which the live load does no work if its λ is in the range of ``before``.

    Else ``before`` is returned, the solution with the range.
    """
    from masonry_opt.methods.no_work import without_work

    exact = without_work(task, method.run, before)
    limits = before.values_of(Code.RANGE)
    if exact is None or exact.load_factor is None:
        return before
    is_within = limits["carried"] * (1 - SAME) <= exact.load_factor <= limits["not_carried"] * (1 + SAME)
    return exact if is_within else before


def _rests(problem: Problem, solution: Solution, load_factor: float) -> bool:
    """Return True if a scene carries its dead load from rest.

    The tests, in this order:

    1. A known preload, or statics that fix all forces, show that the dead load is carried.
    2. The status of the incremental analysis decides, if it ended with a collapse or an unstable dead load.
    3. The dead load counts as carried if the load factor is not near zero.
    4. Else the preload of elastic contacts is computed.
    """
    if problem.settled is not None or problem.statics_fix_forces:
        return True
    incremental = solution.incremental
    if incremental is not None and incremental.status in (Status.CONVERGED, Status.UNSTABLE):
        return incremental.status.usable
    if min(load_factor, solution.below_zero) > SMALLEST:
        return True
    return IncrementalAnalysis(problem).preload_forces is not None


def _complete(assembly: Assembly, task: Task, solution: Solution) -> Solution:
    """Add the associative load factor to a solution; if it has no λ ≥ 0, add the reasons why.

    The associative load factor is added to Coulomb answers, none of which exceeds it. It is not added if it
    is proven that no load factor exists: statics then carry any multiple of the live load.
    """
    is_associative = solution.kind is Kind.ASSOCIATIVE
    is_small = task.problem.joints <= _MOST_JOINTS_ASSOCIATIVE
    if is_small and not is_associative and not solution.proven_none:
        from masonry_opt.methods.associative import with_associative

        solution = with_associative(task, solution)
    incremental = solution.incremental
    if incremental is not None:
        incremental = replace(incremental, associative=solution.associative_value)
    solution = _without_invalid_load_factor(assembly, replace(solution, incremental=incremental))
    if solution.load_factor is not None:
        return _with_few_starts(task.problem, _with_only_state(task.problem, solution))
    from masonry_opt.stability.existence import explained

    solution = explained(assembly, solution, task.solver, task.effort, is_associative)
    if incremental is None or incremental.load_factor is None or not solution.proven_none:
        return solution
    # It is proven that no collapse exists, so the contacts that slip at the incremental load factor lock
    # later.
    incremental = replace(
        incremental,
        found=FinalState(),
        status=solution.status,
        reasons=solution.reasons,
        followed_to_end=False,
        peak=None,
    )
    return replace(solution, incremental=incremental)


def _with_only_state(problem: Problem, solution: Solution) -> Solution:
    """Record in a solution if it is proven that the scene collapses at no other λ above zero."""
    load_factor = solution.load_factor
    if load_factor is None or solution.kind in (Kind.ASSOCIATIVE, Kind.INCREMENTAL):
        return solution
    return replace(solution, is_only_state=is_only_load_factor(problem, load_factor))


def _with_few_starts(problem: Problem, solution: Solution) -> Solution:
    """Add a reason to a solution if its three load factors agree after only a few starts.

    Agreement proves little if equilibrium does not fix the forces: other forces may lead to lower states. No
    reason is added if all joints follow associative flow, because all exact states then have one load factor.
    No reason is added after a proof that no state is lower, and after a search, whose own reason states the
    number of starts.
    """
    starts = solution.starts
    lowest, incremental, associative = solution.load_factor, solution.incremental, solution.associative
    is_settled = solution.proof is not None or solution.has(Code.SEARCHED)
    if starts is None or starts >= FEW_STARTS or is_settled:
        return solution
    if lowest is None or associative is None or incremental is None or incremental.load_factor is None:
        return solution
    load_factors_agree = same(lowest, incremental.load_factor) and same(lowest, associative)
    is_unique = problem.statics_fix_forces or problem.flow_is_associative
    if not load_factors_agree or is_unique:
        return solution
    return solution.telling(reason(Code.FEW_STARTS, candidates=starts))


def solve(  # noqa: PLR0913 - options of the public API are keywords
    scene: Scene | str | Path,
    method: str = DEFAULT,
    *,
    model: str | None = None,
    solver: str | None = None,
    tolerance: float | None = None,
    incremental: bool = True,
    load_case: str | None = None,
    settled: Movements | None = None,
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
    settled: Movement of supports before the live load acts, by name: (x, y) or (x, y, rotation).
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
        Result of the analysis. Its property ``usable`` is True if there is a load factor.

    Raises
    ------
    CaseError
        If the case file or scene is wrong, or no block carries a live load.
    OptionError
        If a method, model, solver, option or load case is unknown or not available. If the method does not
        support solids, limited forces, limited strength, or dilatancy that falls with stress.
    """
    for name, function in (("progress", progress), ("phases", phases)):
        if not callable(function):
            raise OptionError(f"{name} must be a function (found {function!r})")
    session = prepare(
        method, model=model, solver=solver, tolerance=tolerance, incremental=incremental, **options
    )
    effort = Effort(phases)
    effort.begins("reading blocks")
    with effort.measure("scene"):
        scene = settled_scene(as_scene(scene, load_case), settled)
    return session.solve(scene, progress, effort)


def prepare(
    method: str = DEFAULT, *, keeps: bool = False, incremental: bool = True, **options: Any
) -> Session:
    """Return a session that solves scenes as :func:`solve` does.

    The options include the model, the solver and the tolerance. If ``keeps`` is True, the session keeps
    geometry and compiled programs for scenes that differ only in joint properties or loads.

    Raises OptionError if the method, the model, the solver or an option is unknown or not available.
    """
    engine = {name: options.pop(name, None) for name in ("model", "solver", "tolerance")}
    return Session(
        HowToSolve(method, **engine, incremental=incremental, options=options), ProgramCache(keeps)
    )

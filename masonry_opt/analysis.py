"""Function ``solve``: assemble a scene, check its dead load, run a method and accept the method's answer.

Importing modelling languages takes seconds. Modules that declare or solve programs are therefore imported in
the functions that use them.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from masonry_opt.deadline import TimeLimitReached, limited
from masonry_opt.effort import Effort, Phases, ignore_progress, refuse_if_no_function
from masonry_opt.errors import TimeLimitError
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.registry import DEFAULT, INCREMENTAL_METHOD, METHODS, HowToSolve
from masonry_opt.methods.running import run_method, warn_if_long
from masonry_opt.methods.task import Method, Progress, Task
from masonry_opt.problem.assembly import Assembly, assemble, on_matrices_of
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.settled import Movements
from masonry_opt.result import Result, make_result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.mistakes import keyword_arguments
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import FinalState
from masonry_opt.solution.only_state import is_only_load_factor
from masonry_opt.solution.reasons import Code, Status, reason, size_of
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.stopped import with_answer, without_answer
from masonry_opt.solution.thresholds import FEW_STARTS
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.solvers.registry import MATRICES, find_solver
from masonry_opt.standing import DeadLoadCheck
from masonry_opt.suitability import asks_for_stability, refuse_unsuited, refuse_without_live_load

#: Largest number of joints for which Coulomb methods also compute the associative load factor. In larger
#: scenes, this would take between 15 seconds and several minutes.
_MOST_JOINTS_ASSOCIATIVE = 40_000


@dataclass
class Session:
    """Session that solves several scenes in sequence with the same method and options."""

    how: HowToSolve  #: how to solve each scene: method, solver and options
    #: Cache of compiled optimisation programs for scenes that differ only in joint properties. The cache also
    #: stores joint forces of earlier scenes. These forces may show that a later scene is stable if a solver
    #: alone cannot decide. The cache does not change any load factor.
    cache: ProgramCache = field(default_factory=ProgramCache)
    #: If True, the session decides whether a scene without live load is stable. If False, a scene without
    #: live load raises an error.
    answers_stability: bool = False
    _last: Assembly | None = None

    @property
    def method(self) -> Method:
        """Method of the session."""
        return self.how.chosen

    def without_incremental(self) -> "Session":
        """Return a session that does not compute the incremental load factor."""
        return replace(self, how=replace(self.how, incremental=False))

    def solve(
        self, scene: Scene, progress: Progress = ignore_progress, effort: Effort | None = None
    ) -> Result:
        """Solve a scene and return its result.

        Raises the errors that :func:`solve` raises for scenes.
        """
        effort = effort or Effort()
        return self.result(*self.answer(scene, progress, effort), effort)

    def falls(self, assembly: Assembly, effort: Effort) -> Result | None:
        """Return the result of a scene that is unstable under its dead load; None if the scene is stable.

        If the solver cannot decide whether the scene is stable, the result states why.
        """
        solution = self._check(assembly, effort).fall()
        return None if solution is None else self.result(assembly, solution, effort)

    def push(self, assembly: Assembly, progress: Progress, effort: Effort) -> Result:
        """Run the method on a scene that is stable under its dead load, and return the result.

        Raises the errors that :func:`solve` raises for scenes.
        """
        refuse_unsuited(self.method, assembly)
        refuse_without_live_load(assembly)
        return self.result(assembly, self.pushed(assembly, progress, effort), effort)

    def result(self, assembly: Assembly, solution: Solution, effort: Effort) -> Result:
        """Convert a solution to a result, which names the method and the solver."""
        own, other = self.how.engine, solution.solver
        solver = own if other is None or other.language == own.language else other
        return make_result(assembly, solution, effort, self.method.name, solver)

    def answer(self, scene: Scene, progress: Progress, effort: Effort) -> tuple[Assembly, Solution]:
        """Solve a scene, and return its assembly and its solution.

        Method ``result`` converts both to a result with names and units.

        Raises TimeLimitError if the time limit ends the search for joints.
        """
        with limited(self.how.time_limit):
            assembly = self._assembled(scene, effort)
            refuse_unsuited(self.method, assembly)
            check = self._check(assembly, effort)
            try:
                if self.answers_stability and asks_for_stability(assembly):
                    return assembly, check.answer()
                refuse_without_live_load(assembly)
                warn_if_long(self.method, assembly.problem, self.how.time_limit)
                fallen = check.fall()
            except TimeLimitReached as stop:
                return assembly, without_answer(self.how.kind, stop, effort)
            return assembly, fallen or self.pushed(assembly, progress, effort)

    def _assembled(self, scene: Scene, effort: Effort) -> Assembly:
        """Return the assembly of a scene: its movable blocks, joints, loads and equilibrium matrices.

        Raises TimeLimitError if the time limit ends the search for joints.
        """
        try:
            effort.begins("finding joints")
            with effort.measure("scene"):
                on_last_matrices = None if self._last is None else on_matrices_of(self._last, scene)
                assembly = on_last_matrices or assemble(scene)
        except TimeLimitReached as stop:
            raise TimeLimitError(
                f"{scene.origin}: the search for joints reached the {stop}: use a longer time limit"
            ) from None
        if self.cache.keeps:
            self._last = assembly
        return assembly

    def _check(self, assembly: Assembly, effort: Effort) -> DeadLoadCheck:
        """Return an object that tests whether an assembled scene is stable under its dead load."""
        return DeadLoadCheck(assembly, self.how, self.cache, effort)

    def pushed(self, assembly: Assembly, progress: Progress, effort: Effort) -> Solution:
        """Run the method on a scene that is stable under its dead load, and return the solution.

        If the time limit ends the analysis, the solution has the answer that is known by then, or none.
        """
        steps: list[Any] = []

        def follow(step: Any) -> None:
            steps[:] = [step]
            progress(step)

        known: Solution | None = None
        with limited(self.how.time_limit):
            try:
                known = self._solve_associative_first(assembly, effort)
                return self._pushed(assembly, follow, effort, known)
            except TimeLimitReached as stop:
                return _with_known(without_answer(self.how.kind, stop, effort, *steps), known)

    def _solve_associative_first(self, assembly: Assembly, effort: Effort) -> Solution | None:
        """Return a solution that has only the associative load factor; None without a time limit.

        The associative load factor is an upper bound on λ, and takes much less time than a Coulomb method.
        Because it is computed first, an analysis that the time limit ends later still has this upper bound.
        The method's own cache is not used, so that its programs do not depend on the time limit.
        """
        if self.how.time_limit is None or not _needs_associative(assembly.problem, self.how.kind):
            return None
        from masonry_opt.methods.associative import with_associative

        return with_associative(
            Task(assembly.problem, effort=effort), Solution(Status.TIME_LIMIT, self.how.kind)
        )

    def _pushed(
        self, assembly: Assembly, progress: Progress, effort: Effort, known: Solution | None
    ) -> Solution:
        """Run the method on a stable scene, and return the solution.

        ``known`` is a solution with the associative load factor; None if it was not computed before.

        Raises TimeLimitReached if the time limit passes before an answer is found.
        """
        problem, incremental = assembly.problem, self._solve_incremental(assembly, progress, effort)
        effort.begins(f"method '{self.method.name}'")
        task = Task(problem, self.how.engine, self.how.own_options, effort, progress, self.cache, incremental)
        solution = replace(run_method(self.method, task), incremental=incremental).accepted()
        solution = _complete(assembly, task, solution, known)
        if solution.status not in (Status.SOLVER_FAILED, Status.BELOW_ZERO):
            return solution
        # Without a load factor, the forces and velocities with which the method ended are not a collapse
        # state. Remove them from the solution.
        return replace(solution, state=FinalState(forms=solution.state.forms))

    def _solve_incremental(self, assembly: Assembly, progress: Progress, effort: Effort) -> Solution | None:
        """Compute the incremental load factor, and return the solution of method "incremental".

        The result is None if the incremental load factor is not requested. If the scene has too many joints,
        or dilatancy that depends on stress, the solution states why the method was not run. The time of the
        method is measured separately from the session's method. Load steps are reported if the session's
        method begins with the same steps.
        """
        if not self.how.adds_incremental:
            return None
        method, problem = METHODS[INCREMENTAL_METHOD], assembly.problem
        not_run = Solution(Status.SOLVER_FAILED, Kind.INCREMENTAL)
        if "dilatancy" in method.refuses and problem.dilatancy_depends_on_stress:
            return not_run.telling(reason(Code.DILATANCY_FALLS))
        if problem.joints > IncrementalSettings().most_joints:
            return not_run.telling(reason(Code.NOT_COMPUTED, **size_of(problem)))
        solver = find_solver(MATRICES, None)
        effort.uses(solver.name, "incremental analysis")
        with effort.measure("incremental"):
            own = Effort(effort.begins)
            task = Task(problem, solver, effort=own, cache=self.cache)
            if self.method.begins_with_load_history:
                task = replace(task, progress=progress)
            solution = run_method(method, task)
        return _without_invalid_load_factor(assembly, solution)


def _without_invalid_load_factor(assembly: Assembly, solution: Solution) -> Solution:
    """Remove the load factor from a solution if the load factor is not valid, and return the solution.

    A load factor below zero is not valid. For Coulomb friction a load factor is also not valid if the scene
    does not carry its dead load from rest.
    """
    load_factor = solution.load_factor
    associative = solution.kind is Kind.ASSOCIATIVE
    rests = load_factor is not None and not associative and _rests(assembly.problem, solution, load_factor)
    zero = assembly.problem.load_factor_scale.zero
    is_valid = load_factor is None or (load_factor >= -zero and (associative or rests))
    if solution.status is not Status.UNSTABLE and is_valid:
        return solution
    from masonry_opt.stability.existence import withdrawn

    return withdrawn(assembly, solution, rests)


def _rests(problem: Problem, solution: Solution, load_factor: float) -> bool:
    """Return True if a scene reaches equilibrium when the dead load is applied to blocks at rest.

    The tests, in this order:

    1. A known preload, or statics that fix all forces, show that the dead load is carried.
    2. The status of the incremental analysis decides, if it ended with a collapse or an unstable dead load.
    3. The dead load counts as carried if the load factor is not near zero.
    4. Otherwise the preload of elastic contacts is computed.
    """
    if problem.settled is not None or problem.statics_fix_forces:
        return True
    incremental = solution.incremental
    if incremental is not None and incremental.status in (Status.CONVERGED, Status.UNSTABLE):
        return incremental.status.usable
    if min(load_factor, solution.below_zero) > problem.load_factor_scale.divisor(0.0):
        return True
    return IncrementalAnalysis(problem).preload_forces is not None


def _needs_associative(problem: Problem, kind: Kind) -> bool:
    """Return True if the associative load factor is computed in addition to the method's load factor."""
    return kind is not Kind.ASSOCIATIVE and problem.joints <= _MOST_JOINTS_ASSOCIATIVE


def _with_known(solution: Solution, known: Solution | None) -> Solution:
    """Add the associative load factor of ``known`` to a solution for which it was not computed."""
    is_computed = solution.associative is not None or solution.associative_ended is not None
    if known is None or known.associative is None or is_computed:
        return solution
    return replace(solution, associative=known.associative, associative_ended=known.associative_ended)


def _complete(assembly: Assembly, task: Task, solution: Solution, known: Solution | None) -> Solution:
    """Add the associative load factor to a solution, and return the completed solution.

    The associative load factor is computed, unless ``known`` has it. If no load factor ≥ 0 was found, the
    reasons why are added too.

    The associative load factor is added to Coulomb answers, none of which exceeds it. It is not added if it
    is proven that no load factor exists: statics then carry any multiple of the live load.
    """
    is_associative = solution.kind is Kind.ASSOCIATIVE
    if _needs_associative(task.problem, solution.kind) and not solution.proven_none:
        from masonry_opt.methods.associative import with_associative

        try:
            solution = with_associative(task, _with_known(solution, known))
        except TimeLimitReached as stop:
            if solution.load_factor is None:
                raise
            solution = with_answer(solution, stop, task.effort)
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
    # Remove the incremental load factor, because it is proven that no multiple of the live load causes
    # collapse. Contacts slip at the incremental load factor, but then lock.
    incremental = replace(
        incremental,
        state=FinalState(),
        status=solution.status,
        reasons=solution.reasons,
        followed_to_end=False,
        peak=None,
    )
    return replace(solution, incremental=incremental)


def _with_only_state(problem: Problem, solution: Solution) -> Solution:
    """Record whether λ is proven to be the only positive load factor of collapse, and return the solution.

    ``is_only_state`` is True if it is proven that no other load factor above zero causes collapse. A solution
    without load factor, an associative solution and an incremental solution are returned unchanged.
    """
    load_factor = solution.load_factor
    if load_factor is None or solution.kind in (Kind.ASSOCIATIVE, Kind.INCREMENTAL):
        return solution
    return replace(solution, is_only_state=is_only_load_factor(problem, load_factor))


def _with_few_starts(problem: Problem, solution: Solution) -> Solution:
    """Add a caution if the lowest, incremental and associative load factors agree after only a few starts.

    Agreement proves little if equilibrium does not fix the forces: other forces may lead to states with a
    lower λ. No reason is added if all joints follow associative flow, because all exact states then have one
    load factor. No reason is added after a proof that no state has a lower λ, and after a search, whose own
    reason states the number of starts.
    """
    starts = solution.starts
    lowest, incremental, associative = solution.load_factor, solution.incremental, solution.associative
    is_settled = solution.proof is not None or solution.has(Code.SEARCHED)
    if starts is None or starts >= FEW_STARTS or is_settled:
        return solution
    if lowest is None or associative is None or incremental is None or incremental.load_factor is None:
        return solution
    others = (incremental.load_factor, associative)
    load_factors_agree = all(problem.load_factor_scale.equal(lowest, other) for other in others)
    is_unique = problem.statics_fix_forces or problem.flow_is_associative
    if not load_factors_agree or is_unique:
        return solution
    return solution.telling(reason(Code.FEW_STARTS, candidates=starts))


def solve(  # noqa: PLR0913 - each option of the public API is an argument
    scene: Scene | str | Path,
    method: str = DEFAULT,
    *,
    model: str | None = None,
    solver: str | None = None,
    tolerance: float | None = None,
    incremental: bool = True,
    time_limit: float | None = None,
    load_case: str | None = None,
    settled: Movements | None = None,
    progress: Progress = ignore_progress,
    phases: Phases = ignore_progress,
    **options: Any,
) -> Result:
    """Find the load factor at which a scene collapses; for a scene without live load, decide if it is stable.

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    method: Name of the method. Methods for joints with Coulomb friction, which do not open as they slide:

        - "coulomb", the default: the lowest of several exact collapse states; the loop if dilatancy falls
          with stress.
        - "incremental": the load factor at which equilibrium is lost as the live load grows from zero,
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
    tolerance: Feasibility and gap tolerance of the solver, for "static", "kinematic" and "nonassociative"
        (default 1e-9). With cones of friction in space the solver may miss the tolerance; the reasons of the
        result then say so.
    incremental: True if Coulomb methods compute the incremental load factor too (for up to 3000 joints; in
        space, for up to 3000 contact points).
    time_limit: Seconds after which the analysis ends with the lowest collapse state found so far, or without
        an answer. The reasons of the result then say so. With a time limit, the associative load factor is
        computed first, so that this upper bound is known even without an answer. In method "global" the time
        limits the search for the two bounds. If a scene has load cases, each has this time.
    load_case: Name of a load case of the scene; needed if the scene has load cases. :func:`solve_cases`
        solves all of them.
    settled: Movement of supports before the live load acts, by name: (x, y) or (x, y, rotation). The rotation
        is in radians, counter-clockwise.
    progress: Function that is called with each step of the method:
        :class:`~.load_history.LoadStep`, :class:`~.loop.run.Iteration` of the loop,
        :class:`~.mpec.RelaxationStep`, :class:`~.coulomb.search.LowerState` of the search,
        :class:`~.bracket.relaxation.BoundStep` of "global".
    phases: Function that is called with a few words as each phase begins, such as "finding joints".
    **options: Options of the method: fields of :class:`~.coulomb.method.CoulombOptions`,
        :class:`~.incremental.method.IncrementalOptions`, :class:`~.loop.options.LoopOptions`,
        :class:`~.mpec.MpecOptions`, :class:`~.bracket.bracket.GlobalOptions`.

    Returns
    -------
    Result
        Result of the analysis. Its property ``usable`` is True if there is a load factor, or if a scene
        without live load is stable. The ``stability`` of such a result has its safety margins.

    Raises
    ------
    CaseError
        If the case file or scene is wrong, or no block carries a load. If all live loads of a load case act
        on no block, or the only live loads are axles.
    OptionError
        If a method, model, solver, option or load case is unknown or not available. If the method does not
        support solids, limited forces, limited strength, or dilatancy that falls with stress.
    TimeLimitError
        If the time limit is over before all joints are found.
    """
    refuse_if_no_function("progress", progress)
    refuse_if_no_function("phases", phases)
    engine: dict[str, Any] = {"model": model, "solver": solver, "tolerance": tolerance}
    session = prepare(
        method, function=solve, incremental=incremental, time_limit=time_limit, **engine, **options
    )
    effort = Effort(phases)
    effort.begins("reading blocks")
    with limited(session.how.time_limit):
        with effort.measure("scene"):
            scene = _after_settlement(as_scene(scene, load_case), settled)
        return replace(session, answers_stability=True).solve(scene, progress, effort)


def _after_settlement(scene: Scene, settled: Movements | None) -> Scene:
    """Move the supports of a scene, and return the scene with its displaced blocks.

    Raises TimeLimitError if the time limit ends the computation.
    """
    if settled is None:
        return scene
    # This module is imported only if supports settle, because it imports HiGHS, which takes long to load.
    from masonry_opt.finite_motion.settled_state import settled_scene

    try:
        return settled_scene(scene, settled)
    except TimeLimitReached as stop:
        raise TimeLimitError(
            f"{scene.origin}: the computation of the settlement reached the {stop}: use a longer time limit"
        ) from None


def prepare(
    method: str = DEFAULT,
    *,
    function: Callable[..., Any] | None = None,
    keeps: bool = False,
    incremental: bool = True,
    time_limit: float | None = None,
    **options: Any,
) -> Session:
    """Return a session whose method ``solve`` solves scenes in the same way as :func:`solve`.

    The options include the model, the solver and the tolerance. Errors about unknown options suggest the
    arguments of ``function``, the function that the user called. If ``keeps`` is True, the session keeps
    geometry and compiled programs for scenes that differ only in joint properties or loads.

    Raises OptionError if the method, the model, the solver or an option is unknown or not available.
    """
    engine = {name: options.pop(name, None) for name in ("model", "solver", "tolerance")}
    limits: dict[str, Any] = {"incremental": incremental, "time_limit": time_limit}
    arguments = () if function is None else keyword_arguments(function)
    how = HowToSolve(method, **engine, **limits, options=options, arguments=arguments)
    return Session(how, ProgramCache(keeps))

"""Steps of the default method.

Modules that declare programs are imported inside functions, because the import of a modelling language takes
seconds.
"""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, Protocol

from masonry_opt.methods.associative import associative, with_associative
from masonry_opt.methods.coulomb.run import CoulombRun
from masonry_opt.methods.incremental.method import IncrementalOptions, incremental
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.task import Task
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import Existence
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.registry import find_solver

if TYPE_CHECKING:
    from masonry_opt.methods.bounds.least import LeastProof


class CoulombStep(Protocol):
    """Interface of a step of the default method. A step that ends the run sets ``run.ended``."""

    @property
    def name(self) -> str:
        """Name of the step in the log."""

    def applies(self, run: CoulombRun) -> bool:
        """Return True if this step is needed after the earlier steps."""

    def run(self, run: CoulombRun) -> None:
        """Run the step, and store its results in ``run``."""


@dataclass(frozen=True)
class Incremental:
    """Step that raises the live load from zero until equilibrium is lost.

    If dilatancy falls with stress, or if the scene has too many joints, this step is skipped and the loop of
    linear programs solves the scene.
    """

    settings: IncrementalSettings = field(default_factory=IncrementalSettings)
    name: str = "incremental analysis"

    def applies(self, run: CoulombRun) -> bool:
        """Return True if dilatancy is constant and the scene has at most ``settings.most_joints`` joints."""
        problem = run.problem
        return not problem.dilatancy_depends_on_stress and problem.joints <= self.settings.most_joints

    def run(self, run: CoulombRun) -> None:
        """Compute or reuse the load history. End the run if the scene is unstable under its dead load."""
        task, solution = run.task, run.task.incremental
        if solution is None or not solution.history:
            solution = incremental(task.with_options(IncrementalOptions(settings=self.settings)))
        else:
            # The load history was already computed when the incremental load factor was computed. Record the
            # solver and the number of load steps of the history for this method too.
            run.effort.uses(task.solver.name, "incremental analysis")
            run.effort.iterations += len(solution.history)
            run.seconds_before = run.effort.seconds["incremental"]
        run.incremental = solution
        run.known = replace(run.known, history=solution.history)
        if solution.status is Status.UNSTABLE:
            run.ended = replace(solution, kind=Kind.EXACT)


@dataclass(frozen=True)
class ExactFrom:
    """Step that looks for an exact state near the forces of the incremental analysis or of associative flow.

    Incremental forces are the forces of the state in which the incremental analysis ends. Forces of
    associative flow are used if the load history leads to no exact state, for example if joints hardly slide.
    """

    start: Literal["incremental", "associative"]

    @property
    def name(self) -> str:
        """Name of the step in the log."""
        return f"exact state from the {self.start} forces"

    def applies(self, run: CoulombRun) -> bool:
        """Return True if the incremental analysis was run, and forces to start from are available and needed.

        Incremental forces are available if the incremental analysis ended in a state. Forces of associative
        flow are needed only if no state is known yet.
        """
        if run.incremental is None:
            return False
        if self.start == "incremental":
            return run.incremental.answer is not None
        return run.answer is None

    def run(self, run: CoulombRun) -> None:
        """Look for an exact state. End the run if a proof shows that no collapse state with λ ≥ 0 exists."""
        if self.start == "associative":
            self._run_from_associative(run)
            return
        assert run.incremental is not None
        assert run.incremental.answer is not None
        run.states.near(run.incremental.answer)

    def _run_from_associative(self, run: CoulombRun) -> None:
        run.known = with_associative(run.task, run.known)
        if run.known.associative is None:
            from masonry_opt.stability.existence import existence

            run.known = replace(run.known, infeasibility=existence(run.problem, run.effort))
            if run.known.proven_none:
                run.ended = run.known
            return
        forces = associative(Task(run.problem, cache=run.task.cache)).answer
        if forces is not None:
            run.states.near(forces)


@dataclass(frozen=True)
class FurtherStarts:
    """Step that looks for states with a lower λ from further starts, on small plane scenes and in space."""

    name: str = "further starts"

    def applies(self, run: CoulombRun) -> bool:
        """Return True if the scene is small or in space, and the run seeks the state with the lowest λ.

        False is returned if all exact states must have the same λ.
        """
        problem = run.problem
        if run.incremental is None or not run.seeks_lower:
            return False
        most = min(run.settings.small, run.settings.simplex_up_to)
        if problem.joints > most and not problem.layout.round:
            return False
        return not run.is_only_state

    def run(self, run: CoulombRun) -> None:
        """Look for states with a lower load factor than the present answer."""
        assert run.incremental is not None
        if run.problem.layout.round:
            run.states.look_further_in_space(run.incremental.load_history)
        else:
            proven = run.proof is not None
            starts = run.settings.starts_after_proof if proven else run.settings.starts_in_vain
            run.states.look_further_in_the_plane(starts)


@dataclass(frozen=True)
class LeastProven:
    """Step that tries to prove, on small plane scenes, that no state has a lower load factor.

    The search for the proof may find a state with a lower λ. The proof comes before the further starts,
    because fewer starts are needed after a proof.
    """

    name: str = "proof of the least"

    def applies(self, run: CoulombRun) -> bool:
        """Return True if the run seeks the state with the lowest λ, and a proof is tried for this scene."""
        return run.incremental is not None and run.seeks_lower and run.budget.tries_by_default(run.problem)

    def run(self, run: CoulombRun) -> None:
        """Search for states with a lower λ until a proof excludes them or the budget is used up."""
        # The import is local, because importing the SAT solver takes 30 ms.
        from masonry_opt.methods.bounds.least import LeastProof

        assert run.incremental is not None
        known = run.answer if run.answer is not None and run.answer.exact else None
        upper = run.budget.range_end(run.problem, run.known.associative, run.incremental.load_history)
        search = LeastProof(run.task, known, upper)
        try:
            search.run(run.budget.seconds, run.budget.programs)
        finally:
            # Store a state with a lower λ even if the time limit has stopped the search.
            if search.best is not None and search.best is not known:
                run.states.lower_to(search.best)
        if search.best is not None:
            run.proof = search.proof
        run.note = self._note(search, upper)

    @staticmethod
    def _note(search: "LeastProof", upper: float | None) -> str:
        """Return a sentence for the log that says how the search ended."""
        if search.proof is not None:
            proven = f"proven by {search.proof.contents}"
            return proven if search.best is not None else f"no state up to λ = {upper:.6g}, {proven}"
        if search.why:
            return f"not proven: {search.why}"
        return f"not proven by {search.programs} linear programs"


@dataclass(frozen=True)
class Loop:
    """Step that runs the paper's loop of linear programs, if no earlier step found a collapse state.

    The loop is method "nonassociative", see :mod:`~masonry_opt.methods.loop.nonassociative`.
    """

    options: LoopOptions = field(default_factory=LoopOptions)
    name: str = "loop of linear programs"

    def applies(self, run: CoulombRun) -> bool:
        """Return True if no earlier step found a collapse state."""
        return run.answer is None

    def run(self, run: CoulombRun) -> None:
        """End the run. The first of the following cases that applies determines the solution.

        1. If there is no load history, the solution is the solution of the loop.
        2. If joint forces within their limits carry any load, and the compression of joints grows with the
           load in the load history, there is no collapse.
        3. If all exact states have negative load factors, there is no load factor.
        4. If the scene does not come to equilibrium when its dead load is applied to the blocks at rest, it
           is unstable.
        5. If the loop finds a load factor, or if neither statics nor the loop limit the load, the solution is
           the solution of the loop.
        6. If the load history ends in a collapse without an exact state nearby, the solution is the largest
           load of the history.
        7. Otherwise neither the load history nor the loop decides, and there is no load factor.
        """
        if run.incremental is None:
            run.ended = self._solve(run)
            return
        run.ended = _end_without_loop(run) or self._end_by_loop(run)

    def _solve(self, run: CoulombRun) -> Solution:
        from masonry_opt.methods.loop.nonassociative import nonassociative

        return nonassociative(run.task.with_options(self.options, find_solver("cvxpy", None)))

    def _end_by_loop(self, run: CoulombRun) -> Solution:
        assert run.incremental is not None
        known = run.known
        by_loop = self._solve(run).accepted()
        statics = known.associative_ended
        endless = statics is not None and statics.unlimited and by_loop.status.unlimited
        ended = by_loop
        if by_loop.answer is None and not endless:
            ended = run.incremental
            if ended.answer is None:
                return _undecided(run, Status.SOLVER_FAILED, looped=True)
        ended = _with_carried_load(run, ended, run.incremental)
        ended = replace(ended, associative=known.associative, associative_ended=statics)
        return replace(ended, infeasibility=known.infeasibility)


def _with_carried_load(run: CoulombRun, ended: Solution, incremental: Solution) -> Solution:
    """If the load history reached a higher λ than the solution, add a reason that states the higher λ."""
    history = incremental.load_history
    if history is None or ended.load_factor is None or not incremental.has(Code.UNDECIDED):
        return ended
    carried = history.steps[-1].load_factor
    if not run.problem.load_factor_scale.is_lower(ended.load_factor, carried):
        return ended
    return ended.telling_first(reason(Code.CARRIES_MORE, carried=carried))


def _end_without_loop(run: CoulombRun) -> Solution | None:
    """Return the solution if the loop is not needed (cases 2 to 4 of :meth:`Loop.run`), otherwise None."""
    assert run.incremental is not None
    infeasibility = run.known.infeasibility
    grows = [own_reason for own_reason in run.incremental.reasons if own_reason.code is Code.UNBOUNDED]
    if grows and infeasibility is not None and infeasibility.existence is Existence.UNBOUNDED:
        return replace(run.known, status=Status.JAMMED, reasons=tuple(grows))
    lowest = run.states.met.lowest
    if lowest < -run.problem.load_factor_scale.zero:
        ended = run.known.ended(Status.BELOW_ZERO, Code.BELOW_ZERO, load_factor=lowest)
        return replace(ended, below_zero=lowest)
    if run.analysis.preload_forces is None:
        return _undecided(run, Status.UNSTABLE, looped=False)
    return None


def _undecided(run: CoulombRun, status: Status, looped: bool) -> Solution:
    assert run.incremental is not None
    word = run.incremental.values_of(Code.UNDECIDED).get("word", "there is no exact state nearby")
    steps = len(run.incremental.history)
    return run.known.ended(status, Code.UNDECIDED, word=word, steps=steps, looped=looped, searched=False)

"""Decide if a scene is stable under its dead load, and answer for scenes that have no live load.

The forces of elastic contacts are computed first, because load histories need them in any case. If there are
no such forces, optimisation programs decide. Modules that declare programs are imported in the functions that
use them, because the imports take seconds.
"""

from dataclasses import dataclass, replace

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.methods.incremental.analysis import analysis_of
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.registry import INCREMENTAL_METHOD, METHODS, HowToSolve
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import FinalState
from masonry_opt.solution.motion import moving_names
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.stability import Stability, are_resultants_unique, worst_joint
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.solvers.registry import MATRICES, find_solver
from masonry_opt.stability.dead_load import DEAD_LOAD, carries

#: Scenes with up to this number of joints are first tested for stability with elastic contacts. Larger scenes
#: are first tested by a linear program, because it finds instability faster.
_MOST_JOINTS_AT_REST = 500


@dataclass(frozen=True)
class DeadLoadCheck:
    """Check of one scene for stability under its dead load, with the method and programs of a session."""

    assembly: Assembly
    how: HowToSolve  #: method, solver and options
    cache: ProgramCache  #: compiled programs of the session
    effort: Effort

    @property
    def _follows_load_history(self) -> bool:
        """True if the analysis computes a load history, from zero live load to collapse."""
        return self.how.adds_incremental or self.how.chosen.name == INCREMENTAL_METHOD

    @property
    def _is_small(self) -> bool:
        """True if elastic contact forces are computed before programs are solved, as in small scenes."""
        return self.assembly.problem.joints <= _MOST_JOINTS_AT_REST

    def fall(self) -> Solution | None:
        """Return a solution with the reason why the scene is unstable; None if the scene is stable.

        If the solver cannot decide whether the scene is stable, the solution states why.
        """
        self.effort.begins("stability under the dead load")
        # Count the programs of this check separately. The final result includes the time and the solver of
        # the check, but not the number of its programs.
        own_effort = self.effort.separate_counter()
        with self.effort.measure("dead_load"):
            if self._is_small and self._forces_at_rest(own_effort) is not None:
                return None
        return self._decide_by_program(own_effort)[0]

    def answer(self) -> Solution:
        """Return the solution of a scene without live load, with safety margins if the scene is stable."""
        self.effort.begins("stability under the dead load")
        own_effort = self.effort.separate_counter()
        with self.effort.measure("dead_load"):
            forces = self._forces_at_rest(own_effort) if self._is_small else None
            if forces is not None:
                return self._stable(forces, True, own_effort)
        fallen, by_program = self._decide_by_program(own_effort)
        if by_program is None:
            assert fallen is not None, "if the stability check returns no forces, it must return a solution"
            return fallen
        with self.effort.measure("dead_load"):
            forces = None if self._is_small else self._forces_at_rest(own_effort)
            if forces is not None:
                return self._stable(forces, True, own_effort)
            return self.fall_from_rest(own_effort) or self._stable(by_program, False, own_effort)

    def _stable(self, forces: np.ndarray, elastic: bool, effort: Effort) -> Solution:
        """Return the solution of a stable scene, with its safety margins.

        ``forces`` are in equilibrium with the dead load, shape (3c + t,).
        """
        from masonry_opt.stability.reserves import geometric_margin, least_friction_factor

        problem, solver = self.assembly.problem.by_cone, self.how.of_dead_load
        self.effort.begins("least friction of a stable scene")
        factor = least_friction_factor(problem, solver, effort)
        self.effort.begins("geometric margin of a stable scene")
        margin = geometric_margin(self.assembly, solver, effort)
        friction = np.unique(problem.friction)
        total_dead = float(problem.force_sizes(problem.dead).sum()) or 1.0
        unique = are_resultants_unique(self.assembly)
        stability = Stability(
            unique=unique,
            equilibrium=float(np.abs(problem.unbalanced(0.0, forces)).max()) / total_dead,
            yield_=max(0.0, -float(problem.slacks(forces).min(initial=0.0))),
            least_friction_factor=factor,
            least_friction=None if factor is None or len(friction) != 1 else factor * float(friction[0]),
            geometric_margin=margin,
            worst_joint=worst_joint(self.assembly, forces),
        )
        state = FinalState(q=forces, forms=problem.forms)
        carried = reason(Code.CARRIED, unique=unique, elastic=elastic)
        return Solution(Status.STABLE, Kind.ASSOCIATIVE, reasons=(carried,), state=state, stability=stability)

    def _decide_by_program(self, effort: Effort) -> tuple[Solution | None, np.ndarray | None]:
        """Decide by optimisation programs if a scene is stable under its dead load.

        Return the solution of an unstable scene, or forces, shape (3c + t,), that carry the dead load.

        Exactly one of the two values is not None. If the solver cannot decide, the solution states why.
        """
        from masonry_opt.stability import diagnosis

        assembly, problem, solver = self.assembly, self.assembly.problem, self.how.of_dead_load
        solution = Solution(Status.UNSTABLE, Kind.ASSOCIATIVE)
        with self.effort.measure("dead_load"):
            try:
                falling, forces = diagnosis.mechanism_or_forces(problem, solver, effort, self.cache)
            except diagnosis.DeadLoadUndecided as error:
                return solution.ended(Status.SOLVER_FAILED, Code.DEAD_LOAD_UNDECIDED, **error.values), None
        if falling is None:
            return None, forces
        self.effort.begins(
            "falling blocks of an unstable scene, and the friction or strength that would make it stable"
        )
        with self.effort.measure("dead_load"):
            falling = diagnosis.as_it_falls(assembly, falling, Effort())
            falls = reason(Code.FALLS, blocks=moving_names(assembly, falling))
            remedies = diagnosis.what_would_hold(assembly, falling, solver, Effort())
        state = FinalState(d=falling, forms=problem.by_cone.forms)
        return replace(solution, state=state, reasons=(falls, *remedies)), None

    def fall_from_rest(self, effort: Effort) -> Solution | None:
        """Check if a scene is stable only because self-stress (forces without any load) wedges its blocks.

        If so, return the solution of an unstable scene; otherwise None.

        Programs find forces that carry the dead load of such a scene, but elastic contacts that start without
        forces do not come to rest, and an exact state of collapse exists. Methods with associative flow do
        not consider this, and neither do scenes that are too large for a load history.
        """
        problem = self.assembly.problem
        if not self._is_history_possible(problem):
            return None
        task = Task(problem, find_solver(MATRICES, None), effort=Effort(), cache=self.cache)
        if analysis_of(task).preload_forces is not None:
            return None
        solution = METHODS[INCREMENTAL_METHOD].run(task)
        if solution.status is not Status.UNSTABLE:
            return None
        from masonry_opt.stability.existence import withdrawn

        effort.uses(task.solver.name, DEAD_LOAD)
        return withdrawn(self.assembly, solution, rests=False)

    def _is_history_possible(self, problem: Problem) -> bool:
        """Return True if the method computes a load history, and the scene is not too large for it."""
        is_small = problem.joints <= IncrementalSettings().most_joints
        return self._follows_load_history and is_small and not problem.dilatancy_depends_on_stress

    def _forces_at_rest(self, effort: Effort) -> np.ndarray | None:
        """Return elastic contact forces, shape (3c + t,), under the dead load; None if they are not found."""
        problem = self.assembly.problem
        if not self._is_history_possible(problem):
            return None
        forces = analysis_of(Task(problem, effort=effort, cache=self.cache)).preload_forces
        if forces is None or not carries(problem, forces):
            return None
        if problem.settled is None and problem.dead.any():
            effort.uses(find_solver(MATRICES, None).name, DEAD_LOAD)
        return forces

"""Conflict-driven search for a lower collapse state, by a SAT solver and two linear programs.

The search follows DPLL(T), as in SMT solvers: CaDiCaL assigns the Boolean variables of the yield conditions,
and after each propagation the two programs examine the partial assignment. Where one of them is infeasible,
its Farkas multipliers name a few conditions to blame. Deletion makes the set minimal, and its clause is
learned.
"""

import time
from collections.abc import Callable
from functools import cached_property
from math import inf

import numpy as np
from pysat.engines import Propagator
from pysat.solvers import Cadical195

from masonry_opt.methods.bounds.conflicts import (
    Kinematics,
    Refutation,
    Statics,
    Theory,
    Undecided,
    friction_excess,
    senses_of,
)
from masonry_opt.methods.bounds.settings import ProofSettings
from masonry_opt.methods.exact.refiner import Refiner, refiner_of
from masonry_opt.methods.incremental.analysis import analysis_of, is_meaningful
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import in_units_of_load
from masonry_opt.solution.acceptance import SMALLEST
from masonry_opt.solution.answer import Answer, certified
from masonry_opt.solution.proof import Conflict, EnergyBound, Proof, StaticConflict
from masonry_opt.solution.thresholds import ZERO, is_lower


class ConflictSearchTimeout(Exception):
    """The time or the number of linear programs of the search is over."""


class ConflictSearch(Propagator):  # type: ignore[misc]  # python-sat has no types
    """Search for states below the lowest known λ, until the conflicts found exclude all of them.

    Methods without an underscore, but for ``run``, are the interface that CaDiCaL calls (IPASIR-UP).
    """

    def __init__(self, task: Task, known: float, settings: ProofSettings) -> None:
        super().__init__()
        self._task, self._problem, self._settings = task, task.problem, settings
        #: Time, and number of programs, at which the search stops. A stopped search can be continued.
        self._ends, self._most_programs = inf, settings.most_programs
        self._scaled = in_units_of_load(task.problem)
        self._effort, self._solved_before = task.effort, task.effort.lp_solves
        self._effort.uses("cadical", "clauses")
        self._statics = Statics(self._scaled, self._effort, settings)
        self.known = known  #: lowest load factor of all known exact states
        self.best: Answer | None = None  #: exact state with the lowest load factor that this search has found
        self.highest = bound_below(known, settings)  #: load factor up to which states are excluded
        self.conflicts: list[Conflict] = []
        self.energy_bounds: list[EnergyBound] = []
        self.senses = senses_of(task.problem)
        self._statics.set_highest(self.highest / self._scaled.load_factor)
        self._kinematics = Kinematics(self._scaled, self._energy(), self._effort, settings)
        self._kinematics.set_highest(self.highest / self._scaled.load_factor)
        #: Value of each yield condition, shape (faces,): 1 if it moves, −1 if it is at rest, 0 if not
        #: assigned.
        self._values = np.zeros(task.problem.faces, dtype=int)
        self._trail: list[int] = []  # conditions in the order of their assignment
        self._levels: list[int] = []  # length of the trail at each decision
        self._clause: list[int] | None = None  # learned clause that was not yet passed to the SAT solver
        self._slacks: np.ndarray | None = None  # slacks of the last feasible forces, divided by max(1, μ)
        # Rates and velocities of the last feasible mechanism.
        self._motion: tuple[np.ndarray, np.ndarray] | None = None
        self._decisions, self._examined = 0, False
        self._stopped: BaseException | None = None

    def run(self, ends: float, more: int) -> None:
        """Search until no assignment of values to the yield conditions satisfies all clauses.

        The search stops at a time of ``time.perf_counter``, or after a number of ``more`` linear programs. It
        goes on with its clauses when it is run again. Raise ConflictSearchTimeout if it stops, and Undecided
        if the programs leave an assignment undecided.
        """
        self._ends, self._most_programs = ends, min(self._settings.most_programs, self.programs + more)
        self._stopped = self._clause = None
        self._values[:] = 0
        self._trail.clear()
        self._levels.clear()
        with Cadical195() as solver:
            solver.connect_propagator(self)
            for variable in range(1, self._problem.faces + 1):
                solver.observe(variable)
                solver.add_clause([variable, -variable])
            for one, other in self.senses.tolist():
                solver.add_clause([-(one + 1), -(other + 1)])
            for conflict in self.conflicts:
                solver.add_clause(conflict.clause)
            satisfiable = solver.solve()
        if self._stopped is not None:
            raise self._stopped
        if satisfiable is not False:
            raise Undecided("the SAT solver found an assignment that no program refuted")

    @cached_property
    def _refiner(self) -> Refiner:
        return refiner_of(self._task)

    def lower_to(self, load_factor: float) -> None:
        """Search only below a load factor that another search has found, if it is the lowest one known.

        Raise Undecided if nothing is left to exclude. Conflicts stay valid for every lower load factor.
        """
        if load_factor >= self.known:
            return
        self.known = load_factor
        self.highest = bound_below(load_factor, self._settings)
        if self.highest <= 0:
            raise Undecided("a collapse state with load factor zero exists, so that nothing can be excluded")
        for theory in (self._statics, self._kinematics):
            theory.set_highest(self.highest / self._scaled.load_factor)
        self._slacks = self._motion = None

    @property
    def programs(self) -> int:
        """Number of linear programs that the search has solved."""
        return self._effort.lp_solves - self._solved_before

    def proof(self) -> Proof:
        """Return the proof of a search that has run to its end."""
        return Proof(
            bound=self.highest,
            load_factor=self.known,
            conditions=self._problem.faces,
            conflicts=tuple(self.conflicts),
            energy_bounds=tuple(self.energy_bounds),
            senses=self.senses,
        )

    def on_assignment(self, lit: int, fixed: bool = False) -> None:
        """Record the value of a condition."""
        condition = abs(lit) - 1
        if self._values[condition] == 0:
            self._trail.append(condition)
        self._values[condition] = 1 if lit > 0 else -1
        self._examined = False

    def on_new_level(self) -> None:
        """Record a decision."""
        self._levels.append(len(self._trail))

    def on_backtrack(self, to: int) -> None:
        """Remove the values that were assigned after a decision level."""
        if to < len(self._levels):
            first = self._levels[to]
            self._values[self._trail[first:]] = 0
            del self._trail[first:], self._levels[to:]
        self._clause = None

    def propagate(self) -> list[int]:
        """Examine the partial assignment. The list is empty, because conflicts are passed on as clauses."""
        self._guarded(self._examine)
        return []

    def provide_reason(self, lit: int) -> list[int]:
        """Return an empty list, because this propagator assigns no values."""
        return []

    def check_model(self, model: list[int]) -> bool:
        """Examine a complete assignment, and return True if the search must end there undecided."""
        values = np.sign(np.array(model[: self._problem.faces]))
        self._values[:] = values
        self._examined = False
        self._guarded(self._examine)
        return self._clause is None

    def has_clause(self) -> bool:
        """Return True if a clause waits to be passed to the SAT solver."""
        return self._clause is not None

    def add_clause(self) -> list[int]:
        """Return the waiting clause to the SAT solver. An empty clause ends the search."""
        clause, self._clause = self._clause, None
        return clause or []

    def decide(self) -> int:
        """Decide that the unassigned condition with the largest product z p moves, and return its variable.

        Zero leaves the decision to the SAT solver.
        """
        self._decisions += 1
        if self._slacks is None or self._motion is None or self._decisions % self._settings.decide_every:
            return 0
        energy = np.where(self._values == 0, self._slacks * self._motion[0], 0.0)
        condition = int(energy.argmax())
        return condition + 1 if energy[condition] > 0 else 0

    def _guarded(self, action: Callable[[], None]) -> None:
        """Run an action in a call from the SAT solver. After an exception an empty clause ends the search."""
        if self._stopped is not None or self._examined or self._clause is not None:
            return
        try:
            action()
        except (Exception, KeyboardInterrupt) as error:
            self._stopped, self._clause = error, []

    def _examine(self) -> None:
        """Refute the assignment, or find a state with a lower load factor, or else change nothing."""
        self._examined = True
        while True:
            if time.perf_counter() >= self._ends or self.programs >= self._most_programs:
                raise ConflictSearchTimeout
            moving, at_rest = self._values > 0, self._values < 0
            if self._motion is None or self._motion[0][at_rest].max(initial=0.0) > self._settings.zero:
                self._motion = None
                if self._refuted(self._kinematics, at_rest):
                    return
                self._motion = self._kinematics.motion()
            if self._slacks is None or self._slacks[moving].max(initial=0.0) > self._settings.zero:
                self._slacks = None
                if self._refuted(self._statics, moving):
                    return
                self._slacks = self._statics.slacks()
            energy = float((self._slacks * self._motion[0]).max(initial=0.0))
            is_complete = bool(self._values.all())
            if (energy > self._settings.energy and not is_complete) or not self._descended():
                return

    def _refuted(self, theory: Theory, conditions: np.ndarray) -> bool:
        """Restrict a program; if it is infeasible, learn a minimal conflict and return True.

        Return True without a conflict if HiGHS or the matrices do not confirm the refutation: the assignment
        stays, and more values may bring a conflict that they confirm.
        """
        try:
            found = theory.refutes(conditions)
        except Undecided:
            return True
        if found is None:
            return False
        # The newest conditions are released first, because a clause of older conditions takes back more
        # decisions.
        refutations = [found]
        for condition in [one for one in reversed(self._trail) if found.blamed[one]]:
            if refutations[-1].blamed[condition]:
                fewer = refutations[-1].blamed.copy()
                fewer[condition] = False
                shorter = _refutes(theory, fewer)
                if shorter is not None:
                    refutations.append(shorter)
        self._learn(theory, refutations)
        return True

    def _learn(self, theory: Theory, refutations: list[Refutation]) -> None:
        """Check refutations with the matrices, and store the clause of the last one that passes.

        Nothing is stored if none passes.
        """
        for found in reversed(refutations):
            conflict = theory.conflict(found, self._problem, self.highest)
            if conflict is not None:
                self.conflicts.append(conflict)
                self._clause = conflict.clause
                return

    def _descended(self) -> bool:
        """Store an exact state of lower λ if the last mechanism leads to one, and return True then.

        Raise Undecided if only blocks without load move in the state: it is no answer, and no proof excludes
        it.
        """
        assert self._motion is not None
        lowest = self._lowest_nearby(*self._motion)
        if lowest is None:
            return False
        if not is_meaningful(analysis_of(self._task), lowest.load_factor, lowest.d):
            raise Undecided("a state with a lower load factor exists in which only blocks without load move")
        self.best = lowest
        self.lower_to(lowest.load_factor)
        return True

    def _lowest_nearby(self, rates: np.ndarray, d: np.ndarray) -> Answer | None:
        """Return the exact state of lowest λ near the last forces and a mechanism; None if none lowers λ.

        Three states are examined: the last forces, the forces of least λ that hold the mechanism at yield,
        and the state to which the two programs of exact states lead from there.
        """
        points = [self._statics.point()]
        least = self._statics.least(rates > self._settings.zero)
        if least is not None:
            points.append(least)
        answers = [self._answer(load_factor, q, d) for load_factor, q in points]
        nearby = self._refiner.state_near(answers[-1].q)
        if nearby is not None:
            answers.append(nearby.answer)
        return min(filter(self._is_lower, answers), key=lambda one: one.load_factor, default=None)

    def _answer(self, load_factor: float, q: np.ndarray, d: np.ndarray) -> Answer:
        """Return an answer with certificate, from λ and forces (3c + t,) in scaled units and velocities."""
        return certified(self._problem, self._scaled.load_factor * load_factor, self._scaled.force * q, d)

    def _is_lower(self, one: Answer) -> bool:
        return one.load_factor >= -ZERO and is_lower(one.load_factor, self.known) and one.exact

    def _energy(self) -> np.ndarray:
        """Return the least energy e of each condition, in scaled units, shape (faces,).

        A sliding condition that cannot be at yield becomes a conflict of its own.
        """
        problem = self._problem
        energy = problem.face_cohesion.copy()
        for condition in np.flatnonzero(friction_excess(problem)).tolist():
            found = self._statics.least_friction(problem, condition, self.highest)
            if isinstance(found, StaticConflict):
                self.conflicts.append(found)
            elif found is not None and found.value > 0:
                self.energy_bounds.append(found)
                energy[condition] += found.value
        return energy / self._scaled.force


def _refutes(theory: Theory, conditions: np.ndarray) -> Refutation | None:
    """Return a proof that a linear program with the given conditions (faces,) held is infeasible, or None.

    Forces hold a condition at yield, and mechanisms hold a condition at rest. None means that the program is
    feasible, or that HiGHS decides nothing.
    """
    try:
        return theory.refutes(conditions)
    except Undecided:
        return None


def bound_below(load_factor: float, settings: ProofSettings) -> float:
    """Return the load factor up to which a proof excludes states: a little below the best known λ."""
    return load_factor - settings.gap * max(abs(load_factor), SMALLEST)

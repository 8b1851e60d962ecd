"""Conflict-driven search for a lower collapse state, by a SAT solver and two linear programs.

The search follows DPLL(T), as in SMT solvers: CaDiCaL assigns the Boolean variables of the yield conditions,
and after each propagation the two programs examine the partial assignment. If a program is infeasible, its
Farkas multipliers name a few conditions that contradict each other. Conditions are deleted from this set
until it is minimal, and the SAT solver learns a clause that excludes the set.
"""

import time
from collections.abc import Callable
from contextlib import suppress
from functools import cached_property
from math import inf

import numpy as np
from pysat.engines import Propagator
from pysat.solvers import Cadical195

from masonry_opt.effort import ProgramLimitReached
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
from masonry_opt.methods.task import Task
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.problem.problem import in_units_of_load
from masonry_opt.solution.answer import Answer, certified
from masonry_opt.solution.proof import Conflict, EnergyBound, Proof, StaticConflict


class ConflictSearchTimeout(Exception):
    """Error that is raised if the search reaches its time limit."""


class NoLoadFactorLeft(Exception):
    """Error that is raised if products exclude all load factors below the lowest known state."""


class ConflictSearch(Propagator):  # type: ignore[misc]  # python-sat has no types
    """Search for collapse states below the lowest known λ, until the learned conflicts exclude them all.

    CaDiCaL calls the methods from ``on_assignment`` to ``decide`` (interface IPASIR-UP).
    """

    def __init__(self, task: Task, known: float, settings: ProofSettings) -> None:
        super().__init__()
        self._task, self._problem, self._settings = task, task.problem, settings
        self._ends = inf  #: time at which the search stops; a stopped search can be continued
        self._scaled = in_units_of_load(task.problem)
        self._scale = task.problem.load_factor_scale
        self._effort, self._solved_before = task.effort, task.effort.lp_solves
        self._effort.uses("cadical", "clauses")
        self._statics = Statics(self._scaled, self._effort, settings)
        self.known = known  #: lowest load factor of all known exact states
        self.best: Answer | None = None  #: exact state with the lowest λ that this search has found
        #: Load factor up to which the proof excludes states.
        self.highest = bound_below(known, settings, self._scale)
        self.conflicts: list[Conflict] = []
        self.energy_bounds: list[EnergyBound] = []
        self.senses = senses_of(task.problem)
        self._lowest = 0.0  # load factor up to which products exclude all states
        self._statics.set_range(0.0, self.highest)
        self._kinematics = Kinematics(self._scaled, self._energy(), self._effort, settings)
        self._kinematics.set_highest(self.highest / self._scaled.load_factor)
        #: Value of each yield condition in the SAT solver, shape (faces,). It is 1 if the condition is at
        #: yield and may have a nonzero rate, −1 if its rate is zero, and 0 if no value is assigned.
        self._values = np.zeros(task.problem.faces, dtype=int)
        self._trail: list[int] = []  # yield conditions in the order of their assignment
        self._levels: list[int] = []  # length of the trail at each decision
        self._clause: list[int] | None = None  # learned clause, not yet passed to the SAT solver
        # Slack of each yield condition under the latest feasible forces, divided by max(1, μ), shape
        # (faces,).
        self._slacks: np.ndarray | None = None
        # Rates, shape (faces,), and velocities, shape (3b,), of the latest feasible mechanism.
        self._motion: tuple[np.ndarray, np.ndarray] | None = None
        self._decisions, self._examined = 0, False
        self._stopped: BaseException | None = None

    def run(self, ends: float) -> None:
        """Search until the learned clauses exclude all assignments of the yield conditions.

        Raise ConflictSearchTimeout when ``time.perf_counter`` reaches ``ends``, and ProgramLimitReached when
        the effort permits no further linear program. A further call continues the search with its learned
        clauses. Raise Undecided if the programs leave an assignment undecided. Raise NoLoadFactorLeft if the
        search finds a state below which products exclude all others.
        """
        self._ends = ends
        self._stopped = self._clause = None
        self._values[:] = 0
        self._trail.clear()
        self._levels.clear()
        with Cadical195() as solver:
            solver.connect_propagator(self)
            for variable in range(1, self._problem.faces + 1):
                solver.observe(variable)
                solver.add_clause([variable, -variable])
            for first, second in self.senses.tolist():
                solver.add_clause([-(first + 1), -(second + 1)])
            for conflict in self.conflicts:
                solver.add_clause(conflict.clause)
            satisfiable = solver.solve()
        if self._stopped is not None:
            raise self._stopped
        if satisfiable is not False:
            raise Undecided("the linear programs could not exclude a combination of yielding joints")

    @cached_property
    def _refiner(self) -> Refiner:
        return refiner_of(self._task)

    def lower_to(self, load_factor: float) -> None:
        """Restrict the search to load factors below ``load_factor``.

        All conflicts remain valid, because they hold for every lower load factor. Raise NoLoadFactorLeft if
        products exclude all lower load factors. Raise Undecided if the load factor is zero.
        """
        if load_factor >= self.known:
            return
        self.known = load_factor
        self.highest = bound_below(load_factor, self._settings, self._scale)
        if self.highest <= 0:
            raise Undecided("a collapse state at λ = 0 exists, and a proof cannot cover λ below zero")
        if self.highest <= self._lowest:
            raise NoLoadFactorLeft
        self._statics.set_range(self._lowest, self.highest)
        self._kinematics.set_highest(self.highest / self._scaled.load_factor)
        self._slacks = self._motion = None

    def raise_to(self, lowest: float) -> None:
        """Restrict the search to load factors above ``lowest``, after a relaxation excluded smaller ones.

        All conflicts remain valid, because they hold for every interval within the present one.
        """
        self._lowest = lowest
        self._statics.set_range(lowest, self.highest)
        self._slacks = None

    @property
    def programs(self) -> int:
        """Number of linear programs that the search has solved."""
        return self._effort.lp_solves - self._solved_before

    def proof(self) -> Proof:
        """Return the proof. Call this method only after ``run`` has returned without an exception."""
        return Proof(
            bound=self.highest,
            load_factor=self.known,
            conditions=self._problem.faces,
            conflicts=tuple(self.conflicts),
            energy_bounds=tuple(self.energy_bounds),
            senses=self.senses,
        )

    def on_assignment(self, lit: int, fixed: bool = False) -> None:
        """Record the value that the SAT solver assigns to a yield condition."""
        condition = abs(lit) - 1
        if self._values[condition] == 0:
            self._trail.append(condition)
        self._values[condition] = 1 if lit > 0 else -1
        self._examined = False

    def on_new_level(self) -> None:
        """Record that the SAT solver makes a decision and thereby opens a new decision level."""
        self._levels.append(len(self._trail))

    def on_backtrack(self, to: int) -> None:
        """Remove all values that were assigned above the decision level ``to``."""
        if to < len(self._levels):
            first = self._levels[to]
            self._values[self._trail[first:]] = 0
            del self._trail[first:], self._levels[to:]
        self._clause = None

    def propagate(self) -> list[int]:
        """Check if the partial assignment can be refuted, and learn a conflict if so.

        The returned list is empty, because this propagator assigns no values.
        """
        self._guarded(self._examine)
        return []

    def provide_reason(self, lit: int) -> list[int]:
        """Return an empty list of reasons, because this propagator never assigns a value."""
        return []

    def check_model(self, model: list[int]) -> bool:
        """Check if a complete assignment can be refuted; if not, return True, which ends the search."""
        values = np.sign(np.array(model[: self._problem.faces]))
        self._values[:] = values
        self._examined = False
        self._guarded(self._examine)
        return self._clause is None

    def has_clause(self) -> bool:
        """Return True if a learned clause must still be passed to the SAT solver."""
        return self._clause is not None

    def add_clause(self) -> list[int]:
        """Pass the learned clause to the SAT solver. An empty clause ends the search."""
        clause, self._clause = self._clause, None
        return clause or []

    def decide(self) -> int:
        """Assume that the unassigned yield condition with the largest product of slack and rate is at yield.

        Return the SAT variable of this condition. Zero leaves the decision to the SAT solver.
        """
        self._decisions += 1
        if self._slacks is None or self._motion is None or self._decisions % self._settings.decide_every:
            return 0
        energy = np.where(self._values == 0, self._slacks * self._motion[0], 0.0)
        condition = int(energy.argmax())
        return condition + 1 if energy[condition] > 0 else 0

    def _guarded(self, action: Callable[[], None]) -> None:
        """Run an action. If the action raises an exception, store the exception and end the search.

        Exceptions cannot pass through the SAT solver. An empty clause ends it, and ``run`` then raises the
        stored exception.
        """
        if self._stopped is not None or self._examined or self._clause is not None:
            return
        try:
            action()
        except (Exception, KeyboardInterrupt) as error:
            self._stopped, self._clause = error, []

    def _examine(self) -> None:
        """Check if the present assignment can be refuted; if not, look for an exact state with a lower λ."""
        self._examined = True
        while True:
            if time.perf_counter() >= self._ends:
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
            if energy > self._settings.energy and not is_complete:
                return
            if not self._descended():
                # If ``_descended`` found no state because no further linear program is permitted, this call
                # raises ProgramLimitReached.
                self._effort.check_programs()
                return

    def _refuted(self, theory: Theory, conditions: np.ndarray) -> bool:
        """Return True unless the program stays feasible when chosen slacks or rates are set to zero.

        The mask ``conditions`` selects the yield conditions whose slacks (in statics) or rates (in
        kinematics) are set to zero. If the program is infeasible, the search learns a minimal conflict of
        these conditions. No conflict is learned if HiGHS does not decide whether the program is feasible, or
        if no conflict is confirmed. The assignment then remains, and a conflict may be confirmed after more
        values are assigned.
        """
        try:
            refutation = theory.refutes(conditions)
        except Undecided:
            return True
        if refutation is None:
            return False
        # Try to drop each condition from the conflict, the last assigned first. A clause of conditions that
        # were assigned early lets the SAT solver revoke more decisions.
        refutations = [refutation]
        for condition in [assigned for assigned in reversed(self._trail) if refutation.blamed[assigned]]:
            if refutations[-1].blamed[condition]:
                fewer = refutations[-1].blamed.copy()
                fewer[condition] = False
                shorter = _refutes(theory, fewer)
                if shorter is not None:
                    refutations.append(shorter)
        self._learn(theory, refutations)
        return True

    def _learn(self, theory: Theory, refutations: list[Refutation]) -> None:
        """Store the conflict of the last confirmed refutation, and the clause that excludes this conflict.

        A refutation is confirmed if its multipliers prove a conflict with the matrices of the problem.
        Nothing is stored if no refutation is confirmed.
        """
        for refutation in reversed(refutations):
            conflict = theory.conflict(refutation, self._problem, self.highest)
            if conflict is not None:
                self.conflicts.append(conflict)
                self._clause = conflict.clause
                return

    def _descended(self) -> bool:
        """Look for an exact state with a lower load factor; if one is found, store it and return True.

        The state must be near the last mechanism. Its load factor is not below zero, so no check for blocks
        without net load is needed (see :func:`.weightless`).
        """
        assert self._motion is not None
        lowest = self._lowest_nearby(*self._motion)
        if lowest is None:
            return False
        self.best = lowest
        self.lower_to(lowest.load_factor)
        return True

    def _lowest_nearby(self, rates: np.ndarray, d: np.ndarray) -> Answer | None:
        """Return the exact state with the lowest λ near the present forces and a mechanism.

        Three sets of forces are tested: the present forces of the program, the forces with the least λ at
        which all conditions with a nonzero rate in the mechanism are at yield, and the forces that the search
        for exact states finds near these. The result is None if no state has a lower λ than all known states.
        Forces that need a linear program are left out if no further program is permitted.
        """
        answers = [self._answer(*self._statics.point(), d)]
        with suppress(ProgramLimitReached):
            least = self._statics.least(rates > self._settings.zero)
            if least is not None:
                answers.append(self._answer(*least, d))
            nearby = self._refiner.state_near(answers[-1].q)
            if nearby is not None:
                answers.append(nearby.answer)
        return min(filter(self._is_lower, answers), key=lambda answer: answer.load_factor, default=None)

    def _answer(self, load_factor: float, q: np.ndarray, d: np.ndarray) -> Answer:
        """Convert a state in scaled units to an answer with a certificate."""
        return certified(self._problem, self._scaled.load_factor * load_factor, self._scaled.force * q, d)

    def _is_lower(self, answer: Answer) -> bool:
        if answer.load_factor < -self._scale.zero:
            return False
        return self._scale.is_lower(answer.load_factor, self.known) and answer.exact

    def _energy(self) -> np.ndarray:
        """Return a lower bound on the energy that each yield condition dissipates per unit rate.

        The bounds have shape (faces,) and are in scaled units. If a sliding condition cannot be at yield, a
        conflict that consists of this condition alone is stored. If no further linear program is permitted,
        the remaining bounds contain no friction energy, also in a search that is continued later.
        """
        problem = self._problem
        energy = problem.face_cohesion.copy()
        for condition in np.flatnonzero(friction_excess(problem)).tolist():
            try:
                result = self._statics.least_friction(problem, condition, self.highest)
            except ProgramLimitReached:
                break
            if isinstance(result, StaticConflict):
                self.conflicts.append(result)
            elif result is not None and result.value > 0:
                self.energy_bounds.append(result)
                energy[condition] += result.value
        return energy / self._scaled.force


def _refutes(theory: Theory, conditions: np.ndarray) -> Refutation | None:
    """Return a refutation if the program is infeasible when chosen slacks or rates are zero; otherwise None.

    The mask ``conditions``, shape (faces,), selects the yield conditions whose slacks (in statics) or rates
    (in kinematics) are set to zero. None is returned if the program is feasible, if HiGHS does not decide, or
    if no further linear program is permitted.
    """
    try:
        return theory.refutes(conditions)
    except (Undecided, ProgramLimitReached):
        return None


def bound_below(load_factor: float, settings: ProofSettings, scale: LoadFactorScale) -> float:
    """Return the λ up to which a proof must exclude collapse states, slightly below the lowest known λ."""
    return load_factor - settings.gap * scale.divisor(load_factor)

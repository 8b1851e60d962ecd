"""Search for exact states with a lower λ, alternately from random starts and near the best state so far."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from itertools import cycle, islice
from math import inf
from typing import TypeVar

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.methods.exact.random_forces import RandomForces
from masonry_opt.methods.exact.refiner import ExactState, Refiner, StateFinder
from masonry_opt.methods.exact.self_stress import self_stress
from masonry_opt.methods.exact.settings import SEARCH, SearchSettings
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE, LoadFactorScale
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.answer import Answer
from masonry_opt.solution.reasons import Code, Reason, reason
from masonry_opt.solution.solution import Solution

#: Kind of a start, and the exact state found from this start, or None if no state was found.
Candidate = tuple[str, ExactState | None]


class StateRecord:
    """Record of a search: the number of its starts, and the load factors of the exact states found."""

    def __init__(self, scale: LoadFactorScale) -> None:
        self.scale = scale  #: decides which load factors are equal, and which are zero
        self.load_factors: list[float] = []  #: distinct load factors of exact states, in order of discovery
        self.candidates = 0  #: number of starts, including those without an exact state
        #: Lowest load factor of all states whose mechanism counts as a collapse. The answer of the search may
        #: have a higher load factor, for example because positive load factors are preferred.
        self.lowest = inf

    def count(self, state: ExactState | Answer | None) -> None:
        """Count a start. If the start led to a state, record the load factor of the state."""
        self.candidates += 1
        if state is not None:
            self.add(state.load_factor)

    def add(self, load_factor: float) -> None:
        """Record a load factor, unless an equal load factor is already recorded."""
        if not any(self.scale.equal(load_factor, known) for known in self.load_factors):
            self.load_factors.append(load_factor)

    @property
    def _above_zero(self) -> list[float]:
        """Positive load factors of the states, or all load factors if none is positive."""
        return [value for value in self.load_factors if value > self.scale.zero] or self.load_factors

    @property
    def _has_state_below(self) -> bool:
        """True if the lowest λ found is zero or negative and lower than all reported load factors."""
        return self.lowest <= self.scale.zero and self.lowest < min(self._above_zero) - self.scale.zero

    @property
    def reasons(self) -> list[Reason]:
        """Reasons that report the number of states with λ > 0, and the lowest λ if it is zero or negative."""
        above = self._above_zero
        values = {"candidates": self.candidates, "count": len(above), "least": min(above), "most": max(above)}
        below = [reason(Code.BELOW_ZERO, load_factor=self.lowest)] if self._has_state_below else []
        return [reason(Code.STATES_MET, **values), *below]

    def recorded_in(self, solution: Solution) -> Solution:
        """Return a solution that also contains the number of starts and the number of exact states found.

        If no exact state was found, the solution is returned unchanged.
        """
        if not self.load_factors:
            return solution
        below_zero = self.lowest if self._has_state_below else inf
        states = len(self._above_zero)
        solution = replace(solution, starts=self.candidates, exact_states=states, below_zero=below_zero)
        return solution.telling(*self.reasons)


class Search:
    """Search for exact states with a λ below the lowest known λ, from random forces and near known states."""

    def __init__(
        self,
        finder: StateFinder,
        analysis: IncrementalAnalysis,
        met: StateRecord,
        settings: SearchSettings = SEARCH,
    ) -> None:
        self._finder, self._analysis, self.problem, self.met = finder, analysis, finder.problem, met
        self._settings = settings
        #: State with the lowest λ from another search, such as the search for a proof, or None. Later starts
        #: use forces near the forces of this state.
        self.known: ExactState | None = None

    @property
    def effort(self) -> Effort:
        """Record of the optimisation programs solved so far, with their times and solvers."""
        return self._finder.effort

    @cached_property
    def _random(self) -> RandomForces:
        """Object that draws random forces. It builds its linear program once, and uses it for all draws."""
        return RandomForces(self.problem, self._finder.effort, self._settings)

    @cached_property
    def _largest_load_factor(self) -> float | None:
        """Largest λ at which admissible forces are in equilibrium, or None if no largest λ is found."""
        return self._random.largest_load_factor(self._finder.seconds_left)

    def start(self, q: np.ndarray | None) -> ExactState | None:
        """Count one more start, and return the exact state that the search finds near the joint forces ``q``.

        The joint forces have shape (3c,). None is returned if the search finds no exact state, or if ``q`` is
        None because no joint forces were found for the start.
        """
        self._finder.effort.begins(f"lower states, start {self.met.candidates + 1}")
        state = None if q is None else self._finder.state_near(q)
        self.met.count(state)
        return state

    def until_in_vain(self, lowest: ExactState | None, starts: int) -> Iterator[ExactState | None]:
        """Yield the state of each start. Stop after ``starts`` successive starts that do not lower λ."""
        in_vain = 0
        for _, state in self.endless(lowest, 0):
            yield state
            before, lowest = lowest, lower_of(lowest, state, self.met.scale)
            in_vain = 0 if lowest is not before else in_vain + 1
            if in_vain >= starts:
                return

    def fixed_number(
        self, lowest: ExactState | None, forces: Iterable[np.ndarray]
    ) -> Iterator[ExactState | None]:
        """Run a fixed number of starts, which depends only on the scene, and yield the state of each start.

        The first starts are the given forces, each of shape (3c + t,). On scenes with many contacts one more
        start follows, from the forces of the state with the lowest λ. On other scenes random starts follow.
        """
        for q in forces:
            state = self.start(q)
            lowest = lower_of(lowest, state, self.met.scale)
            yield state
        if self.problem.joints > self._settings.most_contacts:
            if lowest is not None:
                yield self.start(lowest.q)
            return
        for _, state in islice(self.endless(lowest, 0), self._settings.starts_in_space):
            yield state

    def endless(self, best: ExactState | None, seed: int) -> Iterator[Candidate]:
        """Run starts without end, and yield the kind of each start and the state found from this start.

        Random numbers depend only on the seed and on the number of the random start. In space a start from
        the forces of the state with the lowest λ comes first, and again whenever λ is lowered: another
        mechanism that is possible under these forces may lead to a lower load factor.
        """
        kinds: tuple[str, ...] = _KINDS_IN_SPACE if self.problem.layout.round else _KINDS_IN_PLANE
        repeated: ExactState | None = None
        for number, kind in enumerate(cycle(kinds)):
            while self.problem.layout.round and best is not None and best is not repeated:
                repeated = best
                state = self.start(best.q)
                best = lower_of(best, state, self.met.scale)
                yield _LOWEST, state
            rng = np.random.default_rng((seed, number))
            best = lower_of(best, self.known, self.met.scale)
            state = self.start(_START_FUNCTIONS[kind](self, best, rng))
            best = lower_of(best, state, self.met.scale)
            yield kind, state

    def random_forces(self, best: ExactState | None, rng: np.random.Generator) -> np.ndarray | None:
        """Return random forces in equilibrium at a random fraction of the lowest known load factor.

        If no positive load factor is known, the largest load factor that statics permit is used.
        """
        known = self._largest_load_factor
        if best is not None and best.load_factor > self.met.scale.zero:
            known = best.load_factor
        if known is None:
            return None
        self._finder.check_time()
        load_factor = known * rng.uniform(*self._settings.load_shares)
        return self._random.draw(load_factor, rng, self._finder.seconds_left)

    def _loaded(self, problem: Problem) -> np.ndarray | None:
        """Return the forces at the end of a load history, or None if the history ends without collapse."""
        with self._finder.effort.measure("solve"):
            result = self._analysis.again_for(problem).run(lambda _: self._finder.check_time())
        if result.load_factor is None:
            return None
        return result.history.steps[-1].forces

    def with_self_stress(self, _best: ExactState | None, rng: np.random.Generator) -> np.ndarray | None:
        """Return the forces at the end of a load history that starts from a random preload."""
        settled = self_stress(self.problem, rng)
        return None if settled is None else self._loaded(replace(self.problem, settled=settled))

    def fixed_point(self, _best: ExactState | None, rng: np.random.Generator) -> np.ndarray | None:
        """Return forces from the fixed-point iteration of Acary, Cadoux, Lemaréchal & Malick (2011).

        Each iteration solves a linear program in which normal forces have costs. The costs are random at
        first. At a fixed point the cost of a normal force equals the difference between the associative and
        the actual opening of its joint, (μ − tan φ₀) |slip|.
        """
        assert isinstance(self._finder, Refiner)
        problem = self.problem
        closing = problem.friction - problem.dilatancy
        cost = closing * rng.exponential(1.0, len(closing))
        for _ in range(self._settings.fixed_point_iterations):
            forces_and_rates = self._finder.at_cost(cost)
            if forces_and_rates is None:
                return None
            q, p = forces_and_rates
            last, cost = cost, closing * problem.table.slip_speed(p)
            if np.abs(cost - last).max(initial=0.0) <= EQUALITY_TOLERANCE * max(1.0, last.max(initial=0.0)):
                break
        return q

    def neighbour(self, state: ExactState | None, rng: np.random.Generator) -> np.ndarray | None:
        """Return a random interpolation between the forces of a state and forces with a lower load factor.

        Program (b) of the module ``refiner`` yields the forces with a lower load factor, after a few of the
        active yield conditions are released.
        """
        assert isinstance(self._finder, Refiner)
        if state is None or not state.duals.any():
            return None
        holding = np.flatnonzero(state.duals > EQUALITY_TOLERANCE * state.duals.max())
        drawn = rng.random(self.problem.faces)[holding]
        rates = state.rates.copy()
        rates[holding[drawn <= max(self._settings.released_share, drawn.min())]] = 0.0
        relaxed = self._finder.least(rates, state.d)
        if relaxed is None:
            return None
        weight = rng.uniform()
        return weight * relaxed.q + (1 - weight) * state.q


_L = TypeVar("_L", ExactState, Answer)


def lower_of(first: _L | None, second: _L | None, scale: LoadFactorScale) -> _L | None:
    """Return the state with the lower load factor; a state that is None is ignored.

    - If the load factors are equal, a state that is exact is preferred to a state that is not. If neither or
      both are exact, the first state is returned.
    - A state with a positive load factor is preferred to a state with a load factor of zero or less, in which
      the scene would move without live load.
    """
    if first is None or second is None:
        return first or second
    if first.exact != second.exact and scale.equal(first.load_factor, second.load_factor):
        return first if first.exact else second
    if (first.load_factor <= scale.zero) != (second.load_factor <= scale.zero):
        return second if first.load_factor < second.load_factor else first
    return second if scale.is_lower(second.load_factor, first.load_factor) else first


#: Kind of start of a search: the forces of the state with the lowest λ found so far.
_LOWEST = "lowest state"
#: Kind of start of a search: random forces in equilibrium.
_RANDOM_FORCES = "random forces"
#: Kind of start of a search: the final forces of a load history with a random preload.
_STRESS = "self-stress"
#: Kind of start of a search: forces from a fixed-point iteration, which repeats a linear program and updates
#: the cost of each normal force.
_FIXED = "fixed point"
#: Kind of start of a search: forces close to the forces of the state with the lowest λ found so far.
_NEIGHBOUR = "neighbour"

#: Type of a function that returns the forces of a start. Its arguments are the search, the state with the
#: lowest λ so far, and a random number generator.
_Start = Callable[[Search, ExactState | None, np.random.Generator], np.ndarray | None]

#: Function of each kind of start.
_START_FUNCTIONS: dict[str, _Start] = {
    _RANDOM_FORCES: Search.random_forces,
    _STRESS: Search.with_self_stress,
    _FIXED: Search.fixed_point,
    _NEIGHBOUR: Search.neighbour,
}

#: Kinds of starts in the plane, in the order in which the search repeats them. Starts that iterate to a fixed
#: point take about three times as long as other starts, but only they lead to the lowest states of some
#: slopes that slide as a whole (see ``benchmarks/README.md``).
_KINDS_IN_PLANE = (_RANDOM_FORCES, _NEIGHBOUR, _RANDOM_FORCES, _FIXED)

#: Kinds of starts in space, in the order in which the search repeats them. Random forces are frequent,
#: because they lead to a lower λ in less time than self-stress.
_KINDS_IN_SPACE = (_RANDOM_FORCES, _RANDOM_FORCES, _STRESS, _RANDOM_FORCES)

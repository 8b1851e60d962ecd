"""Search for lower exact states from other starts and in the neighbourhood of the lowest state, in turn."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cached_property, partial
from itertools import cycle, islice
from math import inf
from typing import TypeVar

import numpy as np

from masonry_opt.answer.answer import Answer
from masonry_opt.answer.reasons import Code, Reason, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import SAME, ZERO, is_lower, same
from masonry_opt.methods.exact.random_forces import RandomForces
from masonry_opt.methods.exact.refiner import ExactState, Refiner, StateFinder
from masonry_opt.methods.exact.self_stress import self_stress
from masonry_opt.methods.exact.settings import SEARCH, SearchSettings
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis
from masonry_opt.problem.problem import Problem

#: Kind of a start, and the exact state to which it led.
Candidate = tuple[str, ExactState | None]


class Met:
    """Record of the starts of a search, and of the exact states to which they led."""

    def __init__(self) -> None:
        self.load_factors: list[float] = []  #: different load factors of the states, in order of discovery
        self.candidates = 0  #: number of starts, with or without a state
        self.lowest = inf  #: least load factor of a physically meaningful state, even if it is not the answer

    def count(self, state: ExactState | Answer | None) -> None:
        """Count a start, and record the load factor of its state if there is one."""
        self.candidates += 1
        if state is not None and not any(same(state.load_factor, known) for known in self.load_factors):
            self.load_factors.append(state.load_factor)

    @property
    def _above_zero(self) -> list[float]:
        """Load factors above zero of the different states; all load factors if none lies above zero."""
        return [value for value in self.load_factors if value > ZERO] or self.load_factors

    @property
    def _has_state_below(self) -> bool:
        """True if a state at or below zero lies below all states above zero."""
        return self.lowest <= ZERO and self.lowest < min(self._above_zero) - ZERO

    @property
    def reasons(self) -> list[Reason]:
        """Reasons that count the states above zero, and name the lowest state if it lies at or below zero."""
        above = self._above_zero
        values = {"candidates": self.candidates, "count": len(above), "least": min(above), "most": max(above)}
        below = [reason(Code.BELOW_ZERO, load_factor=self.lowest)] if self._has_state_below else []
        return [reason(Code.STATES_MET, **values), *below]

    def recorded_in(self, solution: Solution) -> Solution:
        """Return a solution that reports the starts, and the exact states that they led to."""
        if not self.load_factors:
            return solution
        below_zero = self.lowest if self._has_state_below else inf
        states = len(self._above_zero)
        solution = replace(solution, starts=self.candidates, exact_states=states, below_zero=below_zero)
        return solution.telling(*self.reasons)


class Search:
    """Search for lower exact states of one problem, from many starts and around the lowest state."""

    def __init__(
        self,
        finder: StateFinder,
        analysis: IncrementalAnalysis,
        met: Met,
        settings: SearchSettings = SEARCH,
    ) -> None:
        self._finder, self._analysis, self.problem, self.met = finder, analysis, finder.problem, met
        self._settings = settings

    @cached_property
    def _random(self) -> RandomForces:
        """Return the generator of random forces, whose program is loaded once."""
        return RandomForces(self.problem, self._finder.effort, self._settings)

    @cached_property
    def _largest_load_factor(self) -> float | None:
        """Return the largest load factor that statics allow; None if none or any load factor is possible."""
        return self._random.largest_load_factor(self._finder.seconds_left)

    def start(self, q: np.ndarray | None) -> ExactState | None:
        """Return the exact state found from joint forces (3c,), or None, and count the start."""
        self._finder.effort.begins(f"lower states, start {self.met.candidates + 1}")
        state = None if q is None else self._finder.state_near(q)
        self.met.count(state)
        return state

    def until_in_vain(self, lowest: ExactState | None) -> Iterator[ExactState | None]:
        """Yield the states of further starts until a number of starts in a row has found no lower state."""
        in_vain = 0
        for _, state in self.endless(lowest, 0):
            yield state
            before, lowest = lowest, lower_of(lowest, state)
            in_vain = 0 if lowest is not before else in_vain + 1
            if in_vain >= self._settings.starts_in_vain:
                return

    def fixed_number(
        self, lowest: ExactState | None, forces: Iterable[np.ndarray]
    ) -> Iterator[ExactState | None]:
        """Yield the states of a number of further starts that depends on the scene alone, not on time.

        The first starts are the given forces, each of shape (3c + t,). On scenes with many contacts the only
        other start is the one from the forces of the lowest state.
        """
        for q in forces:
            state = self.start(q)
            lowest = lower_of(lowest, state)
            yield state
        if self.problem.joints > self._settings.most_contacts:
            if lowest is not None:
                yield self.start(lowest.q)
            return
        for _, state in islice(self.endless(lowest, 0), self._settings.starts_in_space):
            yield state

    def endless(self, best: ExactState | None, seed: int) -> Iterator[Candidate]:
        """Yield candidates without end.

        Random numbers depend on the seed and the number of a random start alone. In space a start from the
        forces of the lowest state comes first, and again after each lower state, without the mechanism of
        that state: another mechanism that these forces allow may lead lower.
        """
        kinds: tuple[str, ...] = _KINDS_IN_SPACE if self.problem.layout.round else _KINDS
        if self._random.has_limited_forces:
            kinds = (*_WEAKER_TIES, *kinds)
        repeated: ExactState | None = None
        for number, kind in enumerate(cycle(kinds)):
            while self.problem.layout.round and best is not None and best is not repeated:
                repeated = best
                state = self.start(best.q)
                best = lower_of(best, state)
                yield _LOWEST, state
            rng = np.random.default_rng((seed, number))
            state = self.start(_STARTS[kind](self, best, rng))
            best = lower_of(best, state)
            yield kind, state

    def random_forces(
        self, best: ExactState | None, rng: np.random.Generator, strength_share: float = 1.0
    ) -> np.ndarray | None:
        """Return random forces at a share of the lowest load factor, or of the largest that statics allow.

        Ties, props and other forces with two limits use at most ``strength_share`` of their strength. A tie
        that does not yield may allow a lower state than a tie that does.
        """
        known = self._largest_load_factor if best is None or best.load_factor <= ZERO else best.load_factor
        if known is None:
            return None
        self._finder.check_time()
        load_factor = known * rng.uniform(*self._settings.load_shares)
        return self._random.draw(load_factor, rng, strength_share, self._finder.seconds_left)

    def _loaded(self, problem: Problem) -> np.ndarray | None:
        """Return the forces at the end of a load history; None if it has no collapse."""
        with self._finder.effort.measure("solve"):
            result = self._analysis.again_for(problem).run(lambda _: self._finder.check_time())
        if result.load_factor is None:
            return None
        return result.history.steps[-1].forces

    def with_other_loads(self, _best: ExactState | None, rng: np.random.Generator) -> np.ndarray | None:
        """Return the forces of a load history with the loads of each block changed at random."""
        problem, sizes = self.problem, (2, self.problem.dead.size)
        dead, live = np.exp(self._settings.load_deviation * rng.standard_normal(sizes)) * [
            problem.dead,
            problem.live,
        ]
        return self._loaded(replace(problem, dead=dead, live=live))

    def with_self_stress(self, _best: ExactState | None, rng: np.random.Generator) -> np.ndarray | None:
        """Return the forces of a load history from another random preload."""
        settled = self_stress(self.problem, rng)
        return None if settled is None else self._loaded(replace(self.problem, settled=settled))

    def fixed_point(self, _best: ExactState | None, rng: np.random.Generator) -> np.ndarray | None:
        """Return forces at a fixed point, from random costs (Acary, Cadoux, Lemaréchal & Malick 2011).

        At a fixed point the cost of a normal force is the dilation that Coulomb's joints lack,
        (μ − tan φ₀) |slip|.
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
            if np.abs(cost - last).max(initial=0.0) <= SAME * max(1.0, last.max(initial=0.0)):
                break
        return q

    def neighbour(self, state: ExactState | None, rng: np.random.Generator) -> np.ndarray | None:
        """Return forces between a state's and lower ones.

        The lower forces are those for which a few of the yield conditions that hold λ up are released.
        """
        assert isinstance(self._finder, Refiner)
        if state is None or not state.strength.any():
            return None
        holding = np.flatnonzero(state.strength > SAME * state.strength.max())
        drawn = rng.random(self.problem.faces)[holding]
        rates = state.rates.copy()
        rates[holding[drawn <= max(self._settings.released_share, drawn.min())]] = 0.0
        relaxed = self._finder.least(rates, state.d)
        if relaxed is None:
            return None
        weight = rng.uniform()
        return weight * relaxed.q + (1 - weight) * state.q


_L = TypeVar("_L", ExactState, Answer)


def lower_of(one: _L | None, other: _L | None) -> _L | None:
    """Return the lower of two states.

    - Of two states with equal load factors, it is the exact one, or else the first.
    - A state at or below zero, in which a scene needs no load to move, is lower only than another such state.
    """
    if one is None or other is None:
        return one or other
    if one.exact != other.exact and same(one.load_factor, other.load_factor):
        return one if one.exact else other
    if (one.load_factor <= ZERO) != (other.load_factor <= ZERO):
        return other if one.load_factor < other.load_factor else one
    return other if is_lower(other.load_factor, one.load_factor) else one


_LOWEST = "lowest state"  #: Kind of a start from the forces of the lowest state.
_RANDOM_FORCES = "random forces"  #: Kind of a start from random forces in equilibrium.
_STRESS = "self-stress"  #: Kind of a start from a load history with a random preload.
_FIXED = "fixed point"  #: Kind of a start from a fixed point of the costs of normal forces.
_NEIGHBOUR = "neighbour"  #: Kind of a start near the lowest state.

#: Kinds of starts in which ties and other limited forces use at most a share of their strength. These starts
#: come first if a scene has such forces: a tie at its strength hides states in which it does not yield.
_WEAKER_TIES = {f"ties at {share:g} of their strength": share for share in SEARCH.strength_shares}

#: Function that returns the forces of a start, from the search, the lowest state and a random generator.
_Start = Callable[[Search, ExactState | None, np.random.Generator], np.ndarray | None]

#: Functions of the starts, by kind.
_STARTS: dict[str, _Start] = {
    _RANDOM_FORCES: Search.random_forces,
    _STRESS: Search.with_self_stress,
    "loads": Search.with_other_loads,
    _FIXED: Search.fixed_point,
    _NEIGHBOUR: Search.neighbour,
    **{kind: partial(Search.random_forces, strength_share=share) for kind, share in _WEAKER_TIES.items()},
}

#: Kinds of starts in the plane, in turn. A start from random forces or a neighbour takes a tenth of the time
#: of a load history, and a fixed point a third. Fixed points lead lower if a whole slope slides.
_KINDS = (_RANDOM_FORCES, _NEIGHBOUR, _RANDOM_FORCES, _FIXED)

#: Kinds of starts in space, in turn. Random forces lead lower in less time than load histories do.
_KINDS_IN_SPACE = (_RANDOM_FORCES, _RANDOM_FORCES, _STRESS, _RANDOM_FORCES, "loads")

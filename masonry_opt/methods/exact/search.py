"""The search for lower exact states: other starts, and the neighbourhood of the lowest found, in turn."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import cycle
from math import inf
from typing import TypeVar

import numpy as np

from masonry_opt.answer.answer import Answer
from masonry_opt.answer.reasons import Code, Reason, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import ZERO, is_lower, same
from masonry_opt.methods.exact.refiner import ExactState, Refiner, StateFinder
from masonry_opt.methods.push.compliant import self_stress
from masonry_opt.methods.push.push import Elastic
from masonry_opt.problem.problem import Problem

#: Standard deviation of the logarithm by which random starts change loads and frictions: of loads this, of
#: frictions one between these, so that both near and far states are found.
_LOADS, _FRICTIONS = 0.5, (0.03, 0.3)

#: Further starts of a small scene that may in a row bring no state that was not met before. Of 500 random
#: scenes of 3 to 10 blocks 2 % ended more than 1 % above the lowest state met without further starts, 0.2 %
#: with them, in three to five times the time without them; with 10 in a row 0.7 %.
_NOTHING_NEW = 15

#: A face whose dual is above this share of the largest holds λ up; and share of these which a neighbour lets
#: go of, one at least.
_HOLDS, _LET_GO = 1e-6, 0.02

#: Displacements at which forces of a push are taken: in space softer contacts lead lower.
_STIFF, _STIFF_IN_SPACE = 1e4, 1e2

#: Programs of a fixed point at most, and the relative change of its costs at which it ends.
_FIXED_POINT, _SETTLED = 15, 1e-7

Candidate = tuple[str, ExactState | None]  #: The kind of a start, and the state it led to.


class Met:
    """Exact states met."""

    def __init__(self) -> None:
        self.load_factors: list[float] = []  #: each once
        self.candidates = 0  #: with or without a state
        self.lowest = inf  #: least load factor of a state that tells of the load, kept or not

    def count(self, state: ExactState | Answer | None) -> None:
        """Count a candidate, and its state if it has one."""
        self.candidates += 1
        if state is not None and not any(same(state.load_factor, known) for known in self.load_factors):
            self.load_factors.append(state.load_factor)

    @property
    def _above_zero(self) -> list[float]:
        """Load factors above zero of the different states; all load factors if none lies above zero."""
        return [one for one in self.load_factors if one > ZERO] or self.load_factors

    @property
    def _has_state_below(self) -> bool:
        """True if a state at or below zero lies below all states above zero."""
        return self.lowest <= ZERO and self.lowest < min(self._above_zero) - ZERO

    @property
    def reasons(self) -> list[Reason]:
        """Reasons that count the states above zero, and name the lowest state if it lies at or below zero."""
        found = self._above_zero
        told = {"candidates": self.candidates, "count": len(found), "least": min(found), "most": max(found)}
        below = [reason(Code.BELOW_ZERO, load_factor=self.lowest)] if self._has_state_below else []
        return [reason(Code.STATES_MET, **told), *below]

    def recorded_in(self, solution: Solution) -> Solution:
        """Return a solution that reports the starts, and the exact states that they led to."""
        if not self.load_factors:
            return solution
        beneath = self.lowest if self._has_state_below else inf
        states = len(self._above_zero)
        solution = replace(solution, starts=self.candidates, exact_states=states, below_zero=beneath)
        return solution.telling(*self.reasons)


class Search:
    """Candidates of one problem; its contacts start those of other loads and frictions."""

    def __init__(self, finder: StateFinder, elastic: Elastic, met: Met) -> None:
        self._finder, self._elastic, self.problem, self.met = finder, elastic, finder.problem, met

    def start(self, q: np.ndarray | None) -> ExactState | None:
        """The state that forces (3c,) lead to, if there are any."""
        state = None if q is None else self._finder.state_near(q)
        self.met.count(state)
        return state

    def few(self, lowest: ExactState | None) -> Iterator[ExactState | None]:
        """States of further starts of a small scene, and neighbours of the lowest known, until a number of
        them bring nothing new."""
        known, nothing_new = len(self.met.load_factors), 0
        for _, state in self._series(lowest, 0, _FOR_A_FIRST if lowest is None else _ROUND_OF_SMALL):
            yield state
            before, known = known, len(self.met.load_factors)
            nothing_new = 0 if known > before else nothing_new + 1
            if nothing_new >= _NOTHING_NEW:
                return

    def endless(self, best: ExactState | None, seed: int) -> Iterator[Candidate]:
        """Without end: a start of each kind in turn, then some neighbours of the lowest state."""
        kinds = _ROUND_IN_SPACE if self.problem.layout.round else _ROUND
        return self._series(best, seed + 1, kinds)

    def _series(self, best: ExactState | None, seed: int, kinds: Sequence[str]) -> Iterator[Candidate]:
        """Candidates of these kinds in turn, each with random numbers from seed and number alone."""
        for number, kind in enumerate(cycle(kinds)):
            rng = np.random.default_rng((seed, number))
            q = _STARTS[kind](self, rng) if kind in _STARTS else self._neighbour(best, rng)
            state = self.start(q)
            best = lower_of(best, state)
            yield kind, state

    def _pushed(self, problem: Problem) -> np.ndarray | None:
        until = _STIFF_IN_SPACE if problem.layout.round else _STIFF
        with self._finder.effort.measure("solve"):
            elastic = self._elastic.again_for(problem)
            pushed = elastic.pushed(lambda _: self._finder.check_time(), until, rougher=True)
            state = elastic.at(pushed, until)
        return None if state is None else state.answer.q

    def with_other_friction(self, rng: np.random.Generator) -> np.ndarray | None:
        """Forces of a push with each joint's friction changed."""
        problem = self.problem
        spread = np.exp(rng.uniform(*np.log(_FRICTIONS)))
        factor = np.exp(spread * rng.standard_normal(problem.joints))[problem.sliding]
        friction = np.maximum(problem.friction * factor, problem.dilatancy)
        return self._pushed(replace(problem, law=replace(problem.law, friction=friction)))

    def with_other_loads(self, rng: np.random.Generator) -> np.ndarray | None:
        """Forces of a push with each load changed."""
        problem, sizes = self.problem, (2, self.problem.dead.size)
        dead, live = np.exp(_LOADS * rng.standard_normal(sizes)) * [problem.dead, problem.live]
        return self._pushed(replace(problem, dead=dead, live=live))

    def with_self_stress(self, rng: np.random.Generator) -> np.ndarray | None:
        """Forces of a push from others than those at rest, which the dead load allows."""
        settled = self_stress(self.problem, rng)
        return None if settled is None else self._pushed(replace(self.problem, settled=settled))

    def fixed_point(self, rng: np.random.Generator) -> np.ndarray | None:
        """Forces at which the cost of a normal force is the dilation that Coulomb's joints lack,
        (μ − tan φ₀) |slip| (Acary, Cadoux, Lemaréchal & Malick 2011), from random costs."""
        assert isinstance(self._finder, Refiner)
        problem = self.problem
        closing = problem.friction - problem.dilatancy
        cost = closing * rng.exponential(1.0, len(closing))
        for _ in range(_FIXED_POINT):
            found = self._finder.at_cost(cost)
            if found is None:
                return None
            q, p = found
            last, cost = cost, closing * problem.table.slip_speed(p)
            if np.abs(cost - last).max(initial=0.0) <= _SETTLED * max(1.0, last.max(initial=0.0)):
                break
        return q

    def _neighbour(self, state: ExactState | None, rng: np.random.Generator) -> np.ndarray | None:
        """Forces between a state's and the lower ones allowed by letting go of a few faces that hold λ up."""
        assert isinstance(self._finder, Refiner)
        if state is None or not state.strength.any():
            return None
        holding = np.flatnonzero(state.strength > _HOLDS * state.strength.max())
        drawn = rng.random(self.problem.faces)[holding]
        rates = state.rates.copy()
        rates[holding[drawn <= max(_LET_GO, drawn.min())]] = 0.0
        relaxed = self._finder.least(rates, state.d)
        if relaxed is None:
            return None
        weight = rng.uniform()
        return weight * relaxed.q + (1 - weight) * state.q


_L = TypeVar("_L", ExactState, Answer)


def lower_of(one: _L | None, other: _L | None) -> _L | None:
    """The lower state, of even ones the exact or the first. One at or below zero, where a scene needs no load
    to move, is the lower of two such states alone."""
    if one is None or other is None:
        return one or other
    if one.exact != other.exact and same(one.load_factor, other.load_factor):
        return one if one.exact else other
    if (one.load_factor <= ZERO) != (other.load_factor <= ZERO):
        return other if one.load_factor < other.load_factor else one
    return other if is_lower(other.load_factor, one.load_factor) else one


_STRESS, _FIXED, _NEIGHBOUR = "self-stress", "fixed point", "neighbour"
_STARTS: dict[str, Callable[[Search, np.random.Generator], np.ndarray | None]] = {
    _STRESS: Search.with_self_stress,
    "friction": Search.with_other_friction,
    "loads": Search.with_other_loads,
    _FIXED: Search.fixed_point,
}

#: Turn of the search in the plane. Of other self-stress pushes led as low as of other frictions and loads on
#: 115 scenes, on one lower, and on the slope at its limiting friction in 7 s to what these missed in 120.
_ROUND = tuple(kind for start in (_STRESS, _FIXED) for kind in (start, _NEIGHBOUR, _NEIGHBOUR))

_ROUND_IN_SPACE = ("friction", "loads")  #: In space: of other self-stress states come down to λ = 0 there.

#: Turns on small scenes: while no state is known, and then; a neighbour takes a tenth of a push's time.
_FOR_A_FIRST = (_FIXED, _FIXED, _STRESS)
_ROUND_OF_SMALL = (*(_NEIGHBOUR,) * 3, _STRESS, *(_NEIGHBOUR,) * 3, _FIXED)

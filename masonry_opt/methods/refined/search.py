"""The search for lower exact states: other starts, and the neighbourhood of the lowest found, in turn."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from masonry_opt.methods.mcp.passes import Passes
from masonry_opt.methods.mcp.rules import ATTEMPTS, Rules
from masonry_opt.methods.refined.programs import ExactState, Refiner, is_lower
from masonry_opt.problem.problem import Problem

#: By how much random starts change loads and frictions (standard deviation of the logarithm): loads by this,
#: frictions between these, so that both what is near and what is far is found.
_LOADS, _FRICTIONS = 0.5, (0.03, 0.3)

#: The friction, over its own, of the second of the deterministic starts.
_MORE_FRICTION = 1.1

#: Share of the faces that hold λ up which a neighbour lets go of, one at least.
_LET_GO = 0.02

#: Programs of a fixed point at most, and the relative change of its costs at which it ends.
_FIXED_POINT, _SETTLED = 15, 1e-7

#: Forces are replaced by nearer ones so often at most: what takes longer seldom ends low.
_REPAIRS = 2


@dataclass(frozen=True)
class Candidate:
    """An exact state that was tried, None if its start led to none, and what led to it."""

    origin: str
    state: ExactState | None


def deterministic(refiner: Refiner) -> Iterator[Candidate]:
    """The states of two further passes: with more friction, and by the second set of rules.

    On the walls of Table 1 and random scenes these end lower most often of all single changes tried.
    """
    problem = refiner.problem
    stiffer = replace(problem, friction=_MORE_FRICTION * problem.friction)
    for origin, changed, rules in (("friction", stiffer, ATTEMPTS[0]), ("rules", problem, ATTEMPTS[1])):
        yield Candidate(origin, _settled(refiner, _of_pass(changed, rules)))


def search(refiner: Refiner, best: ExactState | None, seed: int) -> Iterator[Candidate]:
    """Candidates without end: a start of each kind in turn, after each a few neighbours of the lowest state.

    Each has random numbers of its own, from the seed and its number alone.
    """
    for number in count():
        origin = _ROUND[number % len(_ROUND)]
        rng = np.random.default_rng((seed, number))
        if origin in _STARTS:
            q = _STARTS[origin](refiner, rng)
        elif best is not None:
            q = _neighbour(refiner, best, rng)
        else:
            continue
        state = _settled(refiner, q)
        if state is not None and (best is None or is_lower(state, best)):
            best = state
        yield Candidate(origin, state)


def _settled(refiner: Refiner, q: np.ndarray | None) -> ExactState | None:
    return None if q is None else refiner.settled(q, _REPAIRS)


def _of_pass(problem: Problem, rules: Rules = ATTEMPTS[0]) -> np.ndarray | None:
    state = Passes(problem).run(rules)
    return None if state is None else state.q


def _with_other_friction(refiner: Refiner, rng: np.random.Generator) -> np.ndarray | None:
    """Forces of a pass with each joint's friction changed."""
    problem = refiner.problem
    spread = np.exp(rng.uniform(*np.log(_FRICTIONS)))
    factor = np.exp(spread * rng.standard_normal(problem.joints))[problem.sliding]
    return _of_pass(replace(problem, friction=np.maximum(problem.friction * factor, problem.dilatancy)))


def _with_other_loads(refiner: Refiner, rng: np.random.Generator) -> np.ndarray | None:
    """Forces of a pass with each load changed."""
    problem = refiner.problem
    dead, live = (
        load * np.exp(_LOADS * rng.standard_normal(load.size)) for load in (problem.dead, problem.live)
    )
    return _of_pass(replace(problem, dead=dead, live=live))


def _fixed_point(refiner: Refiner, rng: np.random.Generator) -> np.ndarray | None:
    """Forces at which the cost of a normal force is what Coulomb's joints do not dilate, (μ − tan φ₀) |slip|
    (Acary, Cadoux, Lemaréchal & Malick 2011), from random costs."""
    problem = refiner.problem
    k = len(problem.sliding)
    closing = problem.friction - problem.dilatancy
    cost = closing * rng.exponential(1.0, k)
    for _ in range(_FIXED_POINT):
        found = refiner.at_cost(cost)
        if found is None:
            return None
        q, p = found
        last, cost = cost, closing * np.abs(p[k : 2 * k] - p[:k])
        if np.abs(cost - last).max(initial=0.0) <= _SETTLED * max(1.0, last.max(initial=0.0)):
            break
    return q


def _neighbour(refiner: Refiner, state: ExactState, rng: np.random.Generator) -> np.ndarray | None:
    """Forces between a state's and the lower ones that letting go of a few faces that hold λ up allows."""
    if len(state.holding) == 0:
        return None
    dropped = state.holding[rng.random(len(state.holding)) < _LET_GO]
    support = state.support.copy()
    support[dropped if len(dropped) else rng.choice(state.holding)] = False
    relaxed = refiner.least(support, state.d)
    if relaxed is None:
        return None
    weight = rng.uniform()
    return weight * relaxed.q + (1 - weight) * state.q


_NEIGHBOUR = "neighbour"
_STARTS: dict[str, Callable[[Refiner, np.random.Generator], np.ndarray | None]] = {
    "friction": _with_other_friction,
    "loads": _with_other_loads,
    "fixed point": _fixed_point,
}

#: What is tried in turn.
_ROUND = tuple(origin for start in _STARTS for origin in (start, *[_NEIGHBOUR] * 3))

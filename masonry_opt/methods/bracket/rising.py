"""The lower end of a bracket, raised by programs of more and more products."""

import time
from collections.abc import Iterator
from math import inf

import numpy as np

from masonry_opt.answer.acceptance import CLOSED, SMALLEST
from masonry_opt.effort import Effort
from masonry_opt.methods.bracket.bounds import bounds_of, tightened
from masonry_opt.methods.bracket.relaxation import LEAST_TIME, RADII, BoundStep, Distances, relaxed
from masonry_opt.problem.edges import EdgeFactors
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.registry import LpSize

_ABOVE = 1e-4  #: The programs take this share more than the best λ known, so that they have an interior.

#: A program that closes more than this share of the gap is followed by another of the same products, with the
#: limits of forces that it leaves; else by one of more products, which takes three to ten times as long.
_WORTH_REPEATING = 0.5

#: What rates are assumed to sum to, at least, and over those of the state known (on walls 30 to 140).
_LEAST_RATES, _OVER_KNOWN = 100.0, 10.0

_MOST_PRODUCTS = 400_000  #: No program keeps more products than this (memory).


class Rising:
    """A lower bound of λ that rises towards the best λ known.

    Attributes
    ----------
    best: λ > 0 of the lowest state known; whoever finds a lower one puts it here.
    bound: what is proven by now.
    of: largest forces and rates of all states from there up to the best, which the bound assumes in part.
    """

    def __init__(self, problem: Problem, best: float, rates: float, effort: Effort) -> None:
        self._problem, self._effort, self.best, self.bound = problem, effort, best, 0.0
        self.of = bounds_of(problem, a_little_above(best), rates, effort)

    def programs(
        self, ends: float = inf, began: float = 0.0
    ) -> Iterator[tuple[BoundStep, LpSize, list[np.ndarray]]]:
        """Programs of more and more products, until the bracket is closed or time is up: what each proved,
        its size, and joint forces (3c,) that may lead to states lower than the best.

        Below what one program proves there is no state: the next looks above only, where forces have less
        room, and the same products prove more. They are kept while that pays."""
        distances, before = Distances(self._problem), 0
        for radii in RADII:
            near, moves = distances.within(radii)
            products = 12 * int(near.sum()) + 9 * int(moves.sum())
            if products == before or products > _MOST_PRODUCTS:
                continue
            gains = True
            while gains:
                if before and ends - time.perf_counter() < LEAST_TIME:
                    return
                highest, last = a_little_above(self.best), self.bound
                if last > self.of.lowest:
                    self.of = tightened(self.of, self._problem, last, highest, self._effort)
                before, left = products, ends - time.perf_counter()
                told = relaxed(self._problem, highest, self.of, near, moves, left, self._effort)
                proven, forces, size = told
                self.bound, seconds = max(last, min(proven, self.best)), time.perf_counter() - began
                step = BoundStep(proven, self.of.lowest, self.best, *radii, products, seconds)
                yield step, size, [] if closed(self.bound, self.best) else forces
                if closed(self.bound, self.best):
                    return
                gains = self.bound - last > _WORTH_REPEATING * (self.best - last)


def a_little_above(best: float) -> float:
    """Λ of the programs, from the best λ known."""
    return best + _ABOVE * max(abs(best), 1e-3)


def assumed_rates(problem: Problem, d: np.ndarray | None) -> float:
    """What slips and edge openings are assumed to sum to, from the velocities (3b,) of the lowest state."""
    return max(_LEAST_RATES, _OVER_KNOWN * (0.0 if d is None else sum_of_rates(problem, d)))


def sum_of_rates(problem: Problem, d: np.ndarray) -> float:
    """The sum of slips and edge openings under block velocities (3b,)."""
    return float(EdgeFactors(problem).in_edges(problem.rates(d, problem.dilatancy)).sum())


def closed(bound: float, load_factor: float) -> bool:
    """Whether a bracket from a bound to a load factor is closed."""
    return load_factor - bound <= CLOSED * max(abs(load_factor), SMALLEST)

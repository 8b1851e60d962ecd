"""The loop of Gilbert, Casapulla & Ahmed (2006), section 4.2: its six steps and nothing else."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np

from masonry_opt.answer.answer import largest_acting, of_lesser_block
from masonry_opt.errors import OptionError
from masonry_opt.methods.loop.options import LoopParameters
from masonry_opt.problem.problem import Problem, ShearLimits, State
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import Solved, Verdict

_TRIALS = 8  #: How often a trial cohesion that carries no dead load is multiplied by four.

#: So many times what acts on a block, forces elsewhere in its part are no measure for its joints.
_DWARFS = 1e3


@dataclass(frozen=True)
class SubProblem:
    """One linear program of the loop, numbered from 1."""

    number: int
    solved: Solved
    state: State  #: the optimum
    limits: ShearLimits
    alpha: float  #: α of its shear limits; NaN for the first, which has none
    small_cohesion: np.ndarray  #: c⁰ of them, shape (k,)
    stands_still: bool  #: whether λ changed by less than ``tol`` (step 3)


@dataclass(frozen=True)
class LimitUpdate:
    """What the shear limits of the next sub-problem are made of (step 4)."""

    problem: Problem
    last: SubProblem
    alpha: float  #: α of the next
    small_cohesion: np.ndarray  #: c⁰ of the next, shape (k,)
    about: np.ndarray  #: normal forces about which the limits turn, blended by β, shape (c,)

    def limits(self) -> ShearLimits:
        """Step 4: |s| ≤ c⁰ + (1 + α) n μ − α n' μ, n being ``about`` and n' the next normal force.

        With dilatancy, flow opens joints by tan φ₀ − α μ instead of −α μ. Joints that dilate at their
        friction angle are associative: their limits stay as they are.
        """
        problem, mu = self.problem, self.problem.friction
        dilatancy, n = problem.dilatancy_at(self.about), self.about[problem.sliding]
        turns = dilatancy < mu
        slope = np.where(turns, dilatancy - self.alpha * mu, mu)
        added = np.where(turns, self.small_cohesion + (mu - slope) * n, 0.0)
        return ShearLimits(slope, problem.cohesion + added)


def sub_problems(
    problem: Problem, driver: Driver, parameters: LoopParameters
) -> Iterator[SubProblem | Solved]:
    """Steps 1 to 5, until the caller stops (step 3) or a sub-problem has no optimum, of which it is told how
    it ended. Of the driver's model the shear limits alone are changed. Step 6 is :func:`corrected`."""
    alpha, next_alpha = float("nan"), parameters.alpha
    small_cohesion = np.zeros(len(problem.sliding))
    limits = ShearLimits.true(problem)  # step 1: Coulomb's limits, or a trial cohesion
    if parameters.start == "cohesive":
        limits = ShearLimits(small_cohesion, small_cohesion + parameters.trial_cohesion)
    before: State | None = None
    for number in count(1):
        driver.effort.begins(f"sub-problem {number}")
        driver.set_shear_limits(limits)  # step 2
        answer = driver.solve()
        # The trial cohesion is arbitrary: raise it while it is too small to carry the dead load.
        for _ in range(_TRIALS if number == 1 and parameters.start == "cohesive" else 0):
            if answer.solved.verdict is not Verdict.INFEASIBLE:
                break
            limits = ShearLimits(limits.slope, 4 * limits.cohesion)
            driver.set_shear_limits(limits)
            answer = driver.solve()
        state = answer.state
        if state is None:
            yield answer.solved
            return
        change = abs(state.load_factor - before.load_factor) if before else float("inf")
        still = change < parameters.tol * abs(state.load_factor)
        last = SubProblem(number, answer.solved, state, limits, alpha, small_cohesion, still)
        yield last
        if number == 1:
            small_cohesion = parameters.c0 * _largest_nearby(problem, state)[problem.sliding]
        elif still and alpha > parameters.alpha_min:
            next_alpha = parameters.alpha_min  # sliding would still contract by α μ
        alpha = next_alpha  # step 5
        next_alpha = parameters.shrink * alpha if alpha > parameters.alpha_min else parameters.alpha_min
        n, n_before = (problem.normal_forces(of.q) for of in (state, before or state))
        about = parameters.beta * n + (1 - parameters.beta) * n_before
        update = LimitUpdate(problem, last, alpha, small_cohesion, about)
        limits = parameters.revise(update) if parameters.revise else update.limits()  # step 4
        if not isinstance(limits, ShearLimits):
            raise OptionError(f"option 'revise' must return ShearLimits (found {limits!r})")
        before = state


def corrected(problem: Problem, last: SubProblem) -> float:
    """Step 6: λ less what the small cohesion dissipates."""
    state = last.state
    turns = problem.dilatancy_at(problem.normal_forces(state.q)) < problem.friction
    dissipated = np.where(turns, last.small_cohesion, 0.0) @ problem.slip(state.p)
    return state.load_factor - float(dissipated) / problem.live_norm


def _largest_nearby(problem: Problem, state: State) -> np.ndarray:
    """Largest normal force of the part of the scene that each joint belongs to, as far as it does not dwarf
    what acts on the joint's own blocks, shape (c,): the small cohesion must be small for each."""
    largest = np.zeros(problem.part.max() + 1)
    np.maximum.at(largest, problem.part, problem.normal_forces(state.q))
    own = of_lesser_block(problem, largest_acting(problem, state.load_factor, state.q))
    return np.minimum(largest[problem.part], _DWARFS * own)

"""Run the six steps of the loop of Gilbert, Casapulla & Ahmed (2006), section 4.2."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np

from masonry_opt.errors import OptionError
from masonry_opt.methods.loop.options import LoopParameters
from masonry_opt.problem.problem import Problem, ShearLimits, State
from masonry_opt.solution.answer import largest_acting, of_lesser_block
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import Solved, Verdict

#: Largest number of times that a cohesive start raises its cohesion because the first sub-problem is
#: infeasible. If the sub-problem is then still infeasible, the run fails.
_MOST_RAISES = 8

#: Factor by which a cohesive start multiplies its cohesion each time that the first sub-problem is
#: infeasible.
_RAISE_FACTOR = 4

#: A joint's small cohesion is proportional to the largest normal force in its connected component. This force
#: counts only up to this multiple of the largest force on the joint's own blocks. Without the limit, very
#: large forces on other blocks could make the cohesion too large.
_LARGEST_FORCE_RATIO = 1e3


@dataclass(frozen=True)
class SubProblem:
    """Solved sub-problem: the linear program of one iteration of the loop, with its optimum."""

    number: int  #: number of the sub-problem in its run, from 1
    solved: Solved  #: status and time of the solver
    state: State  #: the optimum
    limits: ShearLimits  #: the shear limits of the program
    alpha: float  #: slope α of the shear limits; NaN for the first sub-problem, whose limits have no α
    #: Small cohesion that the program adds to the shear limit of each joint that can slide, shape (k,). It is
    #: 0 at joints that dilate at their friction angle.
    added_cohesion: np.ndarray
    stands_still: bool  #: True if λ has converged: its relative change is below option ``tol``


@dataclass(frozen=True)
class LimitUpdate:
    """Data for the shear limits of the next sub-problem: step 4 of the paper's section 4.2."""

    problem: Problem  #: the problem of the loop
    last: SubProblem  #: the last sub-problem that was solved
    alpha: float  #: α of the next sub-problem
    #: Small cohesion c⁰ of each joint that can slide, shape (k,). The next sub-problem adds it to the shear
    #: limits of joints with less dilatancy than friction.
    small_cohesion: np.ndarray
    #: Normal forces n about which the next shear limits are linearised, shape (c,). They are weighted means
    #: of the normal forces of the last two sub-problems, with weight β for the later sub-problem. Where the
    #: next normal force equals n, the shear limit is Coulomb's limit plus the small cohesion, if any.
    about: np.ndarray

    @property
    def dilatancy(self) -> np.ndarray:
        """Dilatancy of each joint that can slide, under the normal forces ``about``, shape (k,)."""
        return self.problem.dilatancy_at(self.about)

    @property
    def added_cohesion(self) -> np.ndarray:
        """Small cohesion that :meth:`limits` adds to each shear limit, shape (k,).

        It is 0 at joints that dilate at their friction angle, because their limits do not change.
        """
        return np.where(self.dilatancy < self.problem.friction, self.small_cohesion, 0.0)

    def limits(self) -> ShearLimits:
        """Return the shear limits of the next sub-problem: step 4 of the paper's section 4.2.

        The limits are |s| ≤ c⁰ + (1 + α) n μ − α n' μ. The normal forces n are ``about``, and n' are the
        normal forces of the next sub-problem.

        With dilatancy, the flow opens joints by tan φ₀ − α μ instead of −α μ per unit slip. Joints that
        dilate at their friction angle are associative: their limits do not change.
        """
        problem, mu = self.problem, self.problem.friction
        n, dilatancy = self.about[problem.sliding], self.dilatancy
        slope = np.where(dilatancy < mu, dilatancy - self.alpha * mu, mu)
        return ShearLimits(slope, problem.cohesion + (self.added_cohesion + (mu - slope) * n))


def sub_problems(
    problem: Problem, driver: Driver, parameters: LoopParameters
) -> Iterator[SubProblem | Solved]:
    """Solve the sub-problems of the loop one after another, by steps 1 to 5 of the paper's section 4.2.

    The caller decides when to stop, which is step 3. If a sub-problem has no optimum, the solver's result is
    yielded in its place, and the loop ends. Only the shear limits of the driver's model are changed. The
    function ``corrected`` is step 6. Raises OptionError if the option ``revise`` returns no ShearLimits.
    """
    alpha, next_alpha = float("nan"), parameters.alpha
    small_cohesion = added_cohesion = np.zeros(len(problem.sliding))
    # Step 1: begin with Coulomb's limits or, for the cohesive start, with a trial cohesion.
    limits = ShearLimits.true(problem)
    if parameters.start == "cohesive":
        limits = ShearLimits(small_cohesion, small_cohesion + parameters.trial_cohesion)
    previous: State | None = None
    for number in count(1):
        driver.effort.begins(f"sub-problem {number}")
        driver.set_shear_limits(limits)  # step 2
        answer = driver.solve()
        # Raise the trial cohesion as long as the first sub-problem is infeasible: the cohesion is then too
        # small to carry the dead load.
        for _ in range(_MOST_RAISES if number == 1 and parameters.start == "cohesive" else 0):
            if answer.solved.verdict is not Verdict.INFEASIBLE:
                break
            limits = ShearLimits(limits.slope, _RAISE_FACTOR * limits.cohesion)
            driver.set_shear_limits(limits)
            answer = driver.solve()
        state = answer.state
        if state is None:
            yield answer.solved
            return
        change = abs(state.load_factor - previous.load_factor) if previous else float("inf")
        stands_still = change < parameters.tol * abs(state.load_factor)
        last = SubProblem(number, answer.solved, state, limits, alpha, added_cohesion, stands_still)
        yield last
        if number == 1:
            small_cohesion = parameters.c0 * _largest_nearby(problem, state)[problem.sliding]
        elif stands_still and alpha > parameters.alpha_min:
            # λ has converged. Continue with the smallest α, so that sliding joints contract least: by α μ per
            # unit slip.
            next_alpha = parameters.alpha_min
        alpha = next_alpha  # step 5
        next_alpha = parameters.shrink * alpha if alpha > parameters.alpha_min else parameters.alpha_min
        n = problem.normal_forces(state.q)
        previous_n = problem.normal_forces((previous or state).q)
        about = parameters.beta * n + (1 - parameters.beta) * previous_n
        update = LimitUpdate(problem, last, alpha, small_cohesion, about)
        limits = parameters.revise(update) if parameters.revise else update.limits()  # step 4
        added_cohesion = update.added_cohesion
        if not isinstance(limits, ShearLimits):
            raise OptionError(f"the function of option 'revise' must return ShearLimits (found {limits!r})")
        previous = state


def corrected(problem: Problem, last: SubProblem) -> float:
    """Return λ without the contribution of the small cohesion that the loop adds to the shear limits.

    This is step 6 of the paper's section 4.2.
    """
    state = last.state
    dissipated = last.added_cohesion @ problem.slip(state.p)
    return state.load_factor - float(dissipated) / problem.live_norm


def _largest_nearby(problem: Problem, state: State) -> np.ndarray:
    """Return the force to which the small cohesion of each joint is proportional, shape (c,).

    The force is the largest normal force in the joint's connected component, but at most
    ``_LARGEST_FORCE_RATIO`` times the largest force on the joint's own blocks. This limit keeps the cohesion
    small if other blocks carry very large forces.
    """
    largest = np.zeros(problem.part.max() + 1)
    np.maximum.at(largest, problem.part, problem.normal_forces(state.q))
    force_on_blocks = of_lesser_block(problem, largest_acting(problem, state.load_factor, state.q))
    return np.minimum(largest[problem.part], _LARGEST_FORCE_RATIO * force_on_blocks)

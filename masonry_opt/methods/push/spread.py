"""What the load to expect owes to what nobody knows: how stiff contacts are, and the self-stress at rest."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from scipy.optimize import linprog

from masonry_opt.answer.reasons import Code, Reason, reason
from masonry_opt.methods.push.push import Elastic
from masonry_opt.problem.problem import Problem

_STIFFNESS = 0.5  #: Standard deviation of the logarithm of a contact's stiffness.


def spread(elastic: Elastic, draws: int) -> Reason:
    """The ranges of the load to expect over so many draws of stiffness, and of self-stress: vertices of what
    the dead load allows, and mixtures of two. None where no push comes to a ray; and how many come to none.
    """
    rng = np.random.default_rng(0)
    stiffness, by_stiffness = _range(elastic.drawn(_STIFFNESS, rng) for _ in range(draws))
    stress, by_stress = _range(_stressed(elastic, number, rng) for number in range(draws))
    without = 2 * draws - by_stiffness - by_stress
    return reason(Code.SPREAD, draws=draws, stiffness=stiffness, stress=stress, without=without)


def _stressed(elastic: Elastic, number: int, rng: np.random.Generator) -> Elastic | None:
    one, other = (self_stress(elastic.problem, rng) for _ in range(2))
    if one is None or other is None:
        return None
    share = rng.uniform() if number % 2 else 1.0
    return elastic.again_for(replace(elastic.problem, settled=share * one + (1 - share) * other))


def _range(drawn: Iterable[Elastic | None]) -> tuple[tuple[float, float] | None, int]:
    """Least and largest load to expect, and of how many."""
    pushes = (one.pushed() for one in drawn if one is not None)
    peaks = [float(pushed.peak) for pushed in pushes if pushed.peak is not None]
    return ((min(peaks), max(peaks)) if peaks else None), len(peaks)


def self_stress(problem: Problem, rng: np.random.Generator) -> np.ndarray | None:
    """Forces (3c + t,) in equilibrium with the dead load, a vertex of those within yield, in space of its
    sides: of least random cost of its normal forces; None if there are none."""
    cost = rng.exponential(1.0, problem.B.shape[1])
    points = problem.layout.points * problem.joints
    cost[points:] = 0.0
    found = linprog(
        cost,
        A_ub=-problem.true_yield,
        b_ub=problem.face_cohesion,
        A_eq=problem.B,
        b_eq=-problem.dead,
        bounds=(None, None),
    )
    q: np.ndarray | None = found.x
    return q

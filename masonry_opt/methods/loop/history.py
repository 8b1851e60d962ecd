"""What is recorded of each sub-problem of the loop."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from masonry_opt.methods.loop.steps import SubProblem
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import State


@dataclass(frozen=True)
class Iteration:
    """One sub-problem of the loop.

    Attributes
    ----------
    iteration: counted from 1.
    load_factor: λ of the sub-problem, uncorrected.
    alpha: slope of its shear limit over μ (NaN for the first).
    change: largest change of a normal force since the last one, in median block weights.
    violation: largest violation of the true Coulomb law, in median block weights.
    raising: work against the dead load, in units of λ (paper, Fig. 12).
    sliding: energy dissipated in the sub-problem's sliding, in units of λ.
    coulomb_sliding: the same slips against the true law's shear limit (the paper's corrected
        energy), in units of λ.
    mismatch: energy by which sliding joints are off the true law (the small cohesion apart), each
        counted for itself, in units of λ.
    seconds: the solver's time.
    attempt, remedy: which run of the loop it belongs to, and the option that was changed for that run.
    solved: the sub-problem itself, for whoever follows the loop; not kept in a history.
    """

    iteration: int
    load_factor: float
    alpha: float
    change: float
    violation: float
    raising: float
    sliding: float
    coulomb_sliding: float
    mismatch: float
    seconds: float
    attempt: int = 1
    remedy: str = ""
    solved: SubProblem | None = field(default=None, repr=False)


def recorded(problem: Problem, last: SubProblem, before: State | None) -> Iteration:
    """The record of a sub-problem that was solved, and the state before it."""
    state, limits = last.state, last.limits
    assert state is not None  # only a solved sub-problem is recorded
    n, slip = problem.normal_forces(state.q), problem.slip(state.p)
    coulomb = ShearLimits.true(problem).at(n[problem.sliding])
    limit = limits.at(n[problem.sliding]) - last.small_cohesion
    change = np.nan if before is None else np.abs(n - problem.normal_forces(before.q)).max()

    def in_units_of_load_factor(energy: float) -> float:
        return float(energy) / problem.live_norm

    return Iteration(
        iteration=last.number,
        load_factor=state.load_factor,
        alpha=last.alpha,
        change=float(change),
        violation=max(-float(problem.slacks(state.q).min()), 0.0),
        raising=in_units_of_load_factor(-problem.dead @ state.d),
        sliding=in_units_of_load_factor(limits.cohesion @ slip),
        coulomb_sliding=in_units_of_load_factor(coulomb @ slip),
        mismatch=in_units_of_load_factor(np.abs(limit - coulomb) @ slip),
        seconds=last.solved.seconds,
        solved=last,
    )

"""Draw random forces in equilibrium, from which the two linear programs lead to different exact states."""

from math import inf

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.methods.exact.refiner import programs
from masonry_opt.methods.exact.settings import SearchSettings
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.highs import HighsSession
from masonry_opt.solvers.registry import Verdict

#: Key of ``result.solvers`` under which the solvers of the programs that find random forces are listed.
_RANDOM_FORCES_PURPOSE = "random forces"


class RandomForces:
    """Generator of random joint forces in equilibrium and within the yield conditions at a load factor.

    A draw is a vertex of the set of admissible forces: it minimises the sum of the slacks of a random set of
    yield conditions. Draws below the lowest known load factor lead to states that a load history misses. In
    space a polygon limits the shear.
    """

    def __init__(self, problem: Problem, effort: Effort, settings: SearchSettings) -> None:
        self._problem, self._settings = problem, settings
        self._statics = HighsSession(programs(problem)[0], effort, _RANDOM_FORCES_PURPOSE)

    def largest_load_factor(self, seconds: float = inf) -> float | None:
        """Return the largest λ with admissible forces in equilibrium, or None if no largest λ is found."""
        self._statics.set_bounds("load_factor", 0.0, inf)
        self._statics.set_costs("load_factor", np.array([-1.0]))
        self._statics.set_costs("q", np.zeros(self._problem.B.shape[1]))
        if self._statics.solve(seconds) is not Verdict.OPTIMAL:
            return None
        return float(self._statics.values("load_factor")[0])

    def draw(self, load_factor: float, rng: np.random.Generator, seconds: float = inf) -> np.ndarray | None:
        """Return random forces in equilibrium at a load factor, or None if no forces are found in time.

        The forces have shape (3c + t,).
        """
        problem, settings = self._problem, self._settings
        share = rng.uniform(*settings.yielding_shares)
        yields = rng.random(problem.faces) < share
        self._statics.set_bounds("load_factor", load_factor, load_factor)
        self._statics.set_costs("load_factor", np.zeros(1))
        self._statics.set_costs("q", problem.true_yield.T @ (yields / problem.steep))
        if self._statics.solve(seconds) is not Verdict.OPTIMAL:
            return None
        return self._statics.values("q")

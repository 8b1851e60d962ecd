"""The load history: load factor, displacement and events of each increment."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_opt.brief import brief


@dataclass(frozen=True)
class LoadStep:
    """Equilibrium at the end of a load increment.

    Contacts are the joints of the problem; in space, they are the corners of the shared polygons.
    """

    iteration: int  #: number of the step, counted from 1; the first step is under the dead load alone
    load_factor: float  #: load factor λ at the end of the increment
    #: Displacement of the live load: the work of the live load divided by Σ|f_L|. The unit of displacement is
    #: the closing of an elastic joint of mean length under the mean contact force of the dead load.
    displacement: float
    is_jump: bool  #: True if the step is a jump: the blocks came to rest after a damped motion
    sliding: np.ndarray  #: True for contacts that are pressed and at their friction limit, shape (c,)
    #: True for open contacts, shape (c,). In the plane, a joint is open if at least one of its ends is open.
    #: In space, a contact is open if it has no normal force.
    open: np.ndarray
    d: np.ndarray  #: block displacements, zero at equilibrium under the dead load, shape (3b,)
    #: Forces of the c contacts and of the t ties and other forces with limits, in the problem's order, shape
    #: (3c + t,).
    forces: np.ndarray

    __repr__ = brief


@dataclass(frozen=True)
class LoadHistory:
    """Load steps in order, from the dead load alone to the end of the analysis.

    The load never decreases, so the load–displacement curve has jumps instead of falling branches.
    """

    steps: tuple[LoadStep, ...] = ()

    __repr__ = brief

    @cached_property
    def load_factors(self) -> np.ndarray:
        """Load factor of each step, shape (steps,)."""
        return np.array([step.load_factor for step in self.steps])

    @cached_property
    def displacements(self) -> np.ndarray:
        """Displacement of the live load at each step, shape (steps,).

        See ``LoadStep.displacement`` for the definition and the unit.
        """
        return np.array([step.displacement for step in self.steps])

    @property
    def jumps(self) -> int:
        """Number of jumps. A jump is a load step that ends after a damped motion of the blocks."""
        return sum(step.is_jump for step in self.steps)

    def state_at(self, load_factor: float) -> tuple[np.ndarray, np.ndarray]:
        """Return block displacements and joint forces at a given load factor.

        The shapes are (3b,) and (3c + t,). The values are interpolated linearly between load steps. This is
        exact if no contact changes between the two steps.

        Raises
        ------
        ValueError
            If the load factor is negative or above the last one.
        """
        if not 0 <= load_factor <= self.steps[-1].load_factor:
            raise ValueError(
                f"the load history does not contain the load factor {load_factor:.6g}: "
                f"choose a load factor from 0 to {self.steps[-1].load_factor:.6g}"
            )
        after = int(np.searchsorted(self.load_factors, load_factor))
        if self.load_factors[after] == load_factor:
            return self.steps[after].d, self.steps[after].forces
        low, high = self.steps[after - 1], self.steps[after]
        share = (load_factor - low.load_factor) / (high.load_factor - low.load_factor)
        return low.d + share * (high.d - low.d), low.forces + share * (high.forces - low.forces)

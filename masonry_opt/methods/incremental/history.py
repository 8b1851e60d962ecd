"""The load history: load factor, displacement and events of each increment."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_opt.methods.incremental.contact_law import Response


@dataclass(frozen=True)
class LoadStep:
    """Equilibrium at the end of a load increment."""

    load_factor: float
    displacement: float  #: of the live load, in elastic displacements
    is_jump: bool  #: True if the blocks came to rest after a damped motion
    begin_to_slide: np.ndarray  #: indices of joints, since the step before
    begin_to_open: np.ndarray
    begin_to_stick: np.ndarray  #: indices of joints that press without sliding, and did not before
    d: np.ndarray  #: displacements of the blocks since the dead load, shape (3b,)
    forces: np.ndarray  #: joint forces in the problem's order, shape (3c + t,)


def load_step(
    load_factor: float,
    displacement: float,
    is_jump: bool,
    before: Response | None,
    now: Response,
    d: np.ndarray,
    forces: np.ndarray,
) -> LoadStep:
    """Return the step between two responses of the contacts; the first step has no events."""
    last = now if before is None else before
    begin_to_slide = np.flatnonzero(now.sliding & ~last.sliding)
    begin_to_open = np.flatnonzero(now.open & ~last.open)
    begin_to_stick = np.flatnonzero(~(now.sliding | now.open) & (last.sliding | last.open))
    return LoadStep(
        load_factor, displacement, is_jump, begin_to_slide, begin_to_open, begin_to_stick, d, forces
    )


@dataclass(frozen=True)
class LoadHistory:
    """Load steps in order, the first under the dead load alone.

    Under a growing load the load-displacement curve has jumps, not falling branches.
    """

    steps: tuple[LoadStep, ...] = ()

    @cached_property
    def load_factors(self) -> np.ndarray:
        """Load factors, shape (steps,)."""
        return np.array([step.load_factor for step in self.steps])

    @cached_property
    def displacements(self) -> np.ndarray:
        """Displacements of the live load, in elastic displacements, shape (steps,)."""
        return np.array([step.displacement for step in self.steps])

    @property
    def jumps(self) -> int:
        """Number of jumps."""
        return sum(step.is_jump for step in self.steps)

    def state_at(self, load_factor: float) -> tuple[np.ndarray, np.ndarray]:
        """Return block displacements (3b,) and joint forces (3c + t,) at a load factor.

        They are interpolated between load steps: exact where no contact changes between them.

        Raises
        ------
        ValueError
            If the load factor is negative or above the last one.
        """
        if not 0 <= load_factor <= self.steps[-1].load_factor:
            raise ValueError(f"load factor {load_factor:.6g} is not in [0, {self.steps[-1].load_factor:.6g}]")
        after = int(np.searchsorted(self.load_factors, load_factor))
        if self.load_factors[after] == load_factor:
            return self.steps[after].d, self.steps[after].forces
        low, high = self.steps[after - 1], self.steps[after]
        share = (load_factor - low.load_factor) / (high.load_factor - low.load_factor)
        return low.d + share * (high.d - low.d), low.forces + share * (high.forces - low.forces)

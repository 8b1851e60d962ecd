"""The law of the joints: which slide and crush, and at what forces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Law:
    """Friction and strength of the joints that have any limit.

    Attributes
    ----------
    sliding: indices of the joints that can slide (friction is limited), shape (k,).
    friction, dilatancy: μ and tan φ₀ of the joints that can slide, shape (k,).
    cohesion: of the joints that can slide, as a force (per unit length × L), shape (k,).
    dilatancy_force: normal forces up to which the dilatancy is whole and from which there is none (``inf``
        where it does not depend on them), shape (k, 2).
    crushing: indices of the joints of limited strength, shape (l,).
    crushing_force: f_c L, the normal force that crushes all of such a joint, shape (l,).
    """

    sliding: np.ndarray
    friction: np.ndarray
    cohesion: np.ndarray
    dilatancy: np.ndarray
    dilatancy_force: np.ndarray
    crushing: np.ndarray
    crushing_force: np.ndarray

    @property
    def dilatancy_depends_on_stress(self) -> bool:
        """Whether the dilatancy of any joint falls with its normal force."""
        return bool((np.isfinite(self.dilatancy_force[:, 1]) & (self.dilatancy != 0)).any())

    def dilatancy_at(self, n: np.ndarray) -> np.ndarray:
        """tan φ₀ of the joints that can slide, shape (k,), under normal forces n of all joints, shape (c,)
        (section 6.5)."""
        depends = np.isfinite(self.dilatancy_force[:, 1])
        full, none = self.dilatancy_force[depends].T
        share = np.ones(len(self.sliding))
        share[depends] = np.clip((none - n[self.sliding][depends]) / (none - full), 0.0, 1.0)
        return self.dilatancy * share

    def in_units_of(self, force: float) -> Law:
        """The same law with forces in units of ``force``."""
        return replace(
            self,
            cohesion=self.cohesion / force,
            dilatancy_force=self.dilatancy_force / force,
            crushing_force=self.crushing_force / force,
        )

"""Laws of joints: friction by senses of sliding or by the cone, strength by chords or by the parabola.
Cone and parabola have the faces of their sides and chords (see :class:`~.faces.Faces`); slacks and energy are
by the curve."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from masonry_opt.problem.faces import CHORDS, Layout, crushing_energy


class _Limited:
    """A law of joints."""

    conic = False  #: whether it is a curve, for solvers of conic programs

    def __init__(self, layout: Layout, law: "Law") -> None:
        self.layout, self.law = layout, law


class Sides(_Limited):
    """Coulomb friction with cohesion by senses of sliding, in space sides of a polygon inside the cone.

    factor (c + μ n) − e·s ≥ 0    for each sense e
    """

    @property
    def word(self) -> str:
        """What a result calls it; nothing in the plane, where there is no other."""
        return self.layout.word

    def energy(self, z: np.ndarray, slides: np.ndarray, n: np.ndarray, shears: np.ndarray) -> float:
        """Energy of sliding short of yield: slacks and rates (senses, k), n (k,) and shears (shears, k)."""
        return float(np.abs(z * slides).sum())

    def speed(self, slides: np.ndarray) -> np.ndarray:
        """What the shear limit dissipates at rates of the senses (senses, k), over it, shape (k,)."""
        return np.asarray(self.layout.factor * slides.sum(axis=0))


class Cone(Sides):
    """The cone of friction in space, c + μ n ≥ |(s, t)|, in each of its senses."""

    conic = True
    word = "cone"

    def slacks(self, n: np.ndarray, shears: np.ndarray) -> np.ndarray:
        """Its slack in all senses, c + μ n − |(s, t)|, shape (k,)."""
        return self._limit(n) - np.hypot(*shears)

    def energy(self, z: np.ndarray, slides: np.ndarray, n: np.ndarray, shears: np.ndarray) -> float:
        work = (shears * (self.layout.senses.T @ slides)).sum(axis=0)
        return float(np.abs(self._limit(n) * self.speed(slides) - work).sum())

    def speed(self, slides: np.ndarray) -> np.ndarray:
        return np.hypot(*(self.layout.senses.T @ slides))

    def _limit(self, n: np.ndarray) -> np.ndarray:
        return self.law.cohesion + self.law.friction * n


class Chords(_Limited):
    """Limited strength by chords of the parabola at both points (see :data:`~.faces.CHORDS`)."""

    word = "chords"

    def energy(self, z: np.ndarray, p: np.ndarray, at_points: np.ndarray) -> float:
        """Energy of crushing short of yield: slacks and rates (2, l, chords), and n at points (2, l)."""
        return float(np.abs(z * p).sum())


class Parabola(Chords):
    """The parabola itself, 2 n₁, 2 n₂ ≥ n² / (f_c L): the paper's |m| ≤ L/2 (n − n² / (f_c L))."""

    conic = True
    word = "parabola"

    def slacks(self, at_points: np.ndarray) -> np.ndarray:
        """Its slack at each point in all chords, shape (2, l)."""
        slacks: np.ndarray = self.layout.points * at_points
        return slacks - at_points.sum(axis=0) ** 2 / self.law.crushing_force

    def energy(self, z: np.ndarray, p: np.ndarray, at_points: np.ndarray) -> float:
        first, second = at_points
        opening, turning = (p.sum(axis=0) * CHORDS.slope).sum(axis=1), (p[1] - p[0]).sum(axis=1)
        given = crushing_energy(opening, turning) * self.law.crushing_force
        taken = -(first + second) * opening - (second - first) * turning
        return float(np.abs(given - taken).sum())


class Forms(NamedTuple):
    """The laws of friction and of strength."""

    friction: type[Sides] = Sides
    strength: type[Chords] = Chords


BY_FACES = Forms()  #: As linear programs take them.


@dataclass(frozen=True)
class Law:
    """Friction and strength of the joints that have any limit, and limits of forces."""

    sliding: np.ndarray  #: indices of the joints that can slide (friction is limited), shape (k,)
    friction: np.ndarray  #: μ of the joints that can slide, shape (k,)
    cohesion: np.ndarray  #: of the joints that can slide, as a force (per unit length × L), shape (k,)
    dilatancy: np.ndarray  #: tan φ₀ of the joints that can slide, shape (k,)
    #: Normal forces up to which the dilatancy is whole, and from which there is none (``inf``: it does not
    #: depend on them), shape (k, 2).
    dilatancy_force: np.ndarray
    crushing: np.ndarray  #: indices of the joints of limited strength, shape (l,)
    crushing_force: np.ndarray  #: f_c L, the normal force that crushes all of such a joint, shape (l,)
    #: Limits of the limited forces, ±``inf`` where there is none, shape (t,).
    lowest: np.ndarray = field(default_factory=lambda: np.zeros(0))
    highest: np.ndarray = field(default_factory=lambda: np.zeros(0))
    forms: Forms = BY_FACES  #: by which laws friction and strength are measured

    @property
    def dilatancy_depends_on_stress(self) -> bool:
        """Whether the dilatancy of any joint falls with its normal force."""
        return bool((np.isfinite(self.dilatancy_force[:, 1]) & (self.dilatancy != 0)).any())

    def dilatancy_at(self, n: np.ndarray) -> np.ndarray:
        """tan φ₀ of those that can slide, (k,), under normal forces n of all joints, (c,): section 6.5."""
        depends = np.isfinite(self.dilatancy_force[:, 1])
        full, none = self.dilatancy_force[depends].T
        share = np.ones(len(self.sliding))
        share[depends] = np.clip((none - n[self.sliding][depends]) / (none - full), 0.0, 1.0)
        return self.dilatancy * share

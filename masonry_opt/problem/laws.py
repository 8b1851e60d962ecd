"""Define the laws of joints: friction by a polygon or a cone, strength by chords or a parabola.

A problem with a cone or a parabola has the same unknowns as with a polygon or chords (see
:class:`~.faces.Faces`). Only its slacks and complementarity errors are computed from the cone or the
parabola itself.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.problem.faces import CHORDS, Layout, crushing_energy


class _Limited:
    """Base class of the friction laws and the strength laws, which compute complementarity errors."""

    conic = False  #: True if the law is a cone or a parabola, which needs a conic solver

    def __init__(self, layout: Layout, law: "Law") -> None:
        self.layout, self.law = layout, law


class Sides(_Limited):
    """Coulomb friction with cohesion, written as one linear condition for each sense of sliding.

        factor (c + μ n) − e·s ≥ 0

    Here e is the unit vector of the sense, and s the shear force. In space the senses are the sides of a
    polygon inside the friction cone, and ``factor`` reduces the shear limit to this polygon. In the plane,
    ``factor`` is 1.
    """

    @property
    def word(self) -> str:
        """Return the name of the friction law in results; empty in the plane, which has only one law."""
        return self.layout.word

    def energies(self, z: np.ndarray, slides: np.ndarray, n: np.ndarray, shears: np.ndarray) -> np.ndarray:
        """Return the complementarity errors of sliding, one energy for each sense of sliding of each joint.

        The error is the rate of sliding times the slack of the shear limit. It is zero if a joint slides only
        at its shear limit. The shape is (senses, k) for linear conditions and (k,) for a cone.

        Parameters
        ----------
        z, slides : ndarray, shape (senses, k)
            Slacks and rates of the senses of sliding.
        n : ndarray, shape (k,)
            Normal forces.
        shears : ndarray, shape (shears, k)
            Shear forces.
        """
        return np.abs(z * slides)

    def speed(self, slides: np.ndarray) -> np.ndarray:
        """Return the slip rate of each joint, shape (k,): the sum of its rates in all senses of sliding.

        ``slides`` has shape (senses, k). In space the sum is multiplied by ``factor``. The slip rate times
        the shear limit is the dissipated power.
        """
        return np.asarray(self.layout.factor * slides.sum(axis=0))


class Cone(Sides):
    """Coulomb friction with cohesion in space, as the cone |(s, t)| ≤ c + μ n."""

    conic = True
    word = "cone"

    def slacks(self, n: np.ndarray, shears: np.ndarray) -> np.ndarray:
        """Return the slack c + μ n − |(s, t)| of the friction cone of each joint, shape (k,).

        All senses of sliding share this slack.
        """
        return self._limit(n) - np.hypot(*shears)

    def energies(self, z: np.ndarray, slides: np.ndarray, n: np.ndarray, shears: np.ndarray) -> np.ndarray:
        """Return the complementarity error of sliding at each joint, shape (k,), from the friction cone.

        The error is the difference between the energy that sliding dissipates and the work of the shear
        forces. See :meth:`Sides.energies`.
        """
        work = (shears * (self.layout.senses.T @ slides)).sum(axis=0)
        return np.abs(self._limit(n) * self.speed(slides) - work)

    def speed(self, slides: np.ndarray) -> np.ndarray:
        """Return the magnitude of the slip rate of each joint, shape (k,)."""
        return np.hypot(*(self.layout.senses.T @ slides))

    def _limit(self, n: np.ndarray) -> np.ndarray:
        return self.law.cohesion + self.law.friction * n


class Chords(_Limited):
    """Limited compressive strength, approximated by chords of the moment parabola.

    The coefficients of the chords are :data:`~.faces.CHORDS`.
    """

    word = "chords"

    def energies(self, z: np.ndarray, p: np.ndarray, at_points: np.ndarray) -> np.ndarray:
        """Return the complementarity errors of crushing, one energy for each chord at each contact point.

        The error is the rate of crushing times the slack of the strength limit. It is zero if a joint crushes
        only at its strength limit. The shape is (2, l, chords) for chords and (l,) for the parabola.

        Parameters
        ----------
        z, p : ndarray, shape (2, l, chords)
            Slacks and rates of the chords.
        at_points : ndarray, shape (2, l)
            Normal forces at the points of the joints.
        """
        return np.abs(z * p)


class Parabola(Chords):
    """Limited compressive strength: the parabola that limits the moment, without approximation by chords.

    The parabola is |m| ≤ L/2 (n − n² / (f_c L)). In normal forces at the contact points, the condition
    is 2 n₁, 2 n₂ ≥ n² / (f_c L).
    """

    conic = True
    word = "parabola"

    def slacks(self, at_points: np.ndarray) -> np.ndarray:
        """Return the slack of the crushing condition at both contact points of each joint, shape (2, l).

        All chords of a contact point have this slack.
        """
        slacks: np.ndarray = self.layout.points * at_points
        return slacks - at_points.sum(axis=0) ** 2 / self.law.crushing_force

    def energies(self, z: np.ndarray, p: np.ndarray, at_points: np.ndarray) -> np.ndarray:
        """Return the complementarity error of crushing at each joint, shape (l,), from the parabola.

        The error is the difference between the energy that crushing dissipates and the work of the joint's
        forces. See :meth:`Chords.energies`.
        """
        first, second = at_points
        opening = (p.sum(axis=0) * CHORDS.slope).sum(axis=1)
        turning = (p[1] - p[0]).sum(axis=1)
        dissipated = crushing_energy(opening, turning) * self.law.crushing_force
        work = -(first + second) * opening - (second - first) * turning
        return np.abs(dissipated - work)


class Forms(NamedTuple):
    """Pair of classes: the first evaluates the friction law, the second evaluates the strength law."""

    friction: type[Sides] = Sides
    strength: type[Chords] = Chords


#: Classes of the friction and strength laws in linear programs: a polygon for friction, chords for strength.
BY_FACES = Forms()


@dataclass(frozen=True)
class Law:
    """Friction and strength of the joints, and limits of some other forces, in dimensionless units.

    The other forces have lower and upper limits, and are called limited forces: the forces of ties, props and
    settling supports, and earth pressures.
    """

    #: Indices of the joints that can slide, which have a finite friction coefficient, shape (k,).
    sliding: np.ndarray
    friction: np.ndarray  #: friction coefficient μ of the joints that can slide, shape (k,)
    #: Cohesion of the joints that can slide, as a force (cohesive stress × joint area), shape (k,).
    cohesion: np.ndarray
    dilatancy: np.ndarray  #: dilatancy tan φ₀ of the joints that can slide, shape (k,)
    #: Two normal forces for each joint that can slide, shape (k, 2). The dilatancy is full up to the first
    #: force, falls linearly up to the second force, and is zero above the second force. Both forces are
    #: ``inf`` if the dilatancy does not depend on the normal force.
    dilatancy_force: np.ndarray
    crushing: np.ndarray  #: indices of the joints of limited strength, shape (l,)
    crushing_force: np.ndarray  #: normal force f_c L at which the whole joint crushes, shape (l,)
    #: Lower limits of the limited forces, shape (t,); −``inf`` for a force without lower limit.
    lowest: np.ndarray = field(default_factory=lambda: np.zeros(0))
    #: Upper limits of the limited forces, shape (t,); ``inf`` for a force without upper limit.
    highest: np.ndarray = field(default_factory=lambda: np.zeros(0))
    #: Classes that evaluate friction (polygon or cone) and strength (chords or parabola).
    forms: Forms = BY_FACES

    __repr__ = brief

    @property
    def dilatancy_depends_on_stress(self) -> bool:
        """Return True if the dilatancy of at least one joint falls with its normal force."""
        return bool((np.isfinite(self.dilatancy_force[:, 1]) & (self.dilatancy != 0)).any())

    def dilatancy_at(self, n: np.ndarray) -> np.ndarray:
        """Return the dilatancy tan φ₀ of each joint that can slide, under given normal forces, shape (k,).

        ``n`` are the normal forces of all joints, shape (c,). By section 6.5 of the paper, the dilatancy
        falls linearly between the two forces of ``dilatancy_force``.
        """
        depends = np.isfinite(self.dilatancy_force[:, 1])
        full, none = self.dilatancy_force[depends].T
        share = np.ones(len(self.sliding))
        share[depends] = np.clip((none - n[self.sliding][depends]) / (none - full), 0.0, 1.0)
        return self.dilatancy * share

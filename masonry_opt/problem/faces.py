"""Define the yield conditions of a problem, and the layout of its arrays in the plane and in space.

A yield condition is one row of z = C q + c ≥ 0, called a *face* here. The module also defines chords, by
which linear programs approximate the parabola of limited compressive strength.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
import scipy.sparse as sp

from masonry_opt.brief import brief

#: Number of chords on each side of the vertex of the moment parabola of joints that can crush. More chords
#: approximate the parabola better, but enlarge the linear programs.
_CHORDS_PER_SIDE = 12

#: Number of knots that divide the first chord of the moment parabola. More knots make the approximation more
#: accurate at low stresses.
_LOW_KNOTS = 4


class ChordCoefficients(NamedTuple):
    """Coefficients of chords, which approximate the moment parabola of joints of limited strength.

    Each chord is the condition m ≤ L/2 (slope · n + constant · f_c L) on the moment m and the normal force n
    of a joint of length L and strength f_c.

    The lines, shape (chords,) each, form a polygon inside the parabola |m| ≤ n (L/2 − n / (2 f_c)), so that
    linear programs can represent it. The first line passes through the origin. An associative λ by the chords
    is at most as large as by the parabola.

    With x = n / (f_c L) the parabola is m ≤ f_c L · L/2 · x (1 − x). The knots lie at equal steps of √x up to
    the largest moment, and mirrored beyond it. Then every chord misses nearly the same share of the moment,
    at most (step)² / (1 − x): with twelve chords on each side, 0.35 to 0.64 %.

    Most masonry is stressed below the first of these knots. Further knots there, each at a quarter of the
    next one, let the share fall with the stress.
    """

    slope: np.ndarray
    constant: np.ndarray


#: Knots x = n / (f_c L), normal forces relative to the crushing force f_c L, from zero to the vertex of the
#: parabola. The steps of √x are equal.
_RISING_KNOTS = np.linspace(0.0, np.sqrt(0.5), _CHORDS_PER_SIDE + 1) ** 2

#: Further knots x for low stresses, between zero and the first nonzero entry of ``_RISING_KNOTS``. Each knot
#: is a quarter of the next knot.
_LOW_STRESS_KNOTS = _RISING_KNOTS[1] / 4.0 ** np.arange(_LOW_KNOTS, 0, -1)

#: All knots x = n / (f_c L) of the moment parabola, from x = 0 to x = 1. Chords connect neighbouring knots.
_KNOTS = np.concatenate([[0.0], _LOW_STRESS_KNOTS, _RISING_KNOTS[1:], 1 - _RISING_KNOTS[-2::-1]])

#: Coefficients of the chords of the moment parabola.
CHORDS = ChordCoefficients(1 - _KNOTS[:-1] - _KNOTS[1:], _KNOTS[:-1] * _KNOTS[1:])

#: Largest relative error of the moment limit if chords replace the parabola. The error is largest at the
#: chords next to the vertex.
LARGEST_CHORD_ERROR = 0.0065


def chord_rates(opening: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Return the rates p ≥ 0 of the chords in joints that open and rotate by given amounts.

    Of all rates that produce the motions, these rates dissipate the least energy.

    Parameters
    ----------
    opening : ndarray, shape (joints,)
        Opening of the middle of each joint; negative if material is crushed.
    rotation : ndarray, shape (joints,)
        Rotation of each joint times L/2.

    Returns
    -------
    ndarray, shape (2, joints, chords)
        Rates of the chords at the first point and at the second point.
    """
    slope = CHORDS.slope
    joints = np.arange(len(opening))
    turning = np.abs(rotation)
    p = np.zeros((2, len(opening), len(slope)))
    sense = (rotation > 0).astype(int)
    # The ratio of opening to rotation is between the slopes of the chords `after - 1` and `after`, so only
    # these two chords have nonzero rates.
    after = (opening[:, None] < slope * turning[:, None]).sum(axis=1)
    inner = (after > 0) & (after < len(slope))
    i, k = joints[inner], after[inner]
    share = (opening[i] - slope[k] * turning[i]) / (slope[k - 1] - slope[k])
    p[sense[i], i, k - 1] = share
    p[sense[i], i, k] = turning[i] - share
    # If the ratio of opening to rotation is outside the range of slopes, only the first or the last chord has
    # a nonzero rate.
    for end, beyond in ((0, joints[after == 0]), (-1, joints[after == len(slope)])):
        total = opening[beyond] / slope[end]
        p[:, beyond, end] = np.stack([total - rotation[beyond], total + rotation[beyond]]) / 2
    return p


def parabola(n: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Return the largest moment, divided by L/2, that joints of length L carry under normal forces n.

    The result has shape (joints,). ``whole`` is f_c L of each joint. Beyond this force the result is
    negative.
    """
    return n * (1 - n / whole)


def crushing_energy(opening: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Return the energy that joints dissipate by crushing, divided by their crushing force f_c L.

    The result has shape (joints,). The strength is limited by the parabola.

    The energy is the largest value of |rotation| x (1 − x) − opening x over 0 ≤ x ≤ 1. Opening and rotation
    are those of :func:`chord_rates`.
    """
    turning = np.abs(rotation)
    ratio = np.divide(opening, turning, out=np.where(opening < 0, -1.0, 1.0), where=turning > 0)
    x = np.clip((1 - ratio) / 2, 0.0, 1.0)
    return turning * x * (1 - x) - opening * x


#: Number of force components of a joint: two normal forces and one shear in the plane, one normal force and
#: two shears in space.
FORCE_COMPONENTS = 3


@dataclass(frozen=True)
class Layout:
    """Sizes of the arrays of a plane problem, and the order of their entries.

    :class:`SpaceLayout` overrides both for problems in space.
    """

    #: Unit vectors along which a shear force resists sliding, one for each sense of sliding, shape (senses,
    #: dimension − 1). In the plane they are +1 and −1. In space they have a constant angular spacing, and the
    #: first is half a spacing away from the joint's tangent.
    senses: np.ndarray
    factor: float = 1.0  #: shear that is available in each sense, divided by the shear limit c + μ n
    #: Name of the friction polygon in results; empty in the plane, where friction needs no polygon.
    word: str = ""

    dimension: ClassVar[int] = 2  #: number of components of a force vector
    #: Number of rows of a block in B: ``dimension`` forces, then the moments about its centroid.
    rows: ClassVar[int] = 3
    #: Number of contact points of a joint. Each contact point has one normal force. The remaining force
    #: components of a joint are shears.
    points: ClassVar[int] = 2
    round: ClassVar[bool] = False  #: True in space, where a polygon approximates the friction cone
    called: ClassVar[str] = "joints"  #: name of the problem's joints in printed results

    __repr__ = brief

    def rates(self, slip: np.ndarray) -> np.ndarray:
        """Return the rates of sliding in each sense, shape (senses, k), that produce given slips.

        The slips have shape (dimension − 1, k).
        """
        return np.maximum(-self.senses @ slip, 0.0)

    def norm(self, load: np.ndarray) -> float:
        """Return the sum of the magnitudes of a load's components; the load has the shape (b, rows)."""
        return float(np.abs(load).sum())


class SpaceLayout(Layout):
    """Sizes of the arrays of a problem in space, and the order of their entries.

    A block has three forces and three moments; a contact point has a normal force and two shears.
    """

    dimension = 3
    rows = 6
    points = 1
    round = True
    called = "contacts"

    def rates(self, slip: np.ndarray) -> np.ndarray:
        """Return the rates of sliding in each sense, shape (senses, k), that produce given slips.

        The slips have shape (2, k). Only the one or two senses next to the direction of each slip have
        nonzero rates.
        """
        sides = len(self.senses)
        joints = np.arange(slip.shape[1])
        angle = 2 * np.pi / sides
        direction = np.arctan2(-slip[1], -slip[0]) / angle - 0.5
        before = np.floor(direction)
        past = angle * (direction - before)
        speed = np.hypot(*slip) / np.sin(angle)
        rates = np.zeros((sides, slip.shape[1]))
        rates[before.astype(int) % sides, joints] = speed * np.sin(angle - past)
        rates[(before.astype(int) + 1) % sides, joints] = speed * np.sin(past)
        return rates

    def norm(self, load: np.ndarray) -> float:
        """Return the sum of the magnitudes of all forces and moments in a load of shape (b, 6).

        Magnitudes do not depend on the axes.
        """
        forces, moments = (np.hypot.reduce(vectors, axis=1) for vectors in np.hsplit(load, 2))
        return float((forces + moments).sum())


#: Layout of plane problems: a block has forces in x and y and one moment; a joint has a normal force at each
#: end and one shear.
PLANE = Layout(np.array([[1.0], [-1.0]]))


def space(sides: int) -> Layout:
    """Return the layout of problems in space, with a friction polygon of ``sides`` sides.

    The polygon lies inside the friction cone. Each side is ``cos(π/sides) (c + μ n) − e·(s, t) ≥ 0``. One
    corner of the polygon lies along the tangent. If the number of sides is a multiple of 4, a corner lies
    along each axis, where the polygon is as strong as the cone.
    """
    angles = 2 * np.pi / sides * (np.arange(sides) + 0.5)
    senses = np.column_stack([np.cos(angles), np.sin(angles)])
    return SpaceLayout(senses, float(np.cos(np.pi / sides)), f"polygon of {sides} sides")


#: Two boolean masks of the limited forces, shape (t,) each. The first marks forces with a lower limit, the
#: second forces with an upper limit.
Bounded = tuple[np.ndarray, np.ndarray]


class Faces:
    """Yield conditions of all joints and limited forces; each condition is called a *face*.

    The problem has c joints, of which k can slide and l can crush, and t limited forces.

    The conditions are used with every form of the joint laws. The slack of a face is a force. Every array
    over faces has this order:

    1. sliding (+) of the k joints that can slide, then sliding (−); in space one group for each sense,
    2. rocking (n₁ ≥ 0) of all c joints, then rocking (n₂ ≥ 0),
    3. chords of crushing (``CHORDS``) at the first point of the joints of limited strength, then at the
       second,
    4. lower limits of the limited forces that have one, then their upper limits.

    ``count`` is the number of faces. ``slides``, ``rocks``, ``chords`` and ``limits`` are the slices of these
    groups, and ``non_sliding`` is the slice of the last three groups.
    """

    def __init__(
        self, layout: Layout, joints: int, sliding: np.ndarray, crushing: np.ndarray, bounded: Bounded
    ) -> None:
        self.layout = layout
        self.joints = joints
        self.sliding = sliding
        self.crushing = crushing
        self._joint_of_chord = np.repeat(crushing, len(CHORDS.slope))
        self.below, self.above = map(np.flatnonzero, bounded)
        self.width: int = FORCE_COMPONENTS * joints + len(bounded[0])
        counts = [
            len(layout.senses) * len(sliding),
            layout.points * joints,
            layout.points * len(self._joint_of_chord),
            len(self.below) + len(self.above),
        ]
        ends = np.cumsum(counts).tolist()
        self.slides, self.rocks, self.chords, self.limits = map(slice, [0, *ends], ends)
        self.count: int = ends[-1]
        self.non_sliding = slice(self.slides.stop, self.count)

    @cached_property
    def normal_sums(self) -> sp.csr_array:
        """Return the matrix that sums the normal forces of each joint, shape (c, 3c + t)."""
        points = np.arange(self.layout.points * self.joints).reshape(self.layout.points, -1)
        return sum(selection(columns, self.width) for columns in points)

    @cached_property
    def N(self) -> sp.csr_array:
        """Return the matrix that sums the normal forces of each joint that can slide, shape (k, 3c + t)."""
        return self.normal_sums[self.sliding]

    @cached_property
    def R(self) -> sp.csr_array:
        """Return the yield conditions of rocking, crushing and force limits as rows of a matrix.

        The matrix is C without its sliding rows, shape (2c + chords + limits, 3c + t).

        - Rocking: 2 n₁ of every joint (the paper's n L/2 − m, divided by L/2), then 2 n₂; in space n.
        - Crushing: 2 n₁ − (1 − a) n for each chord of slope a, then 2 n₂ − (1 − a) n.
        - Limits: T of the forces bounded below, then −T of the forces bounded above.
        """
        points = self.layout.points
        forces = np.append(self.below, self.above)
        limited = selection(FORCE_COMPONENTS * self.joints + forces, self.width)
        limited.data[len(self.below) :] = -1.0
        rocking = points * selection(np.arange(points * self.joints), self.width)
        total = self.normal_sums[self._joint_of_chord]
        lost = sp.diags_array(np.tile(1 - CHORDS.slope, len(self.crushing))) @ total
        columns = [point * self.joints + self._joint_of_chord for point in range(points)]
        crushing = [points * selection(at_point, self.width) - lost for at_point in columns]
        return sp.vstack([rocking, *crushing, limited], format="csr")

    @cached_property
    def L(self) -> sp.csr_array:
        """Return the rows of the yield matrix for the bounds of limited forces, shape (limits, 3c + t)."""
        return self.R[self.chords.stop - self.slides.stop :]

    def C(self, slope: np.ndarray) -> sp.csr_array:
        """Return the yield matrix C, shape (faces, 3c + t), with one row for each yield condition.

        ``slope``, shape (k,), is that of the shear limits: the increase of the limit per unit of normal
        force.
        """
        # Fill the sparse arrays directly, because sparse products and sums would dominate the time to check a
        # solution.
        k = len(self.sliding)
        non_sliding = self.R
        senses, shears = self.layout.senses.shape
        entries = np.empty((senses, k, FORCE_COMPONENTS))
        entries[..., :-shears] = self.layout.factor * slope[:, None]
        entries[..., -shears:] = -self.layout.senses[:, None, :]
        columns = np.add.outer(self.sliding, np.arange(FORCE_COMPONENTS) * self.joints)
        values = np.append(entries.ravel(), non_sliding.data)
        indices = np.concatenate([np.tile(columns.ravel(), senses), non_sliding.indices])
        starts = np.arange(0, entries.size, FORCE_COMPONENTS, dtype=non_sliding.indptr.dtype)
        parts = values, indices, np.append(starts, entries.size + non_sliding.indptr)
        matrix = sp.csr_array(parts, shape=(self.count, non_sliding.shape[1]))
        matrix.eliminate_zeros()
        return matrix

    @cached_property
    def limit_factors(self) -> sp.csr_array:
        """Return the coefficient of each shear limit in each yield condition, shape (faces, k).

        The coefficient is the fraction of the limit that is available in a sense of sliding. For other
        conditions it is zero.
        """
        sliders = np.tile(np.arange(len(self.sliding)), len(self.layout.senses))
        factors = self.layout.factor * selection(sliders, len(self.sliding))
        factors.resize(self.count, len(self.sliding))
        return factors

    @cached_property
    def face_joint(self) -> np.ndarray:
        """Return the index of the joint to which each yield condition belongs, shape (faces − limits,).

        The last conditions, which limit forces such as those of ties, belong to no joint and are left out.
        """
        points = self.layout.points
        sliding = np.tile(self.sliding, len(self.layout.senses))
        rocking = np.tile(np.arange(self.joints), points)
        return np.concatenate([sliding, rocking, np.tile(self._joint_of_chord, points)])

    def slip_speed(self, p: np.ndarray) -> np.ndarray:
        """Return the slip speed of each joint that can slide, shape (k,), from rates p of shape (faces,)."""
        senses = self.layout.senses
        return np.hypot.reduce(np.abs(senses.T @ p[self.slides].reshape(len(senses), -1)), axis=0)

    @cached_property
    def bent(self) -> np.ndarray:
        """Return the indices of the crushing conditions by point, joint and chord, shape (2, l, chords).

        The axes are the two contact points, the l joints with limited strength, and the chords of each moment
        limit. The crushing conditions bend the straight limits of the rocking conditions.
        """
        return np.arange(self.count)[self.chords].reshape(self.layout.points, -1, len(CHORDS.slope))

    @cached_property
    def turning(self) -> np.ndarray:
        """Return the indices of the rocking conditions of the l joints of limited strength, shape (2, l)."""
        return np.arange(self.count)[self.rocks].reshape(self.layout.points, -1)[:, self.crushing]


def selection(columns: np.ndarray, width: int) -> sp.csr_array:
    """Return the matrix that selects entries of a vector, one entry in each row.

    ``columns`` are the indices of the entries, ``width`` is the length of the vector.
    """
    count = len(columns)
    return sp.csr_array((np.ones(count), (np.arange(count), columns)), shape=(count, width))

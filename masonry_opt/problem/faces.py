"""The table of faces, the chords of crushing, and the numbers in which the plane and space differ."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
import scipy.sparse as sp

#: Chords on each side of the largest moment, and those that part the first again.
_ON_EACH_SIDE, _NEAR_NOTHING = 12, 4


class Chords(NamedTuple):
    """Lines m ≤ L/2 (slope · n + constant · f_c L), the first through no force, shape (chords,) each: a
    polygon inside |m| ≤ n (L/2 − n / (2 f_c)), so that linear programs take it. An associative λ is then
    at most as large as by the parabola.

    In x = n / (f_c L) the limit is m ≤ f_c L · L/2 · x (1 − x). Knots at equal steps of √x up to the middle,
    and mirrored beyond it, let every chord miss nearly the same share of the moment, (step)² / (1 − x) or
    less: twelve on each side of the middle miss 0.35 to 0.64 % of it at most. Most masonry is stressed below
    the first knot: further knots there, each at a quarter of the next, let the share fall with the stress.
    """

    slope: np.ndarray
    constant: np.ndarray


_RISING = np.linspace(0.0, np.sqrt(0.5), _ON_EACH_SIDE + 1) ** 2
_LOW = _RISING[1] / 4.0 ** np.arange(_NEAR_NOTHING, 0, -1)
_KNOTS = np.concatenate([[0.0], _LOW, _RISING[1:], 1 - _RISING[-2::-1]])

CHORDS = Chords(1 - _KNOTS[:-1] - _KNOTS[1:], _KNOTS[:-1] * _KNOTS[1:])

MISSED = 0.0065  #: The largest share of the moment that a chord misses: beside the middle.


def chord_rates(opening: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Rates p ≥ 0 of all chords, (+) and (−), shape (2, joints, chords), that follow a motion and dissipate
    least: an opening, negative where material is crushed, and a rotation times L/2, shape (joints,) each."""
    slope, joints, turning = CHORDS.slope, np.arange(len(opening)), np.abs(rotation)
    p = np.zeros((2, len(opening), len(slope)))
    sense = (rotation > 0).astype(int)
    # Between the chords at `after - 1` and `after`, whose slopes enclose opening over rotation.
    after = (opening[:, None] < slope * turning[:, None]).sum(axis=1)
    inner = (after > 0) & (after < len(slope))
    i, k = joints[inner], after[inner]
    share = (opening[i] - slope[k] * turning[i]) / (slope[k - 1] - slope[k])
    p[sense[i], i, k - 1], p[sense[i], i, k] = share, turning[i] - share
    # Beyond the first chord it opens more than it turns, beyond the last it crushes more than it turns.
    for end, those in ((0, joints[after == 0]), (-1, joints[after == len(slope)])):
        both = opening[those] / slope[end]
        p[:, those, end] = np.stack([both - rotation[those], both + rotation[those]]) / 2
    return p


def parabola(n: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Largest moment over L/2 under normal forces n, (joints,), negative beyond ``whole``, f_c L of each."""
    return n * (1 - n / whole)


def crushing_energy(opening: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Energy that the parabola dissipates in a motion, over f_c L, shape (joints,): the greatest of
    |rotation| x (1 − x) − opening x over 0 ≤ x ≤ 1. Opening and rotation are those of :func:`chord_rates`."""
    turning = np.abs(rotation)
    ratio = np.divide(opening, turning, out=np.where(opening < 0, -1.0, 1.0), where=turning > 0)
    x = np.clip((1 - ratio) / 2, 0.0, 1.0)
    return turning * x * (1 - x) - opening * x


KINDS = 3  #: Kinds of force of a joint: two points and a shear, or a point and two.


@dataclass(frozen=True)
class Layout:
    """Rows of a block, points of a joint and senses of sliding: of the plane, and below of space."""

    #: Shear that resists each sense of sliding, shape (senses, dimension − 1): in the plane two opposites, in
    #: space directions all round, at equal angles, the first half of one from the tangent.
    senses: np.ndarray
    factor: float = 1.0  #: share of the shear limit that holds in each sense
    word: str = ""  #: what results call the senses; nothing in the plane, where there are no others

    dimension: ClassVar[int] = 2  #: components of a force, on a block or in a joint
    rows: ClassVar[int] = 3  #: of a block in B: ``dimension`` forces, then moments about its centroid
    #: At which a joint presses: of its three kinds of force in q a normal force at each, the rest shears.
    points: ClassVar[int] = 2
    round: ClassVar[bool] = False  #: whether the senses are sides inside a cone
    called: ClassVar[str] = "joints"  #: what results call the problem's joints

    def rates(self, slip: np.ndarray) -> np.ndarray:
        """Rates, shape (senses, k), of the senses that together slip so, shape (dimension − 1, k)."""
        return np.maximum(-self.senses @ slip, 0.0)

    def norm(self, load: np.ndarray) -> float:
        """Sum over the components of a load, shape (b, rows)."""
        return float(np.abs(load).sum())


class SpaceLayout(Layout):
    """The same of space: three forces and three moments of a block; n and two shears at a contact point."""

    dimension = 3
    rows = 6
    points = 1
    round = True
    called = "contacts"

    def rates(self, slip: np.ndarray) -> np.ndarray:
        """As in the plane: of the one or two senses next to the direction of slip."""
        sides, each = len(self.senses), np.arange(slip.shape[1])
        angle = 2 * np.pi / sides
        turned = np.arctan2(-slip[1], -slip[0]) / angle - 0.5
        before = np.floor(turned)
        past, speed = angle * (turned - before), np.hypot(*slip) / np.sin(angle)
        rates = np.zeros((sides, slip.shape[1]))
        rates[before.astype(int) % sides, each] = speed * np.sin(angle - past)
        rates[(before.astype(int) + 1) % sides, each] = speed * np.sin(past)
        return rates

    def norm(self, load: np.ndarray) -> float:
        """Sum over the sizes of forces and of moments, which no axes change."""
        forces, moments = (np.hypot.reduce(of, axis=1) for of in np.hsplit(load, 2))
        return float((forces + moments).sum())


#: Forces in x and y and one moment; n at both ends of a joint, about which it turns, and one shear.
PLANE = Layout(np.array([[1.0], [-1.0]]))


def space(sides: int) -> Layout:
    """Layout of space with so many sides of a polygon inside the cone of friction, each
    ``cos(π/sides) (c + μ n) − e·(s, t) ≥ 0``. A corner of the polygon lies along the tangent, and where 4
    divides their number along each axis: along these the polygon holds as much as the cone."""
    angles = 2 * np.pi / sides * (np.arange(sides) + 0.5)
    senses = np.column_stack([np.cos(angles), np.sin(angles)])
    return SpaceLayout(senses, float(np.cos(np.pi / sides)), f"polygon of {sides} sides")


#: Which of the limited forces are bounded below, and which above, shape (t,) each.
Bounded = tuple[np.ndarray, np.ndarray]


class Faces:
    """Yield conditions of c joints, k of which can slide and l crush, and t limited forces, of any law.

    A *face* is one of them, its slack a force. Every array over faces has this order: sliding (+) of the k
    joints that can slide, sliding (−) of them, rocking (n₁ ≥ 0) of all c joints, rocking (n₂ ≥ 0) of them,
    chords of crushing (``CHORDS``) at the first point and at the second of the joints of limited strength,
    then T not below its lowest, and T not above its highest value of the limited forces that have one.

    ``count`` counts them; ``slides``, ``rocks``, ``chords``, ``limits`` are slices, ``rest`` the last three.
    """

    def __init__(
        self, layout: Layout, joints: int, sliding: np.ndarray, crushing: np.ndarray, bounded: Bounded
    ) -> None:
        self.layout, self.joints, self.sliding, self.crushing = layout, joints, sliding, crushing
        self._of_chord = np.repeat(crushing, len(CHORDS.slope))
        self.below, self.above = map(np.flatnonzero, bounded)
        self.width: int = KINDS * joints + len(bounded[0])
        rocking, crushed = layout.points * joints, layout.points * len(self._of_chord)
        limits = len(self.below) + len(self.above)
        ends = np.cumsum([len(layout.senses) * len(sliding), rocking, crushed, limits]).tolist()
        self.slides, self.rocks, self.chords, self.limits = map(slice, [0, *ends], ends)
        self.count: int = ends[-1]
        self.rest = slice(self.slides.stop, self.count)

    @cached_property
    def normal_sums(self) -> sp.csr_array:
        """Sums the normal forces of each joint, shape (c, 3c + t)."""
        points = np.arange(self.layout.points * self.joints).reshape(self.layout.points, -1)
        return sum(selection(columns, self.width) for columns in points)

    @cached_property
    def N(self) -> sp.csr_array:
        """The same of the joints that can slide, shape (k, 3c + t)."""
        return self.normal_sums[self.sliding]

    @cached_property
    def R(self) -> sp.csr_array:
        """All faces but those of sliding, shape (2c + chords + limits, 3c + t): 2 n₁ of every joint, the
        paper's n L/2 − m over L/2, then 2 n₂; in space n; of joints that can crush 2 n₁ − (1 − a) n for each
        chord of slope a, then 2 n₂ − (1 − a) n; T of forces bounded below, −T of those bounded above."""
        points, forces = self.layout.points, np.append(self.below, self.above)
        limited = selection(KINDS * self.joints + forces, self.width)
        limited.data[len(self.below) :] = -1.0
        rocking = points * selection(np.arange(points * self.joints), self.width)
        total = self.normal_sums[self._of_chord]
        lost = sp.diags_array(np.tile(1 - CHORDS.slope, len(self.crushing))) @ total
        columns = [point * self.joints + self._of_chord for point in range(points)]
        at_points = [points * selection(own, self.width) - lost for own in columns]
        return sp.vstack([rocking, *at_points, limited], format="csr")

    @cached_property
    def L(self) -> sp.csr_array:
        """Rows of R that limit forces, shape (limits, 3c + t)."""
        return self.R[self.chords.stop - self.slides.stop :]

    def C(self, slope: np.ndarray) -> sp.csr_array:
        """Yield conditions with shear limits of that slope, shape (k,): a row a face, (faces, 3c + t)."""
        # Put together by hand: products and sums of sparse matrices would be most of a certificate's time.
        k, rest, (senses, shears) = len(self.sliding), self.R, self.layout.senses.shape
        entries = np.empty((senses, k, KINDS))
        entries[..., :-shears] = self.layout.factor * slope[:, None]
        entries[..., -shears:] = -self.layout.senses[:, None, :]
        columns = np.add.outer(self.sliding, np.arange(KINDS) * self.joints)
        values = np.append(entries.ravel(), rest.data)
        indices = np.concatenate([np.tile(columns.ravel(), senses), rest.indices])
        starts = np.arange(0, entries.size, KINDS, dtype=rest.indptr.dtype)
        parts = values, indices, np.append(starts, entries.size + rest.indptr)
        matrix = sp.csr_array(parts, shape=(self.count, rest.shape[1]))
        matrix.eliminate_zeros()
        return matrix

    @cached_property
    def limit_factors(self) -> sp.csr_array:
        """Share of each slider's shear limit that holds on each face, shape (faces, k)."""
        sliders = np.tile(np.arange(len(self.sliding)), len(self.layout.senses))
        factors = self.layout.factor * selection(sliders, len(self.sliding))
        factors.resize(self.count, len(self.sliding))
        return factors

    @cached_property
    def face_joint(self) -> np.ndarray:
        """The joint that each face belongs to, shape (faces − limits,): the last ones are of no joint."""
        points, every = self.layout.points, np.arange(self.joints)
        sliding = np.tile(self.sliding, len(self.layout.senses))
        return np.concatenate([sliding, np.tile(every, points), np.tile(self._of_chord, points)])

    def slip_speed(self, p: np.ndarray) -> np.ndarray:
        """Speed of slip of the joints that can slide, shape (k,), in rates p, shape (faces,)."""
        senses = self.layout.senses
        return np.hypot.reduce(np.abs(senses.T @ p[self.slides].reshape(len(senses), -1)), axis=0)

    @cached_property
    def bent(self) -> np.ndarray:
        """Chords of the joints that can crush, at the first and second point, shape (2, l, chords)."""
        return np.arange(self.count)[self.chords].reshape(self.layout.points, -1, len(CHORDS.slope))

    @cached_property
    def turning(self) -> np.ndarray:
        """Rocking faces of the joints that can crush, shape (2, l)."""
        return np.arange(self.count)[self.rocks].reshape(self.layout.points, -1)[:, self.crushing]


def selection(columns: np.ndarray, width: int) -> sp.csr_array:
    """Matrix that picks entries of a vector of that width, one a row."""
    count = len(columns)
    return sp.csr_array((np.ones(count), (np.arange(count), columns)), shape=(count, width))

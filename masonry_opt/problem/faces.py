"""The table of faces, and the numbers in which the plane and space differ."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from masonry_opt.problem.chords import CHORDS


@dataclass(frozen=True)
class Layout:
    """Rows of a block, forces of a joint, and senses of sliding.

    Attributes
    ----------
    dimension: components of a force, on a block or in a joint.
    rows: rows of a block in B: ``dimension`` forces, then moments about its centroid.
    kinds: kinds of force in q: normal forces of all joints, then ``dimension`` − 1 shears, then moments.
    senses: shear that resists each sense of sliding, shape (senses, dimension − 1): in the plane two
        opposites, in space directions all round, at equal angles, the first half of one from the tangent.
    factor: share of the shear limit that holds in each sense.
    edges: sign of the moment in each rocking face of a joint; a single 0 says n ≥ 0.
    """

    dimension: int
    rows: int
    kinds: int
    senses: np.ndarray
    factor: float
    edges: np.ndarray

    @property
    def round(self) -> bool:
        """Whether the senses are sides inside a cone."""
        return self.dimension == 3

    def rates(self, slip: np.ndarray) -> np.ndarray:
        """Rates, shape (senses, k), of the senses that together slip so, shape (dimension − 1, k): of the one
        or two next to its direction."""
        if self.dimension == 2:
            return np.maximum(-self.senses @ slip, 0.0)
        sides, each = len(self.senses), np.arange(slip.shape[1])
        angle = 2 * np.pi / sides
        turned = np.arctan2(-slip[1], -slip[0]) / angle - 0.5
        before = np.floor(turned)
        past, speed = angle * (turned - before), np.hypot(*slip) / np.sin(angle)
        rates = np.zeros((sides, slip.shape[1]))
        rates[before.astype(int) % sides, each] = speed * np.sin(angle - past)
        rates[(before.astype(int) + 1) % sides, each] = speed * np.sin(past)
        return rates


#: Forces in x and y and one moment; n, s, m of a joint; two senses of sliding, two edges to turn about.
PLANE = Layout(2, 3, 3, senses=np.array([[1.0], [-1.0]]), factor=1.0, edges=np.array([-1.0, 1.0]))


def space(sides: int) -> Layout:
    """Layout of space: three forces and three moments of a block; n and two shears of a contact point; so
    many sides of a polygon inside the cone of friction, each ``cos(π/sides) (c + μ n) − e·(s, t) ≥ 0``.

    A corner of the polygon lies along the tangent, and where 4 divides their number along each axis: along
    these the polygon holds as much as the cone."""
    angles = 2 * np.pi / sides * (np.arange(sides) + 0.5)
    senses = np.column_stack([np.cos(angles), np.sin(angles)])
    return Layout(3, 6, 3, senses=senses, factor=float(np.cos(np.pi / sides)), edges=np.zeros(1))


class Faces:
    """Yield conditions of c joints, of which k can slide and l can crush, and of t limited forces, whatever
    their friction and limits are.

    A *face* is one yield condition, and every array over faces has this order: sliding (+) of the k joints
    that can slide, sliding (−) of them, rocking about one edge (+) of all c joints, rocking (−) of them,
    then chords of crushing (+) and (−) of the joints of limited strength (see :mod:`~.chords`), then T not
    below its lowest, and T not above its highest value of the limited forces that have one.

    Parameters
    ----------
    bounded: which limited forces are bounded below, and which above, shape (t,) each.

    Attributes
    ----------
    count: number of faces.
    slides, rocks, chords, limits: where each of the four kinds is; ``rest``: all but those that slide.
    """

    def __init__(
        self,
        layout: Layout,
        half_length: np.ndarray,
        sliding: np.ndarray,
        crushing: np.ndarray,
        bounded: tuple[np.ndarray, np.ndarray],
    ) -> None:
        self.layout, self.half_length, self.sliding, self.crushing = layout, half_length, sliding, crushing
        self._of_chord = np.repeat(crushing, len(CHORDS.slope) - 1)
        self.below, self.above = map(np.flatnonzero, bounded)
        edges = len(layout.edges)
        self.width: int = layout.kinds * len(half_length) + len(bounded[0])
        rocking, crushed = edges * len(half_length), edges * len(self._of_chord)
        limits = len(self.below) + len(self.above)
        ends = np.cumsum([len(layout.senses) * len(sliding), rocking, crushed, limits]).tolist()
        self.slides, self.rocks, self.chords, self.limits = map(slice, [0, *ends], ends)
        self.count: int = ends[-1]
        self.rest = slice(self.slides.stop, self.count)

    @cached_property
    def N(self) -> sp.csr_array:
        """Selects the normal forces of the joints that can slide, shape (k, 3c + t)."""
        return selection(self.sliding, self.width)

    @cached_property
    def lever(self) -> np.ndarray:
        """Slope of the rocking faces, shape (c,): L/2, less by the first chord where joints can crush."""
        lever = self.half_length.copy()
        lever[self.crushing] *= CHORDS.slope[0]
        return lever

    @cached_property
    def R(self) -> sp.csr_array:
        """All faces but those of sliding, shape (2c + chords + limits, 3c + t): ``R q`` is n L/2 − m of every
        joint, then n L/2 + m; of joints that can crush a n − m for each further chord, then a n + m; then T
        of the limited forces bounded below, −T of those bounded above."""
        joints = len(self.half_length)
        slope = np.outer(self.half_length[self.crushing], CHORDS.slope[1:]).ravel()
        entries = []
        for joint, leaning in ((np.arange(joints), self.lever), (self._of_chord, slope)):
            for sign in self.layout.edges.tolist():
                moment = (self.layout.kinds - 1) * joints + joint
                turning = np.full_like(leaning, sign)
                entries.append((np.stack([joint, moment], 1), np.stack([leaning, turning], 1)))
        columns, values = (np.concatenate(parts).ravel() for parts in zip(*entries, strict=True))
        starts = np.arange(0, len(columns) + 1, 2)
        forces = np.append(self.below, self.above)
        columns = np.append(columns, self.layout.kinds * joints + forces)
        values = np.append(values, np.repeat([1.0, -1.0], [len(self.below), len(self.above)]))
        starts = np.append(starts, starts[-1] + 1 + np.arange(len(forces)))
        matrix = sp.csr_array((values, columns, starts), (len(starts) - 1, self.width))
        matrix.eliminate_zeros()
        return matrix

    @cached_property
    def L(self) -> sp.csr_array:
        """Rows of R that limit forces, shape (limits, 3c + t)."""
        return self.R[self.chords.stop - self.chords.start + self.rocks.stop - self.rocks.start :]

    @cached_property
    def from_edges(self) -> sp.csr_array:
        """Turns the forces at the first and second edge of each joint, and its shear, into q, shape (3c, 3c):
        n = x₂ + x₃, m = lever · (x₃ − x₂); in space contact points are edges: q as it is."""
        if len(self.layout.edges) == 1:
            return sp.eye_array(self.layout.kinds * len(self.lever), format="csr")
        one, arm = sp.eye_array(len(self.lever)), sp.diags_array(self.lever)
        return sp.block_array([[one, one, None], [None, None, one], [-arm, arm, None]], format="csr")

    def C(self, slope: np.ndarray) -> sp.csr_array:
        """Yield conditions with shear limits of that slope, shape (k,): rows over the faces, shape
        (faces, 3c + t)."""
        # Put together by hand: products and sums of sparse matrices would be most of a certificate's time.
        k, rest, (senses, shears) = len(self.sliding), self.R, self.layout.senses.shape
        entries = np.empty((senses, k, 1 + shears))
        entries[..., 0] = self.layout.factor * slope
        entries[..., 1:] = -self.layout.senses[:, None, :]
        columns = np.add.outer(self.sliding, np.arange(1 + shears) * len(self.half_length))
        matrix = sp.csr_array(
            (
                np.append(entries.ravel(), rest.data),
                np.concatenate([np.tile(columns.ravel(), senses), rest.indices]),
                np.append(
                    np.arange(0, entries.size, 1 + shears, dtype=rest.indptr.dtype),
                    entries.size + rest.indptr,
                ),
            ),
            shape=(self.count, rest.shape[1]),
        )
        matrix.eliminate_zeros()
        return matrix

    @cached_property
    def limit_factors(self) -> sp.csr_array:
        """Share of each slider's shear limit that holds on each face, shape (faces, k)."""
        k, slides = len(self.sliding), self.slides.stop
        sliders = np.tile(np.arange(k), len(self.layout.senses))
        starts = np.minimum(np.arange(self.count + 1), slides)
        return sp.csr_array((np.full(slides, self.layout.factor), sliders, starts), shape=(self.count, k))

    @cached_property
    def face_joint(self) -> np.ndarray:
        """The joint that each face belongs to, shape (faces − limits,): the last ones are of no joint."""
        edges, every = len(self.layout.edges), np.arange(len(self.half_length))
        sliding = np.tile(self.sliding, len(self.layout.senses))
        return np.concatenate([sliding, np.tile(every, edges), np.tile(self._of_chord, edges)])

    @cached_property
    def face_arm(self) -> np.ndarray:
        """Divisor that makes a slack a force: 1, or L/2 where it is a moment, shape (faces,)."""
        arm = np.ones(self.count)
        joints = slice(self.rocks.start, self.chords.stop)
        arm[joints] = self.half_length[self.face_joint[joints]]
        return arm

    @cached_property
    def face_length(self) -> np.ndarray:
        """Factor that makes a rate a slip or the opening of an edge, shape (faces,)."""
        length = np.ones(self.count)
        joints = slice(self.rocks.start, self.chords.stop)
        length[joints] = len(self.layout.edges) * self.lever[self.face_joint[joints]]
        return length

    def slip_speed(self, p: np.ndarray) -> np.ndarray:
        """Speed of slip of the joints that can slide, shape (k,), in rates p, shape (faces,)."""
        senses = self.layout.senses
        return np.hypot.reduce(np.abs(senses.T @ p[self.slides].reshape(len(senses), -1)), axis=0)

    @cached_property
    def bent(self) -> np.ndarray:
        """Rocking faces and chords of the joints that can crush, (+) and (−), shape (2, l, chords)."""
        faces, edges, joints = np.arange(self.count), len(self.layout.edges), len(self.crushing)
        rocking = faces[self.rocks].reshape(edges, -1)[:, self.crushing, None]
        chords = faces[self.chords].reshape(edges, joints, len(CHORDS.slope) - 1)
        return np.concatenate([rocking, chords], axis=2)


def selection(columns: np.ndarray, width: int) -> sp.csr_array:
    """Matrix that picks entries of a vector of that width, one a row."""
    count = len(columns)
    return sp.csr_array((np.ones(count), (np.arange(count), columns)), shape=(count, width))

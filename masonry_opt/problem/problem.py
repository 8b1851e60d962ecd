"""The limit analysis problem of a scene as matrices: eqs (1) to (6), in dimensionless units."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from masonry_opt.problem.chords import CHORDS, chord_rates, crushing_energy, parabola

#: What a problem's matrices are made of, beside the joints' law.
_OF_MATRICES = ("B", "dead", "live", "half_length", "sliding", "crushing", "crushing_force")

#: What is computed once, of the matrices alone.
_CACHED = (
    *("N", "S", "lever", "R", "both_senses", "crushing_moment"),
    *("face_joint", "face_arm", "ends", "touching", "longest_arm", "in_a_point", "bent", "part"),
)


@dataclass(frozen=True)
class Problem:
    """Matrices of b movable blocks and c joints, k of which can slide.

    Statics, eq. (1): ``B q + λ live + dead = 0`` (the paper turns the sign of B: B q − λ f_L = f_D).
    Yield, eq. (4): ``C(slope) q + face_cohesion ≥ 0``. Kinematics, eqs (2), (5), (6): ``Bᵀ d = D(slope) p``,
    the motion of each joint's first block against its second.

    A *face* is one yield condition, and every array over faces has this order: sliding (+) of the k joints
    that can slide, sliding (−) of them, rocking about one edge (+) of all c joints, rocking (−) of them,
    then chords of crushing (+) and (−) of the joints of limited strength (see :mod:`~.chords`).

    Forces are in units of ``force_unit`` (the median dead load of a block), lengths in units of
    ``length_unit`` (half the median joint length), so that the numbers a solver sees are near one whatever
    units a case file uses.

    Attributes
    ----------
    B: equilibrium matrix, shape (3b, 3c); rows fx, fy, moment about the centroid of each block,
        columns n (compression > 0) of all joints, then s, then m (about the joint's middle).
    dead, live: loads f_D and f_L, shape (3b,).
    half_length: L / 2 of each joint, shape (c,); 1 where a corner stands on an edge, whose column m of B is
        empty: there the two rocking faces say n ≥ 0, and m says nothing.
    sliding: indices of the joints that can slide (friction is limited), shape (k,).
    friction, dilatancy: μ and tan φ₀ of the joints that can slide, shape (k,).
    cohesion: of the joints that can slide, as a force (per unit length × L), shape (k,).
    dilatancy_force: normal forces up to which the dilatancy is whole and from which there is none (``inf``
        where it does not depend on them), shape (k, 2).
    crushing: indices of the joints of limited strength, shape (l,).
    crushing_force: f_c L, the normal force that crushes all of such a joint, shape (l,).
    force_unit, length_unit: what a dimensionless force or length is multiplied by.
    """

    B: sp.csr_array
    dead: np.ndarray
    live: np.ndarray
    half_length: np.ndarray
    sliding: np.ndarray
    friction: np.ndarray
    cohesion: np.ndarray
    dilatancy: np.ndarray
    dilatancy_force: np.ndarray
    crushing: np.ndarray
    crushing_force: np.ndarray
    force_unit: float
    length_unit: float

    @property
    def blocks(self) -> int:
        """Number of movable blocks, b."""
        return self.B.shape[0] // 3

    @property
    def joints(self) -> int:
        """Number of joints, c."""
        return self.B.shape[1] // 3

    @property
    def faces(self) -> int:
        """Number of yield conditions, 2k + 2c and the chords of crushing."""
        return 2 * len(self.sliding) + self.R.shape[0]

    @property
    def live_norm(self) -> float:
        """Σ|f_L|, by which objective and velocities are scaled (so that velocities are near 1)."""
        return float(np.abs(self.live).sum())

    @cached_property
    def N(self) -> sp.csr_array:
        """Selects the normal forces of the joints that can slide, shape (k, 3c)."""
        return _selection(self.sliding, 3 * self.joints)

    @cached_property
    def S(self) -> sp.csr_array:
        """Selects their shear forces, shape (k, 3c)."""
        return _selection(self.joints + self.sliding, 3 * self.joints)

    @cached_property
    def lever(self) -> np.ndarray:
        """Slope of the rocking faces, shape (c,): L/2, less by the first chord where joints can crush."""
        lever = self.half_length.copy()
        lever[self.crushing] *= CHORDS.slope[0]
        return lever

    @cached_property
    def R(self) -> sp.csr_array:
        """Rocking and crushing, shape (2c + chords, 3c): ``R q`` is n L/2 − m of every joint, then n L/2 + m;
        of joints that can crush a n − m for each further chord, then a n + m."""
        lever, one = sp.diags_array(self.lever), sp.eye_array(self.joints, format="csr")
        no_shear = sp.csr_array((self.joints, self.joints))
        rocking = [[lever, no_shear, -one], [lever, no_shear, one]]
        if not len(self.crushing):
            return sp.block_array(rocking, format="csr")
        of_chord = np.repeat(self.crushing, len(CHORDS.slope) - 1)
        slope = np.outer(self.half_length[self.crushing], CHORDS.slope[1:]).ravel()
        leaning, turning = sp.diags_array(slope) @ one[of_chord], one[of_chord]
        no_shear = sp.csr_array(turning.shape)
        chords = [[leaning, no_shear, -turning], [leaning, no_shear, turning]]
        return sp.vstack([sp.block_array(rocking), sp.block_array(chords)], format="csr")

    def C(self, slope: np.ndarray) -> sp.csr_array:
        """Yield conditions with shear limits of that slope, shape (k,): rows over the faces, (faces, 3c)."""
        # Put together by hand: products and sums of sparse matrices would be most of a certificate's time.
        k, rest = len(self.sliding), self.R
        columns = np.column_stack([self.sliding, self.joints + self.sliding])
        entries = [np.column_stack([slope, np.full(k, shear)]) for shear in (-1.0, 1.0)]
        matrix = sp.csr_array(
            (
                np.concatenate([*entries[0], *entries[1], rest.data]) if k else rest.data,
                np.concatenate([columns.ravel(), columns.ravel(), rest.indices]),
                np.concatenate([2 * np.arange(2 * k), 4 * k + rest.indptr]),
            ),
            shape=(self.faces, 3 * self.joints),
        )
        matrix.eliminate_zeros()
        return matrix

    @cached_property
    def true_yield(self) -> sp.csr_array:
        """C(μ), of the true friction law, shape (faces, 3c)."""
        return self.C(self.friction)

    def D(self, slope: np.ndarray) -> sp.csr_array:
        """Flow rule that opens joints by that slope, shape (k,), per unit slip: shape (3c, faces).

        Normality is C = D: with the friction as slope the flow is normal to the yield surface. (Dᵀ is C and
        not −C: with the sign of B used here the resultant forces do the work −c·p on the joint velocities.)
        """
        return self.C(slope).T.tocsr()

    @cached_property
    def both_senses(self) -> sp.csr_array:
        """Puts what both senses of sliding share, shape (k,), on the faces, shape (faces, k)."""
        k = len(self.sliding)
        return sp.vstack([sp.eye_array(k), sp.eye_array(k), sp.csr_array((self.R.shape[0], k))], format="csr")

    @cached_property
    def crushing_moment(self) -> np.ndarray:
        """Constant part of the chords of crushing, zero on all other faces, shape (faces,)."""
        moment = np.zeros(self.faces)
        if chords := len(self.crushing) * (len(CHORDS.slope) - 1):
            whole = self.half_length[self.crushing] * self.crushing_force
            moment[-2 * chords :] = np.tile(np.outer(whole, CHORDS.constant[1:]).ravel(), 2)
        return moment

    @cached_property
    def face_cohesion(self) -> np.ndarray:
        """Constant part of each yield condition, shape (faces,)."""
        return self.both_senses @ self.cohesion + self.crushing_moment

    @cached_property
    def face_joint(self) -> np.ndarray:
        """The joint that each face belongs to, shape (faces,)."""
        every, of_chord = np.arange(self.joints), np.repeat(self.crushing, len(CHORDS.slope) - 1)
        return np.concatenate([self.sliding, self.sliding, every, every, of_chord, of_chord])

    @cached_property
    def face_arm(self) -> np.ndarray:
        """What a slack is divided by to be a force: 1, or L/2 where it is a moment, shape (faces,)."""
        arm = self.half_length[self.face_joint]
        arm[: 2 * len(self.sliding)] = 1.0
        return arm

    @cached_property
    def ends(self) -> sp.csr_array:
        """1 where a joint (column) is one of a block's (row), shape (b, c)."""
        of_columns = abs(self.B) @ _selection(np.arange(3 * self.joints) % self.joints, self.joints)
        of_blocks = sp.csr_array(
            (np.ones(3 * self.blocks), (np.arange(3 * self.blocks) // 3, np.arange(3 * self.blocks)))
        )
        touched = (of_blocks @ of_columns).tocsr()
        touched.data[:] = 1.0
        return touched

    @cached_property
    def touching(self) -> tuple[np.ndarray, np.ndarray]:
        """Block and joint of every end of a joint on a movable block."""
        entries = self.ends.tocoo()
        return entries.row, entries.col

    @cached_property
    def longest_arm(self) -> np.ndarray:
        """Longest arm of a force on each block, half a joint's length at least, shape (b,)."""
        arms = abs(self.B[2::3, : 2 * self.joints]).max(axis=1).toarray().ravel()
        block, joint = self.touching
        np.maximum.at(arms, block, self.half_length[joint])
        return arms

    @cached_property
    def in_a_point(self) -> np.ndarray:
        """Whether each joint is a corner on an edge, which carries no moment, shape (c,)."""
        return np.diff(self.B[:, 2 * self.joints :].tocsc().indptr) == 0

    def slacks(self, q: np.ndarray, by_parabola: bool = False) -> np.ndarray:
        """Slack z of each face under forces q and the true friction law, eq. (4), shape (faces,): negative
        is a violation.

        Parameters
        ----------
        by_parabola: whether joints that can crush are held to the parabola, in place of each of its chords.
        """
        z = self.true_yield @ q + self.face_cohesion
        if by_parabola:
            n, _, m = q.reshape(3, -1)[:, self.crushing]
            most = self.half_length[self.crushing] * parabola(n, self.crushing_force)
            z[self.bent] = np.stack([most - m, most + m])[..., None]
        return z

    def energy(self, q: np.ndarray, p: np.ndarray, by_parabola: bool = False) -> float:
        """Σ |z p|: energy of faces that move without being at yield, in rates p, shape (faces,).

        Parameters
        ----------
        by_parabola: as of ``slacks``.
        """
        z = self.slacks(q)
        if not by_parabola:
            return float(np.abs(z * p).sum())
        joints, half = self.crushing, self.half_length[self.crushing]
        n, _, m = q.reshape(3, -1)[:, joints]
        bent = p[self.bent]
        opening, rotation = (bent.sum(axis=0) * CHORDS.slope).sum(axis=1), (bent[1] - bent[0]).sum(axis=1)
        given = crushing_energy(opening, rotation) * half * self.crushing_force
        taken = -n * half * opening - m * rotation
        z[self.bent] = 0.0
        return float(np.abs(z * p).sum() + np.abs(given - taken).sum())

    @cached_property
    def bent(self) -> np.ndarray:
        """Rocking faces and chords of the joints that can crush, (+) and (−), shape (2, l, chords)."""
        bends = np.flatnonzero(np.isin(self.face_joint, self.crushing))
        rocking, chords = np.split(bends[bends >= 2 * len(self.sliding)], [2 * len(self.crushing)])
        of_joints = (2, len(self.crushing), -1)
        return np.concatenate([rocking.reshape(of_joints), chords.reshape(of_joints)], axis=2)

    def rates(self, d: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Rates p ≥ 0 with which the joints could follow Bᵀd under a flow rule, shape (faces,).

        Slip gives the sliding rates, of one sense only; rotation and the opening that sliding does not
        explain give the rocking rates. Where the opening is too small for p ≥ 0, slip and rotation are
        kept, and ``Bᵀd − D p`` is the violation of the flow rule.

        Parameters
        ----------
        d: block velocities, shape (3b,).
        slope: opening per unit slip, shape (k,).
        """
        opening, slip, rotation = (self.B.T @ d).reshape(3, -1)
        slip = slip[self.sliding]
        opening[self.sliding] -= slope * np.abs(slip)
        both_edges = opening / self.lever
        about = np.maximum(np.stack([both_edges - rotation, both_edges + rotation]) / 2, 0.0)
        # Never more than the rotation demands when the joint cannot open that far.
        rock = np.where(both_edges >= np.abs(rotation), about, np.stack([-rotation, rotation]))
        crush = np.zeros((2, 0))
        if len(joints := self.crushing):
            # A joint that can crush follows every motion.
            both = chord_rates(opening[joints] / self.half_length[joints], rotation[joints])
            rock[:, joints], crush = both[..., 0], both[..., 1:].reshape(2, -1)
        return np.maximum(np.concatenate([-slip, slip, *rock, *crush]), 0.0)

    def unbalanced(self, load_factor: float, q: np.ndarray) -> np.ndarray:
        """What joint forces and loads leave of equilibrium, eq. (1), shape (3b,)."""
        return self.B @ q + load_factor * self.live + self.dead

    def departure(self, d: np.ndarray, p: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """What velocities and rates leave of the flow rule with that slope, Bᵀd − D p, shape (3c,)."""
        if slope is self.friction:
            flow = self.true_yield
        elif slope is self.dilatancy:
            flow = self._own_flow
        else:
            flow = self.C(slope)
        return self.B.T @ d - flow.T @ p

    @cached_property
    def _own_flow(self) -> sp.csr_array:
        """Transposed, the flow rule of the joints themselves."""
        return self.C(self.dilatancy)

    def slip(self, p: np.ndarray) -> np.ndarray:
        """Sliding of either sense, shape (k,), in rates p, shape (faces,)."""
        return self.both_senses.T @ p

    def normal_forces(self, q: np.ndarray) -> np.ndarray:
        """Normal forces of all joints, shape (c,), in forces q, shape (3c,)."""
        return q[: self.joints]

    @cached_property
    def part(self) -> np.ndarray:
        """Number of the connected part of the scene that each joint belongs to, shape (c,). Parts
        that share supports alone do not act on each other."""
        _, part = connected_components(self.ends.T @ self.ends, directed=False)
        return part

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

    @property
    def growth(self) -> Problem:
        """The same joints without cohesion and strength: its yield conditions are those of forces that can be
        added without end."""
        return replace(
            self, cohesion=np.zeros_like(self.cohesion), crushing_force=np.zeros_like(self.crushing_force)
        )

    def with_law(self, **law: np.ndarray) -> Problem:
        """The same blocks and joints under another law: ``friction``, ``cohesion``, ``dilatancy``, ..., and
        which joints slide and crush. Arrays that are the same stay the same objects."""
        same = {name: getattr(self, name) for name in law if np.array_equal(getattr(self, name), law[name])}
        problem = replace(self, **(law | same))
        if problem.same_matrices(self):
            known = vars(self)
            vars(problem).update({name: known[name] for name in _CACHED if name in known})
        return problem

    def same_matrices(self, other: Problem) -> bool:
        """Whether a problem differs from another, of which it was made, in the joints' law alone."""
        return all(getattr(self, name) is getattr(other, name) for name in _OF_MATRICES)

    def in_units_of(self, force: float) -> Problem:
        """The same problem with forces in units of ``force`` (itself in units of ``force_unit``)."""
        return replace(
            self,
            dead=self.dead / force,
            live=self.live / force,
            cohesion=self.cohesion / force,
            dilatancy_force=self.dilatancy_force / force,
            crushing_force=self.crushing_force / force,
            force_unit=self.force_unit * force,
        )


@dataclass(frozen=True)
class ShearLimits:
    """|s| ≤ cohesion + slope · n at each joint that can slide (eq. (4), Fig. 4).

    Attributes
    ----------
    slope, cohesion: shape (k,); the cohesion as a force.
    """

    slope: np.ndarray
    cohesion: np.ndarray

    @classmethod
    def true(cls, problem: Problem) -> ShearLimits:
        """The joints' own friction and cohesion; flow normal to them is associative (C = D)."""
        return cls(problem.friction, problem.cohesion)

    def at(self, n: np.ndarray) -> np.ndarray:
        """The largest |s| under normal forces n of the joints that can slide, shape (k,) each."""
        return self.cohesion + self.slope * n


def _selection(columns: np.ndarray, width: int) -> sp.csr_array:
    """Matrix that picks entries of a vector of that width, one a row."""
    count = len(columns)
    return sp.csr_array((np.ones(count), (np.arange(count), columns)), shape=(count, width))

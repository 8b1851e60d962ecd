"""The law of contacts that give, its corners rounded: one formula for joints and for contact points in space.

Normal forces n of trial forces n~ minimise |n - n~|²/2 - τ² Σ log z over the faces z ≥ 0 that bound them:
without crushing n = (n~ + √(n~² + 4 τ²)) / 2. A slip P takes k P off the size r of the trial shear, and opens
points by ψ P: k P = r - r L/M, with the limit L = c + μ Σ n and M = (L + r + √((L - r)² + 4 τ²)) / 2, which
is the larger of both but near the corner. Forces keep within limits; n·opening and (L - |s|)·P are some τ².
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from masonry_opt.problem.faces import CHORDS
from masonry_opt.problem.problem import Of, Problem

#: Newton's steps for the slip of joints that dilate, and for forces between chords, at most; and their end.
_STEPS, _FOUND = 60, 1e-13

#: Of forces between chords: the share that τ² falls to in a step, that a step goes towards a chord, and the
#: least slack over strength that numbers still tell.
_FALLS, _SHARE, _SLACK = 0.1, 0.95, 1e-12

#: Slip that is not past, in roundings of the law: with less, forces that hardly slip would fade.
_CORNER = 10.0

#: Normals of what bounds the normal forces of a joint of limited strength: n ≥ 0, then chords at both points;
#: and what these leave, over its strength.
_BOTH = np.stack([1 + CHORDS.slope, CHORDS.slope - 1], axis=1)
NORMALS = np.concatenate([np.eye(2), _BOTH, _BOTH[:, ::-1]])
_CONSTANTS = np.concatenate([np.zeros(2), CHORDS.constant, CHORDS.constant])

_REGULARISATION = 1e-12  #: Added to the diagonal of B Bᵀ, for blocks that some motion finds no force against.


def compliance(problem: Problem) -> np.ndarray:
    """Motion of each force of the problem per unit, shape (3c + t,): under the mean force that points bear, a
    joint of mean length, in space area, moves by one along its normal. Stiffness grows with length or area,
    and is half as large in shear as along the normal, as of stone."""
    c, t, points = problem.joints, problem.matrices.limited, problem.layout.points
    of_blocks = problem.B @ problem.B.T + _REGULARISATION * sp.eye_array(problem.dead.size)
    least = problem.B.T @ spsolve(of_blocks.tocsc(), -problem.dead)
    extent = np.append(problem.matrices.extent, np.ones(t))
    of_point = extent.mean() / extent / (np.abs(problem.at_points(least)).mean() or 1.0)
    of_shears = np.tile(2 / points * of_point[:c], 3 - points)
    return np.concatenate([np.tile(of_point[:c], points), of_shears, of_point[c:] / 2])


@dataclass(frozen=True)
class Rounded:
    """The law of the c joints of a problem, then of its t limited forces, m sliders in all.

    Their forces, n1, n2 and s, in space n, s and t, are of shape (3, m); limited forces are in the last row.
    """

    problem: Problem
    stiffness: np.ndarray  #: 1/E, shape (3, m), the same at both points of a joint
    slides: np.ndarray  #: which joints can slide, shape (c,)
    friction: np.ndarray  #: shape (c,), as the two that follow; zero where joints cannot slide
    dilatancy: np.ndarray
    cohesion: np.ndarray
    room: np.ndarray  #: of joints of limited strength, shape (faces, joints): ``NORMALS`` · n + room ≥ 0
    rounding: float  #: τ

    joints = Of[int]("problem")
    points = Of[int]("problem.layout")
    crushing = Of[np.ndarray]("problem")

    @classmethod
    def of(cls, problem: Problem, compliance: np.ndarray, rounding: float) -> "Rounded":
        """The law of a problem, its contacts giving by the compliance, shape (3c + t,)."""
        slides, of_joints = np.isin(np.arange(problem.joints), problem.sliding), np.zeros((3, problem.joints))
        of_joints[:, problem.sliding] = problem.friction, problem.dilatancy, problem.cohesion
        stiffness = 1 / _of_sliders(compliance, problem.joints, 1.0)
        friction, dilatancy, cohesion = of_joints
        room = np.outer(_CONSTANTS, problem.crushing_force)
        return cls(problem, stiffness, slides, friction, dilatancy, cohesion, room, rounding)

    @property
    def count(self) -> int:
        """Number of sliders, m."""
        return self.stiffness.shape[1]

    def of_sliders(self, q: np.ndarray) -> np.ndarray:
        """Forces of a problem, shape (3c + t,), by slider, shape (3, m)."""
        return _of_sliders(q, self.joints, 0.0)

    def of_problem(self, forces: np.ndarray) -> np.ndarray:
        """The other way round."""
        return np.concatenate([forces[:2, : self.joints].ravel(), forces[2]])

    def forces(self, trial: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces, shape (3, m), of trial forces, and their rates by these, shape (3, 3, m)."""
        forces, rates = np.zeros_like(trial), np.zeros((3, *trial.shape))
        c = self.joints
        forces[:, :c], rates[:, :, :c] = self._of_joints(trial[:, :c])
        if c < self.count:
            above, over = self._positive(trial[2, c:] - self.problem.highest)
            below, under = self._positive(self.problem.lowest - trial[2, c:])
            forces[2, c:], rates[2, 2, c:] = trial[2, c:] - above + below, 1 - over - under
        return forces, rates

    def without_slip(self, trial: np.ndarray) -> np.ndarray:
        """Trial forces, shape (3, m), that lead to the same forces without a slip but in rounded corners."""
        held, joints = trial.copy(), slice(self.joints)
        limit = self.cohesion + self.friction * self.forces(trial)[0][: self.points, joints].sum(axis=0)
        shears = held[self.points :, joints]
        size, most = np.sqrt((shears**2).sum(axis=0)), limit + _CORNER * self.rounding
        shears *= np.where(self.slides & (size > most), most / np.maximum(size, most), 1.0)
        return held

    def _positive(self, of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The positive part of numbers, rounded, and its derivative."""
        root = np.sqrt(of * of + 4 * self.rounding**2)
        larger = (np.abs(of) + root) / 2
        part = np.where(of > 0, larger, self.rounding**2 / larger)
        return part, part / root

    def _pressed(self, trial: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Normal forces, shape (points, c), and their rates, shape (points, points, c)."""
        forces, own = self._positive(trial)
        rates = np.eye(self.points)[..., None] * own
        if len(self.crushing):
            forces[:, self.crushing], rates[:, :, self.crushing] = self._crushed(trial[:, self.crushing])
        return forces, rates

    def _crushed(self, trial: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same of joints of limited strength, by Newton's steps for n and y = τ²/z, while τ falls."""
        inside = self.room.max(axis=0) / 8
        n = np.stack([inside, inside])
        z, size = NORMALS @ n + self.room, np.abs(trial - n).max(axis=0) + inside
        y, least = inside * size / z, np.maximum(self.rounding**2, _SLACK * inside * size)
        for _ in range(_STEPS):
            pull = np.maximum(least, _FALLS * (y * z).mean(axis=0))
            uphill = trial - n + NORMALS.T @ (pull / z)
            step = np.einsum("pqj,qj->pj", self._giving(y / z), uphill)
            towards = NORMALS @ step
            more = (pull - y * towards) / z - y
            shrinks = np.maximum(-towards / z, -more / y).max(axis=0)
            length = 1 / np.maximum(1.0, shrinks / _SHARE)
            n, y = n + length * step, y + length * more
            z = np.maximum(NORMALS @ n + self.room, _FOUND * inside)
            if (pull <= least).all() and (np.abs(step) <= _FOUND * size).all():
                break
        return n, self._giving(y**2 / least)

    @staticmethod
    def _giving(bends: np.ndarray) -> np.ndarray:
        """Inverse of 1 + Σ b a aᵀ over the normals a of faces that bend by b, shape (faces, joints), none of
        its terms a difference: some b are 1e30."""
        across = NORMALS[:, ::-1] * [1, -1]
        pairs = (across @ NORMALS.T) ** 2 / 2
        determinant = 1 + (NORMALS**2).sum(axis=1) @ bends + (bends * (pairs @ bends)).sum(axis=0)
        rates: np.ndarray = np.eye(2)[..., None] + np.einsum("fj,fp,fq->pqj", bends, across, across)
        return rates / determinant

    def _of_joints(self, trial: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        normal, shear = slice(self.points), slice(self.points, 3)
        stiff = self.stiffness[2, : self.joints]
        opens = self.stiffness[0, : self.joints] * self.dilatancy
        size = np.sqrt((trial[shear] ** 2).sum(axis=0) + self.rounding**2)
        slip = np.zeros_like(size)
        for _ in range(_STEPS):
            n, pressed = self._pressed(trial[normal] + opens * slip)
            by_normal = pressed.sum(axis=0)
            limit = self.cohesion + self.friction * n.sum(axis=0)
            apart = limit - size
            root = np.sqrt(apart * apart + 4 * self.rounding**2)
            most = (limit + size + root) / 2
            share = limit / most
            by_size = 1 - share + size * share / most * (1 - apart / root) / 2
            by_limit = -size / most * (1 - share * (1 + apart / root) / 2)
            stiffer = stiff - by_limit * self.friction * opens * by_normal.sum(axis=0)
            change = self.slides * (size * (1 - share) - stiff * slip) / stiffer
            slip = slip + change
            if not opens.any() or np.abs(stiff * change).max() <= _FOUND * size.max():
                break
        share = stiff * slip / size
        along = trial[shear] / size
        of_slip = np.concatenate([by_limit * self.friction * by_normal, by_size * along])
        of_slip = self.slides * of_slip / stiffer
        rates = np.zeros((3, *trial.shape))
        rates[normal, normal] = pressed
        rates[normal] += (opens * by_normal)[:, None] * of_slip
        kept = np.eye(3 - self.points)[..., None] * (1 - share)
        rates[shear, shear] = kept + share * along[:, None] * along
        rates[shear] -= stiff * along[:, None] * of_slip
        return np.concatenate([n, (1 - share) * trial[shear]]), rates


def _of_sliders(q: np.ndarray, joints: int, none: float) -> np.ndarray:
    forces = np.full((3, len(q) - 2 * joints), none)
    forces[:2, :joints], forces[2] = q[: 2 * joints].reshape(2, joints), q[2 * joints :]
    return forces

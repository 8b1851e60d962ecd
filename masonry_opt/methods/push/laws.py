"""The law of contacts that give, under a trial motion: cells, in which forces are linear.

Trial forces q~ = q0 - Bᵀd / E are what contacts would bear if they held everything. Normal forces (n1, n2) of
a joint are n~ + k ψ P (1, 1) brought back to the nearest that it can bear: n ≥ 0, or between chords of
crushing. The shear is s~ ∓ k P, with P > 0 the slip that brings it to its limit ± (c + μ (n1 + n2)) if s~ is
beyond it, else P = 0. Joint by joint that is z = C q + c ≥ 0, p ≥ 0, z·p = 0, Bᵀd + E (q - q0) = D p; with
normal forces found first it has no corner in which a joint is singular. A limited force is a slider without
points, between limits of its own. A *cell* says which faces of normal forces are at work, and which sliders
are at a limit.

*Bonded* contacts bear a tension t at each point: n + t takes the place of n, so that c + μ (n1 + n2 + 2 t)
limits the shear. Limits that this does not widen, of smooth sliders, of crushing and of limited forces, are
wider by t.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from masonry_opt.problem.chords import CHORDS
from masonry_opt.problem.problem import Problem

#: Friction below which bonds are a slider's cohesion; and above which paths turn in circles.
_SMOOTH, _STEEP = 1e-3, 1e3

#: Added to the diagonal of B Bᵀ, for blocks that some motion finds no force against.
_REGULARISATION = 1e-12

#: Rows of a table that are forces; what follows is left to boundaries.
FORCES = slice(3)

#: Rows of what is one of the five columns.
_ONE = np.eye(5)

#: A shear as the upper and the lower limit see it.
_SENSES = np.stack([_ONE[2], -_ONE[2]])


def takes(problem: Problem) -> bool:
    """Whether this is the law of the problem's joints: in the plane, of constant dilatancy, of no friction
    so large that numbers are lost, and without forces that have no limit (which stand for supports)."""
    free = np.isinf(problem.lowest) & np.isinf(problem.highest)
    beyond = (problem.friction > _STEEP) | (problem.friction * problem.dilatancy <= -1)
    return not (problem.layout.round or problem.dilatancy_depends_on_stress or free.any() or beyond.any())


def compliance(problem: Problem) -> np.ndarray:
    """Motion of each force of the problem per unit, shape (3c + t,): under the mean force that points bear, a
    joint of mean length moves by one along its normal. Stiffness grows with length, and is half as large in
    shear as along the normal, as of stone."""
    c, t = problem.joints, problem.matrices.limited
    of_blocks = problem.B @ problem.B.T + _REGULARISATION * sp.eye_array(problem.dead.size)
    least = problem.B.T @ spsolve(of_blocks.tocsc(), -problem.dead)
    extent = np.append(problem.matrices.extent, np.ones(t))
    of_point = extent.mean() / extent / (np.abs(least[: 2 * c]).mean() or 1.0)
    return np.concatenate([*3 * [of_point[:c]], of_point[c:] / 2])


class Cell(NamedTuple):
    """Which faces of normal forces are at work, shape (faces, m), and the limit, 1 or -1, that sliders are
    at, 0 where they hold, shape (m,)."""

    faces: np.ndarray
    slides: np.ndarray


@dataclass(frozen=True)
class Law:
    """The c joints of a problem, then its limited forces, m sliders in all.

    Their forces, n1, n2 and s, are of shape (3, m); limited forces have no n.

    Attributes
    ----------
    joints: their number c.
    stiffness: 1/E, shape (3, m), the same at both points of a joint.
    friction, dilatancy: μ and ψ, zero where nothing slides, shape (m,).
    limits: largest s, and -s, without normal force, ``inf`` where there is none, shape (2, m).
    bond: what a tension of one adds to both, but for friction's part, shape (m,).
    normals, room: faces of normal forces, normals · n + room ≥ 0, shapes (faces, 2, m) and (faces, m), zero
        where there is none.
    tension: that points bear besides that of bonds, shape (2, m).
    """

    joints: int
    stiffness: np.ndarray
    friction: np.ndarray
    dilatancy: np.ndarray
    limits: np.ndarray
    bond: np.ndarray
    normals: np.ndarray
    room: np.ndarray
    tension: np.ndarray

    @classmethod
    def of(cls, problem: Problem, compliance: np.ndarray) -> Law:
        """The law of a problem that it takes, its contacts giving by the compliance, shape (3c + t,)."""
        c, m = problem.joints, problem.joints + problem.matrices.limited
        friction, dilatancy, bond = np.zeros((3, m))
        limits = np.full((2, m), np.inf)
        friction[problem.sliding], dilatancy[problem.sliding] = problem.friction, problem.dilatancy
        limits[:, problem.sliding] = problem.cohesion
        limits[:, c:] = problem.highest, -problem.lowest
        bond[np.isfinite(limits).any(axis=0) & (friction < _SMOOTH)] = 1.0
        faces = 2 * len(CHORDS.slope) if len(problem.crushing) else 2
        normals, room, stiffness = np.zeros((faces, 2, m)), np.zeros((faces, m)), np.ones((3, m))
        normals[:2, :, :c] = np.eye(2)[:, :, None]
        both = np.stack([1 + CHORDS.slope, CHORDS.slope - 1], axis=1)
        for joint, force in zip(problem.crushing, problem.crushing_force, strict=True):
            normals[:, :, joint] = np.concatenate([both, both[:, ::-1]])
            room[:, joint] = np.tile(force * CHORDS.constant, 2)
        law = cls(c, stiffness, friction, dilatancy, limits, bond, normals, room, np.zeros((2, m)))
        stiffness[:] = 1 / law.of_sliders(compliance, 1.0)
        return law

    def loosened(self, by: np.ndarray) -> Law:
        """The law with limits wider by that much, shape (3, m), of points and of what bonds widen."""
        room = self.room + self.widened * by[:2].max(axis=0)
        return replace(self, tension=by[:2], limits=self.limits + self.bond * by[2], room=room)

    @cached_property
    def widened(self) -> np.ndarray:
        """What a tension of one adds to the room of faces, which else it may take away, shape (faces, m)."""
        return 2.0 * (self.room > 0)

    @cached_property
    def _inside(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """By slider the tension at its points, shape (m, 2, 5), room of faces (m, faces, 5), both limits
        without normal force (m, 2, 5), per unit of what a table has, and whether there are any (m, 2)."""
        m, finite = len(self.friction), np.isfinite(self.limits)
        loose, room, most = np.zeros((m, 2, 5)), np.zeros((m, len(self.room), 5)), np.zeros((m, 2, 5))
        loose[: self.joints, :, 3], loose[:, :, 4] = 1.0, self.tension.T
        room[..., 3], room[..., 4] = self.widened.T, self.room.T
        most[..., 3], most[..., 4] = self.bond[:, None], np.where(finite, self.limits, 0.0).T
        return loose, room, most, finite.T

    def of_sliders(self, q: np.ndarray, none: float = 0.0) -> np.ndarray:
        """Forces of a problem, shape (3c + t,), by slider, shape (3, m)."""
        c, m = self.joints, len(self.friction)
        forces = np.full((3, m), none)
        forces[:2, :c], forces[2] = q[: 2 * c].reshape(2, c), q[2 * c :]
        return forces

    def of_problem(self, forces: np.ndarray) -> np.ndarray:
        """The other way round."""
        return np.concatenate([forces[:2, : self.joints].ravel(), forces[2]])

    @property
    def inside(self) -> Cell:
        """The cell inside of all limits."""
        return Cell(np.zeros(self.room.shape, bool), np.zeros(len(self.friction), int))

    def table(self, cell: Cell) -> np.ndarray:
        """What all sliders do in a cell, shape (5 + faces, 5, m): see :meth:`column`."""
        return np.stack([self.column(cell, slider) for slider in range(len(self.friction))], axis=2)

    def column(self, cell: Cell, slider: int) -> np.ndarray:
        """What a slider does in a cell, shape (5 + faces, 5): by row n1, n2, s, then what is left to
        boundaries, ≥ 0 inside: to the faces, and to the upper and the lower limit; per unit of n1~, n2~, s~,
        of the bonds' tension, and in all. Zero where there is no boundary."""
        loose, room, most, finite = (of[slider] for of in self._inside)
        at, slides, (k, _, h) = cell.faces[:, slider], cell.slides[slider], self.stiffness[:, slider]
        normals, friction = self.normals[:, :, slider], self.friction[slider]
        dilates = k * self.dilatancy[slider]
        table = np.zeros((5 + len(at), 5))
        n, rates, free, back = loose.copy(), _ONE[:0], _ONE[:2, :2], _ONE[:2, :0]
        if slider < self.joints:
            n += _ONE[:2]
        if at.any():
            # Forces brought back to the faces at work, one or the two of a corner.
            faces, short = normals[at], room[at]
            if len(faces) == 2:
                back, free = np.linalg.inv(faces), 0.0 * free
            else:
                back = faces.T / (faces @ faces.T)
                free = free - back @ faces
            rates = -back.T @ (n + back @ short)
            n = free @ n - back @ short
        limits = most + friction * (n[0] + n[1])
        table[2] = _ONE[2]
        if slides:
            wedge = dilates * free.sum(axis=1)
            slip = slides * _ONE[2] - limits[0 if slides > 0 else 1]
            slip /= h + friction * (wedge[0] + wedge[1])
            table[2] -= slides * h * slip
            table[-2 if slides > 0 else -1] = slip
            if dilates:
                n += wedge[:, None] * slip
                rates = rates - dilates * back.sum(axis=0)[:, None] * slip
        else:
            table[-2:] = (limits - _SENSES) * finite[:, None]
        table[:2] = n - loose
        table[3:-2] = normals @ n + room
        table[3:-2][at] = rates
        return table

    def _no_room(self, faces: np.ndarray, slider: int) -> bool:
        """Whether the shear limits of a slider with these faces at work, shape (faces,), leave it no room, at
        the tip of a cone without cohesion: it is always at one of them."""
        corner = faces.sum() == 2 and not self.room[faces, slider].any()
        return bool(corner and not self.limits[:, slider].any())

    def across(self, cell: Cell, boundary: int) -> tuple[Cell, int, int, str]:
        """The cell beyond a boundary, by its index among those of all sliders, shape (faces + 2, m); the
        boundary's index there; the slider that it is of, and what it does."""
        row, slider = divmod(boundary, m := len(self.friction))
        faces, slides = cell.faces.copy(), cell.slides.copy()
        beyond = Cell(faces, slides)
        if row < len(faces):
            faces[row, slider] = not faces[row, slider]
            if slides[slider] == 0 and self._no_room(faces[:, slider], slider):
                slides[slider] = 1
            crushes = self.room[row, slider] > 0
            words = ("holds", "crushes") if crushes else ("closes", "opens")
            return beyond, boundary, slider, words[int(faces[row, slider])]
        sense = 1 if row == len(faces) else -1
        if self._no_room(faces[:, slider], slider):
            slides[slider], boundary = -sense, boundary + sense * m
        else:
            slides[slider] = 0 if slides[slider] else sense
        words = ("sticks", "slides") if slider < self.joints else ("holds", "yields")
        return beyond, boundary, slider, words[int(slides[slider] != 0)]

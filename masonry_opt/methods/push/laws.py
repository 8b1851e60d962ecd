"""The law of contacts that give, under a trial motion: cells, in which forces are linear, and their boundaries.

Trial forces q~ = q0 - Bᵀd / E are what contacts would bear if they held everything. A point bears
n = max(0, n~ + k ψ P); a slider s = s~ ∓ k P, with P > 0 the slip that brings s to its limit ± (c + μ (n1 + n2))
if s~ is beyond it, else P = 0. Joint by joint that is z = C q + c ≥ 0, p ≥ 0, z·p = 0, Bᵀd + E (q - q0) = D p;
with the normal forces found first it has no corner in which a joint is singular. A limited force is a slider
without points, between limits of its own. A *cell* says which points press and which sliders are at a limit.

*Bonded* contacts bear a tension t at each point: n ≥ -t, and c + μ (n1 + n2 + 2 t) limits the shear. Limits that
friction does not widen so, of smooth sliders and of limited forces, are wider by t.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import lsqr

from masonry_opt.problem.problem import Problem

#: Friction below which bonds are a slider's cohesion.
_SMOOTH = 1e-3

#: Guesses of which points press as a joint dilates: the slip falls to its value, past three corners at most.
_GUESSES = 5

#: Rows and columns of a table: forces, then what is left to boundaries; trial forces, the bond, one.
FORCES, GAPS = slice(3), slice(3, 7)


def takes(problem: Problem) -> bool:
    """Whether this is the law of the problem's joints: in the plane, of any strength, of constant dilatancy,
    and without forces that have no limit (which stand for supports)."""
    free = np.isinf(problem.lowest) & np.isinf(problem.highest)
    contracts = problem.friction * problem.dilatancy <= -1
    crushes = len(problem.crushing) > 0
    return not (
        problem.layout.round or crushes or problem.dilatancy_depends_on_stress or free.any() or contracts.any()
    )


def compliance(problem: Problem) -> np.ndarray:
    """Motion of each force of the problem per unit, shape (3c + t,): under the mean force that points bear, a
    joint of mean length moves by one along its normal. Stiffness grows with length, and is half as large in
    shear as along the normal, as of stone."""
    c, t = problem.joints, problem.matrices.limited
    least = lsqr(problem.B, -problem.dead, atol=1e-8, btol=1e-8, iter_lim=300)[0]
    extent = np.append(problem.matrices.extent, np.ones(t))
    of_point = extent.mean() / extent / (np.abs(least[: 2 * c]).mean() or 1.0)
    return np.concatenate([*3 * [of_point[:c]], of_point[c:] / 2])


class Cell(NamedTuple):
    """Which points press, shape (2, m), and the limit, 1 or -1, that sliders are at, 0 where they hold, shape
    (m,)."""

    presses: np.ndarray
    slides: np.ndarray


@dataclass(frozen=True)
class Law:
    """The c joints of a problem, then its limited forces, m sliders in all.

    Their forces, n1, n2 and s, are of shape (3, m); limited forces have no n.

    Attributes
    ----------
    joints: their number c.
    stiffness: 1/E, shape (3, m).
    friction, dilatancy: μ and ψ, zero where nothing slides, shape (m,).
    limits: largest s, and -s, without normal force, ``inf`` where there is none, shape (2, m).
    bond: what a tension of one adds to both, but for friction's part, shape (m,).
    tension: that points bear besides that of bonds, shape (2, m).
    """

    joints: int
    stiffness: np.ndarray
    friction: np.ndarray
    dilatancy: np.ndarray
    limits: np.ndarray
    bond: np.ndarray
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
        stiffness = np.ones((3, m))
        law = cls(c, stiffness, friction, dilatancy, limits, bond, np.zeros((2, m)))
        stiffness[:] = 1 / law.of_sliders(compliance, 1.0)
        return law

    def loosened(self, by: np.ndarray) -> Law:
        """The law with limits wider by that much of points and of what bonds widen, shape (3, m)."""
        return replace(self, tension=by[:2], limits=self.limits + self.bond * by[2])

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
    def bonded(self) -> Cell:
        """The cell in which bonds hold everything."""
        presses, slides = np.zeros((2, len(self.friction)), bool), np.zeros(len(self.friction), int)
        presses[:, : self.joints] = True
        return Cell(presses, slides)

    def cell(self, trial: np.ndarray) -> Cell:
        """The cell that trial forces, shape (3, m), lie in, without bonds."""
        presses, slides = self.bonded
        sense = np.where(trial[2] < 0, -1, 1)
        limit = np.where(sense > 0, *self.limits)
        normal, k, slip = trial[:2] + self.tension, self.stiffness[:2], np.zeros(len(sense))
        for _ in range(_GUESSES):
            presses[:, : self.joints] = (normal + k * self.dilatancy * slip > 0)[:, : self.joints]
            beyond = sense * trial[2] - limit - self.friction * (presses * normal).sum(axis=0)
            slip = np.maximum(beyond, 0.0) / self._slips(presses)
        return Cell(presses, np.where((slip > 0) | self._loose(presses, 0.0), sense, slides))

    def _slips(self, presses: np.ndarray) -> np.ndarray:
        """Shear beyond its limit per unit of slip, shape (m,)."""
        wedged: np.ndarray = (presses * self.stiffness[:2]).sum(axis=0)
        return self.stiffness[2] + self.friction * self.dilatancy * wedged

    def _loose(self, presses: np.ndarray, bonds: float) -> np.ndarray:
        """Whether limits leave a slider no room throughout a cell, shape (m,): it is always at one of them."""
        room = self.limits.sum(axis=0) + bonds * self.bond
        return (room == 0) & ((self.friction == 0) | ~presses.any(axis=0))

    def table(self, cell: Cell, of: np.ndarray | slice = slice(None)) -> np.ndarray:
        """What sliders do in a cell, shape (7, 5, m): by row n1, n2, s, then what is left to boundaries, ≥ 0
        inside: of the points, and at the upper and the lower limit; per unit of n1~, n2~, s~, of the bond, and
        in all. Zero where there is no boundary."""
        presses, slides = cell.presses[:, of].astype(float), cell.slides[of]
        friction, bond, limits = self.friction[of], self.bond[of], self.limits[:, of]
        k, unit = self.stiffness[:, of], np.eye(5)[:, :, None]
        points = np.broadcast_to(np.arange(len(self.friction)) < self.joints, len(self.friction))[of]
        finite = np.isfinite(limits)
        # Limit of the shear in either sense, and the slip by which it is kept.
        most = np.zeros((2, 5, len(slides)))
        most[:, :2], most[:, 3] = friction * presses, bond + friction * presses.sum(axis=0)
        tension = self.tension[:, of]
        most[:, 4] = np.where(finite, limits, 0.0) + friction * (presses * tension).sum(axis=0)
        slip = slides * unit[2] - np.where(slides > 0, *most)
        slip *= (slides != 0) / self._slips(cell.presses)[of]
        table = np.zeros((7, 5, len(slides)))
        for point in range(2):
            loose = unit[3] + unit[4] * tension[point]
            reached = unit[point] + loose + k[point] * self.dilatancy[of] * slip
            table[point] = points * (presses[point] * reached - loose)
            table[3 + point] = points * np.where(presses[point] > 0, reached, -reached)
        table[2] = unit[2] - slides * k[2] * slip
        for row, sense in enumerate((1, -1)):
            holds = finite[row] * (slides == 0)
            table[5 + row] = np.where(slides == sense, slip, holds * (most[row] - sense * unit[2]))
        return table

    def across(self, cell: Cell, boundary: int, bonds: float) -> tuple[Cell, int, int, str]:
        """The cell beyond a boundary, by its index among the gaps, shape (4, m); the boundary's index there;
        the slider that it is of, and what it does."""
        m = len(self.friction)
        row, slider = divmod(boundary, m)
        presses, slides = cell.presses.copy(), cell.slides.copy()
        if row < 2:
            presses[row, slider] = not presses[row, slider]
            if slides[slider] == 0 and self._loose(presses, bonds)[slider]:
                slides[slider] = 1
            return Cell(presses, slides), boundary, slider, "closes" if presses[row, slider] else "opens"
        sense = 1 if row == 2 else -1
        if self._loose(presses, bonds)[slider]:
            slides[slider], boundary = -sense, boundary + sense * m
        else:
            slides[slider] = 0 if slides[slider] else sense
        words = ("sticks", "slides") if slider < self.joints else ("holds", "yields")
        return Cell(presses, slides), boundary, slider, words[int(slides[slider] != 0)]

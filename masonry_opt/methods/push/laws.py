"""The law of contacts that give, under a trial motion: cells, in which forces are linear, and their boundaries.

Trial forces q~ = q0 - Bᵀd / E are what contacts would bear if they held everything. A point bears
n = max(lowest, n~ + k ψ P); a slider s = s~ - (±) k P, with P > 0 the slip at which s is on its limit
± (c + μ (n1 + n2)), if s~ is beyond it, else P = 0; a limited force T = T~ between its limits. That is
z = C q + c ≥ 0, p ≥ 0, z·p = 0, Bᵀd + E (q - q0) = D p, joint by joint; with the normal forces found first it
has no corner in which a joint is singular. A *cell* says which points press, which sliders slide in which
sense, which forces are at a limit.

*Bonded* contacts bear a tension t at each point, and limits are wider by t: n ≥ -t, c + μ (n1 + n2 + 2 t),
lowest - t ≤ T ≤ highest + t. (Of sliders without friction the cohesion is t.)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import lsqr

from masonry_opt.problem.problem import Problem

#: Friction below which bonded sliders have a cohesion of t besides.
_SMOOTH = 1e-3

#: Guesses of which points press as a joint dilates: the slip falls to its value, past three corners at most.
_GUESSES = 5


def takes(problem: Problem) -> bool:
    """Whether the law is that of the problem's joints: in the plane, crushing nowhere, a dilatancy that is
    constant, and no force without limits (which stands for a support)."""
    free = np.isinf(problem.lowest) & np.isinf(problem.highest)
    return not (
        problem.layout.round
        or len(problem.crushing)
        or problem.dilatancy_depends_on_stress
        or free.any()
        or (problem.friction * problem.dilatancy <= -1).any()
    )


def compliance(problem: Problem) -> np.ndarray:
    """Motion of each force of the problem per unit, shape (3c + t,): a joint of mean length moves by one
    along its normal under the mean force that its points bear. Stiffness grows with length, and is half as
    large in shear as along the normal, as of stone."""
    c, t = problem.joints, problem.matrices.limited
    least = lsqr(problem.B, -problem.dead, atol=1e-8, btol=1e-8, iter_lim=300)[0]
    extent = np.append(problem.matrices.extent, np.ones(t))
    of_point = extent.mean() / extent / (np.abs(least[: 2 * c]).mean() or 1.0)
    return np.concatenate([*3 * [of_point[:c]], of_point[c:] / 2])


@dataclass(frozen=True)
class Cell:
    """Which points press, shape (2, c); the sense in which sliders slide, 0 where they stick, shape (c,); the
    limit that limited forces are at, -1, 1 or 0 for none, shape (t,)."""

    presses: np.ndarray
    slides: np.ndarray
    limit: np.ndarray


class Response(NamedTuple):
    """Forces q, shape (3c + t,), and what is left to each boundary of the cell, ≥ 0 inside, ``inf`` where
    there is none: of points (2c,), sliders against either limit (2c,), forces against either limit (2t,)."""

    q: np.ndarray
    gaps: np.ndarray


@dataclass(frozen=True)
class Law:
    """Joints and limited forces of a problem, by joint: μ, c, ψ of all, ``inf`` friction where none slides.

    Attributes
    ----------
    stiffness: 1/E, shape (3c + t,).
    friction, cohesion, dilatancy: shape (c,), zero where a joint cannot slide.
    bond: what a tension of one adds to the cohesion of bonded sliders, shape (c,), but for friction's part.
    sliding: whether friction is limited, shape (c,).
    lowest, highest: of limited forces, shape (t,).
    """

    stiffness: np.ndarray
    friction: np.ndarray
    cohesion: np.ndarray
    dilatancy: np.ndarray
    bond: np.ndarray
    sliding: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray

    @classmethod
    def of(cls, problem: Problem, compliance: np.ndarray) -> Law:
        """The law of a problem that it takes, its contacts giving by the compliance, shape (3c + t,)."""
        friction, cohesion, dilatancy, bond = np.zeros((4, problem.joints))
        at, sliding = problem.sliding, np.zeros(problem.joints, bool)
        friction[at], cohesion[at], dilatancy[at] = problem.friction, problem.cohesion, problem.dilatancy
        sliding[at] = True
        bond[sliding & (friction < _SMOOTH)] = 1.0
        limits = problem.lowest, problem.highest
        return cls(1 / compliance, friction, cohesion, dilatancy, bond, sliding, *limits)

    @property
    def joints(self) -> int:
        """Number of joints, c."""
        return len(self.friction)

    def parts(self, of_forces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normal (2, c), shear (c,) and limited forces (t,)."""
        c = self.joints
        return of_forces[: 2 * c].reshape(2, c), of_forces[2 * c : 3 * c], of_forces[3 * c :]

    def cell(self, trial: np.ndarray, bonded: float = 0.0) -> Cell:
        """The cell that trial forces, shape (3c + t,), lie in."""
        normal, shear, T = self.parts(trial)
        cohesion = self.cohesion + bonded * self.bond
        sense = np.where(shear < 0, -1, 1)
        k, stiff, slip = *self.parts(self.stiffness)[:2], np.zeros(self.joints)
        for _ in range(_GUESSES):
            presses = normal + k * self.dilatancy * slip > -bonded
            beyond = np.abs(shear) - cohesion - self.friction * (presses * (normal + bonded)).sum(axis=0)
            slips = stiff + self.friction * self.dilatancy * (presses * k).sum(axis=0)
            slip = np.where(self.sliding, np.maximum(beyond, 0.0) / (slips + self._shear_stiffness), 0.0)
        # Without a limit a slider never sticks: its sense is that of the trial shear.
        slides = np.where(self.sliding & ((slip > 0) | self._free(presses, bonded)), sense, 0)
        limit = (T >= self.highest + bonded).astype(int) - (T <= self.lowest - bonded)
        return Cell(presses, slides, limit)

    @property
    def holds_all(self) -> Cell:
        """The cell in which all points press, no slider slides and no force is at a limit."""
        c, t = self.joints, len(self.lowest)
        return Cell(np.ones((2, c), bool), np.zeros(c, int), np.zeros(t, int))

    @property
    def _shear_stiffness(self) -> np.ndarray:
        return self.parts(self.stiffness)[1]

    def _free(self, presses: np.ndarray, bonded: float) -> np.ndarray:
        """Whether the limit of a slider is zero throughout a cell, shape (c,)."""
        no_cohesion = (self.cohesion == 0) & ((self.bond == 0) | (bonded == 0))
        return self.sliding & no_cohesion & ((self.friction == 0) | ~presses.any(axis=0))

    def response(self, cell: Cell, trial: np.ndarray, bonded: float, rate: bool = False) -> Response:
        """Forces under trial forces, shape (3c + t,), by the law of a cell, whether or not they lie in it;
        with ``rate`` their change, and that of what is left to boundaries, with those of q~ and t."""
        normal, shear, T = self.parts(trial)
        k, h, _ = self.parts(self.stiffness)
        whole, nowhere = (0.0, 0.0) if rate else (1.0, np.inf)
        presses, slides = cell.presses, cell.slides
        cohesion = whole * self.cohesion + bonded * self.bond
        held = np.where(presses, normal + bonded, 0.0)
        limit = cohesion + self.friction * held.sum(axis=0)
        moves = slides != 0
        slip = moves * (slides * shear - limit)
        slip /= h + self.friction * self.dilatancy * (k * presses).sum(axis=0)
        reached = normal + bonded + k * self.dilatancy * slip
        lowest, highest = (
            np.where(np.isfinite(of), whole * np.where(np.isfinite(of), of, 0.0) + wider, sign * nowhere)
            for of, wider, sign in ((self.lowest, -bonded, -1), (self.highest, bonded, 1))
        )
        q = np.concatenate(
            [
                (np.where(presses, reached, 0.0) - bonded).ravel(),
                shear - slides * h * slip,
                np.select([cell.limit < 0, cell.limit > 0], [lowest, highest], T),
            ]
        )
        # A slider that slides has one boundary, that of its sense.
        of_sliders = (
            np.where(moves, np.where(slides == sense, slip, nowhere), limit - sense * shear)
            for sense in (1, -1)
        )
        none = np.full(len(T), nowhere)
        gaps = [
            np.where(presses, reached, -reached).ravel(),
            *(np.where(self.sliding, gap, nowhere) for gap in of_sliders),
            np.select([cell.limit < 0, cell.limit > 0], [lowest - T, none], T - lowest),
            np.select([cell.limit > 0, cell.limit < 0], [T - highest, none], highest - T),
        ]
        return Response(q, np.concatenate(gaps))

    def slope(self, cell: Cell) -> tuple[np.ndarray, np.ndarray]:
        """∂q/∂q~ of the joints, shape (3, 3, c), and of the limited forces, shape (t,)."""
        k, h, _ = self.parts(self.stiffness)
        moves, presses = cell.slides != 0, cell.presses.astype(float)
        own = np.concatenate([presses, np.ones((1, self.joints))])
        limit = np.concatenate([-self.friction * presses, cell.slides[None]])
        flow = np.concatenate([presses * k * self.dilatancy, -(cell.slides * h)[None]])
        flow = moves * flow / (h + self.friction * self.dilatancy * (k * presses).sum(axis=0))
        slope = flow[:, None] * limit
        slope[range(3), range(3)] += own
        return slope, (cell.limit == 0).astype(float)

    def across(self, cell: Cell, boundary: int, bonded: float) -> tuple[Cell, int, int, str]:
        """The cell beyond a boundary, by its index among the gaps; the boundary's index there; the joint or
        limited force (c and on) that it is of, and what happens."""
        c, t = self.joints, len(self.lowest)
        presses, slides, limit = cell.presses.copy(), cell.slides.copy(), cell.limit.copy()
        row, joint = divmod(boundary, c)
        if row < 2:
            presses[row, joint] = not presses[row, joint]
            word = "closes" if presses[row, joint] else "opens"
            if not slides[joint] and self._free(presses, bonded)[joint]:
                slides[joint] = 1
        elif row < 4:
            sense = 1 if row == 2 else -1
            free = self._free(presses, bonded)[joint]
            slides[joint] = -sense if free else 0 if slides[joint] else sense
            boundary += (sense * c) if free else 0
            word = "slides" if slides[joint] else "sticks"
        else:
            above, force = divmod(boundary - 4 * c, t)
            joint = c + force
            limit[force] = 0 if limit[force] else 1 if above else -1
            word = "yields" if limit[force] else "holds"
        return replace(cell, presses=presses, slides=slides, limit=limit), boundary, joint, word

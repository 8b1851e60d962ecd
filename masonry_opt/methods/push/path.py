"""The path of contacts that give: straight in each cell, followed from boundary to boundary.

In a cell forces are q = J q~ + const, q~ = q0 - k Bᵀd. What changes them is a live load that grows with its
displacement u (a *push*), or the bonds of contacts, which fall (*settling*):

    B q + λ f + f_D = 0,  f·d = u          d' from  S d' - λ' f = 0,  f·d' = u'
    B q(t) + f_D = 0                       d' from  S d' = B ∂q/∂t t'             with S = B J k Bᵀ

Through a boundary the path goes into the next cell: where that makes u or t turn, it folds.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import inf

import numpy as np

from masonry_opt.methods.push.blocks import Blocks, Factors
from masonry_opt.methods.push.laws import FORCES, Cell, Law

#: Rates over that of the trial forces, of forces, gaps and bonds, that are rounding.
_FLAT = 1e-12

#: Faces of a joint's two normal forces at work at once, at a corner. Where falling bonds bring a third there
#: a path is given up.
_MOST_FACES = 2

#: More boundaries than any cell has.
_LOST = 2**62

#: Boundaries of a joint that its trial forces may be beyond, one after another.
_AT_MOST = 8

#: With sliders added: share by which a second solve may change a direction, and least rate at a boundary.
_TRUSTED = 1e-6


class End(StrEnum):
    """How a path ends: where bonds bear nothing; on a ray, on which forces stay, or grow; or before."""

    FREE = "free"
    RAY = "ray"
    JAM = "jam"
    BUDGET = "budget"


@dataclass(frozen=True)
class Event:
    """A boundary met at u, or t, and λ, of the path's own live load until the push tells it; the joint,
    or limited force (c and on), and what it does."""

    at: float
    load_factor: float
    joint: int
    what: str


@dataclass
class Path:
    """A path, and the point that it has come to.

    Attributes
    ----------
    law, blocks: of the contacts.
    rest: forces q0 that contacts give from, shape (3, m).
    dead, live: loads, shape (3b,); without a live load contacts settle, as bonds fall.
    cell: of the point; that of its trial forces unless given.
    d, load_factor: displacements, shape (3b,), and λ.
    drive: u, or the tension t that bonds bear.
    events: that were met.
    highest: λ, the cell and the drive of the event with the largest λ.
    ahead: d' at the end, shape (3b,), and u'.
    """

    law: Law
    blocks: Blocks
    rest: np.ndarray
    dead: np.ndarray
    live: np.ndarray | None
    cell: Cell | None
    d: np.ndarray
    load_factor: float = 0.0
    drive: float = 0.0
    events: list[Event] = field(default_factory=list)
    highest: tuple[float, Cell, float] | None = None
    ahead: tuple[np.ndarray, float] | None = None

    def __post_init__(self) -> None:
        self._entered: int | None = None
        near, self._cell = self.cell is None, self.cell or self.law.inside
        self._table = self.law.table(self._cell)
        if near:
            self._over_boundaries()
        self._factorise()
        self._correct()

    @property
    def _bonds(self) -> float:
        return self.drive if self.live is None else 0.0

    @property
    def trial(self) -> np.ndarray:
        """Trial forces, shape (3, m)."""
        return self.rest + self._trial_rate(self.d)

    @property
    def forces(self) -> np.ndarray:
        """Forces, shape (3, m), by the law of the cell."""
        return self._by_table(self.trial, self._bonds, 1.0, FORCES)

    def _trial_rate(self, d: np.ndarray) -> np.ndarray:
        rate: np.ndarray = -self.law.stiffness * (self.blocks.Bt @ d).reshape(3, -1)
        return rate

    def _by_table(self, trial: np.ndarray, bonds: float, one: float, rows: slice) -> np.ndarray:
        """Forces, or what is left to boundaries, by the law of the cell, shape (rows, m); rates of them."""
        known = np.empty((5, trial.shape[1]))
        known[:3], known[3], known[4] = trial, bonds, one
        return np.einsum("rkm,km->rm", self._table[rows], known)

    def _factorise(self) -> None:
        self._factors = Factors(self.blocks, self._table[FORCES, :3] * self.law.stiffness)

    def _solved(self, at: np.ndarray, one: float) -> np.ndarray:
        """d and λ, shape (3b + 1,), after a step by the equations of the cell, at the same u or t; with zero
        for ``one``, d' and λ' per unit of these. A second step takes off rounding: S, a sum over joints, has
        lost what is small beside their stiffnesses, the joints' own equations have not."""
        drive, settles = self.drive if one else 1.0, self.live is None
        trial = one * self.rest + self._trial_rate(at[:-1])
        forces = self._by_table(trial, drive if settles else 0.0, one, FORCES)
        left, work = self.blocks.B @ forces.ravel() + one * self.dead, -at[-1]
        if not settles:
            left, work = left + at[-1] * self.live, drive - self.live @ at[:-1]
        solved: np.ndarray = at + self._factors.solve(np.append(left, work))
        return solved

    def _correct(self) -> None:
        """Bring the point onto the path."""
        at = self._solved(np.append(self.d, self.load_factor), 1.0)
        self.d, self.load_factor = at[:-1], float(at[-1])

    def _direction(self, way: int) -> tuple[np.ndarray, float, np.ndarray, np.ndarray]:
        """d' and λ', the drive's rate, and rates of forces and of what is left to boundaries, per unit of the
        largest rate of trial forces: away from the boundary by which the cell was entered."""
        once = self._solved(np.zeros(self.blocks.size), 0.0)
        along = self._solved(once, 0.0)
        if not self._factors.fresh and not np.abs(along - once).max() < _TRUSTED * np.abs(along).max():
            self._factorise()
            return self._direction(way)
        settles, trial = float(self.live is None), self._trial_rate(along[:-1])
        rate = self._by_table(trial, settles, 0.0, slice(None))
        if self._entered is not None:
            way = 1 if rate[3:].flat[self._entered] > 0 else -1
        drive = way / max(np.abs(trial).max(), settles)
        return drive * along, drive, drive * rate[FORCES], drive * rate[3:].ravel()

    def comes_into_its_cell(self) -> bool:
        """Whether Newton's steps at the same u lead into the cell that trial forces are in, from a point near
        the path; each is to halve the number of boundaries that these are beyond."""
        before = _LOST
        while beyond := self._over_boundaries():
            if beyond > before / 2:
                return False
            before = beyond
            self._factorise()
            self._correct()
        return True

    def _over_boundaries(self) -> int:
        """Take the cell of the trial forces, joint by joint; how many boundaries they were beyond."""
        over = 0
        for _ in range(_AT_MOST):
            gaps = self._by_table(self.trial, self._bonds, 1.0, slice(3, None))
            sliders = np.flatnonzero(gaps.min(axis=0) < 0.0)
            if not len(sliders):
                break
            for slider, row in zip(sliders, gaps[:, sliders].argmin(axis=0), strict=True):
                if self._crossed(int(row * gaps.shape[1] + slider)) is None:
                    return _LOST
            over += len(sliders)
        return over

    def _crossed(self, boundary: int) -> tuple[int, int, str] | None:
        """Go over a boundary into the next cell: its index there, the slider that it is of, and what that
        does; None where a third face would come to a corner."""
        cell, entered, slider, what = self.law.across(self._cell, boundary)
        if cell.faces[:, slider].sum() > _MOST_FACES:
            return None
        self._cell = cell
        self._table[..., slider] = self.law.column(cell, slider)
        return entered, slider, what

    def follow(self, way: int, most: int) -> End:
        """Follow the path, or go on following it, to its end, or until there are so many events.

        Parameters
        ----------
        way: whether the drive grows at first, 1, or falls, -1.
        """
        settles = self.live is None
        if settles and self.drive == 0:
            return End.FREE
        while len(self.events) < most:
            along, drive, forces, rates = self._direction(way)
            nears = np.flatnonzero(rates < -_FLAT)
            gaps = self._by_table(self.trial, self._bonds, 1.0, slice(3, None)).ravel()[nears]
            steps = np.maximum(gaps, 0.0) / -rates[nears]
            nearest = int(steps.argmin()) if len(nears) else -1
            step = float(steps[nearest]) if len(nears) else inf
            if settles and drive < -_FLAT and self.drive <= -drive * step:
                self._move(along, 0.0, -self.drive / drive)
                return End.FREE
            if not self._factors.fresh and (step == inf or rates[nears[nearest]] > -_TRUSTED):
                self._factorise()
                continue
            if step == inf:
                self.ahead = along[:-1], drive
                return End.RAY if np.abs(forces).max() < _FLAT else End.JAM
            self._move(along, self.drive + step * drive, step)
            crossed = self._crossed(int(nears[nearest]))
            if crossed is None:
                break
            self._entered, slider, what = crossed
            if not self._factors.add(slider, self._table[FORCES, :3] * self.law.stiffness):
                self._factorise()
            self._correct()
            self.events.append(Event(self.drive, self.load_factor, slider, what))
            if self.highest is None or self.load_factor > self.highest[0]:
                self.highest = self.load_factor, self._cell, self.drive
        return End.BUDGET

    def _move(self, along: np.ndarray, drive: float, step: float) -> None:
        self.d = self.d + step * along[:-1]
        self.load_factor += step * along[-1]
        self.drive = drive

    def by(self, law: Law, cell: Cell | None = None, drive: float = 0.0) -> Path:
        """The point at u or t by the equations of a cell, by default that of the end, of another law. On a
        ray its forces and λ are the same at all u."""
        still = np.zeros_like(self.d)
        return replace(self, law=law, cell=cell or self._cell, d=still, load_factor=0.0, drive=drive)

"""The path of contacts that give: straight in each cell, followed from boundary to boundary.

In a cell forces are q = J q~ + const, q~ = q0 - k Bᵀd. What changes them is a live load that grows with its
displacement u (a *push*), or the bonds of contacts, which fall (*settling*):

    B q + λ f + f_D = 0,  f·d = u          d' from  S d' - λ' f = 0,  f·d' = u'
    B q(t) + f_D = 0                       d' from  S d' = B ∂q/∂t t'             with S = B J k Bᵀ

Through a boundary the path goes into the next cell: where that makes u or t turn, it folds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import inf
from time import perf_counter
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.linalg import lapack
from scipy.sparse.linalg import splu

from masonry_opt.methods.push.laws import FORCES, Cell, Law
from masonry_opt.problem.problem import Problem

#: Unknowns up to which matrices are full: LAPACK has little overhead.
_FULL_UP_TO = 250

#: Added to the diagonal of S, over its largest stiffness, for cells in which a block hangs on nothing.
_REGULARISATION = 1e-15

#: Rates over that of the trial forces, of forces, gaps and bonds, that are rounding.
_FLAT = 1e-12

#: Sliders whose change is added to factors, before these are made anew; from so many unknowns on.
_ADDED, _ADDED_FROM = 20, 100

#: With sliders added, share by which a second solve may change a direction, and least rate of the nearest gap.
_TRUSTED = 1e-6

_Solve = Callable[[np.ndarray], np.ndarray]


class End(StrEnum):
    """How a path ends: where bonds bear nothing; on a ray, on which forces stay, or grow; or before."""

    FREE = "free"
    RAY = "ray"
    JAM = "jam"
    BUDGET = "budget"


class Event(NamedTuple):
    """A boundary met at u, or t, and λ; the joint, or limited force (c and on), and what it does."""

    at: float
    load_factor: float
    joint: int
    what: str


class Blocks:
    """The matrix of the blocks, bordered by a live load: [[S, -f], [fᵀ, 0]]; without one [[S, 0], [0, 1]].

    Attributes
    ----------
    B: by slider, shape (3b, 3m), and its transpose ``Bt``.
    """

    def __init__(self, problem: Problem, law: Law, live: np.ndarray | None) -> None:
        B, m = problem.B.tocoo(), len(law.friction)
        column = np.flatnonzero(law.of_sliders(np.ones(B.shape[1])))[B.col]
        self.B = sp.csr_array((B.data, (B.row, column)), shape=(B.shape[0], 3 * m))
        self.Bt, self.size = self.B.T.tocsr(), B.shape[0] + 1
        # Every two entries of B in columns of one slider, and the entry of S that they add to.
        order = np.argsort(column % m, kind="stable")
        row, kind, slider, value = B.row[order], column[order] // m, column[order] % m, B.data[order]
        count = np.bincount(slider, minlength=m)[slider]
        one = np.repeat(np.arange(len(row)), count)
        start = np.searchsorted(slider, slider) - np.cumsum(count) + count
        other = np.arange(len(one)) + np.repeat(start, count)
        at = [row[other] * self.size + row[one]]
        border = np.arange(self.size - 1)
        at += [
            border * (self.size + 1),
            border * self.size + border[-1] + 1,
            (border[-1] + 1) * self.size + border,
        ]
        at += [np.array([self.size**2 - 1])]
        self._places, place = np.unique(np.concatenate(at), return_inverse=True)
        place, self._diagonal, right, below, corner = np.split(place, np.cumsum([len(of) for of in at[:-1]]))
        self._fixed = np.zeros(len(self._places))
        if live is None:
            self._fixed[corner] = 1.0
        else:
            self._fixed[right], self._fixed[below] = live, -live
        entry = (3 * kind[one] + kind[other]) * m + slider[one]
        self._of_stiffness = sp.csr_array(
            (value[one] * value[other], (place, entry)), shape=(len(self._places), 9 * m)
        )
        self._rows = (self._places % self.size).astype(np.int32)
        ends = np.arange(self.size + 1) * self.size
        self._starts = np.searchsorted(self._places, ends).astype(np.int32)

    def columns(self, slider: int) -> np.ndarray:
        """Columns of B of a slider, shape (3, 3b + 1)."""
        columns, m = np.zeros((3, self.size)), self.B.shape[1] // 3
        for kind in range(3):
            row = slice(*self.Bt.indptr[kind * m + slider :][:2])
            columns[kind, self.Bt.indices[row]] = self.Bt.data[row]
        return columns

    def factors(self, stiffness: np.ndarray) -> _Solve:
        """What solves for a right-hand side, of sliders' stiffnesses, shape (3, 3, m)."""
        values = self._of_stiffness @ stiffness.ravel() + self._fixed
        values[self._diagonal] += _REGULARISATION * np.abs(stiffness).max()
        shape = (self.size, self.size)
        if self.size > _FULL_UP_TO:
            return splu(sp.csc_matrix((values, self._rows, self._starts), shape=shape)).solve
        full = np.zeros(self.size**2)
        full[self._places] = values
        lu, pivots, _ = lapack.dgetrf(full.reshape(shape).T, overwrite_a=True)
        return lambda right: lapack.dgetrs(lu, pivots, right)[0]


class Factors:
    """Factors of the blocks' matrix, and changes of single sliders since, (M + L D Lᵀ)⁻¹ by M⁻¹ L."""

    def __init__(self, blocks: Blocks, stiffness: np.ndarray) -> None:
        self._blocks, self._stiffness = blocks, stiffness.copy()
        self._base, self._sliders = blocks.factors(stiffness), []
        # L and M⁻¹ L, three columns a slider; D; and 1 + D Lᵀ M⁻¹ L.
        self._columns, self._solved = np.zeros((2, 3 * _ADDED, blocks.size))
        self._change, self._matrix = np.zeros((0, 3, 3)), np.zeros((0, 0))

    @property
    def fresh(self) -> bool:
        """Whether nothing was added."""
        return not self._sliders

    def add(self, slider: int, stiffness: np.ndarray) -> bool:
        """Whether stiffnesses (3, 3, m), which differ from those before in a slider, are taken."""
        if slider not in self._sliders:
            if self._blocks.size < _ADDED_FROM or len(self._sliders) == _ADDED:
                return False
            new = slice(3 * len(self._sliders), 3 * len(self._sliders) + 3)
            self._columns[new] = self._blocks.columns(slider)
            self._solved[new] = self._base(self._columns[new].T).T
            self._sliders.append(slider)
        of = self._sliders
        self._change = (stiffness[..., of] - self._stiffness[..., of]).transpose(2, 0, 1)
        meets = self._columns[: 3 * len(of)] @ self._solved[: 3 * len(of)].T
        self._matrix = np.eye(3 * len(of)) + self._changed(meets)
        return True

    def _changed(self, of: np.ndarray) -> np.ndarray:
        return (self._change @ of.reshape(len(self._change), 3, -1)).reshape(of.shape)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """The solution for a right-hand side."""
        solution = self._base(right)
        if self._sliders:
            new = slice(3 * len(self._sliders))
            moved = self._changed(self._columns[new] @ solution)
            solution = solution - np.linalg.solve(self._matrix, moved) @ self._solved[new]
        return solution


@dataclass
class Path:
    """A path, and the point that it has come to.

    Attributes
    ----------
    law, blocks: of the contacts.
    rest: forces q0 that contacts give from, shape (3, m).
    dead, live: loads, shape (3b,); without a live load contacts settle, as bonds fall.
    cell: of the point.
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
    cell: Cell
    d: np.ndarray
    load_factor: float = 0.0
    drive: float = 0.0
    events: list[Event] = field(default_factory=list)
    highest: tuple[float, Cell, float] | None = None
    ahead: tuple[np.ndarray, float] | None = None

    def __post_init__(self) -> None:
        self._entered: int | None = None
        self._table = self.law.table(self.cell)
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
        """d and λ, shape (3b + 1,), after a step by the equations of the cell, at the same u or t; with zero for
        ``one``, d' and λ' per unit of these. Of a point on the path what is left is rounding, which it takes off:
        S itself, a sum over joints, has lost stiffnesses that are small beside their own."""
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

    def follow(self, way: int, most: int, until: float = inf) -> End:
        """Follow the path, or go on following it, to its end, or until there are so many events.

        Parameters
        ----------
        way: whether the drive grows at first, 1, or falls, -1.
        until: time, by ``perf_counter``, to end at.
        """
        settles = self.live is None
        if settles and self.drive == 0:
            return End.FREE
        while len(self.events) < most and perf_counter() < until:
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
            self.cell, self._entered, slider, what = self.law.across(self.cell, int(nears[nearest]))
            before = self._table[FORCES, :3, slider].copy()
            self._table[..., slider] = self.law.column(self.cell, slider)
            if not np.array_equal(self._table[FORCES, :3, slider], before):
                if not self._factors.add(slider, self._table[FORCES, :3] * self.law.stiffness):
                    self._factorise()
            self._correct()
            self.events.append(Event(self.drive, self.load_factor, slider, what))
            if self.highest is None or self.load_factor > self.highest[0]:
                self.highest = self.load_factor, self.cell, self.drive
        return End.BUDGET

    def _move(self, along: np.ndarray, drive: float, step: float) -> None:
        self.d = self.d + step * along[:-1]
        self.load_factor += step * along[-1]
        self.drive = drive

    def by(self, law: Law, cell: Cell | None = None, drive: float = 0.0) -> Path:
        """The point at u or t by the equations of a cell, by default that of the end, of another law. On a ray
        its forces and λ are the same at all u."""
        still = np.zeros_like(self.d)
        return replace(self, law=law, cell=cell or self.cell, d=still, load_factor=0.0, drive=drive)

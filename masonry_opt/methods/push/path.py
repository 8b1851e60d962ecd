"""The path of contacts that give: straight in each cell, followed from boundary to boundary.

In a cell forces are q = J q~ + const, q~ = q0 - k Bᵀd, and what changes them is either a live load that grows
with its displacement u (a *push*), or the bonds of contacts, which fall (*settling*):

    B q + λ f + f_D = 0,    f·d = u        d' from  S d' - λ' f = 0,  f·d' = u'
    B q(t) + f_D = 0                       d' from  S d' = B ∂q/∂t t'            with S = B J k Bᵀ

Through a boundary the path goes into the next cell: where that lets u fall, it folds.
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

from masonry_opt.methods.push.laws import Cell, Law, Response
from masonry_opt.problem.matrices import Matrices

#: Unknowns up to which matrices are full: LAPACK has no overhead.
_FULL_UP_TO = 400

#: Added to the diagonal of S, over its largest stiffness, for cells in which a block hangs on nothing.
_REGULARISATION = 1e-15

#: Rate of what is left to a boundary, and of forces, over the largest of trial forces, that is rounding.
FLAT = 1e-10


class End(StrEnum):
    """How a path ends: at its target; on a ray, on which forces stay, or grow; or without events left."""

    THERE = "there"
    RAY = "ray"
    JAM = "jam"
    BUDGET = "budget"


class Event(NamedTuple):
    """A boundary met at u (or t) and λ; the joint, or limited force (c and on), and what it does there."""

    at: float
    load_factor: float
    joint: int
    what: str


class Blocks:
    """The matrix of the blocks, bordered by a load: [[S, -f], [fᵀ, 0]]; where it is none, [[S, 0], [0, 1]]."""

    def __init__(self, matrices: Matrices, live: np.ndarray | None) -> None:
        self.B, self.Bt = matrices.B.tocsr(), matrices.B.T.tocsr()
        self._c, size = matrices.joints, matrices.B.shape[0] + 1
        self.size, columns = size, matrices.B.tocsc()
        entries = columns.tocoo()
        # Forces of one joint meet each other: all pairs of B's entries in its columns.
        group = np.where(entries.col < 3 * self._c, entries.col % self._c, entries.col - 2 * self._c)
        order = np.argsort(group, kind="stable")
        row, column, value, group = (of[order] for of in (entries.row, entries.col, entries.data, group))
        counts = np.bincount(group)[group]
        first = np.repeat(np.arange(len(row)), counts)
        start = np.searchsorted(group, group)
        second = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts) + start[first]
        place = row[second] * size + row[first]
        border = np.arange(size - 1)
        loaded = [] if live is None else [border * size + size - 1, (size - 1) * size + border]
        self._places, of_place = np.unique(
            np.concatenate([place, np.arange(size) * (size + 1), *loaded]), return_inverse=True
        )
        stiff = self._stiffnesses(column[first], column[second])
        pairs = sp.coo_array(
            (value[first] * value[second], (of_place[: len(place)], stiff)),
            shape=(len(self._places), 9 * self._c + matrices.limited),
        )
        self._from_stiffness = pairs.tocsr()
        self._fixed, self._diagonal = np.zeros(len(self._places)), of_place[len(place) :][: size - 1]
        if live is None:
            self._fixed[of_place[len(place) + size - 1]] = 1.0
        else:
            self._fixed[of_place[len(place) + size :]] = np.concatenate([live, -live])
        self._indices, self._starts = (
            (self._places % size).astype(np.int32),
            np.searchsorted(self._places // size, np.arange(size + 1)).astype(np.int32),
        )

    def _stiffnesses(self, of: np.ndarray, by: np.ndarray) -> np.ndarray:
        """Index of the stiffness by which one force answers to another's motion."""
        c = self._c
        joints = 3 * (of // c) * c + (by // c) * c + of % c
        return np.where(of < 3 * c, joints, of + 6 * c)

    def factors(self, stiffness: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        """What solves, of stiffnesses (3, 3, c) and (t,) in turn."""
        values = self._from_stiffness @ stiffness + self._fixed
        values[self._diagonal] += _REGULARISATION * np.abs(stiffness).max()
        if self.size > _FULL_UP_TO:
            shape = (self.size, self.size)
            return splu(sp.csc_matrix((values, self._indices, self._starts), shape=shape)).solve
        full = np.zeros(self.size * self.size)
        full[self._places] = values
        lu, pivots, _ = lapack.dgetrf(full.reshape(self.size, self.size).T, overwrite_a=True)
        return lambda right: lapack.dgetrs(lu, pivots, right)[0]


@dataclass
class Path:
    """A path, and the point that it has come to.

    Attributes
    ----------
    law: of the contacts.
    blocks: their matrix.
    rest: forces q0 that they give from, shape (3c + t,).
    dead, live: loads, shape (3b,); without a live load contacts settle, as bonds fall.
    cell: of the point.
    d, load: displacements and λ.
    drive: u, or the tension t that bonds bear.
    events, peak: what was met, and the largest λ.
    ahead: direction of d, λ and of the drive, when the path has come to a ray.
    """

    law: Law
    blocks: Blocks
    rest: np.ndarray
    dead: np.ndarray
    live: np.ndarray | None
    cell: Cell
    d: np.ndarray
    load: float
    drive: float
    events: list[Event] = field(default_factory=list)
    peak: float = -inf
    factorisations: int = 0

    def __post_init__(self) -> None:
        self._stiffness: np.ndarray | None = None
        self._factorise()
        self.correct()

    @property
    def bonded(self) -> float:
        """The tension that bonds bear."""
        return self.drive if self.live is None else 0.0

    def trial(self, d: np.ndarray) -> np.ndarray:
        """Trial forces at displacements, shape (3c + t,)."""
        return self.rest - self.law.stiffness * (self.blocks.Bt @ d)

    def _factorise(self) -> None:
        joints, limited = self.law.slope(self.cell)
        c = self.law.joints
        k = self.law.stiffness
        stiffness = np.concatenate([(joints * k[: 3 * c].reshape(3, c)).ravel(), limited * k[3 * c :]])
        if self._stiffness is None or not np.array_equal(stiffness, self._stiffness):
            self._stiffness, self._solve = stiffness, self.blocks.factors(stiffness)
            self.factorisations += 1

    def correct(self) -> None:
        """Bring the point onto the path, at the same u or t, by its cell's equations."""
        q = self.law.response(self.cell, self.trial(self.d), self.bonded).q
        left, work = self.blocks.B @ q + self.dead, -self.load
        if self.live is not None:
            left += self.load * self.live
            work = self.drive - self.live @ self.d
        moved = self._solve(np.append(left, work))
        self.d = self.d + moved[:-1]
        self.load += moved[-1]

    def without(self, rest: np.ndarray, dead: np.ndarray) -> tuple[np.ndarray, float]:
        """Forces, shape (3c + t,), and λ in the cell that the path has come to, of contacts that give from
        other forces under another dead load; on a ray these are the same at all u."""
        point = replace(self, rest=rest, dead=dead, d=np.zeros_like(self.d), load=0.0, drive=0.0)
        point.correct()
        return self.law.response(self.cell, point.trial(point.d), 0.0).q, point.load

    def _direction(self) -> tuple[np.ndarray, float, Response]:
        """d' and λ', drive's rate, and rates of what is left to boundaries; trial forces change by one at most."""
        law, right = self.law, np.zeros(self.blocks.size)
        if self.live is None:
            still = np.zeros(len(self.rest))
            right[:-1] = self.blocks.B @ law.response(self.cell, still, 1.0, rate=True).q
        else:
            right[-1] = 1.0
        along = self._solve(right)
        trial = -law.stiffness * (self.blocks.Bt @ along[:-1])
        size = max(np.abs(trial).max(), 1e-300)
        gives = 1 / size if self.live is None else 0.0
        return along / size, 1 / size, law.response(self.cell, trial / size, gives, rate=True)

    def follow(self, way: int, target: float, most: int, until: float = inf) -> End:
        """Follow the path to a target of its drive, or a ray, for so many events at most.

        Parameters
        ----------
        way: whether the drive grows at first, 1, or falls, -1.
        until: time, by ``perf_counter``, to end at.
        """
        entered = None
        if self.drive == target:
            return End.THERE
        while len(self.events) < most and perf_counter() < until:
            along, drive, rate = self._direction()
            if entered is not None:
                way = 1 if rate.gaps[entered] > 0 else -1
            along, drive, rates, q = way * along, way * drive, way * rate.gaps, way * rate.q
            gaps = self.law.response(self.cell, self.trial(self.d), self.bonded).gaps
            nears = rates < -FLAT
            steps = np.full(len(gaps), inf)
            steps[nears] = np.maximum(gaps[nears], 0.0) / -rates[nears]
            boundary = int(steps.argmin())
            step = steps[boundary]
            left = (target - self.drive) / drive
            if 0 < left <= step and left < inf:
                self._move(along, target, left)
                return End.THERE
            if step == inf:
                self.ahead = along, q
                return End.RAY if np.abs(q).max() < FLAT else End.JAM
            self._move(along, self.drive + step * drive, step)
            self.cell, entered, joint, what = self.law.across(self.cell, boundary, self.bonded)
            self._factorise()
            self.correct()
            self.peak = max(self.peak, self.load)
            self.events.append(Event(self.drive, self.load, joint, what))
        return End.BUDGET

    def _move(self, along: np.ndarray, drive: float, step: float) -> None:
        self.d = self.d + step * along[:-1]
        self.load += step * along[-1]
        self.drive = drive

"""The path of centres of rigid contacts, followed round its folds to where passes stall.

All products z p are the same, τ, which falls to 0. With w = log p and z = τ / p every condition is smooth and
no sign is left to keep: Newton steps along the path's tangent, and square to it, go round folds, where τ
rises again (pseudo-arclength, Keller 1977; lengths by log p and log τ alone).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State

#: Energy Σ z p over the live load's work Σ|f_L|, at λ = 1: where the path is begun, and where it ends.
_FIRST, _LAST = 10.0, 1e-10

#: What the equations may leave; steps along the path at first and at most.
LEFT, _STEP, _LONGEST = 1e-9, 0.1, 0.2

#: Newton steps of a correction at most, and of the first centre; by how much each may change a logarithm.
_CORRECTIONS, _TO_BEGIN, _FARTHEST = 8, 200, 2.0

#: Centres at most: walls of 60 to 100 stones took 200 to 400. Beyond these rates, where the live load's mean
#: velocity is one, the path runs off along a mechanism in which that load does no work.
_MOST, _FASTEST = 1000, 1e8


class Centre(NamedTuple):
    """A point of the path.

    Attributes
    ----------
    energy: Σ z p over the live load's work Σ|f_L|, at λ = 1.
    state: its statics and kinematics.
    """

    energy: float
    state: State

    @property
    def is_end(self) -> bool:
        """Whether the path ends here, but for rounding."""
        return self.energy < _LAST


class CentralPath:
    """Centres of a problem, of the unknowns x = (q, d, λ, w = log p, log τ)."""

    def __init__(self, problem: Problem) -> None:
        self._limits, self._flow = problem.true_yield, problem.D(problem.dilatancy)
        self._problem, self._room = problem, problem.face_cohesion
        self._ends = np.cumsum([problem.B.shape[1], problem.dead.size, 1, problem.faces])
        size = int(self._ends[-1])
        self._tau = np.eye(1, size + 1, size)[0]
        self._weights = np.concatenate(
            [np.zeros(self._ends[2]), np.full(problem.faces, 1 / problem.faces), [1]]
        )

    def centres(self) -> Iterator[Centre]:
        """Centres from large products to the path's end, or to where it is given up; none where it does not
        begin, as where nothing can collapse."""
        with suppress(RuntimeError):  # SuperLU's, of a matrix without factors
            yield from self._centres()

    def _centres(self) -> Iterator[Centre]:
        energy = self._problem.live_norm / self._problem.faces
        begun = self._corrected(np.log(_FIRST * energy) * self._tau, self._tau, _TO_BEGIN)
        if begun is None:
            return
        (x, _), along, step = begun, -self._tau, _STEP
        for _ in range(_MOST):
            q, d, load_factor, w, tau = np.split(x, self._ends)
            state = State(float(load_factor[0]), q, d, np.exp(w))
            yield (centre := Centre(float(np.exp(tau[0])) / energy, state))
            if centre.is_end or w.max() > np.log(_FASTEST):
                return
            along = self._tangent(x, self._weights * along)
            while (ended := self._corrected(x + step * along, self._weights * along, _CORRECTIONS)) is None:
                step /= 2
                if step < LEFT:
                    return
            x, count = ended
            step = min(1.5 * step, _LONGEST) if count <= _CORRECTIONS // 3 else step

    def _tangent(self, x: np.ndarray, along: np.ndarray) -> np.ndarray:
        """Of the path, in the sense of the one before, of length one."""
        tangent: np.ndarray = splu(self._at(x, along)[1]).solve(self._tau)
        return tangent / np.sqrt(self._weights @ tangent**2)

    def _at(self, x: np.ndarray, row: np.ndarray) -> tuple[np.ndarray, sp.csc_array]:
        """What is left of the conditions, shape (size,), and their derivative with one more row below."""
        problem, live = self._problem, self._problem.live
        q, d, load_factor, w, tau = np.split(x, self._ends)
        p, z = np.exp(w), np.exp(tau - w)
        left = [
            problem.B @ q + load_factor * live + problem.dead,
            self._limits @ q + self._room - z,
            problem.B.T @ d - self._flow @ p,
            [live @ d / problem.live_norm - 1],
        ]
        blocks = [
            [problem.B, None, live[:, None], None, None],
            [self._limits, None, None, sp.diags_array(z), -z[:, None]],
            [None, problem.B.T, None, -self._flow @ sp.diags_array(p), None],
            [None, live[None] / problem.live_norm, None, None, None],
            [part[None] for part in np.split(row, self._ends)],
        ]
        return np.concatenate(left), sp.block_array(blocks, format="csc")

    def _corrected(self, x: np.ndarray, row: np.ndarray, most: int) -> tuple[np.ndarray, int] | None:
        """The centre near x, square to the row, and after how many Newton steps; None if too many."""
        with np.errstate(all="ignore"):
            for count in range(most):
                left, matrix = self._at(x, row)
                if not np.isfinite(left).all():
                    return None
                if np.abs(left).max() < LEFT:
                    return x, count
                step = splu(matrix).solve(np.append(left, 0.0))
                x = x - step * min(1.0, _FARTHEST / np.abs(step[self._ends[2] :]).max())
        return None

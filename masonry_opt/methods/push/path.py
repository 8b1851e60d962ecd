"""The path of contacts whose law is rounded: smooth, and followed by steps along its tangent (Keller, 1977).

    B q(d) + λ f + f_D = 0,     c·(step) = its length         [S  -f] [d']   [0]
                                                              [c   0] [λ'] = [1]      with S = B ∂q/∂q~ k Bᵀ

c measures trial forces q~ = q0 - k Bᵀd along the tangent before, so that a step goes on through folds of
u = f·d. Along a path the determinant keeps its sign, which tells which way it goes.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Any

import numpy as np

from masonry_opt.methods.push.law import Rounded
from masonry_opt.methods.push.matrix import BlockMatrix

#: First length of a step, in mean forces, and the least, over the length so far, at which a path is given up;
#: and the length at which it is: trial forces have no digit left there.
_FIRST, _LEAST, _FURTHEST = 0.3, 1e-9, 1e14

#: What is left of equilibrium, over the mean force: at points of the path, or over trial forces, whose last
#: digits far from rest are larger; at a state at most, and where its steps end.
_ON_PATH, _DIGITS, _STATE, _EXACT = 1e-6, 1e-10, 1e-9, 1e-12

_RIGID = 1e-9  #: Motion of contacts, over u, that is none but rounding.
_ROUND = 2.0  #: Way round by tangents that meet, over the straight one, at most.

#: Corrections of a step at most, and those up to which the next is four times, and twice as long.
_CORRECTIONS, _QUICK, _EASY = 6, 2, 3

#: Share of a step that goes along the tangent, and cosine of the tangents before and after, at least.
_STRAIGHT, _TURNED = 0.1, 0.3

#: Newton's steps to a state at most, and as many uphill; and the shortest share of one of Newton's.
_STEPS, _SHORTEST = 60, 1e-6

_PATIENCE, _NEARER = 8, 0.3  #: Steps in which a state must come nearer by this share, or is given up.

#: Rounding, in mean forces, falls to the last by a factor, or else by its roots up to another.
_FALLS, _GENTLE, _LAST = 0.1, 0.4, 1e-9


@dataclass(frozen=True)
class Point:
    """A point of the path."""

    at: np.ndarray  #: displacements d and the load λ, shape (3b + 1,)
    along: np.ndarray  #: d' and λ', of a length of one
    sign: int  #: of the determinant
    corrections: int = 0  #: Newton's steps onto the path
    rigid: bool = False  #: whether the path goes on without a motion of contacts


@dataclass(frozen=True)
class Curve:
    """Contacts under loads, shape (3b,). Displacements and λ, or steps of both, are of shape (3b + 1,)."""

    law: Rounded
    matrix: BlockMatrix
    rest: np.ndarray  #: forces that contacts give from, shape (3, m)
    dead: np.ndarray
    live: np.ndarray
    unit: float  #: mean force
    damping: float = 0.0  #: what resists a displacement beside the contacts, over their stiffness

    def rounded_by(self, rounding: float) -> "Curve":
        """The same, its law rounded by so many mean forces."""
        return replace(self, law=replace(self.law, rounding=rounding * self.unit))

    @property
    def rounding(self) -> float:
        """Of the law, in mean forces."""
        return self.law.rounding / self.unit

    def turns_below(self, before: Point, after: Point) -> float:
        """About the highest load between two points, by their tangents; -inf without proof of a turn."""
        up, down = before.along[-1], after.along[-1]
        length, one, other = self.moves(after.at - before.at), before.at[-1], after.at[-1]
        if up > 0 > down:
            bound = one + up * (other - one - down * length) / (up - down)
        elif up > 0 > other - one:
            bound = one + up * length
        elif down < 0 < other - one:
            bound = other - down * length
        else:
            return -inf
        return float(max(one, other, bound))

    def corner(self, before: Point, after: Point) -> np.ndarray:
        """d and λ between two points, where the path may turn: where their tangents come nearest, with λ no
        further than theirs where it goes on; in the middle if they do not on the way."""
        here, there = before.at, after.at
        one, other, way = (self._moves(of).ravel() for of in (before.along, after.along, there - here))
        ahead, back = np.linalg.lstsq(np.column_stack([one, other]), way)[0]
        if min(ahead, back) < 0 or ahead + back > _ROUND * self._size(way):
            return (here + there) / 2
        turn = (ahead * before.along + there - back * after.along - here) / 2
        share = turn[-1] / (there - here)[-1] if there[-1] != here[-1] else 1.0
        return here + turn / max(share, 1.0)

    def still(self, load: float) -> np.ndarray:
        """No displacement, and a load; of a load of one also what the equations of d' and λ' are to equal."""
        return np.append(np.zeros_like(self.dead), load)

    def u(self, at: np.ndarray) -> float:
        """Displacement of the live load."""
        return float(self.live @ at[:-1])

    def moved(self, at: np.ndarray) -> "Curve":
        """The same, its displacements counted from there: trial forces keep their digits far from rest."""
        return replace(self, rest=self.rest + self._moves(at))

    def slipped(self, at: np.ndarray) -> "Curve":
        """The same, its slip past too: what moves back does not slip back."""
        return replace(self, rest=self.law.without_slip(self.rest + self._moves(at)))

    def moves(self, at: np.ndarray) -> float:
        """How far contacts move, in motions under the mean force."""
        return self._size(self._moves(at))

    def along(self, at: np.ndarray) -> np.ndarray:
        """d' and λ' per unit of u, once more of what the joints' own equations leave: S, a sum over joints,
        has lost what is small beside their stiffnesses."""
        rates = self.law.forces(self.rest + self._moves(at))[1]
        factors = self.matrix.factors(rates * self.law.stiffness, self.live, self.live)
        along = factors.solve(self.still(1.0))
        forces = np.einsum("rkm,km->rm", rates, self._moves(along))
        left = self.matrix.B @ forces.ravel() + along[-1] * self.live
        refined: np.ndarray = along + factors.solve(np.append(left, 1.0 - self.u(along)))
        return refined

    def forces(self, at: np.ndarray) -> np.ndarray:
        """Forces of the problem, shape (3c + t,)."""
        return self.law.of_problem(self.law.forces(self.rest + self._moves(at))[0])

    def _moves(self, at: np.ndarray) -> np.ndarray:
        """Change of trial forces, shape (3, m)."""
        moved: np.ndarray = -self.law.stiffness * (self.matrix.Bt @ at[:-1]).reshape(3, -1)
        return moved

    def unbalanced(self, at: np.ndarray) -> float:
        """Mean size of what is left of equilibrium, in mean forces."""
        return self._size(self.balance(at)[0])

    def balance(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What is left of equilibrium, shape (3b,), and stiffnesses, shape (3, 3, m)."""
        moves = self._moves(at)
        forces, rates = self.law.forces(self.rest + moves)
        if self.damping:
            forces, rates = forces + self.damping * moves, rates + self.damping * np.eye(3)[:, :, None]
        left = self.matrix.B @ forces.ravel() + at[-1] * self.live + self.dead
        return left, rates * self.law.stiffness

    def _size(self, of: np.ndarray) -> float:
        return float(np.linalg.norm(of)) / (sqrt(of.size) * self.unit)

    def state(self, at: np.ndarray, u: float | None) -> np.ndarray | None:
        """The state at u, or without one under the same load, from d and λ nearby; None if none is found."""
        return self._across(at, None, 0.0) if u is None else self._across(at, self.live, u - self.u(at))

    def states(self, at: np.ndarray, u: float | None) -> "Iterator[tuple[Curve, np.ndarray]]":
        """States at the same u, or under the same load, under laws that are less and less rounded."""
        return self.sharper(at, lambda sharp, near: sharp.state(near, u))

    def sharper(
        self, found: Any, find: "Callable[[Curve, Any], Any]", last: float = _LAST
    ) -> "Iterator[tuple[Curve, Any]]":
        """What is found, each near the one before, from the law's own rounding on to the last."""
        before, falls = self.rounding / _FALLS, _FALLS
        while falls <= _GENTLE:
            rounding = falls * before if falls * before > 1.01 * last else last
            near = find(sharper := self.rounded_by(rounding), found)
            if near is None:
                falls **= 0.5
                continue
            yield sharper, near
            if rounding == last:
                return
            before, falls, found = rounding, _FALLS, near

    def _across(self, at: np.ndarray, row: np.ndarray | None, short: float) -> np.ndarray | None:
        """The state where c·d is larger by what it is short of, or without c under the same load, by Newton's
        steps as long as they lower what is left."""
        left, stiffness = self.balance(at)
        size, sizes = self._size(np.append(left, short)), list[float]()
        enough, found = (_ON_PATH, _ON_PATH) if self.damping else (_EXACT, _STATE)
        while size > enough and len(sizes) < _STEPS:
            step, length = self.matrix.factors(stiffness, self.live, row).solve(np.append(left, short)), 1.0
            while length > _SHORTEST:
                further = at + length * step
                (left, stiffness), short = self.balance(further), (1 - length) * short
                after = self._size(np.append(left, short))
                if after < (1 - 1e-4 * length) * size:
                    break
                length /= 2
            else:
                break
            slow = size < found and after > size / 4
            at, size = further, after
            sizes.append(size)
            if slow or (len(sizes) > _PATIENCE and size > _NEARER * sizes[-_PATIENCE]):
                break
        return at if size <= found else None

    def points(self, most: int) -> Iterator[Point]:
        """Points from rest, without displacement or else without load, if there is such a state; λ growing at
        first, until steps are too short, or the way is too long."""
        at = self.state(self.still(0.0), 0.0)
        if at is None:
            at = self.state(self.still(0.0), None)
        if at is None:
            return
        length, gone, point = _FIRST, 0.0, self._point(at, self.balance(at)[1], self.live, None)
        for _ in range(most):
            yield point
            if gone > _FURTHEST:
                return
            row, around = self._row(point), None
            while not (found := self._stepped(point, row, length)) or row @ found.along[:-1] < _TURNED:
                around = found or around
                length /= 3
                if length < _LEAST * (gone + _FIRST):
                    # Around a corner sharper than any step the shortest leads that comes to the path.
                    found = around
                    length = _FIRST
                    break
            if found is None:
                return
            point = found
            gone += length
            length *= 4 if point.corrections <= _QUICK else 2 if point.corrections <= _EASY else 1

    def top(self, point: Point) -> Point | None:
        """Where λ turns, uphill from a point of another law's path, if this one is near and turns soon."""
        row, length = self._row(point), _FIRST
        near = self._across(point.at, row, 0.0)
        if near is None:
            return None
        here = self._point(near, self.balance(near)[1], row, point.sign)
        for _ in range(_STEPS):
            if length * abs(here.along[-1]) <= _ON_PATH * (self.unit + abs(here.at[-1])):
                return here
            way = 1 if here.along[-1] > 0 else -1
            row = self._row(here)
            found = self._stepped(here, row, way * length)
            if found is None or way * found.along[-1] < 0 or row @ found.along[:-1] < _TURNED:
                length /= 3
            else:
                here, length = found, 2 * length
        return None

    def _row(self, point: Point) -> np.ndarray:
        """c at a point, shape (3b,)."""
        moves = self._moves(point.along)
        row: np.ndarray = -self.matrix.B @ (self.law.stiffness * moves).ravel() / (self.unit**2 * moves.size)
        return row

    def _point(
        self, at: np.ndarray, stiffness: np.ndarray, row: np.ndarray, sign: int | None, corrections: int = 0
    ) -> Point:
        factors = self.matrix.factors(stiffness, self.live, row)
        along = factors.solve(self.still(1.0))
        size = self.moves(along)
        along /= (size if size > _RIGID else 1.0) * (1 if sign in (None, factors.sign) else -1)
        return Point(at, along, sign or factors.sign, corrections, size <= _RIGID)

    def _stepped(self, point: Point, row: np.ndarray, length: float) -> Point | None:
        """The point a length ahead; None if the step is too long."""
        at, before = point.at + length * point.along, np.inf
        enough = max(_ON_PATH, _DIGITS * self.moves(point.at))
        for corrections in range(_CORRECTIONS + 1):
            left, stiffness = self.balance(at)
            size = self._size(left)
            if not size < 10 * before:
                return None
            if size <= enough:
                gone = self.moves(at - point.at)
                found = self._point(at, stiffness, row, point.sign, corrections)
                return found if abs(length) > _STRAIGHT * gone else None
            step = self.matrix.factors(stiffness, self.live, row).solve(np.append(left, 0.0))
            before, at = size, at + step
        return None

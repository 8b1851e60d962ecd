"""The path of contacts whose law is rounded: smooth, and followed by steps along its tangent (Keller, 1977).

    B q(d) + λ f + f_D = 0,     c·(step) = its length         [S  -f] [d']   [0]
                                                              [c   0] [λ'] = [1]      with S = B ∂q/∂q~ k Bᵀ

c measures trial forces q~ = q0 - k Bᵀd along the tangent before, so that a step goes on through folds of
u = f·d. Along a path the determinant keeps its sign, which tells which way it goes.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import TypeVar

import numpy as np

from masonry_opt.methods.push.law import Rounded
from masonry_opt.methods.push.matrix import BlockFactors, BlockMatrix

#: First length of a step, in mean forces, and the least, over the length so far, at which a path is given up;
#: and the length at which it is: trial forces have no digit left there.
_FIRST, _LEAST, _FURTHEST = 0.3, 1e-9, 1e14

#: What is left of equilibrium, over the mean force: at points of the path, or over trial forces, whose last
#: digits far from rest are larger; at a state at most, and where its steps end.
_ON_PATH, _DIGITS, _STATE, _EXACT = 1e-6, 1e-10, 1e-9, 1e-12

_RIGID = 1e-9  #: Motion of contacts, over u, that is none but rounding.

#: Corrections of a step at most, and those up to which the next is four times, and twice as long.
_CORRECTIONS, _QUICK, _EASY = 6, 2, 3

#: Share of a step that goes along the tangent, and cosine of the tangents before and after, at least.
_STRAIGHT, _TURNED = 0.1, 0.3

_ROUND = 2.0  #: Way round by tangents that meet, over the straight one, at most.

#: Newton's steps to a state at most, and as many uphill; and the shortest share of one of Newton's.
_STEPS, _SHORTEST = 60, 1e-6

_PATIENCE, _NEARER = 8, 0.3  #: Steps in which a state must come nearer by this share, or is given up.

#: Rounding, in mean forces, falls to the last by a factor, or else by its roots up to another.
_FALLS, _GENTLE, _LAST = 0.1, 0.4, 1e-9

_Found = TypeVar("_Found")


@dataclass(frozen=True)
class Point:
    """A point of the path."""

    d: np.ndarray  #: displacements, shape (3b,)
    load_factor: float  #: λ
    along: np.ndarray  #: d' and λ', shape (3b + 1,), of a length of one
    sign: int  #: of the determinant
    corrections: int = 0  #: Newton's steps onto the path


@dataclass(frozen=True)
class Curve:
    """Contacts under loads, shape (3b,)."""

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
        length, change = self._size(self._moves(after.d - before.d)), after.load_factor - before.load_factor
        if up > 0 > down:
            bound = before.load_factor + up * (change - down * length) / (up - down)
        elif up > 0 > change:
            bound = before.load_factor + up * length
        elif down < 0 < change:
            bound = after.load_factor - down * length
        else:
            return -inf
        return float(max(before.load_factor, after.load_factor, bound))

    def corner(self, before: Point, after: Point) -> np.ndarray:
        """d and λ, shape (3b + 1,), between two points, where the path may turn: where their tangents come
        nearest, with λ no further than theirs where it goes on; in the middle if they do not on the way."""
        here, there = (np.append(point.d, point.load_factor) for point in (before, after))
        one, other, way = (self._moves(of[:-1]).ravel() for of in (before.along, after.along, there - here))
        ahead, back = np.linalg.lstsq(np.column_stack([one, other]), way)[0]
        if min(ahead, back) < 0 or ahead + back > _ROUND * self._size(way):
            return (here + there) / 2
        turn = (ahead * before.along + there - back * after.along - here) / 2
        share = turn[-1] / (there - here)[-1] if there[-1] != here[-1] else 1.0
        return here + turn / max(share, 1.0)

    def is_rigid(self, point: Point) -> bool:
        """Whether a path goes on from a point without a motion of contacts."""
        return self._size(self._moves(point.along[:-1])) <= _RIGID

    def moved(self, d: np.ndarray) -> "Curve":
        """The same, its displacements counted from there: trial forces keep their digits far from rest."""
        return replace(self, rest=self.rest + self._moves(d))

    def slipped(self, d: np.ndarray) -> "Curve":
        """The same, its slip past too: what moves back does not slip back."""
        return replace(self, rest=self.law.without_slip(self.rest + self._moves(d)))

    def moves(self, d: np.ndarray) -> float:
        """How far contacts move, in motions under the mean force."""
        return self._size(self._moves(d))

    def along(self, d: np.ndarray) -> np.ndarray:
        """d' and λ' per unit of u, shape (3b + 1,), once more of what the joints' own equations leave: S, a
        sum over joints, has lost what is small beside their stiffnesses."""
        rates = self.law.forces(self.rest + self._moves(d))[1]
        factors = self.matrix.factors(rates * self.law.stiffness, self.live, self.live)
        along = factors.solve(np.append(np.zeros_like(d), 1.0))
        forces = np.einsum("rkm,km->rm", rates, self._moves(along[:-1]))
        left = self.matrix.B @ forces.ravel() + along[-1] * self.live
        refined: np.ndarray = along + factors.solve(np.append(left, 1.0 - self.live @ along[:-1]))
        return refined

    def forces(self, d: np.ndarray) -> np.ndarray:
        """Forces, shape (3, m)."""
        return self.law.forces(self.rest + self._moves(d))[0]

    def _moves(self, d: np.ndarray) -> np.ndarray:
        """Change of trial forces, shape (3, m)."""
        moved: np.ndarray = -self.law.stiffness * (self.matrix.Bt @ d).reshape(3, -1)
        return moved

    def left(self, d: np.ndarray, load_factor: float) -> np.ndarray:
        """What is left of equilibrium, shape (3b,)."""
        return self._at(d, load_factor)[0]

    def unbalanced(self, d: np.ndarray, load_factor: float) -> float:
        """Its mean size, in mean forces."""
        return self._size(self.left(d, load_factor))

    def _at(self, d: np.ndarray, load_factor: float) -> tuple[np.ndarray, np.ndarray]:
        """What is left of equilibrium, and stiffnesses, shape (3, 3, m)."""
        moves = self._moves(d)
        forces, rates = self.law.forces(self.rest + moves)
        if self.damping:
            forces, rates = forces + self.damping * moves, rates + self.damping * np.eye(3)[:, :, None]
        left = self.matrix.B @ forces.ravel() + load_factor * self.live + self.dead
        return left, rates * self.law.stiffness

    def _size(self, of: np.ndarray) -> float:
        return float(np.linalg.norm(of)) / (sqrt(of.size) * self.unit)

    def state(self, d: np.ndarray, load_factor: float, u: float | None) -> tuple[np.ndarray, float] | None:
        """The state at u, or without one under that load, from one nearby; None if none is found."""
        if u is None:
            return self._across(d, load_factor, None, 0.0)
        return self._across(d, load_factor, self.live, u - float(self.live @ d))

    def states(
        self, d: np.ndarray, load_factor: float, u: float | None, *ends: float
    ) -> "Iterator[tuple[Curve, np.ndarray, float]]":
        """States at the same u, or under the same load, under laws that are less and less rounded."""
        for sharper, found in self.sharper(
            (d, load_factor), lambda sharp, near: sharp.state(*near, u), *ends
        ):
            yield sharper, *found

    def sharper(
        self,
        found: _Found,
        find: "Callable[[Curve, _Found], _Found | None]",
        last: float = _LAST,
        gentlest: float = _GENTLE,
    ) -> "Iterator[tuple[Curve, _Found]]":
        """What is found, each near the one before, from the law's own rounding on to the last."""
        before, falls = self.rounding / _FALLS, _FALLS
        while falls <= gentlest:
            rounding = falls * before if falls * before > 1.01 * last else last
            near = find(sharper := self.rounded_by(rounding), found)
            if near is None:
                falls **= 0.5
                continue
            yield sharper, near
            if rounding == last:
                return
            before, falls, found = rounding, _FALLS, near

    def _across(
        self, d: np.ndarray, load_factor: float, row: np.ndarray | None, short: float
    ) -> tuple[np.ndarray, float] | None:
        """The state where c·d is larger by what it is short of, or without c under the same load, by Newton's
        steps, each as long as it lowers what is left; None if that ends before nothing is."""
        live = None if row is None else self.live
        left, stiffness = self._at(d, load_factor)
        size, sizes = self._size(np.append(left, short)), list[float]()
        enough, found = (_ON_PATH, _ON_PATH) if self.damping else (_EXACT, _STATE)
        while size > enough and len(sizes) < _STEPS:
            step, length = self.matrix.factors(stiffness, live, row).solve(np.append(left, short)), 1.0
            while length > _SHORTEST:
                further, load = d + length * step[:-1], load_factor + length * step[-1]
                (left, stiffness), short = self._at(further, load), (1 - length) * short
                after = self._size(np.append(left, short))
                if after < (1 - 1e-4 * length) * size:
                    break
                length /= 2
            else:
                break
            slow = size < found and after > size / 4
            d, load_factor, size = further, load, after
            sizes.append(size)
            if slow or (len(sizes) > _PATIENCE and size > _NEARER * sizes[-_PATIENCE]):
                break
        return (d, load_factor) if size <= found else None

    def points(self, d: np.ndarray, load_factor: float, most: int) -> Iterator[Point]:
        """Points from one on, λ growing at first, until steps are too short, or the way is too long."""
        at, length, gone = np.append(d, load_factor), _FIRST, 0.0
        factors = self.matrix.factors(self._at(d, load_factor)[1], self.live, self.live)
        point = self._point(at, factors, None, 0)
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
        """Where λ turns, uphill from a point of another law's path; None if no point of this one is near, or
        it does not turn soon."""
        row, length = self._row(point), _FIRST
        near = self._across(point.d, point.load_factor, row, 0.0)
        if near is None:
            return None
        factors = self.matrix.factors(self._at(*near)[1], self.live, row)
        here = self._point(np.append(*near), factors, point.sign, 0)
        turned = False
        for _ in range(_STEPS):
            if length * abs(here.along[-1]) <= _ON_PATH * (self.unit + abs(here.load_factor)):
                return here
            way = 1 if here.along[-1] > 0 else -1
            row = self._row(here)
            found = self._stepped(here, row, way * length)
            turned |= found is not None and way * found.along[-1] < 0
            if found is None or way * found.along[-1] < 0 or row @ found.along[:-1] < _TURNED:
                length /= 3
            else:
                here, length = found, 2 * length
        return here if turned else None

    def _row(self, point: Point) -> np.ndarray:
        """c at a point, shape (3b,)."""
        moves = self._moves(point.along[:-1])
        row: np.ndarray = -self.matrix.B @ (self.law.stiffness * moves).ravel() / (self.unit**2 * moves.size)
        return row

    def _point(self, at: np.ndarray, factors: BlockFactors, sign: int | None, corrections: int) -> Point:
        along = factors.solve(np.append(np.zeros(len(at) - 1), 1.0))
        size = self._size(self._moves(along[:-1]))
        along /= (size if size > _RIGID else 1.0) * (1 if sign in (None, factors.sign) else -1)
        return Point(at[:-1], float(at[-1]), along, sign or factors.sign, corrections)

    def _stepped(self, point: Point, row: np.ndarray, length: float) -> Point | None:
        """The point a length ahead; None if the step is too long."""
        at, before = np.append(point.d, point.load_factor) + length * point.along, np.inf
        enough = max(_ON_PATH, _DIGITS * self._size(self._moves(point.d)))
        for corrections in range(_CORRECTIONS + 1):
            left, stiffness = self._at(at[:-1], at[-1])
            size = self._size(left)
            if not size < 10 * before:
                return None
            factors = self.matrix.factors(stiffness, self.live, row)
            if size <= enough:
                gone = self._size(self._moves(at[:-1] - point.d))
                found = self._point(at, factors, point.sign, corrections)
                return found if abs(length) > _STRAIGHT * gone else None
            before, at = size, at + factors.solve(np.append(left, 0.0))
        return None

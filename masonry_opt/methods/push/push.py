"""The load that a scene bears as it is pushed from rest: it settles, then a live load grows with its
displacement until blocks move on for ever.

Contacts give: under the dead load blocks come to rest, from there the live load follows a path. Where λ no
longer changes along it, on a ray, its direction is a collapse mechanism, and the state is exact.
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from itertools import chain, pairwise
from math import inf

import numpy as np

from masonry_opt.answer.acceptance import SMALLEST, Kind
from masonry_opt.answer.answer import Answer, certified
from masonry_opt.answer.motion import weightless
from masonry_opt.answer.solution import GivingState
from masonry_opt.answer.thresholds import APART, PLATEAU
from masonry_opt.effort import Effort
from masonry_opt.methods.push.growth import Growth, come_to_rest, grown, sharp_steps
from masonry_opt.methods.push.law import Rounded, compliance
from masonry_opt.methods.push.matrix import BlockMatrix
from masonry_opt.methods.push.path import Curve, Point
from masonry_opt.methods.task import Progress, Task
from masonry_opt.problem.problem import Problem

#: Roundings of the law on paths, in mean forces, in turn where one stops short; in searches, and on scenes of
#: more joints than follow: of 88 scenes the rougher path leads to the rays of the other in .57 of the time,
#: but where it folds its highest λ is lower. And of a load that grows, and of settling.
_ROUNDINGS, _ROUGHER, _LARGE, _GROWN, _SETTLING = (0.01, 0.1), (0.1, 0.01), 500, 0.03, 0.01

#: A rounding under which hardly any path stops, and how many times as far as ends are looked for it leads.
_COARSE, _OUT = 1.0, 1e2

#: Rounding above which λ is blurred; and what a certificate leaves at most that needs no other beside it.
_BLURRED, _WELL = 1e-5, 1e-11

_SHARP = 1e-4  #: Rounding to which the highest λ on the way is followed.
_LEVEL = 10.0  #: How many times as far λ stays on a level.

#: Points of a path at most, of large scenes too; how many times as far the end is looked for again, and how
#: often: the stiffness that gives directions falls as 1/u². And displacement to which a load is drawn back.
_POINTS, _OF_LARGE, _FURTHER, _LOOKS, _BACK = 1500, 300, 3, 8, -1e6

#: By dimension: displacement from which on the end is looked for, and how many times as far a ray must go
#: straight on; in space slip turns for longer. And what it may leave there of equilibrium, over the way, and
#: at most, in mean forces: a joint that opens, closes, slides or sticks before leaves more.
_END_AND_FAR, _NO_EVENT, _LEFT = {2: (1e4, 1e3), 3: (1e6, 1.0)}, 1e-9, 0.1

#: Elasticity of λ in u from which on it grows without end; how many times as far the path must go straight on
#: then, and what it may leave there, over the forces there.
_GROWS, _FAR_AND_WIDE, _STRAIGHT = 0.5, 1e3, 1e-9

#: Share by which λ falls and rises again from which it is told: of 83 random scenes that do, contact dynamics
#: bring three down below .92 of the highest λ, of 31 others none. And share of the
#: highest λ below which no fall is told.
_DEEP, _TRIFLE = 0.1, 1e-2


class Ended(StrEnum):
    """End of a load history: blocks move on for ever, λ stays, joints press ever harder, or none of these."""

    RAY = "ray"
    LEVEL = "level"
    JAM = "jam"
    BACK = "the live load is drawn back"
    NOT_SETTLED = "its contacts do not come to carry the dead load"
    STOPPED = "no end was found"


@dataclass(frozen=True)
class PushStep:
    """A point of the push."""

    iteration: int  #: counted from 1
    displacement: float  #: u, in motions of a contact of mean size under the mean force
    load_factor: float  #: λ
    corrections: int  #: Newton's steps from the tangent onto the path


@dataclass(frozen=True)
class Pushed:
    """A push from rest."""

    ended: Ended
    steps: tuple[PushStep, ...] = ()
    points: tuple[Point, ...] = ()
    answer: Answer | None = None  #: the exact state at the ray, or that where λ stays
    #: Largest λ on the way, which a load that grows comes to, λ at the end if that is about the same; None
    #: without a load factor.
    peak: float | None = None
    rounding: float = 0.0  #: of the law, in mean forces
    growth: Growth | None = None  #: of a load, where the path came to no end
    growth_steps: tuple[PushStep, ...] = ()

    @property
    def folds(self) -> int:
        """How often the displacement turned."""
        moves = np.diff([step.displacement for step in self.steps])
        return int(np.count_nonzero(np.diff(np.sign(moves[moves != 0]))))

    @property
    def deep_fall(self) -> tuple[float, float] | None:
        """λ from which it first falls deep, to come higher later, and the largest share by which it does."""
        path = np.array([0.0, *(step.load_factor for step in self.steps)])
        path = path[: path.argmax() + 1]
        path = path[np.maximum.accumulate(path) > _TRIFLE * path[-1]]
        highest = np.maximum.accumulate(path)
        deep = 1 - path / highest > _DEEP
        return (float(highest[deep.argmax()]), float((1 - path / highest).max())) if deep.any() else None


class Elastic:
    """A problem whose contacts give."""

    def __init__(
        self, problem: Problem, matrix: BlockMatrix | None = None, gives: np.ndarray | None = None
    ) -> None:
        """The matrix is one of the same B; by default, what contacts give suits the dead load."""
        self.problem = problem
        self._end_from, self._straight_on = _END_AND_FAR[problem.layout.dimension]
        self._compliance = compliance(problem) if gives is None else gives
        self._law = Rounded.of(problem, self._compliance, 0.0)
        self._matrix = matrix or BlockMatrix(problem, self._law)
        extent = problem.matrices.extent
        self._unit = float(extent.mean() / (extent * self._compliance[: problem.joints]).mean())

    def again_for(self, problem: Problem, effort: Effort | None = None) -> "Elastic":
        """The same of a problem of other loads, law or forces at rest."""
        return self if problem is self.problem else Elastic(problem, self._matrix)

    def drawn(self, deviation: float, rng: np.random.Generator) -> "Elastic":
        """The same, each contact's stiffness changed by a random factor of this logarithmic deviation."""
        c = self.problem.joints
        of_each = np.exp(deviation * rng.standard_normal(self.problem.B.shape[1] - 2 * c))
        factors = np.concatenate([of_each[:c], of_each[:c], of_each])
        return Elastic(self.problem, self._matrix, factors * self._compliance)

    @cached_property
    def settled(self) -> np.ndarray | None:
        """Forces (3c + t,) under the dead load from rest; None if contacts do not come to carry it."""
        problem = self.problem
        if problem.settled is not None:
            return problem.settled
        if not problem.dead.any():
            return np.zeros(problem.B.shape[1])
        # The whole dead load at once, from contacts without forces: blocks move, damped, until they rest.
        still, nothing = np.zeros_like(problem.dead), np.zeros_like(self._law.stiffness)
        whole = Curve(self._law, self._matrix, nothing, problem.dead, still, self._unit)
        rest = come_to_rest(whole.rounded_by(_SETTLING), 0.0)
        if rest is None:
            return None
        curve, at = rest
        *_, last = (None, *curve.states(at, None))
        return None if last is None else last[0].forces(last[1])

    @cached_property
    def falls(self) -> Answer | None:
        """The state in which the dead load, as it grows, brings the scene down, if it is known to."""
        if self.settled is not None:
            return None
        nothing, dead = np.zeros(self.problem.B.shape[1]), self.problem.dead
        grows = replace(self.problem, dead=np.zeros_like(dead), live=dead, settled=nothing)
        return Elastic(grows, self._matrix, self._compliance).pushed().answer

    def tells(self, load_factor: float, d: np.ndarray) -> bool:
        """Whether a mechanism (3b,) at a load factor tells of the load: one of blocks that weigh nothing
        there does only where from rest these do not carry the dead load either."""
        return not weightless(self.problem, load_factor, d) or self.settled is None

    def pushed(self, follow: Progress = lambda _: None, until: float = inf, rougher: bool = False) -> Pushed:
        """The push to its end, or to a displacement; of rougher corners where only the end counts."""
        if self.settled is None:
            return Pushed(Ended.NOT_SETTLED)
        large = self.problem.joints > _LARGE
        most = _OF_LARGE if large and until == inf else _POINTS
        level: Pushed | None = None
        for rounding in _ROUGHER[:1] if large else _ROUGHER if rougher else _ROUNDINGS:
            found = self._followed(self.curve.rounded_by(rounding), most, follow, until)
            level = level or (self._level(found) if until == inf else None)
            came = bool(found.steps) and found.steps[-1].displacement >= until
            if came or found.ended is not Ended.STOPPED:
                break
        if level is not None and not _stays(found.answer, level.steps[-1].load_factor):
            found = level
        elif found.ended is Ended.STOPPED and until == inf:
            return self._grown(found, follow)
        return replace(found, peak=self._peak(self.curve.rounded_by(found.rounding), found))

    def _level(self, path: Pushed) -> Pushed | None:
        """A path up to where λ stays as the displacement grows tenfold, far from rest, if it does: beyond,
        joints that are askew by their last digits wedge or open."""
        along = np.array([(step.displacement, step.load_factor) for step in path.steps]).reshape(-1, 2)
        for last in np.flatnonzero(along[:, 0] >= self._end_from):
            u, load_factor = along[last]
            if _stays(path.answer, load_factor):
                return None
            before = np.flatnonzero(along[:last, 0] <= u / _LEVEL)
            if not len(before) or np.ptp(along[before[-1] : last + 1, 1]) > PLATEAU * load_factor:
                continue
            state = self.next_to(path, path.points[last].at, float(u))
            if state is None or state.answer.failing(Kind.COMPLIANT):
                continue
            if self.tells(state.answer.load_factor, state.answer.d):
                steps, points = path.steps[: last + 1], path.points[: last + 1]
                return Pushed(Ended.LEVEL, steps, points, state.answer, rounding=path.rounding)
        return None

    def _grown(self, path: Pushed, follow: Progress) -> Pushed:
        """What becomes of a path that stops as the load grows all the same."""
        unit, steps = self.problem.live_norm, list[PushStep]()

        def told(u: float, load: float) -> None:
            steps.append(PushStep(len(path.steps) + len(steps) + 1, u, load / unit, 0))
            follow(steps[-1])

        growth = grown(self.curve.rounded_by(_GROWN), told)
        if growth is None:
            return path
        found = replace(path, growth=growth, growth_steps=tuple(steps), peak=growth.carried / unit)
        u = self.curve.u(growth.at)
        if growth.beyond is not None or u <= 0:
            return found
        along = np.append(growth.at[:-1], 0.0) / growth.before.moves(growth.at)
        ended, answer = self._end(growth.before, Point(growth.at, along, 1), u)
        return replace(found, ended=ended, answer=answer)

    def beside(self) -> Answer | None:
        """The state to which contacts of much rounder corners lead where a push stops, exact or the last one:
        from rest another may be come to."""
        if self.settled is None:
            return None
        coarse = self.curve.rounded_by(_COARSE)
        path = self._followed(coarse, _POINTS, lambda _: None, _OUT * self._end_from)
        if path.answer is not None or not path.steps or path.steps[-1].displacement < self._end_from:
            return path.answer
        at = path.points[-1].at
        load_factor = float(at[-1]) / self.problem.live_norm
        return certified(self.problem.by_cone, load_factor, coarse.forces(at), at[:-1])

    def _followed(self, rounded: Curve, most: int, follow: Progress, until: float) -> Pushed:
        unit, points, steps = self.problem.live_norm, list[Point](), list[PushStep]()
        ended, answer, looks, next_look = Ended.STOPPED, None, 0, self._end_from
        for point in rounded.points(most):
            points.append(point)
            u, grows = rounded.u(point.at), rounded.u(point.along) > 0
            steps.append(PushStep(len(steps) + 1, u, float(point.at[-1]) / unit, point.corrections))
            follow(steps[-1])
            if u < _BACK:
                ended = Ended.BACK
            elif u < until and ((u > next_look and grows) or point.rigid):
                ended, answer = self._end(rounded, point, u)
                looks, next_look = looks + 1, _FURTHER * u
            if ended is not Ended.STOPPED or point.rigid or u >= until or looks == _LOOKS:
                break
        return Pushed(ended, tuple(steps), tuple(points), answer, rounding=rounded.rounding)

    @cached_property
    def curve(self) -> Curve:
        """The contacts under the loads, at rest with the forces that they have settled with."""
        problem, settled = self.problem, self.settled
        assert settled is not None
        rest, live = self._law.of_sliders(settled), problem.live / problem.live_norm
        return Curve(self._law, self._matrix, rest, problem.dead, live, self._unit)

    def _end(self, rounded: Curve, point: Point, u: float) -> tuple[Ended, Answer | None]:
        """Whether a point lies on a ray, and the exact state there under laws ever sharper: in space the
        direction comes to a mechanism of the cone as 1/u², and a law too sharp has turns of its own."""
        problem, far = self.problem.by_cone, self._straight_on * u
        most_left = self._unit * min(_LEFT, _NO_EVENT * max(far, self._straight_on * self._end_from))
        before = point.along[:-1] / self.curve.u(point.along)
        states = [*rounded.moved(point.at).states(rounded.still(point.at[-1]), 0.0)]
        best: Answer | None = None
        for curve, at in reversed(states):
            if best is not None and (curve.rounding > _BLURRED or best.certificate.worst <= _WELL):
                break
            q = curve.forces(at)
            for way in (curve.along(at)[:-1], before):
                left = curve.balance(at + far * np.append(way, 0.0))[0]
                if np.abs(left).max() > most_left:
                    continue
                answer = certified(problem, at[-1] / problem.live_norm, q, way)
                if answer.exact and (best is None or answer.certificate.worst < best.certificate.worst):
                    best = answer
        if best is not None:
            return Ended.RAY, best
        if not states:
            return Ended.STOPPED, None
        curve, at = states[-1]
        along, far = curve.along(at), _FAR_AND_WIDE * u
        if u * along[-1] < _GROWS * abs(at[-1]):
            return Ended.STOPPED, None
        left = curve.balance(at + far * along)[0]
        straight = np.abs(left).max() <= _STRAIGHT * far * abs(along[-1])
        return Ended.JAM if straight else Ended.STOPPED, None

    def _peak(self, rounded: Curve, pushed: Pushed) -> float | None:
        """The highest λ, where a path that ends turns above its end, under laws as sharp as have the turn."""
        if pushed.answer is None:
            return None
        # At rest the load is none.
        end, unit = pushed.answer.load_factor, self.problem.live_norm
        peak, told = max(0.0, end), end * (1 + PLATEAU)
        if pushed.points[-1].rigid:
            return peak
        turns = [(rounded.turns_below(*pair) / unit, *pair) for pair in pairwise(pushed.points)]
        for bound, before, after in sorted(turns, key=lambda turn: -turn[0]):
            if bound <= max(told, peak):
                break
            high = before if before.at[-1] > after.at[-1] else after
            curve, start = rounded.moved(high.at), replace(high, at=rounded.still(high.at[-1]))
            *_, (_, top) = (rounded, high), *curve.sharper(start, Curve.top, _SHARP)
            if top.at[-1] / unit > told:
                peak = max(peak, float(top.at[-1]) / unit)
        return peak

    def giving(self, give: float) -> Problem:
        """The problem with contacts that give so much, over the motion of the live load."""
        return replace(self.problem.by_cone, compliance=give * self._compliance, settled=self.settled)

    def at(self, pushed: Pushed, u: float) -> GivingState | None:
        """The state of a push as it first comes to u; None if it does not."""
        number = next((step.iteration - 1 for step in pushed.steps if step.displacement >= u), None)
        if number is None:
            return None
        before, after = pushed.points[max(number - 1, 0)].at, pushed.points[number].at
        was, comes = self.curve.u(before), self.curve.u(after)
        between = before + ((u - was) / (comes - was) if comes > was else 1.0) * (after - before)
        states = (self.next_to(pushed, near, u) for near in (between, after))
        return next((state for state in states if state is not None), None)

    def next_to(self, pushed: Pushed, near: np.ndarray, u: float) -> GivingState | None:
        """The state of a push at u near d and λ of its path, certified for its contacts."""
        return self._sharpened(self.curve.rounded_by(pushed.rounding), near, u - self.curve.u(near), u)

    def carried(self, growth: Growth) -> GivingState | None:
        """The last state of a load that grows, of contacts that give from those before; of large scenes else
        one of contacts made sharp."""
        sharp = self.problem.joints > _LARGE and growth.beyond is not None
        for curve, at in chain([(growth.before, growth.at)], sharp_steps(growth) if sharp else ()):
            state = self._sharpened(curve, at, 0.0, max(curve.moves(at), SMALLEST))
            if state is not None and not state.answer.failing(Kind.COMPLIANT):
                return state
        return None

    def _sharpened(self, curve: Curve, near: np.ndarray, short: float, unit: float) -> GivingState | None:
        gives = replace(self.giving(1 / unit), settled=self._law.of_problem(curve.rest))
        *_, last = (None, *curve.moved(near).states(curve.still(near[-1]), short))
        if last is None:
            return None
        curve, at = last
        load_factor, moved = at[-1] / gives.live_norm, (near + at)[:-1] / unit
        return GivingState(1 / unit, gives, certified(gives, load_factor, curve.forces(at), moved))


def _stays(answer: Answer | None, load_factor: float) -> bool:
    """Whether a state's λ is the one that stays; an exact one may be a hundredth from it."""
    return answer is not None and abs(answer.load_factor - load_factor) <= APART * abs(load_factor)


def elastic_of(task: Task) -> Elastic:
    """A task's problem with contacts that give, its matrix kept."""
    problem = task.problem
    return task.kept.of("elastic", problem, task.effort, lambda: Elastic(problem), own=True)

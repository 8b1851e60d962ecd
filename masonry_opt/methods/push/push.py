"""The load that a scene bears as it is pushed from rest: it settles, then a live load grows with its
displacement until blocks move on for ever.

Contacts give: under the dead load blocks come to rest, from there the live load follows a path. Where λ no
longer changes along it, on a ray, its direction is a collapse mechanism, and the state is exact.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from itertools import chain, pairwise
from math import inf

import numpy as np

from masonry_opt.answer.acceptance import SMALLEST, Kind
from masonry_opt.answer.answer import Answer, certified
from masonry_opt.answer.motion import weightless
from masonry_opt.answer.solution import GivingState
from masonry_opt.answer.thresholds import PLATEAU
from masonry_opt.effort import Effort
from masonry_opt.methods.push.growth import Growth, come_to_rest, grown, sharp_steps
from masonry_opt.methods.push.law import Rounded, compliance
from masonry_opt.methods.push.matrix import BlockMatrix
from masonry_opt.methods.push.path import Curve, Point
from masonry_opt.methods.push.pushed import Ended, Pushed, PushStep
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem

#: Roundings of the law on paths, in mean forces, in turn where one stops short; in searches, and on scenes of
#: more joints than follow: of 88 scenes the rougher path leads to the rays of the other in .57 of the time,
#: but where it folds its highest λ is lower. And of a load that grows, and of settling.
_ROUNDINGS, _ROUGHER, _LARGE, _GROWN, _SETTLING = (0.01, 0.1), (0.1, 0.01), 500, 0.03, 0.01

#: Roundings under which hardly any path stops; to which one's state is sharpened, by which factor at least,
#: points of a path from there, and how many times as far as ends are looked for it leads without.
_COARSE, _SHARPENED, _GENTLEST, _SHARPENED_POINTS, _OUT = (1.0, 0.7, 0.5, 0.35), 0.01, 0.9, 400, 1e2

#: Rounding above which λ is blurred; and what a certificate leaves at most that needs no other beside it.
_BLURRED, _WELL = 1e-5, 1e-11

_SHARP = 1e-4  #: Rounding to which the highest λ on the way is followed.

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
        """The same, the stiffness of each contact changed by a random factor, its logarithm's standard
        deviation given."""
        c = self.problem.joints
        of_each = np.exp(deviation * rng.standard_normal(self.problem.B.shape[1] - 2 * c))
        factors = np.concatenate([of_each[:c], of_each[:c], of_each])
        return Elastic(self.problem, self._matrix, factors * self._compliance)

    @cached_property
    def settled(self) -> np.ndarray | None:
        """Forces under the dead load from rest, shape (3c + t,), which contacts give from; None if they do
        not come to carry it."""
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
        curve, d = rest
        *_, last = (None, *curve.states(d, 0.0, None))
        return None if last is None else self._law.of_problem(last[0].forces(last[1]))

    @cached_property
    def falls(self) -> Answer | None:
        """The state in which the dead load, growing from nothing, brings the scene down before it is whole;
        None if it does not, or that is not known."""
        if self.settled is not None:
            return None
        nothing, dead = np.zeros(self.problem.B.shape[1]), self.problem.dead
        grows = replace(self.problem, dead=np.zeros_like(dead), live=dead, settled=nothing)
        return Elastic(grows, self._matrix, self._compliance).pushed().answer

    def tells(self, load_factor: float, d: np.ndarray) -> bool:
        """Whether a mechanism (3b,) at a load factor tells of the load. One of blocks that weigh nothing
        there does so only where from rest these do not carry the dead load either."""
        return not weightless(self.problem, load_factor, d) or self.settled is None

    def pushed(
        self,
        follow: Callable[[PushStep], None] = lambda _: None,
        until: float = inf,
        rougher: bool = False,
    ) -> Pushed:
        """The push, followed to its end, or until it comes to a displacement; of rougher corners where only
        its end counts."""
        if self.settled is None:
            return Pushed(Ended.NOT_SETTLED)
        large = self.problem.joints > _LARGE
        most = _OF_LARGE if large and until == inf else _POINTS
        for rounding in _ROUGHER[:1] if large else _ROUGHER if rougher else _ROUNDINGS:
            curve = self.curve.rounded_by(rounding)
            found = self._followed(curve, self._at_rest(curve), follow, until, most)
            came = bool(found.steps) and found.steps[-1].displacement >= until
            if came or found.ended is not Ended.STOPPED:
                break
        if found.ended is Ended.STOPPED and until == inf:
            return self._grown(found, follow)
        return replace(found, peak=self._peak(curve, found))

    def _grown(self, path: Pushed, follow: Callable[[PushStep], None]) -> Pushed:
        """What becomes of a path that stops as the load grows all the same."""
        unit, steps = self.problem.live_norm, list[PushStep]()

        def told(u: float, load: float) -> None:
            steps.append(PushStep(len(path.steps) + len(steps) + 1, u, load / unit, 0))
            follow(steps[-1])

        growth = grown(self.curve.rounded_by(_GROWN), told)
        if growth is None:
            return path
        ended, answer, u = path.ended, None, float(self.curve.live @ growth.d)
        if growth.beyond is None and u > 0:
            along = np.append(growth.d, 0.0) / growth.before.moves(growth.d)
            ended, answer = self._end(growth.before, Point(growth.d, growth.carried, along, 1), u)
        found = replace(path, growth=growth, growth_steps=tuple(steps))
        return replace(found, ended=ended, answer=answer, peak=growth.carried / unit)

    def beside(self) -> Iterator[Answer]:
        """States to which contacts of much rounder corners lead where a push stops, of each path an exact one
        or else its last: from rest others may be come to."""
        for rounding in _COARSE if self.settled is not None else ():
            found = self._beyond(self.curve.rounded_by(rounding))
            if found is not None:
                yield found

    def _beyond(self, coarse: Curve) -> Answer | None:
        """The exact state that a coarse path leads to, sharpened where ends are looked for; else its last one
        beyond."""
        start, furthest = self._at_rest(coarse), None
        for point in coarse.points(*start, _POINTS) if start else ():
            u = float(coarse.live @ point.d)
            if u < self._end_from:
                continue
            if furthest is None:
                states = coarse.states(point.d, point.load_factor, u, _SHARPENED, _GENTLEST)
                *_, (curve, d, load) = (coarse, point.d, point.load_factor), *states
                if curve.rounding < 2 * _SHARPENED:
                    found = self._followed(curve, (d, load), most=_SHARPENED_POINTS).answer
                    if found is not None:
                        return found
            furthest = point
            if u > _OUT * self._end_from:
                break
        if furthest is None:
            return None
        q, load = self._law.of_problem(coarse.forces(furthest.d)), furthest.load_factor
        return certified(self.problem.by_cone, load / self.problem.live_norm, q, furthest.d)

    @staticmethod
    def _at_rest(curve: Curve) -> tuple[np.ndarray, float] | None:
        """Where a path begins: d and λ, without displacement or else without load; None if none is found."""
        still = np.zeros_like(curve.dead)
        return curve.state(still, 0.0, 0.0) or curve.state(still, 0.0, None)

    def _followed(
        self,
        rounded: Curve,
        start: tuple[np.ndarray, float] | None,
        follow: Callable[[PushStep], None] = lambda _: None,
        until: float = inf,
        most: int = _POINTS,
    ) -> Pushed:
        unit, points, steps = self.problem.live_norm, list[Point](), list[PushStep]()
        ended, answer, looks, next_look = Ended.STOPPED, None, 0, self._end_from
        for point in rounded.points(*start, most) if start else ():
            points.append(point)
            u, grows = float(rounded.live @ point.d), float(rounded.live @ point.along[:-1]) > 0
            rigid = rounded.is_rigid(point)
            steps.append(PushStep(len(steps) + 1, u, point.load_factor / unit, point.corrections))
            follow(steps[-1])
            if u < _BACK:
                ended = Ended.BACK
            elif u < until and ((u > next_look and grows) or rigid):
                ended, answer = self._end(rounded, point, u)
                looks, next_look = looks + 1, _FURTHER * u
            if ended is not Ended.STOPPED or rigid or u >= until or looks == _LOOKS:
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
        before = point.along[:-1] / float(self.curve.live @ point.along[:-1])
        states = [*rounded.moved(point.d).states(np.zeros_like(point.d), point.load_factor, 0.0)]
        best: Answer | None = None
        for curve, d, load in reversed(states):
            blurred = curve.rounding > _BLURRED
            if best is not None and (blurred or best.certificate.worst <= _WELL):
                break
            q = self._law.of_problem(curve.forces(d))
            for way in (curve.along(d)[:-1], before):
                if np.abs(curve.left(d + far * way, load)).max() > most_left:
                    continue
                answer = certified(problem, load / problem.live_norm, q, way)
                if answer.exact and (best is None or answer.certificate.worst < best.certificate.worst):
                    best = answer
        if best is not None:
            return Ended.RAY, best
        if not states:
            return Ended.STOPPED, None
        curve, d, load = states[-1]
        along = curve.along(d)
        if u * along[-1] < _GROWS * abs(load):
            return Ended.STOPPED, None
        far = _FAR_AND_WIDE * u
        left = np.abs(curve.left(d + far * along[:-1], load + far * along[-1])).max()
        straight = left <= _STRAIGHT * far * abs(along[-1])
        return Ended.JAM if straight else Ended.STOPPED, None

    def _peak(self, rounded: Curve, pushed: Pushed) -> float | None:
        """The highest λ of a path that ends in a state, uphill from where it turns above that, under laws as
        sharp as have the turn; None of any other."""
        if pushed.answer is None:
            return None
        # At rest the load is none.
        end, unit = pushed.answer.load_factor, self.problem.live_norm
        peak, told = max(0.0, end), end * (1 + PLATEAU)
        if rounded.is_rigid(pushed.points[-1]):
            return peak
        turns = [(rounded.turns_below(*pair) / unit, *pair) for pair in pairwise(pushed.points)]
        for bound, before, after in sorted(turns, key=lambda turn: -turn[0]):
            if bound <= max(told, peak):
                break
            at = before if before.load_factor > after.load_factor else after
            curve, still = rounded.moved(at.d), replace(at, d=np.zeros_like(at.d))
            *_, (_, top) = (rounded, at), *curve.sharper(still, Curve.top, _SHARP)
            if top.load_factor / unit > told:
                peak = max(peak, top.load_factor / unit)
        return peak

    def giving(self, give: float) -> Problem:
        """The problem with contacts that give so much, over the motion of the live load."""
        return replace(self.problem.by_cone, compliance=give * self._compliance, settled=self.settled)

    def at(self, pushed: Pushed, u: float) -> GivingState | None:
        """The state of a push as it first comes to u; None if it does not."""
        beyond = (step.iteration - 1 for step in pushed.steps if step.displacement >= u)
        number = next(beyond, None)
        if number is None:
            return None
        before, after = pushed.points[max(number - 1, 0)], pushed.points[number]
        was, comes = (float(self.curve.live @ point.d) for point in (before, after))
        share = (u - was) / (comes - was) if comes > was else 1.0
        between = replace(
            after,
            d=before.d + share * (after.d - before.d),
            load_factor=before.load_factor + share * (after.load_factor - before.load_factor),
        )
        states = (self._giving_state(pushed.rounding, point, u) for point in (between, after))
        return next((state for state in states if state is not None), None)

    def next_to(self, pushed: Pushed, step: PushStep) -> GivingState | None:
        """The state at a step of a push."""
        return self._giving_state(pushed.rounding, pushed.points[step.iteration - 1], step.displacement)

    def _giving_state(self, rounding: float, point: Point, u: float) -> GivingState | None:
        """The state at u next to a point of the path, certified for its contacts."""
        short = u - float(self.curve.live @ point.d)
        return self._sharpened(self.curve.rounded_by(rounding), point.d, point.load_factor, short, u)

    def carried(self, growth: Growth) -> GivingState | None:
        """The last state of a load that grows, certified for contacts that give from those before; of large
        scenes else one of sharp contacts. None if none is found that holds."""
        own = (growth.before, growth.d, growth.carried)
        sharp = self.problem.joints > _LARGE and growth.beyond is not None
        for curve, d, load in chain([own], sharp_steps(growth) if sharp else ()):
            state = self._sharpened(curve, d, load, 0.0, max(curve.moves(d), SMALLEST))
            if state is not None and not state.answer.failing(Kind.COMPLIANT):
                return state
        return None

    def _sharpened(
        self, curve: Curve, near: np.ndarray, load: float, short: float | None, unit: float
    ) -> GivingState | None:
        rest, curve = self._law.of_problem(curve.rest), curve.moved(near)
        *_, last = (None, *curve.states(np.zeros_like(near), load, short))
        if last is None:
            return None
        curve, d, load = last
        gives = replace(self.giving(1 / unit), settled=rest)
        q, moved = self._law.of_problem(curve.forces(d)), (near + d) / unit
        return GivingState(1 / unit, gives, certified(gives, load / self.problem.live_norm, q, moved))


def elastic_of(task: Task) -> Elastic:
    """A task's problem with contacts that give, its matrix kept."""
    problem = task.problem
    return task.kept.of("elastic", problem, task.effort, lambda: Elastic(problem), own=True)

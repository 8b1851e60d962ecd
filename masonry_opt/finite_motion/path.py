"""The path of a hinging mechanism: steps of finite rotations, from event to event, down to λ = 0."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.reasons import Code, Reason, reason
from masonry_opt.answer.thresholds import ZERO, same
from masonry_opt.effort import Effort
from masonry_opt.finite_motion.moved_blocks import ForceOptimum, MovedBlocks, overlapping, placed, turned
from masonry_opt.problem.loads import Forces, by_component, moment_of
from masonry_opt.result import Result
from masonry_opt.scene.rows import dots

BORNE = 1e-8  #: Violation of equilibrium and yield that is rounding.
_NEAR = 10.0  #: So many times that, and the joint is only just opening.
_CLOSED = 1e-12  #: Angle (rad) up to which a joint that closes is closed.
_LONGEST, _SHORTEST = 0.02, 1e-6  #: Of steps: ways of the fastest corner over the scene's size.
_ENCLOSED = 1e-13  #: Width to which events are enclosed.
_MOVES = 1e-7  #: Speed of the fastest corner, of a direction whose length is 1, below which nothing moves.
_PROBE = 1e-5  #: Step that shows in which sense a motion is possible.
_MOST, _MOST_EVENTS = 2000, 20  #: Most steps, and most events in one place.
#: Share of the largest singular value below which one is zero: joints that share a hinge repeat equations.
_DEPENDENT = 1e-8
_STEPS, _SOLVED = 12, 1e-13  #: Newton steps of one correction, and the residual at which it ends.
_ROUNDING = 1e-10  #: Residual up to which a correction that comes no nearer is one: rounding.


@dataclass(frozen=True)
class Step:
    """A state of the path, in the case's units; in the plane, while the path is followed, the problem's."""

    poses: np.ndarray  #: (x, y, θ) of all blocks, shape (blocks, 3): a turn about the origin, then a shift
    load_factor: float  #: λ in equilibrium
    #: Contact points that touch from here on, (points,); while a path is followed corners, (joints, 2).
    touch: np.ndarray
    event: Reason | None = None  #: what happens here, if anything


class Chain:
    """Bodies of blocks whose joints are closed, and hinges between them, where one corner of a joint touches.

    Unknowns are the poses (x, y, θ) of the bodies, the force in each hinge, and λ:
        Q(θ, λ) + G(θ)ᵀ f = 0,    g(poses) = 0,
    with Q the generalised loads, g the distance of the two places of each hinge point, G = ∂g/∂poses. With
    one degree of freedom λ is that of virtual work; with more the solutions are still a line. A point of it
    has all unknowns in a row: poses (bodies, 3), forces in hinges on the first body (hinges, 2), and λ.
    """

    def __init__(self, blocks: MovedBlocks, touch: np.ndarray) -> None:
        self.touch, self.body = touch, blocks.bodies(touch)
        self.count = int(self.body.max())  # the ground's number
        body, loads = self.body[blocks.movable], (blocks.dead, blocks.live)
        self.dead, self.live = ((body[each.block], each.point, each.force) for each in loads)
        ends = self.body[blocks.blocks]
        hinges = np.flatnonzero((touch.sum(axis=1) == 1) & (ends[:, 0] != ends[:, 1]))
        self.ends = ends[hinges]
        self.at = blocks.corner[hinges, touch[hinges].argmax(axis=1)]

    def start(self, of_blocks: np.ndarray) -> np.ndarray:
        """The point with these poses of the blocks: forces and λ by least squares."""
        poses, moves = np.zeros((self.count + 1, 3)), 3 * self.count
        poses[self.body] = of_blocks
        point = np.append(poses[:-1].ravel(), np.zeros(2 * len(self.at) + 1))
        rest, slope = self._system(point)
        point[moves:] = np.linalg.lstsq(slope[:moves, moves:], -rest[:moves], rcond=_DEPENDENT)[0]
        return point

    def of_blocks(self, point: np.ndarray) -> np.ndarray:
        """Poses of all blocks in a point, or their rates in a direction, shape (blocks, 3)."""
        return np.vstack([point[: 3 * self.count].reshape(-1, 3), np.zeros(3)])[self.body]

    def tangents(self, point: np.ndarray) -> np.ndarray:
        """Directions in which the line goes on, (k, unknowns): none where jammed, several at a branch."""
        _, slope = self._system(point)
        _, sizes, rows = np.linalg.svd(slope)
        rank = int((sizes > _DEPENDENT * sizes.max(initial=1.0)).sum())
        moves = np.r_[: 3 * self.count, len(point) - 1]
        left, sizes, _ = np.linalg.svd(rows[rank:, moves].T, full_matrices=False)
        found = np.zeros((np.count_nonzero(sizes > _DEPENDENT), len(point)))
        found[:, moves] = left[:, sizes > _DEPENDENT].T
        return found

    def corrected(self, start: np.ndarray, row: np.ndarray, value: float) -> np.ndarray | None:
        """The point of the line whose product with a row has a value; None if Newton steps find none."""
        point, moves, last = start, 3 * self.count, np.inf
        for _ in range(_STEPS):
            rest, slope = self._system(point)
            rest, slope = np.append(rest, row @ point - value), np.vstack([slope, row])
            of = np.ones(len(rest))
            of[:moves], of[-1] = 1.0 + np.abs(point[moves:-1]).max(initial=0.0), 1.0 + abs(value)
            residual = float(np.abs(rest / of).max())
            if residual <= _SOLVED or (residual <= _ROUNDING and residual > 0.5 * last):
                return point
            if residual > 1e3:
                return None
            last = residual
            point = point + np.linalg.lstsq(slope, -rest, rcond=_DEPENDENT)[0]
        return None

    def _system(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals of equilibrium, then of the hinges, and their derivatives by poses, forces and λ."""
        bodies, hinges, forces = self.count, len(self.at), point[3 * self.count : -1].reshape(-1, 2)
        poses = np.vstack([point[: 3 * bodies].reshape(-1, 3), np.zeros(3)])
        live = self._acting(poses, *self.live)
        acting = self._acting(poses, *self.dead) + point[-1] * live
        gap = np.zeros((hinges, 2))
        G = np.zeros((hinges, 2, bodies + 1, 3))
        each = np.arange(hinges)
        for side, sign in enumerate((1.0, -1.0)):
            of = self.ends[:, side]
            acting += self._acting(poses, of, self.at, sign * forces)
            arm = turned(self.at, poses[of])
            gap += sign * placed(self.at, poses[of])
            G[each[:, None], [0, 1], of[:, None], [0, 1]] += sign
            G[each, :, of, 2] += sign * np.column_stack([-arm[:, 1], arm[:, 0]])
        flat = G[:, :, :-1].reshape(2 * hinges, 3 * bodies)
        rest = np.append(acting[:-1, :3].ravel(), gap.ravel())
        slope = np.zeros((len(rest), len(rest) + 1))
        turns = 3 * np.arange(bodies) + 2
        slope[turns, turns] = -acting[:-1, 3]
        slope[: 3 * bodies, 3 * bodies : -1] = flat.T
        slope[3 * bodies :, : 3 * bodies] = flat
        slope[: 3 * bodies, -1] = live[:-1, :3].ravel()
        return rest, slope

    @staticmethod
    def _acting(poses: np.ndarray, body: np.ndarray, at: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Of forces on bodies, at points at rest, the sums fx, fy, x × f about the origin and x · f, by which
        the moment falls as a body turns, shape (bodies + 1, 4)."""
        total, arm = np.zeros((len(poses), 4)), turned(at, poses[body])
        np.add.at(total, body, np.column_stack([force, moment_of(arm, force), dots(arm, force)]))
        return total


class _PathEvent(NamedTuple):
    """What ends a step: its code, the joints or blocks concerned, and the statics that found it."""

    code: Code
    which: list[int]
    borne: ForceOptimum | None = None


class _Stretch(NamedTuple):
    """Where the bodies stay the same."""

    chain: Chain  #: they
    point: np.ndarray  #: a point of their line
    row: np.ndarray  #: rates there of poses and λ, while the fastest corner moves by the scene's size

    @property
    def poses(self) -> np.ndarray:
        return self.chain.of_blocks(self.point)

    @property
    def motion(self) -> np.ndarray:
        return self.chain.of_blocks(self.row)


class _PathEnded(Exception):
    """The path ends; its argument is the reason."""


class HingingPath:
    """The path after the onset of a result: its ``steps``, the first at rest, its ``end``, and ``motion``,
    rates of the poses of all blocks at the onset, shape (blocks, 3)."""

    def __init__(self, result: Result, forces: tuple[Forces, Forces], count: int) -> None:
        self.assembly, self.count, self.effort = result.assembly, count, Effort()
        problem = self.assembly.problem
        onset = result.required()  # λ is in units of it, forces in those of the largest load there
        self.unit = onset if onset > ZERO else 1.0
        largest = max(problem.force_sizes(load).max() for load in (problem.dead, self.unit * problem.live))
        self.blocks = MovedBlocks.of(self.assembly, forces, float(largest), self.unit)
        corners = self.blocks.corner.reshape(-1, 2)
        self.size = 2 * float(np.hypot(*(corners - corners.mean(axis=0)).T).max())
        self.motion = np.zeros((len(self.assembly.scene.blocks), 3))
        self.steps = [Step(0 * self.motion, onset, self.blocks.at_rest)]
        try:
            self._onset(result)
            self._follow()
        except _PathEnded as end:
            self.end: Reason = end.args[0]
        units, points = by_component(2, problem.length_unit, 1.0), self.blocks.at_rest
        self.steps = [replace(one, poses=one.poses * units, touch=one.touch[points]) for one in self.steps]
        self.motion = self.motion * units

    def _onset(self, result: Result) -> None:
        """The mechanism of greatest λ at rest, which must be that of the result, and must hinge."""
        first = self.steps[0]
        found = self.blocks.optimum(first.touch, first.poses, None, self.effort)
        if found is None or not same(self.unit * found.value, first.load_factor):
            slides = np.flatnonzero(joint_motion(self.assembly, result.solution).slides)
            associative, pairs = found and self.unit * found.value, self.assembly.pairs(slides)
            raise _PathEnded(reason(Code.NOT_HINGING, associative=associative, pairs=pairs))
        self.steps = [replace(first, touch=self._opened(first.touch, first.poses, found))]
        self.motion = found.motion

    def _follow(self) -> None:
        """Stretch after stretch, each to its event, until one ends the path."""
        opens, hint, idle = ~self.steps[0].touch & self.blocks.at_rest, self.motion, 0
        while True:
            last = self.steps[-1]
            stretch, event = self._to_event(self._stretch(last, opens, hint))
            # Several events in one place are one after the other; without an end they lead nowhere.
            idle = 0 if np.abs(stretch.poses - last.poses).max() > _CLOSED else idle + 1
            if idle > _MOST_EVENTS:
                raise _PathEnded(reason(Code.LOCKS))
            touch, hint = stretch.chain.touch.copy(), stretch.motion
            if event.borne:
                try:
                    touch, hint = self._opened(touch, stretch.poses, event.borne), event.borne.motion
                except _PathEnded as end:
                    self._add(stretch, touch, end.args[0])
                    raise
            else:
                touch[event.which] = True
            changed = np.flatnonzero((touch != stretch.chain.touch).any(axis=1))
            opens = stretch.chain.touch & ~touch
            self._add(stretch, touch, reason(event.code, pairs=self.assembly.pairs(changed)))

    def _add(self, stretch: _Stretch, touch: np.ndarray, event: Reason | None = None) -> None:
        if len(self.steps) >= _MOST:
            raise _PathEnded(reason(Code.STILL_CARRIES, steps=len(self.steps)))
        self.steps.append(Step(stretch.poses, self.unit * float(stretch.point[-1]), touch, event))

    def _opened(self, touch: np.ndarray, poses: np.ndarray, found: ForceOptimum) -> np.ndarray:
        """Which corners go on touching in the motion that statics found: some open, and none slides."""
        stays, slides = self.blocks.after(touch, poses, found)
        if slides.any():
            raise _PathEnded(reason(Code.JOINTS_SLIDE, pairs=self.assembly.pairs(np.flatnonzero(slides))))
        if (stays == touch).all():
            raise _PathEnded(reason(Code.LOCKS))
        return stays

    def _stretch(self, step: Step, opens: np.ndarray, hint: np.ndarray) -> _Stretch:
        """The way on: that in which corners open, if any do, else that of the motion before, or back."""
        chain = Chain(self.blocks, step.touch)
        stretch = self._onward(chain, chain.start(step.poses), hint)
        if stretch is None:
            raise _PathEnded(reason(Code.LOCKS))
        back = stretch._replace(row=-stretch.row)
        if opens.any():
            opening, _ = self.blocks.relative(stretch.poses, stretch.motion)
            return stretch if (opening * opens).sum() > 0 else back
        # A joint that has closed stays so in one sense only, which may be the way back.
        event, _ = self._try(stretch, _PROBE)
        return back if event and not self._try(back, _PROBE)[0] else stretch

    def _onward(self, chain: Chain, point: np.ndarray, hint: np.ndarray) -> _Stretch | None:
        """A point and its direction, that of a motion of the blocks; None where nothing moves."""
        found = chain.tangents(point)
        if len(found) > 1:
            raise _PathEnded(reason(Code.BRANCHES))
        for row in found:
            motion = chain.of_blocks(row)
            if (fastest := self.blocks.fastest(chain.of_blocks(point), motion)) > _MOVES:
                sense = 1.0 if (motion * hint).sum() >= 0 else -1.0
                return _Stretch(chain, point, sense * self.size / fastest * row)
        return None

    def _to_event(self, stretch: _Stretch) -> tuple[_Stretch, _PathEvent]:
        """Go on to the next event: the last state before it."""
        step = self._first_step(stretch)
        while step >= _SHORTEST:
            event, ahead = self._try(stretch, step)
            if event is not None:
                return self._enclosed(stretch, step, event)
            if ahead is None:
                step /= 4
            else:
                stretch, step = ahead, min(2 * step, self._first_step(ahead))
                self._add(stretch, stretch.chain.touch)
        raise _PathEnded(reason(Code.LOCKS))

    def _first_step(self, stretch: _Stretch) -> float:
        """What changes λ by its share of the onset's, along the tangent."""
        return min(_LONGEST, max(_SHORTEST, 1 / self.count / max(abs(stretch.row[-1]), _MOVES)))

    def _try(self, stretch: _Stretch, step: float) -> tuple[_PathEvent | None, _Stretch | None]:
        """A step: what would happen on it, and where it ends; neither if no such state is found."""
        row, guess = np.append(stretch.row[:-1], 0.0), stretch.point + step * stretch.row
        point = stretch.chain.corrected(guess, row, float(row @ guess))
        ahead = None if point is None else self._onward(stretch.chain, point, stretch.motion)
        return (None, None) if ahead is None else (self._event(ahead), ahead)

    def _event(self, ahead: _Stretch) -> _PathEvent | None:
        """What has happened before a state, if anything has."""
        poses, load_factor = ahead.poses, float(ahead.point[-1])
        if load_factor < 0:
            return _PathEvent(Code.REACHES_ZERO, [])
        # Joints that have a length and touch in one corner are open by an angle.
        touch, angles = ahead.chain.touch, np.diff(poses[self.blocks.blocks, 2])[:, 0]
        hinged = self.blocks.at_rest.all(axis=1) & (touch.sum(axis=1) == 1)
        closed = hinged & (np.where(touch[:, 0], -angles, angles) < -_CLOSED)
        if closed.any():
            return _PathEvent(Code.JOINT_CLOSES, np.flatnonzero(closed).tolist())
        if over := overlapping(self.blocks.geometry, poses, ahead.chain.body):
            return _PathEvent(Code.BLOCKS_MEET, sorted(over))
        borne = self.blocks.optimum(touch, poses, load_factor, self.effort)
        if borne is None:
            raise _PathEnded(reason(Code.FORCES_UNDECIDED))
        if borne.value > BORNE:
            return _PathEvent(Code.JOINT_OPENS, [], borne)
        return None

    def _enclosed(self, stretch: _Stretch, step: float, event: _PathEvent) -> tuple[_Stretch, _PathEvent]:
        """The last state before an event within a step, by bisection, and the event; at λ = 0, and where
        blocks meet, the path ends. After a joint has opened what is missed grows from zero: a secant finds
        from where."""
        low, high, before, farther = 0.0, step, stretch, (0.0, 0.0)
        while high - low > _ENCLOSED:
            if event.code is Code.REACHES_ZERO and (last := self._at_zero(before)):
                before = last
                break
            middle, excess = (low + high) / 2, event.borne.value - BORNE if event.borne else 0.0
            if 0 < excess < farther[1]:
                root = high - excess * (farther[0] - high) / (farther[1] - excess)
                middle = min(max(root + 0.01 * (high - root), low + 0.01 * (high - low)), high)
            found, ahead = self._try(stretch, middle)
            if ahead is None or not low < middle < high:
                break
            if found is None:
                low, before = middle, ahead
                continue
            farther, high, event = (high, excess), middle, found
            if event.borne and event.borne.value < _NEAR * BORNE:
                before = ahead
                break
        if event.code in (Code.REACHES_ZERO, Code.BLOCKS_MEET):
            meet = {"blocks": self.assembly.names(np.array(event.which))} if event.which else {}
            said = reason(event.code, **meet)
            self._add(before, before.chain.touch, said)
            raise _PathEnded(said)
        return before, event

    def _at_zero(self, before: _Stretch) -> _Stretch | None:
        """The state of λ = 0 ahead, if nothing else has happened before it."""
        row = np.append(np.zeros(len(before.row) - 1), 1.0)
        point = before.chain.corrected(before.point, row, 0.0)
        if point is None:
            return None
        last = before._replace(point=np.append(point[:-1], 0.0))
        return None if self._event(last) else last

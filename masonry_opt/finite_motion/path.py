"""Equilibrium path of a hinging mechanism in the plane, at finite rotations, from collapse to λ = 0.

The path is a sequence of stretches. On a stretch, the blocks form rigid bodies with hinges between them,
which do not change (class Chain). A predictor–corrector method follows the equilibrium states: each step
along the tangent is corrected by Newton's method. A stretch ends at an event, which bisection locates: a
joint opens, a joint closes, blocks meet, or λ vanishes. A linear program over the contact forces finds the
joints that open.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, NoReturn

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.effort import Effort
from masonry_opt.finite_motion.chain import Chain
from masonry_opt.finite_motion.moved_blocks import ForceOptimum, MovedBlocks, overlapping
from masonry_opt.problem.loads import Forces, by_component
from masonry_opt.result import Result
from masonry_opt.solution.motion import joint_motion
from masonry_opt.solution.reasons import Code, Reason, reason

#: Largest violation of equilibrium and yield, in the unit of force, at which the forces of displaced blocks
#: count as admissible.
LARGEST_ADMISSIBLE_VIOLATION = 1e-8
#: The bisection for the opening of a joint stops if the violation of equilibrium is less than this multiple
#: of ``LARGEST_ADMISSIBLE_VIOLATION``, the largest admissible violation. With a smaller value, openings are
#: located more exactly, but in more steps.
_JUST_OPENING = 10.0
#: A hinge counts as closed when the edges of its two blocks overlap by more than this angle (rad). The value
#: must exceed rounding errors.
_CLOSING_ANGLE = 1e-12
#: Largest displacement of the fastest corner in one step of the path, relative to the size of the scene.
_LONGEST_STEP = 0.02
#: Smallest displacement of the fastest corner in one step of the path, relative to the size of the scene. If
#: a step of this size has no solution, the mechanism counts as locked.
_SHORTEST_STEP = 1e-6
#: Bisection for an event stops when its interval of step lengths is this narrow, relative to the size of the
#: scene.
_EVENT_WIDTH = 1e-13
#: Blocks count as at rest if the speed of the fastest corner is at most this value. The speed is computed
#: for a unit tangent of the path, whose components are the rates of the poses and of λ.
_LEAST_SPEED = 1e-7
#: Length of the trial step that tests in which direction blocks can move, relative to the size of the scene.
_PROBE_STEP = 1e-5
#: Largest number of states of a path. If more states are needed, the path ends with the reason "still
#: carries".
_MOST_PATH_STATES = 2000
#: Largest number of consecutive events without any motion. After more events, the mechanism counts as locked.
_MOST_EVENTS = 20


@dataclass(frozen=True)
class PathState:
    """One state on the equilibrium path of a mechanism: displaced blocks, load factor and contacts.

    The states of a complete path are in the units of the case. During the computation of a path in the plane,
    its states are in the units of the problem.
    """

    #: Poses of all blocks. In the plane, (x, y, θ) is a rotation by θ about the origin, then a translation,
    #: shape (blocks, 3). In space, a pose is a translation and a rotation vector, shape (blocks, 6).
    poses: np.ndarray
    load_factor: float  #: load factor λ at which the displaced blocks are in equilibrium
    #: True for the contact points that remain closed as the path continues from this state, shape (points,).
    #: While a path in the plane is computed, the shape is (joints, 2), for the two corners of each joint.
    touch: np.ndarray
    #: Event at this state, such as the opening of a joint; None if there is no event.
    event: Reason | None = None

    __repr__ = brief


#: Function that is called at each new state of a path, with the number of the state and its load factor. The
#: state at rest has the number 0.
PathProgress = Callable[[int, float], None]


class _PathEvent(NamedTuple):
    """Event that ends a part of the path: a joint opens or closes, blocks meet, or λ decreases to zero."""

    code: Code
    which: list[int]  #: indices of the joints that close, or of the blocks that meet
    #: If a joint opens: solution of the linear program which shows that no admissible contact forces exist.
    #: None for other kinds of events.
    borne: ForceOptimum | None = None


class _Stretch(NamedTuple):
    """State and tangent on a stretch, which is a part of the path between two events."""

    chain: Chain  #: rigid bodies and hinges along this part of the path
    point: np.ndarray  #: point of the chain's equilibrium curve
    #: Tangent at the point, scaled so that the fastest corner moves by the size of the scene.
    row: np.ndarray

    @property
    def poses(self) -> np.ndarray:
        """Poses (x, y, θ) of all blocks at ``point``, shape (blocks, 3)."""
        return self.chain.of_blocks(self.point)

    @property
    def motion(self) -> np.ndarray:
        """Velocities of all blocks (rates of x, y and θ) along the tangent ``row``, shape (blocks, 3)."""
        return self.chain.of_blocks(self.row)


class _PathEnded(Exception):
    """Exception that ends the computation of a path; its argument is the reason for the end."""


class HingingPath:
    """Equilibrium path of a hinging mechanism in the plane, from the onset of collapse.

    Attributes
    ----------
    steps: States of the path; the first is at rest.
    end: Reason why the path ends.
    motion: Rates of the poses of all blocks at the onset of collapse, shape (blocks, 3).
    """

    def __init__(
        self, result: Result, forces: tuple[Forces, Forces], count: int, progress: PathProgress
    ) -> None:
        self.progress = progress
        self.assembly, self.count, self.effort = result.assembly, count, Effort()
        problem = self.assembly.problem
        # The unit of λ is the load factor at the onset of collapse, or 1 if this load factor is zero. The
        # unit of force is the largest dead or live load of a block at the onset of collapse.
        onset = result.required()
        self.unit = onset if onset > problem.load_factor_scale.zero else 1.0
        largest = max(problem.force_sizes(load).max() for load in (problem.dead, self.unit * problem.live))
        self.blocks = MovedBlocks.of(self.assembly, forces, float(largest), self.unit)
        corners = self.blocks.corner.reshape(-1, 2)
        self.size = 2 * float(np.hypot(*(corners - corners.mean(axis=0)).T).max())
        self.motion = np.zeros((len(self.assembly.scene.blocks), 3))
        self.steps = [PathState(0 * self.motion, onset, self.blocks.at_rest)]
        try:
            self._onset(result)
            self._follow()
        except _PathEnded as end:
            self.end: Reason = end.args[0]
        units, points = by_component(2, problem.length_unit, 1.0), self.blocks.at_rest
        self.steps = [
            replace(step, poses=step.poses * units, touch=step.touch[points]) for step in self.steps
        ]
        self.motion = self.motion * units

    def _onset(self, result: Result) -> None:
        """Find the mechanism at the onset of collapse.

        If λ of the result is the associative load factor, the mechanism is that of associative limit analysis
        of the scene at rest. Otherwise the mechanism is that of the result. The path ends at once if joints
        with a force slide in the result, because only hinging mechanisms have a finite motion here.
        """
        first = self.steps[0]
        optimum = self.blocks.optimum(first.touch, first.poses, None, self.effort)
        scale = self.assembly.problem.load_factor_scale
        if optimum is None or not scale.equal(self.unit * optimum.value, first.load_factor):
            state = self.blocks.state_of(result)
            slides = np.flatnonzero(joint_motion(self.assembly, result.solution).slides & state.pressed)
            if len(slides) or not self._can_move(state):
                associative = None if optimum is None else self.unit * optimum.value
                pairs = self.assembly.pairs(slides)
                slip = self.blocks.slip_share(first.touch, first.poses, state.motion)
                raise _PathEnded(reason(Code.NOT_HINGING, associative=associative, pairs=pairs, slip=slip))
            optimum = state
        self.steps = [replace(first, touch=self._opened(first.touch, first.poses, optimum))]
        self.motion = optimum.motion

    def _can_move(self, state: ForceOptimum) -> bool:
        """Return True if blocks can move about the hinges of a mechanism without any slip.

        The mechanism itself may contain small slips, below the threshold at which a joint counts as sliding.
        """
        first = self.steps[0]
        touch, _ = self.blocks.after(first.touch, first.poses, state)
        chain = Chain(self.blocks, touch)
        motions = map(chain.of_blocks, chain.tangents(chain.start(first.poses)))
        return any(self.blocks.fastest(first.poses, motion) > _LEAST_SPEED for motion in motions)

    def _follow(self) -> None:
        """Compute the parts of the path between events, one after the other, until an event ends the path."""
        opens, hint, events_here = ~self.steps[0].touch & self.blocks.at_rest, self.motion, 0
        while True:
            last = self.steps[-1]
            stretch, event = self._to_event(self._stretch(last, opens, hint))
            # Count the events that occur while the blocks do not move. If there are too many, the blocks are
            # locked.
            moves = np.abs(stretch.poses - last.poses).max() > _CLOSING_ANGLE
            events_here = 0 if moves else events_here + 1
            if events_here > _MOST_EVENTS:
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
        """Append a state to the path; end the path if it has too many states."""
        if len(self.steps) >= _MOST_PATH_STATES:
            raise _PathEnded(reason(Code.STILL_CARRIES, steps=len(self.steps)))
        self.steps.append(PathState(stretch.poses, self.unit * float(stretch.point[-1]), touch, event))
        self.progress(len(self.steps) - 1, self.steps[-1].load_factor)

    def _opened(self, touch: np.ndarray, poses: np.ndarray, optimum: ForceOptimum) -> np.ndarray:
        """Return a mask of the corners that stay in contact as joints begin to open, shape (joints, 2).

        The path ends if a joint slides in the motion of ``optimum``, or if no corner opens.
        """
        stays, slides = self.blocks.after(touch, poses, optimum)
        if slides.any():
            pairs = self.assembly.pairs(np.flatnonzero(slides))
            slip = self.blocks.slip_share(touch, poses, optimum.motion)
            raise _PathEnded(reason(Code.JOINTS_SLIDE, pairs=pairs, slip=slip))
        if (stays == touch).all():
            raise _PathEnded(reason(Code.LOCKS))
        return stays

    def _stretch(self, step: PathState, opens: np.ndarray, hint: np.ndarray) -> _Stretch:
        """Return the part of the path that begins at the state ``step``, with its tangent.

        If corners open, the tangent has the direction in which they open. Otherwise it has the direction of
        ``hint``. If a small step in this direction leads to an event at once, and a step in the opposite
        direction does not, the direction is reversed.
        """
        chain = Chain(self.blocks, step.touch)
        stretch = self._onward(chain, chain.start(step.poses), hint)
        if stretch is None:
            raise _PathEnded(reason(Code.LOCKS))
        back = stretch._replace(row=-stretch.row)
        if opens.any():
            opening, _ = self.blocks.relative(stretch.poses, stretch.motion)
            return stretch if (opening * opens).sum() > 0 else back
        # Try a small step in both directions of the tangent. A joint that has just closed stays closed in one
        # of the two directions, and opens again in the other.
        event, _ = self._try(stretch, _PROBE_STEP)
        if event is None:
            return stretch
        event_back, _ = self._try(back, _PROBE_STEP)
        return stretch if event_back else back

    def _onward(self, chain: Chain, point: np.ndarray, hint: np.ndarray) -> _Stretch | None:
        """Return the part of the path that starts at a point and continues in the direction of ``hint``.

        ``hint`` are rates of the poses of all blocks. The result is None if no block can move. The path ends
        at a bifurcation, at which several tangents exist.
        """
        tangents = chain.tangents(point)
        if len(tangents) > 1:
            raise _PathEnded(reason(Code.BRANCHES))
        for tangent in tangents:
            motion = chain.of_blocks(tangent)
            fastest = self.blocks.fastest(chain.of_blocks(point), motion)
            if fastest > _LEAST_SPEED:
                sense = 1.0 if (motion * hint).sum() >= 0 else -1.0
                return _Stretch(chain, point, sense * self.size / fastest * tangent)
        return None

    def _to_event(self, stretch: _Stretch) -> tuple[_Stretch, _PathEvent]:
        """Follow the path to its next event, such as a joint that opens, and return the last state before it.

        The event is also returned. If a step has no solution, its length is divided by four. After a
        successful step, the length is doubled, up to that of ``_first_step``. If steps become too short, the
        mechanism is locked.
        """
        step = self._first_step(stretch)
        while step >= _SHORTEST_STEP:
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
        """Return the length of a step in which λ changes by about 1 / ``count`` of its initial value."""
        step = 1 / self.count / max(abs(stretch.row[-1]), _LEAST_SPEED)
        return min(_LONGEST_STEP, max(_SHORTEST_STEP, step))

    def _try(self, stretch: _Stretch, step: float) -> tuple[_PathEvent | None, _Stretch | None]:
        """Make a predictor–corrector step. Return an event within the step, and the state at the step's end.

        The event is None if no event occurs within the step. Both are None if the corrector finds no state.
        """
        row, guess = np.append(stretch.row[:-1], 0.0), stretch.point + step * stretch.row
        point = stretch.chain.corrected(guess, row, float(row @ guess))
        if point is None:
            return None, None
        ahead = self._onward(stretch.chain, point, stretch.motion)
        if ahead is None:
            return None, None
        return self._event(ahead), ahead

    def _event(self, ahead: _Stretch) -> _PathEvent | None:
        """Return the event that makes a state inadmissible, or None if the state is admissible.

        Events are tested in this order:

        1. λ < 0.
        2. A hinged joint has rotated beyond its closed position.
        3. Blocks overlap.
        4. No admissible forces balance the loads, so a joint opens.

        If the solver fails in the last test, the path ends.
        """
        poses, load_factor = ahead.poses, float(ahead.point[-1])
        if load_factor < 0:
            return _PathEvent(Code.REACHES_ZERO, [])
        # If a joint touches at only one of its two corners, the edges of its two blocks enclose an angle. If
        # the angle is negative, the blocks overlap.
        touch, angles = ahead.chain.touch, np.diff(poses[self.blocks.blocks, 2])[:, 0]
        hinged = self.blocks.at_rest.all(axis=1) & (touch.sum(axis=1) == 1)
        closed = hinged & (np.where(touch[:, 0], -angles, angles) < -_CLOSING_ANGLE)
        if closed.any():
            return _PathEvent(Code.JOINT_CLOSES, np.flatnonzero(closed).tolist())
        blocks_in_contact = overlapping(self.blocks.geometry, poses, ahead.chain.body)
        if blocks_in_contact:
            return _PathEvent(Code.BLOCKS_MEET, sorted(blocks_in_contact))
        optimum = self.blocks.optimum(touch, poses, load_factor, self.effort)
        if optimum is None:
            raise _PathEnded(reason(Code.FORCES_UNDECIDED))
        if optimum.value > LARGEST_ADMISSIBLE_VIOLATION:
            return _PathEvent(Code.JOINT_OPENS, [], optimum)
        return None

    def _enclosed(self, stretch: _Stretch, step: float, event: _PathEvent) -> tuple[_Stretch, _PathEvent]:
        """Enclose an event within a step by bisection; return the last state before it, and the event.

        If a joint opens, the violation of equilibrium grows from zero, and the secant method proposes the
        next trial length. The path ends at λ = 0, or if blocks meet.
        """
        low, high, before = 0.0, step, stretch
        # The secant method needs the step length and the violation of the previous trial beyond the event.
        farther_step = farther_excess = 0.0
        while high - low > _EVENT_WIDTH:
            if event.code is Code.REACHES_ZERO:
                at_zero = self._at_zero(before)
                if at_zero is not None:
                    before = at_zero
                    break
            middle, excess = (
                (low + high) / 2,
                event.borne.value - LARGEST_ADMISSIBLE_VIOLATION if event.borne else 0.0,
            )
            if 0 < excess < farther_excess:
                root = high - excess * (farther_step - high) / (farther_excess - excess)
                middle = min(max(root + 0.01 * (high - root), low + 0.01 * (high - low)), high)
            trial_event, ahead = self._try(stretch, middle)
            if ahead is None or not low < middle < high:
                break
            if trial_event is None:
                low, before = middle, ahead
                continue
            farther_step, farther_excess = high, excess
            high, event = middle, trial_event
            if event.borne and event.borne.value < _JUST_OPENING * LARGEST_ADMISSIBLE_VIOLATION:
                before = ahead
                break
        if event.code in (Code.REACHES_ZERO, Code.BLOCKS_MEET):
            self._end_at(before, event)
        return before, event

    def _end_at(self, state: _Stretch, event: _PathEvent) -> NoReturn:
        """Append the last state and its event to the path, and raise the exception that ends the path."""
        values = {"blocks": self.assembly.names(np.array(event.which))} if event.which else {}
        why = reason(event.code, **values)
        self._add(state, state.chain.touch, why)
        raise _PathEnded(why)

    def _at_zero(self, before: _Stretch) -> _Stretch | None:
        """Return the state at which λ has decreased to zero, by Newton's method from the state ``before``.

        The result is None if Newton's method finds no such state, or if another event occurs first.
        """
        row = np.append(np.zeros(len(before.row) - 1), 1.0)
        point = before.chain.corrected(before.point, row, 0.0)
        if point is None:
            return None
        last = before._replace(point=np.append(point[:-1], 0.0))
        return None if self._event(last) else last

"""Positions of blocks and their contacts after a settlement of finite size, in the plane.

The mechanism of a small settlement determines which contact points stay closed, slide or open. Blocks whose
joints stay closed form one rigid body. The Gauss–Newton method then finds positions at finite rotations in
which hinges are closed and sliding corners are on the edges along which they slide.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.displaced import placed, turned
from masonry_opt.problem.limited_forces import LimitedForce, Role
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.rows import dots, lengths, linked
from masonry_opt.solution.motion import fastest, joint_motion, velocities
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import SEPARATES, SLIDES

#: Number of steps in which the supports move to their final positions. With more steps, the Gauss–Newton
#: method starts closer to the solution if rotations are large.
_STEPS = 10
#: Largest number of Gauss–Newton iterations in one step of the supports. If they do not converge, the
#: computation continues with the last iterate.
_MOST_CORRECTIONS = 20
#: Gauss–Newton iterations have converged if positions change by less than this fraction of the size of the
#: scene.
_CONVERGED_STEP = 1e-13
#: Weight of a slip at a hinge in the least-squares problem, if the weight of a gap is 1. The weight is small,
#: because hinges on straight edges cannot rotate without a small slip. With a smaller value, gaps close more
#: exactly.
_SLIP_WEIGHT = 1e-3
#: Largest gap that may remain at a contact point that the mechanism keeps closed, relative to the largest
#: displacement of a contact point. A larger gap raises an error. Small gaps are normal in surveyed scenes.
_LARGEST_GAP = SEPARATES
#: Largest slip at a hinge, relative to the largest displacement of a contact point. A larger slip raises an
#: error, because the mechanism of an infinitesimal settlement no longer approximates the finite settlement.
_LARGEST_SLIP = 0.05
#: A singular value counts as zero in the least-squares problem of a Gauss–Newton step if it is below this
#: fraction of the largest singular value.
_SINGULAR = 1e-10


class SettlementBlockedError(Exception):
    """Error: the blocks cannot follow the movement of the supports; the message states the reason."""


@dataclass(frozen=True)
class Contacts:
    """Contact points of a plane scene whose supports move, with a mask of the points that stay closed.

    Positions and poses are those of the geometry at rest, in the scene's unit of length.

    Attributes
    ----------
    assembly: Assembly of the scene at rest.
    touches: True for the contact points that stay closed or slide, shape (points,).
    slides: True for the joints that slide, shape (joints,).
    rates: Velocities (vx, vy, ω) of all blocks for the movement of the supports, shape (blocks, 3). They are
        those of the point of each block at the origin.
    supports: Indices of the supports that move.
    contact: Position at rest of each contact point that stays closed, shape (points, 2): the end of the
        joint. At a joint that crushes, the position is where the joint neither opens nor crushes.
    crushed_depth: Depth over which each joint crushes, relative to its length, shape (joints,).
    struts: Ties and props that keep their length in the mechanism.
    """

    assembly: Assembly
    touches: np.ndarray
    slides: np.ndarray
    rates: np.ndarray
    supports: np.ndarray
    contact: np.ndarray
    crushed_depth: np.ndarray
    struts: tuple[LimitedForce, ...] = ()

    @classmethod
    def of(cls, freed: Assembly, solution: Solution, scale: float, supports: np.ndarray) -> "Contacts":
        """Create the contacts from the mechanism of a solution.

        The velocities of the mechanism are multiplied by ``scale``.
        """
        motion, joints = joint_motion(freed, solution), freed.joints
        assert solution.d is not None
        gap = np.empty(len(joints.joint))  # opening rate of each contact point
        gap[freed.pressed] = freed.problem.at_points(freed.problem.motion(solution.d))
        nearest, speed = -joints.most(-gap), fastest(freed, solution.d)
        contact, depth = _crushed(freed, solution, gap, speed)
        # A joint that slips while it crushes counts as sliding.
        slip = np.abs(freed.problem.shears(freed.problem.motion(solution.d))).max(axis=0)
        slides = motion.slides | (motion.crushes & (freed.most_of_joints(slip) > SLIDES * speed))
        touches = ~motion.separates[joints.joint] & (gap <= nearest[joints.joint] + SEPARATES * speed)
        blocks = np.arange(len(freed.scene.blocks))
        at_origin = velocities(freed, solution.d, blocks, np.zeros((len(blocks), 2)))
        rotation = np.zeros(len(blocks))
        rotation[freed.movable] = freed.problem.moments(solution.d)[:, 0] / freed.problem.length_unit
        rates = scale * np.column_stack([at_origin, rotation])
        struts = _stiff_struts(freed, rates, scale * speed)
        return cls(freed, touches, slides, rates, supports, contact, depth, struts)

    @property
    def joints(self) -> Joints:
        """Joints at rest."""
        return self.assembly.joints

    @cached_property
    def bodies(self) -> np.ndarray:
        """Index of the rigid body of each block, shape (blocks,)."""
        joints = self.joints
        closed = np.bincount(joints.joint, self.touches) == np.bincount(joints.joint)
        rigid = closed & (joints.extent > 0) & ~self.slides
        fixed = np.setdiff1d(np.arange(len(self.rates)), self.assembly.movable)
        ends = np.column_stack([joints.first, joints.second])[rigid]
        # Supports that overlap below a block move together, see :func:`~.freed_supports.refuse_overlapping`.
        links = np.vstack([ends, np.column_stack([fixed[1:], fixed[:-1]]), joints.overlaps[:, 1:]])
        return linked(len(self.rates), *links.T)

    @cached_property
    def _intervals(self) -> np.ndarray:
        """Start and end of the edges of both blocks along each joint, shape (joints, 2 blocks, 2 ends).

        Positions are measured along the tangent from the joint's start. A block that touches with a corner
        has an interval without length.
        """
        joints, tolerance = self.joints, 2 * self.assembly.geometry.contact_tolerance
        tail, tip, owner = self.assembly.geometry.edges
        intervals = np.zeros((len(joints.first), 2, 2))
        for number, start in enumerate(joints.start):
            own = float(joints.extent[number])
            for side, block in enumerate((joints.first[number], joints.second[number])):
                ends = np.stack([tail, tip])[:, owner == block] - start
                off, at = ends @ joints.normal[number], ends @ joints.tangent[number]
                on_line = (np.abs(off) <= tolerance).all(axis=0)
                low, high = at.min(axis=0), at.max(axis=0)
                # Select the edges of the block that are on the line of the joint, and overlap the joint or
                # touch one of its ends.
                near = on_line & (low <= own + tolerance) & (high >= -tolerance)
                bounds = (low[near].min(), high[near].max()) if near.any() else (0.0, 0.0)
                intervals[number, side] = bounds
        return intervals

    @cached_property
    def face(self) -> np.ndarray:
        """Index of the block whose edge each contact point slides along, shape (points,).

        The other block touches this edge with a corner, or with a parallel edge.
        """
        joints = self.joints
        first, second = joints.first[joints.joint], joints.second[joints.joint]
        tangent = joints.tangent[joints.joint]
        at = dots(self.contact - joints.start[joints.joint], tangent)
        slip = placed(self.contact, self.rates[first]) - placed(self.contact, self.rates[second])
        ahead = at + np.sign(dots(slip, tangent)) * self.assembly.geometry.tolerance
        low, high = self._intervals[joints.joint, 1].T
        on_second = (low < ahead) & (ahead < high)
        return np.where(on_second, second, first)

    def poses(self) -> np.ndarray:
        """Return the poses of all blocks after the movement of the supports, shape (blocks, 3).

        Raises SettlementBlockedError if no positions satisfy the contact conditions.
        """
        body = self.bodies
        fixed = np.ones(len(self.rates), dtype=bool)
        fixed[self.assembly.movable] = False
        is_prescribed = np.zeros(body.max() + 1, dtype=bool)
        is_prescribed[body[fixed]] = is_prescribed[body[self.supports]] = True
        # A body that contains a moving support or a fixed block has the velocities of this block. Every other
        # body has the velocities of its largest block.
        order = np.argsort(self.assembly.geometry.size, kind="stable")
        of_body = np.zeros((body.max() + 1, 3))
        for block in [*order, *self.supports, *np.flatnonzero(fixed)]:
            of_body[body[block]] = self.rates[block]
        poses = np.zeros_like(of_body)
        for step in range(1, _STEPS + 1):
            ahead = self._rigid(of_body, step / _STEPS)
            before = self._rigid(of_body, (step - 1) / _STEPS)
            poses = self._corrected(
                np.where(is_prescribed[:, None], ahead, poses + ahead - before), ~is_prescribed
            )
        self._refuse_gaps(poses[body])
        return poses[body]

    def _rigid(self, of_body: np.ndarray, share: float) -> np.ndarray:
        """Return the poses of all bodies after a given fraction of the supports' movement.

        The reference point of each body, the centroid of its support or of its largest block, moves along a
        straight line.
        """
        poses = share * of_body
        centroid = self.assembly.geometry.centroid
        at = np.zeros((len(of_body), 2))
        order = np.argsort(self.assembly.geometry.size, kind="stable")
        for block in [*order, *self.supports]:
            at[self.bodies[block]] = centroid[block]
        across = np.column_stack([-at[:, 1], at[:, 0]])
        moved = at + share * (of_body[:, :2] + of_body[:, 2:] * across)
        poses[:, :2] = moved - turned(at, poses)
        return poses

    def _corrected(self, poses: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Return poses of the bodies that satisfy the contact conditions, by the Gauss–Newton method.

        If the conditions have several solutions, each iteration selects the nearest.
        """
        if not free.any():
            return poses
        corners, _ = self.assembly.geometry.corners
        size = float(np.ptp(corners, axis=0).max())
        scale = np.tile([1.0, 1.0, 1.0 / size], np.count_nonzero(free))
        for _ in range(_MOST_CORRECTIONS):
            normal, tangential, jacobian = self._conditions(poses)
            weights = np.repeat([1.0, _SLIP_WEIGHT], [len(normal), len(tangential)])
            matrix = weights[:, None] * jacobian[:, np.repeat(free, 3)] * scale
            residual = weights * np.concatenate([normal, tangential])
            step = scale * np.linalg.lstsq(matrix, -residual, rcond=_SINGULAR)[0]
            poses = poses.copy()
            poses[free] += step.reshape(-1, 3)
            if np.abs(step / scale).max() <= _CONVERGED_STEP * size:
                break
        return poses

    def _conditions(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return gaps at contact points that must stay closed, slips at hinges, and the derivatives of both.

        Gaps are measured along the normal of the edge of the point's ``face``. Changes of length of ties and
        props that neither yield nor slacken follow the gaps. The derivatives are with respect to the poses of
        all bodies: first those of the gaps, then those of the slips.
        """
        joints, body = self.joints, self.bodies
        points = np.flatnonzero(self.touches & (body[joints.first] != body[joints.second])[joints.joint])
        joint = joints.joint[points]
        face, sticks = body[self.face[points]], ~self.slides[joint]
        apart, slope = np.zeros((len(points), 2)), np.zeros((len(points), 2, *poses.shape))
        rows = np.arange(len(points))
        for sign, block in ((1.0, joints.first[joint]), (-1.0, joints.second[joint])):
            own = body[block]
            arm = turned(self.contact[points], poses[own])
            apart += sign * (arm + poses[own, :2])
            slope[rows[:, None], [0, 1], own[:, None], [0, 1]] += sign
            slope[rows, :, own, 2] += sign * np.column_stack([-arm[:, 1], arm[:, 0]])
        parts, derivatives = [], []
        for direction in (joints.normal[joint], joints.tangent[joint]):
            along = turned(direction, poses[face])
            derivative = np.einsum("pc,pcbk->pbk", along, slope)
            derivative[rows, face, 2] += dots(apart, np.column_stack([-along[:, 1], along[:, 0]]))
            parts.append(dots(apart, along))
            derivatives.append(derivative.reshape(len(points), poses.size))
        change, of_struts = self._lengthening(poses)
        derivative = np.vstack([derivatives[0], of_struts, derivatives[1][sticks]])
        return np.append(parts[0], change), parts[1][sticks], derivative

    def _lengthening(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the lengthening of each tie or prop, and its derivatives with respect to the poses.

        The shapes are (k,) and (k, 3 bodies).
        """
        change, slope = np.zeros(len(self.struts)), np.zeros((len(self.struts), *poses.shape))
        for row, strut in enumerate(self.struts):
            apart = np.zeros(2)
            ends = [(action.block, action.point) for action in strut.actions]
            for sign, (block, point) in zip((-1.0, 1.0), ends, strict=True):
                apart += sign * (placed(point, poses[self.bodies[block]]) if block >= 0 else point)
            length = float(np.hypot(*apart))
            change[row] = length - float(np.hypot(*(ends[1][1] - ends[0][1])))
            for sign, (block, point) in zip((-1.0, 1.0), ends, strict=True):
                if block >= 0:
                    body = self.bodies[block]
                    x, y = turned(point, poses[body])
                    along = sign * apart / length
                    slope[row, body] += [*along, along @ np.array([-y, x])]
        return change, slope.reshape(len(self.struts), poses.size)

    def _refuse_gaps(self, poses: np.ndarray) -> None:
        """Raise SettlementBlockedError if closed contacts would open or hinges would slip by too much.

        The limits are ``_LARGEST_GAP`` and ``_LARGEST_SLIP``. An overlap counts as a gap.
        """
        of_body = np.zeros((self.bodies.max() + 1, 3))
        of_body[self.bodies] = poses
        normal, tangential, _ = self._conditions(of_body)
        point = self.joints.point
        moved = placed(point, poses[self.joints.first[self.joints.joint]])
        movement = lengths(moved - point).max(initial=0.0)
        gap, slip = (np.abs(part).max(initial=0.0) for part in (normal, tangential))
        if gap > _LARGEST_GAP * movement or slip > _LARGEST_SLIP * movement:
            raise SettlementBlockedError("the blocks lock before the supports reach their new positions")

    def displaced_joints(self, poses: np.ndarray) -> tuple[np.ndarray, Joints]:
        """Return the indices of the joints that do not separate, and displaced copies of these joints.

        An opened joint is on the bisector of its edges. Raises SettlementBlockedError if a block has
        slid off another block.
        """
        joints = self.joints
        remaining = np.flatnonzero(np.bincount(joints.joint, self.touches))
        first, second = joints.first[remaining], joints.second[remaining]
        rotation = np.zeros((len(remaining), 3))
        rotation[:, 2] = (poses[first, 2] + poses[second, 2]) / 2
        of_first, of_second = joints.first[joints.joint], joints.second[joints.joint]
        point = (placed(joints.point, poses[of_first]) + placed(joints.point, poses[of_second])) / 2
        # If a corner slides along an edge, the contact point moves with the block to which the corner
        # belongs.
        corner = np.where(self.face == of_first, of_second, of_first)
        is_corner = self.slides[joints.joint] & (joints.extent[joints.joint] == 0)
        point[is_corner] = placed(joints.point, poses[corner])[is_corner]
        chosen = np.isin(joints.joint, remaining)
        counts = np.bincount(joints.joint)[remaining]
        number = np.repeat(np.arange(len(remaining)), counts)
        moved = replace(
            joints,
            first=first,
            second=second,
            normal=turned(joints.normal[remaining], rotation),
            tangent=turned(joints.tangent[remaining], rotation),
            accuracy=joints.accuracy[remaining],
            turn=joints.turn[remaining],
            shift=joints.shift[chosen],
            extent=joints.extent[remaining],
            middle=joints.middle[remaining],
            point=point[chosen],
            joint=number,
            ring=number,
        )
        moved = self._slid(moved, remaining, poses)
        middle = (moved.start + moved.end) / 2
        return remaining, replace(moved, middle=middle, extent=lengths(moved.end - moved.start))

    def _slid(self, moved: Joints, remaining: np.ndarray, poses: np.ndarray) -> Joints:
        """Shorten displaced joints to the length over which their blocks still touch after sliding."""
        point = moved.point.copy()
        for number in np.flatnonzero(self.slides[remaining] & (moved.extent > 0)):
            joint = remaining[number]
            start, tangent = self.joints.start[joint], moved.tangent[number]
            ends = []
            for side, block in enumerate((moved.first[number], moved.second[number])):
                origin = placed(start, poses[block]) @ tangent
                ends.append(origin + self._intervals[joint, side])
            low, high = np.max([end[0] for end in ends]), np.min([end[1] for end in ends])
            if high - low <= self.assembly.geometry.tolerance:
                first, second = self.assembly.names(np.array([moved.first[number], moved.second[number]]))
                raise SettlementBlockedError(f"block '{first}' slides off block '{second}'")
            across = moved.point[moved.first_point[number]]
            across = across - (across @ tangent) * tangent
            point[moved.first_point[number]] = across + low * tangent
            point[moved.last_point[number]] = across + high * tangent
        return replace(moved, point=point)

    def crushed_overlaps(self, poses: np.ndarray) -> dict[frozenset[int], float]:
        """Return the depth by which each pair of blocks may overlap, because joints between the blocks crush.

        If several joints between two blocks crush, the depth is that of the joint that crushes most.
        """
        joints, tolerance = self.joints, self.assembly.geometry.contact_tolerance
        depths: dict[frozenset[int], float] = {}
        for number in np.flatnonzero(self.crushed_depth):
            first, second = int(joints.first[number]), int(joints.second[number])
            turn = abs(float(poses[first, 2] - poses[second, 2]))
            depth = float(self.crushed_depth[number] * joints.extent[number]) * turn + tolerance
            pair = frozenset((first, second))
            depths[pair] = max(depth, depths.get(pair, 0.0))
        return depths

    def carrying_depths(self, remaining: np.ndarray) -> np.ndarray:
        """Return the depth over which each joint can carry a force, as a fraction of the joint's length.

        The joints are those with the indices ``remaining``. The depth is 1 for closed joints, and 0 for
        joints that have opened and do not crush. In a joint that crushes, the depth is twice the crushed
        depth, because the crushed depth changes as the forces change.
        """
        joints = self.joints
        closed = self.touches[joints.first_point] & self.touches[joints.last_point]
        depth = np.minimum(2 * self.crushed_depth, 1.0)
        return np.asarray(np.where(closed, 1.0, depth)[remaining])

    def far_ends(self, remaining: np.ndarray) -> np.ndarray:
        """Return a mask of the joints ``remaining``: True if the first end of a joint does not touch.

        The near end of a joint is the end that touches, and its far end is the other one. ``remaining`` are
        the indices of the joints.
        """
        return np.asarray(~self.touches[self.joints.first_point][remaining])


def _stiff_struts(freed: Assembly, rates: np.ndarray, speed: float) -> tuple[LimitedForce, ...]:
    """Return the ties and props whose lengths do not change at given velocities of all blocks."""
    rates = np.vstack([rates, np.zeros(3)])  # the ground has the index −1
    stiff = []
    for force in freed.limited:
        lengthening = 0.0
        for action in force.actions:
            *velocity, turn = rates[action.block]
            across = np.array([-action.point[1], action.point[0]])
            lengthening += float(action.force @ (velocity + turn * across))
        if force.role in (Role.TIE, Role.PROP) and abs(lengthening) <= SEPARATES * abs(speed):
            stiff.append(force)
    return tuple(stiff)


def _crushed(
    freed: Assembly, solution: Solution, gap: np.ndarray, speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the contact points, moved inwards where joints crush, and the crushed depth of each joint.

    A joint that turns crushes over a depth of n / f_c per unit thickness, which carries its normal force n at
    the strength of the joint. The joint neither opens nor crushes at the end of this depth. The returned
    depths are relative to the length of the joint. The contact points are those of the scene at rest. ``gap``
    is the opening rate at each contact point.
    """
    assert solution.q is not None
    joints, problem = freed.joints, freed.problem
    contact, depth = joints.point.copy(), np.zeros(len(joints.first))
    share = np.zeros(problem.joints)
    share[problem.crushing] = problem.normal_forces(solution.q)[problem.crushing] / problem.crushing_force
    ends = np.stack([joints.first_point, joints.last_point])
    for number in freed.joint[problem.crushing]:
        near, far = ends[np.argsort(gap[ends[:, number]]), number]
        if gap[near] < 0 and gap[far] - gap[near] > SEPARATES * speed:
            depth[number] = share[number]
            contact[near] += depth[number] * (joints.point[far] - joints.point[near])
    return contact, depth

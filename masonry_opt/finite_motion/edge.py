"""Equilibrium path in space of one rigid body that rotates about an edge, from collapse to λ = 0."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.optimize import brentq

from masonry_opt.effort import Effort
from masonry_opt.errors import OptionError
from masonry_opt.finite_motion.moved_blocks import least_missed, overlapping
from masonry_opt.finite_motion.path import LARGEST_ADMISSIBLE_VIOLATION, PathProgress, PathState
from masonry_opt.finite_motion.struts import strut_ends
from masonry_opt.problem.displaced import moved, placed, turned
from masonry_opt.problem.limited_forces import Action, LimitedForce, Role
from masonry_opt.problem.loads import Forces, by_component
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.problem import Problem
from masonry_opt.reporting.names import some
from masonry_opt.result import Result
from masonry_opt.scene.rows import lengths
from masonry_opt.solution.motion import fastest, joint_motion, moving_blocks, velocities
from masonry_opt.solution.reasons import Code, Reason, reason

#: Tolerance for recognising a mechanism as a rotation about an edge. Velocities may differ from those of the
#: rotation by this fraction of the largest velocity. Contact points on the edge may be off the axis of
#: rotation by this fraction of the scene's size. With a larger value, less exact rotations are accepted.
_ROTATION_TOLERANCE = 1e-3
#: If λ grows without bound as the rotation approaches an angle φ, the path ends at the angle (1 − p) φ, where
#: p is this value.
_POLE_DISTANCE = 1e-3
#: A joint is reported as opening if its opening rate exceeds this fraction of the largest opening rate of all
#: joints. A joint is reported as sliding if its slip rate exceeds this fraction of the largest slip rate.
_REPORTED_SHARE = 1e-3
#: Number of angles of rotation, from 0 to 90°, at which the moments about the edge are computed. The largest
#: angle of the path, at which the resisting or the driving moment vanishes, is between two of these angles.
_BRACKETING_ANGLES = 2000
#: Small angle (rad) by which the body is rotated to determine whether ties and props lengthen or shorten.
_DIFFERENCE_ANGLE = 1e-6


class EdgePath:
    """Equilibrium path of a mechanism in space: one rigid body rotates about an edge.

    Equilibrium of moments about the edge determines λ at every angle. A linear program verifies for each
    state that admissible contact forces exist. Poses are a translation and a rotation vector of each block,
    shape (blocks, 6). Raises OptionError if joints slide, blocks move on each other, or no edge stays at
    rest.

    Attributes
    ----------
    steps: States of the path; the first is at rest.
    end: Reason why the path ends.
    motion: Rates of the poses of all blocks at the onset of collapse, shape (blocks, 6).
    turns: True for the blocks that rotate; the last entry, for the ground, is False. Shape (blocks + 1,).
    round: True for the joints between the body and the blocks at rest, shape (joints,).
    body: The rotating block of each joint, or the joint's second block if neither rotates, shape (joints,).
    on_edge: True for the contact points on the edge, shape (points,).
    foot: A point on the edge.
    axis: Unit vector along the edge.
    """

    def __init__(
        self, result: Result, forces: tuple[Forces, Forces], count: int, progress: PathProgress
    ) -> None:
        self.progress = progress
        self.assembly, self.forces, self.effort = result.assembly, forces, Effort()
        self.turns = np.zeros(len(self.assembly.scene.blocks) + 1, dtype=bool)
        self._find_edge(result)
        self.motion = self.turns[:-1, None] * np.append(np.cross(self.foot, self.axis), self.axis)
        touch = ~self.round[self.assembly.joints.joint] | self.on_edge
        self.steps = [PathState(0 * self.motion, result.required(), touch)]
        turning = float(np.divide(*self._moments(0.0)))
        if result.assembly.problem.load_factor_scale.equal(turning, result.required()):
            self.end = self._follow(count)
        else:
            upper = result.associative
            self.end = reason(Code.NOT_HINGING, associative=upper, pairs=[], turning=turning)

    def _find_edge(self, result: Result) -> None:
        """Find the blocks that rotate, their joints with blocks at rest, and the edge of rotation."""
        assembly, d = self.assembly, result.solution.d
        problem, joints, corners = assembly.problem, assembly.joints, assembly.geometry.corners
        assert d is not None
        refused = f"{result.case}: in space a capacity curve needs one rigid body that rotates about an edge"
        slides = joint_motion(assembly, result.solution).slides
        if slides.any():
            pairs = assembly.pairs_of(np.flatnonzero(slides))
            sliding = some([f"'{first}'–'{second}'" for first, second in pairs])
            raise OptionError(f"{refused}, but in this mechanism joints slide: {sliding}")
        moving = moving_blocks(assembly, d)
        self.turns[assembly.movable[moving]] = True
        self.round = self.turns[joints.first] != self.turns[joints.second]
        rotation = problem.moments(d)[moving[0]] / problem.length_unit
        rate, size = float(np.linalg.norm(rotation)) or 1.0, float(np.ptp(corners[0], axis=0).max())
        self.body = np.where(self.turns[joints.first], joints.first, joints.second)
        distance = lengths(velocities(assembly, d, self.body[joints.joint], joints.point)) / rate
        self.on_edge = self.round[joints.joint] & (distance <= _ROTATION_TOLERANCE * size)
        on_edge = joints.point[self.on_edge]
        line = on_edge[np.argsort(on_edge @ rotation)][[0, -1]] if len(on_edge) else np.zeros((2, 3))
        self.foot, length = line[0], float(np.linalg.norm(line[1] - line[0]))
        self.axis = (line[1] - line[0]) / (length or 1.0)
        rigid = self.turns[corners[1], None] * np.cross(rate * self.axis, corners[0] - self.foot)
        deviation = lengths(velocities(assembly, d, corners[1], corners[0]) - rigid).max()
        tolerance = _ROTATION_TOLERANCE * fastest(assembly, d)
        if length <= _ROTATION_TOLERANCE * size or deviation > tolerance:
            raise OptionError(
                f"{refused}, but in this mechanism several bodies move, or a body rotates about a point"
            )

    def _poses(self, angle: float) -> np.ndarray:
        """Return the poses of all blocks and of the ground after the body has rotated by ``angle``.

        The shape is (blocks + 1, 6). Only the blocks of the rotating body move: they rotate about the edge.
        The last pose is the pose of the ground, which does not move.
        """
        pose = np.append(np.zeros(3), angle * self.axis)
        pose[:3] = self.foot - turned(self.foot, pose)
        return self.turns[:, None] * pose

    def _loads(self, angle: float) -> list[Forces]:
        """Return the dead and the live forces after the body has rotated by an angle."""
        return [moved(forces, self._poses(angle)[self.assembly.movable]) for forces in self.forces]

    def _struts(self, angle: float) -> list[tuple[LimitedForce, float]]:
        """Return the ties and props, each with its force, after the body has rotated by an angle.

        If the rotation continues, a tie that lengthens and a prop that shortens have their highest force. All
        other ties and props have their lowest force.
        """
        struts = []
        for force in self.assembly.limited:
            turns = (0.0, angle, angle + _DIFFERENCE_ANGLE)
            ends = [strut_ends(force, self._poses(turn)) for turn in turns]
            at_rest, now, ahead = np.diff(ends, axis=1)[:, 0]
            sense = 1.0 if force.role is Role.TIE else -1.0
            strain = sense * (np.linalg.norm(ahead) - np.linalg.norm(at_rest))
            direction = sense * now / np.linalg.norm(now)
            blocks = [action.block for action in force.actions]
            actions = tuple(map(Action, blocks, ends[1], (direction, -direction)))
            struts.append((replace(force, actions=actions), force.highest if strain > 0 else force.lowest))
        return struts

    def _moments(self, angle: float) -> tuple[float, float]:
        """Return the resisting and the driving moment about the edge after the body has rotated by an angle.

        The resisting moment is that of dead loads, ties and props. The driving moment is that of the live
        load for λ = 1. λ is the ratio of both moments.
        """
        turns = self.turns[self.assembly.movable]
        dead, live = (
            float(turns[forces.block] @ np.cross(forces.point - self.foot, forces.force) @ self.axis)
            for forces in self._loads(angle)
        )
        for strut, force in self._struts(angle):
            on_body = [action for action in strut.actions if self.turns[action.block]]
            # A tie or prop exerts a moment on the body only if exactly one of its two ends is attached to the
            # body.
            if len(on_body) == 1:
                dead += force * float(np.cross(on_body[0].point - self.foot, on_body[0].force) @ self.axis)
        return -dead, live

    def _follow(self, count: int) -> Reason:
        """Compute ``count`` states up to the largest angle, and return the reason why the path ends.

        λ vanishes at the largest angle, or grows without bound just beyond it. The path ends earlier if
        blocks meet or no admissible forces exist.
        """
        angles = np.linspace(0.0, np.pi / 2, _BRACKETING_ANGLES)
        after = next((k for k, angle in enumerate(angles) if not min(self._moments(angle)) > 0), 0)
        if after == 0:
            return reason(Code.LOCKS)
        bracket = angles[after - 1], angles[after]
        last = brentq(lambda angle: min(self._moments(angle)), *bracket, xtol=1e-15, rtol=1e-14)
        # If the driving moment (index 1) vanishes before the resisting moment (index 0), λ grows without
        # bound, and the mechanism locks.
        locks = bool(np.argmin(self._moments(last)) == 1)
        if locks:
            last *= 1 - _POLE_DISTANCE
        for angle in np.linspace(0.0, last, count + 1)[1:]:
            load_factor = float(np.divide(*self._moments(angle))) if locks or angle < last else 0.0
            obstacle = self._obstacle(angle, load_factor)
            if obstacle is not None:
                return obstacle
            self.steps.append(replace(self.steps[0], poses=self._poses(angle)[:-1], load_factor=load_factor))
            self.progress(len(self.steps) - 1, load_factor)
        if locks:
            return reason(Code.LOCKS)
        self.steps[-1] = replace(self.steps[-1], event=reason(Code.REACHES_ZERO))
        return reason(Code.REACHES_ZERO)

    def _obstacle(self, angle: float, load_factor: float) -> Reason | None:
        """Return the reason why the path ends before an angle is reached; None if the angle is reached.

        The path ends if blocks overlap, or if no admissible forces exist, so that a joint opens or slides.
        """
        blocks = overlapping(self.assembly.geometry, self._poses(angle)[:-1], self.turns[:-1])
        if blocks:
            return reason(Code.BLOCKS_MEET, blocks=self.assembly.names(np.array(blocks)))
        problem = self._problem(angle)
        optimum = least_missed(problem, load_factor, self.effort)
        if optimum is None:
            return reason(Code.FORCES_UNDECIDED)
        violation, d, _ = optimum
        if violation <= LARGEST_ADMISSIBLE_VIOLATION:
            return None
        slips = problem.slip_speed(d)
        # Compute the opening rates at the contact points, without the opening that associative flow adds to
        # slip.
        opens = problem.rates(d, problem.friction)[problem.table.rocks]
        if slips.max() > opens.max():
            speeds, code = slips, Code.JOINTS_SLIDE
        else:
            speeds, code = opens, Code.JOINT_OPENS
        joints = np.flatnonzero(speeds > _REPORTED_SHARE * speeds.max())
        return reason(code, pairs=self.assembly.pairs(joints))

    def _problem(self, angle: float) -> Problem:
        """Return the equilibrium problem of all blocks after the moving blocks have rotated by an angle.

        At the edge of rotation, friction acts along the contact face of the body, which turns with the body.
        Contact points of the opened joints away from the edge carry no force. Points on the edge have no
        cohesion.
        """
        assembly, joints, rest = self.assembly, self.assembly.joints, self.assembly.problem
        movable, unit, poses = assembly.movable, rest.length_unit, self._poses(angle)
        pose = poses[self.body]
        normal, tangent = turned(joints.normal, pose), turned(joints.tangent, pose)
        point = placed(joints.point, pose[joints.joint])
        displaced_joints = replace(joints, normal=normal, tangent=tangent, point=point)
        centroid = placed(assembly.geometry.centroid, poses[:-1])
        struts = [strut for strut, _ in self._struts(angle)]
        geometry = replace(assembly.geometry, centroid=centroid)
        matrices = Matrices.of(displaced_joints, geometry, movable, unit, struts)
        carries = np.append(np.tile(self.steps[0].touch, 3), np.ones(len(struts)))
        units = rest.force_unit * np.tile(by_component(3, 1.0, unit), len(movable))
        dead, live = (forces.about(centroid[movable]) / units for forces in self._loads(angle))
        cohesion = np.where(self.on_edge[rest.law.sliding], 0.0, rest.law.cohesion)
        matrices = replace(matrices, B=sp.csr_array(matrices.B @ sp.diags_array(carries)))
        return Problem(matrices, replace(rest.law, cohesion=cohesion), dead, live, rest.force_unit)

"""A mechanism in space that turns about an edge: one body, of blocks that stay together, down to λ = 0."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.optimize import brentq

from masonry_opt.answer.motion import fastest, joint_motion, moving_blocks, velocities
from masonry_opt.answer.reasons import Code, Reason, reason
from masonry_opt.answer.thresholds import same
from masonry_opt.effort import Effort
from masonry_opt.errors import OptionError
from masonry_opt.finite_motion.moved_blocks import least_missed, moved, overlapping, placed, turned
from masonry_opt.finite_motion.path import BORNE, Step
from masonry_opt.problem.limited_forces import Action, LimitedForce, Role
from masonry_opt.problem.loads import Forces, by_component
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.problem import Problem
from masonry_opt.result import Result
from masonry_opt.scene.rows import lengths
from masonry_opt.words.names import some

#: Share of the fastest corner's speed, and of the scene's size, up to which a motion is that of one body
#: about an edge, and of the way to an endless λ.
_ALIKE = 1e-3
_LOOKS, _AHEAD = 2000, 1e-6  #: Angles to a quarter turn looked at; a small angle.


class EdgePath:
    """The path in space, attributes as of :class:`~.path.HingingPath`; poses are a shift and a rotation
    vector of each block, shape (blocks, 6). Raises OptionError if joints slide, blocks move on each other, or
    no edge stays."""

    def __init__(self, result: Result, forces: tuple[Forces, Forces], count: int) -> None:
        self.assembly, self.forces, self.effort = result.assembly, forces, Effort()
        self.turns = np.zeros(len(self.assembly.scene.blocks) + 1, dtype=bool)  # the last is the ground
        self._find_edge(result)
        self.motion = self.turns[:-1, None] * np.append(np.cross(self.foot, self.axis), self.axis)
        touch = ~self.round[self.assembly.joints.joint] | self.on_edge
        self.steps = [Step(0 * self.motion, result.required(), touch)]
        turning = float(np.divide(*self._moments(0.0)))
        if same(turning, result.required()):
            self.end = self._follow(count)
        else:
            upper = result.associative
            self.end = reason(Code.NOT_HINGING, associative=upper, pairs=[], turning=turning)

    def _find_edge(self, result: Result) -> None:
        """The blocks that turn, joints round them, of each the one that turns, the edge's points and line."""
        assembly, d = self.assembly, result.solution.d
        problem, joints, corners = assembly.problem, assembly.joints, assembly.geometry.corners
        assert d is not None
        refused = f"{result.case}: in space the capacity curve is of one body that turns about an edge"
        if (slides := joint_motion(assembly, result.solution).slides).any():
            told = some([f"'{one}'–'{other}'" for one, other in assembly.pairs_of(np.flatnonzero(slides))])
            raise OptionError(f"{refused}, and here joints slide: {told}")
        own = moving_blocks(assembly, d)
        self.turns[assembly.movable[own]] = True
        self.round = self.turns[joints.first] != self.turns[joints.second]
        about = problem.moments(d)[own[0]] / problem.length_unit
        rate, size = float(np.linalg.norm(about)) or 1.0, float(np.ptp(corners[0], axis=0).max())
        self.body = np.where(self.turns[joints.first], joints.first, joints.second)
        off = lengths(velocities(assembly, d, self.body[joints.joint], joints.point)) / rate
        self.on_edge = self.round[joints.joint] & (off <= _ALIKE * size)
        on_edge = joints.point[self.on_edge]
        line = on_edge[np.argsort(on_edge @ about)][[0, -1]] if len(on_edge) else np.zeros((2, 3))
        self.foot, length = line[0], float(np.linalg.norm(line[1] - line[0]))
        self.axis = (line[1] - line[0]) / (length or 1.0)
        as_one = self.turns[corners[1], None] * np.cross(rate * self.axis, corners[0] - self.foot)
        apart = lengths(velocities(assembly, d, corners[1], corners[0]) - as_one).max()
        if length <= _ALIKE * size or apart > _ALIKE * fastest(assembly, d):
            raise OptionError(f"{refused}, and here blocks move on each other, or about a point")

    def _poses(self, angle: float) -> np.ndarray:
        """Of all blocks, then of the ground, where the body has turned."""
        pose = np.append(np.zeros(3), angle * self.axis)
        pose[:3] = self.foot - turned(self.foot, pose)
        return self.turns[:, None] * pose

    def _loads(self, angle: float) -> list[Forces]:
        """Dead and live forces where the body has turned."""
        return [moved(of, self._poses(angle)[self.assembly.movable]) for of in self.forces]

    def _struts(self, angle: float) -> list[tuple[LimitedForce, float]]:
        """Ties and props there, and their forces as the body turns on."""
        found = []
        for force in self.assembly.limited:
            blocks = np.array([one.block for one in force.actions])
            at = np.array([one.point for one in force.actions])
            ends = [placed(at, self._poses(turn)[blocks]) for turn in (0.0, angle, angle + _AHEAD)]
            rest, now, ahead = np.diff(ends, axis=1)[:, 0]
            sense = 1.0 if force.role is Role.TIE else -1.0
            longer = sense * (np.linalg.norm(ahead) - np.linalg.norm(rest))
            pull = sense * now / np.linalg.norm(now)
            actions = tuple(map(Action, blocks.tolist(), ends[1], (pull, -pull)))
            found.append((replace(force, actions=actions), force.highest if longer > 0 else force.lowest))
        return found

    def _moments(self, angle: float) -> tuple[float, float]:
        """Moments of dead loads, ties and props against the turn, and of the live load for λ = 1 with it."""
        turns = self.turns[self.assembly.movable]
        dead, live = (
            float(turns[of.block] @ np.cross(of.point - self.foot, of.force) @ self.axis)
            for of in self._loads(angle)
        )
        for strut, force in self._struts(angle):
            own = [one for one in strut.actions if self.turns[one.block]]
            if len(own) == 1:  # else it leads from the body to itself, or past it
                dead += force * float(np.cross(own[0].point - self.foot, own[0].force) @ self.axis)
        return -dead, live

    def _follow(self, count: int) -> Reason:
        """Steps to λ = 0, or to the last before λ is endless, blocks meet or no forces exist; why it ends."""
        angles = np.linspace(0.0, np.pi / 2, _LOOKS)
        after = next((k for k, angle in enumerate(angles) if not min(self._moments(angle)) > 0), 0)
        if after == 0:
            return reason(Code.LOCKS)
        ends = angles[after - 1], angles[after]
        last = brentq(lambda angle: min(self._moments(angle)), *ends, xtol=1e-15, rtol=1e-14)
        if locks := np.argmin(self._moments(last)) == 1:  # the live one: λ grows without end before it
            last *= 1 - _ALIKE
        for angle in np.linspace(0.0, last, count + 1)[1:]:
            load_factor = float(np.divide(*self._moments(angle))) if locks or angle < last else 0.0
            if meet := overlapping(self.assembly.geometry, self._poses(angle)[:-1], self.turns[:-1]):
                return reason(Code.BLOCKS_MEET, blocks=self.assembly.names(np.array(meet)))
            problem = self._problem(angle)
            if (missed := least_missed(problem, load_factor, self.effort)) is None:
                return reason(Code.FORCES_UNDECIDED)
            if missed[0] > BORNE:
                rates, slips = problem.rates(missed[1], problem.friction), problem.slip_speed(missed[1])
                opens = rates[problem.table.rocks]  # beside what slip opens
                slides = slips.max() > opens.max()
                most, code = (slips, Code.JOINTS_SLIDE) if slides else (opens, Code.JOINT_OPENS)
                return reason(code, pairs=self.assembly.pairs(np.flatnonzero(most > _ALIKE * most.max())))
            self.steps.append(replace(self.steps[0], poses=self._poses(angle)[:-1], load_factor=load_factor))
        if locks:
            return reason(Code.LOCKS)
        self.steps[-1] = replace(self.steps[-1], event=reason(Code.REACHES_ZERO))
        return reason(Code.REACHES_ZERO)

    def _problem(self, angle: float) -> Problem:
        """Statics there: friction on the edge is by the body's face, and points off it have no force."""
        assembly, joints, rest = self.assembly, self.assembly.joints, self.assembly.problem
        movable, unit, poses = assembly.movable, rest.length_unit, self._poses(angle)
        pose = poses[self.body]
        normal, tangent = turned(joints.normal, pose), turned(joints.tangent, pose)
        point = placed(joints.point, pose[joints.joint])
        there = replace(joints, normal=normal, tangent=tangent, point=point)
        centroid = placed(assembly.geometry.centroid, poses[:-1])
        struts = [strut for strut, _ in self._struts(angle)]
        matrices = Matrices.of(there, replace(assembly.geometry, centroid=centroid), movable, unit, struts)
        bears = np.append(np.tile(self.steps[0].touch, 3), np.ones(len(struts)))
        units = rest.force_unit * np.tile(by_component(3, 1.0, unit), len(movable))
        dead, live = (of.about(centroid[movable]) / units for of in self._loads(angle))
        cohesion = np.where(self.on_edge[rest.law.sliding], 0.0, rest.law.cohesion)
        matrices = replace(matrices, B=sp.csr_array(matrices.B @ sp.diags_array(bears)))
        return Problem(matrices, replace(rest.law, cohesion=cohesion), dead, live, rest.force_unit)

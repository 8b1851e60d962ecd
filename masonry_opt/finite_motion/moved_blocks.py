"""The blocks of a scene after they have moved: how joints touch, the problem then, what its forces miss."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import shapely

from masonry_opt.answer.thresholds import IDLE, LOWER, SLIDES
from masonry_opt.effort import Effort
from masonry_opt.errors import OptionError
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.laws import Law
from masonry_opt.problem.loads import Forces, LoadedPiece, by_component, loads, moments_in
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.rows import dots, linked
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.highs import HighsSession, LinearProgram
from masonry_opt.solvers.registry import Verdict, find_solver

#: Simpson's rule on an edge, exact for what is cubic there: places along it, and weights.
_PLACES, _WEIGHTS = np.array([0.0, 0.5, 1.0]), np.array([1.0, 4.0, 1.0]) / 6
_STAYS = 1e-6  #: Share of the fastest corner's speed below which a corner of a joint does not open.
_UNLIMITED = 1e9  #: Friction from which on it limits nothing.


def placed(points: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Points at rest, shape (..., 2), where poses (x, y, θ), shape (..., 3), bring them: turned about the
    origin, then shifted. In space points have three coordinates and poses six, with a rotation vector."""
    return turned(points, poses) + poses[..., : points.shape[-1]]


def turned(vectors: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Vectors, shape (..., 2), turned by the angle of poses, shape (..., 3); in space as ``placed``."""
    if vectors.shape[-1] == 3:
        angle = np.linalg.norm(poses[..., 3:], axis=-1, keepdims=True)
        axis = poses[..., 3:] / np.where(angle > 0, angle, 1.0)
        across, along = np.cross(axis, vectors), (axis * vectors).sum(axis=-1, keepdims=True) * axis
        return np.asarray(along + np.cos(angle) * (vectors - along) + np.sin(angle) * across)
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def moved(forces: Forces, poses: np.ndarray) -> Forces:
    """Forces, which stay what they are, on movable blocks with these poses, shape (b, 3), in space (b, 6)."""
    return replace(forces, point=placed(forces.point, poses[forces.block]))


def point_forces(assembly: Assembly) -> tuple[Forces, Forces]:
    """Dead and live forces of a scene. Raises OptionError of loads whose points of action are not known."""
    given = loads(assembly.scene, assembly.geometry, assembly.movable)
    found = _joined(assembly, "dead", given.weight, given.dead), _joined(assembly, "live", given.live)
    problem, centroid = assembly.problem, assembly.geometry.centroid[assembly.movable]
    units = problem.force_unit * by_component(centroid.shape[1], 1.0, problem.length_unit)
    for forces, known in zip(found, (problem.dead, problem.live), strict=True):
        left = problem.by_block(forces.about(centroid)) / units - problem.by_block(known)
        if np.abs(left).max(initial=0.0) > LOWER * max(1.0, np.abs(known).max()):
            follows = "the capacity curve follows weights, forces at points and loads on edges alone"
            others = "the scene has others, whose points of action are not known after the onset"
            left_out = "leave out [[fill]], or " if assembly.scene.fills else ""
            remedy = f"{left_out}find the load factor alone with 'solve'"
            raise OptionError(f"{assembly.scene.called}: {follows}: {others}: {remedy}")
    return found


def _joined(assembly: Assembly, kind: str, *parts: Forces) -> Forces:
    on_edges = [_on_edge(piece, assembly) for piece in assembly.loaded_pieces if piece.kind == kind]
    acting = ((each.block, each.force, each.point) for each in (*parts, *on_edges))
    block, force, point = map(np.concatenate, zip(*acting, strict=True))
    return Forces(block, force, point, np.zeros((len(assembly.movable), moments_in(point.shape[1]))))


def _on_edge(piece: LoadedPiece, assembly: Assembly) -> Forces:
    """Three forces in place of a load on an edge."""
    along, (first, last) = piece.ends[1] - piece.ends[0], piece.intensity
    force = np.hypot(*along) * _WEIGHTS[:, None] * (first + np.outer(_PLACES, last - first))
    block = np.full(3, np.searchsorted(assembly.movable, piece.block))
    return Forces(block, force, piece.ends[0] + np.outer(_PLACES, along), np.zeros(0))


def displaced(shapes: Any, poses: np.ndarray) -> Any:
    """Shapes where poses of all blocks bring them."""
    centroid = placed(shapes.centroid, poses)
    if isinstance(shapes, Geometry):
        corners, block = shapes.corners
        polygons = shapely.set_coordinates(shapes.polygons.copy(), placed(corners, poses[block]))
        return replace(shapes, polygons=polygons, centroid=centroid)
    parts, faces, frame = shapes.parts, shapes.faces, shapes.faces.frame
    blocks = parts.block[parts.of_point], parts.block[parts.of_plane], faces.block
    of_point, of_plane, of_face = (poses[own] for own in blocks)
    normal = turned(parts.normal, of_plane)
    offset = parts.offset + dots(normal, of_plane[:, :3])
    axes = {name: turned(getattr(frame, name), of_face) for name in ("u", "v", "normal")}
    frame = replace(frame, base=placed(frame.base, of_face), **axes)
    parts = replace(parts, points=placed(parts.points, of_point), normal=normal, offset=offset)
    return replace(shapes, parts=parts, faces=replace(faces, frame=frame), centroid=centroid)


def overlapping(shapes: Any, poses: np.ndarray, body: np.ndarray) -> list[int]:
    """The two blocks of different bodies that lie deepest in one another, if any, the higher body's first."""
    there = displaced(shapes, poses)
    low, high = there.boxes
    boxes = shapely.box(*low[:, :2].T, *high[:, :2].T)
    one, other = shapely.STRtree(boxes).query(boxes)
    near = ((low[one] < high[other]) & (low[other] < high[one])).all(axis=1)
    pairs = np.column_stack([one, other])[near & (body[one] > body[other])]
    found = max(there.overlaps(pairs), key=lambda found: found[1].depth, default=None)
    return pairs[found[0]].tolist() if found else []


@dataclass(frozen=True)
class ForceOptimum:
    """An optimum of statics."""

    value: float  #: load factor, or by how much forces miss yield at the least, in the unit of force
    motion: np.ndarray  #: rates of the poses of all blocks that multipliers of equilibrium are, (blocks, 3)
    pressed: np.ndarray  #: joints with any force, shape (joints,)


@dataclass(frozen=True)
class MovedBlocks:
    """The blocks of a scene in the plane, in the problem's unit of length; poses are of all, (blocks, 3)."""

    geometry: Geometry  #: at rest
    joints: Joints
    movable: np.ndarray  #: indices of the movable blocks, shape (b,)
    dead: Forces  #: forces on these
    live: Forces
    cohesion: np.ndarray  #: of each joint, as a force while it is closed, shape (joints,)

    @classmethod
    def of(cls, assembly: Assembly, forces: tuple[Forces, Forces], unit: float, live: float) -> "MovedBlocks":
        """The blocks of an assembly, with dead and live forces in such a unit, and λ in units of ``live``."""
        problem, at_rest, geometry = assembly.problem, assembly.joints, assembly.geometry
        length = problem.length_unit
        joints = replace(at_rest, point=at_rest.point / length, extent=at_rest.extent / length)
        sizes = {of: getattr(geometry, of) / length for of in ("tolerance", "contact_tolerance", "centroid")}
        polygons = shapely.transform(geometry.polygons, lambda corners: corners / length)
        shapes = replace(geometry, polygons=polygons, **sizes)
        cohesion = np.zeros(problem.joints)
        cohesion[problem.sliding] = problem.cohesion / unit
        dead, pushing = (
            replace(each, force=each.force * scale, point=each.point / length)
            for each, scale in zip(forces, np.array([1.0, live]) / (unit * problem.force_unit), strict=True)
        )
        return cls(shapes, joints, assembly.movable, dead, pushing, cohesion)

    @property
    def blocks(self) -> np.ndarray:
        """The two blocks of each joint, shape (joints, 2)."""
        return np.stack([self.joints.first, self.joints.second], axis=1)

    @property
    def corner(self) -> np.ndarray:
        """Start and end of each joint at rest, which both blocks keep, shape (joints, 2, 2)."""
        return np.stack([self.joints.start, self.joints.end], axis=1)

    @property
    def at_rest(self) -> np.ndarray:
        """Which corners of the joints touch at rest, shape (joints, 2): of a corner on an edge the first."""
        return np.stack([np.ones_like(self.joints.extent, dtype=bool), self.joints.extent > 0], axis=1)

    @cached_property
    def faces(self) -> np.ndarray:
        """Which blocks' edges corners touch, both where two meet: (joints, 2, 2), joint, corner, block."""
        points, block = self.geometry.corners
        corners = shapely.multipoints(points, indices=block)[self.blocks]
        away = shapely.distance(shapely.points(self.corner)[..., None], corners[:, None])
        own = away <= 2 * self.geometry.tolerance
        return own[..., ::-1] | ~own  # a corner of the second block alone touches the first one's edge

    def problem(self, touch: np.ndarray, poses: np.ndarray) -> Problem:
        """The problem of the joints of which any corner touches, shape (joints, 2). Closed joints are as at
        rest. A corner that touches alone has no cohesion, and the edge that it touches is the joint's; where
        two corners meet their bisector is, and friction that of the forces which both edges bear."""
        kept = np.flatnonzero(touch.any(axis=1))
        touch, blocks, at_rest = touch[kept], self.blocks[kept], self.joints
        closed, corner = np.logical_and(*touch.T), touch.argmax(axis=1)
        edges = np.where(closed[:, None], [True, False], self.faces[kept, corner])
        angle = poses[blocks, 2]
        turn = np.zeros((len(kept), 3))
        turn[:, 2] = (angle * edges).sum(axis=1) / edges.sum(axis=1)
        lean = np.where(edges.all(axis=1), np.abs(angle[:, 0] - angle[:, 1]) / 2, 0.0)
        friction = np.tan(np.arctan(at_rest.friction[kept]) - lean)
        pressed = np.column_stack([corner, np.where(closed, 1, corner)])
        place = placed(self.corner[kept[:, None], pressed], poses[blocks[:, :1]])
        number = np.repeat(np.arange(len(kept)), 2)
        normal, tangent = (turned(axis[kept], turn) for axis in (at_rest.normal, at_rest.tangent))
        extent = np.where(closed, at_rest.extent[kept], 0.0)
        joints = replace(at_rest, first=blocks[:, 0], second=blocks[:, 1], normal=normal, tangent=tangent)
        joints = replace(joints, extent=extent, point=place.reshape(-1, 2), joint=number, ring=number)
        sliding = np.flatnonzero(friction < _UNLIMITED)
        slope, cohesion, none = friction[sliding], np.where(closed, self.cohesion[kept], 0.0), np.zeros(0)
        law = Law(sliding, slope, cohesion[sliding], slope, np.full((len(slope), 2), np.inf), none, none)
        centroid = placed(self.geometry.centroid, poses)
        acting = (moved(each, poses[self.movable]) for each in (self.dead, self.live))
        dead, live = (each.about(centroid[self.movable]) for each in acting)
        shapes = replace(self.geometry, centroid=centroid)
        return Problem(Matrices.of(joints, shapes, self.movable, 1.0), law, dead, live, 1.0)

    def optimum(
        self, touch: np.ndarray, poses: np.ndarray, load_factor: float | None, effort: Effort
    ) -> ForceOptimum | None:
        """The greatest load factor, eq. (9), or how much forces under a given one miss at least, if found."""
        problem = self.problem(touch, poses)
        if load_factor is None:
            solver = find_solver("cvxpy", "highs")
            state = Driver(problem, "static", solver, effort, of_load=True).solve().state
            found = None if state is None else (state.load_factor, state.d, state.q)
        else:
            found = least_missed(problem, load_factor, effort)
        if found is None:
            return None
        value, d, q = found
        size, pressed = np.abs(problem.by_kind(q)).max(axis=0), np.zeros(len(touch), dtype=bool)
        pressed[touch.any(axis=1)] = size > IDLE * size.max(initial=0.0)
        # From velocities of centroids to those of the points in the origin.
        motion, (x, y) = np.zeros_like(poses), turned(self.geometry.centroid, poses).T
        motion[self.movable] = problem.by_block(d)
        motion[:, :2] += motion[:, 2:] * np.column_stack([y, -x])
        return ForceOptimum(value, motion, pressed)

    def bodies(self, touch: np.ndarray) -> np.ndarray:
        """Number of each block's rigid body, shape (blocks,), by closed joints; the last is the ground's."""
        fixed = np.setdiff1d(np.arange(len(self.geometry.size)), self.movable)
        closed = self.blocks[touch.all(axis=1)]
        links = np.concatenate([closed, np.column_stack([fixed[1:], fixed[:-1]])])
        body = linked(len(self.geometry.size), *links.T)
        return np.asarray((body - body[fixed[0]] - 1) % (body.max() + 1))

    def _velocities(self, poses: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """Velocities of the joints' corners with first and second blocks, shape (2, joints, 2, 2)."""
        blocks = self.blocks.T[..., None]
        arm = turned(self.corner, poses[blocks])
        quarter = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
        return motion[blocks][..., :2] + motion[blocks][..., 2:] * quarter

    def fastest(self, poses: np.ndarray, motion: np.ndarray) -> float:
        """Speed of the fastest corner of a joint."""
        return float(np.linalg.norm(self._velocities(poses, motion), axis=-1).max(initial=0.0))

    def _fastest_of_blocks(self, poses: np.ndarray, motion: np.ndarray) -> float:
        """Return the speed of the fastest corner of a block."""
        points, block = self.geometry.corners
        arm = turned(points, poses[block])
        velocity = motion[block, :2] + motion[block, 2:] * np.column_stack([-arm[:, 1], arm[:, 0]])
        return float(np.linalg.norm(velocity, axis=1).max(initial=0.0))

    def relative(self, poses: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """Rates at which the joints' corners open, and slip, shape (2, joints, 2)."""
        first, second = self._velocities(poses, motion)
        along = np.stack([self.joints.normal, self.joints.tangent])[:, :, None]
        frame = turned(along, poses[self.joints.first][:, None])
        return np.asarray(((first - second) * frame).sum(axis=-1))

    def after(
        self, touch: np.ndarray, poses: np.ndarray, found: ForceOptimum
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners that still touch in the motion of an optimum, and the joints that slide in it,
        shapes (joints, 2) and (joints,).

        A joint slides if it slips by more than the share ``SLIDES`` of the speed of the fastest corner, as in
        :func:`~masonry_opt.answer.motion.joint_motion`, and carries a force or does not open. A corner that
        slips less, as on surveyed blocks, goes on touching unless it opens by more than its slip explains.
        """
        opening, slip = self.relative(poses, found.motion)
        speed = self._fastest_of_blocks(poses, found.motion) or 1.0
        friction = np.where(np.isfinite(self.joints.friction), self.joints.friction, 0.0)
        opens = opening > _STAYS * speed
        lifts = opening - friction[:, None] * np.abs(slip) > _STAYS * speed
        slips = touch & (np.abs(slip) > SLIDES * speed)
        stays = touch & ~lifts & ~slips
        slides = (slips & ~opens).any(axis=1) | (slips.any(axis=1) & ~stays.any(axis=1) & found.pressed)
        return stays, slides


def least_missed(
    problem: Problem, load_factor: float, effort: Effort
) -> tuple[float, np.ndarray, np.ndarray] | None:
    """By how much forces miss equilibrium and yield at the least, the motion that gains by it, and they.

        min  v    s.t.    −v ≤ B q + λ f_L + f_D ≤ v,    z + v = C q + c + v ≥ 0

    Hinges leave the forces of a given λ no room: without v rounding would make the program infeasible.
    """
    load = problem.dead + load_factor * problem.live
    rows, faces = len(load), problem.faces
    column = np.repeat([1.0, -1.0, 1.0], [rows, rows, faces])
    # Slacks of rocking are so many times the normal force that is missed.
    column[2 * rows :][problem.table.rocks] = problem.layout.points
    conditions = sp.vstack([problem.B, problem.B, problem.true_yield])
    matrix = sp.hstack([conditions, sp.csr_array(column[:, None])], format="csc")
    cost = np.zeros(matrix.shape[1])
    cost[-1] = 1.0
    row_lower = np.concatenate([-load, np.full(rows, -np.inf), -problem.face_cohesion])
    row_upper = np.concatenate([np.full(rows, np.inf), -load, np.full(faces, np.inf)])
    low, high = np.where(cost > 0, 0.0, -np.inf), np.full(len(cost), np.inf)
    program = LinearProgram(cost, matrix, row_lower, row_upper, low, high)
    for presolve in ("choose", "off"):  # of what presolve leaves HiGHS' simplex may end in an error
        session = HighsSession(program, effort, "finite motion", small_matrix_value=1e-12, presolve=presolve)
        if session.solve() is Verdict.OPTIMAL:
            *q, value = session.point()
            below, above = session.multipliers()[: 2 * rows].reshape(2, rows)
            return float(value), -(below + above), np.array(q)
    return None

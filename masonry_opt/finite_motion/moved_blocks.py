"""Compute the contacts and the equilibrium of displaced blocks, or the least violation of equilibrium."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import shapely

from masonry_opt.effort import Effort
from masonry_opt.errors import OptionError
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.displaced import displaced, moved, placed, turned
from masonry_opt.problem.laws import Law
from masonry_opt.problem.load_factor_scale import RELATIVE_ROUNDING
from masonry_opt.problem.loads import Forces, LoadedPiece, by_component, moments_in
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.problem import Problem
from masonry_opt.result import Result
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.rows import linked
from masonry_opt.solution.thresholds import NEGLIGIBLE_SHARE, SLIDES
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.highs import SMALLEST_COEFFICIENT, HighsSession, LinearProgram
from masonry_opt.solvers.registry import Verdict, find_solver

#: An error is raised if one of two ratios is at most this value:
#:
#: - The resultant of the live loads, divided by the sum of their magnitudes. The direction of the control
#:   displacement would be undefined.
#: - The rate of the control point along the live load, divided by the largest rate of a loaded point. The
#:   control point would hardly move.
LEAST_RATE = 1e-6
#: Points of Simpson's rule on an edge, as fractions of its length. The rule integrates cubic functions
#: exactly.
_SIMPSON_POINTS = np.array([0.0, 0.5, 1.0])
#: Weights of Simpson's rule.
_SIMPSON_WEIGHTS = np.array([1.0, 4.0, 1.0]) / 6
#: Opening rate above which a corner of a joint counts as opening, relative to the speed of the fastest
#: corner.
_OPENING_TOLERANCE = 1e-6
#: A joint whose friction coefficient exceeds this value counts as unable to slide.
_UNLIMITED_FRICTION = 1e9
#: Options of HiGHS, in the order in which they are tried. The last attempt uses the primal simplex method,
#: because the dual simplex method may fail if joints are nearly parallel.
_ATTEMPTS: tuple[dict[str, Any], ...] = (
    {"presolve": "choose"},
    {"presolve": "off"},
    {"presolve": "off", "simplex_strategy": 4},
)


def point_forces(assembly: Assembly) -> tuple[Forces, Forces]:
    """Return the dead and the live forces of a scene with their points of action.

    Raises OptionError if these forces do not add up to the loads of the problem. The points of action of some
    loads, such as the pressure of fill, are not known after the onset of collapse.
    """
    parts = assembly.block_loads
    dead = _joined(assembly, "dead", parts.weight, parts.dead)
    live = _joined(assembly, "live", parts.live)
    problem, centroid = assembly.problem, assembly.geometry.centroid[assembly.movable]
    units = problem.force_unit * by_component(centroid.shape[1], 1.0, problem.length_unit)
    for forces, load in ((dead, problem.dead), (live, problem.live)):
        difference = problem.by_block(forces.about(centroid)) / units - problem.by_block(load)
        if np.abs(difference).max(initial=0.0) > RELATIVE_ROUNDING * max(1.0, np.abs(load).max()):
            follows = "a capacity curve can be computed only for weights, forces at points and loads on edges"
            cause = "the scene has other loads, whose points of action on displaced blocks are unknown"
            left_out = "omit [[fill]], or " if assembly.scene.fills else ""
            remedy = f"{left_out}use 'solve' to compute only the load factor"
            raise OptionError(f"{assembly.scene.called}: {follows}: {cause}: {remedy}")
    return dead, live


def _joined(assembly: Assembly, kind: str, *parts: Forces) -> Forces:
    """Return one set of forces: the forces in ``parts``, and all edge loads of a kind, "dead" or "live"."""
    on_edges = [_on_edge(piece, assembly) for piece in assembly.loaded_pieces if piece.kind == kind]
    forces = [*parts, *on_edges]
    block = np.concatenate([part.block for part in forces])
    force = np.concatenate([part.force for part in forces])
    point = np.concatenate([part.point for part in forces])
    return Forces(block, force, point, np.zeros((len(assembly.movable), moments_in(point.shape[1]))))


def _on_edge(piece: LoadedPiece, assembly: Assembly) -> Forces:
    """Return three point forces that replace an edge load of linear intensity, by Simpson's rule."""
    edge, (first, last) = piece.ends[1] - piece.ends[0], piece.intensity
    intensity = first + np.outer(_SIMPSON_POINTS, last - first)
    force = np.hypot(*edge) * _SIMPSON_WEIGHTS[:, None] * intensity
    block = np.full(3, np.searchsorted(assembly.movable, piece.block))
    return Forces(block, force, piece.ends[0] + np.outer(_SIMPSON_POINTS, edge), np.zeros(0))


def overlapping(
    shapes: Any,
    poses: np.ndarray,
    body: np.ndarray,
    allowed: Mapping[frozenset[int], float] | None = None,
) -> list[int]:
    """Return the indices of the two blocks that overlap most; an empty list if no blocks overlap.

    The block of the body with the higher number comes first.

    Parameters
    ----------
    shapes: Shapes of the blocks at rest.
    poses: Poses of all blocks.
    body: Number of the rigid body of each block; only blocks of different bodies count.
    allowed: Depth up to which two blocks may overlap because their joint crushes.
    """
    allowed = allowed or {}
    moved_shapes = displaced(shapes, poses)
    low, high = moved_shapes.boxes
    boxes = shapely.box(*low[:, :2].T, *high[:, :2].T)
    first, second = shapely.STRtree(boxes).query(boxes)
    near = ((low[first] < high[second]) & (low[second] < high[first])).all(axis=1)
    pairs = np.column_stack([first, second])[near & (body[first] > body[second])]
    overlaps = (
        (number, common)
        for number, common in moved_shapes.overlaps(pairs)
        if common.depth > allowed.get(frozenset(pairs[number].tolist()), 0.0)
    )
    deepest = max(overlaps, key=lambda overlap: overlap[1].depth, default=None)
    return pairs[deepest[0]].tolist() if deepest else []


@dataclass(frozen=True)
class ForceOptimum:
    """Optimum of a linear program for the contact forces of displaced blocks."""

    #: Largest load factor if the program maximises λ. If λ is fixed: smallest violation of equilibrium and
    #: yield, in the unit of force.
    value: float
    #: Rates of the poses of all blocks, shape (blocks, 3): the dual variables of the equilibrium equations.
    motion: np.ndarray
    pressed: np.ndarray  #: True for joints that carry a force, shape (joints,)


@dataclass(frozen=True)
class MovedBlocks:
    """Plane scene at rest, with methods that compute the equilibrium of its displaced blocks.

    Lengths are in the problem's unit of length. Arguments of the methods are the poses of all blocks, shape
    (blocks, 3), and a mask ``touch`` of the joints' corners that touch, shape (joints, 2).
    """

    geometry: Geometry  #: shapes of the blocks at rest
    joints: Joints
    movable: np.ndarray  #: indices of the movable blocks, shape (b,)
    dead: Forces  #: dead forces on the movable blocks
    live: Forces  #: live forces on the movable blocks
    cohesion: np.ndarray  #: cohesive force of each joint while it is closed, shape (joints,)

    @classmethod
    def of(cls, assembly: Assembly, forces: tuple[Forces, Forces], unit: float, live: float) -> "MovedBlocks":
        """Create the ``MovedBlocks`` of an assembly; ``forces`` are its dead and its live forces.

        All forces are divided by ``unit``, and load factors by ``live``.
        """
        problem, at_rest, geometry = assembly.problem, assembly.joints, assembly.geometry
        length = problem.length_unit
        joints = replace(at_rest, point=at_rest.point / length, extent=at_rest.extent / length)
        lengths = ("tolerance", "contact_tolerance", "centroid")
        sizes = {name: getattr(geometry, name) / length for name in lengths}
        polygons = shapely.transform(geometry.polygons, lambda corners: corners / length)
        shapes = replace(geometry, polygons=polygons, **sizes)
        cohesion = np.zeros(problem.joints)
        cohesion[problem.sliding] = problem.cohesion / unit
        dead, pushing = (
            replace(part, force=part.force * scale, point=part.point / length)
            for part, scale in zip(forces, np.array([1.0, live]) / (unit * problem.force_unit), strict=True)
        )
        return cls(shapes, joints, assembly.movable, dead, pushing, cohesion)

    @property
    def blocks(self) -> np.ndarray:
        """Indices of the two blocks of each joint, shape (joints, 2)."""
        return np.stack([self.joints.first, self.joints.second], axis=1)

    @property
    def corner(self) -> np.ndarray:
        """Start and end of each joint before the blocks move, shape (joints, 2 corners, 2 coordinates)."""
        return np.stack([self.joints.start, self.joints.end], axis=1)

    @property
    def at_rest(self) -> np.ndarray:
        """For each of a joint's two corners, True if the corner is in contact at rest, shape (joints, 2).

        The corners are the start and the end of a joint. A joint without length has only one corner.
        """
        return np.stack([np.ones_like(self.joints.extent, dtype=bool), self.joints.extent > 0], axis=1)

    @cached_property
    def faces(self) -> np.ndarray:
        """For each corner of a joint and each of its blocks, True if the corner is on an edge of the block.

        The shape is (joints, 2 corners, 2 blocks).

        Usually the corner of one block touches the edge of the other block. If corners of both blocks
        coincide, both blocks count as touched on an edge.
        """
        points, block = self.geometry.corners
        corners = shapely.multipoints(points, indices=block)[self.blocks]
        distance = shapely.distance(shapely.points(self.corner)[..., None], corners[:, None])
        is_corner_of = distance <= 2 * self.geometry.tolerance
        return is_corner_of[..., ::-1] | ~is_corner_of

    def problem(self, touch: np.ndarray, poses: np.ndarray) -> Problem:
        """Return the equilibrium problem of displaced blocks.

        The problem contains the joints that touch at one or both corners.

        - A closed joint has the properties that it has at rest.
        - A joint that touches at one corner has no cohesion. Its direction is that of the touched edge.
        - If two corners meet, the direction of the joint is the bisector of both edges. The friction angle is
          reduced by half of the angle between the edges, so that the forces are admissible on both edges.
        """
        touching = np.flatnonzero(touch.any(axis=1))
        touch, blocks, at_rest = touch[touching], self.blocks[touching], self.joints
        closed, corner = np.logical_and(*touch.T), touch.argmax(axis=1)
        edges = np.where(closed[:, None], [True, False], self.faces[touching, corner])
        angle = poses[blocks, 2]
        rotation = np.zeros((len(touching), 3))
        rotation[:, 2] = (angle * edges).sum(axis=1) / edges.sum(axis=1)
        half_angle = np.where(edges.all(axis=1), np.abs(angle[:, 0] - angle[:, 1]) / 2, 0.0)
        friction = np.tan(np.arctan(at_rest.friction[touching]) - half_angle)
        pressed = np.column_stack([corner, np.where(closed, 1, corner)])
        point = placed(self.corner[touching[:, None], pressed], poses[blocks[:, :1]])
        number = np.repeat(np.arange(len(touching)), 2)
        normal = turned(at_rest.normal[touching], rotation)
        tangent = turned(at_rest.tangent[touching], rotation)
        extent = np.where(closed, at_rest.extent[touching], 0.0)
        joints = replace(at_rest, first=blocks[:, 0], second=blocks[:, 1], normal=normal, tangent=tangent)
        joints = replace(joints, extent=extent, point=point.reshape(-1, 2), joint=number, ring=number)
        sliding = np.flatnonzero(friction < _UNLIMITED_FRICTION)
        slope, cohesion = friction[sliding], np.where(closed, self.cohesion[touching], 0.0)
        none = np.zeros(0)
        law = Law(sliding, slope, cohesion[sliding], slope, np.full((len(slope), 2), np.inf), none, none)
        centroid = placed(self.geometry.centroid, poses)
        dead = moved(self.dead, poses[self.movable]).about(centroid[self.movable])
        live = moved(self.live, poses[self.movable]).about(centroid[self.movable])
        shapes = replace(self.geometry, centroid=centroid)
        return Problem(Matrices.of(joints, shapes, self.movable, 1.0), law, dead, live, 1.0)

    def optimum(
        self, touch: np.ndarray, poses: np.ndarray, load_factor: float | None, effort: Effort
    ) -> ForceOptimum | None:
        """Maximise λ or, at a fixed λ, minimise the violation of equilibrium and yield; return the optimum.

        If ``load_factor`` is None, the load factor is maximised, eq. (9). Otherwise the violation of
        equilibrium and yield at this load factor is minimised. The result is None if the solver fails.
        """
        problem = self.problem(touch, poses)
        if load_factor is None:
            solver = find_solver("cvxpy", "highs")
            state = Driver(problem, "static", solver, effort, of_load=True).solve().state
            solution = None if state is None else (state.load_factor, state.d, state.q)
        else:
            solution = least_missed(problem, load_factor, effort)
        if solution is None:
            return None
        value, d, q = solution
        pressed = np.zeros(len(touch), dtype=bool)
        pressed[touch.any(axis=1)] = _pressed(problem, q)
        return ForceOptimum(value, self._motion(problem, d, poses), pressed)

    def state_of(self, result: Result) -> ForceOptimum:
        """Return the load factor, mechanism and compressed joints of a result, before any displacement."""
        problem, solution = result.assembly.problem, result.solution
        assert solution.d is not None
        assert solution.q is not None
        motion = self._motion(problem, solution.d, np.zeros((len(self.geometry.size), 3)))
        return ForceOptimum(result.required(), motion, _pressed(problem, solution.q))

    def _motion(self, problem: Problem, d: np.ndarray, poses: np.ndarray) -> np.ndarray:
        """Convert velocities d, shape (3b,), to rates of the poses of all blocks, shape (blocks, 3)."""
        motion, (x, y) = np.zeros_like(poses), turned(self.geometry.centroid, poses).T
        motion[self.movable] = problem.by_block(d)
        # Convert velocities of the centroids to velocities at the origin, about which poses rotate.
        motion[:, :2] += motion[:, 2:] * np.column_stack([y, -x])
        return motion

    def bodies(self, touch: np.ndarray) -> np.ndarray:
        """Return the index of the rigid body to which each block belongs, shape (blocks,).

        The ground is the last body.

        Blocks that closed joints connect form one body. All fixed blocks form one body, the ground. At least
        one block must be fixed. A plane scene without fixed blocks hangs on ties, which capacity curves in
        the plane do not support.
        """
        fixed = np.setdiff1d(np.arange(len(self.geometry.size)), self.movable)
        assert len(fixed), "a capacity curve in the plane needs at least one fixed block"
        closed = self.blocks[touch.all(axis=1)]
        links = np.concatenate([closed, np.column_stack([fixed[1:], fixed[:-1]])])
        body = linked(len(self.geometry.size), *links.T)
        return np.asarray((body - body[fixed[0]] - 1) % (body.max() + 1))

    def _velocities(self, poses: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """Return two velocities of each joint corner: as a point of the first block and of the second block.

        The shape is (2 blocks, joints, 2 corners, 2 components).
        """
        blocks = self.blocks.T[..., None]
        arm = turned(self.corner, poses[blocks])
        rotated_arm = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
        return motion[blocks][..., :2] + motion[blocks][..., 2:] * rotated_arm

    def fastest(self, poses: np.ndarray, motion: np.ndarray) -> float:
        """Return the speed of the fastest corner of all joints."""
        return float(np.linalg.norm(self._velocities(poses, motion), axis=-1).max(initial=0.0))

    def _fastest_of_blocks(self, poses: np.ndarray, motion: np.ndarray) -> float:
        """Return the speed of the fastest corner of all blocks."""
        points, block = self.geometry.corners
        arm = turned(points, poses[block])
        velocity = motion[block, :2] + motion[block, 2:] * np.column_stack([-arm[:, 1], arm[:, 0]])
        return float(np.linalg.norm(velocity, axis=1).max(initial=0.0))

    def relative(self, poses: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """Return the relative motion at joint corners: opening rates and slip rates, shape (2, joints, 2)."""
        first, second = self._velocities(poses, motion)
        along = np.stack([self.joints.normal, self.joints.tangent])[:, :, None]
        frame = turned(along, poses[self.joints.first][:, None])
        return np.asarray(((first - second) * frame).sum(axis=-1))

    def after(
        self, touch: np.ndarray, poses: np.ndarray, optimum: ForceOptimum
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return masks of the corners that stay in contact after a motion, and of the joints that slide.

        The motion is that of ``optimum``. The shapes of the masks are (joints, 2) and (joints,).

        - A joint slides if its slip exceeds the share ``SLIDES`` of the speed of the fastest corner, as in
          :func:`~masonry_opt.solution.motion.joint_motion`. It must also carry a force, or not open.
        - A corner with a smaller slip, as on surveyed blocks, stays in contact unless it opens by more than
          friction times its slip.
        - A joint that slips without force separates, because no friction resists its motion.
        """
        opening, slip = self.relative(poses, optimum.motion)
        speed = self._fastest_of_blocks(poses, optimum.motion) or 1.0
        friction = np.where(np.isfinite(self.joints.friction), self.joints.friction, 0.0)
        opens = opening > _OPENING_TOLERANCE * speed
        lifts = opening - friction[:, None] * np.abs(slip) > _OPENING_TOLERANCE * speed
        slips = touch & (np.abs(slip) > SLIDES * speed)
        stays = touch & ~lifts & ~slips
        slides = (slips & ~opens).any(axis=1) | (slips.any(axis=1) & ~stays.any(axis=1) & optimum.pressed)
        is_free = slips.any(axis=1) & ~optimum.pressed
        return stays & ~is_free[:, None], slides & ~is_free

    def slip_share(self, touch: np.ndarray, poses: np.ndarray, motion: np.ndarray) -> float:
        """Return the largest slip rate at a corner in contact, divided by the speed of the fastest corner."""
        _, slip = self.relative(poses, motion)
        speed = self._fastest_of_blocks(poses, motion) or 1.0
        return float(np.abs(slip[touch]).max(initial=0.0)) / speed


def _pressed(problem: Problem, q: np.ndarray) -> np.ndarray:
    """Return a mask of the joints that carry a force, shape (joints,)."""
    size = np.abs(problem.by_kind(q)).max(axis=0)
    return np.asarray(size > NEGLIGIBLE_SHARE * size.max(initial=0.0))


def least_missed(
    problem: Problem, load_factor: float, effort: Effort
) -> tuple[float, np.ndarray, np.ndarray] | None:
    """Minimise the violation v of equilibrium and yield at a given load factor λ.

        min  v    s.t.    −v ≤ B q + λ f_L + f_D ≤ v,    z + v = C q + c + v ≥ 0

    The violation v is a variable, because the forces of a mechanism are completely determined at a given λ. A
    program without v would be infeasible due to rounding errors. In rocking conditions, v is multiplied by
    the number of contact points of a joint, so that it measures the missing normal force of the joint.

    Returns
    -------
    tuple or None
        The violation v, the dual motion d and the forces q; None if the solver fails.
    """
    load = problem.dead + load_factor * problem.live
    rows, faces = len(load), problem.faces
    column = np.repeat([1.0, -1.0, 1.0], [rows, rows, faces])
    column[2 * rows :][problem.table.rocks] = problem.layout.points
    conditions = sp.vstack([problem.B, problem.B, problem.true_yield])
    matrix = sp.hstack([conditions, sp.csr_array(column[:, None])], format="csc")
    cost = np.zeros(matrix.shape[1])
    cost[-1] = 1.0
    row_lower = np.concatenate([-load, np.full(rows, -np.inf), -problem.face_cohesion])
    row_upper = np.concatenate([np.full(rows, np.inf), -load, np.full(faces, np.inf)])
    low, high = np.where(cost > 0, 0.0, -np.inf), np.full(len(cost), np.inf)
    program = LinearProgram(cost, matrix, row_lower, row_upper, low, high)
    for attempt in _ATTEMPTS:
        session = HighsSession(
            program, effort, "finite motion", small_matrix_value=SMALLEST_COEFFICIENT, **attempt
        )
        if session.solve() is Verdict.OPTIMAL:
            *q, value = session.point()
            below, above = session.multipliers()[: 2 * rows].reshape(2, rows)
            return float(value), -(below + above), np.array(q)
    return None

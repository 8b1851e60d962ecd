"""Safety margins of a stable scene without live load, and the positions of resultants in its joints."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.rank import has_independent_columns
from masonry_opt.solution.thresholds import NEGLIGIBLE_SHARE

#: The function ``worst_joint`` ignores a joint if its normal force is below this fraction of the lighter
#: block's dead load. With a smaller value, the worst joint may be almost without force.
_PRESSED_SHARE = 0.01


@dataclass(frozen=True)
class WorstJoint:
    """Joint whose resultant is nearest to an edge of the joint, relative to the joint's size.

    Attributes
    ----------
    first, second: names of the two blocks.
    distance: distance of the resultant from the nearest edge of the joint, in the scene's unit of length.
    margin: 0 if the resultant acts at the edge of the joint, 1 if it acts at the middle. In the plane it is
        the distance from the nearer end, divided by half the length of the joint.
    """

    first: str
    second: str
    distance: float
    margin: float


@dataclass(frozen=True, kw_only=True)
class Stability:
    """Safety margins of friction and of geometry, for a scene that is stable under its dead load alone.

    Attributes
    ----------
    unique: True if equilibrium alone fixes the resultants of all joints. Otherwise the joint forces are one
        of many solutions.
    equilibrium: largest unbalanced force or moment on a block, divided by the total dead load.
    yield_: largest violation of a yield condition by the joint forces, in median block weights.
    least_friction_factor: smallest factor by which all friction coefficients can be multiplied so that forces
        still carry the dead load. None if no joint can slide, or if the factor was not computed because the
        scene is large.
    least_friction: smallest friction coefficient with which forces still carry the dead load, if all joints
        that can slide have the same coefficient; otherwise None.
    geometric_margin: largest fraction by which all joints can shrink towards their middles while forces still
        carry the dead load. With a margin of 0.4 all resultants fit into the middle 60 % of the joints. None
        if joints have a limited strength, or if the margin was not computed because the scene is large.
    worst_joint: joint whose resultant is nearest to its edge under the joint forces of this result. Joints
        are left out if their normal force is below 1 % of the dead load of the lighter block. None if no
        joint with an area (in the plane, a length) is pressed.
    """

    unique: bool
    equilibrium: float
    yield_: float
    least_friction_factor: float | None
    least_friction: float | None
    geometric_margin: float | None
    worst_joint: WorstJoint | None

    def as_dict(self) -> dict[str, Any]:
        """Return all attributes as plain values, under their names in JSON output."""
        return {name.rstrip("_"): value for name, value in asdict(self).items()}


def are_resultants_unique(assembly: Assembly) -> bool:
    """Return True if equilibrium alone provably determines the resultants of all joints.

    Resultants are unique if the joint forces are unique. They are also unique if joints and limited forces
    connect the blocks without closed loops, because each connection then carries all loads on one of its
    sides.
    """
    scene, joints = assembly.scene, assembly.joints
    B = assembly.problem.B
    if scene.dimension == 2:
        # If a corner touches an edge, both contact points of the joint coincide, so only the sum of their
        # forces matters.
        is_second = np.zeros(B.shape[1], dtype=bool)
        count = len(joints.first)
        is_second[count : 2 * count] = joints.extent == 0
        B = B[:, ~is_second]
    if has_independent_columns(B):
        return True
    # The ground and all fixed blocks form one node of the graph, the last one.
    ground = len(scene.blocks)
    node = np.append(np.where(scene.fixed, ground, np.arange(ground)), ground)
    first, second = joints.first, joints.second
    ends = [[action.block for action in force.actions] for force in assembly.limited]
    if any(len(blocks) > 2 for blocks in ends):
        return False
    first = node[np.append(first, [blocks[0] for blocks in ends]).astype(int)]
    # The second end of a force on a single block is the ground: index -1 selects the last entry of ``node``.
    second = node[np.append(second, [(*blocks, -1)[1] for blocks in ends]).astype(int)]
    count = ground + 1
    links = csr_array((np.ones(len(first)), (first, second)), shape=(count, count))
    parts, _ = connected_components(links, directed=False)
    return len(first) == count - parts


def worst_joint(assembly: Assembly, q: np.ndarray) -> WorstJoint | None:
    """Return the joint whose resultant is nearest to an edge of the joint, relative to the joint's size.

    The joint forces q have shape (3c + t,). Joints without length (in space, without area) and joints with
    very small normal forces are left out.
    """
    joints, problem = assembly.joints, assembly.problem
    n = np.zeros(len(joints.joint))
    n[assembly.pressed] = problem.at_points(q)
    total = np.bincount(joints.joint, n, minlength=len(joints.first))
    pressed = np.flatnonzero((total > _least_normal_forces(assembly, total)) & (joints.extent > 0))
    if not len(pressed):
        return None
    measure = _in_plane if assembly.scene.dimension == 2 else _in_space
    distance, margin = np.maximum(measure(assembly, n, pressed), 0.0)
    worst = int(margin.argmin())
    if not np.isfinite(margin[worst]):
        return None
    (pair,) = assembly.pairs_of(pressed[[worst]])
    return WorstJoint(pair[0], pair[1], float(distance[worst]), float(margin[worst]))


def _least_normal_forces(assembly: Assembly, total: np.ndarray) -> np.ndarray:
    """Return the normal force above which each joint counts as pressed, shape (joints,).

    ``total`` are the normal forces of the joints.
    """
    weight = np.full(len(assembly.scene.blocks), np.inf)
    weight[assembly.movable] = assembly.problem.force_sizes(assembly.problem.dead)
    lighter = np.minimum(weight[assembly.joints.first], weight[assembly.joints.second])
    return np.maximum(_PRESSED_SHARE * lighter, NEGLIGIBLE_SHARE * total.max(initial=0.0))


def _in_plane(assembly: Assembly, n: np.ndarray, pressed: np.ndarray) -> np.ndarray:
    """Return the distance of each resultant from the nearer end of its joint, absolute and relative.

    The relative distance is the distance divided by half the length of the joint: 1 in the middle, 0 at the
    ends. The shape is (2, k) for the k joints ``pressed``; ``n`` are the normal forces at the contact points.
    """
    first, second = n[assembly.joints.first_point[pressed]], n[assembly.joints.last_point[pressed]]
    share = np.minimum(first, second) / (first + second)
    return np.stack([share * assembly.joints.extent[pressed], 2 * share])


def _in_space(assembly: Assembly, n: np.ndarray, pressed: np.ndarray) -> np.ndarray:
    """Return the distance of each resultant from the nearest edge of its joint, absolute and relative.

    For the relative distance, the distance of the resultant from an edge is divided by the distance of the
    joint's middle from this edge: 1 in the middle, 0 at the edge. The smallest value of all edges is
    returned. The edges are the sides of the convex hull of the contact points. The shape is (2, k) for the k
    joints ``pressed``; ``n`` are the normal forces at the contact points.
    """
    # Import scipy.spatial only here, because the import takes 0.1 s and scenes in the plane do not need it.
    from scipy.spatial import ConvexHull, QhullError

    joints, measured = assembly.joints, []
    for joint in pressed.tolist():
        at = slice(joints.first_point[joint], joints.last_point[joint] + 1)
        _, *tangents = joints.axes[:, joint]
        middle = joints.point[at].mean(axis=0)
        points = (joints.point[at] - middle) @ np.array(tangents).T
        try:
            outward_and_offset = ConvexHull(points).equations
        except QhullError:
            # The points are nearly collinear, so the joint has no area in which to measure distances from its
            # edges.
            measured.append((np.inf, np.inf))
            continue
        reach = -outward_and_offset[:, 2]
        along = outward_and_offset[:, :2] @ (n[at] @ points / n[at].sum())
        measured.append(((reach - along).min(), (1 - along / reach).min()))
    return np.array(measured).T

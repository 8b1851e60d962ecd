"""Find the joints of a scene: shared sides of blocks, and corners and edges that touch elsewhere."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.errors import rounded
from masonry_opt.scene.contacts.alignment import AlignedContacts, aligned, square_to
from masonry_opt.scene.contacts.drawn import DrawnContacts
from masonry_opt.scene.contacts.gaps import (
    Closing,
    Gaps,
    closing,
    near_misses,
    widest_gaps,
)
from masonry_opt.scene.contacts.lost_joints import LostJoints, find_lost_joints, find_narrow_joints
from masonry_opt.scene.contacts.mortar import (
    Bridge,
    bridged_by_tolerance,
    find_bridge,
    is_drawn_apart,
    refuse_thin_blocks,
)
from masonry_opt.scene.contacts.neighbours import (
    CONTACT_FUNCTIONS,
    facing_sides,
    has_sides_at_small_angle,
    near_pairs,
)
from masonry_opt.scene.contacts.overlapping_supports import count_once
from masonry_opt.scene.contacts.overlaps import refuse_overlaps
from masonry_opt.scene.contacts.properties import joint_properties
from masonry_opt.scene.geometry import (
    MORTAR,
    Extents,
    raise_for,
)
from masonry_opt.scene.positions import coordinate_rounding
from masonry_opt.scene.rows import following, linked, ranges
from masonry_opt.scene.scene import Scene


@dataclass(frozen=True)
class Joints:
    """Joints of a scene with their contact points.

    Joints are ordered by first block, then by second block; contact points are ordered by joint. Points and
    vectors have two components in the plane, three in space. Points are relative to the shapes' origin.
    """

    first: np.ndarray  #: index of the first block of each joint in the scene, shape (joints,)
    #: Index of the second block of each joint, larger than the index of the first block, shape (joints,).
    second: np.ndarray
    #: Unit normal of each joint, from the second into the first block, shape (joints, 2) or (joints, 3).
    normal: np.ndarray
    #: Unit vector perpendicular to each joint's normal, shape (joints, 2) or (joints, 3). In the plane the
    #: vector is the normal rotated clockwise by 90°. In space the vector depends on the kind of joint. For a
    #: polygon it is parallel to the longest side, and for an edge to this edge. For a corner on a face it is
    #: parallel to a side of the face, and for two crossing edges to the edge of the first block.
    tangent: np.ndarray
    #: Uncertainty of each normal's direction in the drawing, in radians, shape (joints,).
    accuracy: np.ndarray
    #: Angle in radians by which each normal was rotated to correct errors of the drawing, shape (joints,).
    turn: np.ndarray
    #: Distance by which each contact point was moved to correct errors of the drawing, shape (points,).
    shift: np.ndarray
    #: Length (in space: area) of each joint, shape (joints,). Contacts at a point, or in space along an edge,
    #: have the value zero.
    extent: np.ndarray
    middle: np.ndarray  #: midpoint (for a polygon: centroid) of each joint, shape (joints, 2) or (joints, 3)
    #: Contact points, shape (points, 2) or (points, 3). A joint has the two ends of an edge, the corners of a
    #: polygon and its holes, or one point.
    point: np.ndarray
    #: Index of the joint to which each contact point belongs, in ascending order, shape (points,).
    joint: np.ndarray
    #: Index of the outline ring of each contact point, in ascending order, shape (points,). The outer ring of
    #: a polygon precedes the rings of its holes.
    ring: np.ndarray
    friction: np.ndarray  #: friction coefficient of each joint, ``inf`` if unlimited, shape (joints,)
    cohesion: np.ndarray  #: cohesion of each joint per unit of its length (in space: area), shape (joints,)
    dilatancy: np.ndarray  #: dilatancy tan ψ of each joint, shape (joints,)
    #: Two mean normal stresses for each joint, shape (joints, 2). Up to the first stress the dilatancy is
    #: full; above the second stress it is zero. Both are ``inf`` if the dilatancy does not depend on stress.
    dilatancy_stress: np.ndarray
    #: Compressive strength of each joint per unit of its length (in space: area), ``inf`` if unlimited, shape
    #: (joints,).
    strength: np.ndarray
    #: Blocks that rest on the overlap of two supports, shape (k, 3). Each row has the index of the block, of
    #: the support that has the joint on the overlap, and of the other support.
    overlaps: np.ndarray
    #: Length (in space: area) of the overlap in each row of ``overlaps``, shape (k,). It is relative to the
    #: smaller of two joints: the block of the row with its first support, and with its second support. The
    #: length of each joint includes the overlap.
    overlap_ratio: np.ndarray
    fixed_pairs: int  #: number of pairs of blocks that touch but have no joint because both are fixed
    gaps: Gaps  #: small gaps between blocks, with the largest width of each gap
    closing: Closing  #: option that turns all small gaps into joints, with the smallest value that does so
    #: Pairs of blocks that have no joint, because their facing sides are shorter than about ten times the
    #: scene's option ``tolerance``.
    lost: LostJoints
    #: Gaps that are probably undrawn mortar joints and that the scene's option ``tolerance`` closes, with the
    #: largest width of each gap.
    bridged: Gaps
    #: Value of ``tolerance`` that makes the sides of the gaps in ``bridged`` parallel. The value is 0 if the
    #: sides are parallel already, or if such a ``tolerance`` would remove joints of solids.
    aligning: float
    #: Segments that show the small gaps, midway between the two blocks at each gap. Each segment is given by
    #: its two ends, shape (segments, 2, 2) or (segments, 2, 3). In space, the segments of a gap are the edges
    #: of a polygon: the region in which the faces of the two blocks are opposite to each other.
    facing: np.ndarray
    #: Pairs of blocks (indices) that touch at a point where they have no joint, because the contact has no
    #: normal. The contact is between two corners or, in space, between a corner and an edge. Pairs in
    #: ``gaps`` or ``lost`` are omitted, and so are pairs of which both blocks have joints with other blocks
    #: at the point of contact.
    without_normal: list[tuple[int, int]]
    #: Points at which blocks touch without a contact normal, shape (points, 2) or (points, 3).
    meets: np.ndarray
    #: Pairs of blocks (indices) that have a joint at coinciding corners (in space: along coinciding edges).
    at_corners: list[tuple[int, int]]

    __repr__ = brief

    @cached_property
    def first_point(self) -> np.ndarray:
        """Return the index of the first contact point of each joint, shape (joints,)."""
        return np.searchsorted(self.joint, np.arange(len(self.first)))

    @property
    def last_point(self) -> np.ndarray:
        """Return the index of the last contact point of each joint, shape (joints,)."""
        return np.searchsorted(self.joint, np.arange(len(self.first)), side="right") - 1

    @property
    def parts(self) -> tuple[np.ndarray, np.ndarray]:
        """Return, for each joint of the optimisation problem, its joint in the scene and its contact points.

        In the plane, the joints of the problem are the joints of the scene, with contact points at both ends.
        In space, each contact point is a joint of the problem.

        Returns
        -------
        joint : ndarray, shape (parts,)
            Index of the joint in the scene, in ascending order.
        point : ndarray, shape (2, parts) in the plane, (1, parts) in space
            Indices of the contact points of each joint of the problem.
        """
        if self.point.shape[1] == 2:
            return np.arange(len(self.first)), np.stack([self.first_point, self.last_point])
        return self.joint, np.arange(len(self.joint))[None]

    def most(self, values: np.ndarray) -> np.ndarray:
        """Return the largest of the values at the contact points of each joint, shape (joints,)."""
        return np.maximum.reduceat(values, self.first_point)

    @property
    def start(self) -> np.ndarray:
        """Return the first contact point of each joint, shape (joints, 2) or (joints, 3)."""
        return self.point[self.first_point]

    @property
    def end(self) -> np.ndarray:
        """Return the last contact point of each joint, shape (joints, 2) or (joints, 3)."""
        return self.point[self.last_point]

    @property
    def axes(self) -> np.ndarray:
        """Return the normal and tangential axes of all joints, shape (axes, joints, coordinates).

        The axes are unit vectors: the normals, the tangents and, in space, the vector products of normals and
        tangents.
        """
        binormals = [np.cross(self.normal, self.tangent)] if self.normal.shape[1] > 2 else []
        return np.stack([self.normal, self.tangent, *binormals])

    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the sides of all joint outlines, and the index of the joint to which each side belongs.

        The indices are in ascending order. In the plane, each joint is a side. Sides are pairs of ends, shape
        (lines, 2, 2) or (lines, 2, 3). A joint at a single point has one side with equal ends.
        """
        lines, corner = outline_sides(np.bincount(self.ring), self.point)
        return lines, self.joint[corner]


def outline_sides(count: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the sides of outline rings, and the index of the corner at which each side begins.

    A side is given by its two ends. ``count`` is the number of corners of each ring. A ring of two corners
    has one side.
    """
    next_corner = following(count)
    is_way_back = (np.repeat(count, count) == 2) & (next_corner < np.arange(len(next_corner)))
    return np.stack([points, points[next_corner]], axis=1)[~is_way_back], np.flatnonzero(~is_way_back)


def shapes_of(scene: Scene) -> Extents:
    """Return the shapes of the blocks of a scene. Raises CaseError if a block has no valid shape."""
    return CONTACT_FUNCTIONS[scene.dimension][0](scene)


def find_joints(scene: Scene, shapes: Extents, *, floating: bool = False) -> Joints:
    """Find the joints of a scene from the shapes of its blocks.

    Two blocks, of which at least one can move, have a joint wherever their sides face each other without a
    third block between them. Over the whole shared length or area, the distance of the sides must not exceed
    the option ``contact_tolerance`` of the scene (its default is the option ``tolerance``). The joint lies on
    the bisecting line or plane of the sides. Where a block rests on two supports that overlap, only one of
    the two supports has a joint with the block.

    - In the plane, sides are edges. The length that two edges share is a joint. In a scene without
      ``contact_tolerance``, lengths below ten times ``tolerance`` are joints only if the edges are nearly
      parallel, or if their distance is at most a tenth of the length.
    - Away from shared lengths, a corner on an edge is a joint without length, normal to the edge.
    - Where two corners meet, the joint lies on the bisector of the sides that face each other, unless both
      blocks share sides there with other blocks, or two of their sides lie in one line. A corner in a notch
      has a joint with each side of the notch.
    - In space, sides are outer faces. Each connected polygon that two faces share is a joint. Pieces narrower
      than ten times ``tolerance`` are not joints.
    - Away from shared polygons, an edge in a face is a joint of two points. A corner on a face, and two edges
      that cross, are joints of one point. Two edges that run along each other are a joint of two points, on
      the bisector of the faces.

    Joints that are parallel, perpendicular or in one line within the accuracy of the drawing become exactly
    parallel, perpendicular or in one line (see :mod:`~.contacts.alignment`).

    Parameters
    ----------
    scene : Scene
        The scene.
    shapes : Extents
        Shapes of the blocks of the scene, from :func:`shapes_of`.
    floating : bool
        If True, movable blocks may touch nothing or reach no support, so that they can be drawn.

    Raises
    ------
    CaseError
        If too many pairs of blocks are near each other; if blocks overlap; if a movable block touches nothing
        or reaches no support, unless ``floating``; or if an exception names two blocks that do not touch.
    """
    refuse_thin_blocks(scene, shapes)
    pairs = near_pairs(scene, shapes, shapes.reach)
    both_fixed = scene.fixed[pairs].all(axis=1)
    refuse_overlaps(scene, shapes, pairs[~both_fixed])
    facing = facing_sides(scene, shapes, pairs, shapes.reach[pairs].min(axis=1, initial=np.inf))
    is_touching, can_move = facing.largest_gap <= shapes.contact_tolerance, ~both_fixed[facing.pair]
    fixed_pairs = len(np.unique(facing.pair[is_touching & ~can_move]))
    shared_sides, gap_sides = facing.where(is_touching & can_move), facing.where(~is_touching & can_move)
    # Two convex blocks that share a side have no other contact, so only other pairs are searched for contacts
    # at corners.
    may_meet_elsewhere = ~both_fixed
    may_meet_elsewhere[shared_sides.pair] &= ~shapes.convex[pairs[shared_sides.pair]].all(axis=1)
    candidates = np.flatnonzero(may_meet_elsewhere)
    corners = CONTACT_FUNCTIONS[scene.dimension][2](shapes, np.unique(pairs[candidates]))
    contacts = corners.touches(pairs, candidates, shared_sides)
    gap_sides = near_misses(
        (shared_sides, contacts), gap_sides, len(pairs), drawn_apart=is_drawn_apart(scene, shapes)
    )
    at_corners = corners.touches_at_corners(pairs, candidates, (shared_sides, contacts))
    facing_pairs = pairs[np.concatenate([shared_sides.pair, contacts.pair, gap_sides.pair])]
    lost = find_lost_joints(scene, shapes, facing_pairs)
    # Leave out contacts at corners of two blocks that face each other across a small gap, or that have no
    # joint because ``tolerance`` is too large.
    is_lost = np.array([tuple(pair) in lost.gaps for pair in pairs[at_corners.pair].tolist()], dtype=bool)
    at_corners = at_corners.where(~np.isin(at_corners.pair, gap_sides.pair) & ~is_lost)
    contacts = contacts.then(at_corners)
    gaps = widest_gaps(pairs, gap_sides)
    lost = lost.then(
        find_narrow_joints(
            scene,
            shapes,
            pairs,
            (np.flatnonzero(both_fixed), shared_sides.pair, contacts.pair, gap_sides.pair),
        )
    )
    closes_gaps = closing(scene, shapes, pairs, gap_sides)
    meeting_pairs, meeting_points = corners.without_normal(pairs, candidates, (shared_sides, contacts))
    # Exclude pairs of blocks in ``gaps`` or ``lost``, because other warnings name these pairs.
    named_pairs = {*gaps, *lost.gaps}
    has_no_gap = np.array(
        [tuple(pair) not in named_pairs for pair in pairs[meeting_pairs].tolist()], dtype=bool
    )
    bridged_gaps, alignment_tolerance = bridged_by_tolerance(scene, shapes, pairs, shared_sides)
    shared_sides, overlaps, overlap_ratio = count_once(scene, shapes, pairs, shared_sides)
    # Order the joints by pair of blocks. Within a pair, shared sides precede contacts along edges and at
    # points.
    owner = np.concatenate([shared_sides.pair, contacts.pair])
    order = np.argsort(owner, kind="stable")
    outlines = zip(shared_sides.outlines(), contacts.outlines(len(shared_sides.pair)), strict=True)
    tangent, owner_of_ring, count, point = map(np.concatenate, outlines)
    joint = np.argsort(order)[owner_of_ring]
    rings = np.argsort(joint, kind="stable")
    ends = pairs[owner[order]]
    first, second = ends.T
    if not floating:
        refuse_floating(scene, shapes, (first, second), closes_gaps)
    normal = np.concatenate([shared_sides.normal, contacts.normal])[order]
    accuracy = np.concatenate([shared_sides.accuracy, contacts.accuracy])[order]
    extent = np.concatenate([shared_sides.extent, np.zeros(len(contacts.pair))])[order]
    middle = np.concatenate([shared_sides.middle, (contacts.start + contacts.end) / 2])[order]
    point = point[ranges((np.cumsum(count) - count)[rings], count[rings])]
    joint, ring = np.repeat(joint[rings], count[rings]), np.repeat(np.arange(len(rings)), count[rings])
    rounding = coordinate_rounding(shapes)
    alignment = aligned(DrawnContacts(ends, normal, accuracy, point, joint, ring, shapes.tolerance, rounding))
    tangent = np.where(
        alignment.turn[:, None] > 0, square_to(tangent[order], alignment.normal), tangent[order]
    )
    if scene.dimension == 2:
        extent, middle = _measure_moved_joints(alignment, joint, extent, middle)
    return Joints(
        first=first,
        second=second,
        normal=alignment.normal,
        tangent=tangent,
        accuracy=accuracy,
        turn=alignment.turn,
        shift=alignment.shift,
        extent=extent,
        middle=middle,
        point=alignment.point,
        joint=joint,
        ring=ring,
        **joint_properties(scene, (first, second), (overlaps, overlap_ratio), gaps, closes_gaps),
        overlaps=overlaps,
        overlap_ratio=overlap_ratio,
        fixed_pairs=fixed_pairs,
        gaps=gaps,
        closing=closes_gaps,
        lost=lost,
        bridged=bridged_gaps,
        aligning=alignment_tolerance,
        facing=outline_sides(*gap_sides.outlines()[2:])[0],
        without_normal=[(int(i), int(j)) for i, j in pairs[np.unique(meeting_pairs[has_no_gap])]],
        meets=meeting_points[has_no_gap],
        at_corners=[(int(i), int(j)) for i, j in pairs[np.unique(at_corners.pair)]],
    )


def _measure_moved_joints(
    alignment: AlignedContacts, joint: np.ndarray, extent: np.ndarray, middle: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """For a scene in the plane, return the lengths and midpoints of the joints after alignment.

    Only the values of joints that the alignment moved are recomputed.
    """
    extent, middle = extent.copy(), middle.copy()
    moved_joints = np.unique(joint[alignment.shift > 0])
    start = alignment.point[np.searchsorted(joint, moved_joints)]
    end = alignment.point[np.searchsorted(joint, moved_joints, side="right") - 1]
    extent[moved_joints], middle[moved_joints] = np.hypot(*(end - start).T), (start + end) / 2
    return extent, middle


def refuse_floating(
    scene: Scene, shapes: Extents, joint_ends: tuple[np.ndarray, np.ndarray], closes_gaps: Closing
) -> None:
    """Raise CaseError if a block floats: it touches no block, or nothing connects it to a support.

    A tie or prop that ends at the ground supports a block, as a fixed block does.

    ``joint_ends`` has the two blocks of each joint. ``closes_gaps`` is the option that closes the small gaps.
    """
    first, second = joint_ends
    # Ties and props that end at the ground support a block, as a fixed block does.
    is_supported = scene.fixed.copy()
    index = {block.name: number for number, block in enumerate(scene.blocks)}
    for strut in [*scene.ties, *scene.props]:
        ends = [index[name] for name in strut.between if name in index]
        if len(ends) == 1:
            is_supported[ends] = True
        else:
            first, second = np.append(first, ends[0]), np.append(second, ends[1])
    group = linked(len(scene.blocks), first, second)
    floating_blocks = np.flatnonzero(~np.isin(group, group[is_supported]))
    bridge = (
        find_bridge(scene, shapes, (first, second), is_supported, closes_gaps)
        if len(floating_blocks)
        else None
    )
    if bridge:
        # List first the blocks that the recommended option connects, and then the remaining blocks.
        floating_blocks = np.append(
            floating_blocks[~np.isin(floating_blocks, bridge.remaining)], bridge.remaining
        )
    is_alone = ~np.isin(floating_blocks, [first, second])
    isolated_blocks = floating_blocks[is_alone]
    if len(isolated_blocks):
        raise_for(
            isolated_blocks,
            scene,
            f"{{}} touches no other block: "
            f"{_describe_neighbour(scene, shapes, int(isolated_blocks[0]), bridge)}",
        )
    remedy = f"support it, or {bridge.advice(scene)}" if bridge else "support it"
    raise_for(
        floating_blocks,
        scene,
        f"{{}} is not connected to any fixed block or to the ground, directly or through other blocks: "
        f"{remedy}",
    )


def _describe_neighbour(scene: Scene, shapes: Extents, block: int, bridge: Bridge | None) -> str:
    """Return the part of a message that describes the gap between an isolated block and its neighbour.

    The neighbour is a block that the isolated block faces, or else the nearest block.
    """
    if bridge and block in bridge.neighbour:
        neighbour, gap = bridge.neighbour[block]
        name = repr(scene.blocks[neighbour].name)
        if not bridge.gap or gap <= shapes.contact_tolerance:
            return (
                f"its sides that face {name} are narrower than ten times 'tolerance': {bridge.advice(scene)}"
            )
        return f"its neighbour {name} is up to {rounded(gap)} away: close the gap, or {bridge.advice(scene)}"
    neighbour, gap = shapes.nearest(block)
    name = repr(scene.blocks[neighbour].name)
    if gap <= shapes.tolerance:
        return f"it meets {name} {shapes.meeting}: {shapes.bearing}"
    gap_text = f"the nearest block {name} is {rounded(gap)} away"
    is_near = gap <= MORTAR * shapes.width[[block, neighbour]].min()
    if is_near and not has_sides_at_small_angle(scene, shapes, block, neighbour):
        return (
            f"{gap_text}, but 'contact_tolerance' cannot bridge the gap, because no two facing "
            "sides are parallel within 20°: close the gap, draw the blocks as wedges with parallel sides at "
            "the gap, or remove the block"
        )
    return f"{gap_text}: close the gap, or remove the block"

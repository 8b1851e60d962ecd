"""Joints from geometry, in one table: what sides share, and where corners and edges touch beside that."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from masonry_opt.errors import CaseError, counted, rounded_up
from masonry_opt.scene.contacts import edges, faces
from masonry_opt.scene.contacts.alignment import AlignedContacts, DrawnContacts, aligned, square_to
from masonry_opt.scene.contacts.gaps import joining_tolerance, near_misses
from masonry_opt.scene.contacts.sides import BlockCorners, Facing
from masonry_opt.scene.geometry import Common, Extents, geometry, raise_for, set_tolerance
from masonry_opt.scene.joints import JointDefaults
from masonry_opt.scene.rows import following, linked, ranges
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.faces import place
from masonry_opt.scene.space.shapes import shapes

#: By dimension: shapes of blocks, what of them faces what, and what touches beside it.
_KINDS: dict[int, tuple[Callable[[Scene], Extents], Callable[..., Facing], Callable[..., BlockCorners]]] = {
    2: (geometry, edges.facing, edges.PlaneCorners),
    3: (shapes, faces.facing, faces.SolidCorners),
}

#: Length below which coordinates differ by rounding, over the spacing of floating-point numbers there.
_ROUNDING = 64.0

#: Largest width of the small gap between two blocks that face each other, by the pair of their indices.
Gaps = dict[tuple[int, int], float]


@dataclass(frozen=True)
class Joints:
    """Arrays over the joints of a scene, ordered by (first, second) block, and over their contact points,
    ordered by joint. Points and vectors have two components in the plane, three in space."""

    first: np.ndarray  #: index into the scene's blocks, shape (joints,)
    second: np.ndarray  #: index of the other block, first < second
    normal: np.ndarray  #: unit normal from the second block into the first, shape (joints, 2) or (joints, 3)
    #: Unit vector square to it: in the plane a quarter turn clockwise, in space along the longest side or
    #: the edge that touches, at a point along a side of the face or one of the two edges.
    tangent: np.ndarray
    accuracy: np.ndarray  #: angle within which the drawing fixes each normal, in radians, shape (joints,)
    turn: np.ndarray  #: angle in radians by which alignment turned each normal, shape (joints,)
    shift: np.ndarray  #: distance by which alignment moved each contact point, shape (points,)
    #: Length, in space area; 0 where a corner stands on an edge, in space along an edge or at a point.
    extent: np.ndarray
    middle: np.ndarray  #: of each joint, of a polygon its centroid, relative to the shapes' origin
    #: Contact points, relative to the shapes' origin: the two ends of an edge, the corners of a polygon and
    #: its holes, or one point, shape (points, 2) or (points, 3).
    point: np.ndarray
    joint: np.ndarray  #: joint of each contact point, rising, shape (points,)
    ring: np.ndarray  #: ring of each contact point, rising, shape (points,): a joint's outer one, then holes
    friction: np.ndarray  #: shape (joints,)
    cohesion: np.ndarray  #: per unit of extent, shape (joints,)
    dilatancy: np.ndarray  #: shape (joints,)
    #: Mean normal stresses up to which dilatancy is whole, and from which there is none, else ``inf``.
    dilatancy_stress: np.ndarray
    strength: np.ndarray  #: compressive, per unit of extent, ``inf`` where unlimited, shape (joints,)
    fixed_pairs: int  #: how many touching pairs were left out because both blocks are fixed
    gaps: Gaps
    joining_tolerance: float  #: tolerance that closes all small gaps and aligns their joints; 0 without gaps
    facing: np.ndarray  #: lines along such gaps, in space round them, shape (lines, 2, 2) or (lines, 2, 3)
    #: Pairs of blocks (indices) that meet without a normal, and so without a joint, where not both have one:
    #: corner on corner, in space also corner on edge or edge along edge; but those beside a small gap.
    without_normal: list[tuple[int, int]]
    meets: np.ndarray  #: points where they do, shape (points, 2) or (points, 3)

    @cached_property
    def first_point(self) -> np.ndarray:
        """Number of the first contact point of each joint, shape (joints,)."""
        return np.searchsorted(self.joint, np.arange(len(self.first)))

    @property
    def last_point(self) -> np.ndarray:
        """Number of the last one."""
        return np.searchsorted(self.joint, np.arange(len(self.first)), side="right") - 1

    @property
    def parts(self) -> tuple[np.ndarray, np.ndarray]:
        """The problem's joints, in the plane these, in space their contact points: the joint of each, rising,
        and the contact points at which it presses, its two ends or itself, shape (points, parts)."""
        if self.point.shape[1] == 2:
            return np.arange(len(self.first)), np.stack([self.first_point, self.last_point])
        return self.joint, np.arange(len(self.joint))[None]

    def most(self, values: np.ndarray) -> np.ndarray:
        """Of values of the contact points the largest of each joint, shape (joints,)."""
        return np.maximum.reduceat(values, self.first_point)

    @property
    def start(self) -> np.ndarray:
        """First contact point of each joint, shape (joints, 2) or (joints, 3)."""
        return self.point[self.first_point]

    @property
    def end(self) -> np.ndarray:
        """Last contact point of each joint, shape (joints, 2) or (joints, 3)."""
        return self.point[self.last_point]

    @property
    def axes(self) -> np.ndarray:
        """Normal and tangent of each joint, in space also their product, shape (dim, joints, dim)."""
        across = [np.cross(self.normal, self.tangent)] if self.normal.shape[1] > 2 else []
        return np.stack([self.normal, self.tangent, *across])

    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Sides of all joints' outlines, in the plane the joints themselves: both ends, shape (lines, 2, 2)
        or (lines, 2, 3), and the joint of each, rising. What has no length has equal ends."""
        lines, corner = outline_sides(np.bincount(self.ring), self.point)
        return lines, self.joint[corner]


def outline_sides(count: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of sides of rings of so many corners, and the corner that each begins at; two have one side."""
    after = following(count)
    back = (np.repeat(count, count) == 2) & (after < np.arange(len(after)))
    return np.stack([points, points[after]], axis=1)[~back], np.flatnonzero(~back)


def shapes_of(scene: Scene) -> Extents:
    """Shapes of the blocks of a scene, in the plane or in space. Raises CaseError if one is wrong."""
    return _KINDS[scene.dimension][0](scene)


def find_joints(scene: Scene, shapes: Extents, *, floating: bool = False) -> Joints:
    """Find the joints of a scene.

    Two blocks, not both fixed, share a joint wherever their sides face each other and stay within the
    tolerance (or the contact tolerance) over all they share: its line or plane is the sides' bisector.

    In the plane sides are edges: they share lengths of ten tolerances or more, or of less, if they stay
    within a tenth of that length. Where a corner of one stands on an edge of the other, away from such a
    length, is a joint without length, normal to the edge.

    In space they are outer faces: each connected polygon that two share is one joint; what is narrower than
    ten tolerances is nothing. Away from such polygons, an edge that lies in a face is a joint of two points,
    a corner on a face and two edges that cross are joints of one.

    Joints that are parallel, square or in one line within the accuracy of the drawing become so exactly
    (see :mod:`~.contacts.alignment`).

    Raises CaseError if blocks overlap, a movable block touches nothing or reaches no support (unless they are
    ``floating``, to show them), an exception names two that do not touch, or too many pairs are near.
    """
    pairs = near_pairs(scene, shapes)
    both_fixed = scene.fixed[pairs].all(axis=1)
    refuse_overlaps(scene, shapes, pairs[~both_fixed])
    _, facing, corners_of = _KINDS[scene.dimension]
    found = facing(scene, shapes, pairs, shapes.reach[pairs].min(axis=1, initial=np.inf))
    touch, joined = found.most <= shapes.contact_tolerance, ~both_fixed[found.pair]
    fixed_pairs = len(np.unique(found.pair[touch & ~joined]))
    shared, across = found.where(touch & joined), found.where(~touch & joined)
    # Two convex blocks that share a side meet nowhere else.
    alone = ~both_fixed
    alone[shared.pair] &= ~shapes.convex[pairs[shared.pair]].all(axis=1)
    asked = np.flatnonzero(alone)
    corners = corners_of(shapes, np.unique(pairs[asked]))
    beside = corners.touches(pairs, asked, shared)
    across = near_misses((shared, beside), across, len(pairs))
    gaps: Gaps = {}
    for (i, j), width in zip(pairs[across.pair].tolist(), across.most.tolist(), strict=True):
        gaps[i, j] = max(gaps.get((i, j), 0.0), width)
    joining = joining_tolerance(across)
    # What sides share first, then lines and points of each pair.
    owner = np.concatenate([shared.pair, beside.pair])
    order = np.argsort(owner, kind="stable")
    both = zip(shared.outlines(), beside.outlines(len(shared.pair)), strict=True)
    tangent, owner_of_ring, count, point = map(np.concatenate, both)
    joint = np.argsort(order)[owner_of_ring]
    rings = np.argsort(joint, kind="stable")
    first, second = pairs[owner[order]].T
    meeting, meets = corners.without_normal(pairs, asked, (shared, beside))
    loose = ~np.isin(meeting, across.pair)
    if not floating:
        refuse_floating(scene, shapes, (first, second), gaps, joining)
    normal = np.concatenate([shared.normal, beside.normal])[order]
    accuracy = np.concatenate([shared.accuracy, beside.accuracy])[order]
    extent = np.concatenate([shared.extent, np.zeros(len(beside.pair))])[order]
    middle = np.concatenate([shared.middle, (beside.start + beside.end) / 2])[order]
    point = point[ranges((np.cumsum(count) - count)[rings], count[rings])]
    joint, ring = np.repeat(joint[rings], count[rings]), np.repeat(np.arange(len(rings)), count[rings])
    rounding = _ROUNDING * float(np.spacing(np.abs(shapes.boxes + shapes.origin).max()))
    ends = pairs[owner[order]]
    now = aligned(DrawnContacts(ends, normal, accuracy, point, joint, ring, shapes.tolerance, rounding))
    tangent = np.where(now.turn[:, None] > 0, square_to(tangent[order], now.normal), tangent[order])
    if scene.dimension == 2:
        extent, middle = _measured_again(now, joint, extent, middle)
    return Joints(
        first=first,
        second=second,
        normal=now.normal,
        tangent=tangent,
        accuracy=accuracy,
        turn=now.turn,
        shift=now.shift,
        extent=extent,
        middle=middle,
        point=now.point,
        joint=joint,
        ring=ring,
        **joint_properties(scene, first, second, gaps, joining),
        fixed_pairs=fixed_pairs,
        gaps=gaps,
        joining_tolerance=joining,
        facing=outline_sides(*across.outlines()[2:])[0],
        without_normal=[(int(i), int(j)) for i, j in pairs[np.unique(meeting[loose])]],
        meets=meets[loose],
    )


def _measured_again(
    now: AlignedContacts, joint: np.ndarray, extent: np.ndarray, middle: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return lengths and midpoints of plane joints, recomputed where alignment moved a contact point."""
    extent, middle = extent.copy(), middle.copy()
    moved = np.unique(joint[now.shift > 0])
    start = now.point[np.searchsorted(joint, moved)]
    end = now.point[np.searchsorted(joint, moved, side="right") - 1]
    extent[moved], middle[moved] = np.hypot(*(end - start).T), (start + end) / 2
    return extent, middle


def joint_properties(
    scene: Scene, first: np.ndarray, second: np.ndarray, gaps: Gaps, joining: float
) -> dict[str, Any]:
    """Return the properties of joints as :class:`Joints` has them.

    Raises CaseError if the two blocks of an exception do not touch. The message names the tolerance
    ``joining`` that closes the small gaps if one of ``gaps`` separates the two blocks.
    """
    found = {name: np.full((len(first), *np.shape(of)), of) for name, of in _values(scene.joints).items()}
    index = {block.name: number for number, block in enumerate(scene.blocks)}
    for exception in scene.exceptions:
        one, other = sorted(index[name] for name in exception.between)
        of_both = (first == one) & (second == other)
        if not of_both.any():
            both_fixed = scene.blocks[one].fixed and scene.blocks[other].fixed
            why = "are both fixed" if both_fixed else "do not touch"
            where = f"joint between {list(exception.between)}"
            remedy = ""
            if (one, other) in gaps:
                width = f"the gap between them is up to {rounded_up(gaps[one, other], 2)} wide"
                remedy = f": {width}; {set_tolerance(joining)} if they should touch"
            no_joint = f"these blocks {why}, so there is no joint to describe"
            raise CaseError(f"{scene.origin}: {where}: {no_joint}{remedy}")
        for name, value in _values(exception.over(scene.joints)).items():
            found[name][of_both] = value
    return found


def _values(joint: JointDefaults) -> dict[str, float | tuple[float, float]]:
    """Properties of a joint, ``inf`` for what does not limit."""
    slides = np.isfinite(joint.friction)  # else cohesion and dilatancy say nothing
    return {
        "friction": joint.friction,
        "cohesion": joint.cohesion if slides else 0.0,
        "dilatancy": joint.dilatancy if slides else 0.0,
        "dilatancy_stress": joint.dilatancy_stress or (np.inf, np.inf),
        "strength": joint.strength or np.inf,
    }


#: Most pairs of blocks near each other: this many, and so many more for each block. Side by side a block has
#: some six neighbours; of blocks that lie on one another each is a neighbour of all.
_MOST_PAIRS, _MOST_PAIRS_PER_BLOCK = 1_000_000, 40


def near_pairs(scene: Scene, shapes: Extents) -> np.ndarray:
    """Sorted index pairs (i < j) of blocks whose boxes come near. Raises CaseError if they are too many."""
    (low, high), far = shapes.boxes, shapes.reach
    across = np.argsort(np.ptp(low, axis=0))[-2:]  # in space seen where the scene is least deep
    tree = shapely.STRtree(shapely.box(*low[:, across].T, *high[:, across].T))
    grown = shapely.box(*(low[:, across] - far[:, None]).T, *(high[:, across] + far[:, None]).T)
    count = len(low)
    found: list[np.ndarray] = []
    pairs = 0
    for first in range(0, count, 100):
        i, j = tree.query(grown[first : first + 100])
        i += first
        apart = np.maximum(low[i] - high[j], low[j] - high[i]).max(axis=1)
        near = (i < j) & (apart <= np.minimum(far[i], far[j]))
        found.append(np.column_stack([i[near], j[near]]))
        pairs += len(found[-1])
        if pairs > _MOST_PAIRS + _MOST_PAIRS_PER_BLOCK * count:
            many = f"the first {min(first + 100, count)} have {pairs} neighbours"
            why = f"blocks lie on one another: {many}; give each block a place of its own"
            raise CaseError(f"{scene.origin}: {why}")
    return np.unique(np.concatenate(found), axis=0)


def refuse_overlaps(scene: Scene, shapes: Extents, near: np.ndarray) -> None:
    """Raise CaseError if two blocks near each other overlap by more than the contact tolerance.

    ``near`` lists the pairs of blocks, shape (pairs, 2).
    """
    (low, high), (i, j) = shapes.boxes, near.T
    inside = np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])
    pairs = near[(inside > shapes.contact_tolerance).all(axis=1)]
    found: dict[int, list[Common]] = {}
    for number, piece in shapes.overlaps(pairs):
        found.setdefault(number, []).append(piece)
        if len(found) == shapes.enough:
            break
    if not found:
        return
    size = {pair: sum(piece.size for piece in pieces) for pair, pieces in found.items()}
    worst = max(size, key=lambda pair: size[pair])
    deepest = max(found[worst], key=lambda piece: piece.depth)
    names = [repr(scene.blocks[index].name) for index in pairs[worst]]
    depth = max(piece.depth for pieces in found.values() for piece in pieces)
    # Rounding leaves slivers; what is deeper is no matter of tolerance.
    remedy = shapes.remedy.format(rounded_up(depth, 2))
    if size[worst] > shapes.inside * shapes.size[pairs[worst]].min():
        remedy = ", or leave one out: one lies within the other"
    elif deepest.depth <= shapes.reach[pairs[worst]].min():
        joining = _tolerance_for_overlaps(scene, shapes, near, pairs[[*found]], depth)
        remedy = f", or {set_tolerance(joining)} if their coordinates are inexact"
    others = len(found) - 1
    least = "at least " if len(found) == shapes.enough else ""
    more = f" ({least}{counted(others, 'more pair')} overlap{'s' if others == 1 else ''})" if others else ""
    overlap = f"blocks {names[0]} and {names[1]} overlap {shapes.within} of {size[worst]:.6g}"
    at = f"round {place(deepest.middle + shapes.origin, shapes.contact_tolerance)}, {deepest.depth:.3g} deep"
    raise CaseError(f"{scene.origin}: {overlap} {at}: move them apart{remedy}{more}")


def _tolerance_for_overlaps(
    scene: Scene, shapes: Extents, near: np.ndarray, overlapping: np.ndarray, depth: float
) -> float:
    """Return the tolerance at which overlaps up to a depth, and small gaps, become joints that align.

    ``near`` lists the pairs of blocks that may face each other, and ``overlapping`` those that overlap.
    """
    _, facing, _ = _KINDS[scene.dimension]
    shapes = replace(shapes, contact_tolerance=depth)
    found = facing(scene, shapes, near, shapes.reach[near].min(axis=1, initial=np.inf))
    number_of_pair = np.array([len(scene.blocks), 1])
    overlap = np.isin(near @ number_of_pair, overlapping @ number_of_pair)
    touch = (found.most <= shapes.tolerance) & ~overlap[found.pair]
    apart = near_misses((found.where(touch),), found.where(~touch), len(near))
    return max(depth, joining_tolerance(apart))


def refuse_floating(
    scene: Scene, shapes: Extents, joined: tuple[np.ndarray, np.ndarray], gaps: Gaps, joining: float
) -> None:
    """Raise CaseError if a block touches nothing or is not linked to a support.

    ``joined`` holds the two blocks of each joint, ``joining`` is the tolerance that closes the small gaps.
    """
    fixed, count = scene.fixed, len(scene.blocks)
    first, second = joined
    joints, ground = len(first), int(fixed.argmax())  # which does not move, as a fixed block
    index = {block.name: number for number, block in enumerate(scene.blocks)}
    for strut in [*scene.ties, *scene.props]:
        ends = [index.get(name, ground) for name in strut.between]
        first, second = np.append(first, ends[0]), np.append(second, ends[1])
    touched = np.zeros(count, dtype=bool)
    touched[first] = touched[second] = True
    alone = np.flatnonzero(~touched & ~fixed)
    if len(alone):
        raise_for(
            alone, scene, f"touches no other block: {_nearest(scene, shapes, int(alone[0]), gaps, joining)}"
        )
    group = linked(count, first, second)
    loose = np.flatnonzero(~np.isin(group, group[fixed]))
    raise_for(loose, scene, "reaches no fixed block, neither itself nor through others: support it")
    if not joints:
        raise CaseError(f"{scene.origin}: ties and props hold every block: one must stand on another")


def _nearest(scene: Scene, shapes: Extents, block: int, gaps: Gaps, joining: float) -> str:
    """Return how far a block that touches nothing is from the block it faces or the nearest, and a remedy."""
    remedy = ""
    if faced := [(gap, sum(pair) - block) for pair, gap in gaps.items() if block in pair]:
        (gap, other), which = min(faced), "which it faces, is up to"
    else:
        (other, gap), which = shapes.nearest(block), "the nearest, is"
    name, both = repr(scene.blocks[other].name), [block, other]
    if not faced and gap <= shapes.tolerance:
        return f"it meets {name} {shapes.meeting} of either"
    if faced or gap <= shapes.reach[both].min():
        remedy = f", or {set_tolerance(max(gap, joining))} if coordinates are inexact"
    elif gap <= shapes.mortar * shapes.width[both].min():
        remedy = f", or raise 'contact_tolerance' to {rounded_up(gap, 2)} if mortar was left out"
    return f"{name}, {which} {gap:.3g} away: close the gap{remedy}, or take the block away"

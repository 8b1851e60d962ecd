"""Joints from geometry: what sides of two blocks share, and where corners and edges touch beside that."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from masonry_opt.scene.contacts import edges, faces, solids
from masonry_opt.scene.contacts.joints import Joints, joint_properties, outline_sides
from masonry_opt.scene.contacts.pairs import near_pairs, refuse_floating, refuse_overlaps
from masonry_opt.scene.contacts.sides import LEAN, BlockCorners, Facing, Touches, nearest
from masonry_opt.scene.extents import Extents
from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.rows import lengths, ranges
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.shapes import shapes

#: By dimension: shapes of blocks, what of them faces what, and what touches beside it.
_KINDS: dict[int, tuple[Callable[[Scene], Extents], Callable[..., Facing], Callable[..., BlockCorners]]] = {
    2: (geometry, edges.facing, edges.PlaneCorners),
    3: (shapes, faces.facing, solids.SolidCorners),
}


def shapes_of(scene: Scene) -> Extents:
    """Shapes of the blocks of a scene, in the plane or in space. Raises CaseError if one is wrong."""
    return _KINDS[scene.dimension][0](scene)


def find_joints(scene: Scene, shapes: Extents, *, floating: bool = False) -> Joints:
    """Find the joints of a scene.

    Two blocks share a joint wherever their sides face each other and stay within the tolerance (or the
    contact tolerance) over all they share, at any angle: its line or plane is the sides' bisector. Two fixed
    blocks share no joint.

    In the plane sides are edges: they share lengths of ten tolerances or more, or of less, if they stay
    within a tenth of that length. Where a corner of one stands on an edge of the other, away from such a
    length, is a joint without length, normal to the edge.

    In space they are outer faces: each connected polygon that two share is one joint; what is narrower than
    ten tolerances is nothing. Away from such polygons, an edge that lies in a face is a joint of two points,
    a corner on a face and two edges that cross are joints of one.

    Raises CaseError if blocks overlap, a movable block touches nothing or reaches no support, an exception
    names two blocks that do not touch, or there are more pairs to compare than memory holds.

    Parameters
    ----------
    floating: whether blocks may touch nothing, or reach no support: to show them.
    """
    fixed = np.array([block.fixed for block in scene.blocks])
    pairs = near_pairs(scene, shapes)
    both_fixed = fixed[pairs].all(axis=1)
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
    across = _near_misses(shared, beside, across, len(pairs))
    gaps: dict[tuple[int, int], float] = {}
    for (i, j), width in zip(pairs[across.pair].tolist(), across.most.tolist(), strict=True):
        gaps[i, j] = min(gaps.get((i, j), np.inf), width)
    # What sides share first, then lines and points of each pair.
    owner = np.concatenate([shared.pair, beside.pair])
    order = np.argsort(owner, kind="stable")
    tangent, *of_rings = shared.outlines()
    joint, point, ring = _points(np.argsort(order), of_rings, beside)
    first, second = pairs[owner[order]].T
    meeting, meets = corners.without_normal(pairs, asked, (shared, beside))
    loose = ~np.isin(meeting, across.pair)
    if not floating:
        refuse_floating(scene, shapes, first, second, gaps)
    return Joints(
        first=first,
        second=second,
        normal=np.concatenate([shared.normal, beside.normal])[order],
        tangent=np.concatenate([tangent, beside.along])[order],
        extent=np.concatenate([shared.extent, np.zeros(len(beside.pair))])[order],
        middle=np.concatenate([shared.middle, (beside.start + beside.end) / 2])[order],
        point=point,
        joint=joint,
        ring=ring,
        **joint_properties(scene, first, second),
        fixed_pairs=fixed_pairs,
        gaps=gaps,
        facing=outline_sides(*across.outlines()[2:])[0],
        without_normal=[(int(i), int(j)) for i, j in pairs[np.unique(meeting[loose])]],
        meets=meets[loose],
    )


def _near_misses(shared: Facing, beside: Touches, across: Facing, pairs: int) -> Facing:
    """What faces each other across a small gap, beside what its pair shares."""
    # Not so wide that it leans away, and no mere chamfer of what is shared.
    of_pair = np.bincount(shared.pair, shared.extent, pairs)
    width = across.extent ** (1 / (across.middle.shape[1] - 1))
    across = across.where((across.most <= LEAN * width) & (across.extent > LEAN * of_pair[across.pair]))
    apart = [nearest(across.pair, across.middle, found, found.pair) for found in (shared, beside)]
    return across.where(np.minimum(*apart) > 2 * across.most)


def _points(
    joint_of: np.ndarray, of_rings: list[np.ndarray], lines: Touches
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joint, position and ring of each contact point, given the joint of each of what sides share
    and then of each line or point, and of all rings what ``outlines`` gives."""
    polygon, corners, point = of_rings
    long = lengths(lines.end - lines.start) > 0
    ends = np.stack([lines.start, lines.end], axis=1)[np.column_stack([np.ones_like(long), long])]
    polygons = len(joint_of) - len(long)
    joint = joint_of[np.concatenate([polygon, np.arange(polygons, len(joint_of))])]
    count = np.concatenate([corners, 1 + long])
    order = np.argsort(joint, kind="stable")
    point = np.concatenate([point, ends])[ranges((np.cumsum(count) - count)[order], count[order])]
    count = count[order]
    return np.repeat(joint[order], count), point, np.repeat(np.arange(len(count)), count)

"""Joints of blocks in space: polygons that faces share, edges and corners on faces, edges that cross."""

from __future__ import annotations

import numpy as np
import shapely

from masonry_opt.scene.combinations import ranges
from masonry_opt.scene.contacts.floating import refuse_floating
from masonry_opt.scene.contacts.joints import Joints, joint_properties
from masonry_opt.scene.contacts.pairs import near_pairs, refuse_overlaps
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.facing import Facing, facing
from masonry_opt.scene.space.frames import lengths
from masonry_opt.scene.space.outlines import rolled
from masonry_opt.scene.space.shapes import Shapes
from masonry_opt.scene.space.touches import Corners, Touches, nearest, touches, without_normal
from masonry_opt.scene.touching import LEAN


def find_contacts(scene: Scene, shapes: Shapes, *, floating: bool = False) -> Joints:
    """Find the joints of a scene in space.

    Two blocks share a joint wherever outer faces of theirs face each other and stay within the tolerance
    (or the contact tolerance) over all they share, at any angle: its plane is the faces' bisector; each
    connected piece is one joint; what is narrower than ten tolerances is nothing. Away from such polygons, an
    edge that lies in a face is a joint of two points, a corner on a face and two edges that cross are joints
    of one. Two fixed blocks share no joint.

    Parameters
    ----------
    floating: whether blocks may touch nothing, or reach no support: to show them.

    Raises
    ------
    CaseError
        If blocks overlap, a movable block touches nothing or reaches no support, an exception names two
        blocks that do not touch, or there are more pairs to compare than memory holds.
    """
    fixed = np.array([block.fixed for block in scene.blocks])
    pairs = near_pairs(scene, shapes)
    both_fixed = fixed[pairs].all(axis=1)
    refuse_overlaps(scene, shapes, pairs[~both_fixed])
    far = shapes.reach[pairs].min(axis=1, initial=np.inf)
    found = facing(shapes, pairs, far)
    shared = found.most <= shapes.contact_tolerance
    fixed_pairs = len(np.unique(found.pair[shared & both_fixed[found.pair]]))
    joined = ~both_fixed[found.pair]
    polygons, across = found.where(shared & joined), found.where(~shared & joined)
    # Two convex blocks that share a polygon meet nowhere else.
    alone = ~both_fixed
    alone[polygons.pair] &= ~shapes.convex[pairs[polygons.pair]].all(axis=1)
    asked = np.flatnonzero(alone)
    corners = Corners(shapes, np.unique(pairs[asked]))
    lines = touches(corners, pairs, asked, polygons)
    gap = _near_misses(polygons, lines, across, len(pairs))
    near = np.flatnonzero(np.isfinite(gap))
    # Polygons first, then lines and points of each pair.
    owner = np.concatenate([polygons.pair, lines.pair])
    order = np.argsort(owner, kind="stable")
    tangent, *of_rings = _rings(polygons)
    joint, point, ring = _points(np.argsort(order), of_rings, lines)
    first, second = pairs[owner[order]].T
    gaps = {(int(i), int(j)): float(width) for width, (i, j) in zip(gap[near], pairs[near], strict=True)}
    meeting = np.setdiff1d(without_normal(corners, pairs, asked, (polygons, lines)), near)
    if not floating:
        refuse_floating(scene, shapes, first, second, gaps)
    return Joints(
        first=first,
        second=second,
        normal=np.concatenate([-polygons.frame.normal, lines.normal])[order],
        tangent=np.concatenate([tangent, lines.along])[order],
        extent=np.concatenate([polygons.area, np.zeros(len(lines.pair))])[order],
        point=point,
        joint=joint,
        ring=ring,
        **joint_properties(scene, first, second),
        fixed_pairs=fixed_pairs,
        gaps=gaps,
        without_normal=[(int(i), int(j)) for i, j in pairs[meeting]],
    )


def _near_misses(shared: Facing, lines: Touches, across: Facing, pairs: int) -> np.ndarray:
    """Of each pair the largest width of a small gap across which its blocks face each other beside what they
    share, ``inf`` without one, shape (pairs,)."""
    area = across.area
    # Not so wide that it leans away, and no mere chamfer of what is shared.
    of_pair = np.bincount(shared.pair, shared.area, pairs)
    across = across.where((across.most <= LEAN * np.sqrt(area)) & (area > LEAN * of_pair[across.pair]))
    middles = shapely.get_coordinates(shapely.centroid(across.polygon))
    middle = across.frame.up(middles, np.arange(len(middles)))
    apart = [nearest(across.pair, middle, found, found.pair) for found in (shared, lines)]
    across = across.where(np.minimum(*apart) > 2 * across.most)
    width = np.full(pairs, np.inf)
    np.minimum.at(width, across.pair, across.most)
    return width


def _rings(polygons: Facing) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """First tangents of the polygons; of all their rings the polygon, the number of corners, and these in
    space, one ring after the other. Outer rings begin with the side along the tangent."""
    rings, polygon = shapely.get_rings(polygons.polygon, return_index=True)
    flat, ring = shapely.get_coordinates(rings, return_index=True)
    closing = np.diff(ring, append=ring[-1:] + 1) != 0
    side = (np.roll(flat, -1, axis=0) - flat)[~closing]
    flat, ring = flat[~closing], ring[~closing]
    count = np.bincount(ring, minlength=len(rings))
    outer = np.diff(polygon, prepend=-1) != 0
    length = np.hypot(*side.T)
    longest = np.zeros(len(polygons.pair))
    np.maximum.at(longest, polygon[ring], length * outer[ring])
    # Among sides of one length the one most along the first axis of the first block's face, then the second:
    # a choice that turns with the scene.
    as_long = np.flatnonzero(outer[ring] & (length >= longest[polygon[ring]] * (1 - 1e-6)))
    direction = side[as_long] / length[as_long, None]
    rank = np.round(direction @ [1.0, 1e-3], 6)
    best = np.lexsort((as_long, -rank, polygon[ring[as_long]]))
    best = best[np.unique(polygon[ring[as_long[best]]], return_index=True)[1]]
    frame, along, chosen = polygons.frame, direction[best], as_long[best]
    tangent = along[:, :1] * frame.u + along[:, 1:] * frame.v
    by = np.zeros_like(count)
    by[ring[chosen]] = chosen - (np.cumsum(count) - count)[ring[chosen]]
    return tangent, polygon, count, frame.up(flat[rolled(count, by)], polygon[ring])


def _points(
    joint_of: np.ndarray, of_rings: list[np.ndarray], lines: Touches
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joint, position and ring of each contact point, given the joint of each polygon
    and then of each line or point, and of all rings of polygons what :func:`_rings` gives."""
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

"""Joints from geometry: every length of edge that two blocks share, and every corner on an edge."""

from __future__ import annotations

import numpy as np

from masonry_opt.scene.contacts.floating import refuse_floating
from masonry_opt.scene.contacts.joints import Joints, joint_properties
from masonry_opt.scene.contacts.pairs import near_pairs, refuse_overlaps
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.touching import Edges, corners_on_edges, shared_edges


def find_joints(scene: Scene, geometry: Geometry, *, floating: bool = False) -> Joints:
    """Find the joints of a scene.

    Two blocks share a joint wherever their edges face each other and stay within the geometry's tolerance
    along ten tolerances or more, at any angle (along less, if they stay within a tenth of that length): its
    line and normal are those of the edges' bisector. Where a corner of one stands on an edge of the other,
    away from such a length, is a joint without length, normal to the edge. Two fixed blocks share no joint.

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
    pairs = near_pairs(scene, geometry)
    both_fixed = fixed[pairs].all(axis=1)
    refuse_overlaps(scene, geometry, pairs[~both_fixed])
    edges = Edges(*geometry.edges(), scene, geometry)
    along, gap = shared_edges(edges, pairs)
    joined, near = ~both_fixed[along.pair], np.flatnonzero(np.isfinite(gap) & ~both_fixed)
    fixed_pairs = len(np.unique(along.pair[~joined]))
    along = along.where(joined)
    points, corners = corners_on_edges(edges, pairs, along, np.flatnonzero(~both_fixed))
    found = along.by_pair(points)
    ends = np.column_stack([np.ones(len(found.pair), dtype=bool), found.length > 0])
    first, second = pairs[found.pair, 0], pairs[found.pair, 1]
    gaps = {(int(i), int(j)): float(width) for width, (i, j) in zip(gap[near], pairs[near], strict=True)}
    if not floating:
        refuse_floating(scene, geometry, first, second, gaps)
    return Joints(
        first=first,
        second=second,
        normal=found.normal,
        tangent=np.column_stack([found.normal[:, 1], -found.normal[:, 0]]),
        extent=found.length,
        point=np.stack([found.start, found.end], axis=1)[ends],
        joint=np.nonzero(ends)[0],
        ring=np.nonzero(ends)[0],
        **joint_properties(scene, first, second),
        fixed_pairs=fixed_pairs,
        gaps=gaps,
        without_normal=[(int(i), int(j)) for i, j in pairs[np.setdiff1d(corners, near)]],
    )

"""Joints from geometry: every length of edge that two blocks share, and every corner on an edge."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import scipy.sparse as sp
import shapely
from scipy.sparse.csgraph import connected_components

from masonry_opt.errors import CaseError, counted, rounded_up
from masonry_opt.scene.contacts.joints import Joints, joint_properties
from masonry_opt.scene.geometry import Geometry, raise_for
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.touching import Edges, corners_on_edges, reach, shared_edges

#: Most pairs of blocks near each other: this many, and so many more for each block. Side by side a block has
#: some six neighbours; of blocks that lie on one another each is a neighbour of all.
MOST_PAIRS, MOST_PAIRS_PER_BLOCK = 1_000_000, 40


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
    pairs = _near_pairs(scene, geometry)
    both_fixed = fixed[pairs].all(axis=1)
    _refuse_overlaps(scene, geometry, pairs[~both_fixed])
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
        refuse_floating(scene, first, second, gaps, partial(nearest_block, scene, geometry))
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


def _near_pairs(scene: Scene, geometry: Geometry) -> np.ndarray:
    """Index pairs (i < j) of blocks that touch or nearly do, sorted, shape (pairs, 2)."""
    tree = shapely.STRtree(geometry.polygons)
    far = reach(geometry.tolerance, np.sqrt(geometry.area))
    count = len(geometry.polygons)
    found: list[np.ndarray] = []
    pairs = 0
    for first in range(0, count, 100):
        some = slice(first, first + 100)
        near = tree.query(geometry.polygons[some], predicate="dwithin", distance=far[some]).T
        found.append(near + np.array([first, 0]))
        pairs += len(near)
        if pairs > MOST_PAIRS + MOST_PAIRS_PER_BLOCK * count:
            raise CaseError(
                f"{scene.origin}: blocks lie on one another: the first {min(first + 100, count)} have "
                f"{pairs} neighbours; give each block a place of its own"
            )
    both_ways = np.concatenate(found)
    return np.unique(np.sort(both_ways[both_ways[:, 0] != both_ways[:, 1]], axis=1), axis=0)


def refuse_floating(
    scene: Scene,
    first: np.ndarray,
    second: np.ndarray,
    gaps: Mapping[tuple[int, int], float],
    nearest: Callable[[int], str],
) -> None:
    """Raise CaseError if blocks touch nothing, or groups of blocks reach no support, given the two blocks of
    each joint, the largest width of each small gap by the two blocks beside it, and what to say of the
    nearest block of one that touches nothing and has no such gap. Ties and props hold blocks as joints do."""
    fixed = np.array([block.fixed for block in scene.blocks])
    count = len(fixed)
    joints, ground = len(first), int(fixed.argmax())  # which does not move, as a fixed block
    index = {block.name: number for number, block in enumerate(scene.blocks)}
    for strut in [*scene.ties, *scene.props]:
        ends = [index.get(name, ground) for name in strut.between]
        first, second = np.append(first, ends[0]), np.append(second, ends[1])
    touched = np.zeros(count, dtype=bool)
    touched[first] = touched[second] = True
    alone = np.flatnonzero(~touched & ~fixed)
    if len(alone):
        one = int(alone[0])
        faced = [(gap, sum(pair) - one) for pair, gap in gaps.items() if one in pair]
        gap, other = min(faced, default=(0.0, one))
        name = f"{scene.blocks[other].name!r}, which it faces, is up to"
        beside = how_far(name, gap, rounding(gap)) if faced else nearest(one)
        raise_for(alone, scene, f"touches no other block{beside}")
    links = sp.coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    _, group = connected_components(links, directed=False)
    loose = np.flatnonzero(~np.isin(group, group[fixed]))
    raise_for(loose, scene, "reaches no fixed block, neither itself nor through others: support it")
    if not joints:
        raise CaseError(f"{scene.origin}: ties and props hold every block: one must stand on another")


def nearest_block(scene: Scene, geometry: Geometry, block: int) -> str:
    """How far from a block that touches nothing the nearest is, and what to do."""
    distance = shapely.distance(geometry.polygons[block], geometry.polygons)
    distance[block] = np.inf
    nearest = int(distance.argmin())
    gap = float(distance[nearest])
    name = repr(scene.blocks[nearest].name)
    if gap <= geometry.tolerance:
        return f": it meets {name} corner on corner alone, where a joint needs an edge of either"
    small = gap <= reach(geometry.tolerance, np.sqrt(geometry.area[[block, nearest]].min()))
    return how_far(f"{name}, the nearest, is", gap, rounding(gap) if small else "")


def rounding(gap: float) -> str:
    """What to do about a gap that is so small that it may be rounding."""
    return f", or raise 'tolerance' to {rounded_up(gap, 2)} if coordinates were rounded"


def how_far(neighbour: str, gap: float, remedy: str) -> str:
    """What to say of a block that touches nothing: which one is how far, and what to do about that."""
    return f": {neighbour} {gap:.3g} away: close the gap{remedy}, or take the block away"


def _refuse_overlaps(scene: Scene, geometry: Geometry, pairs: np.ndarray) -> None:
    common = shapely.intersection(geometry.polygons[pairs[:, 0]], geometry.polygons[pairs[:, 1]])
    area, perimeter = shapely.area(common), shapely.length(common)
    # A convex piece is at least as deep as its area over half its perimeter, and at most π times that.
    mean = np.divide(2 * area, perimeter, out=np.zeros_like(area), where=area > 0)
    depth = np.zeros_like(area)
    for index in np.flatnonzero(mean > geometry.tolerance / np.pi):
        depth[index] = max(map(_least_width, shapely.get_parts(common[index])))
    deep = np.flatnonzero(depth > geometry.tolerance)
    if len(deep):
        worst = deep[np.argmax(area[deep])]
        one, other = (repr(scene.blocks[index].name) for index in pairs[worst])
        middle = shapely.get_coordinates(shapely.centroid(common[worst]))[0] + geometry.origin
        x, y = (f"{0.0 if abs(value) <= geometry.tolerance else value:.6g}" for value in middle)
        # Rounding leaves slivers; what is deeper is no matter of tolerance.
        shallow = depth[worst] <= reach(geometry.tolerance, np.sqrt(geometry.area[pairs[worst]].min()))
        most = rounded_up(float(depth[deep].max()), 2)
        rounded = f", or raise 'tolerance' to {most} if their coordinates were rounded" if shallow else ""
        others = len(deep) - 1
        more = f" ({counted(others, 'more pair')} overlap{'s' if others == 1 else ''})" if others else ""
        raise CaseError(
            f"{scene.origin}: blocks {one} and {other} overlap over an area of {area[worst]:.6g} round "
            f"({x}, {y}), {depth[worst]:.3g} deep: move them apart{rounded}{more}"
        )


def _least_width(piece: shapely.Geometry) -> float:
    """The least distance of parallel lines that enclose a piece: how far apart its blocks must be moved."""
    corners = shapely.get_coordinates(shapely.convex_hull(piece))
    sides = np.diff(corners, axis=0)
    if len(sides) < 3:
        return 0.0
    across = np.column_stack([-sides[:, 1], sides[:, 0]]) / np.hypot(*sides.T)[:, None]
    return float(np.ptp(corners @ across.T, axis=0).min())

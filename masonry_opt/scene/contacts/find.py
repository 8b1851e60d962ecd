"""Joints from geometry: what sides of two blocks share, and where corners and edges touch beside that."""

from collections.abc import Callable, Mapping

import numpy as np
import shapely

from masonry_opt.errors import CaseError, counted, rounded_up
from masonry_opt.scene.contacts import edges, faces
from masonry_opt.scene.contacts.joints import Joints, joint_properties, outline_sides
from masonry_opt.scene.contacts.sides import LEAN, BlockCorners, Facing, Touches, nearest
from masonry_opt.scene.geometry import Common, Extents, geometry, raise_for
from masonry_opt.scene.rows import linked, ranges
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.shapes import shapes
from masonry_opt.scene.space.surfaces import place

#: By dimension: shapes of blocks, what of them faces what, and what touches beside it.
_KINDS: dict[int, tuple[Callable[[Scene], Extents], Callable[..., Facing], Callable[..., BlockCorners]]] = {
    2: (geometry, edges.facing, edges.PlaneCorners),
    3: (shapes, faces.facing, faces.SolidCorners),
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

    Raises CaseError if blocks overlap, a movable block touches nothing or reaches no support (unless they are
    ``floating``, to show them), an exception names two blocks that do not touch, or there are more pairs to
    compare than memory holds.
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
    across = _near_misses(shared, beside, across, len(pairs))
    gaps: dict[tuple[int, int], float] = {}
    for (i, j), width in zip(pairs[across.pair].tolist(), across.most.tolist(), strict=True):
        gaps[i, j] = min(gaps.get((i, j), np.inf), width)
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
        refuse_floating(scene, shapes, first, second, gaps)
    return Joints(
        first=first,
        second=second,
        normal=np.concatenate([shared.normal, beside.normal])[order],
        tangent=tangent[order],
        extent=np.concatenate([shared.extent, np.zeros(len(beside.pair))])[order],
        middle=np.concatenate([shared.middle, (beside.start + beside.end) / 2])[order],
        point=point[ranges((np.cumsum(count) - count)[rings], count[rings])],
        joint=np.repeat(joint[rings], count[rings]),
        ring=np.repeat(np.arange(len(rings)), count[rings]),
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


#: Most pairs of blocks near each other: this many, and so many more for each block. Side by side a block has
#: some six neighbours; of blocks that lie on one another each is a neighbour of all.
_MOST_PAIRS, _MOST_PAIRS_PER_BLOCK = 1_000_000, 40


def near_pairs(scene: Scene, shapes: Extents) -> np.ndarray:
    """Index pairs (i < j) of blocks whose boxes touch or nearly do, sorted, shape (pairs, 2). Raises
    CaseError if there are more than memory holds."""
    (low, high), far = shapes.boxes, shapes.reach
    # Seen along the axis, if there are three, where blocks hide one another least.
    share = (high - low) / (high.max(axis=0) - low.min(axis=0))
    depth = [np.prod(np.delete(share, axis, axis=1), axis=1).sum() for axis in range(share.shape[1])]
    across = np.sort(np.argsort(depth, kind="stable")[-2:])
    tree = shapely.STRtree(shapely.box(*low[:, across].T, *high[:, across].T))
    grown = shapely.box(*(low[:, across] - far[:, None]).T, *(high[:, across] + far[:, None]).T)
    count = len(low)
    found: list[np.ndarray] = []
    pairs = 0
    for first in range(0, count, 100):
        i, j = tree.query(grown[first : first + 100])
        i += first
        kept = i < j
        i, j = i[kept], j[kept]
        apart = np.maximum(low[i] - high[j], low[j] - high[i]).max(axis=1)
        near = apart <= np.minimum(far[i], far[j])
        found.append(np.column_stack([i[near], j[near]]))
        pairs += len(found[-1])
        if pairs > _MOST_PAIRS + _MOST_PAIRS_PER_BLOCK * count:
            raise CaseError(
                f"{scene.origin}: blocks lie on one another: the first {min(first + 100, count)} have "
                f"{pairs} neighbours; give each block a place of its own"
            )
    every = np.concatenate(found)
    return every[np.lexsort((every[:, 1], every[:, 0]))]


def refuse_overlaps(scene: Scene, shapes: Extents, pairs: np.ndarray) -> None:
    """Raise CaseError if blocks of the pairs overlap by more than the contact tolerance."""
    (low, high), (i, j) = shapes.boxes, pairs.T
    inside = np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])
    pairs = pairs[(inside > shapes.contact_tolerance).all(axis=1)]
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
    most = rounded_up(max(piece.depth for pieces in found.values() for piece in pieces), 2)
    # Rounding leaves slivers; what is deeper is no matter of tolerance.
    remedy = shapes.remedy.format(most)
    if size[worst] > shapes.inside * shapes.size[pairs[worst]].min():
        remedy = ", or leave one out: one lies within the other"
    elif deepest.depth <= shapes.reach[pairs[worst]].min():
        remedy = f", or raise 'tolerance' to {most} if their coordinates were rounded"
    others = len(found) - 1
    least = "at least " if len(found) == shapes.enough else ""
    more = f" ({least}{counted(others, 'more pair')} overlap{'s' if others == 1 else ''})" if others else ""
    raise CaseError(
        f"{scene.origin}: blocks {names[0]} and {names[1]} overlap {shapes.within} of {size[worst]:.6g} "
        f"round {place(deepest.middle + shapes.origin, shapes.contact_tolerance)}, {deepest.depth:.3g} deep: "
        f"move them apart{remedy}{more}"
    )


def refuse_floating(
    scene: Scene,
    shapes: Extents,
    first: np.ndarray,
    second: np.ndarray,
    gaps: Mapping[tuple[int, int], float],
) -> None:
    """Raise CaseError if blocks touch nothing, or groups of blocks reach no support, given the two blocks of
    each joint, and the largest width of each small gap by the blocks beside it. Ties and props hold too."""
    fixed, count = scene.fixed, len(scene.blocks)
    joints, ground = len(first), int(fixed.argmax())  # which does not move, as a fixed block
    index = {block.name: number for number, block in enumerate(scene.blocks)}
    for strut in [*scene.ties, *scene.props]:
        ends = [index.get(name, ground) for name in strut.between]
        first, second = np.append(first, ends[0]), np.append(second, ends[1])
    touched = np.zeros(count, dtype=bool)
    touched[first] = touched[second] = True
    alone = np.flatnonzero(~touched & ~fixed)
    if len(alone):
        raise_for(alone, scene, f"touches no other block: {_nearest(scene, shapes, int(alone[0]), gaps)}")
    group = linked(count, first, second)
    loose = np.flatnonzero(~np.isin(group, group[fixed]))
    raise_for(loose, scene, "reaches no fixed block, neither itself nor through others: support it")
    if not joints:
        raise CaseError(f"{scene.origin}: ties and props hold every block: one must stand on another")


def _nearest(scene: Scene, shapes: Extents, block: int, gaps: Mapping[tuple[int, int], float]) -> str:
    """How far from a block that touches nothing the one that it faces is, else the nearest; and a remedy."""
    remedy = ""
    if faced := [(gap, sum(pair) - block) for pair, gap in gaps.items() if block in pair]:
        (gap, other), which = min(faced), "which it faces, is up to"
    else:
        (other, gap), which = shapes.nearest(block), "the nearest, is"
    name, both = repr(scene.blocks[other].name), [block, other]
    if not faced and gap <= shapes.tolerance:
        return f"it meets {name} {shapes.meeting} of either"
    if faced or gap <= shapes.reach[both].min():
        remedy = f", or raise 'tolerance' to {rounded_up(gap, 2)} if coordinates were rounded"
    elif gap <= shapes.mortar * shapes.width[both].min():
        remedy = f", or raise 'contact_tolerance' to {rounded_up(gap, 2)} if mortar was left out"
    return f"{name}, {which} {gap:.3g} away: close the gap{remedy}, or take the block away"

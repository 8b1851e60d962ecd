"""Alignment of contacts: planes that agree within the accuracy of a drawing become equal.

In a drawing, the position of a point is uncertain by the tolerance, and the direction of an edge is uncertain
by the tolerance divided by the length of the edge. Even small errors matter between rigid blocks. For
example, two bed joints of a block that differ in direction by 1e-5 form a wedge: the block cannot slide along
both joints without opening one of them. Errors of drawings can therefore change load factors by up to a
factor of two. Contacts are aligned in four steps:

1. *Planes.* A plane (for blocks in the plane: a line) is assigned to each joint, and to each end or side of
   the joint.
2. *Directions.* Planes that are parallel within their accuracies become exactly parallel, if blocks connect
   their joints. Planes that are perpendicular within their accuracies become exactly perpendicular.
3. *Positions.* Parallel planes are merged if their distances from the origin agree within the tolerance.
4. *Contact points* are moved to the intersections of their planes.

No plane rotates by more than the accuracy of its own edges. Therefore the joints of an arch, which differ
slightly in direction, remain distinct. Coordinates do not change if the planes of a drawing agree up to
rounding. Equilibrium is exact for the aligned contacts.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import hypot
from operator import mul

import numpy as np

from masonry_opt.scene.contacts.drawn import ContactPlanes, DrawnContacts, Lists
from masonry_opt.scene.rows import chunks, combine, dots, lengths, linked


@dataclass(frozen=True)
class AlignmentSettings:
    """Settings of the alignment of contacts."""

    #: Largest angle, in radians, by which the alignment rotates a plane. With a smaller value, short edges of
    #: coarse surveys are not aligned.
    most_turn: float = 0.02
    #: Number of fits of plane directions to the contact points. Each fit merges more planes of one bed joint.
    #: With fewer fits, a long bed joint may keep several planes.
    fits: int = 4
    #: Largest movement of a contact point, relative to the tolerance. Planes at a sharp angle may intersect
    #: farther away. The point then moves only onto one of these planes, if possible the plane of its joint.
    most_shift: float = 2.0
    #: Largest number of joints of a block whose joints are compared in pairs before the alignment. The
    #: comparison excludes planes that cannot be parallel or perpendicular to another joint of their two
    #: blocks. A larger value needs more memory. With a smaller value, fewer planes of rubble are excluded, so
    #: that the alignment needs more time.
    most_neighbours: int = 100
    #: Joints linked to a plane (see ``_Links``) are searched from block to block. If the search finds more
    #: than this number, all joints of the scene are searched at once instead. With a larger value, planes
    #: with many linked joints take longer. With a smaller value, planes with few linked joints take longer.
    most_one_by_one: int = 64


DEFAULT_SETTINGS = AlignmentSettings()

#: A direction that must be perpendicular to two other directions is their cross product, if the sine of the
#: angle between these two is at least this value. Otherwise it is made perpendicular to only one of the two.
#: With a smaller value, cross products amplify errors. With a larger value, fewer directions are made
#: perpendicular to both.
_SINE_OF_DISTINCT_DIRECTIONS = 0.1

#: The intersection of planes is computed with a pseudo-inverse of their unit normals. Singular values below
#: this fraction of the largest singular value count as zero. For two planes, the ratio of the singular values
#: is the tangent of half their angle, so they are intersected only if their angle is at least 11.4° (sine
#: 0.2). With a smaller value, errors are amplified. With a larger value, more points are moved onto a mean of
#: their planes.
_LEAST_SPREAD_OF_NORMALS = 0.1


@dataclass(frozen=True)
class AlignedContacts:
    """Joints and contact points after alignment."""

    normal: np.ndarray  #: unit normal of each joint, shape (joints, dim)
    point: np.ndarray  #: contact points, shape (points, dim)
    turn: np.ndarray  #: angle in radians by which each joint was rotated, shape (joints,)
    shift: np.ndarray  #: distance by which each contact point was moved, shape (points,)


def aligned(contacts: DrawnContacts, settings: AlignmentSettings = DEFAULT_SETTINGS) -> AlignedContacts:
    """Align the contacts of a drawing, to correct its small errors.

    Joints that are nearly parallel become parallel, and joints that are nearly perpendicular become
    perpendicular. Contact points near a common line (in space: plane) are moved onto it.
    """
    joints, points = len(contacts.normal), len(contacts.point)
    if joints < 2:
        return AlignedContacts(contacts.normal, contacts.point, np.zeros(joints), np.zeros(points))
    planes = contacts.planes()
    parallel = _parallel_planes(contacts, settings, planes)
    groups = [Group(contacts, settings, planes, members) for members in parallel]
    square = _square_pairs(groups, planes)
    _make_square(groups, square)
    if any(group.differs for group in groups):
        for _ in range(settings.fits):
            for group in groups:
                group.fit()
            _make_square(groups, square)
    direction = planes.direction.copy()
    place = np.full(len(planes.direction), np.nan)
    for group in _moved_groups(contacts, planes, groups):
        group.settle(direction, place)
    normal = direction[: len(contacts.normal)]
    turn = np.where((normal == contacts.normal).all(axis=1), 0.0, _sines(normal, contacts.normal))
    point = _move_points(contacts, settings, planes, direction, place)
    return AlignedContacts(normal, point, turn, lengths(point - contacts.point))


class Group:
    """Group of planes of several joints; the alignment makes all planes of the group parallel."""

    def __init__(
        self, contacts: DrawnContacts, settings: AlignmentSettings, planes: ContactPlanes, members: np.ndarray
    ) -> None:
        self.members = members
        self._contacts, self._planes, self._normals = contacts, planes, planes.direction[members]
        self._accuracy = np.minimum(planes.accuracy[members], settings.most_turn)
        self.accuracy = float(self._accuracy.min())
        self._rounding = contacts.rounding / contacts.tolerance * planes.accuracy[members]
        # If all planes agree up to rounding, the direction of the most accurate plane is used unchanged.
        self.direction = self._normals[0]
        self.differs = bool((_sines(self._normals, self.direction) > self._rounding).any())
        if self.differs:
            self.turn_to(_fit_direction(self._normals, self._accuracy))

    @cached_property
    def _points(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the contact points on the group's planes: index of the plane, and coordinates of the point.

        The index refers to ``members``. A point that is on several planes is repeated.
        """
        number, points = self._planes.by_plane.where(self.members)
        return number, self._contacts.point[points]

    def turn_to(self, direction: np.ndarray) -> None:
        """Replace the group's direction by a new direction if they differ by more than rounding errors.

        The sign of the new direction is chosen to agree with the old direction.
        """
        if _sines(direction[None], self.direction)[0] > self._rounding.min():
            self.direction, self.differs = direction * np.sign(direction @ self.direction), True

    def fit(self) -> None:
        """Fit the group's direction to the unit normals of its planes and to the contact points on them.

        A group whose planes agree up to rounding is not changed.
        """
        if not self.differs:
            return
        number, positions = self._points
        plane = self._common_planes()[number]
        count = np.bincount(plane)
        middle = np.column_stack([np.bincount(plane, x) / count for x in positions.T])
        offset = (positions - middle[plane]) / self._contacts.tolerance
        self.turn_to(_fit_direction(self._normals, self._accuracy, offset.T @ offset))

    def settle(self, direction: np.ndarray, place: np.ndarray) -> None:
        """Store the new direction, and the new distance from the origin, of each plane that moves."""
        sign = np.sign(self._normals @ self.direction)
        turns = _sines(self._normals, self.direction) <= self._accuracy
        if self.differs:
            direction[self.members[turns]] = sign[turns, None] * self.direction
        number, positions = self._points
        height, of_plane = positions @ self.direction, self._common_planes()
        plane = of_plane[number]
        mean = np.bincount(plane, height) / np.bincount(plane)
        spread = np.zeros(len(mean))
        np.maximum.at(spread, plane, np.abs(height - mean[plane]))
        moves = turns & (spread[of_plane] > self._contacts.rounding)
        place[self.members[moves]] = (sign * mean[of_plane])[moves]

    def _common_planes(self) -> np.ndarray:
        """Return the index of the common plane to which each plane of the group belongs, shape (members,)."""
        number, positions = self._points
        height = np.bincount(number, positions @ self.direction)
        return _group_values(height / np.bincount(number), self._contacts.tolerance)


def _moved_groups(contacts: DrawnContacts, planes: ContactPlanes, groups: list[Group]) -> list[Group]:
    """Return the groups of planes that the alignment moves or rotates by more than rounding errors.

    All other groups do not change. In an exact drawing no group changes.
    """
    if not groups:
        return []
    members = np.concatenate([group.members for group in groups])
    owner = np.repeat(np.arange(len(groups)), [len(group.members) for group in groups])
    number, points = planes.by_plane.where(members)
    direction = np.stack([group.direction for group in groups])[owner]
    height = dots(contacts.point[points], direction[number])
    mean = np.bincount(number, height) / np.bincount(number)
    # Sort the planes of each group by their distance from the origin.
    order = np.lexsort((mean, owner))
    # A new common plane begins where two neighbouring distances differ by more than the tolerance.
    begins = (np.diff(owner[order]) != 0) | (np.diff(mean[order]) > contacts.tolerance)
    run = np.empty(len(members), dtype=int)
    run[order] = np.cumsum(np.append(0, begins))
    lowest, highest = np.full(len(members), np.inf), np.full(len(members), -np.inf)
    np.minimum.at(lowest, run[number], height)
    np.maximum.at(highest, run[number], height)
    is_moved = np.array([group.differs for group in groups])
    is_moved[owner[(highest - lowest)[run] > contacts.rounding]] = True
    return [group for group, moves in zip(groups, is_moved.tolist(), strict=True) if moves]


def _parallel_planes(
    contacts: DrawnContacts, settings: AlignmentSettings, planes: ContactPlanes
) -> Iterator[np.ndarray]:
    """Find groups of planes of different joints that are parallel within the drawing's accuracy.

    The most accurate plane that is not yet in a group, the leader, begins a new group. A plane can belong to
    the group if blocks and joints connect its joint to the leader's joint, and if these joints are parallel
    or perpendicular to the leader. Planes that would rotate by more than their accuracy leave the group, the
    plane with the largest rotation first.
    """
    accuracy = np.minimum(planes.accuracy, settings.most_turn)
    links = _Links(contacts, settings, accuracy[: len(contacts.normal)])
    is_free = _has_partner(contacts, settings, planes)
    joint_of, planes_of = planes.joint.tolist(), planes.by_joint
    for leader in np.argsort(accuracy, kind="stable").tolist():
        if not is_free[leader]:
            continue
        is_free[leader] = False
        direction = planes.direction[leader]
        joints = links.linked_to(joint_of[leader], direction, float(accuracy[leader]))
        if len(joints) == 1:
            continue
        _, members = planes_of.where(joints)
        members = members[is_free[members]]
        sine = _sines(planes.direction[members], direction)
        is_parallel = sine <= accuracy[leader] + accuracy[members]
        members = np.append(leader, members[is_parallel])
        # The leader is the most accurate plane. If all planes are parallel to the leader within a quarter of
        # the leader's accuracy, no plane rotates by more than its own accuracy. The loop below is then
        # skipped.
        all_agree = sine[is_parallel].max(initial=0.0) <= accuracy[leader] / 4
        while len(members) > 1 and not all_agree:
            mean_direction = _fit_direction(planes.direction[members], accuracy[members])
            excess = _sines(planes.direction[members], mean_direction) / accuracy[members]
            if excess.max() <= 1:
                break
            members = np.delete(members, int(excess.argmax()))
        is_free[members] = False
        if len(np.unique(planes.joint[members])) > 1:
            yield members


class _Links:
    """Search for the joints that chains of parallel or perpendicular joints link to a plane.

    A joint is *linked* to a plane if a chain of blocks and joints connects it to the joint of the plane, and
    if all joints of the chain are parallel or perpendicular to the plane.
    """

    def __init__(self, contacts: DrawnContacts, settings: AlignmentSettings, accuracy: np.ndarray) -> None:
        self._contacts, self._accuracy, self._most = contacts, accuracy, settings.most_one_by_one
        self._crowded = settings.most_neighbours
        # Lists are faster than arrays if few joints are linked.
        self._ends, self._normals = contacts.ends.tolist(), contacts.normal.tolist()
        self._accuracies = accuracy.tolist()

    def linked_to(self, joint: int, direction: np.ndarray, accuracy: float) -> np.ndarray:
        """Return the indices of the joints that a chain of parallel or perpendicular joints links to a plane.

        A joint is linked to a plane if all joints of the chain are parallel or perpendicular to the plane.
        The plane belongs to the joint with index ``joint``, which is one of the returned joints. The plane
        has the given direction (unit normal) and accuracy. The indices are in ascending order.
        """
        joints = self._search_joints(joint, direction, accuracy)
        if joints is not None:
            return joints
        is_aligned = _deviations(self._contacts.normal, direction) <= accuracy + self._accuracy
        is_aligned[joint] = True
        return _component_of(joint, np.flatnonzero(is_aligned), self._contacts.ends)

    def _search_joints(self, joint: int, direction: np.ndarray, accuracy: float) -> np.ndarray | None:
        """Search from block to block; return the joints found, or None if there are too many joints."""
        joints = [joint]
        examined_joints = {joint}
        examined_blocks: set[int] = set()
        axis = direction.tolist()
        # Breadth-first search: the list ``joints`` grows during the loop.
        for current_joint in joints:
            for block in self._ends[current_joint]:
                if block in examined_blocks:
                    continue
                examined_blocks.add(block)
                for candidate in self._candidates(block, direction, accuracy):
                    if candidate in examined_joints:
                        continue
                    examined_joints.add(candidate)
                    if _deviation(self._normals[candidate], axis) <= accuracy + self._accuracies[candidate]:
                        joints.append(candidate)
                if len(joints) > self._most:
                    return None
        return np.array(sorted(joints))

    def _candidates(self, block: int, direction: np.ndarray, accuracy: float) -> list[int]:
        """Return the joints of a block that may be parallel or perpendicular to a plane with a given normal.

        Other joints are left out only if the block has many joints.
        """
        of_block = self._contacts.joints_of_block
        first, count = of_block.first[block], of_block.count[block]
        joints = of_block.item[first : first + count]
        if count > self._crowded:
            sine = _deviations(self._contacts.normal[joints], direction)
            # Select joints coarsely, with twice the permitted deviation. The caller compares each selected
            # joint with the permitted deviation itself.
            joints = joints[sine <= 2 * (accuracy + self._accuracy[joints])]
        candidates: list[int] = joints.tolist()
        return candidates


def _has_partner(contacts: DrawnContacts, settings: AlignmentSettings, planes: ContactPlanes) -> np.ndarray:
    """Return a mask of the planes that may be parallel or perpendicular to another joint, shape (planes,).

    The other joint, called partner, belongs to the same block. For planes of blocks with very many joints,
    the mask is True without a comparison.
    """
    of_block = contacts.joints_of_block
    is_crowded = of_block.count > settings.most_neighbours
    has_partner: np.ndarray = is_crowded[contacts.ends].any(axis=1)[planes.joint]
    for side in range(2):
        block = contacts.ends[planes.joint, side]
        remaining_planes = np.flatnonzero(~has_partner & ~is_crowded[block])
        for chunk in chunks(of_block.count[block[remaining_planes]]):
            plane = remaining_planes[chunk]
            number, partner = of_block.where(block[plane])
            plane = plane[number]
            sine = _deviations(contacts.normal[partner], planes.direction[plane])
            # Accept deviations of up to three times the sum of both accuracies. The planes of a group may
            # deviate from each other by more than this sum, because each plane is compared only with the
            # first plane of the group.
            is_near = sine <= 3 * (planes.accuracy[plane] + contacts.accuracy[partner])
            has_partner[plane[is_near & (partner != planes.joint[plane])]] = True
    return has_partner


def _component_of(joint: int, joints: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return the indices of the joints in the connected component of a given joint, in ascending order.

    Only the joints in ``joints``, which are in ascending order, connect blocks. ``ends`` has both blocks of
    each joint.
    """
    count, blocks = len(joints), int(ends.max()) + 1
    group = linked(count + blocks, np.tile(np.arange(count), 2), count + ends[joints].T.ravel())
    return joints[group[:count] == group[np.searchsorted(joints, joint)]]


def _square_pairs(groups: list[Group], planes: ContactPlanes) -> list[list[int]]:
    """Return, for each group of planes, the groups that are perpendicular to the planes of this group.

    Two groups are compared if they have planes of a common joint. Deviations within the drawing's accuracy
    are allowed.
    """
    of_plane = np.full(len(planes.direction), -1)
    for number, group in enumerate(groups):
        of_plane[group.members] = number
    by_joint = planes.by_joint
    _, first, second = combine(by_joint.first, by_joint.count, by_joint.first, by_joint.count)
    first, second = of_plane[by_joint.item[first]], of_plane[by_joint.item[second]]
    is_pair = (first >= 0) & (second >= 0) & (first != second)
    pairs: list[list[int]] = [[] for _ in groups]
    for code in np.unique(first[is_pair] * len(groups) + second[is_pair]).tolist():
        i, j = divmod(code, len(groups))
        if abs(groups[i].direction @ groups[j].direction) <= groups[i].accuracy + groups[j].accuracy:
            pairs[i].append(j)
    return pairs


def _make_square(groups: list[Group], pairs: list[list[int]]) -> None:
    """Rotate groups of planes so that paired groups are perpendicular to each other.

    The most accurate group is not rotated. In order of accuracy, every other group is rotated until it is
    perpendicular to the more accurate groups paired with it (in space, to at most two of them).
    """
    order = sorted(range(len(groups)), key=lambda number: groups[number].accuracy)
    rank = {number: position for position, number in enumerate(order)}
    for number, own_rank in rank.items():
        partners = [groups[partner].direction for partner in pairs[number] if rank[partner] < own_rank]
        if not partners:
            continue
        group, first = groups[number], partners[0]
        direction = group.direction - (group.direction @ first) * first
        if len(first) == 3:
            candidates = [np.cross(first, partner) for partner in partners[1:]]
            direction = max(candidates, key=np.hypot.reduce, default=direction)
            if np.hypot.reduce(direction) < _SINE_OF_DISTINCT_DIRECTIONS:
                direction = group.direction - (group.direction @ first) * first
        group.turn_to(direction / np.hypot.reduce(direction))


def _group_values(values: np.ndarray, tolerance: float) -> np.ndarray:
    """Divide values into groups of nearly equal values, and return the index of each value's group.

    The values are sorted and divided into runs, in which neighbours differ by at most the tolerance. A run
    that is not longer than the tolerance is a group. In a longer run, the value with the most other values
    within the tolerance forms a group with these values. The rest of the run is divided in the same manner.
    """
    order = np.argsort(values, kind="stable")
    rising = values[order]
    run = np.cumsum(np.diff(rising, prepend=rising[:1]) > tolerance)
    count = np.bincount(run)
    last = np.cumsum(count) - 1
    first = last - count + 1
    number, groups = run.copy(), len(count)
    for long_run in np.flatnonzero(rising[last] - rising[first] > tolerance).tolist():
        indices = np.arange(first[long_run], last[long_run] + 1)
        while len(indices):
            low = np.searchsorted(rising[indices], rising[indices] - tolerance, "left")
            high = np.searchsorted(rising[indices], rising[indices] + tolerance, "right")
            # The leader is the value with the most neighbours within the tolerance. If several values have
            # equally many, choose the value whose neighbours span the smallest range. The order of the values
            # then has no effect.
            leader = np.lexsort((rising[indices][high - 1] - rising[indices][low], low - high))[0]
            members = np.arange(low[leader], high[leader])
            number[indices[members]] = groups
            groups += 1
            indices = np.delete(indices, members)
    group_of_value = np.empty_like(number)
    group_of_value[order] = np.unique(number, return_inverse=True)[1]
    return group_of_value


def _move_points(
    contacts: DrawnContacts,
    settings: AlignmentSettings,
    planes: ContactPlanes,
    direction: np.ndarray,
    place: np.ndarray,
) -> np.ndarray:
    """Move contact points to the intersections of the planes on which they lie, and return the points.

    A point that would move too far moves only onto one of its planes, if possible the plane of its joint.
    ``direction`` is the unit normal of each plane. ``place`` is the distance of each plane from the origin,
    or NaN for a plane that does not move.
    """
    is_moved = np.isfinite(place[planes.plane])
    of_point = Lists.of(planes.point[is_moved], planes.plane[is_moved], len(contacts.point))
    shift = np.zeros_like(contacts.point)
    for count in np.unique(of_point.count[of_point.count > 0]).tolist():
        points = np.flatnonzero(of_point.count == count)
        plane = of_point.where(points)[1].reshape(-1, count)
        normals = direction[plane]
        offset = place[plane] - np.einsum("pij,pj->pi", normals, contacts.point[points])
        full_shift = np.einsum("pij,pj->pi", np.linalg.pinv(normals, rcond=_LEAST_SPREAD_OF_NORMALS), offset)
        is_far = lengths(full_shift) > settings.most_shift * contacts.tolerance
        shift[points] = np.where(is_far[:, None], offset[:, :1] * normals[:, 0], full_shift)
    return contacts.point + shift


def _fit_direction(
    directions: np.ndarray, accuracy: np.ndarray, scatter: np.ndarray | float = 0.0
) -> np.ndarray:
    """Fit a direction to unit vectors, regardless of their signs, by least squares; return the direction.

    A vector is weighted by the inverse square of its accuracy. ``scatter``, shape (dim, dim), is the scatter
    matrix of points, in units of the tolerance, on planes to which the direction should be normal.
    """
    weight = accuracy[:, None] ** -2.0
    misfit = weight.sum() * np.eye(directions.shape[1]) - (weight * directions).T @ directions + scatter
    return np.asarray(np.linalg.eigh(misfit)[1][:, 0])


def _sines(directions: np.ndarray, references: np.ndarray) -> np.ndarray:
    """Return the sine of the angle between each pair of unit vectors, shape (rows,).

    ``references`` is one vector for all rows, or one vector for each row.
    """
    cosine = (directions * references).sum(axis=1)
    return lengths(directions - cosine[:, None] * references)


def _deviation(vector: list[float], reference: list[float]) -> float:
    """Return the sine or the absolute cosine of the angle of two unit vectors, whichever is smaller.

    The result is zero if the vectors are parallel or perpendicular.
    """
    cosine = sum(map(mul, vector, reference))
    sine = hypot(*(a - cosine * b for a, b in zip(vector, reference, strict=True)))
    return min(abs(cosine), sine)


def _deviations(directions: np.ndarray, references: np.ndarray) -> np.ndarray:
    """Return, for each pair of unit vectors, the sine or absolute cosine of their angle, shape (rows,).

    The smaller of the two numbers is returned. It is zero if the vectors are parallel or perpendicular.
    ``references`` is one vector for all rows, or one vector for each row.
    """
    return np.minimum(np.abs((directions * references).sum(axis=1)), _sines(directions, references))


def square_to(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Project vectors onto the planes perpendicular to the normals, and return unit vectors."""
    projection = vectors - dots(vectors, normal)[:, None] * normal
    return projection / lengths(projection)[:, None]

"""Blocks as meshes: corners joined, faces turned one way, faces of one plane merged."""

from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import cKDTree

from masonry_opt.scene.rows import linked, spaces, steps_round, turned
from masonry_opt.scene.space.faces import place

_OFF_TRIANGLE = 4.0  #: Tolerances that triangles of a polygon that is flat lie off the plane of one of them.
_ALIKE = 0.9  #: Cosine of the angle up to which faces may be of one plane.
_SAME_ANGLE = 1e-4  #: Angle between faces round an edge that is rounding, in radians.

Edge = tuple[int, int]


@dataclass(frozen=True)
class Mesh:
    """A block by its corners, shape (points, 3), and the corners of each face, in order round it; whether it
    is a support; and the layers that it is drawn on."""

    name: str
    points: np.ndarray
    faces: list[list[int]]
    fixed: bool = False
    layers: str = ""

    @property
    def flat(self) -> bool:
        """Whether it is a polygon without thickness: one face."""
        return len(self.faces) == 1


@dataclass(frozen=True)
class Side:
    """A plane piece of a block's surface: its outer ring of corners, then holes, the surface to the left seen
    from outside; a point and unit normal of its plane; its area, and this over half the length round it."""

    rings: list[list[int]]
    base: np.ndarray
    normal: np.ndarray
    area: float
    width: float

    def flat(self, points: np.ndarray) -> list[np.ndarray]:
        """The rings in the plane's own axes, each of shape (corners, 2)."""
        return [(points[ring] - self.base) @ across(self.normal).T for ring in self.rings]


@dataclass(frozen=True)
class MeshSolid:
    """Corners, shape (points, 3), and the plane sides between them."""

    points: np.ndarray
    sides: list[Side]

    @property
    def volume(self) -> float:
        """Inside the sides, if they close."""
        # Seen from the middle of a side, which lies in no other: one that is missing is missed.
        middle = self.sides[0].base
        return sum(side.area * float((side.base - middle) @ side.normal) for side in self.sides) / 3

    def unclosed(self) -> tuple[np.ndarray, np.ndarray] | None:
        """The ends of an edge that sides have more often in one direction than in the other, if any."""
        ways = Counter(edge for side in self.sides for ring in side.rings for edge in steps_round(ring))
        for (tail, tip), count in ways.items():
            if count != ways[tip, tail]:
                return self.points[tail], self.points[tip]
        return None

    def convex(self, tolerance: float) -> bool:
        """Whether it is convex, but for the tolerance; sides no wider than that have no plane."""
        used = self.points[np.unique([corner for side in self.sides for corner in side.rings[0]])]
        wide = [side for side in self.sides if side.width > tolerance]
        convex = all(((used - side.base) @ side.normal).max() <= tolerance for side in wide)
        return convex and all(len(side.rings) == 1 for side in self.sides)


def across(normal: np.ndarray) -> np.ndarray:
    """Two unit vectors in the plane of a unit normal, shape (2, 3), right-handed with it in this order."""
    u = _cross(normal, np.eye(3)[np.abs(normal).argmin()])
    u /= np.linalg.norm(u)
    return np.array([u, _cross(normal, u)])


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """As np.cross, which is slow of few vectors."""
    return one[..., [1, 2, 0]] * other[..., [2, 0, 1]] - one[..., [2, 0, 1]] * other[..., [1, 2, 0]]


def area_vector(corners: np.ndarray) -> np.ndarray:
    """Normal of a polygon in space as long as its area (Newell's formula), shape (3,)."""
    around = corners[1:] - corners[0]
    return _cross(around[:-1], around[1:]).sum(axis=0) / 2


def polyhedron(mesh: Mesh, tolerance: float) -> MeshSolid:
    """The block with corners nearer than the tolerance joined, faces turned outwards, those that are not flat
    cut into triangles, and those of one plane merged. Raises ValueError if no face is left."""
    points, faces = mesh.points, outwards(mesh.points, _joined(mesh.points, mesh.faces, tolerance))
    faces = [flat for face in faces for flat in _flat(points, face, tolerance)]
    if not faces:
        raise ValueError(f"is smaller than the tolerance of {tolerance:.3g}: is it drawn in another unit?")
    return MeshSolid(points, _sides(points, faces, tolerance))


def refuse_holes(mesh: Mesh, tolerance: float) -> None:
    """Raise ValueError, with the place, if a hole wider than the tolerance is in the surface of a block.

    An edge that one face alone has borders a hole, unless other such edges lie along its whole length. They
    do where the corners of one face lie on an edge of another, and in gaps narrower than the tolerance.
    """
    faces = _joined(mesh.points, mesh.faces, tolerance)
    open_edges = np.array([edge for edge, having in _by_edge(faces).items() if len(having) == 1], dtype=int)
    ends = mesh.points[open_edges.reshape(-1, 2)]
    for edge, others in zip(ends, _neighbours(ends, tolerance), strict=True):
        if not _is_covered(edge, ends[others], tolerance):
            one, other = map(place, edge)
            raise ValueError(
                f"is not closed at its edge from {one} to {other}, which one face alone has: add the missing "
                "face, or close the hole in the program that drew the block"
            )


def _neighbours(ends: np.ndarray, tolerance: float) -> Iterator[np.ndarray]:
    """Yield, for each edge, the numbers of the other edges whose boxes are within the tolerance of its box.

    ``ends`` has shape (edges, 2, 3). A tree of boxes seen along the axis in which the mesh is least deep
    leaves few candidates, so that the time grows little faster than the number of edges.
    """
    if not len(ends):
        return
    low, high = ends.min(axis=1), ends.max(axis=1)
    widest = np.argsort(np.ptp(ends.reshape(-1, 3), axis=0))[-2:]
    tree = shapely.STRtree(shapely.box(*low[:, widest].T, *high[:, widest].T))
    reach = 2 * tolerance  # Boxes of a tree are rounded outwards, and candidates are tested by the caller.
    grown = shapely.box(*(low[:, widest] - reach).T, *(high[:, widest] + reach).T)
    for number, box in enumerate(grown):
        candidates = tree.query(box)
        apart = np.maximum(low[candidates] - high[number], low[number] - high[candidates]).max(axis=1)
        yield np.sort(candidates[(apart <= reach) & (candidates != number)])


def _is_covered(edge: np.ndarray, others: np.ndarray, tolerance: float) -> bool:
    """Return True if others, shape (edges, 2, 3), lie along the whole length of an edge, shape (2, 3)."""
    length = float(np.linalg.norm(edge[1] - edge[0]))
    direction = (edge[1] - edge[0]) / length
    arms = others - edge[0]
    along = arms @ direction
    off = np.linalg.norm(arms - along[..., None] * direction, axis=-1)
    beside = np.sort(along[(off <= tolerance).all(axis=1)], axis=1).tolist()
    return not spaces(0.0, length, beside, least=2 * tolerance)


def outwards(points: np.ndarray, faces: list[list[int]]) -> list[list[int]]:
    """The faces of a surface counter-clockwise seen from outside: along an edge two run opposite ways."""
    directed = [set(steps_round(face)) for face in faces]
    mates = {edge: having for edge, having in _by_edge(faces).items() if len(having) == 2}
    one, other = np.array(list(mates.values()), dtype=int).reshape(-1, 2).T
    alike = [(edge in directed[a]) == (edge in directed[b]) for edge, (a, b) in mates.items()]
    turn, _ = turned(len(faces), one, other, np.array(alike, dtype=bool))
    faces = [face[::-1] if turns else face for face, turns in zip(faces, turn.tolist(), strict=True)]
    return [face[::-1] for face in faces] if _volume(points, faces) < 0 else faces


def shells(mesh: Mesh) -> list[Mesh]:
    """The closed surfaces of a mesh, also of those that touch, each a block, named by its number from 0.
    Where more than two faces have an edge, each goes with the one that it meets through the inside."""
    at, corner = np.unique(mesh.points, axis=0, return_inverse=True)
    faces = [corner.reshape(-1)[face].tolist() for face in mesh.faces]
    if _volume(at, faces) < 0:
        faces = [face[::-1] for face in faces]
    links: list[list[int]] = []
    for edge, having in _by_edge(faces).items():
        links += _through_inside(at, edge, having, faces) if len(having) > 2 else [having[:1] + having[-1:]]
    group = linked(len(faces), *np.array(links, dtype=int).reshape(-1, 2).T)
    if not group.any():
        return [mesh]
    apart: list[list[list[int]]] = [[] for _ in range(group.max() + 1)]
    for number, face in zip(group.tolist(), mesh.faces, strict=True):
        apart[number].append(face)
    return [used(f"{mesh.name}-{number}", mesh.points, own) for number, own in enumerate(apart)]


def used(name: str, points: np.ndarray, faces: list[list[int]], layers: str = "") -> Mesh:
    """The block of some faces, with the points that they use."""
    corners = np.unique(np.concatenate(faces))
    own = [np.searchsorted(corners, face).tolist() for face in faces]
    return Mesh(name, points[corners], own, layers=layers)


def _through_inside(
    points: np.ndarray, edge: Edge, having: list[int], faces: list[list[int]]
) -> Iterator[list[int]]:
    """Pairs of faces that have an edge: each and the first behind it that turns the other way round it."""
    low, high = points[list(edge)]
    u, v = across((high - low) / np.linalg.norm(high - low))
    angles: dict[bool, list[tuple[int, float]]] = {True: [], False: []}
    for number in having:
        away = points[faces[number]].mean(axis=0) - low
        forth = edge in steps_round(faces[number])
        angles[forth].append((number, float(np.arctan2(away @ v, away @ u))))
    for number, angle in angles[True] if angles[False] else ():
        # Faces of two blocks that lie on each other have nothing between them.
        behind = [((angle - other - _SAME_ANGLE) % (2 * np.pi), mate) for mate, other in angles[False]]
        yield [number, min(behind)[1]]


def _joined(points: np.ndarray, faces: list[list[int]], tolerance: float) -> list[list[int]]:
    """The faces with one number for corners nearer than the tolerance, without those that have none left."""
    corner = first_near(points, tolerance).tolist()
    renamed = [[corner[number] for number in face] for face in faces]
    rings = [[one for one, after in steps_round(ring) if one != after] for ring in renamed]
    return [ring for ring in rings if len(set(ring)) > 2]


def first_near(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Of each point the first of those that are nearer than the tolerance, from one to the next."""
    near = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    group = linked(len(points), *near.T)
    return np.unique(group, return_index=True)[1][group]


def _by_edge(faces: list[list[int]]) -> dict[Edge, list[int]]:
    """The faces that have each edge, which begins with its lower corner."""
    having: dict[Edge, list[int]] = defaultdict(list)
    for number, face in enumerate(faces):
        for tail, tip in steps_round(face):
            having[min(tail, tip), max(tail, tip)].append(number)
    return having


def _flat(points: np.ndarray, face: list[int], tolerance: float) -> list[list[int]]:
    """A face that is flat within the tolerance, or triangles in its place: ears with the shortest third side
    first, so that two blocks that share the corners of a face share its triangles."""
    vector, found = area_vector(points[face]), []
    size = float(np.linalg.norm(vector))
    middle = points[face].mean(axis=0)
    while len(face) > 3 and size * tolerance < np.abs((points[face] - middle) @ vector).max():
        before, after = points[np.roll(face, 1)], points[np.roll(face, -1)]
        outwards = np.cross(points[face] - before, after - points[face]) @ vector
        third = np.round(np.linalg.norm(after - before, axis=1) / np.sqrt(size), 6)
        third[outwards <= 0] = np.inf
        # Of the two diagonals of a rhombus the one through the corner that comes first in space.
        among = np.flatnonzero(third == third.min())
        ends = np.minimum(before, after)[among] + np.maximum(before, after)[among]
        ear = int(among[np.lexsort(np.round(ends, 9).T)[0]])
        found.append([face[ear - 1], face[ear], face[(ear + 1) % len(face)]])
        face = face[:ear] + face[ear + 1 :]
    return [*found, face]


def _volume(points: np.ndarray, faces: list[list[int]]) -> float:
    """Inside the faces, negative if they are inside out."""
    corners = (points[face] - points[faces[0][0]] for face in faces)
    return float(sum(own[0] @ area_vector(own) for own in corners)) / 3


def _sides(points: np.ndarray, faces: list[list[int]], tolerance: float) -> list[Side]:
    beside: list[list[int]] = [[] for _ in faces]
    for mates in _by_edge(faces).values():
        if len(mates) == 2:
            beside[mates[0]].append(mates[1])
            beside[mates[1]].append(mates[0])
    alone = [_ringed(points, [face]) for face in faces]
    area = np.array([side.area for side in alone])
    left = dict.fromkeys(np.argsort(-np.round(area, 12), kind="stable").tolist())
    found = []
    while left:
        seed = next(iter(left))
        plane = alone[seed]
        # A narrower reach where what was merged bends too much to be one plane.
        for reach in (_OFF_TRIANGLE, 0.5, 0.0):
            own, waiting = {seed}, [seed]
            while waiting:
                for other in beside[waiting.pop()]:
                    if other in own or other not in left:
                        continue
                    off = np.abs((points[faces[other]] - plane.base) @ plane.normal).max()
                    alike = abs(alone[other].normal @ plane.normal) > _ALIKE
                    if (alike or alone[other].width <= tolerance) and off <= reach * tolerance:
                        own.add(other)
                        waiting.append(other)
            side = _side(points, [faces[number] for number in own], tolerance)
            if side is not None:
                break
        else:
            own, side = {seed}, plane
        for number in own:
            del left[number]
        found.append(side)
    return found


def _side(points: np.ndarray, faces: list[list[int]], tolerance: float) -> Side | None:
    """The faces as one, None if they are in no plane, or have no outline or one that touches itself."""
    # Triangles of a notched polygon may lie outside of it, turned round: their edges cancel all the same.
    edges = {side for face in faces for side in steps_round(face)}
    outline = [(tail, tip) for tail, tip in edges if (tip, tail) not in edges]
    following = dict(outline)
    if not outline or sorted(following) != sorted(tip for _, tip in outline):
        return None
    rings = rings_of(following)
    side = _ringed(points, rings)
    off = np.abs((points[np.concatenate(rings)] - side.base) @ side.normal).max()
    simple = all(shapely.linearrings(ring).is_simple for ring in side.flat(points))
    return side if simple and off <= tolerance else None


def rings_of(following: dict[int, int]) -> list[list[int]]:
    """The rings of what each follows, a permutation; each begins with its first key."""
    rings = []
    while following:
        ring = [next(iter(following))]
        while (after := following.pop(ring[-1])) != ring[0]:
            ring.append(after)
        rings.append(ring)
    return rings


def _ringed(points: np.ndarray, rings: list[list[int]]) -> Side:
    vectors = np.array([area_vector(points[ring]) for ring in rings])
    sizes = np.linalg.norm(vectors, axis=1)
    outer = int(sizes.argmax())
    rings = [rings[outer], *rings[:outer], *rings[outer + 1 :]]
    steps = [points[ring[1:] + ring[:1]] - points[ring] for ring in rings]
    around = sum(float(np.linalg.norm(own, axis=1).sum()) for own in steps)
    area = float(np.linalg.norm(vectors.sum(axis=0)))
    normal = vectors[outer] / sizes[outer] if sizes[outer] > 0 else np.array([0.0, 0.0, 1.0])
    return Side(rings, points[rings[0]].mean(axis=0), normal, area, 2 * area / around)

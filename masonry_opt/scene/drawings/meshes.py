"""Process blocks that are drawn as meshes: join corners, orient faces, and merge faces of one plane."""

from collections import Counter, defaultdict
from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
import shapely

from masonry_opt.errors import rounded
from masonry_opt.scene.rows import first_alike, linked, steps_round, turned

#: A face is merged with a side if the distance of its corners from the plane of the side is at most this
#: value, relative to the tolerance. A larger value merges more faces of a bent surface.
_TRIANGLE_REACH = 4.0

#: Largest distance of a corner from the planes of its sides, relative to the tolerance, that counts as an
#: inaccuracy of the mesh. A larger value also flattens intended bends.
_NOISE = 4.0

#: A least-squares problem moves each corner onto the planes of its sides. Singular values below this fraction
#: of the largest singular value count as zero. With a smaller value, corners between nearly parallel planes
#: move farther.
_LEAST_NORMAL_SPREAD = 0.02

#: Cosine of the largest angle between faces that may be merged into one flat side. Faces at a larger angle
#: belong to different sides.
_PARALLEL_COSINE = 0.9

#: Largest distance of a corner from the plane of a flat mesh, relative to the extent of the mesh. With a
#: larger value, thin blocks would count as flat.
_FLATNESS = 1e-5

FEWEST_SIDES = 4  #: Smallest number of sides of a solid, as for a tetrahedron.

Edge = tuple[int, int]


@dataclass(frozen=True)
class Mesh:
    """A block that is drawn as a mesh."""

    name: str
    points: np.ndarray  #: corners, shape (points, 3)
    faces: list[list[int]]  #: indices of the corners of each face, in order around the face
    fixed: bool = False  #: True for a support
    layers: str = ""  #: names of the layers on which the block is drawn
    #: True if this package wrote the mesh. Each surface of such a mesh is a convex part of the block.
    is_exported: bool = False

    @property
    def flat(self) -> bool:
        """Return True if the mesh is a single polygon without thickness."""
        return len(self.faces) == 1


@dataclass(frozen=True)
class Side:
    """A flat side of a block, which may have holes."""

    #: Indices of the corners of the outer ring and of the holes. Seen from outside, the surface is to the
    #: left of each ring.
    rings: list[list[int]]
    base: np.ndarray  #: a point in the plane of the side, shape (3,)
    normal: np.ndarray  #: unit normal of the plane, shape (3,)
    area: float
    width: float  #: mean width: area of the side divided by half the total length of its rings

    def flat(self, points: np.ndarray) -> list[np.ndarray]:
        """Return the corners of each ring in coordinates of the side's plane, shape (corners, 2) each."""
        return [(points[ring] - self.base) @ across(self.normal).T for ring in self.rings]

    def convex(self, points: np.ndarray, tolerance: float) -> bool:
        """Return True if the outer ring is a convex polygon within the tolerance."""
        hull = shapely.convex_hull(shapely.multipoints(self.flat(points)[0]))
        return bool(shapely.area(hull) - self.area <= tolerance * shapely.length(hull) / 2)


@dataclass(frozen=True)
class MeshSolid:
    """A solid that is described by its corners and its flat sides."""

    points: np.ndarray  #: corners, shape (points, 3)
    sides: list[Side]

    @property
    def volume(self) -> float:
        """Return the volume of the solid, whose sides must form a closed surface."""
        # Add up the volumes of pyramids with the sides as bases and a point of the first side as apex.
        middle = self.sides[0].base
        return sum(side.area * float((side.base - middle) @ side.normal) for side in self.sides) / 3

    @property
    def area(self) -> float:
        """Return the area of the surface."""
        return sum(side.area for side in self.sides)

    @property
    def corners(self) -> np.ndarray:
        """Return the corners of the sides, shape (corners, 3), without points that no side uses."""
        return self.points[np.unique([corner for side in self.sides for corner in side.rings[0]])]

    def unclosed(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the two ends of an edge at which the surface is not closed, or None if it is closed.

        At an edge of a closed surface, equal numbers of outlines run in both directions.
        """
        uses = Counter(edge for side in self.sides for ring in side.rings for edge in steps_round(ring))
        for (tail, tip), count in uses.items():
            if count != uses[tip, tail]:
                return self.points[tail], self.points[tip]
        return None

    def convex(self, tolerance: float) -> bool:
        """Return True if the solid and its sides are convex within the tolerance.

        Sides that are not wider than the tolerance are not checked, because their planes are inaccurate.
        """
        if any(len(side.rings) > 1 for side in self.sides):
            return False
        corners = self.corners
        wide_sides = [side for side in self.sides if side.width > tolerance]
        return all(
            ((corners - side.base) @ side.normal).max() <= tolerance and side.convex(self.points, tolerance)
            for side in wide_sides
        )


def across(normal: np.ndarray) -> np.ndarray:
    """Return unit vectors u and v in a plane, shape (2, 3), so that u × v is the given unit normal."""
    u = _cross(normal, np.eye(3)[np.abs(normal).argmin()])
    u /= np.linalg.norm(u)
    return np.array([u, _cross(normal, u)])


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return cross products, faster than ``numpy.cross`` for few vectors."""
    return u[..., [1, 2, 0]] * v[..., [2, 0, 1]] - u[..., [2, 0, 1]] * v[..., [1, 2, 0]]


def area_vector(corners: np.ndarray) -> np.ndarray:
    """Return the area vector of a polygon, shape (3,), by Newell's formula.

    The vector is normal to the polygon, and its length is the area of the polygon.
    """
    arms = corners[1:] - corners[0]
    return _cross(arms[:-1], arms[1:]).sum(axis=0) / 2


def with_one_face(mesh: Mesh) -> Mesh:
    """Return a flat mesh with its outline as its single face. Any other mesh is returned unchanged.

    Programs divide a flat polygon into triangles, for example the ground.
    """
    offset = mesh.points - mesh.points.mean(axis=0)
    normal = np.linalg.svd(offset, full_matrices=False)[2][-1]
    if mesh.flat or np.abs(offset @ normal).max() > _FLATNESS * np.ptp(offset, axis=0).max():
        return mesh
    faces = merge_equal_corners(mesh)
    upward_faces = [face if area_vector(mesh.points[face]) @ normal > 0 else face[::-1] for face in faces]
    edges = {edge for face in upward_faces for edge in steps_round(face)}
    outline = [(tail, tip) for tail, tip in edges if (tip, tail) not in edges]
    next_corner = dict(outline)
    if len(next_corner) < len(outline):
        return mesh
    rings = rings_of(next_corner)
    return replace(mesh, faces=rings) if len(rings) == 1 else mesh


def polyhedron(mesh: Mesh, tolerance: float) -> MeshSolid:
    """Convert a mesh to a solid with flat sides.

    Corners that are nearer to each other than the tolerance are joined, and faces are oriented outwards.
    Faces that are not flat are divided into triangles, and faces in one plane are merged. Raises ValueError
    if no face remains.
    """
    points = mesh.points
    faces = outwards(points, join_corners(points, mesh.faces, tolerance))
    faces = [piece for face in faces for piece in _flat_pieces(points, face, tolerance)]
    if not faces:
        raise ValueError(
            f"the block is smaller than the tolerance {rounded(tolerance)}: check the unit of the drawing"
        )
    return MeshSolid(points, _sides(points, faces, tolerance))


def flattened(mesh: Mesh, tolerance: float) -> MeshSolid | None:
    """Return a mesh as a solid with exactly flat sides, or None if its sides are not nearly flat.

    The sides are nearly flat if the corners are at most four times the tolerance away from their planes.
    Each corner moves along the shortest line onto these planes.
    """
    noise = _NOISE * tolerance
    try:
        coarse = polyhedron(mesh, noise)
    except ValueError:
        return None
    sides_at: dict[int, list[Side]] = defaultdict(list)
    for side in coarse.sides:
        for corner in {corner for ring in side.rings for corner in ring} if side.width > noise else ():
            sides_at[corner].append(side)
    points = coarse.points.copy()
    for corner, sides in sides_at.items():
        normals = np.array([side.normal for side in sides])
        heights = np.array([(points[corner] - side.base) @ side.normal for side in sides])
        move = np.linalg.pinv(normals, rcond=_LEAST_NORMAL_SPREAD) @ heights
        if np.linalg.norm(move) > 2 * noise:
            return None
        points[corner] -= move
    solid = MeshSolid(points, [_side_of_rings(points, side.rings) for side in coarse.sides])
    is_flat = all(_is_flat(points, side, tolerance) for side in solid.sides)
    # Check the volume, because a large tolerance may merge opposite faces so that no volume remains.
    is_solid = len(solid.sides) >= FEWEST_SIDES and 2 * solid.volume > tolerance * solid.area
    return solid if is_flat and is_solid else None


def _is_flat(points: np.ndarray, side: Side, tolerance: float) -> bool:
    """Return True if the corners of a side are in its plane and its rings do not cross themselves."""
    height = np.abs((points[np.concatenate(side.rings)] - side.base) @ side.normal)
    is_simple = all(shapely.linearrings(ring).is_simple for ring in side.flat(points))
    return is_simple and bool(height.max() <= tolerance)


def outwards(points: np.ndarray, faces: list[list[int]]) -> list[list[int]]:
    """Orient the faces of a surface counter-clockwise, seen from outside.

    Then two faces that share an edge traverse this edge in opposite directions.
    """
    directed_edges = [set(steps_round(face)) for face in faces]
    pairs = {edge: edge_faces for edge, edge_faces in by_edge(faces).items() if len(edge_faces) == 2}
    first, second = np.array(list(pairs.values()), dtype=int).reshape(-1, 2).T
    is_alike = [(edge in directed_edges[i]) == (edge in directed_edges[j]) for edge, (i, j) in pairs.items()]
    turn, _ = turned(len(faces), first, second, np.array(is_alike, dtype=bool))
    faces = [face[::-1] if turns else face for face, turns in zip(faces, turn.tolist(), strict=True)]
    return [face[::-1] for face in faces] if volume(points, faces) < 0 else faces


def used(name: str, points: np.ndarray, faces: list[list[int]], layers: str = "") -> Mesh:
    """Return a block with the given faces and without points that the faces do not use."""
    corners = np.unique(np.concatenate(faces))
    renumbered = [np.searchsorted(corners, face).tolist() for face in faces]
    return Mesh(name, points[corners], renumbered, layers=layers)


def join_corners(points: np.ndarray, faces: list[list[int]], tolerance: float) -> list[list[int]]:
    """Join corners that are nearer to each other than the tolerance, and return the distinct faces."""
    first = first_near(points, tolerance).tolist()
    return [*distinct_faces([[first[corner] for corner in face] for face in faces]).values()]


def merge_equal_corners(mesh: Mesh) -> list[list[int]]:
    """Return the faces of a mesh after replacing each corner by the first corner with equal coordinates."""
    first = first_alike(mesh.points).tolist()
    return [[first[corner] for corner in face] for face in mesh.faces]


def distinct_faces(faces: list[list[int]]) -> dict[int, list[int]]:
    """Return a dict from the index of each distinct face to its corners, without repeated successive corners.

    Faces with fewer than three corners are left out, and so are repetitions of a face.
    """
    rings: dict[tuple[int, ...], tuple[int, list[int]]] = {}
    for number, face in enumerate(faces):
        ring = [corner for corner, next_corner in steps_round(face) if corner != next_corner]
        if len(set(ring)) > 2:
            rings.setdefault(from_smallest(ring), (number, ring))
    return dict(rings.values())


def from_smallest(ring: list[int]) -> tuple[int, ...]:
    """Return the corners of a face, beginning at the smallest index: a key that is equal for equal faces."""
    start = ring.index(min(ring))
    return (*ring[start:], *ring[:start])


def first_near(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Group points that nearly coincide, and return, for each point, the lowest index in its group.

    Points are in one group if a chain of points, with steps of at most the tolerance, connects them.
    """
    # Import scipy.spatial only here, because the import takes 0.1 s and few scenes need it.
    from scipy.spatial import cKDTree

    near_pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    group = linked(len(points), *near_pairs.T)
    return np.unique(group, return_index=True)[1][group]


def by_edge(faces: list[list[int]]) -> dict[Edge, list[int]]:
    """Return a dict from each edge, a pair of ascending corner indices, to the faces at the edge."""
    edge_faces: dict[Edge, list[int]] = defaultdict(list)
    for number, face in enumerate(faces):
        for tail, tip in steps_round(face):
            edge_faces[min(tail, tip), max(tail, tip)].append(number)
    return edge_faces


def _flat_pieces(points: np.ndarray, face: list[int], tolerance: float) -> list[list[int]]:
    """Return a face unchanged if it is flat within the tolerance, and otherwise as triangles.

    The algorithm is ear clipping, which begins with the ear that has the shortest third side. The triangles
    depend only on the corners of the face, so two blocks with a common face have the same triangles.
    """
    if len(face) == 3:
        return [face]
    vector = area_vector(points[face])
    triangles = []
    size = float(np.linalg.norm(vector))
    middle = points[face].mean(axis=0)
    while len(face) > 3 and size * tolerance < np.abs((points[face] - middle) @ vector).max():
        tails = points[np.roll(face, 1)]
        tips = points[np.roll(face, -1)]
        turn = np.cross(points[face] - tails, tips - points[face]) @ vector
        third_side = np.round(np.linalg.norm(tips - tails, axis=1) / np.sqrt(size), 6)
        third_side[turn <= 0] = np.inf
        # If several diagonals are equally short, as in a rhombus, choose by their positions. Both blocks with
        # this face then have the same triangles.
        candidates = np.flatnonzero(third_side == third_side.min())
        ends = np.minimum(tails, tips)[candidates] + np.maximum(tails, tips)[candidates]
        ear = int(candidates[np.lexsort(np.round(ends, 9).T)[0]])
        triangles.append([face[ear - 1], face[ear], face[(ear + 1) % len(face)]])
        face = face[:ear] + face[ear + 1 :]
    return [*triangles, face]


def volume(points: np.ndarray, faces: list[list[int]]) -> float:
    """Return the volume that faces enclose, which is negative if the faces are oriented inwards."""
    corners = (points[face] - points[faces[0][0]] for face in faces)
    return float(sum(polygon[0] @ area_vector(polygon) for polygon in corners)) / 3


def _sides(points: np.ndarray, faces: list[list[int]], tolerance: float) -> list[Side]:
    """Merge neighbouring faces of a surface that lie in one plane, and return the flat sides.

    Each side starts from the largest face that is not yet part of a side.
    """
    neighbours = _neighbours(faces)
    face_sides = [_side_of_rings(points, [face]) for face in faces]
    surface = _Surface(points, faces, neighbours, face_sides)
    area = np.array([side.area for side in face_sides])
    # Use a dictionary, because it keeps the order of the faces and removes a face in constant time.
    remaining_faces = dict.fromkeys(np.argsort(-np.round(area, 12), kind="stable").tolist())
    sides = []
    while remaining_faces:
        seed = next(iter(remaining_faces))
        # If the merged faces are not flat within the tolerance, merge only faces nearer to the plane.
        for reach in (_TRIANGLE_REACH, 0.5, 0.0):
            members = surface.coplanar(seed, remaining_faces, reach * tolerance, tolerance)
            side = _merge_faces(points, [faces[number] for number in members], tolerance)
            if side is not None:
                break
        else:
            members = {seed}
            side = face_sides[seed]
        for number in members:
            del remaining_faces[number]
        sides.append(side)
    return sides


@dataclass(frozen=True)
class _Surface:
    """Faces of a block's surface, with their neighbours and planes."""

    points: np.ndarray  #: coordinates of the corners, shape (points, 3)
    faces: list[list[int]]
    neighbours: list[list[int]]  #: indices of the faces next to each face
    face_sides: list[Side]  #: one side for each face, before faces are merged

    def coplanar(self, seed: int, candidates: Collection[int], reach: float, tolerance: float) -> set[int]:
        """Return the connected set of faces that contains the face ``seed`` and is in the plane of this face.

        The corners of the faces are at most ``reach`` away from the plane. Faces that are narrower than the
        tolerance may have any normal.
        """
        plane = self.face_sides[seed]
        members = {seed}
        queue = [seed]
        while queue:
            for neighbour in self.neighbours[queue.pop()]:
                if neighbour in members or neighbour not in candidates:
                    continue
                distance = np.abs((self.points[self.faces[neighbour]] - plane.base) @ plane.normal).max()
                is_parallel = abs(self.face_sides[neighbour].normal @ plane.normal) > _PARALLEL_COSINE
                is_narrow = self.face_sides[neighbour].width <= tolerance
                if (is_parallel or is_narrow) and distance <= reach:
                    members.add(neighbour)
                    queue.append(neighbour)
        return members


def _neighbours(faces: list[list[int]]) -> list[list[int]]:
    """Return the indices of the neighbours of each face.

    Two faces are neighbours if they share an edge that belongs to no third face.
    """
    neighbours: list[list[int]] = [[] for _ in faces]
    for edge_faces in by_edge(faces).values():
        if len(edge_faces) == 2:
            neighbours[edge_faces[0]].append(edge_faces[1])
            neighbours[edge_faces[1]].append(edge_faces[0])
    return neighbours


def _merge_faces(points: np.ndarray, faces: list[list[int]], tolerance: float) -> Side | None:
    """Merge faces into one flat side, or return None if the faces cannot be merged.

    Faces cannot be merged if they are not in one plane, if they have no outline, or if their outline touches
    itself.
    """
    # An edge that two faces traverse in opposite directions is inside the merged side, not on its outline.
    # Some programs divide a notched polygon into a fan of triangles. Triangles of the fan that are outside
    # the polygon have the opposite orientation, so this rule removes them too.
    edges = {side for face in faces for side in steps_round(face)}
    outline = [(tail, tip) for tail, tip in edges if (tip, tail) not in edges]
    next_corner = dict(outline)
    if not outline or sorted(next_corner) != sorted(tip for _, tip in outline):
        return None
    rings = rings_of(next_corner)
    side = _side_of_rings(points, rings)
    return side if _is_flat(points, side, tolerance) else None


def rings_of(following: dict[int, int]) -> list[list[int]]:
    """Return the rings (cycles) of a permutation as lists.

    ``following`` maps each number to the next number. It is empty afterwards.
    """
    rings = []
    while following:
        ring = [next(iter(following))]
        next_number = following.pop(ring[-1])
        while next_number != ring[0]:
            ring.append(next_number)
            next_number = following.pop(next_number)
        rings.append(ring)
    return rings


def _side_of_rings(points: np.ndarray, rings: list[list[int]]) -> Side:
    """Return the flat side that is bounded by rings of corners. The largest ring surrounds all others."""
    vectors = np.array([area_vector(points[ring]) for ring in rings])
    sizes = np.linalg.norm(vectors, axis=1)
    outer_ring = int(sizes.argmax())
    rings = [rings[outer_ring], *rings[:outer_ring], *rings[outer_ring + 1 :]]
    steps = [points[ring[1:] + ring[:1]] - points[ring] for ring in rings]
    perimeter = sum(float(np.linalg.norm(step, axis=1).sum()) for step in steps)
    area = float(np.linalg.norm(vectors.sum(axis=0)))
    normal = vectors[outer_ring] / sizes[outer_ring] if sizes[outer_ring] > 0 else np.array([0.0, 0.0, 1.0])
    return Side(rings, points[rings[0]].mean(axis=0), normal, area, 2 * area / perimeter)

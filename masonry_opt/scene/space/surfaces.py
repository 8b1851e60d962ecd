"""Surfaces of the blocks' convex parts as flat arrays, closed, and turned so that normals point outwards."""

from dataclasses import dataclass, field, replace
from itertools import chain
from typing import NoReturn

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.scene.rows import first_alike, following, ranges, sums, turned
from masonry_opt.scene.scene import Scene


@dataclass(frozen=True)
class Surfaces:
    """Faces of all parts of all blocks in turn."""

    scene: Scene  #: theirs, for messages
    points: np.ndarray  #: vertices, shape (vertices, 3)
    block: np.ndarray  #: block of each part, rising, shape (parts,)
    part: np.ndarray  #: part of each face, rising, shape (faces,)
    face: np.ndarray  #: face of each corner, rising, shape (corners,)
    vertex: np.ndarray  #: vertex of each corner, shape (corners,)
    #: Blocks whose faces were not all given turned one way.
    mixed: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))

    @property
    def corners(self) -> np.ndarray:
        """Positions of the corners, shape (corners, 3)."""
        return self.points[self.vertex]

    @property
    def count(self) -> np.ndarray:
        """Number of corners of each face, shape (faces,)."""
        return np.bincount(self.face, minlength=len(self.part))

    def following(self) -> np.ndarray:
        """The next corner of each corner's face, shape (corners,)."""
        return following(self.count)

    def sum_by_face(self, values: np.ndarray) -> np.ndarray:
        """Sums over the corners of each face of values, shape (corners, k)."""
        return sums(self.face, values, len(self.part))

    def refuse(self, face: int, why: str) -> NoReturn:
        """Raise CaseError that names the block, part and face."""
        part = self.part[face]
        block = self.block[part]
        number = face - np.searchsorted(self.part, part) + 1
        several = np.count_nonzero(self.block == block) > 1
        of_part = f" of part no. {part - np.searchsorted(self.block, block) + 1}" if several else ""
        name = self.scene.blocks[block].name
        raise CaseError(f"{self.scene.origin}: block {name!r}: face no. {number}{of_part} {why}")


def surfaces(scene: Scene) -> Surfaces:
    """The blocks' surfaces as given, turned consistently within each part. Raises CaseError if an edge is not
    in exactly two faces, or faces cannot be turned consistently."""
    bodies = [block.polyhedra for block in scene.in_space()]
    parts = list(chain.from_iterable(bodies))
    points = np.concatenate([np.asarray(vertices, dtype=float) for vertices, _ in parts])
    of_vertices = np.array([len(vertices) for vertices, _ in parts])
    part = np.repeat(np.arange(len(parts)), [len(faces) for _, faces in parts])
    of_corners = np.array([len(face) for _, faces in parts for face in faces])
    vertex = np.fromiter(chain.from_iterable(face for _, faces in parts for face in faces), dtype=np.int64)
    vertex += np.repeat((np.cumsum(of_vertices) - of_vertices)[part], of_corners)
    # Meshes may repeat vertices face by face.
    vertex = first_alike(np.column_stack([np.repeat(np.arange(len(parts)), of_vertices), points]))[vertex]
    face = np.repeat(np.arange(len(part)), of_corners)
    apart = vertex != vertex[following(of_corners)]
    block = np.repeat(np.arange(len(bodies)), list(map(len, bodies)))
    return _turned(Surfaces(scene, points, block, part, face[apart], vertex[apart]))


def _turned(given: Surfaces) -> Surfaces:
    """The surfaces with the faces of each part turned one way, after the check that they are closed."""
    tail, tip = given.vertex, given.vertex[given.following()]
    key = np.minimum(tail, tip) * np.int64(len(given.points)) + np.maximum(tail, tip)
    _, edge, uses = np.unique(key, return_inverse=True, return_counts=True)
    wrong = np.flatnonzero(uses[edge] != 2)
    if len(wrong):
        one, other = (place(given.points[end[wrong[0]]]) for end in (tail, tip))
        more = uses[edge[wrong[0]]] - 1
        others = f"{more} other faces have" if more else "no other face has"
        given.refuse(
            int(given.face[wrong[0]]),
            f"has an edge from {one} to {other} that {others}: close the surface, each edge in two faces",
        )
    mates = np.argsort(edge, kind="stable").reshape(-1, 2)
    one, other = given.face[mates].T
    same_way = tail[mates[:, 0]] == tail[mates[:, 1]]
    turn, twisted = turned(len(given.part), one, other, same_way)
    if twisted.any():
        why = "is part of a surface without inside and outside: give a solid's faces"
        given.refuse(int(twisted.argmax()), why)
    mixed = np.unique(given.block[given.part[one[same_way]]])
    return reversed_faces(replace(given, mixed=mixed), turn)


def reversed_faces(given: Surfaces, chosen: np.ndarray) -> Surfaces:
    """The surfaces with the chosen faces, shape (faces,), turned round."""
    count = given.count
    first = np.cumsum(count) - count
    at = ranges(first, count)
    turned = (2 * first + count - 1)[given.face] - at
    return replace(given, vertex=given.vertex[np.where(chosen[given.face], turned, at)])


def place(point: np.ndarray, tolerance: float = 0.0) -> str:
    """A point in words, coordinates within the tolerance as 0."""
    return f"({', '.join(f'{0.0 if abs(value) <= tolerance else value:.6g}' for value in point)})"

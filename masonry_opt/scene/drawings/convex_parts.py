"""Cut polyhedra with notches and holes into convex parts."""

from typing import NamedTuple

import numpy as np
import shapely

from masonry_opt.scene.drawings.meshes import Mesh, MeshSolid, Side, across, first_near, polyhedron
from masonry_opt.scene.outlines import convex_pieces
from masonry_opt.scene.rows import bounds, dots
from masonry_opt.scene.space.faces import place

#: Largest number of convex parts of one block. A block that needs more parts is refused: it usually has a
#: curved surface, with too many contacts for an analysis.
_MOST_PIECES = 1000

#: Distance from a plane, relative to the tolerance, up to which a face certainly lies in the plane.
_COPLANAR_SHARE = 1e-3

#: Largest share of a block's volume in parts that are omitted because they are thinner than the tolerance.
#: For a block with curved surfaces the share is about 0.03 %.
_MOST_THIN_VOLUME = 1e-3

#: Corners of a unit square.
_SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])

#: Faces of a unit cube.
_UNIT_BOX = [np.insert(_SQUARE, axis, at, axis=1) for axis in range(3) for at in (0, 1)]


class _Pieces(NamedTuple):
    """Convex pieces of a block's sides inside one cell of a binary space partition."""

    rings: list[np.ndarray]  #: corners of each piece, shape (corners, 3)
    side: np.ndarray  #: index of the side to which each piece belongs, shape (pieces,)

    def heights(self, base: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the smallest and largest height of each piece above planes, shape (pieces, planes) each."""
        over = np.concatenate(self.rings) @ normal.T - dots(base, normal)
        piece = np.repeat(np.arange(len(self.rings)), list(map(len, self.rings)))
        return bounds(piece, over, len(self.rings))


def convex_parts(block: MeshSolid, tolerance: float) -> list[MeshSolid]:
    """Divide a closed polyhedron into convex polyhedra.

    The algorithm is binary space partition (Fuchs, Kedem and Naylor 1980). Space is cut along the planes of
    sides, and each cell along those of the sides in it, until no cell has a side inside. A cell is then full
    or empty. Sides that cut off only empty space come first, then those that cut the fewest other sides.
    Parts thinner than the tolerance are left out. If there are several closed surfaces, which may touch, the
    parts are those of all.

    Raises ValueError if the sides do not close or cross each other, if there are too many parts, or if there
    is none.
    """
    sides = [side for side in block.sides if side.width > tolerance]
    base, normal = np.array([(side.base, side.normal) for side in sides]).reshape(-1, 2, 3).swapaxes(0, 1)
    corners = block.points[np.unique([corner for side in sides for ring in side.rings for corner in ring])]
    low, high = corners.min(axis=0), corners.max(axis=0)
    low, high = low - (high - low), high + (high - low)
    cell = [low + face * (high - low) for face in _UNIT_BOX]
    queue = [(_pieces(block.points, sides, tolerance), cell)]
    parts: list[MeshSolid] = []
    while queue:
        pieces, cell = queue.pop()
        number = _best(pieces, base, normal, tolerance)
        halves = _divided(pieces, base[number], normal[number], tolerance)
        # If two sides in the plane have opposite normals, two closed surfaces touch there; the half in front
        # of the plane is then solid too.
        within = np.setdiff1d(pieces.side, np.concatenate([half.side for half in halves]))
        ahead = (base[within] - base[number]) @ normal[number] > -_COPLANAR_SHARE * tolerance
        touching = bool((ahead & (normal[within] @ normal[number] < 0)).any())
        for half, sign, full in zip(halves, (-1.0, 1.0), (touching, True), strict=True):
            clipped = _clipped(cell, base[number], sign * normal[number]) if half.rings or full else []
            if half.rings:
                queue.append((half, clipped))
                continue
            part = _part(clipped, tolerance)
            if part:
                parts.append(part)
        if len(parts) + len(queue) > _MOST_PIECES:
            raise ValueError(
                f"is not convex and would need more than {_MOST_PIECES} convex parts: simplify the block"
            )
    if not parts:
        raise ValueError("has no volume: draw the faces of a solid, all oriented outwards")
    _check_volume(block, parts, tolerance)
    return parts


def _check_volume(block: MeshSolid, parts: list[MeshSolid], tolerance: float) -> None:
    """Raise ValueError if the volumes of a block's parts do not add up to the volume of the block."""
    off = abs(sum(part.volume for part in parts) - block.volume)
    edge = block.unclosed()
    rounding = tolerance * sum(side.area for side in block.sides)
    if edge is not None and off > rounding:
        one, other = map(place, edge)
        raise ValueError(
            f"is not closed at its edge from {one} to {other}: each edge must belong to two faces"
        )
    if off > _MOST_THIN_VOLUME * abs(block.volume) + rounding:
        raise ValueError("has faces that cross or coincide: draw one closed surface")


def _pieces(points: np.ndarray, sides: list[Side], tolerance: float) -> _Pieces:
    """Divide all sides of a block into convex pieces."""
    rings: list[np.ndarray] = []
    numbers: list[int] = []
    for number, side in enumerate(sides):
        outer, *holes = side.flat(points)
        try:
            convex = convex_pieces(shapely.Polygon(outer, holes), tolerance)
        except shapely.errors.GEOSException:
            raise ValueError(
                "has a face that crosses itself: list its corners in order around the face"
            ) from None
        rings += [side.base + piece @ across(side.normal) for piece in convex]
        numbers += [number] * len(convex)
    return _Pieces(rings, np.array(numbers, dtype=int))


def _best(pieces: _Pieces, base: np.ndarray, normal: np.ndarray, tolerance: float) -> int:
    """Choose the side along whose plane a cell is cut next, and return the side's index."""
    planes = np.unique(pieces.side)
    low, high = pieces.heights(base[planes], normal[planes])
    ahead, behind = high > tolerance, low < -tolerance
    cut, within = (ahead & behind).sum(axis=0), (~ahead & ~behind).sum(axis=0)
    return int(planes[np.lexsort((-within, cut, ahead.any(axis=0)))[0]])


def _divided(pieces: _Pieces, base: np.ndarray, normal: np.ndarray, tolerance: float) -> list[_Pieces]:
    """Cut pieces along a plane; return the pieces in front of the plane and the pieces behind it.

    Pieces in the plane are left out.
    """
    low, high = (bound[:, 0] for bound in pieces.heights(base[None], normal[None]))
    ahead, behind = high > tolerance, low < -tolerance

    def half(within: np.ndarray, beyond: np.ndarray, normal: np.ndarray) -> _Pieces:
        rings = []
        for number in np.flatnonzero(within):
            ring = pieces.rings[number]
            rings.append(_cut(ring, base, normal)[0] if beyond[number] else ring)
        return _Pieces(rings, pieces.side[within])

    return [half(ahead, behind, -normal), half(behind, ahead, normal)]


def _cut(ring: np.ndarray, base: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the part of a convex polygon behind a plane, and the corners of the part in the plane."""
    height = (ring - base) @ normal
    after, height_after = np.roll(ring, -1, axis=0), np.roll(height, -1)
    crosses = (height > 0) != (height_after > 0)
    share = np.divide(height, height - height_after, out=np.zeros_like(height), where=crosses)
    # Insert after each corner the point at which the following side of the polygon crosses the plane.
    points = np.stack([ring, ring + share[:, None] * (after - ring)], axis=1).reshape(-1, 3)
    behind = np.column_stack([height <= 0, crosses]).ravel()
    in_plane = np.column_stack([height == 0, crosses]).ravel()
    return points[behind], points[in_plane]


def _clipped(cell: list[np.ndarray], base: np.ndarray, normal: np.ndarray) -> list[np.ndarray]:
    """Cut a convex polyhedron at a plane, and return the faces of the part behind the plane."""
    cuts = [_cut(ring, base, normal) for ring in cell]
    faces = [ring for ring, _ in cuts if len(ring) > 2]
    lid = np.concatenate([corners for _, corners in cuts])
    if len(lid) > 2 and len(faces) > 1:
        u, v = across(normal)
        around = lid - lid.mean(axis=0)
        faces.append(lid[np.argsort(np.arctan2(around @ v, around @ u))])
    return faces


def _part(cell: list[np.ndarray], tolerance: float) -> MeshSolid | None:
    """Return a cell as a polyhedron, or None if the cell is thinner than the tolerance."""
    # Importing scipy.spatial takes a tenth of a second, and few scenes reach this function.
    from scipy.spatial import ConvexHull, QhullError

    points = np.concatenate(cell) if cell else np.zeros((0, 3))
    corners = points[np.unique(first_near(points, tolerance / 4))]
    try:
        # Use the convex hull, which is a closed surface in spite of rounding errors of the corners.
        hull = ConvexHull(corners)
        mesh = Mesh("", corners, hull.simplices.tolist())
        shape = polyhedron(mesh, tolerance / 4)
        # A narrow side may have been merged in an inaccurate plane: merge fewer triangles.
        if not shape.convex(tolerance):
            shape = polyhedron(mesh, _COPLANAR_SHARE * tolerance)
    except (QhullError, ValueError):
        return None
    return shape if 2 * hull.volume > tolerance * hull.area else None

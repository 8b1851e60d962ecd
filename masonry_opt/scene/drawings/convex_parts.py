"""Cut polyhedra with notches and holes into convex parts."""

from typing import NamedTuple

import numpy as np
import shapely

from masonry_opt.errors import rounded
from masonry_opt.scene.drawings.meshes import (
    FEWEST_SIDES,
    Mesh,
    MeshSolid,
    Side,
    across,
    first_near,
    flattened,
    polyhedron,
)
from masonry_opt.scene.drawings.winding import fan_triangles, winding_number
from masonry_opt.scene.outlines import convex_pieces
from masonry_opt.scene.rows import bounds, dots
from masonry_opt.scene.space.faces import place

#: Largest number of convex parts of one block. A block that needs more parts raises an error, because it
#: usually has a curved surface with too many contacts for an analysis.
_MOST_PIECES = 1000

#: Distance, relative to the tolerance, within which triangles of a convex hull are merged into one side. This
#: distance is used only if merging within a quarter of the tolerance makes the hull non-convex. With a larger
#: value, triangles in different planes may be merged.
_COPLANAR_SHARE = 1e-3

#: Smallest thickness of a part, relative to the tolerance. Thinner parts are omitted. With a value of 1 or
#: less, rounding may reduce the volume of a part to zero.
_THINNEST = 2.0

#: Largest fraction of a block's volume in parts that are omitted because they are too thin. A larger fraction
#: raises an error. For a block with curved surfaces the fraction is about 0.03 %.
_MOST_THIN_VOLUME = 1e-3

#: Positions of test points on the lines from the middle of a hull (0) to its corners (1). The hull replaces
#: the block if all test points are inside the block.
_TEST_POSITIONS = (0.35, 0.7)

#: Corners of a unit square.
_SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])

#: Faces of a unit cube.
_UNIT_BOX = [np.insert(_SQUARE, axis, at, axis=1) for axis in range(3) for at in (0, 1)]


class _Pieces(NamedTuple):
    """Convex pieces of a block's sides inside one cell of a binary space partition."""

    rings: list[np.ndarray]  #: corners of each piece, shape (corners, 3)
    side: np.ndarray  #: index of the side of the block from which each piece was cut, shape (pieces,)

    def heights(self, base: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the smallest and largest height of each piece above planes, shape (pieces, planes) each."""
        height = np.concatenate(self.rings) @ normal.T - dots(base, normal)
        piece = np.repeat(np.arange(len(self.rings)), list(map(len, self.rings)))
        return bounds(piece, height, len(self.rings))


def convex_solids(mesh: Mesh, tolerance: float) -> list[MeshSolid]:
    """Divide a closed mesh into convex solids, which are the parts of one block.

    1. If the corners are at most four times the tolerance away from the planes of the sides, the sides are
       flattened.
    2. A solid that is closed, and convex within the tolerance, is one part. Sides with corners in the middle
       of a neighbour's edge are not closed.
    3. If the volume of the convex hull exceeds the volume of the solid by at most the tolerance times the
       surface area of the solid, the hull is the only part.
    4. Otherwise the solid is divided into convex parts.

    Raises ValueError if the mesh does not enclose a volume, crosses itself, or needs too many parts.
    """
    solid = polyhedron(mesh, tolerance)
    flat_solid = flattened(mesh, tolerance)
    if flat_solid is not None and len(flat_solid.sides) < len(solid.sides):
        solid = flat_solid
    if len(solid.sides) < FEWEST_SIDES:
        raise ValueError(
            f"the block is not a solid within the tolerance {rounded(tolerance)}: lower 'tolerance', "
            "check the unit of the drawing, or give the block a thickness"
        )
    if solid.unclosed() is None and solid.convex(tolerance):
        return [solid]
    hull = _hull(solid.corners, tolerance)
    if hull and _fills(solid, hull, tolerance):
        return [hull]
    return convex_parts(solid, tolerance)


def _fills(block: MeshSolid, hull: MeshSolid, tolerance: float) -> bool:
    """Return True if a block fills its convex hull, except for a layer as thick as the tolerance.

    Surfaces that cross each other may enclose the volume of the hull by chance. Therefore the winding number
    is checked at points between the middle of the hull and its corners.
    """
    if abs(hull.volume - block.volume) > tolerance * block.area:
        return False
    surface = fan_triangles(block)
    corners = hull.corners
    middle = corners.mean(axis=0)
    points = [
        middle,
        *(middle + share * (corner - middle) for corner in corners for share in _TEST_POSITIONS),
    ]
    return all(0.5 < winding_number(point, surface) < 1.5 for point in points)


def convex_parts(block: MeshSolid, tolerance: float) -> list[MeshSolid]:
    """Divide a closed polyhedron into convex polyhedra.

    The algorithm is binary space partitioning (Fuchs, Kedem and Naylor 1980). Space is divided along the
    plane of a side. Each resulting cell is divided along the planes of the sides in it, until no cell
    contains a side. Sides that cut off only empty space are chosen first, and then sides that cut the fewest
    other sides. A cell is a part if the winding number of the block's surface at the middle of the cell is 1.
    Parts thinner than twice the tolerance are omitted. If the block has several closed surfaces, which may
    touch, the parts fill all of them.

    Raises ValueError if the sides do not form a closed surface, if they cross each other, if there are too
    many parts, or if there is no part.
    """
    sides = [side for side in block.sides if side.width > tolerance]
    if not sides:
        raise ValueError(
            f"the block has no face wider than the tolerance {rounded(tolerance)}: lower 'tolerance'"
        )
    base, normal = np.array([(side.base, side.normal) for side in sides]).reshape(-1, 2, 3).swapaxes(0, 1)
    surface = fan_triangles(block)
    queue = [(_pieces(block.points, sides, tolerance), _box_around(block.points, sides))]
    parts: list[MeshSolid] = []
    while queue:
        pieces, cell = queue.pop()
        number = _best_side(pieces, base, normal, tolerance)
        halves = _divide(pieces, base[number], normal[number], tolerance)
        for half, sign in zip(halves, (-1.0, 1.0), strict=True):
            half_cell = _clip(cell, base[number], sign * normal[number])
            if half.rings:
                queue.append((half, half_cell))
            elif half_cell:
                parts += _parts_in_cell(half_cell, surface, tolerance)
        if len(parts) + len(queue) > _MOST_PIECES:
            raise ValueError(
                "the block is not convex and would need "
                f"more than {_MOST_PIECES} convex parts: simplify the block"
            )
    if not parts:
        raise ValueError(
            f"the block has no part thicker than the tolerance {rounded(tolerance)}: "
            "draw the faces of a solid, or lower 'tolerance'"
        )
    _check_volume(block, parts, tolerance)
    return parts


def _box_around(points: np.ndarray, sides: list[Side]) -> list[np.ndarray]:
    """Return the faces of a box three times as large as the bounding box of all sides."""
    corners = points[np.unique([corner for side in sides for corner in side.rings[0]])]
    low, high = corners.min(axis=0), corners.max(axis=0)
    low, high = low - (high - low), high + (high - low)
    return [low + face * (high - low) for face in _UNIT_BOX]


def _check_volume(block: MeshSolid, parts: list[MeshSolid], tolerance: float) -> None:
    """Raise ValueError if the sum of the volumes of the parts differs from the volume of the block."""
    missing = abs(sum(part.volume for part in parts) - block.volume)
    rounding = tolerance * block.area
    edge = block.unclosed()
    if edge is not None and missing > rounding:
        start, end = map(place, edge)
        raise ValueError(
            f"the block is not closed at its edge from {start} to {end}: each edge must belong to two faces"
        )
    if missing > _MOST_THIN_VOLUME * abs(block.volume) + rounding:
        share = missing / abs(block.volume)
        raise ValueError(
            f"the block has {share:.2%} of its volume in places thinner than twice the tolerance "
            f"{rounded(tolerance)}: lower 'tolerance', or remove the thin places"
        )


def _pieces(points: np.ndarray, sides: list[Side], tolerance: float) -> _Pieces:
    """Divide all sides of a block into convex pieces."""
    rings: list[np.ndarray] = []
    numbers: list[int] = []
    for number, side in enumerate(sides):
        outer_ring, *holes = side.flat(points)
        try:
            convex_rings = convex_pieces(shapely.Polygon(outer_ring, holes), tolerance)
        except shapely.errors.GEOSException:
            raise ValueError(
                "the block has a face that crosses itself: list the corners of the face in order along its "
                "outline"
            ) from None
        rings += [side.base + piece @ across(side.normal) for piece in convex_rings]
        numbers += [number] * len(convex_rings)
    return _Pieces(rings, np.array(numbers, dtype=int))


def _best_side(pieces: _Pieces, base: np.ndarray, normal: np.ndarray, tolerance: float) -> int:
    """Return the index of the side along whose plane a cell is divided next.

    Planes without pieces in front of them are chosen first. Among several planes, a plane that cuts the
    fewest pieces is chosen, and then a plane that contains the most pieces.
    """
    planes = np.unique(pieces.side)
    low, high = pieces.heights(base[planes], normal[planes])
    is_ahead, is_behind = high > tolerance, low < -tolerance
    cut_count, contained_count = (is_ahead & is_behind).sum(axis=0), (~is_ahead & ~is_behind).sum(axis=0)
    return int(planes[np.lexsort((-contained_count, cut_count, is_ahead.any(axis=0)))[0]])


def _divide(pieces: _Pieces, base: np.ndarray, normal: np.ndarray, tolerance: float) -> list[_Pieces]:
    """Divide pieces along a plane into pieces in front of the plane and pieces behind the plane.

    Pieces in the plane are left out.
    """
    low, high = (bound[:, 0] for bound in pieces.heights(base[None], normal[None]))
    is_ahead, is_behind = high > tolerance, low < -tolerance

    def half(is_chosen: np.ndarray, is_cut: np.ndarray, normal: np.ndarray) -> _Pieces:
        rings = []
        for number in np.flatnonzero(is_chosen):
            ring = pieces.rings[number]
            rings.append(_cut(ring, base, normal)[0] if is_cut[number] else ring)
        return _Pieces(rings, pieces.side[is_chosen])

    return [half(is_ahead, is_behind, -normal), half(is_behind, is_ahead, normal)]


def _cut(ring: np.ndarray, base: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the part of a convex polygon behind a plane, and the corners of this part on the plane."""
    height = (ring - base) @ normal
    next_corner, next_height = np.roll(ring, -1, axis=0), np.roll(height, -1)
    crosses = (height > 0) != (next_height > 0)
    share = np.divide(height, height - next_height, out=np.zeros_like(height), where=crosses)
    # Insert after each corner the point at which the following side of the polygon crosses the plane.
    points = np.stack([ring, ring + share[:, None] * (next_corner - ring)], axis=1).reshape(-1, 3)
    is_behind = np.column_stack([height <= 0, crosses]).ravel()
    is_in_plane = np.column_stack([height == 0, crosses]).ravel()
    return points[is_behind], points[is_in_plane]


def _clip(cell: list[np.ndarray], base: np.ndarray, normal: np.ndarray) -> list[np.ndarray]:
    """Cut a convex polyhedron at a plane, and return the faces of the part behind the plane."""
    cuts = [_cut(ring, base, normal) for ring in cell]
    faces = [ring for ring, _ in cuts if len(ring) > 2]
    lid = np.concatenate([corners for _, corners in cuts])
    if len(lid) > 2 and len(faces) > 1:
        u, v = across(normal)
        offset = lid - lid.mean(axis=0)
        faces.append(lid[np.argsort(np.arctan2(offset @ v, offset @ u))])
    return faces


def _parts_in_cell(cell: list[np.ndarray], surface: np.ndarray, tolerance: float) -> list[MeshSolid]:
    """Return a list with the convex polyhedron that fills a cell, or an empty list if the cell is not a part.

    A cell is not a part if it is outside the block or thinner than twice the tolerance. Raises ValueError
    if the cell is inside a surface that crosses itself.
    """
    points = np.concatenate(cell)
    middle = points.mean(axis=0)
    winding = winding_number(middle, surface)
    if abs(winding) < 0.5:
        return []
    shape = _hull(points[np.unique(first_near(points, tolerance / 4))], tolerance)
    if shape is None:
        return []
    if not 0.5 < winding < 1.5:
        raise ValueError(
            f"the block has faces that cross or coincide near {place(middle)}: draw one closed surface"
        )
    return [shape]


def _hull(corners: np.ndarray, tolerance: float) -> MeshSolid | None:
    """Return the convex hull of points, or None if the hull is thinner than twice the tolerance.

    The surface of the hull is closed in spite of rounding errors of the points.
    """
    # Import scipy.spatial only here, because the import takes 0.1 s and few scenes need it.
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(corners)
        mesh = Mesh("", corners, hull.simplices.tolist())
        shape = polyhedron(mesh, tolerance / 4)
        # Narrow triangles that are merged into one side may make the plane of the side inaccurate, so that
        # the shape is not convex. If so, merge fewer triangles.
        if not shape.convex(tolerance):
            shape = polyhedron(mesh, _COPLANAR_SHARE * tolerance)
    except (QhullError, ValueError):
        return None
    return shape if 2 * hull.volume > _THINNEST * tolerance * hull.area else None

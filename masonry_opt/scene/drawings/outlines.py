"""Outlines of blocks from the curves of a drawing: closed ones with their holes, and the cells of a net."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import shapely
from scipy.spatial import cKDTree

from masonry_opt.scene.drawings.meshes import first_near, rings_of
from masonry_opt.scene.geometry import RELATIVE_TOLERANCE

_SAME = 1e-9  #: Part of the area by which outlines within each other differ if they are the same.
_GRID = 0.01  #: Share of what is rounding: the grid on which lines of a net cross.
_STRAIGHT = 10.0  #: Corners so many steps of that off the line without them are none.


@dataclass(frozen=True)
class Curve:
    """A chain of straight lines through points, shape (points, 2), with layer and handle of its entity."""

    points: np.ndarray
    closed: bool
    layer: str
    handle: str
    kind: str

    @property
    def where(self) -> str:
        """The curve as an error names it."""
        return f"{self.kind} {self.handle} on layer '{self.layer}'"


@dataclass(frozen=True)
class Outline:
    """An outline with its holes, and the curve that is its outline."""

    polygon: shapely.Polygon
    curve: Curve


def closed_outlines(curves: Sequence[Curve], tolerance: float, rounding: float) -> list[Curve]:
    """The closed curves, and the loops that the open ones of a layer make, in the order of the drawing. Two
    ends meet within rounding, or else within the tolerance where no third end without one is as near. Raises
    ValueError, naming the curve, if one is open and does not belong to a simple loop."""
    outlines, open_ones = [], defaultdict(list)
    for number, curve in enumerate(curves):
        extent = np.ptp(curve.points, axis=0).max()
        if curve.closed or math.dist(curve.points[0], curve.points[-1]) <= tolerance < extent:
            outlines.append((number, curve))
        else:
            open_ones[curve.layer].append((number, curve))
    for of_layer in open_ones.values():
        outlines += _loops(of_layer, (rounding, tolerance))
    return [curve for _, curve in sorted(outlines, key=lambda entry: entry[0])]


def _loops(curves: list[tuple[int, Curve]], tolerances: Sequence[float]) -> list[tuple[int, Curve]]:
    """Loops of open curves, each with the number of its first; ends meet within the first tolerance that
    leaves them one other end."""
    ends = np.array([curve.points[end] for _, curve in curves for end in (0, -1)])
    partner: dict[int, int] = {}
    free = np.arange(len(ends))
    for tolerance in tolerances:
        node = first_near(ends[free], tolerance)
        meeting = np.bincount(node)[node]
        by_node = np.argsort(node, kind="stable")
        for a, b in free[by_node[meeting[by_node] == 2]].reshape(-1, 2).tolist():
            partner[a], partner[b] = b, a
        free, meeting = free[meeting != 2], meeting[meeting != 2]
        if not len(free):
            break
    else:  # ends are left
        curve, (x, y) = curves[free[0] // 2][1], ends[free[0]] + 0.0
        gap, others = np.sort(np.hypot(*(ends[free] - ends[free[0]]).T))[1], meeting[0] - 1
        told = f"is open: no other end of its layer is nearer than {gap:.3g} to its end"
        change = "raise 'outline_tolerance'"
        if others:
            told, change = f"meets {others} other ends", "lower 'outline_tolerance' to part them"
        raise ValueError(
            f"{curve.where} {told} at ({x:g}, {y:g}): draw blocks as closed polylines, {change}, name the "
            "blocks' 'layers', or say 'net' (--net) if all lines are joints"
        )
    # From each end at which a curve is entered to that of the next; loops begin with their first curve.
    loops = []
    for ring in rings_of({end: partner[end ^ 1] for end in range(len(ends))}):
        if ring[0] % 2 == 0:  # the others are the same backwards
            parts = [curves[end // 2][1].points[:: -1 if end % 2 else 1] for end in ring]
            number, curve = curves[ring[0] // 2]
            loops.append((number, replace(curve, points=np.concatenate(parts), closed=True)))
    return loops


def outlines_with_holes(outlines: Sequence[Curve], tolerance: float, overlap: float) -> list[Outline]:
    """Blocks with their holes: an outline inside one other, but for an overlap, is a hole of it, one inside a
    hole a block, and so on in turns. Of two outlines that are the same the first is the outer one. Raises
    ValueError, naming the outlines, if one has no area or crosses itself, or is drawn twice."""
    polygons = np.array([_polygon(curve, tolerance) for curve in outlines], dtype=object)
    area = shapely.area(polygons)
    inner, outer = shapely.STRtree(polygons).query(shapely.point_on_surface(polygons), predicate="within")
    same = np.abs(area[inner] - area[outer]) <= _SAME * area[outer]
    inside = np.where(same, inner > outer, area[inner] < area[outer])
    inner, outer = inner[inside], outer[inside]
    rest = shapely.area(shapely.difference(polygons[inner], polygons[outer]))
    covered = rest <= overlap * shapely.length(polygons[inner])
    inner, outer = inner[covered], outer[covered]
    depth = np.bincount(inner, minlength=len(polygons))
    holes: defaultdict[int, list[shapely.LinearRing]] = defaultdict(list)
    for index in np.flatnonzero(depth % 2).tolist():
        parent = min(outer[inner == index].tolist(), key=lambda other: (-depth[other], area[other]))
        if area[index] >= (1 - _SAME) * area[parent]:
            raise ValueError(
                f"{outlines[index].where} is drawn again as {outlines[parent].where}: delete one"
            )
        holes[parent].append(polygons[index].exterior)
    return [
        Outline(shapely.Polygon(polygons[index].exterior, holes[index]), outlines[index])
        for index in np.flatnonzero(depth % 2 == 0).tolist()
    ]


def _polygon(curve: Curve, tolerance: float) -> shapely.Polygon:
    points = curve.points
    step = np.hypot(*(points - np.roll(points, 1, axis=0)).T)
    points = points[step > tolerance]
    if len(points) < 3 or shapely.Polygon(points).area <= tolerance**2:
        raise ValueError(f"{curve.where} has no area: delete it")
    polygon = shapely.Polygon(points)
    if not polygon.is_valid:
        raise ValueError(f"{curve.where} crosses itself: draw its corners in order round the block")
    return shapely.orient_polygons(polygon)


def net_cells(
    joints: Sequence[Curve], windows: Sequence[Curve], drawn: Sequence[shapely.Polygon], tolerance: float
) -> list[Outline]:
    """The cells between joints, windows and blocks drawn whole, from below and from the left; without those
    inside these blocks, and inside what the lines of windows enclose.

    Lines may cross and branch. Ends that stop short of another line by no more than the tolerance go on to
    it, and cells narrower than that are none. A cell is on the layer of the first joint drawn along it.

    Raises ValueError, naming the curve, if a joint ends within a cell, which it does not divide, or the line
    of a window encloses none with others of windows.
    """
    points = [[*own.points, *own.points[: int(own.closed)]] for own in (*joints, *windows)]
    lines = np.array([shapely.LineString(own) for own in points], dtype=object)
    every = np.concatenate([lines, shapely.boundary(np.array(drawn, dtype=object))])
    size = float(np.hypot(*np.ptp(shapely.get_coordinates(every), axis=0)))
    grid = _GRID * min(tolerance, RELATIVE_TOLERANCE * size)
    cells, *loose, _ = map(shapely.get_parts, shapely.polygonize_full(_noded(every, tolerance, grid)))
    _refuse_loose(joints, every, np.concatenate(loose), tolerance)
    found = shapely.simplify(shapely.normalize(cells), _STRAIGHT * grid)
    found = shapely.transform(found, partial(_as_drawn, shapely.get_coordinates(every), grid))
    of_windows = lines[len(joints) :]
    openings = shapely.union_all(shapely.get_parts(shapely.polygonize(_noded(of_windows, tolerance, grid))))
    _refuse_open(windows, of_windows, openings, tolerance)
    outside = ~shapely.within(shapely.point_on_surface(found), shapely.union_all([*drawn, openings]))
    found = found[outside & (2 * shapely.area(found) > tolerance * shapely.length(found))]
    left, low, _, _ = shapely.bounds(found).T
    found = shapely.orient_polygons(found[np.lexsort((left, np.round(low / tolerance)))])
    tree, outlines = shapely.STRtree(lines[: len(joints)]), []
    for number, cell in enumerate(found, start=1):
        beside = tree.query(cell.exterior, "dwithin", tolerance)
        layer = joints[beside.min()].layer if len(beside) else joints[0].layer
        corners = shapely.get_coordinates(cell.exterior)[:-1]
        outlines.append(Outline(cell, Curve(corners, True, layer, str(number), "cell")))
    return outlines


def _refuse_loose(joints: Sequence[Curve], lines: np.ndarray, loose: np.ndarray, tolerance: float) -> None:
    for piece in loose[shapely.length(loose) > tolerance]:
        middle = piece.interpolate(0.5, normalized=True)
        if (owner := int(shapely.STRtree(lines).nearest(middle))) < len(joints):
            raise ValueError(
                f"{joints[owner].where} divides no stone round ({middle.x:g}, {middle.y:g}), along "
                f"{piece.length:.3g}: let it end on another line, raise 'outline_tolerance', or leave its "
                "layer out by 'without_layers'"
            )


def _refuse_open(
    windows: Sequence[Curve], lines: np.ndarray, openings: shapely.Geometry, tolerance: float
) -> None:
    closed = shapely.buffer(openings, tolerance)
    for window, line in zip(windows, lines, strict=True):
        if shapely.length(shapely.difference(line, closed)) > tolerance:
            raise ValueError(
                f"{window.where} encloses no opening with other lines of windows: draw openings whole, sill "
                "and threshold too, or leave the layer out by 'without_layers'"
            )


def _as_drawn(given: np.ndarray, grid: float, corners: np.ndarray) -> np.ndarray:
    """Corners, those that the grid has moved where they were given."""
    off, number = cKDTree(given).query(corners)
    return np.where((off <= grid)[:, None], given[number], corners)


def _noded(lines: np.ndarray, tolerance: float, grid: float) -> np.ndarray:
    """Lines divided where they meet, and short ones from their ends to what these miss."""
    ends = shapely.get_point(np.repeat(lines, 2), np.tile([0, -1], len(lines)))
    end, other = shapely.STRtree(lines).query(ends, predicate="dwithin", distance=tolerance)
    missed = shapely.shortest_line(ends[end], lines[other])[end // 2 != other]
    return shapely.get_parts(shapely.union_all([*lines, *missed[shapely.length(missed) > 0]], grid_size=grid))

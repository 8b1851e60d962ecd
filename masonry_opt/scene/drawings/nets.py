"""Closed cells of a net of joint lines, as most surveys draw stones."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import shapely
from scipy.spatial import cKDTree

from masonry_opt.scene.drawings.outlines import Curve, Outline
from masonry_opt.scene.extents import RELATIVE_TOLERANCE

#: Share of what is rounding: the grid on which lines cross. So many steps of that off the line without them
#: corners are none.
_GRID, _STRAIGHT = 0.01, 10.0


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

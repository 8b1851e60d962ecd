"""Curves and texts of a DXF file, and outlines of blocks: closed ones with holes, and the cells of a net."""

import logging
import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from scipy.spatial import cKDTree

from masonry_opt.errors import CaseError
from masonry_opt.scene.drawings.meshes import first_near, rings_of
from masonry_opt.scene.geometry import RELATIVE_TOLERANCE
from masonry_opt.scene.tables import broken, library, read_bytes

_LARGEST_DXF = 50_000_000  #: Bytes; a DXF file has some 500 for each block.
_TOO_MANY = 4000  #: Points of one curve: no drawing of masonry needs more.
SAGITTA = 1e-4  #: Largest distance of a curve from its chords, over the drawing's diagonal, by default.
_SAME = 1e-9  #: Part of the area by which outlines within each other differ if they are the same.
_GRID = 0.01  #: Share of what is rounding: the grid on which lines of a net cross.
_STRAIGHT = 10.0  #: Corners so many steps of that off the line without them are none.
#: Entities that are outlines, or parts of one.
_READ = {"ARC", "CIRCLE", "ELLIPSE", "LINE", "LWPOLYLINE", "POLYLINE", "SPLINE"}
#: Entities that are no blocks. Others that cannot be read are refused: none is left out in silence.
_IGNORED = {
    "ATTDEF", "ARC_DIMENSION", "DIMENSION", "HATCH", "IMAGE", "LARGE_RADIAL_DIMENSION", "LEADER", "LIGHT",
    "MTEXT", "MULTILEADER", "OLE2FRAME", "PDFUNDERLAY", "POINT", "RAY", "SUN", "TEXT", "TOLERANCE",
    "VIEWPORT", "WIPEOUT", "XLINE",
}  # fmt: skip
#: What may hide outlines, in words.
_HIDING = {"INSERT": "a reference to a block definition", "MLINE": "a multiline", "REGION": "a region"}
#: Metres in one unit of the drawing, by its code $INSUNITS (DXF reference, HEADER section).
_METRES = {
    1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 8: 2.54e-8, 9: 2.54e-5,
    10: 0.9144, 13: 1e-6, 14: 0.1, 15: 10.0, 16: 100.0, 21: 1200 / 3937,
}  # fmt: skip


class Curve(NamedTuple):
    """A chain of straight lines through points, shape (points, 2), with layer and handle of its entity."""

    points: np.ndarray
    closed: bool
    layer: str
    handle: str
    where: str = ""  #: the entity as an error names it


class Outline(NamedTuple):
    """A polygon with its holes, and the curve that is its outline."""

    polygon: shapely.Polygon
    curve: Curve


def ezdxf() -> Any:
    """The library that reads and writes DXF; OptionError if it is not installed."""
    found = library("ezdxf", "DXF needs ezdxf; install it with: pip install '.[drawings]'")
    # What it logs goes where the user's handlers take it, not to standard error.
    logging.getLogger("ezdxf").addHandler(logging.NullHandler())
    return found


def read_document(path: Path) -> Any:
    """The document of a DXF file, text or binary. Raises CaseError if it cannot be read or is no DXF file."""
    reader = ezdxf()
    read_bytes(path, _LARGEST_DXF, ": keep the layers of the blocks alone")
    with broken(lambda said: CaseError(f"{path}: not valid DXF: {said}; save the drawing as DXF again")):
        document = reader.readfile(path)
        document.modelspace()  # which must be there
    return document


def metres(document: Any) -> float:
    """Metres in one unit of the drawing. Raises ValueError if it names no unit of length."""
    code = document.header.get("$INSUNITS", 0)
    if code not in _METRES:
        raise ValueError("names no unit ($INSUNITS): set it in the drawing, or do without scaling to metres")
    return _METRES[code]


def visible(document: Any) -> list[Any]:
    """The entities of the model space that are not hidden, nor on a layer that is off or frozen."""
    hidden = {layer.dxf.name.casefold() for layer in document.layers if layer.is_off() or layer.is_frozen()}
    shown = (entity for entity in document.modelspace() if not _attribute(entity, "invisible", 0))
    return [entity for entity in shown if layer_of(entity).casefold() not in hidden]


def layer_of(entity: Any) -> str:
    """Name of the layer of an entity."""
    return str(_attribute(entity, "layer", "0"))


def _attribute(entity: Any, name: str, default: object) -> Any:
    return entity.dxf.get(name, default) if entity.dxf.is_supported(name) else default


def curves(entities: list[Any], scale: float, sagitta: float | None) -> tuple[list[Curve], float]:
    """Outlines among entities of a drawing, as chains of straight lines, all lengths times a scale; and the
    diagonal round them. Raises ValueError, naming the entity, if one cannot be read as an outline."""
    from ezdxf.edgesmith import is_closed_entity

    drawn = [entity for entity in entities if entity.dxftype() not in _IGNORED]
    if not drawn:
        return [], 0.0
    corners = np.concatenate([_chain(entity, math.inf) for entity in drawn])
    diagonal = scale * float(np.hypot(*np.ptp(corners, axis=0)))
    # Of counts that rounding decides the lower one, from both sides of a joint.
    reach = (1 + 1e-9) * (sagitta or SAGITTA * diagonal) / scale
    found = []
    for entity in drawn:
        points = scale * _chain(entity, reach)
        of = layer_of(entity), str(entity.dxf.handle), _named(entity)
        found.append(Curve(points, bool(is_closed_entity(entity)), *of))
    return found, diagonal


def _chain(entity: Any, sagitta: float) -> np.ndarray:
    """Points along an entity, shape (points, 2), whose chords are no farther from it than the sagitta."""
    kind = entity.dxftype()
    if kind not in _READ or (kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline)):
        what = _HIDING.get(kind, "of a kind that is not read")
        raise ValueError(f"{_named(entity)} is {what}: explode it, outline it, or leave it out by 'layers'")
    with broken(lambda said: ValueError(f"{_named(entity)} cannot be read: {said}; draw it anew")):
        points = np.array([point.xyz for point in _points(entity, sagitta)], dtype=float).reshape(-1, 3)
    if len(points) == 0 or not np.isfinite(points).all():
        raise ValueError(f"{_named(entity)} has no points, or one that is no number: delete it")
    if np.ptp(points[:, 2]) > 1e-6 * np.ptp(points[:, :2], axis=0).max():
        raise ValueError(f"{_named(entity)} does not lie in the drawing's xy plane: turn or flatten it")
    return points[:, :2]


def _points(entity: Any, sagitta: float) -> list[Any]:
    """The points, in the drawing's coordinates; of an arc those of equal chords, the same from either end."""
    from ezdxf.math.arc import arc_segment_count

    dxf = entity.dxf
    match entity.dxftype():
        case "LINE":
            return [dxf.start, dxf.end]
        case "CIRCLE" | "ARC" as kind:
            start, end = (dxf.start_angle, dxf.end_angle) if kind == "ARC" else (0.0, 360.0)
            angle = (end - start) % 360 or 360.0
            parts = 1 if angle < 270 else 2  # a chord alone says nothing of a whole circle
            count = arc_segment_count(abs(dxf.radius), math.radians(angle / parts), sagitta)
            found = entity.vertices(np.linspace(start, start + angle, min(count, _TOO_MANY) * parts + 1))
        case "LWPOLYLINE" | "POLYLINE":
            if entity.dxftype() == "POLYLINE":
                # Corners of the frame that a smoothed polyline was drawn from are no points of it.
                entity.vertices[:] = [vertex for vertex in entity.vertices if not vertex.dxf.flags & 16]
                corners = list(entity.points_in_wcs())
            else:
                corners = list(entity.vertices_in_wcs())
            if not entity.has_arc:
                return corners
            points = corners[:1]
            for part in entity.virtual_entities():
                own = _points(part, sagitta)
                # Arcs run counter-clockwise, whatever way the polyline takes.
                turned = own[-1].distance(points[-1]) < own[0].distance(points[-1])
                points += own[-2::-1] if turned else own[1:]
            return points[:-1] if entity.is_closed else points
        case "SPLINE" if not entity.construction_tool().is_clamped:  # ezdxf goes on beyond its ends
            raise ValueError("is a periodic spline")
        case _:
            found = entity.flattening(sagitta)
    points = list(islice(found, _TOO_MANY + 1))
    if len(points) > _TOO_MANY:
        raise ValueError(f"needs more than {_TOO_MANY} chords: raise 'sagitta'")
    return points


def texts(entities: list[Any]) -> Iterator[tuple[str, float, float]]:
    """Each text, and the point that it stands at."""
    for entity in entities:
        match entity.dxftype():
            case "TEXT":
                at, text = entity.ocs().to_wcs(entity.get_placement()[1]), str(entity.dxf.text)
            case "MTEXT":
                at, text = entity.dxf.insert, entity.plain_text()
            case _:
                continue
        if math.isfinite(at[0]) and math.isfinite(at[1]):
            yield text, float(at[0]), float(at[1])


def _named(entity: Any) -> str:
    return f"{entity.dxftype()} {entity.dxf.handle} on layer '{layer_of(entity)}'"


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
    """Loops of open curves, with the number of the first of each; ends meet as in closed_outlines."""
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
        instead = "name the blocks' 'layers', or say 'net' (--net) if all lines are joints"
        remedy = f"draw blocks as closed polylines, {change}, {instead}"
        raise ValueError(f"{curve.where} {told} at ({x:g}, {y:g}): {remedy}")
    # From each end at which a curve is entered to that of the next; loops begin with their first curve.
    loops = []
    for ring in rings_of({end: partner[end ^ 1] for end in range(len(ends))}):
        if ring[0] % 2 == 0:  # the others are the same backwards
            parts = [curves[end // 2][1].points[:: -1 if end % 2 else 1] for end in ring]
            number, curve = curves[ring[0] // 2]
            loops.append((number, curve._replace(points=np.concatenate(parts), closed=True)))
    return loops


def outlines_with_holes(outlines: Sequence[Curve], tolerance: float, overlap: float) -> list[Outline]:
    """Blocks with their holes: an outline inside one other, but for an overlap, is a hole of it, one inside a
    hole a block, and so on in turns. Of two that are the same the first is the outer one. Raises ValueError,
    naming it, if one has no area, crosses itself, or is drawn twice."""
    polygons = np.array([_polygon(curve, tolerance) for curve in outlines], dtype=object)
    area = shapely.area(polygons)
    inner, outer = shapely.STRtree(polygons).query(shapely.point_on_surface(polygons), predicate="within")
    same = np.abs(area[inner] - area[outer]) <= _SAME * area[outer]
    inside = np.where(same, inner > outer, area[inner] < area[outer])
    rest = shapely.area(shapely.difference(polygons[inner], polygons[outer]))
    inside &= rest <= overlap * shapely.length(polygons[inner])
    inner, outer = inner[inside], outer[inside]
    depth = np.bincount(inner, minlength=len(polygons))
    holes: defaultdict[int, list[shapely.LinearRing]] = defaultdict(list)
    for index in np.flatnonzero(depth % 2).tolist():
        parent = min(outer[inner == index].tolist(), key=lambda other: (-depth[other], area[other]))
        if area[index] >= (1 - _SAME) * area[parent]:
            where, again = outlines[index].where, outlines[parent].where
            raise ValueError(f"{where} is drawn again as {again}: delete one")
        holes[parent].append(polygons[index].exterior)
    blocks = np.flatnonzero(depth % 2 == 0).tolist()
    return [Outline(shapely.Polygon(polygons[one].exterior, holes[one]), outlines[one]) for one in blocks]


def _polygon(curve: Curve, tolerance: float) -> shapely.Polygon:
    step = np.hypot(*(curve.points - np.roll(curve.points, 1, axis=0)).T)
    points = curve.points[step > tolerance]
    polygon = shapely.Polygon(points if len(points) > 2 else None)
    if polygon.area <= tolerance**2:
        raise ValueError(f"{curve.where} has no area: delete it")
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
    given = shapely.get_coordinates(every)
    size = float(np.hypot(*np.ptp(given, axis=0)))
    grid = _GRID * min(tolerance, RELATIVE_TOLERANCE * size)
    cells, *loose, _ = map(shapely.get_parts, shapely.polygonize_full(_noded(every, tolerance, grid)))
    _refuse_loose(joints, every, np.concatenate(loose), tolerance)
    found = shapely.simplify(shapely.normalize(cells), _STRAIGHT * grid)
    # Corners that the grid has moved go back to where they were given.
    corners = shapely.get_coordinates(found)
    off, number = cKDTree(given).query(corners)
    shapely.set_coordinates(found, np.where((off <= grid)[:, None], given[number], corners))
    of_windows = lines[len(joints) :]
    openings = shapely.union_all(shapely.get_parts(shapely.polygonize(_noded(of_windows, tolerance, grid))))
    closed = shapely.buffer(openings, tolerance)
    for window, line in zip(windows, of_windows, strict=True):
        if shapely.length(shapely.difference(line, closed)) > tolerance:
            whole = "draw openings whole, sill and threshold too, or leave the layer out by 'without_layers'"
            raise ValueError(f"{window.where} encloses no opening with other lines of windows: {whole}")
    outside = ~shapely.within(shapely.point_on_surface(found), shapely.union_all([*drawn, openings]))
    found = found[outside & (2 * shapely.area(found) > tolerance * shapely.length(found))]
    left, low, _, _ = shapely.bounds(found).T
    found = shapely.orient_polygons(found[np.lexsort((left, np.round(low / tolerance)))])
    tree, outlines = shapely.STRtree(lines[: len(joints)]), []
    for number, cell in enumerate(found, start=1):
        beside = tree.query(cell.exterior, "dwithin", tolerance)
        layer = joints[beside.min()].layer if len(beside) else joints[0].layer
        corners = shapely.get_coordinates(cell.exterior)[:-1]
        outlines.append(Outline(cell, Curve(corners, True, layer, str(number))))
    return outlines


def _refuse_loose(joints: Sequence[Curve], lines: np.ndarray, loose: np.ndarray, tolerance: float) -> None:
    for piece in loose[shapely.length(loose) > tolerance]:
        middle = piece.interpolate(0.5, normalized=True)
        if (owner := int(shapely.STRtree(lines).nearest(middle))) < len(joints):
            at = f"round ({middle.x:g}, {middle.y:g}), along {piece.length:.3g}"
            remedy = "raise 'outline_tolerance', or leave its layer out by 'without_layers'"
            why = f"divides no stone {at}: let it end on another line, {remedy}"
            raise ValueError(f"{joints[owner].where} {why}")


def _noded(lines: np.ndarray, tolerance: float, grid: float) -> np.ndarray:
    """Lines divided where they meet, and short ones from their ends to what these miss."""
    ends = shapely.get_point(np.repeat(lines, 2), np.tile([0, -1], len(lines)))
    end, other = shapely.STRtree(lines).query(ends, predicate="dwithin", distance=tolerance)
    missed = shapely.shortest_line(ends[end], lines[other])[end // 2 != other]
    return shapely.get_parts(shapely.union_all([*lines, *missed[shapely.length(missed) > 0]], grid_size=grid))

"""Read curves and texts of a DXF file, and make outlines of blocks.

An outline is a closed curve, or a cell of a network of joint lines.
"""

import logging
import math
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely

from masonry_opt.errors import CaseError, rounded
from masonry_opt.scene.drawings.defects import WIDEST_ERROR, WIDEST_GAP, Defect, Defects, near
from masonry_opt.scene.geometry import RELATIVE_TOLERANCE
from masonry_opt.scene.tables import broken, library, read_bytes

#: Largest size of a DXF file, in bytes. A larger file raises an error. A block needs about 500 bytes.
_LARGEST_DXF = 50_000_000

#: Largest number of points of one curve. A curve that needs more points raises an error. Curves in drawings
#: of masonry need far fewer points.
_MOST_POINTS = 4000

#: Default of the largest distance of a curve from its chords, relative to the drawing's diagonal. A smaller
#: value produces more chords.
DEFAULT_SAGITTA = 1e-4

#: Step of the grid to which intersections of joint lines are rounded. The step is relative to the tolerance
#: of the outlines or the default tolerance of a scene, whichever is smaller.
_GRID_SHARE = 0.01

#: A corner of a cell is removed if its distance from the line between the previous and the next corner is at
#: most this many grid steps.
_STRAIGHT_STEPS = 10.0

#: DXF entities that are read as outlines or as parts of outlines.
_READ_ENTITIES = {"ARC", "CIRCLE", "ELLIPSE", "LINE", "LWPOLYLINE", "POLYLINE", "SPLINE"}
#: DXF entities that cannot be blocks and are ignored. All other entities that cannot be read raise an error.
_IGNORED = {
    "ATTDEF", "ATTRIB", "ARC_DIMENSION", "DIMENSION", "HATCH", "IMAGE", "LARGE_RADIAL_DIMENSION", "LEADER",
    "LIGHT", "MTEXT", "MULTILEADER", "OLE2FRAME", "PDFUNDERLAY", "POINT", "RAY", "SUN", "TEXT", "TOLERANCE",
    "VIEWPORT", "WIPEOUT", "XLINE",
}  # fmt: skip
#: Names, for messages, of DXF entities that may contain outlines but are not read.
_UNREAD_ENTITIES = {
    "INSERT": "a reference to a block definition that is empty or cannot be placed",
    "MLINE": "a multiline",
    "REGION": "a region",
}
#: Length of the drawing's unit in metres, by the code $INSUNITS (DXF reference, HEADER section).
_METRES = {
    1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 8: 2.54e-8, 9: 2.54e-5,
    10: 0.9144, 13: 1e-6, 14: 0.1, 15: 10.0, 16: 100.0, 21: 1200 / 3937,
}  # fmt: skip


#: Beginning of the color names that mark the parts of a closed polyline.
_POLYLINE_MARK = "part of polyline "


class Curve(NamedTuple):
    """Polyline that represents a curve or line of a DXF drawing."""

    points: np.ndarray  #: coordinates of the points, shape (points, 2)
    closed: bool
    layer: str  #: name of the drawing layer of the curve
    handle: str  #: handle of the curve in the DXF file
    label: str = ""  #: kind, handle and layer of the curve's entity, for error messages
    polyline: str = ""  #: label of the closed polyline to which the curve belongs; empty if there is none


class Outline(NamedTuple):
    """A polygon with its holes, and the curves of its outer ring and of its holes."""

    polygon: shapely.Polygon
    curve: Curve
    holes: tuple[Curve, ...] = ()  #: curves of the holes; empty for a cell between joint lines


def ezdxf() -> Any:
    """Import the library that reads and writes DXF. Raises OptionError if it is not installed."""
    package = library("ezdxf", "DXF drawings need ezdxf: install it with pip install '.[drawings]'")
    # Without this handler, Python would print warnings of ezdxf to standard error.
    logging.getLogger("ezdxf").addHandler(logging.NullHandler())
    return package


def read_document(path: Path) -> Any:
    """Read a DXF file, text or binary, and return its ezdxf document.

    Raises CaseError if the file cannot be read or is not a DXF file.
    """
    reader = ezdxf()
    read_bytes(path, _LARGEST_DXF, "delete all layers except the layers of the blocks")
    with broken(
        lambda reason: CaseError(
            f"{path}: the file is not valid DXF ({_without_path(reason, path)}): "
            "save the drawing as DXF again"
        )
    ):
        document = reader.readfile(path)
        document.modelspace()  # raises an error if the document has no model space
    return document


def _without_path(reason: str, path: Path) -> str:
    """Return the reason of an error without the path of the file, which the message names already."""
    return reason.replace(f"File '{path}'", "it").rstrip(".")


def metres(document: Any) -> float | None:
    """Return the length of the drawing's unit in metres, or None if the drawing has no unit."""
    return _METRES.get(document.header.get("$INSUNITS", 0))


def hidden_layers(document: Any) -> dict[str, str]:
    """Return a dict that maps the lower-case name of each hidden layer to "frozen" or "off"."""
    return {
        decoded(layer.dxf.name).casefold(): "frozen" if layer.is_frozen() else "off"
        for layer in document.layers
        if layer.is_off() or layer.is_frozen()
    }


def visible(document: Any, entities: list[Any]) -> list[Any]:
    """Return the visible entities among those drawn in the model space.

    Entities that are hidden, or on a layer that is off or frozen, are not visible.
    """
    layers = hidden_layers(document)
    unhidden_entities = (entity for entity in entities if not attribute(entity, "invisible", 0))
    return [entity for entity in unhidden_entities if layer_of(entity).casefold() not in layers]


def is_ignored(entity: Any) -> bool:
    """Return True if an entity is ignored because its type, such as a text, cannot be a block."""
    return entity.dxftype() in _IGNORED


def layer_of(entity: Any) -> str:
    """Return the name of the layer on which an entity is drawn."""
    return decoded(str(attribute(entity, "layer", "0")))


def decoded(text: str) -> str:
    """Return a text of a DXF file, with codes such as ``\\U+00e9`` replaced by characters.

    Files of old versions contain such codes for characters that their encoding lacks.
    """
    from ezdxf.lldxf.encoding import decode_dxf_unicode

    return str(decode_dxf_unicode(text))


def mark_polyline(entity: Any, mark: str) -> None:
    """Mark an entity as a part of a closed polyline, so that it is joined only to the other parts.

    The mark is stored as the name of the entity's color, which ezdxf copies to all parts of a polyline.
    """
    entity.dxf.color_name = f"{_POLYLINE_MARK}{mark}"


def polyline_mark(entity: Any) -> str:
    """Return the label of the closed polyline to which an entity belongs; empty if it belongs to none."""
    color_name = str(attribute(entity, "color_name", ""))
    return color_name.removeprefix(_POLYLINE_MARK) if color_name.startswith(_POLYLINE_MARK) else ""


def attribute(entity: Any, name: str, default: object) -> Any:
    """Return an attribute of an entity, or the default if the entity lacks the attribute."""
    return entity.dxf.get(name, default) if entity.dxf.is_supported(name) else default


def curves(
    entities: list[Any], scale: float, sagitta: float | None, defects: Defects
) -> tuple[list[Curve], np.ndarray]:
    """Return the outlines among entities as polylines, and the width and height of the drawing.

    All lengths are multiplied by ``scale``. Entities that cannot be read as outlines are added to the defects
    and left out.
    """
    from ezdxf.edgesmith import is_closed_entity

    readable_entities, ends = [], [np.zeros((0, 2))]
    for entity in entities:
        if is_ignored(entity):
            continue
        corners = _read_curve(entity, math.inf, defects)
        if corners is not None:
            readable_entities.append(entity)
            ends.append(corners)
    if not readable_entities:
        return [], np.zeros(2)
    extent = scale * np.ptp(np.concatenate(ends), axis=0)
    diagonal = float(np.hypot(*extent))
    # Increase the sagitta slightly, so that rounding cannot give the two blocks at a curved joint different
    # numbers of chords.
    reach = (1 + 1e-9) * (sagitta or DEFAULT_SAGITTA * diagonal) / scale
    outlines = []
    for entity in readable_entities:
        points = _read_curve(entity, reach, defects)
        if points is None:
            continue
        is_closed = bool(is_closed_entity(entity))
        handle = str(entity.dxf.handle)
        polyline = "" if is_closed else polyline_mark(entity)
        outlines.append(
            Curve(scale * points, is_closed, layer_of(entity), handle, _describe(entity), polyline)
        )
    return outlines, extent


def _read_curve(entity: Any, sagitta: float, defects: Defects) -> np.ndarray | None:
    """Return points along a curve of the drawing, shape (points, 2).

    The distance between the curve and the chords through these points is at most the sagitta. If the entity
    cannot be read, add a defect and return None.
    """
    try:
        return _checked_points(entity, sagitta)
    except _UnreadableError as error:
        insert = attribute(entity, "insert", None)
        place = "" if insert is None else near(insert.x, insert.y)
        plural_mistake = f"entities cannot be read, because each is {error.description}"
        defects.add(Defect(_describe(entity), f"is {error.description}", plural_mistake, error.remedy, place))
        return None


class _UnreadableError(Exception):
    """Error for an entity of a drawing that cannot be read."""

    def __init__(self, description: str, remedy: str) -> None:
        super().__init__(description)
        self.description, self.remedy = description, remedy


def _checked_points(entity: Any, sagitta: float) -> np.ndarray:
    """Return points along the curve of an entity, shape (points, 2), or raise _UnreadableError.

    See :func:`_read_curve` for the sagitta. The error is raised if the kind of the entity is not supported,
    if ezdxf cannot compute the curve, or if the curve needs too many points. It is also raised if points are
    missing or not finite, or if the entity is not parallel to the xy plane.
    """
    kind = entity.dxftype()
    if kind not in _READ_ENTITIES or (
        kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline)
    ):
        description = _UNREAD_ENTITIES.get(kind, "of a kind that cannot be read")
        raise _UnreadableError(
            description,
            "explode unreadable entities, draw their outlines, or omit their layers with 'without_layers' "
            "(--without-layer)",
        )
    with broken(lambda reason: _UnreadableError(f"not readable ({reason})", "redraw unreadable entities")):
        points = np.array([point.xyz for point in _sample_points(entity, sagitta)], dtype=float).reshape(
            -1, 3
        )
    if len(points) == 0 or not np.isfinite(points).all():
        raise _UnreadableError(
            "an entity without points or with a coordinate that is not a finite number",
            "delete entities without valid points",
        )
    if np.ptp(points[:, 2]) > 1e-6 * np.ptp(points[:, :2], axis=0).max():
        raise _UnreadableError(
            "an entity that is not parallel to the xy plane of the drawing",
            "rotate or flatten inclined entities",
        )
    return points[:, :2]


def _sample_points(entity: Any, sagitta: float) -> list[Any]:
    """Return points along the curve of an entity, as vectors (x, y, z) in the drawing's coordinates.

    The chords of an arc are equal, so that its points do not depend on its direction.
    """
    from ezdxf.math.arc import arc_segment_count

    dxf = entity.dxf
    match entity.dxftype():
        case "LINE":
            return [dxf.start, dxf.end]
        case "CIRCLE" | "ARC" as kind:
            start, end = (dxf.start_angle, dxf.end_angle) if kind == "ARC" else (0.0, 360.0)
            angle = (end - start) % 360 or 360.0
            # ezdxf may compute a single chord for a circle, so circles and long arcs are divided in two.
            parts = 1 if angle < 270 else 2
            count = arc_segment_count(abs(dxf.radius), math.radians(angle / parts), sagitta)
            samples = entity.vertices(np.linspace(start, start + angle, min(count, _MOST_POINTS) * parts + 1))
        case "LWPOLYLINE" | "POLYLINE":
            if entity.dxftype() == "POLYLINE":
                # Remove the corners of the control frame of a smoothed polyline, which are not on the curve.
                entity.vertices[:] = [vertex for vertex in entity.vertices if not vertex.dxf.flags & 16]
                corners = list(entity.points_in_wcs())
            else:
                corners = list(entity.vertices_in_wcs())
            if not entity.has_arc:
                return corners
            points = corners[:1]
            for part in entity.virtual_entities():
                part_points = _sample_points(part, sagitta)
                # DXF arcs are counter-clockwise. Reverse an arc that runs against the direction of the
                # polyline.
                end = points[-1]
                is_reversed = part_points[-1].distance(end) < part_points[0].distance(end)
                points += part_points[-2::-1] if is_reversed else part_points[1:]
            return points[:-1] if entity.is_closed else points
        case "SPLINE" if not entity.construction_tool().is_clamped:
            # Refuse splines that are not clamped at their ends, such as periodic splines, because ezdxf would
            # continue them beyond their ends.
            raise ValueError("the curve is a periodic spline, or a spline that is not clamped at its ends")
        case _:
            samples = entity.flattening(sagitta)
    points = list(islice(samples, _MOST_POINTS + 1))
    if len(points) > _MOST_POINTS:
        raise ValueError(f"the curve needs more than {_MOST_POINTS} chords: raise 'sagitta'")
    return points


def texts(entities: list[Any]) -> Iterator[tuple[str, float, float]]:
    """Yield each text among entities, with the coordinates x and y of its insertion point."""
    for entity in entities:
        match entity.dxftype():
            case "TEXT" | "ATTRIB":
                at, text = entity.ocs().to_wcs(entity.get_placement()[1]), str(entity.dxf.text)
            case "MTEXT":
                at, text = entity.dxf.insert, entity.plain_text()
            case _:
                continue
        if math.isfinite(at[0]) and math.isfinite(at[1]):
            yield decoded(text), float(at[0]), float(at[1])


def _describe(entity: Any) -> str:
    """Return the description of an entity for error messages: its kind, handle and layer."""
    return f"{entity.dxftype()} {entity.dxf.handle} on layer '{layer_of(entity)}'"


def net_cells(
    joints: Sequence[Curve],
    windows: Sequence[Curve],
    supports: Sequence[shapely.Polygon],
    tolerance: float,
    defects: Defects,
) -> list[Outline]:
    """Return the cells of a network of joint lines, sorted from the bottom upwards and from left to right.

    Cells lie between joints, windows and the blocks ``supports``, which are drawn as outlines. Cells inside
    these blocks, and cells that lines of windows enclose, are left out. Lines may cross and branch. Ends that
    miss another line by at most the tolerance are extended to this line. Cells narrower than the tolerance
    are left out. The layer of a cell is the layer of the first joint along its boundary.

    Joints that end inside a cell are added to the defects. Lines of windows that do not enclose an opening
    are added too.
    """
    chains = [[*curve.points, *curve.points[: int(curve.closed)]] for curve in (*joints, *windows)]
    lines = np.array([shapely.LineString(chain) for chain in chains], dtype=object)
    all_lines = np.concatenate([lines, shapely.boundary(np.array(supports, dtype=object))])
    drawn_points = shapely.get_coordinates(all_lines)
    size = float(np.hypot(*np.ptp(drawn_points, axis=0)))
    grid = _GRID_SHARE * min(tolerance, RELATIVE_TOLERANCE * size)
    cells, *loose_pieces, _ = map(
        shapely.get_parts, shapely.polygonize_full(_node_lines(all_lines, tolerance, grid))
    )
    _add_loose_joints(joints, all_lines, np.concatenate(loose_pieces), tolerance, defects)
    polygons = shapely.simplify(shapely.normalize(cells), _STRAIGHT_STEPS * grid)
    # Restore the original coordinates of corners that were rounded to the grid.
    corners = shapely.get_coordinates(polygons)
    # Importing scipy.spatial takes a tenth of a second, and few scenes reach this function.
    from scipy.spatial import cKDTree

    distance, number = cKDTree(drawn_points).query(corners)
    shapely.set_coordinates(polygons, np.where((distance <= grid)[:, None], drawn_points[number], corners))
    window_lines = lines[len(joints) :]
    openings = shapely.union_all(
        shapely.get_parts(shapely.polygonize(_node_lines(window_lines, tolerance, grid)))
    )
    closed_openings = shapely.buffer(openings, tolerance)
    for window, line in zip(windows, window_lines, strict=True):
        if shapely.length(shapely.difference(line, closed_openings)) > tolerance:
            mistake = "is not part of a closed outline of an opening"
            plural_mistake = "lines on window layers are not part of a closed outline of an opening"
            remedy = "draw the complete outline of each opening, or omit the layer with 'without_layers'"
            defects.add(Defect(window.label, mistake, plural_mistake, remedy))
    is_outside = ~shapely.within(shapely.point_on_surface(polygons), shapely.union_all([*supports, openings]))
    polygons = polygons[is_outside & (2 * shapely.area(polygons) > tolerance * shapely.length(polygons))]
    left, low, _, _ = shapely.bounds(polygons).T
    polygons = shapely.orient_polygons(polygons[np.lexsort((left, np.round(low / tolerance)))])
    tree = shapely.STRtree(lines[: len(joints)])
    outlines = []
    for number, cell in enumerate(polygons, start=1):
        joint_numbers = tree.query(cell.exterior, "dwithin", tolerance)
        joint = joints[joint_numbers.min()] if len(joint_numbers) else joints[0]
        corners = shapely.get_coordinates(cell.exterior)[:-1]
        outlines.append(Outline(cell, Curve(corners, True, joint.layer, str(number), joint.label)))
    return outlines


def _add_loose_joints(
    joints: Sequence[Curve], lines: np.ndarray, pieces: np.ndarray, tolerance: float, defects: Defects
) -> None:
    """Add a defect for each loose joint line, which ends inside a cell.

    The place of the defect is the middle of the longest piece inside a cell. If an end of the line misses
    another line by little, the remedy is a tolerance that closes the gap.
    """
    tree = shapely.STRtree(lines)
    named_joints = set()
    for piece in pieces[np.argsort(-shapely.length(pieces), kind="stable")]:
        middle = piece.interpolate(0.5, normalized=True)
        owner = int(tree.nearest(middle))
        if owner >= len(joints) or owner in named_joints or piece.length <= tolerance:
            continue
        named_joints.add(owner)
        place = f"{near(middle.x, middle.y)}, over a length of {rounded(piece.length)}"
        gap = _widest_gap(owner, lines, tolerance)
        change = "extend the line"
        if gap > 0:
            change = f"set 'outline_tolerance' (--outline-tolerance) to {WIDEST_GAP} to close the gaps"
        remedy = f"{change}, or use 'without_layers' (--without-layer) to omit layers without joints"
        plural_mistake = "lines end inside a block"
        defects.add(Defect(joints[owner].label, "ends inside a block", plural_mistake, remedy, place, gap))


def _widest_gap(number: int, lines: np.ndarray, tolerance: float) -> float:
    """Return the larger distance between the two ends of a line and the nearest other line.

    Distances up to the tolerance are left out, and also distances that are too large for a drawing error.
    The result is zero if no distance remains.
    """
    line = lines[number]
    ends = shapely.get_point(line, [0, -1])
    distance = shapely.distance(ends[:, None], np.delete(lines, number)).min(axis=1, initial=math.inf)
    is_gap = (distance > tolerance) & (distance <= WIDEST_ERROR * line.length)
    return float(distance[is_gap].max(initial=0.0))


def _node_lines(lines: np.ndarray, tolerance: float, grid: float) -> np.ndarray:
    """Divide lines at their intersections (nodes), and extend lines that end just before another line."""
    ends = shapely.get_point(np.repeat(lines, 2), np.tile([0, -1], len(lines)))
    end, line = shapely.STRtree(lines).query(ends, predicate="dwithin", distance=tolerance)
    extensions = shapely.shortest_line(ends[end], lines[line])[end // 2 != line]
    return shapely.get_parts(
        shapely.union_all([*lines, *extensions[shapely.length(extensions) > 0]], grid_size=grid)
    )

"""Curves of a DXF file, and its texts with their places."""

import logging
import math
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.scene.drawings.outlines import Curve
from masonry_opt.scene.tables import broken, library, read_bytes

_LARGEST_DXF = 50_000_000  #: Bytes; a DXF file has some 500 for each block.
_TOO_MANY = 4000  #: Points of one curve: no drawing of masonry needs more.
SAGITTA = 1e-4  #: Largest distance of a curve from its chords, over the drawing's diagonal, by default.

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


def ezdxf() -> Any:
    """The library that reads and writes DXF. Raises OptionError if ezdxf, of the extra "drawings", is not
    installed."""
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
    return [
        entity
        for entity in document.modelspace()
        if not _attribute(entity, "invisible", 0) and layer_of(entity).casefold() not in hidden
    ]


def layer_of(entity: Any) -> str:
    """Name of the layer of an entity."""
    return str(_attribute(entity, "layer", "0"))


def _attribute(entity: Any, name: str, default: object) -> Any:
    return entity.dxf.get(name, default) if entity.dxf.is_supported(name) else default


def curves(entities: list[Any], scale: float, sagitta: float | None) -> tuple[list[Curve], float]:
    """Outlines among entities of a drawing, as chains of straight lines; and the diagonal round them. All
    lengths are multiplied by a scale, and chords are no farther from a curve than the sagitta (None: 10⁻⁴ of
    the diagonal). Raises ValueError if an entity cannot be read as an outline; the message names it."""
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
        kind, handle = entity.dxftype(), str(entity.dxf.handle)
        found.append(Curve(points, bool(is_closed_entity(entity)), layer_of(entity), handle, kind))
    return found, diagonal


def _chain(entity: Any, sagitta: float) -> np.ndarray:
    """Points along an entity, shape (points, 2), whose chords are no farther from it than the sagitta. Raises
    ValueError, naming the entity, if there are none or too many, or it does not lie in the plane."""
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

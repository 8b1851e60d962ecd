"""Curves of a DXF file, and its texts with their places."""

from __future__ import annotations

import importlib
import logging
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.scene.drawings.outlines import Curve, flattened
from masonry_opt.scene.tables import read_bytes

#: Bytes; a DXF file has some 500 for each block.
_LARGEST_DXF = 50_000_000

#: Entities that are no blocks. Others that cannot be read are refused: none is left out in silence.
_IGNORED = {
    "ATTDEF", "ARC_DIMENSION", "DIMENSION", "HATCH", "IMAGE", "LARGE_RADIAL_DIMENSION", "LEADER", "LIGHT",
    "MTEXT", "MULTILEADER", "OLE2FRAME", "PDFUNDERLAY", "POINT", "RAY", "SUN", "TEXT", "TOLERANCE",
    "VIEWPORT", "WIPEOUT", "XLINE",
}  # fmt: skip

#: What to do with entities that may be meant as blocks.
_REFUSED = {
    "ELLIPSE": "an ellipse: draw it with arcs or straight lines",
    "SPLINE": "a spline: draw it with arcs or straight lines",
    "INSERT": "a reference to a block definition: explode it",
    "MLINE": "a multiline: explode it",
    "REGION": "a region: explode it",
    "SOLID": "a filled area: draw its outline",
    "TRACE": "a filled area: draw its outline",
    "3DFACE": "a surface: draw its outline",
    "3DSOLID": "a solid: draw its outline",
    "MESH": "a mesh: draw its outline",
}

#: Metres in one unit of the drawing, by its code $INSUNITS (DXF reference, HEADER section).
_METRES = {
    1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 8: 2.54e-8, 9: 2.54e-5,
    10: 0.9144, 13: 1e-6, 14: 0.1, 15: 10.0, 16: 100.0, 21: 1200 / 3937,
}  # fmt: skip


def ezdxf() -> Any:
    """The library that reads and writes DXF.

    Raises OptionError if ezdxf, of the extra "drawings", is not installed.
    """
    try:
        library = importlib.import_module("ezdxf")
    except ImportError:
        raise OptionError("DXF needs ezdxf; install it with: pip install '.[drawings]'") from None
    # What it logs goes where the user's handlers take it, not to standard error.
    logging.getLogger("ezdxf").addHandler(logging.NullHandler())
    return library


def read_document(path: Path) -> Any:
    """The document of a DXF file, text or binary. Raises CaseError if it cannot be read or is no DXF file."""
    library = ezdxf()
    if len(read_bytes(path, _LARGEST_DXF)) > _LARGEST_DXF:
        raise CaseError(
            f"{path}: is larger than {_LARGEST_DXF // 1_000_000} MB: keep the layers of the blocks alone"
        )
    try:
        return library.readfile(path)
    except MemoryError:
        raise
    # What a broken file makes the library raise is any exception at all.
    except Exception as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise CaseError(f"{path}: not valid DXF: {reason}; save the drawing as DXF again") from None


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
    """Outlines among entities, as chains of straight lines; and the diagonal round them.

    Parameters
    ----------
    entities: of one drawing.
    scale: by which all lengths are multiplied.
    sagitta: largest distance between an arc and its chords; None for 10⁻⁴ of the drawing's diagonal.

    Raises
    ------
    ValueError
        If an entity cannot be read as an outline; the message names it.
    """
    raw = []
    for entity in entities:
        if entity.dxftype() not in _IGNORED:
            corners, closed = _corners(entity)
            points, bulges = _in_plane(entity, np.array(corners, dtype=float).reshape(-1, 4))
            if len(points) == 0 or not (np.isfinite(points).all() and np.isfinite(bulges).all()):
                raise ValueError(f"{_named(entity)} has no points, or one that is no number: delete it")
            raw.append((entity, points * scale, bulges, closed))
    if not raw:
        return [], 0.0
    diagonal = float(np.hypot(*np.ptp(np.concatenate([points for _, points, _, _ in raw]), axis=0)))
    found = []
    for entity, points, bulges, closed in raw:
        try:
            lines = flattened(points, bulges, closed, sagitta or 1e-4 * diagonal)
        except ValueError as error:
            raise ValueError(f"{_named(entity)}: {error}: raise 'sagitta'") from None
        found.append(Curve(lines, closed, layer_of(entity), str(entity.dxf.handle), entity.dxftype()))
    return found, diagonal


def _corners(entity: Any) -> tuple[list[tuple[float, ...]], bool]:
    """Corners of an outline, each x, y, z in the entity's own coordinates and the bulge to the next; and
    whether it is closed."""
    dxf, kind = entity.dxf, entity.dxftype()
    match kind:
        case "LINE":
            return [(*dxf.start, 0.0), (*dxf.end, 0.0)], False
        case "CIRCLE":
            return [_on_circle(entity, 0.0, 1.0), _on_circle(entity, 180.0, 1.0)], True
        case "ARC":
            angle = (dxf.end_angle - dxf.start_angle) % 360 or 360.0
            # A bulge says nothing of a whole circle, and little of nearly one.
            parts = 1 if angle < 270 else 2
            bulge = math.tan(math.radians(angle / parts) / 4)
            ends = [dxf.start_angle + angle * part / parts for part in range(parts + 1)]
            return [_on_circle(entity, end, bulge) for end in ends], False
        case "LWPOLYLINE":
            height = float(dxf.get("elevation", 0.0))
            return [(x, y, height, bulge) for x, y, bulge in entity.get_points("xyb")], bool(entity.closed)
        case "POLYLINE" if entity.is_2d_polyline or entity.is_3d_polyline:
            # Corners of the frame that a smoothed polyline was drawn from are no points of it.
            corners = [vertex.dxf for vertex in entity.vertices if not vertex.dxf.flags & 16]
            curved = entity.is_2d_polyline
            closed = bool(entity.is_closed)
            return [(*at.location, at.get("bulge", 0.0) if curved else 0.0) for at in corners], closed
        case "POLYLINE":
            raise ValueError(f"{_named(entity)} is a mesh: draw its outline")
    remedy = _REFUSED.get(kind, "of a kind that is not read: draw its outline")
    raise ValueError(f"{_named(entity)} is {remedy}, or name the layers of the blocks by 'layers'")


def _on_circle(entity: Any, degrees: float, bulge: float) -> tuple[float, ...]:
    x, y, z = entity.dxf.center
    radius, angle = entity.dxf.radius, math.radians(degrees)
    return x + radius * math.cos(angle), y + radius * math.sin(angle), z, bulge


def _in_plane(entity: Any, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and bulges in the drawing's plane, seen from above; the mirror image of an arc turns the other
    way."""
    points, bulges = corners[:, :3], corners[:, 3]
    normal = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))
    # Lines and 3D polylines are given in the drawing's coordinates.
    if entity.dxftype() != "LINE" and not (entity.dxftype() == "POLYLINE" and entity.is_3d_polyline):
        if abs(normal[0]) > 1e-9 or abs(normal[1]) > 1e-9:
            raise ValueError(f"{_named(entity)} does not lie in the drawing's xy plane: turn it")
        if normal[2] < 0:  # its x axis points to the left
            return points[:, :2] * [-1, 1], -bulges
    elif len(points) and np.ptp(points[:, 2]) > 1e-6 * np.ptp(points[:, :2], axis=0).max():
        raise ValueError(f"{_named(entity)} does not lie in the drawing's xy plane: flatten it")
    return points[:, :2], bulges


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

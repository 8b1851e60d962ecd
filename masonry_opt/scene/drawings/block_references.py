"""Replace the references to block definitions in a DXF drawing by the entities that they place.

A drawing can define a stone once, as a block definition, and place it many times by references (entities of
type INSERT), which move, rotate, mirror and scale it. A definition may contain references itself.
"""

from collections.abc import Iterator
from itertools import islice
from typing import Any

from masonry_opt.scene.drawings.outlines import (
    attribute,
    hidden_layers,
    layer_of,
    mark_polyline,
    polyline_mark,
)
from masonry_opt.scene.tables import broken

#: Largest number of entities that one reference may place. Nested references can place a number of entities
#: that grows exponentially with the size of the file.
_MOST_PLACED = 50_000

#: Kinds of entities that may be closed polylines with arcs.
_POLYLINES = ("LWPOLYLINE", "POLYLINE")


def in_model_space(document: Any) -> list[Any]:
    """Return the entities of the model space, with references replaced by the entities that they place.

    A placed entity has a handle of its own, which begins with the handle of the reference. An entity that is
    defined on layer "0" is on the layer of the reference. All entities of a reference on a frozen layer are
    on this layer, and those of an invisible reference are invisible.

    A reference is returned unchanged if its definition is missing or empty, for example because the
    definition is in another file. The reference is also returned unchanged if one of its entities cannot be
    transformed.

    Raises ValueError if a reference is invalid or places too many entities.
    """
    frozen_layers = {layer for layer, reason in hidden_layers(document).items() if reason == "frozen"}
    _mark_polylines(document)
    entities: list[Any] = []
    for entity in document.modelspace():
        entities += _placed_entities(entity, frozen_layers) if entity.dxftype() == "INSERT" else [entity]
    return entities


def _mark_polylines(document: Any) -> None:
    """In block definitions, mark closed polylines that have arcs.

    A reference with different scales along its axes divides such a polyline into lines and parts of ellipses.
    The mark of the parts keeps them separate from the parts of a stone that touches.
    """
    for definition in document.blocks:
        for entity in definition:
            if entity.dxftype() in _POLYLINES and entity.is_closed and entity.has_arc:
                mark_polyline(entity, str(entity.dxf.handle))


def _placed_entities(reference: Any, frozen_layers: set[str]) -> list[Any]:
    """Return the entities that a reference places; see :func:`in_model_space`.

    ``frozen_layers`` has the names of the frozen layers, in lower case.
    """
    label = f"block reference {reference.dxf.handle}"
    with broken(lambda reason: ValueError(f"{label} is not readable ({reason}): delete it")):
        parts = list(islice(_placed_parts(reference, frozen_layers, ()), _MOST_PLACED + 1))
    if len(parts) > _MOST_PLACED:
        raise ValueError(
            f"{label} places more than {_MOST_PLACED} entities: delete it, or reduce the number of blocks "
            "that it places"
        )
    return parts


def _placed_parts(entity: Any, frozen_layers: set[str], definitions: tuple[str, ...]) -> Iterator[Any]:
    """Yield the entities that a reference places, or the entity itself if it is not a reference.

    ``definitions`` has the names of the block definitions in which the entity is defined. A reference to such
    a definition is yielded unchanged, because its replacement would never end.
    """
    if entity.dxftype() != "INSERT" or entity.dxf.name in definitions or entity.block() is None:
        yield entity
        return
    skipped_entities: list[Any] = []
    references = entity.multi_insert() if entity.mcount > 1 else [entity]
    parts = []
    for position, reference in enumerate(references):
        for part in reference.virtual_entities(
            skipped_entity_callback=lambda part, _: skipped_entities.append(part)
        ):
            mark = polyline_mark(part)
            if mark:
                mark_polyline(part, f"{mark} in {entity.dxf.handle}-{position}")
            parts.append(part)
    if not parts or skipped_entities:
        yield entity
        return
    layer = layer_of(entity)
    for number, part in enumerate([*parts, *entity.attribs], 1):
        if layer_of(part) == "0" or layer.casefold() in frozen_layers:
            part.dxf.layer = layer
        if attribute(entity, "invisible", 0):
            part.dxf.invisible = 1
        part.dxf.handle = f"{entity.dxf.handle}-{number}"
        yield from _placed_parts(part, frozen_layers, (*definitions, entity.dxf.name))

"""Select the layers of a DXF drawing that are read, and report which layers were not read."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from masonry_opt.errors import counted
from masonry_opt.scene.drawings import outlines, stones

#: Advice on how to read a layer, by the reason why the layer was not read.
_ADVICE = {
    "frozen": "thaw the layer, or turn it on, in the drawing",
    "off": "thaw the layer, or turn it on, in the drawing",
    "--without-layer": "remove the layer from 'without_layers' (--without-layer)",
    "not named with --layer": "add the layer to 'layers' (--layer)",
    "no outlines": "draw the supports on the layer as closed outlines",
}


def select(
    document: Any,
    visible_entities: list[Any],
    layers: Collection[str] | None,
    without_layers: Collection[str],
) -> list[Any]:
    """Return the visible entities on the selected layers.

    Raises ValueError if a named layer has no visible entities.
    """
    layer_names = [outlines.layer_of(entity).casefold() for entity in visible_entities]
    hidden_layers = outlines.hidden_layers(document)
    for key, option, named_layers in (
        ("layers", "--layer", layers or ()),
        ("without_layers", "--without-layer", without_layers),
    ):
        for layer in named_layers:
            if layer.casefold() in layer_names:
                continue
            mistake = f"'{key}' ({option}): layer '{layer}'"
            if key == "layers" and layer.casefold() in hidden_layers:
                reason = hidden_layers[layer.casefold()]
                raise ValueError(f"{mistake} is {reason}: {how_to_read(reason)}")
            if layer.casefold() not in hidden_layers:
                raise ValueError(
                    f"{mistake} is empty or does not exist{describe_layers(document, visible_entities)}"
                )
    selected_layers = {layer.casefold() for layer in layers or layer_names}
    selected_layers -= {layer.casefold() for layer in without_layers}
    return [
        entity
        for entity, layer in zip(visible_entities, layer_names, strict=True)
        if layer in selected_layers
    ]


def find_unread(
    document: Any, entities: list[Any], layers: Collection[str] | None, without_layers: Collection[str]
) -> dict[str, str]:
    """Return the names of the layers that were not read, each with the reason.

    ``entities`` has the entities of the model space.
    """
    hidden_layers = outlines.hidden_layers(document)
    omitted_layers = {layer.casefold() for layer in without_layers}
    selected_layers = None if layers is None else {layer.casefold() for layer in layers}
    reasons = {}
    for key, (name, count) in _curves_on_layers(entities).items():
        if key in hidden_layers:
            reasons[name] = hidden_layers[key]
        elif key in omitted_layers:
            reasons[name] = "--without-layer"
        elif selected_layers is not None and key not in selected_layers:
            reasons[name] = "not named with --layer"
        elif not count:
            reasons[name] = "no outlines"
    return reasons


def how_to_read(reason: str) -> str:
    """Return advice on how to read a layer of supports that was left out for a given reason."""
    return _ADVICE[reason]


def report(entities: list[Any], unread_layers: Mapping[str, str], support_words: Iterable[str]) -> list[str]:
    """Return lines of text that list the layers that were read, and the ``unread_layers`` with reasons."""
    words = [*support_words]
    read_layers = []
    for name, count in _curves_on_layers(entities).values():
        if name not in unread_layers:
            supports = ", supports" if has_word(name, words) else ""
            read_layers.append(f"{name} ({counted(count, 'curve')}{supports})")
    lines = [f"layers read: {', '.join(read_layers)}"]
    if unread_layers:
        reasons = ", ".join(f"{name} ({reason})" for name, reason in unread_layers.items())
        lines.append(f"layers not read: {reasons}")
    return lines


def has_word(name: str, words: Iterable[str]) -> bool:
    """Return True if a name contains one of the given words, in upper or lower case."""
    return any(word.casefold() in name.casefold() for word in words)


def describe_layers(document: Any, visible_entities: list[Any]) -> str:
    """Return a text in brackets, to be appended to a message, that names all layers with visible entities.

    If no entity is visible, the text states whether entities are hidden in the model space, are in a layout
    of the paper space, or do not exist.
    """
    layers = sorted({outlines.layer_of(entity) for entity in visible_entities})
    if layers:
        return f" (layers with entities: {stones.listed_names(layers)})"
    if len(document.modelspace()):
        return " (all entities of the model space, or their layers, are hidden: show them in the drawing)"
    for layout in document.layouts:
        entities = [entity for entity in layout if entity.dxftype() != "VIEWPORT"]
        if entities:
            return (
                f" (the model space is empty, but layout '{layout.name}' in the paper space has "
                f"{counted(len(entities), 'entity', 'entities')}: move the blocks to the model space)"
            )
    return " (the drawing is empty)"


def _curves_on_layers(entities: list[Any]) -> dict[str, tuple[str, int]]:
    """Return a dict from each layer's name in lower case to its original name and number of curves."""
    names: dict[str, str] = {}
    count: Counter[str] = Counter()
    for entity in entities:
        name = outlines.layer_of(entity)
        names.setdefault(name.casefold(), name)
        count[name.casefold()] += not outlines.is_ignored(entity)
    return {key: (name, count[key]) for key, name in names.items()}

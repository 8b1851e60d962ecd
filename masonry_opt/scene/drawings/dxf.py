"""Read DXF drawings as scenes."""

import math
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from pydantic import ConfigDict, Field

from masonry_opt.errors import (
    CaseError,
    DrawingWarning,
    OptionError,
    counted,
    printable,
    rounded,
    shortened,
)
from masonry_opt.scene.blocks import Block, Name, Number, Positive, YesNo
from masonry_opt.scene.drawings import block_references, dxf_layers, grounds, loops, nesting, outlines, stones
from masonry_opt.scene.drawings.defects import Defects
from masonry_opt.scene.drawings.nesting import OutlineTolerance
from masonry_opt.scene.drawings.outlines import Curve, Outline
from masonry_opt.scene.extrude import extrude
from masonry_opt.scene.geometry import RELATIVE_TOLERANCE
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import PlaneOrSpaceVector, Solid
from masonry_opt.scene.tables import as_path
from masonry_opt.scene.typical_sizes import (
    FEWEST_STONES,
    LARGEST_SCENE,
    LARGEST_SMALLER_SIDE,
    SMALLEST_SCENE,
)

#: Words that mark layers of windows or doors. The name of such a layer contains one of these words.
WINDOW_WORDS = ("window", "door", "opening")

#: Largest number of copies of outlines that one warning lists; further copies are only counted.
_MOST_COPIES = 10

#: Largest number of holes that the report on a drawing lists; further holes are only counted.
_MOST_HOLES = 10


class DxfDrawing(stones.FlatDrawing):
    """Values that the user specifies for a DXF drawing, such as friction, and the meaning of its layers.

    See :func:`read_dxf`.
    """

    model_config = ConfigDict(title="a DXF drawing")

    live_layers: dict[Name, PlaneOrSpaceVector] = {}
    thickness: Positive | None = None
    layers: list[Name] | None = Field(default=None, min_length=1)
    without_layers: list[Name] = []
    fixed_layers: list[Name] = list(stones.SUPPORT_WORDS)
    fixed_below: Number | None = None
    net: YesNo = False
    window_layers: list[Name] = list(WINDOW_WORDS)
    outline_tolerance: Positive | None = None
    sagitta: Positive | None = None
    to_metres: YesNo = False


def read_dxf(  # noqa: PLR0913 - options of the public API are keywords
    path: str | Path,
    *,
    friction: float,
    unit_weight: float,
    live: Sequence[float] | None = None,
    live_layers: Mapping[str, Sequence[float]] | None = None,
    layers: Iterable[str] | None = None,
    without_layers: Iterable[str] = (),
    fixed_layers: Iterable[str] = stones.SUPPORT_WORDS,
    fixed_below: float | None = None,
    net: bool = False,
    window_layers: Iterable[str] = WINDOW_WORDS,
    tolerance: float | None = None,
    contact_tolerance: float | None = None,
    outline_tolerance: float | None = None,
    sagitta: float | None = None,
    to_metres: bool = False,
    thickness: float | None = None,
) -> Scene:
    """Read a scene from the closed outlines of a DXF drawing, or from a net of joint lines.

    Outlines are closed polylines, circles, ellipses and splines, and closed loops of lines, arcs, open
    polylines and pieces of ellipses and splines on one layer. They are read from the visible layers of the
    model space. Each outline is a block. An outline inside another outline is a hole, and an outline inside a
    hole is a block again. If a block contains exactly one text, and no other block contains the same text,
    the text is the name of the block. Other blocks are named by layer and handle. Blocks are in the order of
    the drawing. Further copies of an outline are left out, and a DrawingWarning names the copies. Another
    DrawingWarning reports that the unit ($INSUNITS) makes the drawing or its blocks unusually small or large.

    In a net of joint lines, the blocks are the closed cells between all lines, which may cross and branch.
    The supports are closed outlines or straight lines. Cells are named by layer and number, from the bottom
    upwards and from left to right.

    Parameters
    ----------
    path: A ``.dxf`` file, text or binary.
    friction: Friction coefficient μ = tan φ of every joint.
    unit_weight: Weight per unit area, or per unit volume if a thickness is given, in the units of the scene.
    live: Live force on every movable block as a multiple of its weight, at the centroid: ``[fx, fy]``, or
        ``[fx, fy, fz]`` if a thickness is given.
    live_layers: Live forces, as for ``live``, by the name of the layer on whose blocks they act in place of
        ``live``.
    layers: Layers to read, including the layers of supports (default: all).
    without_layers: Layers to leave out.
    fixed_layers: Words that mark supports. A block is a support if the name of its layer contains one of
        these words, in upper or lower case. A straight line on such a layer, with all blocks on one side, is
        read as the surface of a support, and a DrawingWarning names the line.
    fixed_below: Blocks that reach down to this height y of the drawing, or below, are supports too.
    net: True if lines are joints, and the cells between the lines are blocks.
    window_layers: Words that mark windows in a net. A region is not a block if lines enclose it that are on
        layers with one of these words in their names.
    tolerance: Length below which gaps and overlaps between blocks are ignored (default: 1e-6 of the diagonal
        round the movable blocks).
    contact_tolerance: Largest gap or overlap of facing edges that are in contact, such as the width of mortar
        that is not drawn. :class:`Scene` explains it.
    outline_tolerance: Largest gap between two ends of lines that are joined to an outline, if no third end is
        as near. Ends within 1e-6 of the drawing's diagonal are joined first. The default is the tolerance,
        or 1e-6 of the diagonal if no tolerance is given. In a net, this option is the largest gap over which
        an end is extended to the next line, and the width of the narrowest cell (default: the larger of
        sagitta and tolerance).
    sagitta: Largest distance between a curve and the chords that replace it (default: 1e-4 of the drawing's
        diagonal). The ends of the chords are on the curve.
    to_metres: True to scale the drawing from its own unit ($INSUNITS) to metres. All other arguments are then
        in metres.
    thickness: Thickness to which the blocks are extruded, which makes a scene in space. The x axis of
        the drawing becomes x, its y axis becomes z, and blocks extend from y = 0 to the thickness.

    Returns
    -------
    Scene
        The scene in the plane, or in space if a thickness is given.

    Raises
    ------
    CaseError
        If the file cannot be read, if an outline is not a block, or if the blocks do not form a valid scene.
        The message names the file, and all wrong entities by handle, layer and place.
    OptionError
        If ezdxf is not installed, which is part of the extra "drawings", if the thickness is not a positive
        number, or if ``window_layers`` are given without ``net``.
    """
    return read_with_layers(path, DxfDrawing.of(locals())).scene


class DxfScene(NamedTuple):
    """Scene of a DXF drawing, with a report on the layers that were read."""

    scene: Scene
    #: Lines of text about the layers that were read, the unread layers with the reasons, and the outlines
    #: that are holes.
    layers: list[str]
    unit: str  #: name of the scene's unit of length, such as "millimetres"; empty if the drawing has no unit
    metres: float | None  #: length of the scene's unit in metres; None if the drawing has no unit


def read_with_layers(path: str | Path, drawing: DxfDrawing) -> DxfScene:
    """Read a drawing as :func:`read_dxf` does, and also report which layers were read.

    Raises the errors, and issues the warnings, of :func:`read_dxf`.
    """
    path = as_path(path, "a DXF drawing", ".dxf")
    if not drawing.net and drawing.window_layers != list(WINDOW_WORDS):
        raise OptionError(
            "'window_layers' (--window-layer) applies only to a net of joint lines: "
            "set 'net' (--net) as well, or omit layers with 'without_layers' (--without-layer)"
        )
    _refuse_third_component(path, drawing)
    document = outlines.read_document(path)
    with stones.naming(f"{path}:"):
        scale = _metres_per_unit(document) if drawing.to_metres else 1.0
        entities = block_references.in_model_space(document)
        visible_entities = outlines.visible(document, entities)
        defects = Defects()
        selected_entities = dxf_layers.select(
            document, visible_entities, drawing.layers, drawing.without_layers
        )
        curves, extent = outlines.curves(selected_entities, scale, drawing.sagitta, defects)
        drawn_blocks, copies, slabs = _outlines(curves, float(np.hypot(*extent)), drawing, defects)
        defects.refuse()
        if not drawn_blocks:
            raise ValueError(
                f"the model space contains no closed outline"
                f"{dxf_layers.describe_layers(document, visible_entities)}"
            )
        live_of_layer = {layer.casefold(): force for layer, force in drawing.live_layers.items()}
        # Live loads are multiples of the weights. The multiple may depend on the layer of a block.
        pushes = [live_of_layer.get(shape.curve.layer.casefold(), drawing.live) for shape in drawn_blocks]
        unread_layers = dxf_layers.find_unread(document, entities, drawing.layers, drawing.without_layers)
        blocks: Sequence[Block | Solid] = _blocks(
            drawn_blocks, _names(drawn_blocks, visible_entities, scale), drawing, unread_layers
        )
        if drawing.thickness is not None:
            flat_scene = stones.scene_of(blocks, drawing, path)
            blocks = extrude(flat_scene.replace(thickness=drawing.thickness)).in_space()
            pushes = [push if len(push) == 3 else (push[0], 0.0, push[1]) for push in pushes]
        loaded_blocks = [
            block if block.fixed else block.replace(live_per_weight=push)
            for block, push in zip(blocks, pushes, strict=True)
        ]
        scene = stones.scene_of(loaded_blocks, drawing, path)
    sides = [
        _smaller_side(shape) for shape, block in zip(drawn_blocks, blocks, strict=True) if not block.fixed
    ]
    side = float(np.median(sides)) if len(sides) >= FEWEST_STONES else None
    unit_warning = _unit_warning(document, extent / scale, side and side / scale, drawing.to_metres)
    for warning in (_copies_warning(copies), grounds.lines_warning(slabs), unit_warning):
        if warning:
            warnings.warn(printable(f"{path}: {warning}"), DrawingWarning, stacklevel=3)
    unit = ("metres", 1.0) if drawing.to_metres else (_unit_name(document), outlines.metres(document))
    return DxfScene(
        scene,
        [
            *dxf_layers.report(entities, unread_layers, drawing.fixed_layers),
            *_describe_holes(drawn_blocks, scene),
        ],
        *unit,
    )


def _refuse_third_component(path: Path, drawing: DxfDrawing) -> None:
    """Raise CaseError if a live load has three components, but the drawing is read as a plane scene."""
    if drawing.thickness is not None:
        return
    for option, key, loads in (
        ("--live", "live", [drawing.live]),
        ("--live-layer", "live_layers", [*drawing.live_layers.values()]),
    ):
        if any(len(load) == 3 for load in loads):
            raise CaseError(
                f"{path}: '{key}' ({option}) has three components, but the drawing is read as a plane scene: "
                "give two components, or set 'thickness' (--thickness) for a scene in space"
            )


def _metres_per_unit(document: Any) -> float:
    """Return the length of the drawing's unit in metres. Raises ValueError if the drawing has no unit."""
    scale = outlines.metres(document)
    if scale is None:
        raise ValueError(
            "the drawing has no unit ($INSUNITS): set the unit, or omit 'to_metres' (--to-metres)"
        )
    return scale


def _outlines(
    curves: list[Curve], diagonal: float, drawing: DxfDrawing, defects: Defects
) -> tuple[list[Outline], list[tuple[Curve, Curve]], list[Curve]]:
    """Return the outlines of the blocks, the omitted copies of outlines, and the slabs of ground lines.

    The second list has a pair of curves for each omitted copy: the copy and its original. The third list has
    the outlines of the slabs that :func:`grounds.support_outlines` makes from lines on layers of supports.

    Defects of the drawing are added to ``defects``.
    """
    rounding = RELATIVE_TOLERANCE * diagonal
    gap_tolerance = drawing.tolerance or rounding
    detail_tolerance = drawing.outline_tolerance or gap_tolerance
    outline_curves = [curve for curve in curves if not drawing.net or _is_support(curve, drawing)]
    is_on_support_layer = partial(_is_support, drawing=drawing)
    closed_curves, copies, straight_lines = loops.closed_outlines(
        outline_curves, is_on_support_layer, detail_tolerance, min(rounding, detail_tolerance), defects
    )
    slabs = grounds.support_outlines(
        straight_lines, curves, closed_curves, is_on_support_layer, gap_tolerance, defects
    )
    closed_curves += slabs
    is_support = [_is_support(curve, drawing) for curve in closed_curves]
    option = "tolerance" if drawing.outline_tolerance is None else "outline_tolerance"
    tolerance = OutlineTolerance(option, detail_tolerance, min(rounding, detail_tolerance))
    nested_outlines = nesting.outlines_with_holes(
        closed_curves, is_support, tolerance, max(detail_tolerance, gap_tolerance), defects
    )
    drawn_blocks = nested_outlines.blocks
    lines = [curve for curve in curves if drawing.net and not _is_support(curve, drawing)]
    windows = [curve for curve in lines if _layer_has_word(curve, drawing.window_layers)]
    joints = [curve for curve in lines if not _layer_has_word(curve, drawing.window_layers)]
    if joints:
        # Report defective supports before the net of joint lines is divided into cells. Without these
        # supports, cells would be open and cause further errors.
        defects.refuse()
        net_tolerance = drawing.outline_tolerance or max(
            gap_tolerance, drawing.sagitta or outlines.DEFAULT_SAGITTA * diagonal
        )
        supports = [outline.polygon for outline in drawn_blocks]
        drawn_blocks = [*outlines.net_cells(joints, windows, supports, net_tolerance, defects), *drawn_blocks]
    nesting.add_smaller_copies(drawn_blocks, detail_tolerance, defects)
    nesting.add_frames(drawn_blocks, is_on_support_layer, _are_fixed(drawn_blocks, drawing), defects)
    return drawn_blocks, [*copies, *nested_outlines.copies], slabs


def _is_support(curve: Curve, drawing: DxfDrawing) -> bool:
    """Return True if a curve is on a layer of supports."""
    return _layer_has_word(curve, drawing.fixed_layers)


def _are_fixed(drawn_blocks: Sequence[Outline], drawing: DxfDrawing) -> list[bool]:
    """Return, for each outline, True if its layer or its lowest point makes it a support."""
    height_limit = -math.inf if drawing.fixed_below is None else drawing.fixed_below
    return [
        _is_support(shape.curve, drawing) or shape.polygon.bounds[1] <= height_limit for shape in drawn_blocks
    ]


def _copies_warning(copies: Sequence[tuple[Curve, Curve]]) -> str:
    """Return a warning that copies of outlines were left out, or an empty text if there are no copies."""
    if not copies:
        return ""
    pairs = shortened([f"{copy.label} repeats {original.label}" for copy, original in copies], _MOST_COPIES)
    outline_count = counted(len(copies), "outline")
    is_or_are = "is" if len(copies) == 1 else "are"
    return f"{outline_count} {is_or_are} drawn twice, and copies were left out: {'; '.join(pairs)}"


def _smaller_side(shape: Outline) -> float:
    """Return the smaller side of the bounding box of an outline."""
    left, low, right, high = shape.polygon.bounds
    return float(min(right - left, high - low))


def _unit_name(document: Any) -> str:
    """Return the name of the drawing's unit in plural, such as "millimetres", or "" if it has no unit."""
    if outlines.metres(document) is None:
        return ""
    from ezdxf.units import unit_name

    return str(unit_name(document.header["$INSUNITS"])).lower().replace("meter", "metre")


def _unit_warning(document: Any, extent: np.ndarray, side: float | None, to_metres: bool) -> str:
    """Return a warning if the drawing or its blocks have an unusual size in metres, or else an empty text.

    ``extent`` is the width and height of the drawing, and ``side`` the median of the smaller sides of its
    movable blocks, both in the unit of the drawing. ``side`` is None if there are few blocks.
    """
    unit = outlines.metres(document)
    size = float(extent.max())
    if unit is None:
        return ""
    if not SMALLEST_SCENE <= size * unit <= LARGEST_SCENE:
        how_large = "only" if size * unit < SMALLEST_SCENE else "as much as"
        finding = f"it is {how_large} {size * unit:.6g} m wide or high"
    elif side is not None and side * unit > LARGEST_SMALLER_SIDE:
        finding = f"half of its blocks are at least {rounded(side * unit)} m wide and high"
    else:
        return ""
    effect = (
        "lengths were not scaled, so the unit weight must be given per area or volume in the drawing's unit "
        "of length"
    )
    if to_metres:
        effect = f"lengths were multiplied by {unit:g}"
    in_unit = f"{_unit_name(document)} ($INSUNITS)"
    return (
        f"the drawing is in {in_unit}, so {finding}: correct the unit in the drawing if it is wrong; {effect}"
    )


def _describe_holes(drawn_blocks: Sequence[Outline], scene: Scene) -> list[str]:
    """Return a list of one line that names the holes and their blocks, or an empty list without holes."""
    holes = [
        f"{hole.label} in block '{block.name}'"
        for shape, block in zip(drawn_blocks, scene.blocks, strict=True)
        for hole in shape.holes
    ]
    return [f"holes: {'; '.join(shortened(holes, _MOST_HOLES))}"] if holes else []


def _layer_has_word(curve: Curve, words: Iterable[str]) -> bool:
    """Return True if the name of the curve's layer contains one of the given words."""
    return dxf_layers.has_word(curve.layer, words)


def _names(drawn_blocks: Sequence[Outline], entities: list[Any], scale: float) -> list[str]:
    """Return the names of the blocks: the text inside a block, or else its layer and handle."""
    texts_in: defaultdict[int, list[str]] = defaultdict(list)
    tree = shapely.STRtree([shape.polygon for shape in drawn_blocks])
    for text, x, y in outlines.texts(entities):
        for block in tree.query(shapely.Point(x * scale, y * scale), predicate="within").tolist():
            texts_in[block].append(stones.block_name(text))
    single_texts = {block: texts[0] for block, texts in texts_in.items() if len(texts) == 1}
    count = Counter(single_texts.values())
    unique_texts = {block: text for block, text in single_texts.items() if text and count[text] == 1}
    default_names = (
        stones.block_name(f"{shape.curve.layer[:100]}-{shape.curve.handle}") for shape in drawn_blocks
    )
    return [unique_texts.get(block, name) for block, name in enumerate(default_names)]


def _blocks(
    drawn_blocks: Sequence[Outline],
    names: Sequence[str],
    drawing: DxfDrawing,
    unread_layers: Mapping[str, str],
) -> list[Block]:
    """Return the blocks without their live loads. Raises ValueError if there are no supports.

    ``unread_layers`` contains the layers that were not read, by name, with the reasons.
    """
    words = [word.casefold() for word in drawing.fixed_layers]
    is_fixed = _are_fixed(drawn_blocks, drawing)
    rows = zip(names, drawn_blocks, is_fixed, strict=True)
    blocks = [drawing.block(name, shape.polygon, fixed) for name, shape, fixed in rows]
    loaded_layers = {
        shape.curve.layer.casefold() for shape, fixed in zip(drawn_blocks, is_fixed, strict=True) if not fixed
    }
    layers = f"layers of blocks: {stones.listed_names(sorted({shape.curve.layer for shape in drawn_blocks}))}"
    for layer in drawing.live_layers:
        if layer.casefold() not in loaded_layers:
            raise ValueError(
                f"'live_layers' (--live-layer): no movable block is on layer '{layer}' ({layers})"
            )
    if all(block.fixed for block in blocks):
        reasons = ", ".join(f"{layer} ({reason})" for layer, reason in unread_layers.items())
        unread_text = f"; layers not read: {reasons}" if reasons else ""
        raise ValueError(
            f"every block is a support: draw the movable blocks as closed outlines, or mark fewer blocks as "
            f"supports ({layers}{unread_text})"
        )
    if not any(block.fixed for block in blocks):
        condition = f"with {' or '.join(map(repr, words))} in its name ({layers})"
        for layer, reason in unread_layers.items():
            if dxf_layers.has_word(layer, words):
                raise ValueError(
                    f"no block is a support, because layer '{layer}' was not read ({reason}): "
                    f"{dxf_layers.how_to_read(reason)}"
                )
        raise ValueError(
            f"no block is a support, because no block is on a layer {condition}: move the supports to such a "
            "layer, name the layer of the supports with 'fixed_layers' (--fixed-layer), or set 'fixed_below' "
            "(--fixed-below) to a height: blocks whose lowest point is not above it become supports"
        )
    return blocks

"""Refuse blocks that overlap, and advise tolerances for overlaps of inexact coordinates."""

from dataclasses import replace

import numpy as np

from masonry_opt.errors import CaseError, counted, rounded
from masonry_opt.scene.contacts.gaps import aligning_tolerance, joining_tolerance, near_misses
from masonry_opt.scene.contacts.mortar import has_large_tolerance, mortar_gaps
from masonry_opt.scene.contacts.neighbours import facing_sides
from masonry_opt.scene.contacts.sides import Facing
from masonry_opt.scene.geometry import MORTAR, Common, Extents
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.faces import place
from masonry_opt.scene.tolerance_advice import set_both, set_contact_tolerance, set_tolerance

#: Overlap of two blocks, as a fraction of the smaller block, above which the smaller block counts as inside
#: the larger block.
_SHARE_INSIDE = 0.999

#: An advised tolerance exceeds the computed depth of an overlap by at least this fraction. The computed depth
#: of a wedge-shaped overlap is smaller than the distance of its two sides, in rare cases by a fraction of
#: 2e-5. With zero, an advised tolerance may be too small to join the sides.
_DEPTH_ERROR = 1e-3


def refuse_overlaps(scene: Scene, shapes: Extents, near: np.ndarray) -> None:
    """Raise CaseError if two blocks overlap by more than the contact tolerance.

    ``near`` lists the pairs of blocks that are near each other, shape (pairs, 2).
    """
    (low, high), (i, j) = shapes.boxes, near.T
    inside = np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])
    pairs = near[(inside > shapes.contact_tolerance).all(axis=1)]
    overlaps: dict[int, list[Common]] = {}
    for number, piece in shapes.overlaps(pairs):
        overlaps.setdefault(number, []).append(piece)
        if len(overlaps) == shapes.enough:
            break
    if not overlaps:
        return
    size = {pair: sum(piece.size for piece in pieces) for pair, pieces in overlaps.items()}
    worst = max(size, key=lambda pair: size[pair])
    deepest = max(overlaps[worst], key=lambda piece: piece.depth)
    names = [repr(scene.blocks[index].name) for index in pairs[worst]]
    depth = max(piece.depth for pieces in overlaps.values() for piece in pieces)
    bridged = depth * (1 + _DEPTH_ERROR)
    advice = "move the blocks apart"
    if size[worst] > _SHARE_INSIDE * shapes.size[pairs[worst]].min():
        advice = "one block is inside the other: move the blocks apart, or remove one of them"
    elif deepest.depth <= shapes.reach[pairs[worst]].min() and scene.contact_tolerance is None:
        # A thin overlap may be due to inexact coordinates, so the message also recommends a tolerance.
        sides, _ = _sides_to_join(scene, shapes, near, pairs[[*overlaps]], bridged)
        advice += f"; {_advice_on_inexact(scene, shapes, sides, bridged)}"
    elif depth <= MORTAR * shapes.width[pairs[worst]].min():
        sides, is_mortar = _sides_to_join(scene, shapes, near, pairs[[*overlaps]], bridged)
        advice += f"; {_advice_on_meant(shapes, sides, bridged, is_mortar, len(overlaps) > 1)}"
    omitted = len(overlaps) - 1
    least = "at least " if len(overlaps) == shapes.enough else ""
    more = ""
    if omitted:
        verb = "overlaps" if omitted == 1 else "overlap"
        more = f" ({least}{counted(omitted, 'more pair')} {verb}, up to {rounded(depth)} deep)"
    overlap = f"blocks {names[0]} and {names[1]} overlap {shapes.within} of {size[worst]:.6g}"
    where = place(deepest.middle + shapes.origin, shapes.contact_tolerance)
    at = f"near {where}, {rounded(deepest.depth)} deep"
    raise CaseError(f"{scene.origin}: {overlap} {at}: {advice}{more}")


def _sides_to_join(
    scene: Scene, shapes: Extents, near: np.ndarray, overlapping: np.ndarray, depth: float
) -> tuple[Facing, bool]:
    """Return the pairs of sides that could become joints, and True if the gaps between them are mortar.

    If the scene is drawn without its mortar, these are the sides of its mortar joints. Otherwise they are the
    sides that a small error separates, and the sides of blocks that overlap by at most ``depth``.

    ``near`` lists the pairs of blocks that may face each other. ``overlapping`` lists the pairs of blocks
    that overlap.
    """
    shapes = replace(shapes, contact_tolerance=depth)
    mortar = mortar_gaps(scene, shapes)
    if len(mortar.pair):
        return mortar, True
    facing = facing_sides(scene, shapes, near, shapes.reach[near].min(axis=1, initial=np.inf))
    number_of_pair = np.array([len(scene.blocks), 1])
    overlap = np.isin(near @ number_of_pair, overlapping @ number_of_pair)
    touch = (facing.most <= shapes.tolerance) & ~overlap[facing.pair]
    return near_misses((facing.where(touch),), facing.where(~touch), len(near)), False


def _advice_on_inexact(scene: Scene, shapes: Extents, sides: Facing, depth: float) -> str:
    """Return advice on options that turn the given sides, and overlaps up to a given depth, into joints.

    The option is the tolerance, unless a tolerance that closes the gaps is so large that joints may be lost.
    """
    tolerance = max(depth, joining_tolerance(sides))
    if not has_large_tolerance(scene, replace(shapes, tolerance=tolerance)):
        parallel = " (the tolerance also aligns nearly parallel sides)" if tolerance > depth else ""
        return f"if coordinates are inexact, {set_tolerance(tolerance)}{parallel}"
    closes, aligning = float(sides.most.max(initial=depth)), _aligning(shapes, sides)
    if not aligning:
        return f"if coordinates are inexact, {set_contact_tolerance(closes)}"
    meant = "if the blocks are meant to overlap, set only 'contact_tolerance'"
    return f"if coordinates are inexact, {set_both(closes, aligning)}; {meant}"


def _advice_on_meant(shapes: Extents, sides: Facing, depth: float, is_mortar: bool, several: bool) -> str:
    """Return advice on options that turn overlaps into joints, for stones that are meant to overlap.

    If the gaps between the given sides are mortar, the options also close these gaps. If the drawing may be a
    survey, the options also align the sides. A drawing may be a survey if it omits the mortar, or if
    ``several`` pairs of blocks overlap by up to the given depth.
    """
    closes = float(sides.most.max(initial=depth))
    advice = f"if they are meant to overlap, {set_contact_tolerance(closes if is_mortar else depth)}"
    if is_mortar:
        advice += ", which also closes the gaps of the mortar"
    aligning = _aligning(shapes, sides) if is_mortar or several else 0.0
    if not aligning:
        return advice
    return f"{advice}; if the drawing is a survey, {set_both(closes, aligning)}"


def _aligning(shapes: Extents, sides: Facing) -> float:
    """Return a value of ``tolerance`` that aligns the sides.

    The result is 0 if the present value is sufficient, or if no value aligns the sides without losing joints.
    """
    aligning = aligning_tolerance(sides)
    return aligning if aligning > shapes.tolerance else 0.0

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

#: Smallest fraction by which an advised tolerance exceeds the computed depth of an overlap. The two sides of
#: a wedge-shaped overlap may be farther apart than this depth, in rare cases by 0.002 %. With zero, an
#: advised tolerance may be too small to join the sides.
_DEPTH_ERROR = 1e-3


def refuse_overlaps(scene: Scene, shapes: Extents, near_pairs: np.ndarray) -> None:
    """Raise CaseError if two blocks overlap by more than the contact tolerance.

    ``near_pairs`` lists the pairs of blocks that are near each other, shape (pairs, 2).
    """
    (low, high), (i, j) = shapes.boxes, near_pairs.T
    common_extent = np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])
    pairs = near_pairs[(common_extent > shapes.contact_tolerance).all(axis=1)]
    overlaps: dict[int, list[Common]] = {}
    for number, piece in shapes.overlaps(pairs):
        overlaps.setdefault(number, []).append(piece)
        if len(overlaps) == shapes.enough:
            break
    if not overlaps:
        return
    size = {pair: sum(piece.size for piece in pieces) for pair, pieces in overlaps.items()}
    worst_pair = max(size, key=lambda pair: size[pair])
    deepest = max(overlaps[worst_pair], key=lambda piece: piece.depth)
    names = [repr(scene.blocks[index].name) for index in pairs[worst_pair]]
    depth = max(piece.depth for pieces in overlaps.values() for piece in pieces)
    advised_depth = depth * (1 + _DEPTH_ERROR)
    advice = "move the blocks apart"
    if size[worst_pair] > _SHARE_INSIDE * shapes.size[pairs[worst_pair]].min():
        advice = "one block is inside the other: move the blocks apart, or remove one of them"
    elif deepest.depth <= shapes.reach[pairs[worst_pair]].min() and scene.contact_tolerance is None:
        # A thin overlap may be due to inexact coordinates, so the message also recommends a tolerance.
        sides, _ = _sides_to_join(scene, shapes, near_pairs, pairs[[*overlaps]], advised_depth)
        advice += f"; {_advice_on_inexact_coordinates(scene, shapes, sides, advised_depth)}"
    elif depth <= MORTAR * shapes.width[pairs[worst_pair]].min():
        sides, is_mortar = _sides_to_join(scene, shapes, near_pairs, pairs[[*overlaps]], advised_depth)
        advice += (
            f"; {_advice_on_intended_overlaps(shapes, sides, advised_depth, is_mortar, len(overlaps) > 1)}"
        )
    else:
        advice += ", or remove one of them if both are the same stone"
    omitted_count = len(overlaps) - 1
    qualifier = "at least " if len(overlaps) == shapes.enough else ""
    addition = ""
    if omitted_count:
        verb = "overlaps" if omitted_count == 1 else "overlap"
        addition = f" ({qualifier}{counted(omitted_count, 'more pair')} {verb}, up to {rounded(depth)} deep)"
    overlap = f"blocks {names[0]} and {names[1]} overlap {shapes.within} of {size[worst_pair]:.6g}"
    location = place(deepest.middle + shapes.origin, shapes.contact_tolerance)
    position = f"near {location}, {rounded(deepest.depth)} deep"
    raise CaseError(f"{scene.origin}: {overlap} {position}: {advice}{addition}")


def _sides_to_join(
    scene: Scene, shapes: Extents, near_pairs: np.ndarray, overlapping_pairs: np.ndarray, depth: float
) -> tuple[Facing, bool]:
    """Return the sides that larger tolerances could join, and True if the scene is drawn without mortar.

    If the scene is drawn without its mortar, the sides are the sides of its mortar joints. Otherwise they are
    the sides that a small error separates, and the sides of blocks that overlap by at most ``depth``.

    ``near_pairs`` lists the pairs of blocks that may face each other. ``overlapping_pairs`` lists the pairs
    of blocks that overlap.
    """
    shapes = replace(shapes, contact_tolerance=depth)
    mortar = mortar_gaps(scene, shapes)
    if len(mortar.pair):
        return mortar, True
    facing = facing_sides(scene, shapes, near_pairs, shapes.reach[near_pairs].min(axis=1, initial=np.inf))
    number_of_pair = np.array([len(scene.blocks), 1])
    is_overlapping = np.isin(near_pairs @ number_of_pair, overlapping_pairs @ number_of_pair)
    is_touching = (facing.largest_gap <= shapes.tolerance) & ~is_overlapping[facing.pair]
    return near_misses((facing.where(is_touching),), facing.where(~is_touching), len(near_pairs)), False


def _advice_on_inexact_coordinates(scene: Scene, shapes: Extents, sides: Facing, depth: float) -> str:
    """Return advice on options that turn the given sides, and overlaps up to a given depth, into joints.

    The option is the tolerance, unless a tolerance that closes the gaps is so large that joints may be lost.
    """
    tolerance = max(depth, joining_tolerance(sides))
    if not has_large_tolerance(scene, replace(shapes, tolerance=tolerance)):
        effect = " (the tolerance also aligns nearly parallel sides)" if tolerance > depth else ""
        return f"if coordinates are inexact, {set_tolerance(tolerance)}{effect}"
    closing_tolerance, alignment_tolerance = (
        float(sides.largest_gap.max(initial=depth)),
        _alignment_tolerance(shapes, sides),
    )
    if not alignment_tolerance:
        return f"if coordinates are inexact, {set_contact_tolerance(closing_tolerance)}"
    alternative = "if the blocks are meant to overlap, set only 'contact_tolerance'"
    return f"if coordinates are inexact, {set_both(closing_tolerance, alignment_tolerance)}; {alternative}"


def _advice_on_intended_overlaps(
    shapes: Extents, sides: Facing, depth: float, is_mortar: bool, has_several_overlaps: bool
) -> str:
    """Return advice on options that turn overlaps into joints, for stones that are meant to overlap.

    If the gaps between the given sides are mortar, the options also close these gaps. If the drawing may be a
    survey, the options also align the sides. A drawing may be a survey if it omits the mortar, or if
    ``has_several_overlaps`` is True: several pairs of blocks overlap by up to the given depth.
    """
    closing_tolerance = float(sides.largest_gap.max(initial=depth))
    advice = (
        f"if they are meant to overlap, {set_contact_tolerance(closing_tolerance if is_mortar else depth)}"
    )
    if is_mortar:
        advice += ", which also closes the gaps of undrawn mortar joints"
    alignment_tolerance = _alignment_tolerance(shapes, sides) if is_mortar or has_several_overlaps else 0.0
    if not alignment_tolerance:
        return advice
    return f"{advice}; if the drawing is a survey, {set_both(closing_tolerance, alignment_tolerance)}"


def _alignment_tolerance(shapes: Extents, sides: Facing) -> float:
    """Return the value of ``tolerance`` that makes nearly parallel sides parallel, or 0.

    The result is 0 if no two sides are nearly parallel, if the present value is sufficient, or if the value
    would remove joints.
    """
    tolerance = aligning_tolerance(sides)
    return tolerance if tolerance > shapes.tolerance else 0.0

"""Find stones that are drawn without their mortar, and the contact tolerance that joins them.

Three functions decide which gaps are mortar joints. They differ, because they have different evidence:

- :func:`find_bridge`: Floating blocks prove that gaps must be closed, so even one narrow gap counts.
- :func:`bridged_by_tolerance`: The tolerance of a rough survey also closes many gaps, so the gaps count only
  if they are wide compared with the errors of their sides.
- :func:`mortar_gaps`: Blocks overlap, so errors may be as large as the gaps, and the number of the gaps is
  decisive.
"""

from bisect import bisect_left
from dataclasses import dataclass, replace

import numpy as np

from masonry_opt.errors import counted, rounded, rounded_down
from masonry_opt.scene.contacts.faces import NARROWEST
from masonry_opt.scene.contacts.gaps import Closing, aligning_tolerance, closing
from masonry_opt.scene.contacts.neighbours import facing_sides, near_pairs
from masonry_opt.scene.contacts.sides import SMALL_LENGTH_RATIO, Facing
from masonry_opt.scene.geometry import (
    MORTAR,
    NEAR_MISS,
    RELATIVE_TOLERANCE,
    Extents,
    raise_for,
    refuse_too_thin,
)
from masonry_opt.scene.rows import linked
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tolerance_advice import set_tolerance

#: A gap counts as a mortar joint if its mean width is at most this multiple of the median width of the gaps.
#: With a larger value, messages advise values of options that also close narrow openings.
_WIDEST_OF_MORTAR = 2.0

#: Largest mean width of a mortar joint, relative to the width of the narrower block, in the second search for
#: mortar joints. The second search is made if the first search, with the smaller limit ``MORTAR``, does not
#: connect all floating blocks to supports. With a larger value, messages would also advise closing gaps that
#: are mistakes of the drawing.
_WIDE_MORTAR = 0.6

#: Largest advised ``contact_tolerance``, relative to the thickness of the thinnest movable block. A value as
#: large as the thickness would be refused.
_MOST_OF_THICKNESS = 0.95

#: Several gaps count as mortar joints if the sides of each gap become parallel when a corner moves by at most
#: this fraction of the gap's width. With a larger value, gaps that are due to inaccurate coordinates count
#: too.
_PARALLEL_ERROR = 0.1

#: Smallest thickness of a block, relative to ``tolerance``. A thinner movable block raises an error,
#: because its opposite sides may merge into one line or plane.
_THINNEST = 2.0

#: Fraction of ``contact_tolerance`` by which a gap may exceed it because of rounding errors. With a smaller
#: value, gaps that are exactly as wide as ``contact_tolerance`` would cause false warnings.
_ROUNDING = 1e-6

#: Gaps of a survey count as mortar joints if the median difference between the widths at their two ends is at
#: most this fraction of their median width. With a larger value, gaps that are due to inaccurate coordinates
#: count too.
_SURVEY_ERROR = 0.5

#: Gaps of a survey, or of a scene that is drawn without its mortar, count as mortar joints only if at least
#: this fraction of all joints crosses such gaps. With a smaller value, gaps at a few inaccurate corners count
#: too.
_SURVEY_FRACTION = 0.5


@dataclass(frozen=True)
class Bridge:
    """Value of ``contact_tolerance`` or ``tolerance`` that connects floating blocks to supports."""

    closing: Closing  #: scene option that closes the gaps, and the smallest value that closes them all
    gap: float  #: width of the widest gap that ``closing`` closes; 0 if the blocks touch
    widest: tuple[int, int]  #: indices of the two blocks at the widest gap
    breadth: float  #: smallest breadth of the joints that ``closing`` adds
    joints: int  #: number of joints that ``closing`` adds
    blocks: int  #: number of floating blocks that ``closing`` connects to supports
    remaining: np.ndarray  #: indices of the floating blocks that ``closing`` does not connect to supports
    #: For each block at a gap, the index of the block across the gap, and the width of the gap.
    neighbour: dict[int, tuple[int, float]]
    #: True if the scene's ``tolerance`` is as large as a mortar joint. The advice is then to remove
    #: ``tolerance``, and to set ``contact_tolerance`` instead.
    replaces_tolerance: bool
    lowers_tolerance: bool  #: True if ``closing`` is a value of ``tolerance`` below its present value
    #: Value of ``tolerance`` that aligns the sides of the gaps; 0 if the sides are parallel, if the present
    #: value aligns them already, or if such a value would remove joints of solids.
    aligning: float

    def advice(self, scene: Scene) -> str:
        """Return the part of a message that advises how to connect the floating blocks to supports.

        The text advises a value of ``contact_tolerance`` or ``tolerance``, and describes the effect of this
        value.
        """
        if not self.gap:
            joint_count = counted(self.joints, "joint")
            return (
                f"set 'tolerance' to less than {rounded_down(self.breadth / NARROWEST)}, because its present "
                f"value prevents {joint_count} that would connect {self._describe_connections(scene)}"
            )
        first, second = (repr(scene.blocks[index].name) for index in self.widest)
        advice = self.closing.advice
        if self.lowers_tolerance:
            advice = advice.replace("set", "lower", 1)
        survey = ""
        if self.aligning:
            removal = ", and otherwise remove 'tolerance'" if self.replaces_tolerance else ""
            survey = (
                f"; if the drawing is a survey, also {set_tolerance(self.aligning)}, which makes nearly "
                f"parallel joints parallel{removal}"
            )
        elif self.replaces_tolerance:
            advice += " and remove 'tolerance'"
        return (
            f"{advice}, which makes {counted(self.joints, 'joint')} "
            f"across gaps of up to {rounded(self.gap)} (the widest gap is between {first} and {second}) "
            f"and connects {self._describe_connections(scene)}{survey}"
        )

    def _describe_connections(self, scene: Scene) -> str:
        """Return a text that counts the blocks connected to supports, and names an unconnected block."""
        connection = f"{counted(self.blocks, 'block')} to supports"
        omitted_count = len(self.remaining) - 1
        if omitted_count < 0:
            return connection
        addition = f" and {counted(omitted_count, 'other block')}" if omitted_count else ""
        return f"{connection}, but not {scene.blocks[self.remaining[0]].name!r}{addition}"


def find_bridge(
    scene: Scene,
    shapes: Extents,
    joint_ends: tuple[np.ndarray, np.ndarray],
    is_supported: np.ndarray,
    gap_option: Closing,
) -> Bridge | None:
    """Find the smallest value of a scene option at which floating blocks become connected to supports.

    The option is ``contact_tolerance`` or ``tolerance``. Its value is the width of the widest gap that must
    be closed, or of a wider gap that is mortar of the same masonry. Gaps wider than usual mortar are closed
    only if more blocks then become connected. Gaps about as wide as the thinnest block are never closed,
    because such a value would be refused. None is returned if no value connects a floating block.

    Parameters
    ----------
    scene : Scene
        The scene.
    shapes : Extents
        Shapes of the blocks of the scene.
    joint_ends : tuple of ndarray
        The two blocks of each joint, and of each tie and prop between blocks.
    is_supported : ndarray
        True for each block that is fixed, or that a tie or prop connects to the ground, shape (blocks,).
    gap_option : Closing
        Option that closes the small gaps of the scene.
    """
    bridge = _bridge_within(scene, shapes, joint_ends, is_supported, gap_option)
    if bridge is not None and not len(bridge.remaining):
        return bridge
    wider_bridge = _bridge_within(scene, shapes, joint_ends, is_supported, gap_option, share=_WIDE_MORTAR)
    if bridge is None:
        return wider_bridge
    if wider_bridge is None or len(wider_bridge.remaining) >= len(bridge.remaining):
        return bridge
    return wider_bridge


def _bridge_within(
    scene: Scene,
    shapes: Extents,
    joint_ends: tuple[np.ndarray, np.ndarray],
    is_supported: np.ndarray,
    gap_option: Closing,
    *,
    share: float = MORTAR,
) -> Bridge | None:
    """Return the result of :func:`find_bridge` for gaps up to ``share`` times the narrower block's width."""
    pairs, facing = _gaps_to_close(scene, shapes, joint_ends, share=share)
    thickness = float(shapes.thickness()[~scene.fixed].min())
    facing = facing.where(facing.largest_gap <= _MOST_OF_THICKNESS * thickness)
    ends = pairs[facing.pair]

    def floating(gap: float) -> np.ndarray:
        """Return the blocks that remain floating when gaps up to a given width are closed."""
        gap_ends = ends[facing.largest_gap <= gap]
        group = linked(
            len(scene.blocks),
            *(np.append(joint, pair) for joint, pair in zip(joint_ends, gap_ends.T, strict=True)),
        )
        return np.flatnonzero(~np.isin(group, group[is_supported]))

    initial_count, remaining = len(floating(-np.inf)), floating(np.inf)
    if len(remaining) == initial_count:
        return None
    widths = np.unique(facing.largest_gap)
    needed_gap = widths[bisect_left(widths, -len(remaining), key=lambda gap: -len(floating(gap)))]
    median_gap = float(np.median(facing.largest_gap[facing.largest_gap <= needed_gap]))
    is_mortar = (facing.largest_gap <= needed_gap) | _is_no_opening(facing, median_gap)
    gap = float(facing.largest_gap[is_mortar].max())
    connected_count = initial_count - len(floating(gap))
    # Find the facing sides again with the new ``contact_tolerance``, so that a gap along a curved edge, which
    # is drawn as a chain of short edges, counts as one joint.
    pairs, facing = _gaps_to_close(scene, shapes, joint_ends, contact_tolerance=gap, share=share)
    closed_gaps = facing.where(facing.largest_gap <= gap)
    if not len(closed_gaps.pair):
        return None
    closed_ends = pairs[closed_gaps.pair]
    # Round the widths, so that rounding errors do not decide which of several equal gaps a message names.
    width = np.round(closed_gaps.largest_gap / max(gap, fine_tolerance(scene, shapes)), 6)
    first, second = closed_ends[width.argmax()].tolist()
    neighbour: dict[int, tuple[int, float]] = {}
    for row in np.argsort(width, kind="stable").tolist():
        i, j = closed_ends[row].tolist()
        neighbour.setdefault(i, (j, float(closed_gaps.largest_gap[row])))
        neighbour.setdefault(j, (i, float(closed_gaps.largest_gap[row])))
    option = _option(scene, shapes, pairs, closed_gaps, gap_option)
    if gap <= fine_tolerance(scene, shapes):
        gap = 0.0
    replaces = option.option == "contact_tolerance" and has_large_tolerance(scene, shapes)
    lowers = option.option == "tolerance" and option.tolerance < shapes.tolerance
    alignment_tolerance = 0.0
    if option.option == "contact_tolerance" and not _are_parallel(closed_gaps):
        alignment_tolerance = aligning_tolerance(closed_gaps)
    if alignment_tolerance <= shapes.tolerance and not replaces:
        alignment_tolerance = 0.0
    return Bridge(
        closing=option,
        gap=gap,
        widest=(first, second),
        breadth=float(closed_gaps.breadth.min()),
        joints=len(closed_gaps.pair),
        blocks=connected_count,
        remaining=remaining,
        neighbour=neighbour,
        replaces_tolerance=replaces,
        lowers_tolerance=lowers,
        aligning=alignment_tolerance,
    )


def _gaps_to_close(
    scene: Scene,
    shapes: Extents,
    joint_ends: tuple[np.ndarray, np.ndarray],
    *,
    contact_tolerance: float | None = None,
    share: float = MORTAR,
) -> tuple[np.ndarray, Facing]:
    """Return pairs of neighbouring blocks, and their sides that other values of the tolerances could join.

    A larger ``contact_tolerance`` or ``tolerance`` could join sides with a gap of up to ``share`` times the
    width of the narrower block. A smaller ``tolerance`` could join sides that touch and have no joint.
    ``joint_ends`` has the two blocks of each joint. The argument ``contact_tolerance`` replaces the contact
    tolerance of the shapes if it is larger.
    """
    wide_shapes = replace(shapes, contact_tolerance=max(shapes.contact_tolerance, contact_tolerance or 0.0))
    pairs, facing = facing_across_mortar(scene, wide_shapes, share)
    is_joined = np.isin(pair_codes(pairs[facing.pair], scene), pair_codes(np.column_stack(joint_ends), scene))
    return pairs, facing.where(~is_joined | (facing.largest_gap > shapes.contact_tolerance))


def _option(scene: Scene, shapes: Extents, pairs: np.ndarray, gaps: Facing, gap_option: Closing) -> Closing:
    """Return the scene option that closes the given gaps, and the value that closes them all.

    Several gaps with parallel sides count as mortar joints, which ``contact_tolerance`` closes. If the option
    ``tolerance`` closes both the given gaps and the small gaps of the scene, as ``gap_option`` does, its
    value suffices for all of these gaps.
    """
    option = closing(scene, shapes, pairs, gaps)
    if len(gaps.pair) > 1 and _are_parallel(gaps):
        return Closing("contact_tolerance", float(gaps.largest_gap.max()))
    if option.option == gap_option.option == "tolerance":
        return Closing("tolerance", max(option.tolerance, gap_option.tolerance))
    return option


def mortar_gaps(scene: Scene, shapes: Extents) -> Facing:
    """Return the gaps that mortar fills in a scene that is drawn without its mortar.

    For other scenes the result has no rows. A scene is drawn without its mortar if several gaps separate at
    least half of the pairs of sides that face each other. Gaps that are only errors of the drawing do not
    count. Gaps that are much wider than the median gap are openings, and are left out.
    """
    pairs, facing = facing_across_mortar(scene, shapes)
    gaps = facing.where(facing.largest_gap > _widest_error(shapes, pairs, facing))
    if not _are_usual(gaps, len(facing.pair)):
        return gaps.where(np.zeros(0, dtype=int))
    return gaps.where(_is_no_opening(gaps, float(np.median(_mean_gap(gaps)))))


def wedge_at_corners(scene: Scene, shapes: Extents, at_corners: list[tuple[int, int]]) -> float:
    """Return the width of the widest gap that begins at touching corners of two blocks.

    Such a gap is a wedge as narrow as mortar, as between rectangular bricks of an arch that touch at the
    intrados. The result is 0 if there is no such gap. ``at_corners`` has the pairs of blocks whose corners
    touch.
    """
    if not at_corners:
        return 0.0
    pairs = np.unique(np.sort(at_corners, axis=1), axis=0)
    facing = _sides_across_mortar(scene, shapes, pairs, _thickest_mortar(scene, shapes))
    return float(facing.largest_gap.max(initial=0.0))


def is_drawn_apart(scene: Scene, shapes: Extents) -> bool:
    """Return True if the options of the scene show that blocks are drawn with gaps between them.

    The scene then has a ``contact_tolerance``, or a large ``tolerance``.
    """
    return scene.contact_tolerance is not None or has_large_tolerance(scene, shapes)


def has_large_tolerance(scene: Scene, shapes: Extents) -> bool:
    """Return True if ``tolerance`` is larger than 1 % of the width of the narrowest movable block.

    Errors of a drawing are usually smaller.
    """
    return shapes.tolerance > NEAR_MISS * float(shapes.width[~scene.fixed].min())


def bridged_by_tolerance(
    scene: Scene, shapes: Extents, pairs: np.ndarray, sides: Facing
) -> tuple[dict[tuple[int, int], float], float]:
    """Return the pairs of blocks between which the option ``tolerance`` closes a gap as wide as mortar.

    Several such gaps with parallel sides count as mortar joints. In a survey, whose sides are not exactly
    parallel, gaps count as mortar joints if at least half of the joints cross such a gap, and if the gaps are
    wide compared with the errors of their sides. Option ``contact_tolerance`` makes the same joints, but does
    not move corners.

    The first result contains the width of the gap between the blocks of each pair. The second result is the
    value of ``tolerance`` that makes the sides of the gaps parallel. It is 0 if they are parallel already, or
    if such a value would remove joints of solids.

    Parameters
    ----------
    scene : Scene
        The scene.
    shapes : Extents
        Shapes of the blocks of the scene.
    pairs : ndarray
        Pairs of blocks, shape (pairs, 2).
    sides : Facing
        Sides of these pairs that face each other and have a joint.
    """
    if not has_large_tolerance(scene, shapes):
        return {}, 0.0
    # Gaps up to this width are closed by ``contact_tolerance``, even with a small ``tolerance``. Such gaps do
    # not count here.
    width_limit = (1 + _ROUNDING) * (scene.contact_tolerance or 0.0)
    gaps = sides.where(sides.largest_gap > np.maximum(_widest_error(shapes, pairs, sides), width_limit))
    if len(gaps.pair) < 2 or not (_are_parallel(gaps) or _are_surveyed(gaps, len(sides.pair))):
        return {}, 0.0
    bridged_gaps: dict[tuple[int, int], float] = {}
    for (i, j), width in zip(pairs[gaps.pair].tolist(), gaps.largest_gap.tolist(), strict=True):
        bridged_gaps[i, j] = max(bridged_gaps.get((i, j), 0.0), width)
    return bridged_gaps, 0.0 if _are_parallel(gaps) else aligning_tolerance(gaps)


def _widest_error(shapes: Extents, pairs: np.ndarray, facing: Facing) -> np.ndarray:
    """Return the width up to which each gap may be an error of the drawing, shape (n,).

    Wider gaps may be mortar. ``pairs`` lists the blocks of each pair.
    """
    error: np.ndarray = NEAR_MISS * shapes.width[pairs[facing.pair]].min(axis=1)
    return error


def _is_no_opening(gaps: Facing, usual_width: float) -> np.ndarray:
    """Return a mask of the gaps that are not much wider than ``usual_width``; wider gaps are openings."""
    mask: np.ndarray = _mean_gap(gaps) <= _WIDEST_OF_MORTAR * usual_width
    return mask


def _are_parallel(gaps: Facing) -> bool:
    """Return True if the two sides of each gap are parallel, apart from small errors."""
    return bool((gaps.angle * gaps.shorter_side <= _PARALLEL_ERROR * gaps.largest_gap).all())


def _are_surveyed(gaps: Facing, joints: int) -> bool:
    """Return True if the given gaps are probably the mortar joints of a surveyed wall.

    At least half of all joints must cross such gaps. The median difference between the widths at the two ends
    of a gap must be small compared with the median width. The ``gaps`` are wider than errors
    of the drawing. ``joints`` is the number of all joints along sides.
    """
    if not _are_usual(gaps, joints):
        return False
    difference = float(np.median(gaps.angle * gaps.width))
    return difference <= _SURVEY_ERROR * float(np.median(_mean_gap(gaps)))


def _are_usual(gaps: Facing, joints: int) -> bool:
    """Return True if there are several ``gaps``, and if at least half of all joints cross such gaps."""
    return len(gaps.pair) >= max(2, _SURVEY_FRACTION * joints)


def refuse_thin_blocks(scene: Scene, shapes: Extents) -> None:
    """Raise CaseError if a movable block is not thicker than the tolerances of the scene.

    The message names the thinnest block.
    """
    is_large = shapes.tolerance > SMALL_LENGTH_RATIO * shapes.width[~scene.fixed].min()
    if scene.contact_tolerance is None and not is_large:
        return
    thickness = np.where(scene.fixed, np.inf, shapes.thickness())
    order = np.argsort(thickness, kind="stable")
    smallest_thickness = float(thickness[order[0]])
    refuse_too_thin(scene, np.arange(len(thickness)), thickness, (_THINNEST * shapes.tolerance, 0.0))
    if scene.contact_tolerance is None:
        return
    too_thin = order[thickness[order] <= scene.contact_tolerance]
    raise_for(
        too_thin,
        scene,
        f"{{}} is {rounded(smallest_thickness)} thick, but must be thicker than 'contact_tolerance' "
        f"{rounded(scene.contact_tolerance)}: lower 'contact_tolerance', "
        "or draw the block and a neighbour as one block",
    )


def facing_across_mortar(scene: Scene, shapes: Extents, share: float = MORTAR) -> tuple[np.ndarray, Facing]:
    """Return pairs of neighbouring blocks, and their sides that touch or have a gap as narrow as mortar.

    The mean width of the gap is at most ``share`` times the width of the narrower block.
    """
    limits = _thickest_mortar(scene, shapes, share)
    # Search within twice the thickness of mortar, because a wedge-shaped gap may be twice as wide at one end
    # as in the middle.
    pairs = near_pairs(scene, shapes, 2 * limits)
    pairs = pairs[~scene.fixed[pairs].all(axis=1)]
    return pairs, _sides_across_mortar(scene, shapes, pairs, limits)


def _thickest_mortar(scene: Scene, shapes: Extents, share: float = MORTAR) -> np.ndarray:
    """Return, for each block, the largest mean width of a gap that counts as mortar, shape (blocks,).

    This limit is ``share`` times the width of the block. A fixed block counts as wide as the widest movable
    block.
    """
    movable_width = shapes.width[~scene.fixed]
    limits: np.ndarray = share * np.where(scene.fixed, movable_width.max(), shapes.width)
    return limits


def _sides_across_mortar(scene: Scene, shapes: Extents, pairs: np.ndarray, limits: np.ndarray) -> Facing:
    """Return the sides of pairs of blocks that touch, or that a gap as narrow as mortar separates.

    The mean width of the gap is at most the value of ``limits`` for both blocks. The sides are computed with
    a ``tolerance`` of at most the default value, because a large ``tolerance`` would hide some of the sides.
    """
    fine_shapes = replace(shapes, tolerance=fine_tolerance(scene, shapes))
    gap_limit = limits[pairs].min(axis=1, initial=np.inf)
    facing = facing_sides(scene, fine_shapes, pairs, 2 * gap_limit)
    return facing.where(_mean_gap(facing) <= gap_limit[facing.pair])


def fine_tolerance(scene: Scene, shapes: Extents) -> float:
    """Return the option ``tolerance`` of the scene or its default, whichever is smaller."""
    low, high = (corners[~scene.fixed] for corners in shapes.boxes)
    default = RELATIVE_TOLERANCE * float(np.hypot.reduce(high.max(axis=0) - low.min(axis=0)))
    return min(shapes.tolerance, default)


def _mean_gap(facing: Facing) -> np.ndarray:
    """Return the mean distance between sides that face each other, shape (n,)."""
    mean: np.ndarray = facing.largest_gap - facing.angle * facing.width / 2
    return mean


def pair_codes(ends: np.ndarray, scene: Scene) -> np.ndarray:
    """Return a number that identifies each pair of blocks in either order, shape (pairs,)."""
    codes: np.ndarray = ends.min(axis=1) * len(scene.blocks) + ends.max(axis=1)
    return codes

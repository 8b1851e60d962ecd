"""Join open curves of a drawing to closed loops, and find outlines that are not closed."""

import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from masonry_opt.errors import rounded
from masonry_opt.scene.drawings.defects import WIDEST_ERROR, WIDEST_GAP, Defect, Defects, near
from masonry_opt.scene.drawings.meshes import first_near, rings_of
from masonry_opt.scene.drawings.outlines import Curve


class OpenLine(NamedTuple):
    """Chain of connected curves that is not closed, represented by the straight line between its ends."""

    ends: np.ndarray  #: ends of the line, shape (2, 2)
    length: float  #: total length of the curves
    gap: float  #: distance to the nearest end of another open outline, infinite if there is none
    curves: list[Curve]  #: curves of which the line consists
    defect: Defect  #: defect of an open outline


def closed_outlines(
    curves: Sequence[Curve],
    is_support: Callable[[Curve], bool],
    tolerance: float,
    rounding: float,
    defects: Defects,
) -> tuple[list[Curve], list[tuple[Curve, Curve]], list[OpenLine]]:
    """Return the closed curves of a drawing, and the closed loops formed by the open curves of each layer.

    Curves and loops are in the order of the drawing. Two ends of curves are joined if their distance is
    within the rounding, or if it is within the tolerance and no third free end is as near. Parts of a closed
    polyline are joined only to each other. Open curves that
    do not belong to a simple loop are added to the defects, except straight lines. ``is_support`` returns
    True for a curve on a layer of supports.

    The second list contains the copies of open curves on the same layer, which are left out, each with its
    original. The third list contains straight lines that do not belong to a loop.
    """
    outlines = []
    open_curves: defaultdict[tuple[str, str], list[tuple[int, Curve]]] = defaultdict(list)
    originals: dict[tuple[str, str, bytes], Curve] = {}
    copies = []
    lines: list[OpenLine] = []
    for number, curve in enumerate(curves):
        extent = np.ptp(curve.points, axis=0).max()
        if curve.closed or math.dist(curve.points[0], curve.points[-1]) <= tolerance < extent:
            outlines.append((number, curve))
            continue
        # Two curves with equal keys are copies. The key does not depend on the direction of the curve,
        # because a copy may run in the opposite direction.
        grid_points = np.round(curve.points / rounding) + 0.0
        key = curve.layer, curve.polyline, min(grid_points.tobytes(), grid_points[::-1].tobytes())
        if key in originals:
            copies.append((curve, originals[key]))
            continue
        originals[key] = curve
        open_curves[curve.layer, curve.polyline].append((number, curve))
    for curves_of_layer in open_curves.values():
        on_support_layer = is_support(curves_of_layer[0][1])
        outlines += _loops(curves_of_layer, (rounding, tolerance), lines, defects, on_support_layer)
    return [curve for _, curve in sorted(outlines, key=lambda entry: entry[0])], copies, lines


def _loops(
    curves: list[tuple[int, Curve]],
    tolerances: Sequence[float],
    lines: list[OpenLine],
    defects: Defects,
    on_support_layer: bool,
) -> list[tuple[int, Curve]]:
    """Return the closed loops that open curves of a layer form, each with the index of its first curve.

    See :func:`closed_outlines` for the tolerances, the lines and the defects.
    """
    ends = np.array([curve.points[end] for _, curve in curves for end in (0, -1)])
    partner: dict[int, int] = {}
    free_ends = np.arange(len(ends))
    for tolerance in tolerances:
        node = first_near(ends[free_ends], tolerance)
        meeting_count = np.bincount(node)[node]
        by_node = np.argsort(node, kind="stable")
        for first, second in free_ends[by_node[meeting_count[by_node] == 2]].reshape(-1, 2).tolist():
            partner[first], partner[second] = second, first
        is_free = meeting_count != 2
        free_ends, node, meeting_count = free_ends[is_free], node[is_free], meeting_count[is_free]
        if not len(free_ends):
            break
    layer_curves = [curve for _, curve in curves]
    is_alone = meeting_count == 1
    for line in _open_chains(ends, free_ends[is_alone], partner, layer_curves, on_support_layer):
        _add_open_chain(line, tolerances[0], lines, defects)
    branches = np.unique(node[~is_alone], return_index=True)[1]
    for branch, other_count in zip(
        free_ends[~is_alone][branches], meeting_count[~is_alone][branches] - 1, strict=True
    ):
        mistake = f"touches {other_count} other ends of curves, but can be joined to only one"
        plural_mistake = "ends of curves touch several other ends, but can be joined to only one"
        change = "lower 'outline_tolerance' (--outline-tolerance) to separate the ends"
        remedy = _remedy(change, on_support_layer)
        defects.add(
            Defect(layer_curves[branch // 2].label, mistake, plural_mistake, remedy, near(*ends[branch]))
        )
    next_end = {end: partner[end ^ 1] for end in range(len(ends)) if end ^ 1 in partner}
    for start in free_ends.tolist():
        # Remove the curves of each open chain, beginning at a free end, so that only closed loops remain in
        # `next_end`.
        end: int | None = start
        while end is not None:
            end = next_end.pop(end, None)
    # Each ring describes a closed loop of curves. For each curve in order along the loop, the ring has the
    # index of the end at which the loop enters the curve.
    loops = []
    for ring in rings_of(next_end):
        if ring[0] % 2 == 0:  # skip the second copy of each loop, which runs in the opposite direction
            parts = [curves[end // 2][1].points[:: -1 if end % 2 else 1] for end in ring]
            number, curve = curves[ring[0] // 2]
            loops.append((number, curve._replace(points=np.concatenate(parts), closed=True)))
    return loops


def _open_chains(
    ends: np.ndarray,
    free_ends: np.ndarray,
    partner: dict[int, int],
    curves: Sequence[Curve],
    on_support_layer: bool,
) -> Iterator[OpenLine]:
    """Yield each open chain of curves as a line between its ends.

    ``free_ends`` lists the ends without another end nearby.
    """
    visited_ends = set()
    for start in free_ends.tolist():
        if start in visited_ends:
            continue
        end = start
        chain = [curves[start // 2]]
        while end ^ 1 in partner:
            end = partner[end ^ 1]
            chain.append(curves[end // 2])
        visited_ends.add(end ^ 1)
        distance = np.hypot(*(ends[free_ends] - ends[start]).T)
        nearest_distance = float(np.sort(distance)[1]) if len(free_ends) > 1 else math.inf
        gap_text = f", {rounded(nearest_distance)} from the nearest free end" if len(free_ends) > 1 else ""
        place = f"{near(*ends[start])}{gap_text}"
        length = sum(float(np.hypot(*np.diff(curve.points, axis=0).T).sum()) for curve in chain)
        chain_ends = [start, end ^ 1]
        change = _closing_advice(chain, length, math.dist(*ends[chain_ends]), nearest_distance)
        remedy = _remedy(change, on_support_layer)
        gaps = [float(np.sort(np.hypot(*(ends[free_ends] - ends[tip]).T))[:2][-1]) for tip in chain_ends]
        widest_gap = max((gap for gap in gaps if gap <= WIDEST_ERROR * length), default=0.0)
        defect = Defect(chain[0].label, "is open", "outlines are open", remedy, place, widest_gap)
        other_ends = ends[free_ends[~np.isin(free_ends, chain_ends)]]
        gap_width = min(
            float(np.hypot(*(other_ends - ends[tip]).T).min(initial=math.inf)) for tip in chain_ends
        )
        yield OpenLine(ends[chain_ends], length, gap_width, chain, defect)


def _add_open_chain(line: OpenLine, tolerance: float, lines: list[OpenLine], defects: Defects) -> None:
    """Add an open chain of curves to the lines or to the defects.

    A chain is a line if it is straight within the tolerance, and if no end of another chain is near. An end
    of another chain would be near if the chain were a side of an outline.
    """
    distance = math.dist(*line.ends)
    if distance > 0 and line.length - distance <= tolerance and line.gap > WIDEST_ERROR * line.length:
        lines.append(line)
    else:
        defects.add(line.defect)


def _closing_advice(chain: Sequence[Curve], length: float, own_gap: float, nearest_distance: float) -> str:
    """Return advice on how to close an open chain of curves with a given total length.

    The distance between the ends of the chain is ``own_gap``. The distance from its first end to the nearest
    free end is ``nearest_distance``.
    """
    raise_advice = f"set 'outline_tolerance' (--outline-tolerance) to {WIDEST_GAP} to close the gaps"
    is_near = nearest_distance <= WIDEST_ERROR * length
    if own_gap > WIDEST_ERROR * length and all(len(curve.points) > 2 for curve in chain):
        flag_advice = "set the flag 'closed' of polylines that lack their last side"
        return f"{flag_advice}, {raise_advice}" if is_near else flag_advice
    return raise_advice if is_near else "draw the missing sides"


def _remedy(change: str, on_support_layer: bool) -> str:
    """Return the remedy for lines that do not form simple loops."""
    ground = (
        "a ground line must be a single straight line with all blocks on one side and no outline behind it, "
        "so draw any other ground as a closed outline; where lines are not the ground, "
    )
    return (
        f"{ground if on_support_layer else ''}draw blocks as closed polylines, {change}, use "
        "'without_layers' (--without-layer) to omit layers without outlines of blocks, or set 'net' (--net) "
        "if all lines are joints"
    )

"""Read a straight line on a layer of supports, such as a ground line, as the surface of a support."""

from collections.abc import Callable, Sequence

import numpy as np
import shapely

from masonry_opt.errors import shortened
from masonry_opt.scene.drawings import dxf_layers
from masonry_opt.scene.drawings.defects import WIDEST_ERROR, Defect, Defects, near
from masonry_opt.scene.drawings.loops import OpenLine
from masonry_opt.scene.drawings.outlines import Curve
from masonry_opt.scene.drawings.stones import SLAB_THICKNESS, SUPPORT_WORDS

#: Largest number of ground lines that one warning lists; further ground lines are only counted.
_MOST_GROUND_LINES = 10


def support_outlines(
    lines: Sequence[OpenLine],
    curves: Sequence[Curve],
    closed: Sequence[Curve],
    is_support: Callable[[Curve], bool],
    tolerance: float,
    defects: Defects,
) -> list[Curve]:
    """Return, for each straight ground line, the outline of a slab on the side without blocks.

    A line is the surface of a support if it is on a layer of supports, blocks are on only one of its sides,
    and the slab overlaps no outline. Other lines are added to the defects.

    Parameters
    ----------
    lines : sequence of OpenLine
        Straight lines that are not part of a closed outline.
    curves : sequence of Curve
        All curves of the drawing.
    closed : sequence of Curve
        Closed outlines of the drawing.
    is_support : callable
        Function that returns True for a curve on a layer of supports.
    tolerance : float
        Largest distance by which a block may extend beyond a line, on the side of the slab.
    defects : Defects
        Defects of the drawing.
    """
    handles = {curve.handle for line in lines for curve in line.curves}
    other_curves = [curve for curve in curves if curve.handle not in handles]
    block_points = [curve.points for curve in other_curves if not is_support(curve)]
    outlines: list[Curve] = []
    for line in lines:
        normal, heights = _normal_towards_blocks(line.ends, block_points)
        is_clear = bool(len(heights)) and heights.min() >= -tolerance
        far_side = line.ends[::-1] - SLAB_THICKNESS * line.length * normal
        slab = line.curves[0]._replace(points=np.concatenate([line.ends, far_side]), closed=True)
        if is_clear and is_support(slab) and not _overlaps(slab, [*closed, *outlines], tolerance):
            outlines.append(slab)
        elif is_clear and not is_support(slab) and heights.min() <= WIDEST_ERROR * line.length:
            supports = [curve for curve in other_curves if is_support(curve)]
            defects.add(_ground_defect(line, other_curves, supports))
        else:
            defects.add(line.defect)
    return outlines


def lines_warning(slabs: Sequence[Curve]) -> str:
    """Return a warning that names the lines that are read as supports, or an empty text if there are none.

    ``slabs`` are the outlines that :func:`support_outlines` returns. They begin with the ends of the lines.
    """
    if not slabs:
        return ""
    places = shortened([f"{slab.label}{near(*slab.points[0])}" for slab in slabs], _MOST_GROUND_LINES)
    read_as = (
        "straight line is read as the surface of a support"
        if len(slabs) == 1
        else "straight lines are read as surfaces of supports"
    )
    return (
        f"{len(slabs)} {read_as} ({'; '.join(places)}): move lines that are not surfaces, such as axes, to a "
        "separate layer, and omit that layer with 'without_layers' (--without-layer)"
    )


def _overlaps(slab: Curve, outlines: Sequence[Curve], tolerance: float) -> bool:
    """Return True if a slab overlaps one of several outlines by more than the tolerance."""
    polygon = shapely.Polygon(slab.points)
    polygons = [
        shapely.make_valid(shapely.Polygon(curve.points)) for curve in outlines if len(curve.points) > 2
    ]
    return bool((shapely.area(shapely.intersection(polygon, polygons)) > tolerance * polygon.length).any())


def _normal_towards_blocks(
    ends: np.ndarray, block_points: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit normal of a line towards the blocks, and the distance of each block corner to the line.

    The distance is negative if the normal points away from the corner.
    """
    direction = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
    normal = np.array([-direction[1], direction[0]])
    points = np.concatenate([*block_points, np.zeros((0, 2))])
    heights = (points - ends[0]) @ normal
    return (normal, heights) if heights.sum() >= 0 else (-normal, -heights)


def _ground_defect(line: OpenLine, other_curves: Sequence[Curve], supports: Sequence[Curve]) -> Defect:
    """Return the defect to report for a line that may be the ground, but is not on a layer of supports.

    ``other_curves`` are the curves of the drawing that are not part of a straight open line. ``supports`` are
    the curves among ``other_curves`` that are on layers of supports.
    """
    layer = line.curves[0].layer
    if any(dxf_layers.has_word(curve.layer, [layer]) for curve in other_curves):
        change = f"move it to a layer with '{SUPPORT_WORDS[0]}' in its name"
    else:
        # Setting `fixed_layers` replaces the words that mark layers of supports by default. The advice
        # therefore names the layers of all supports.
        layers = dict.fromkeys(curve.layer for curve in supports)
        options = " ".join(f"--fixed-layer {name}" for name in (*layers, layer))
        change = f"name its layer with 'fixed_layers' ({options})"
    remedy = f"if it is the ground, {change}, so that it becomes a support; if not, {line.defect.remedy}"
    mistake, plural_mistake = "is a straight line next to the blocks", "straight lines are next to the blocks"
    return Defect(line.curves[0].label, mistake, plural_mistake, remedy, near(*line.ends[0]))

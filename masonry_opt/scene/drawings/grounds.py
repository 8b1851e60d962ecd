"""Read a straight line on a layer of supports, such as a ground line, as the surface of a support."""

from collections.abc import Callable, Sequence

import numpy as np
import shapely

from masonry_opt.errors import shortened
from masonry_opt.scene.drawings import dxf_layers
from masonry_opt.scene.drawings.defects import Defect, Defects, near
from masonry_opt.scene.drawings.loops import WIDEST_ERROR, OpenLine
from masonry_opt.scene.drawings.outlines import Curve
from masonry_opt.scene.drawings.stones import SLAB_THICKNESS, SUPPORT_WORDS

#: Largest number of lines that one warning lists; further lines are only counted.
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
        Largest distance of a block from the wrong side of a line.
    defects : Defects
        Defects of the drawing.
    """
    handles = {curve.handle for line in lines for curve in line.curves}
    others = [curve for curve in curves if curve.handle not in handles]
    movable = [curve.points for curve in others if not is_support(curve)]
    outlines: list[Curve] = []
    for line in lines:
        normal, heights = _towards_blocks(line.ends, movable)
        is_clear = bool(len(heights)) and heights.min() >= -tolerance
        back = line.ends[::-1] - SLAB_THICKNESS * line.length * normal
        slab = line.curves[0]._replace(points=np.concatenate([line.ends, back]), closed=True)
        if is_clear and is_support(slab) and not _overlaps(slab, [*closed, *outlines], tolerance):
            outlines.append(slab)
        elif is_clear and not is_support(slab) and heights.min() <= WIDEST_ERROR * line.length:
            supports = [curve for curve in others if is_support(curve)]
            defects.add(_ground_defect(line, others, supports))
        else:
            defects.add(line.defect)
    return outlines


def lines_warning(slabs: Sequence[Curve]) -> str:
    """Return a warning that names the lines that are read as supports, or an empty text if there are none.

    ``slabs`` are the outlines that :func:`support_outlines` returns. They begin with the ends of the lines.
    """
    if not slabs:
        return ""
    places = shortened([f"{slab.where}{near(*slab.points[0])}" for slab in slabs], _MOST_GROUND_LINES)
    read_as = (
        "straight line is read as the surface of a support"
        if len(slabs) == 1
        else "straight lines are read as surfaces of supports"
    )
    return (
        f"{len(slabs)} {read_as} ({'; '.join(places)}): move other lines, such as axes, to a separate layer, "
        "and omit this layer with 'without_layers' (--without-layer)"
    )


def _overlaps(slab: Curve, outlines: Sequence[Curve], tolerance: float) -> bool:
    """Return True if a slab overlaps one of several outlines by more than the tolerance."""
    polygon = shapely.Polygon(slab.points)
    drawn = [shapely.make_valid(shapely.Polygon(curve.points)) for curve in outlines if len(curve.points) > 2]
    return bool((shapely.area(shapely.intersection(polygon, drawn)) > tolerance * polygon.length).any())


def _towards_blocks(ends: np.ndarray, movable: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit normal of a line towards the blocks, and the heights of their corners over the line."""
    along = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
    normal = np.array([-along[1], along[0]])
    points = np.concatenate([*movable, np.zeros((0, 2))])
    heights = (points - ends[0]) @ normal
    return (normal, heights) if heights.sum() >= 0 else (-normal, -heights)


def _ground_defect(line: OpenLine, others: Sequence[Curve], supports: Sequence[Curve]) -> Defect:
    """Return the defect of a line that may be the ground, but is not on a layer of supports.

    ``others`` are the other curves of the drawing, and ``supports`` those on layers of supports.
    """
    layer = line.curves[0].layer
    if any(dxf_layers.has_word(curve.layer, [layer]) for curve in others):
        change = f"move it to a layer with '{SUPPORT_WORDS[0]}' in its name"
    else:
        # The option `fixed_layers` replaces its default, so it must name the layers of all supports.
        layers = dict.fromkeys(curve.layer for curve in supports)
        options = " ".join(f"--fixed-layer {name}" for name in (*layers, layer))
        change = f"name its layer with 'fixed_layers' ({options})"
    remedy = f"if it is the ground, {change}, so that it becomes a support; if not, {line.defect.remedy}"
    mistake, several = "is a straight line next to the blocks", "straight lines are next to the blocks"
    return Defect(line.curves[0].where, mistake, several, remedy, near(*line.ends[0]))

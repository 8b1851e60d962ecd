"""A scene on axes: its blocks, supports and names, and the frame round them."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path as FilePath

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke

from masonry_opt.answer.result import Result
from masonry_opt.answer.status import Status
from masonry_opt.errors import printable
from masonry_opt.problem.assembly import Assembly
from masonry_opt.report.colours import AT_REST, BLOCK, FIXED, HATCH
from masonry_opt.scene.scene import Scene
from masonry_opt.words.sentences import numeral

#: What a legend shows of a thing drawn.
Handle = Line2D | Patch

#: Where a picture has points of a block that are given relative to the geometry's origin: (block, points),
#: shape (points, 2), to the case's coordinates.
Place = Callable[[int, np.ndarray], np.ndarray]

#: Share of the scene's size that is left free round the movable blocks.
MARGIN = 0.09

#: Points: largest and smallest letters of block names, the smallest where blocks are many; their width over
#: their height.
_NAME, _LEAST_NAME, _TINY_NAME, _LETTER = 8.0, 3.0, 1.0, 0.62

#: More blocks are many: their names can be read where a picture is enlarged.
_MANY = 200


def at_rest(assembly: Assembly) -> Place:
    """Blocks where they stand."""
    origin = assembly.geometry.origin
    return lambda _, points: points + origin


def extent(assembly: Assembly) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right of the movable blocks, in the case's coordinates."""
    corners = shapely.get_coordinates(assembly.geometry.polygons[assembly.movable])
    origin = assembly.geometry.origin
    return corners.min(axis=0) + origin, corners.max(axis=0) + origin


def size_of(assembly: Assembly) -> float:
    """The larger side of the box round the movable blocks."""
    low, high = extent(assembly)
    return float((high - low).max())


def frame(axes: Axes, assembly: Assembly) -> None:
    """Axes round the movable blocks, in equal scales; supports may reach beyond."""
    low, high = extent(assembly)
    margin = MARGIN * size_of(assembly)
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.set_xlabel("x, y in the length unit of the case")
    axes.set_ylabel("y")


def set_title(axes: Axes, scene: Scene, line: str) -> None:
    """A scene's title or the name of its file, wrapped, and a line below it."""
    title = scene.title or FilePath(scene.origin).stem
    # A title may hold dollar signs.
    axes.set_title(f"{printable(textwrap.fill(title, 60))}\n{line}", parse_math=False)


def title_result(axes: Axes, result: Result) -> None:
    """What was analysed, and its load factor or why there is none."""
    if result.load_factor is not None:
        line = f"load factor λ = {numeral(result.load_factor, '.5f')} ({result.method})"
        if result.tilt_angle is not None:
            line = f"falls when tilted by {numeral(result.tilt_angle, '.2f')}°: {line}"
    else:
        moves = result.solution.d is not None and result.status is not Status.UNSTABLE
        tried = "; drawn: the last motion tried, no collapse" if moves else ""
        line = f"no load factor ({result.status}){tried}"
    set_title(axes, result.assembly.scene, line)


def say_no_forces(axes: Axes) -> None:
    """Write over the blocks that there is nothing to draw on them."""
    axes.text(
        0.5,
        0.5,
        "no forces were found to draw",
        transform=axes.transAxes,
        ha="center",
        va="center",
        bbox={"facecolor": "white", "edgecolor": "black"},
        zorder=8,
    )


def draw_blocks(axes: Axes, assembly: Assembly, place: Place) -> list[Handle]:
    """Draw supports, hatched, and blocks."""
    fixed = np.setdiff1d(np.arange(len(assembly.scene.blocks)), assembly.movable)
    standing = at_rest(assembly)
    supports = [_outline(assembly, block, standing) for block in fixed]
    axes.add_collection(PathCollection(supports, facecolor=FIXED, edgecolor=HATCH, hatch="////", linewidth=0))
    blocks = [_outline(assembly, block, place) for block in assembly.movable]
    # Of many small blocks the outlines must not hide the rest.
    width = float(np.clip(15 / np.sqrt(len(blocks) or 1), 0.1, 0.8))
    axes.add_collection(PathCollection(blocks, facecolor=BLOCK, edgecolor="black", linewidth=width))
    return block_handles()


def block_handles() -> list[Handle]:
    """What a legend says of blocks."""
    return [
        Patch(facecolor=BLOCK, edgecolor="black", label="block"),
        Patch(facecolor=FIXED, edgecolor=HATCH, hatch="////", linewidth=0, label="support"),
    ]


def draw_at_rest(axes: Axes, assembly: Assembly) -> None:
    """Draw the outlines of the movable blocks where they stood."""
    standing = at_rest(assembly)
    outlines = [_outline(assembly, block, standing) for block in assembly.movable]
    axes.add_collection(PathCollection(outlines, facecolor="none", edgecolor=AT_REST, linewidth=0.5))


def draw_names(axes: Axes, assembly: Assembly, place: Place) -> None:
    """Write each block's name into it, as large as fits; the axes' size must be set."""
    polygons, scene = assembly.geometry.polygons, assembly.scene
    (left, bottom), (right, top) = axes.transData.inverted().transform(axes.bbox.corners())[[0, 3]]
    points_per_unit = 72 / axes.figure.dpi * axes.bbox.width / (right - left)
    least = _LEAST_NAME if len(scene.blocks) <= _MANY else _TINY_NAME
    for number, block in enumerate(scene.blocks):
        polygon = polygons[number]
        if block.fixed:  # of a support the part that is seen
            ox, oy = assembly.geometry.origin
            polygon = shapely.intersection(polygon, shapely.box(left - ox, bottom - oy, right - ox, top - oy))
            if polygon.is_empty:
                continue
        west, south, east, north = polygon.bounds
        middle = shapely.centroid(polygon)
        if not shapely.contains(polygon, middle):
            middle = shapely.point_on_surface(polygon)
        at = place(number, shapely.get_coordinates(middle))[0]
        wide, high = (east - west) * points_per_unit, (north - south) * points_per_unit
        fits = min(0.9 * wide / (_LETTER * len(block.name)), 0.45 * high, _NAME)
        letters = max(fits, least)
        # Just above the middle, from where arrows of loads start.
        name = axes.annotate(
            printable(block.name),
            at,
            xytext=(0, 1),
            textcoords="offset points",
            fontsize=letters,
            ha="center",
            va="bottom",
            zorder=7,
            clip_on=True,
            parse_math=False,
            in_layout=False,  # inside the axes; to find what room thousands take is slow
        )
        if len(scene.blocks) <= _MANY:
            name.set_path_effects([withStroke(linewidth=0.15 * letters, foreground="white")])


def _outline(assembly: Assembly, block: int, place: Place) -> Path:
    """The outlines of a block, its holes among them, as one path."""
    shape = assembly.geometry.polygons[block]
    rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(shape))]
    return Path.make_compound_path(*(Path(place(block, points), closed=True) for points in rings))

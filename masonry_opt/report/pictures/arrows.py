"""Arrows of the loads on a scene."""

from __future__ import annotations

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.edge_loads import LoadedPiece
from masonry_opt.problem.loads import Forces, loads
from masonry_opt.report.colours import DEAD, FURTHER_DEAD, LIVE
from masonry_opt.report.pictures.blocks import MARGIN, Handle, Place, extent, size_of

#: Up to so many blocks each weight has its arrow; of more, one shows where all act to.
_FEW = 30

#: Of more parallel live loads one shows where all act to.
_MANY = 200

#: Up to so many forces of a kind the longest arrow takes the margin round the scene; of more, this share of a
#: usual block.
_LONE, _OF_BLOCK = 8, 0.6

#: Arrows along an edge load's line, and the least space between them over their length.
_ALONG, _SPACE = 8, 0.3


def draw_loads(axes: Axes, assembly: Assembly, place: Place, live: bool = True) -> list[Handle]:
    """Draw weights, further dead loads and, if they act, live loads, each kind to a scale of its own."""
    given = loads(assembly.scene, assembly.geometry, assembly.movable)
    handles: list[Handle] = []
    if len(given.weight.force):
        if len(assembly.movable) <= _FEW:
            _draw_forces(axes, assembly, place, given.weight, DEAD, 0.012)
            handles.append(_handle(DEAD, "weight"))
        else:
            _draw_direction(axes, assembly, given.weight, DEAD)
            handles.append(_handle(DEAD, "direction of all weights"))
    # The live load last and thinner: it may lie on a dead load that it takes away from.
    for kind, forces, colour, width, label in (
        ("dead", given.dead, FURTHER_DEAD, 0.04, "further dead load"),
        ("live", given.live, LIVE, 0.02, "live load, times λ"),
    ):
        if kind == "live" and not live:
            continue
        pieces = [piece for piece in assembly.loaded_pieces if _kind(assembly, piece) == kind]
        if kind == "live" and _many_parallel(forces):
            _draw_direction(axes, assembly, forces, colour)
            handles.append(_handle(colour, "direction of live loads, times λ"))
        elif len(forces.force):
            _draw_forces(axes, assembly, place, forces, colour, width)
            handles.append(_handle(colour, label))
        if pieces:
            _draw_pieces(axes, assembly, place, pieces, colour)
            if not len(forces.force):
                handles.append(_handle(colour, label))
    return handles


def _many_parallel(forces: Forces) -> bool:
    """Whether they are too many to be told apart, and all of one direction."""
    if len(forces.force) <= _MANY:
        return False
    direction = forces.force / np.hypot(*forces.force.T)[:, None]
    return bool((np.abs(direction - direction[0]) < 1e-9).all())


def _kind(assembly: Assembly, piece: LoadedPiece) -> str:
    return assembly.scene.edge_loads[piece.load].kind


def _draw_forces(
    axes: Axes, assembly: Assembly, place: Place, forces: Forces, colour: str, width: float
) -> None:
    """From where they act; what pushes a block from outside, to there."""
    size, point, blocks = np.hypot(*forces.force.T), forces.point, assembly.movable[forces.block]
    polygons = assembly.geometry.polygons[blocks]
    longest = MARGIN * size_of(assembly)
    if len(size) > _LONE:
        longest = min(longest, _OF_BLOCK * float(np.sqrt(np.median(shapely.area(polygons)))))
    arrow = longest * forces.force / size.max()
    behind = point - 0.02 * longest * forces.force / size[:, None]
    from_outside = ~shapely.intersects(polygons, shapely.points(behind))
    at = [place(block, own[None])[0] for block, own in zip(blocks, point, strict=True)]
    tail = np.array(at) - np.where(from_outside[:, None], arrow, 0.0)
    _quiver(axes, tail, arrow, colour, width if len(size) <= 100 else 0.4 * width)


def _draw_pieces(
    axes: Axes, assembly: Assembly, place: Place, pieces: list[LoadedPiece], colour: str
) -> None:
    """A row of arrows on each piece, and a line along their ends."""
    longest = 0.8 * MARGIN * size_of(assembly)
    most = max(np.hypot(*piece.intensity.T).max() for piece in pieces)
    for piece in pieces:
        load = assembly.scene.edge_loads[piece.load]
        line = np.hypot(*(np.array(load.end) - load.start))
        length = np.hypot(*(piece.ends[1] - piece.ends[0]))
        count = max(1, min(round(_ALONG * length / line), int(length / (_SPACE * longest)))) + 1
        share = np.linspace(0, 1, count)[:, None]
        arrow = (1 - share) * piece.intensity[0] + share * piece.intensity[1]
        arrow *= longest / most
        tip = place(piece.block, (1 - share) * piece.ends[0] + share * piece.ends[1])
        # Into the edge, or out of it where it is pulled.
        behind = piece.ends.mean(axis=0) - 1e-3 * arrow.sum(axis=0)
        pulled = shapely.intersects(assembly.geometry.polygons[piece.block], shapely.Point(*behind))
        tail = tip if pulled else tip - arrow
        far = tip + arrow if pulled else tail
        axes.plot(*far.T, color=colour, linewidth=0.8, zorder=5)
        _quiver(axes, tail, arrow, colour, 0.012)


def _draw_direction(axes: Axes, assembly: Assembly, forces: Forces, colour: str) -> None:
    """One arrow in the upper right corner, above where blocks are displaced to."""
    _, high = extent(assembly)
    margin = MARGIN * size_of(assembly)
    total = forces.force.sum(axis=0)
    arrow = 0.8 * margin * total / np.hypot(*total)
    _quiver(axes, high[None] + [[0, 1.7 * margin]], arrow[None], colour, 0.03)


def _quiver(axes: Axes, tail: np.ndarray, arrow: np.ndarray, colour: str, width: float) -> None:
    # What acts from outside may reach beyond the margin.
    points = np.concatenate([tail, tail + arrow])
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    pad = 0.015 * max(x1 - x0, y1 - y0)
    (left, bottom), (right, top) = points.min(axis=0) - pad, points.max(axis=0) + pad
    axes.set_xlim(min(x0, left), max(x1, right))
    axes.set_ylim(min(y0, bottom), max(y1, top))
    axes.quiver(
        *tail.T,
        *arrow.T,
        angles="xy",
        scale_units="xy",
        scale=1,
        units="inches",
        width=width,
        headwidth=4.5,
        headlength=5,
        headaxislength=4.5,
        minlength=0.1,
        color=colour,
        zorder=5,
    )


def _handle(colour: str, label: str) -> Line2D:
    return Line2D([], [], color=colour, linestyle="none", marker=r"$\rightarrow$", markersize=14, label=label)

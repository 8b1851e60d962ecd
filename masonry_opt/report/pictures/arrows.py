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

#: Up to so many forces of a kind the longest arrow takes the margin round the scene; of more, this share of a
#: usual block.
_LONE, _OF_BLOCK = 8, 0.6

#: Arrows along an edge load's line.
_ALONG = 8


def draw_loads(axes: Axes, assembly: Assembly, place: Place) -> list[Handle]:
    """Draw weights, further dead loads and live loads, each kind to a scale of its own."""
    given = loads(assembly.scene, assembly.geometry, assembly.movable)
    handles: list[Handle] = []
    if given.weight.force.any():
        if len(assembly.movable) <= _FEW:
            _draw_forces(axes, assembly, place, given.weight, DEAD, 0.012)
            handles.append(_handle(DEAD, "weight"))
        else:
            _draw_gravity(axes, assembly)
            handles.append(_handle(DEAD, "direction of all weights"))
    # The live load last and thinner: it may lie on a dead load that it takes away from.
    for kind, forces, colour, width, label in (
        ("dead", given.dead, FURTHER_DEAD, 0.04, "further dead load"),
        ("live", given.live, LIVE, 0.02, "live load, times λ"),
    ):
        pieces = [piece for piece in assembly.loaded_pieces if _kind(assembly, piece) == kind]
        if forces.force.any():
            _draw_forces(axes, assembly, place, forces, colour, width)
        if pieces:
            _draw_pieces(axes, assembly, place, pieces, colour)
        if forces.force.any() or pieces:
            handles.append(_handle(colour, label))
    return handles


def _kind(assembly: Assembly, piece: LoadedPiece) -> str:
    return assembly.scene.edge_loads[piece.load].kind


def _draw_forces(
    axes: Axes, assembly: Assembly, place: Place, forces: Forces, colour: str, width: float
) -> None:
    """From where they act; what pushes a block from outside, to there."""
    size = np.hypot(*forces.force.T)
    acts = np.flatnonzero(size > 0)
    polygons = assembly.geometry.polygons[assembly.movable[acts]]
    longest = MARGIN * size_of(assembly)
    if len(acts) > _LONE:
        longest = min(longest, _OF_BLOCK * float(np.sqrt(np.median(shapely.area(polygons)))))
    arrow = longest * forces.force[acts] / size.max()
    point = forces.point[acts]
    behind = point - 0.02 * longest * forces.force[acts] / size[acts, None]
    from_outside = ~shapely.intersects(polygons, shapely.points(behind))
    at = [place(block, own[None])[0] for block, own in zip(assembly.movable[acts], point, strict=True)]
    tail = np.array(at) - np.where(from_outside[:, None], arrow, 0.0)
    _quiver(axes, tail, arrow, colour, width if len(acts) <= 100 else 0.4 * width)


def _draw_pieces(
    axes: Axes, assembly: Assembly, place: Place, pieces: list[LoadedPiece], colour: str
) -> None:
    """A row of arrows on each piece, and a line along their ends."""
    most = max(np.hypot(*piece.intensity.T).max() for piece in pieces)
    for piece in pieces:
        load = assembly.scene.edge_loads[piece.load]
        line = np.hypot(*(np.array(load.end) - load.start))
        count = max(2, round(_ALONG * float(np.hypot(*np.diff(piece.ends, axis=0)[0]) / line)) + 1)
        share = np.linspace(0, 1, count)[:, None]
        arrow = (1 - share) * piece.intensity[0] + share * piece.intensity[1]
        arrow *= 0.8 * MARGIN * size_of(assembly) / most
        tip = place(piece.block, (1 - share) * piece.ends[0] + share * piece.ends[1])
        # Into the edge, or out of it where it is pulled.
        behind = piece.ends.mean(axis=0) - 1e-3 * arrow.sum(axis=0)
        pulled = shapely.intersects(assembly.geometry.polygons[piece.block], shapely.Point(*behind))
        tail = tip if pulled else tip - arrow
        far = tip + arrow if pulled else tail
        axes.plot(*far.T, color=colour, linewidth=0.8, zorder=5)
        _quiver(axes, tail, arrow, colour, 0.012)


def _draw_gravity(axes: Axes, assembly: Assembly) -> None:
    """One arrow in the upper right corner, in the margin."""
    _, high = extent(assembly)
    margin = MARGIN * size_of(assembly)
    gravity = np.array(assembly.scene.gravity) / np.hypot(*assembly.scene.gravity)
    arrow = 0.8 * margin * gravity
    _quiver(axes, high[None] + margin / 2 - arrow / 2, arrow[None], DEAD, 0.03)


def _quiver(axes: Axes, tail: np.ndarray, arrow: np.ndarray, colour: str, width: float) -> None:
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

"""Loads as arrows."""

from __future__ import annotations

import numpy as np
import shapely

from masonry_opt.answer.result import Result
from masonry_opt.problem.loads import Forces, loads
from masonry_opt.report.colours import FURTHER_DEAD, LIVE
from masonry_opt.report.page.drawing import Pen, group, outline
from masonry_opt.report.page.view import SIDE

#: Forces up to which each has an arrow of its own; of more their resultant is drawn.
MOST_ARROWS = 300

#: Lengths of the longest arrow, as shares of the picture: least and greatest.
_SHORTEST, _LONGEST = 0.03, 0.09

#: The shortest arrow and its head, as shares of the longest.
_LEAST, _HEAD = 0.35, 0.22


def draw_loads(result: Result, pen: Pen) -> str:
    """Arrows of the live load, if it acts, and of dead loads beside the weights, from where they act."""
    assembly = result.assembly
    given = loads(assembly.scene, assembly.geometry, assembly.movable)
    drawn = ""
    kinds = [("dead", given.dead, FURTHER_DEAD)]
    if result.status.live_load_acts:
        kinds.append(("live", given.live, LIVE))
    for kind, forces, colour in kinds:
        paths = _arrows(result, forces, pen) + _edge_arrows(result, kind, pen)
        drawn += group(f"loads {kind}", paths, fill="none", stroke=colour, stroke_width=1.6)
    return drawn


def _arrows(result: Result, forces: Forces, pen: Pen) -> list[str]:
    assembly, view = result.assembly, pen.view
    size = np.hypot(*forces.force.T)
    if not len(size):
        return []
    if len(size) > MOST_ARROWS:
        tail = view.at(size / size.sum() @ forces.point)
        return [pen.path(_arrow(tail, forces.force.sum(axis=0), _LONGEST * SIDE))]
    blocks = assembly.movable[forces.block]
    of_block = float(np.sqrt(np.median(assembly.geometry.area[np.unique(blocks)]))) * view.scale
    longest = float(np.clip(0.8 * of_block, _SHORTEST * SIDE, _LONGEST * SIDE))
    drawn = []
    for block, point, force, own in zip(blocks, forces.point, forces.force, size, strict=True):
        along, length = force / own, longest * max(_LEAST, own / size.max())
        # What pushes a block from outside ends on it.
        behind = shapely.Point(*(point - 0.02 * length / view.scale * along))
        pushes = not shapely.intersects(assembly.geometry.polygons[block], behind)
        tail = view.at(point - (length / view.scale * along if pushes else 0.0))
        drawn.append(pen.path(_arrow(tail, along, length), view.motions[block]))
    return drawn


def _edge_arrows(result: Result, kind: str, pen: Pen) -> list[str]:
    """Of loads along edges: arrows that end on the edge, and the line of their tails."""
    assembly, view = result.assembly, pen.view
    listed = assembly.scene.edge_loads
    pieces = [piece for piece in assembly.loaded_pieces if listed[piece.load].kind == kind]
    most = max((np.hypot(*piece.intensity.T).max() for piece in pieces), default=0.0)
    drawn = []
    for piece in pieces:
        shares = np.linspace(0.0, 1.0, 4)[:, None]
        tips = view.at((1 - shares) * piece.ends[0] + shares * piece.ends[1])
        steps = (1 - shares) * piece.intensity[0] + shares * piece.intensity[1]
        steps = steps / most * _LONGEST * SIDE * [1, -1]
        tails = np.rint(tips - steps).astype(int)
        arrows = "".join(
            _arrow(tail, step * [1, -1], float(np.hypot(*step)))
            for tail, step in zip(tails, steps, strict=True)
            if np.hypot(*step) > 0
        )
        drawn.append(pen.path(arrows + outline(tails), view.motions[piece.block]))
    return drawn


def _arrow(tail: np.ndarray, direction: np.ndarray, length: float) -> str:
    """An arrow of the picture, along a direction of the scene, as ``d`` of a path."""
    size = np.hypot(*direction)
    if not size:
        return ""
    along = direction / size * [1, -1]
    tip, across = tail + length * along, np.array([-along[1], along[0]])
    head = _HEAD * length
    barbs = [tip - head * along + side * 0.5 * head * across for side in (1, -1)]
    points = np.rint([tail, tip, barbs[0], tip, barbs[1]]).astype(int)
    return outline(points)

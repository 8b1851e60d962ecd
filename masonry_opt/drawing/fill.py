"""Fill as lines: its road, its columns, and the edges that it touches."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from masonry_opt.drawing.colours import FILL
from masonry_opt.drawing.marks import Marks
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role

#: Space between the columns that are drawn, over the size of the scene.
_APART = 0.02

#: Length of the arrow of the largest pressure, over the size of the scene.
_LONGEST = 0.1


def fill_marks(assembly: Assembly, size: float, motion: np.ndarray) -> Iterable[Marks]:
    """Roads, which stay; and with the blocks that carry them columns of fill and the edges below.

    Parameters
    ----------
    size: of the scene.
    motion: what moves the scene's blocks, shape (blocks, 3).
    """
    pieces = assembly.filled_pieces
    if not pieces:
        return
    owner, ends = np.array([piece.block for piece in pieces]), np.array([piece.ends for piece in pieces])
    columns, below = [np.empty((0, 2, 2))], []
    for number, piece in enumerate(pieces):
        (right, left), apart = piece.ends[:, 0], _APART * size
        x = apart * np.arange(np.ceil(left / apart), right / apart)
        low, deep = (np.interp(x, [left, right], of[::-1]) for of in (piece.ends[:, 1], piece.depth))
        columns.append(np.stack([np.column_stack([x, low]), np.column_stack([x, low + deep])], axis=1))
        below += [owner[number]] * len(x)
    drawn = np.concatenate(columns)
    if len(drawn):
        yield Marks("fill", "fill", "line", FILL, 0.4, drawn, motion[below])
    yield Marks("filled", "edge that fill touches", "line", FILL, 1.8, ends, motion[owner])
    for fill in assembly.scene.fills:
        road = np.array(fill.road) - assembly.geometry.origin
        yield Marks("road", "road", "line", FILL, 1.2, np.stack([road[:-1], road[1:]], axis=1))


def pressure_marks(assembly: Assembly, size: float, force: np.ndarray) -> Iterable[Marks]:
    """What fill presses on each face that it touches, as arrows that end there.

    Parameters
    ----------
    size: of the scene.
    force: on each face, in the order of ``Result.pressures``.
    """
    if len(force) and (most := force.max()) > 0:
        acting = [each.actions[0] for each in assembly.limited if each.role is Role.EARTH]
        tip, along = (np.array([getattr(each, of) for each in acting]) for of in ("point", "force"))
        tail = tip - _LONGEST * size / most * force[:, None] * along
        label = f"pressure of fill on a face, {most:.3g} at most"
        yield Marks("earth", label, "arrow", FILL, 1.0, np.stack([tail, tip], axis=1))

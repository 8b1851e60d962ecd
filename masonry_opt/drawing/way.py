"""The way of a push on a page: λ over displacement, and at each keyframe where blocks are and what yields."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_opt.answer.motion import fastest, yielded_on
from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.solution import Way
from masonry_opt.drawing.colours import HINGES, SLIDES
from masonry_opt.drawing.elements import FULL, motion_of
from masonry_opt.drawing.marks import Marks, shrink_of, size_of
from masonry_opt.words.page import begins
from masonry_opt.words.sentences import numeral

#: What joints show along a push, and units of a rotation of one.
PUSH, _TURN = "push", 100_000


def way_of(result: Outcome) -> Way | None:
    """The way to the load to expect, if there is one."""
    state = result.solution.at_expected
    return state.way() if state is not None and state.load_factor is not None and state.way else None


def way_motions(result: Outcome, way: Way) -> np.ndarray:
    """Motions of the movable blocks at each keyframe, as ``moved`` takes them, shape (k, b, 3) or (k, b, 6):
    the last is as large as a mechanism that is fully moved."""
    assembly = result.assembly
    full = FULL * size_of(assembly) / fastest(assembly, way.d[-1])
    return np.stack([motion_of(assembly, full * d)[assembly.movable] for d in way.d])


def way_marks(result: Outcome) -> list[Marks]:
    """How joints are marked that have slid, and that have opened."""
    dimension, width = result.assembly.scene.dimension, 2.3 * shrink_of(result.assembly)
    dashes = (1.6, 1.1) if dimension == 2 else ()
    nowhere = np.empty((0, 2, dimension))
    return [
        Marks("slid", "has slid", "line", SLIDES, width, nowhere),
        Marks("open", "has opened", "line", HINGES, 0.7 * width, nowhere, dashes=dashes),
    ]


def way_data(result: Outcome, way: Way, motions: np.ndarray) -> dict[str, Any]:
    """What a page shows at each keyframe: λ, displacement of the live load, motions in the figure's units,
    joints that have slid and that have opened, and which began last."""
    assembly, moves = result.assembly, yielded_on(result.assembly, way)
    starts = moves & ~np.maximum.accumulate(np.concatenate([np.zeros_like(moves[:1]), moves[:-1]]))
    events = ["no joint has slid or opened yet"]
    for load, (slide, part) in zip(way.load_factor[1:], starts[1:], strict=True):
        new = begins(assembly.pairs_of(slide), assembly.pairs_of(part), load)
        events.append(new or events[-1])
    if result.end is not None:
        events[-1] = f"moves on at λ = {numeral(result.end, '.3g')}: collapse"
    along = way.displacement * assembly.problem.live_displacement
    u, loads = ([float(f"{value:.4g}") for value in of] for of in (along, way.load_factor))
    slid, opened = ([np.flatnonzero(joints).tolist() for joints in kind] for kind in moves.swapaxes(0, 1))
    # Lengths of the figure are whole; so, scaled, are rotations, which keeps large scenes short.
    scales = np.where(np.arange(motions.shape[-1]) < assembly.scene.dimension, 1, _TURN)
    return {
        "displacement": u,
        "load_factor": loads,
        "expected": result.expected,
        "blocks": assembly.movable.tolist(),
        "motions": np.rint(motions * scales).astype(int).reshape(len(motions), -1).tolist(),
        "scales": (1 / scales).tolist(),
        "marks": [[each.colour, each.width, each.dashes] for each in way_marks(result)],
        "joints": [slid, opened],
        "events": events,
    }

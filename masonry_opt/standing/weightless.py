"""Mechanisms of blocks that weigh nothing at a load factor below zero."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.thresholds import DRIVES, MOVES, ZERO
from masonry_opt.problem.problem import Problem


def weightless(problem: Problem, load_factor: float, d: np.ndarray) -> bool:
    """Whether the blocks that a mechanism (3b,) moves carry no load at a load factor below zero, as all those
    whose live load is along their weight do at some: any of them can move there, whatever carries them."""
    if load_factor >= -ZERO:
        return False
    speeds = np.abs(problem.by_block(d)).max(axis=1)
    dead, live = problem.by_block(problem.dead), load_factor * problem.by_block(problem.live)
    left, sizes = np.abs(dead + live).max(axis=1), np.abs(dead).max(axis=1) + np.abs(live).max(axis=1)
    moving = speeds > MOVES * speeds.max()
    return bool((left[moving] <= DRIVES * sizes[moving]).all())

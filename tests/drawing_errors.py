"""Copies of scenes with random coordinate errors of a known size, as in a survey."""

import numpy as np

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

#: Tolerance of a copy, divided by the error. Edges that touch are apart by at most twice the error.
TOLERANCE = 3.0


def with_errors(scene: mo.Scene, error: float, seed: int) -> mo.Scene:
    """Return a copy of the scene with a random error in every coordinate.

    The largest error is relative to the mean width of the movable blocks. The tolerance of the copy is three
    times the largest error.
    """
    rng = np.random.default_rng([seed, round(1e9 * error)])
    off = error * float(assemble(scene).geometry.width[~scene.fixed].mean())
    blocks = []
    for block in scene.blocks:
        corners = np.array(block.vertices, dtype=float)
        corners += off * rng.uniform(-1, 1, corners.shape)
        blocks.append(block.model_copy(update={"vertices": list(map(tuple, corners.tolist()))}))
    return mo.Scene(joints=scene.joints, blocks=blocks, tolerance=TOLERANCE * off)

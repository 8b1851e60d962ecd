"""Copies of scenes whose coordinates are off by a known error, as of a survey."""

import numpy as np

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

#: Tolerance over the error: two edges that meet are apart by twice the error at most.
TOLERANCE = 3.0


def with_errors(scene: mo.Scene, error: float, seed: int) -> mo.Scene:
    """Return a copy with every coordinate off by up to an error, relative to the mean size of a block.

    The tolerance of the copy is three times the error.
    """
    rng = np.random.default_rng([seed, round(1e9 * error)])
    off = error * float(assemble(scene).geometry.width[~scene.fixed].mean())
    blocks = []
    for block in scene.blocks:
        corners = np.array(block.vertices, dtype=float)
        corners += off * rng.uniform(-1, 1, corners.shape)
        blocks.append(block.model_copy(update={"vertices": list(map(tuple, corners.tolist()))}))
    return mo.Scene(joints=scene.joints, blocks=blocks, tolerance=TOLERANCE * off)

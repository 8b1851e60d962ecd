"""The incremental load factor of the push against the load steps, which raises the load by steps.

Both have the same definition and different algorithms: see :mod:`masonry_opt.methods.incremental`.
"""

import pytest
from atlas.random_scenes import random_scene

import masonry_opt as mo
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis
from masonry_opt.problem.assembly import assemble

#: Relative difference of the two programs. Load steps end with a bracket of 1e-3 if they find no exact state.
TOLERANCE = 3e-3

SCENES = {
    "two blocks": lambda: mo.load("cases/gilbert/two_blocks.toml"),
    "wall 3": lambda: mo.load("cases/ferris_tinloi/wall_3.toml"),
    **{f"{kind} {seed}": (kind, seed) for kind in ("wall", "arch", "stack") for seed in (1460000, 1460001)},
}


def scene_of(name: str) -> mo.Scene:
    made = SCENES[name]
    return made() if callable(made) else random_scene(*made)


@pytest.mark.parametrize("name", SCENES)
def test_push_and_load_steps_agree(name):
    scene = scene_of(name)
    by_push = mo.solve(scene, "incremental").incremental
    by_steps = IncrementalAnalysis(assemble(scene).problem).run().load_factor
    if by_steps is None:
        assert by_push is None
    else:
        assert by_push == pytest.approx(by_steps, rel=TOLERANCE)

"""Incremental load factors by load steps agree with those of another algorithm.

The other program followed the equilibrium path from rest to the motion in which the scene moves without
limit. Its load factors were computed before load steps replaced the program.
"""

import pytest
from atlas.random_scenes import random_scene
from scenes import CASES, WALLS

import masonry_opt as mo

#: Relative difference allowed between the two programs. Load steps without an exact state end with a range of
#: 1e-3.
TOLERANCE = 3e-3

#: Scenes and their load factors by the other program; None if the live load has no limit.
PUSHED = {
    "two blocks": (lambda: mo.load(CASES / "gilbert" / "two_blocks.toml"), 0.188439755691),
    "wall 3": (lambda: mo.load(WALLS[2]), 0.355817378498),
    "wall 1460000": (lambda: random_scene("wall", 1460000), 2.42681937571),
    "wall 1460001": (lambda: random_scene("wall", 1460001), 21.1136759997),
    "arch 1460000": (lambda: random_scene("arch", 1460000), 2.01051984093),
    "arch 1460001": (lambda: random_scene("arch", 1460001), 14.1412934199),
    "stack 1460000": (lambda: random_scene("stack", 1460000), 0.28657792727),
    "stack 1460001": (lambda: random_scene("stack", 1460001), None),
}


@pytest.mark.parametrize("name", PUSHED)
def test_load_factor_is_that_of_another_program(name):
    scene, load_factor = PUSHED[name]
    found = mo.solve(scene(), "incremental")
    if load_factor is None:
        assert found.status is mo.Status.UNLIMITED
        assert found.incremental is None
    else:
        assert found.incremental == pytest.approx(load_factor, rel=TOLERANCE)

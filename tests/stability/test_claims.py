"""The programs of ``claims`` on scenes whose answers are known by hand or published."""

from math import inf

import pytest
from claims import live_work, other_state, wrong_reactions
from scenes import block_on_floor, two_blocks

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble


@pytest.mark.parametrize(
    ("scene", "least"),
    [
        pytest.param(two_blocks(), 0.15, id="two blocks, Gilbert et al. (2006)"),
        pytest.param(block_on_floor(1.0, 2.0, 0.3), 0.3, id="slides at the friction"),
        pytest.param(block_on_floor(1.0, 2.0, 0.7), 0.5, id="rocks at width over height"),
    ],
)
def test_the_least_state_is_the_known_one(scene, least):
    assert other_state(assemble(scene)) == pytest.approx(least, rel=1e-4)


def test_no_state_lies_below_the_least():
    assert other_state(assemble(two_blocks()), below=0.149) is None


def pressed(friction: float) -> mo.Scene:
    """Return a block that its live load presses straight down onto the floor."""
    scene = block_on_floor(1.0, 2.0, friction)
    return scene.replace(blocks=[of if of.fixed else of.replace(live=(0.0, -1.0)) for of in scene.blocks])


@pytest.mark.parametrize("friction", [0.3, inf])
def test_a_load_into_the_floor_does_no_work(friction):
    assembly = assemble(pressed(friction))
    assert live_work(assembly) == 0.0
    assert other_state(assembly) is None


def test_the_reactions_of_a_floor_are_the_weight():
    assert wrong_reactions(block_on_floor(1.0, 2.0, 0.3), seed=0) == []

"""Tests of the programs of ``claims`` on scenes whose answers are known by hand or published."""

from math import inf

import pytest
from claims import live_work, other_state, refute_uniqueness, wrong_reactions
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


def prism_on_its_edge() -> mo.Scene:
    """Return a prism that rests on one edge.

    Its two contact points have six forces for six equations. Shears along the edge may oppose each other.
    """
    corners = [(x, y, z) for y in (0, 1) for x, z in ((0, 0), (0.5, 1), (-0.5, 1))]
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]
    prism = mo.Solid(name="prism", vertices=corners, faces=faces, unit_weight=1, live=(0, 1, 0))
    floor = mo.Solid(name="floor", box=((-2, 2), (-2, 2), (-1, 0)), fixed=True)
    return mo.Scene(blocks=[prism, floor], joints=mo.JointDefaults(friction=0.5))


def test_self_stress_along_an_edge_refutes_uniqueness():
    """The rank is 5. Each point carries half of the weight, so that its shear is at most 0.25 of the
    weight."""
    rank, range_ = refute_uniqueness(assemble(prism_on_its_edge()), 0.0)
    assert "rank 5 of 6" in rank
    assert float(range_.split()[-1]) == pytest.approx(0.5, rel=0.02)


def test_a_stack_has_unique_forces():
    """A block on the floor has three forces and three equations, so that its forces are unique."""
    assert refute_uniqueness(assemble(block_on_floor(1.0, 2.0, 0.3)), 0.1) == []


def test_the_reactions_of_a_floor_are_the_weight():
    assert wrong_reactions(block_on_floor(1.0, 2.0, 0.3), seed=0) == []

"""Tests of scenes that hang on ties alone, after a settlement, and under loads that ties cannot carry."""

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.scene.blocks import rectangle


def hanging_block(**keys: object) -> mo.Scene:
    """Return a scene: a block of 2 × 1 and weight 10 hangs on two vertical ties of length 3 and strength
    20."""
    ties = [mo.Tie(between=("block", "beam"), at=((x, 3.0), (x, 6.0)), strength=20.0) for x in (2.2, 3.8)]
    blocks = [
        mo.Block(name="beam", vertices=rectangle(0, 6, 6, 7), fixed=True),
        mo.Block(name="block", vertices=rectangle(2, 4, 2, 3), weight=10, **keys),
    ]
    return mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=blocks, ties=ties)


def test_a_block_on_ties_follows_its_support():
    """Ties keep their forces and lengths when the beam settles: each tie carries (10 + λ)/2 and yields at
    20."""
    result = mo.solve(hanging_block(live=(0, -1)), settled={"beam": (0, -0.1)})
    assert result.load_factor == pytest.approx(30, rel=1e-9)
    np.testing.assert_allclose(result.ties["force"], [20, 20], rtol=1e-9)
    at_rest = mo.solve(hanging_block(), settled={"beam": (0, -0.1)})
    assert at_rest.stability is not None
    np.testing.assert_allclose(at_rest.ties["force"], [5, 5], rtol=1e-9)


@pytest.mark.parametrize("method", ["coulomb", "incremental", "nonassociative"])
def test_a_push_across_vertical_ties_is_not_carried(method):
    """Vertical ties cannot carry a horizontal force: all methods find that the block swings at λ = 0."""
    result = mo.solve(hanging_block(live=(1, 0)), method)
    assert result.load_factor == pytest.approx(0, abs=1e-6)


def test_loads_at_the_edges_of_settled_blocks_give_no_warning():
    """A live load on the top of a block that has moved down by half its height still acts on the block."""
    scene = hanging_block(live=(0, -1), live_at=(3.0, 3.0))
    result = mo.solve(scene, settled={"beam": (0, -0.5)})
    assert not [warning for warning in result.warnings if warning.code == "acts outside"]

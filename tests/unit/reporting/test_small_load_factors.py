"""Load factors of zero, and load factors that are small because the live load is large, in printed texts."""

import pytest
from proofs import FOLDER
from scenes import block_on_floor, two_blocks

import masonry_opt as mo


def rectangle(name, left, right, bottom, top, **more):
    return mo.Block(name=name, vertices=[(left, bottom), (right, bottom), (right, top), (left, top)], **more)


def test_no_self_stress_explains_a_load_factor_that_equals_the_incremental_one():
    """A stone without weight begins to move as soon as its live load acts, so both load factors are zero."""
    push = {"live": (-1.0, 0.0)}
    blocks = [
        rectangle("lintel", 0, 3, 0, 0.5, weight=1.0, **push),
        rectangle("beam", 0, 3, 0.5, 1, weight=1.0, **push),
        rectangle("light", 0, 1, 1, 1.5, weight=0.0, **push),
        rectangle("stone", 1, 2, 1, 1.5, weight=1.0, **push),
        rectangle("left", 0, 0.5, -1, 0, fixed=True),
        rectangle("right", 2.5, 3, -1, 0, fixed=True),
    ]
    result = mo.solve(mo.Scene(joints={"friction": 0.6}, blocks=blocks))
    assert result.load_factor == pytest.approx(0.0, abs=1e-9)
    assert result.incremental == pytest.approx(0.0, abs=1e-9)
    assert "  lowest found   0 " in result.summary
    assert "self-stress" not in result.summary


@pytest.mark.parametrize("size", [1.0, 1e4, 1e7, 1e9])
def test_a_large_live_load_has_a_small_load_factor_and_not_zero(size):
    """A block of b = 1 and h = 2 overturns at λ F h/2 = W b/2, with W = 1 and the live force F."""
    result = mo.solve(block_on_floor(1.0, 2.0, live=(size, 0.0)), "static")
    assert result.load_factor == pytest.approx(0.5 / size, rel=1e-6)
    assert f"  associative    {0.5 / size:.6g} " in result.summary


@pytest.mark.parametrize("size", [1.0, 1e7])
def test_a_small_load_factor_is_proven_as_any_other(size):
    """The live force on block A is ``size`` times its weight, so that the least λ is 0.15 / ``size``."""
    scene = two_blocks().replace(blocks={"A": {"live": (size, 0.0)}})
    result = mo.solve(scene)
    assert result.proof is not None
    assert result.load_factor == pytest.approx(0.15 / size, rel=1e-6)
    assert f"  least, proven  {0.15 / size:.6g} " in result.summary
    assert mo.check_proof(scene, result.proof).holds


@pytest.mark.slow
@pytest.mark.parametrize("size", [1e6, 1e9])
def test_the_least_of_several_states_is_proven_at_any_size_of_the_live_load(size):
    """If the live load is multiplied by a number, all load factors are divided by it, and the texts agree."""
    scene = mo.load(FOLDER / "stones_14_joints.toml")
    larger = {b.name: {"live": tuple(size * force for force in b.live)} for b in scene.blocks if not b.fixed}
    small, result = mo.solve(scene), mo.solve(scene.replace(blocks=larger))
    assert small.proof is not None
    assert result.proof is not None
    assert result.load_factor == pytest.approx(small.load_factor / size, rel=1e-9)
    assert result.solution.exact_states == small.solution.exact_states
    assert f"  least, proven  {small.load_factor / size:.6g} " in result.summary

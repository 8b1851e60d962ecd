"""Metamorphic relations on one wall: what moves, turns, mirrors, rescales or renumbers it leaves λ as it is.

Of associative flow they are theorems (λ is the optimum of one linear program): asserted to the accuracy
of the solver. The loop is a heuristic: its λ depends on which of many optimal states a solver returns.
"""

import numpy as np
import pytest
from atlas.odd_stones import odd_scene
from mappings import SAME, mapped, same
from scenes import WALLS, small_wall, solved

import masonry_opt as mo
from masonry_opt.answer.reasons import Code

#: Programs solved to 1e-9, twice. Random scenes have sliver cells and light blocks, which cost digits.
EXACT, RANDOM = 1e-7, 1e-6
#: The loop's own tolerance is 1e-5 on λ, and rounding may choose another optimal state on the way.
LOOP = 5e-4

BASE, SMALL = small_wall(6, 4), small_wall(3, 2)


#: Kinematics find what statics do, on every case and kind of joint: see the tests of duality.
@pytest.mark.parametrize("name", SAME)
@pytest.mark.parametrize(
    ("scene", "method", "tolerance"),
    [
        (BASE, "static", EXACT),
        (odd_scene(1), "static", RANDOM),
        pytest.param(BASE, "nonassociative", LOOP, marks=pytest.mark.slow),
    ],
    ids=["wall", "odd stones", "loop"],
)
def test_load_factor_is_unmoved(scene, method, tolerance, name):
    same(solved(scene, method), solved(SAME[name](scene), method), tolerance)


#: Two pushes that differ by rounding.
SAME_WAY = 1e-8
#: The exact state below is on the same mechanism, whichever way the push went: 4e-15 apart on these walls.
DESCENDED = 1e-10


@pytest.mark.parametrize("name", SAME)
def test_the_default_is_unmoved(name):
    """Of many mechanisms that cost nothing rounding picks one on larger walls."""
    one, other = (solved(each) for each in (SMALL, SAME[name](SMALL)))
    for result in (one, other):
        assert result.exact
        assert [reason.code for reason in result.reasons] == [Code.STATES_MET]
    same(one, other, DESCENDED)


@pytest.mark.parametrize("path", [None, WALLS[0]], ids=["wall", "wall_1"])
def test_units_twice_as_large_change_no_bit(path):
    """Forces and lengths are measured in medians of the scene's own: powers of two change no digit."""
    scene = BASE if path is None else mo.load(path)
    larger = mapped(scene, lambda v: (1024 * v[0], 1024 * v[1]), dead=2.0, live=2.0, length=1024.0)
    one, other = (solved(each) for each in (scene, larger))
    assert other.load_factor == one.load_factor


def test_results_come_in_the_units_of_the_case():
    metres, millimetres = solved(BASE, "static"), solved(SAME["in millimetres"](BASE), "static")
    np.testing.assert_allclose(millimetres.joints["length"], 1e3 * metres.joints["length"])
    np.testing.assert_allclose(millimetres.joints["n"], metres.joints["n"], atol=1e-6)
    np.testing.assert_allclose(millimetres.joints["m"], 1e3 * metres.joints["m"], atol=1e-3)
    newtons = solved(SAME["in newtons"](BASE), "static")
    np.testing.assert_allclose(newtons.joints["n"], 2.3e4 * metres.joints["n"], atol=1e-2)


@pytest.mark.parametrize("factor", [1e-12, 1e12])
@pytest.mark.parametrize(
    ("method", "tolerance"),
    [("static", EXACT), ("kinematic", EXACT), ("nonassociative", LOOP), ("mcp", SAME_WAY)],
)
def test_scaling_the_live_load_divides_the_load_factor(factor, method, tolerance):
    wall = small_wall(3, 2)
    expected = solved(wall, method).load_factor / factor
    result = solved(mapped(wall, live=factor), method)
    assert result.load_factor == pytest.approx(expected, rel=tolerance, abs=0)
    if method == "mcp":
        assert result.method == "mcp"
        assert result.status is mo.Status.CONVERGED

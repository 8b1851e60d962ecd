"""Tests that λ does not change if a scene is moved, turned, mirrored, scaled or renumbered.

For associative flow this is a theorem (λ is the optimum of one program), asserted to the accuracy of the
solver. It also holds for elastic contacts, whose forces are unique. The sides of their friction polygons
start from the longest side of each joint, and turn with it. The loop is a heuristic: its λ depends on which
of many optimal states a solver returns.
"""

import numpy as np
import pytest
from atlas.odd_stones import odd_scene
from mappings import SAME, mapped, same
from scenes import WALLS, small_wall, solved
from scenes_in_space import corner_wall, pushed_box
from space import mappings_in_space
from speeds import slow

import masonry_opt as mo
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Code

#: Relative tolerances of two programs solved to 1e-9. Random scenes have thin cells and light blocks, which
#: cost digits.
EXACT = 1e-7
RANDOM = 1e-6
#: The tolerance of the loop is 1e-5 on λ, and rounding may lead to another optimal state on the way.
LOOP = 5e-4

BASE = small_wall(6, 4)
SMALL = small_wall(3, 2)


#: Kinematics have the same load factors as statics for every case and kind of joint: see the tests of
#: duality.
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


#: Relative tolerance of two load histories that differ by rounding.
SAME_WAY = 1e-8
#: Relative tolerance of the exact state after a descent. It has the same mechanism whatever the load history:
#: on these walls the load factors differ by 4e-15.
DESCENDED = 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("name", SAME)
def test_the_default_is_unmoved(name):
    """The default's exact state is the same on a small wall.

    On larger walls, rounding decides between several mechanisms of equal λ.
    """
    one, other = (solved(each) for each in (SMALL, SAME[name](SMALL)))
    for result in (one, other):
        assert result.exact
        assert [reason.code for reason in result.reasons] == [Code.STATES_MET]
    same(one, other, DESCENDED)


#: A corner of two walls. The default finds several exact states, below the associative load factor.
CORNER = corner_wall(2, 2, 3)
#: A smaller corner, whose load history is short. Its joints in `SPACE` have cohesion.
SMALL_CORNER = corner_wall(1, 1, 2)
SPACE = {
    "box": pushed_box((1.0, 2.0, 3.0), 0.3, 20.0),
    "corner": SMALL_CORNER.replace(joints={"friction": 0.5, "cohesion": 0.02}),
    "corner of 20": corner_wall(3, 2, 4, 0.4),
}


#: Changes of the box. One of them turns, mirrors and moves it at once; the corners do so one by one too.
OF_THE_BOX = ("turned, mirrored and moved", "in other units", "renumbered", "faces in pieces")


@pytest.mark.parametrize(
    ("scene", "name"),
    [
        *(("box", name) for name in OF_THE_BOX),
        *(
            ("corner", name) if name in OF_THE_BOX else pytest.param("corner", name, marks=pytest.mark.slow)
            for name in mappings_in_space.SAME
        ),
        *(pytest.param("corner of 20", name, marks=pytest.mark.slow) for name in mappings_in_space.SAME),
    ],
)
def test_load_factors_in_space_are_unmoved(scene, name):
    """Two static programs are solved to 1e-9, and two load histories to a gap of 1e-9."""
    one, other = SPACE[scene], mappings_in_space.SAME[name](SPACE[scene])
    for method, tolerance in (("static", EXACT), ("incremental", 1e-6)):
        first, second = solved(one, method), solved(other, method)
        assert second.load_factor == pytest.approx(first.load_factor, rel=tolerance)
        assert max(first.certificate.worst, second.certificate.worst) < 1e-7


@pytest.mark.slow
def test_the_default_in_space_is_certified_all_the_same():
    """The default ends in one of many exact states, and rounding may lead to another: it is certified in
    any case."""
    result = solved(mappings_in_space.SAME["turned"](CORNER))
    assert max(entry.exact_states for entry in result.solution.log) > 1
    assert not result.solution.answer.failing(Kind.EXACT)
    # The margin shows that the flow rule matters on this corner.
    assert result.load_factor < 0.9 * solved(CORNER, "static").load_factor


@pytest.mark.parametrize(
    ("scene", "method"),
    [(BASE, "coulomb"), (mo.load(WALLS[0]), "coulomb"), (mappings_in_space.mapped(CORNER), "static")],
    ids=["wall", "wall_1", "space"],
)
def test_units_twice_as_large_change_no_bit(scene, method):
    """Lengths that are 1024 times and forces that are twice as large do not change a bit of λ.

    The package measures both in medians of the scene, and powers of two change no digit.
    """
    if scene.dimension == 3:
        larger = mappings_in_space.mapped(scene, length=1024.0, force=2.0)
    else:
        larger = mapped(scene, lambda v: (1024 * v[0], 1024 * v[1]), dead=2.0, live=2.0, length=1024.0)
    assert solved(larger, method).load_factor == solved(scene, method).load_factor


def test_results_come_in_the_units_of_the_case():
    metres, millimetres = solved(BASE, "static"), solved(SAME["in millimetres"](BASE), "static")
    np.testing.assert_allclose(millimetres.joints["length"], 1e3 * metres.joints["length"])
    np.testing.assert_allclose(millimetres.joints["n"], metres.joints["n"], atol=1e-6)
    np.testing.assert_allclose(millimetres.joints["m"], 1e3 * metres.joints["m"], atol=1e-3)
    newtons = solved(SAME["in newtons"](BASE), "static")
    np.testing.assert_allclose(newtons.joints["n"], 2.3e4 * metres.joints["n"], atol=1e-2)


@pytest.mark.parametrize("factor", [1e-12, *slow(1e12)])
@pytest.mark.parametrize(
    ("method", "tolerance"),
    [("static", EXACT), ("kinematic", EXACT), ("nonassociative", LOOP), ("coulomb", SAME_WAY)],
)
def test_scaling_the_live_load_divides_the_load_factor(factor, method, tolerance):
    wall = small_wall(2, 1)
    expected = solved(wall, method).load_factor / factor
    result = solved(mapped(wall, live=factor), method)
    assert result.load_factor == pytest.approx(expected, rel=tolerance, abs=0)
    if method == "coulomb":
        assert result.method == "coulomb"
        assert result.status is mo.Status.CONVERGED

"""Metamorphic relations in space: what moves, turns, mirrors, rescales or renumbers a scene, or cuts faces in
pieces, leaves its load factors as they are.

Of associative flow they are theorems. Of contacts that give too, whose forces are unique: the sides of
polygons are set out from each joint's longest side and turn with it. The default ends in one exact state of
many, and rounding may choose another: what is certified of it is asserted, and that it is no more than the
associative.
"""

import pytest
from scenes import solved
from scenes_in_space import corner_wall, pushed_box
from space.mappings_in_space import SAME, mapped

import masonry_opt as mo
from masonry_opt.answer.acceptance import Kind

#: Programs solved to 1e-9, twice; a pass to a gap of 1e-9, twice.
ASSOCIATIVE, EXPECTED = 1e-7, 1e-6

#: Joints without cohesion, and with.
SCENES = {"box": pushed_box((1.0, 2.0, 3.0), 0.3, 20.0), "corner": corner_wall(2, 2, 3)}
SCENES["cohesion"] = SCENES["corner"].model_copy(
    update={"joints": mo.JointDefaults(friction=0.5, cohesion=0.02)}
)
LARGER = {"corner of 20": corner_wall(3, 2, 4, 0.4)}


@pytest.mark.parametrize("name", SAME)
@pytest.mark.parametrize(
    "scene", ["box", "cohesion", *(pytest.param(larger, marks=pytest.mark.slow) for larger in LARGER)]
)
def test_load_factors_are_unmoved(scene, name):
    one = (SCENES | LARGER)[scene]
    other = SAME[name](one)
    for method, tolerance in (("static", ASSOCIATIVE), ("compliant", EXPECTED)):
        first, second = solved(one, method), solved(other, method)
        assert second.load_factor == pytest.approx(first.load_factor, rel=tolerance)
        assert first.certificate.worst < 1e-7
        assert second.certificate.worst < 1e-7


def test_the_default_is_certified_all_the_same():
    result = solved(SAME["turned"](SCENES["corner"]))
    assert not result.solution.answer.failing(Kind.EXACT)
    assert result.load_factor < solved(SCENES["corner"], "static").load_factor * (1 + ASSOCIATIVE)


def test_units_twice_as_large_change_no_bit():
    """Forces and lengths are measured in medians of the scene's own: powers of two change no digit."""
    wall = SCENES["corner"]
    larger = mapped(wall, length=1024.0, force=2.0)
    assert solved(larger, "static").load_factor == solved(mapped(wall), "static").load_factor

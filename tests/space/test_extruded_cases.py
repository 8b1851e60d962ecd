"""Extruded case files have the load factors of the plane: associative ones by cones, and the loop's."""

import pytest
from scenes import CASES, solved
from speeds import slow, slow_after

import masonry_opt as mo

#: Small cases: a wedge, a dam, an arch on columns, a wall, two blocks, and an overhanging stack.
SMALL = [
    "beer_johnston/wedge_lowers",
    "closed_forms/dam_slides",
    "examples/segmental_arch_on_columns",
    "ferris_tinloi/wall_1",
    "gilbert/two_blocks",
    "paterson_zwick/best_3",
]

#: Thickness of extruded scenes. The totals of weight, load and cohesion do not depend on the thickness.
THICKNESS = 0.7


def path(name: str):
    return CASES / f"{name}.toml"


@pytest.mark.parametrize(
    "name", [*slow_after(3, SMALL), *slow("casapulla_lauro/arch", "orduna_lourenco/wall")]
)
def test_associative_load_factor_is_that_of_the_plane(name):
    """The associative load factor of an extruded case is that of the plane, to 1e-7.

    The mechanism of the plane is a mechanism in space, and half of its joint forces act on each face.
    """
    found = mo.solve(mo.extrude(path(name), THICKNESS), "static")
    assert found.load_factor == pytest.approx(solved(path(name), "static").load_factor, rel=1e-7)


@pytest.mark.parametrize(
    "name",
    ["closed_forms/dam_slides", "gilbert/two_blocks", *slow("livesley/wedges", "ferris_tinloi/wall_2")],
)
def test_the_loop_where_it_ends_is_near_that_of_the_plane(name):
    """The load factor of the loop is that of the plane to 0.5 %, or a reason says why there is none."""
    found = mo.solve(mo.extrude(path(name), THICKNESS), "nonassociative")
    if found.load_factor is None:
        assert found.reasons
    else:
        plane = solved(path(name), "nonassociative")
        assert found.load_factor == pytest.approx(plane.load_factor, rel=5e-3)

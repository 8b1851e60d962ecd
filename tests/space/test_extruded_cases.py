"""Case files of the plane, extruded: load factors by cones, exact states lifted, the loop."""

import pytest
from scenes import CASES, solved

import masonry_opt as mo

#: Arches, wedges, slopes, stacks, two blocks.
SMALL = [
    "beer_johnston/wedge_lowers",
    "closed_forms/dam_slides",
    "examples/segmental_arch_on_columns",
    "ferris_tinloi/wall_1",
    "gilbert/two_blocks",
    "paterson_zwick/best_3",
]

#: Whatever the thickness, totals of weight, load and cohesion are the plane's.
THICKNESS = 0.7


def slow(*names: str) -> list[object]:
    return [pytest.param(name, marks=pytest.mark.slow) for name in names]


def path(name: str):
    return CASES / f"{name}.toml"


@pytest.mark.parametrize("name", [*SMALL, *slow("casapulla_lauro/arch", "orduna_lourenco/wall")])
def test_associative_load_factor_is_that_of_the_plane(name):
    """Nothing moves out of the plane: the plane's mechanism is one of space, and its forces are, halved."""
    found = mo.solve(mo.extrude(path(name), THICKNESS), "static")
    assert found.load_factor == pytest.approx(solved(path(name), "static").load_factor, rel=1e-7)


@pytest.mark.parametrize(
    "name",
    ["closed_forms/dam_slides", "gilbert/two_blocks", *slow("livesley/wedges", "ferris_tinloi/wall_2")],
)
def test_the_loop_where_it_ends_is_near_that_of_the_plane(name):
    """Within .5 %; where its second program has no state it says so, and no load factor is given."""
    found = mo.solve(mo.extrude(path(name), THICKNESS), "nonassociative")
    if found.load_factor is None:
        assert found.reasons
    else:
        plane = solved(path(name), "nonassociative")
        assert found.load_factor == pytest.approx(plane.load_factor, rel=5e-3)

"""What the load to expect owes to self-stress and to how stiff contacts are."""

import pytest
from scenes import CASES, WALLS, values_of

import masonry_opt as mo
from masonry_opt.answer.reasons import Code
from masonry_opt.errors import OptionError


def spread(case, draws):
    return values_of(mo.solve(case, "compliant", spread=draws), Code.SPREAD)


def test_two_blocks_bear_any_load_of_their_continuum_by_self_stress():
    """Exact states are at every λ from .15 to the associative .25 (Gilbert et al. 2006)."""
    found = spread(CASES / "gilbert" / "two_blocks.toml", 30)
    least, most = found["stress"]
    assert 0.15 - 1e-6 <= least < 0.16
    assert 0.24 < most <= 0.25 + 1e-6
    # From rest .1884 with contacts that are alike.
    assert least < found["stiffness"][0] < 0.1884 < found["stiffness"][1] < most
    assert found["without"] == 0


@pytest.mark.slow
@pytest.mark.parametrize(("number", "least", "most"), [(1, 0.6391, 0.6430), (5, 0.2100, 0.2297)])
def test_ranges_of_walls_are_those_of_an_independent_program(number, least, most):
    """60 draws of self-stress led it to .6410 to .6429, and .2104 to .2296, or to a state that is lower."""
    found = spread(WALLS[number - 1], 20)
    for low, high in (found["stress"], found["stiffness"]):
        assert least <= low <= high <= most
    assert found["stress"][1] - found["stress"][0] > 1e-3


def test_a_spread_is_of_loads_to_expect():
    with pytest.raises(OptionError, match="give"):
        mo.solve(CASES / "gilbert" / "two_blocks.toml", "compliant", spread=2, give=1e-3)

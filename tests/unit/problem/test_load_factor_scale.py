"""Load factors are equal, lower or zero relative to the unit of their scale."""

from dataclasses import replace

import pytest
from scenes import two_blocks

from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.load_factor_scale import (
    EQUALITY_TOLERANCE,
    RELATIVE_ROUNDING,
    ZERO,
    LoadFactorScale,
)


@pytest.mark.parametrize("unit", [1.0, 1e-6])
@pytest.mark.parametrize("size", [0.0, 1e-3, 1.0, 1e3])
def test_differences_are_relative_from_a_hundredth_of_the_unit_on(size, unit):
    """Both `equal` and the stricter `is_lower` divide by λ, or by 0.01 units if λ is smaller.

    EQUALITY_TOLERANCE is below 1e-3, because the loop's state of wall 1 is 1e-3 above the default's.
    """
    scale, load_factor = LoadFactorScale(unit), size * unit
    divisor = max(size, 0.01) * unit
    near, far = (load_factor + share * EQUALITY_TOLERANCE * divisor for share in (0.9, 1.1))
    assert EQUALITY_TOLERANCE < 1e-3
    assert scale.equal(load_factor, near)
    assert scale.equal(near, load_factor)
    assert not scale.equal(load_factor, far)
    higher = [load_factor + share * RELATIVE_ROUNDING * divisor for share in (-1.1, 0.9, 1.1)]
    assert [scale.is_lower(load_factor, than) for than in higher] == [False, False, True]


@pytest.mark.parametrize(("live", "unit"), [(1e-3, 1.0), (1.0, 1.0), (1e3, 1e-3), (1e6, 1e-6)])
def test_the_unit_falls_as_the_live_load_grows_beyond_the_dead_load(live, unit):
    problem = assemble(two_blocks()).problem
    dead = problem.force_sizes(problem.dead).sum()
    loaded = replace(problem, live=problem.live * (live * dead / problem.live_norm))
    assert loaded.load_factor_scale.unit == pytest.approx(unit)
    assert loaded.load_factor_scale.zero == pytest.approx(ZERO * unit)
    unloaded = replace(problem, live=0 * problem.live)
    assert unloaded.load_factor_scale == LoadFactorScale(1.0)

"""Exact collapse states below λ = 0 are not reported as the load factor of a scene that is stable.

Such states exist for two reasons. If the live load acts along the weight, blocks have no net load at λ = -1,
so any mechanism is exact there. Other states have a self-stress that the scene does not have from rest.
"""

import re
from math import inf
from types import SimpleNamespace

import pytest
from atlas.random_scenes import random_scene
from contact_dynamics import QUICK, FallsUnderItsWeight, collapse_load
from scenes import values_of

import masonry_opt as mo
from masonry_opt.methods.exact.search import StateRecord, lower_of
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.reporting.load_factors import certainty, load_factor_lines
from masonry_opt.solution.reasons import Code


@pytest.mark.parametrize("method", ["coulomb", "incremental"])
def test_what_stands_and_jams_is_not_called_unstable(method):
    """An arch on fixed abutments whose live load is its weight carries any load and is not unstable."""
    built = {"span": 3, "rise": 1, "thickness": 0.3, "voussoirs": 7, "skewbacks": 0.3}
    ring = mo.Arch(unit_weight=20, live_per_weight=(0, -1), **built)
    result = mo.solve(mo.Scene(joints={"friction": 0.7}, blocks=ring.blocks()), method)
    assert (result.status, result.load_factor) == (mo.Status.UNLIMITED, None)
    assert result.solution.proven_none


def near_the_least_friction(kind: str, seed: int, friction: float) -> mo.Scene:
    """Return a random scene whose friction is slightly above the least friction of its static program."""
    return random_scene(kind, seed).model_copy(update={"joints": mo.JointDefaults(friction=friction)})


#: An arch with an exact state at λ = -0.1123, and further exact states at and above zero.
ARCH = near_the_least_friction("arch", 600032, 0.26197)


@pytest.mark.parametrize(
    "method", ["coulomb", *(pytest.param(method, marks=pytest.mark.slow) for method in ("global",))]
)
def test_a_state_below_zero_is_told_beside_the_load_at_which_a_scene_that_rests_collapses(method):
    """The load factor is the associative one, and a reason reports the state below zero.

    The MPEC ends in the state below zero, so its value is the reference, to 1e-6.
    """
    below = values_of(mo.solve(ARCH, "mpec", incremental=False), Code.BELOW_ZERO)["load_factor"]
    result = mo.solve(ARCH, method)
    assert result.usable
    assert result.exact
    assert result.load_factor == pytest.approx(result.associative, rel=1e-6)
    assert result.incremental == pytest.approx(result.associative, rel=1e-4)
    assert values_of(result, Code.BELOW_ZERO)["load_factor"] == pytest.approx(below, rel=1e-6)
    assert below < -0.1
    assert f"an exact state has λ = {below:.4g}" in certainty(result)
    assert "with the joint forces of this state the scene would fall without live load" in result.summary


def test_a_state_without_load_gives_way_to_one_above_and_is_told():
    """A state at λ ≈ 0 is reported as below zero, and the state at 0.099 remains the lowest.

    The values 1.4e-9 and 0.099 stand for a block in space that turns about the edge on which it rests.
    """
    scale = LoadFactorScale()
    none, above = (SimpleNamespace(load_factor=found, exact=False) for found in (1.4e-9, 0.099))
    assert lower_of(none, above, scale) is lower_of(above, none, scale) is above
    met = StateRecord(scale)
    for state in (above, none):
        met.count(state)
        met.lowest = min(met.lowest, state.load_factor)
    states, below = met.reasons
    assert (states.values["least"], states.values["count"]) == (0.099, 1)
    assert (below.code, below.values["load_factor"]) == (Code.BELOW_ZERO, 1.4e-9)


@pytest.mark.slow
def test_a_state_below_zero_alone_is_no_load_factor_of_a_scene_that_rests():
    """A stable scene whose only exact state is below zero has no load factor.

    In contact dynamics the scene carries at least half of the associative load factor.
    """
    scene = near_the_least_friction("tessellation", 600015, 0.22651)
    result = mo.solve(scene)
    assert (result.status, result.load_factor) == (mo.Status.BELOW_ZERO, None)
    assert values_of(result, Code.BELOW_ZERO)["load_factor"] < 0
    assert re.search(rf"^  associative +{result.associative:.6g} ", result.summary, re.MULTILINE)
    assert Code.BELOW_ZERO in [said.code for said in result.incremental_reasons]
    assert collapse_load(result.assembly.scene, result.associative / 2, QUICK) == inf


@pytest.mark.slow
def test_what_does_not_rest_is_unstable_with_one_explanation():
    """A scene that falls under its weight in contact dynamics is unstable, with the single reason "wedged".

    The static program finds equilibrium by self-stress.
    """
    result = mo.solve(near_the_least_friction("tessellation", 600002, 0.39672))
    assert (result.status, result.load_factor, result.incremental) == (mo.Status.UNSTABLE, None, None)
    assert [said.code for said in result.reasons] == [Code.WEDGED]
    assert load_factor_lines(result) == ()
    with pytest.raises(FallsUnderItsWeight):
        collapse_load(result.assembly.scene, 1.0, QUICK)

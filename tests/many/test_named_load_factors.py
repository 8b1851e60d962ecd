"""Tests that every study names the load factors that it prints, and says whether they are proven least."""

import pytest
from scenes import axles_on_a_beam, block_on_floor, two_blocks

import masonry_opt as mo
from masonry_opt.studies.many.sweep import summary_text

NOT_PROVEN = "lowest found (exact collapse states that are not proven to have the least load factors)"
UPPER_BOUND = "associative (upper bounds, by classical limit analysis)"
PROVEN = "least, proven (exact collapse states, proven to have the least load factors)"
METHODS = [("coulomb", PROVEN), ("static", UPPER_BOUND)]

#: Remark on a reaction if other exact states may have a reaction closer to the reaction at rest.
MAY_BE_NEARER = (
    "this reaction is not proven to be the limit: other exact states may have a reaction closer to the "
    "reaction at rest"
)


@pytest.mark.parametrize(("method", "words"), METHODS)
def test_a_sweep(method, words):
    frame = mo.sweep(two_blocks(), {"joints.friction": [0.3, 0.5]}, method=method, workers=1)
    assert f"λ is {words}" in summary_text(frame, ["joints.friction"]).splitlines()
    assert set(frame["which"]) == {words.split(" (")[0]}


def test_a_sweep_without_proofs():
    """Without descent the answer is the first exact state, and nothing is proven."""
    frame = mo.sweep(two_blocks(), {"joints.friction": [0.3, 0.5]}, workers=1, descent=False)
    assert f"λ is {NOT_PROVEN}" in summary_text(frame, ["joints.friction"]).splitlines()


@pytest.mark.parametrize(("method", "words"), METHODS)
def test_a_sample(method, words):
    drawn = {"joints.friction": ("uniform", 0.3, 0.5)}
    found = mo.sample(two_blocks(), drawn, n=2, method=method, workers=1)
    assert found.facts()["λ is"] == words
    for kind in ("fragility", "sensitivity"):
        datasets = found.drawing(kind).chart.to_dict()["datasets"].values()
        assert {row["of"] for rows in datasets for row in rows} - {"incremental"} == {words.split(" (")[0]}


@pytest.mark.parametrize(("method", "words"), [("coulomb", PROVEN), ("static", UPPER_BOUND)])
def test_a_threshold(method, words):
    """The least friction that carries a load of 0.3 is 0.3, and equilibrium alone fixes the forces of the
    block."""
    found = mo.least(lambda friction: block_on_floor(friction=friction), 0.1, 0.4, load=0.3, method=method)
    assert found.value == pytest.approx(0.3, rel=1e-5)
    assert found.facts()["λ is"] == words


def test_a_threshold_under_dead_load_is_no_load_factor():
    found = mo.least(lambda friction: block_on_floor(dead=(0.3, 0.0), friction=friction), 0.1, 0.4)
    assert "λ is" not in found.facts()


@pytest.mark.slow
@pytest.mark.parametrize(("method", "name"), [("coulomb", "lowest found"), ("static", "associative")])
def test_a_crossing(no_proof, method, name):
    facts = mo.crossing(axles_on_a_beam(0.6), method=method).facts()
    assert facts["governing λ"].endswith(f"({name})")
    assert "not proven to be the least" in facts["certainty"]
    assert facts["certainty"].startswith("upper bound") == (method == "static")


@pytest.mark.slow
@pytest.mark.parametrize(("method", "name"), [("coulomb", "least, proven"), ("static", "associative")])
def test_a_capacity_curve(method, name):
    facts = mo.capacity(mo.solve(block_on_floor(), method)).facts()
    assert facts["load factor"].endswith(f"at the onset of collapse ({name})")
    assert facts["certainty"].startswith("upper bound") == (method == "static")


@pytest.mark.slow
def test_reactions_of_a_support_that_settles():
    """Neither Coulomb reaction is called proven. Associative reactions are proven to be the farthest from
    rest."""
    found = mo.settle(block_on_floor(), "floor", (0, -1))
    for end in ("least", "greatest"):
        if found.ends[end].result.load_factor is not None:
            assert MAY_BE_NEARER in found.facts()[end]
            assert "(found, not proven)" in found.facts()[end].splitlines()[0]
    by_statics = mo.settle(block_on_floor(), "floor", (0, -1), method="static")
    furthest = "in this direction of movement, no state has a reaction farther from the reaction at rest"
    assert furthest in by_statics.facts()["least"]

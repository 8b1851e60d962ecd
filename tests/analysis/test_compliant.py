"""The incremental load factor: rays and plateaus, closed forms, contact dynamics, invariance."""

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from contact_dynamics import QUICK, collapse_load
from mappings import SAME
from residuals import residuals
from scenes import CASES, KINDS_OF_JOINTS, WALLS, block_on_floor, small_wall, solved, two_blocks, values_of
from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.answer.acceptance import LIMITS, Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.methods.push.push import Elastic
from masonry_opt.models.pyomo_mcp import PyomoMcp
from masonry_opt.problem.problem import State


def code(result):
    return result.reasons[0].code


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow if name == "strength" else ()) for name in KINDS_OF_JOINTS],
)
def test_the_certificate_is_of_contacts_that_give(name):
    """Of the equations declared in Pyomo, of rigid contacts, they leave just E (q - q₀)."""
    result = mo.solve(KINDS_OF_JOINTS[name], "compliant", give=0.01)
    problem, found = result.assembly.problem, result.solution.found
    assert not LIMITS[Kind.COMPLIANT].failing(result.solution.answer.residuals)
    assert not result.exact
    soft = Elastic(problem).giving(0.01)
    p = soft.rates(found.d, soft.dilatancy, found.q)
    left = residuals(PyomoMcp(problem), State(result.load_factor, found.q, found.d, p)).compatibility
    gives = soft.compliance * (found.q - soft.settled)
    np.testing.assert_allclose(left, -gives, atol=1e-8 * np.abs(found.d).max())


@pytest.mark.parametrize("scene", [two_blocks(), box_on_floor((2, 2, 1), 0.5)], ids=["plane", "space"])
def test_without_a_ray_the_load_is_that_which_stays(certificates, scene):
    """As the displacement grows tenfold."""
    ray = solved(scene, "compliant").load_factor
    certificates(1e-6, "complementarity")  # too much for an exact state alone
    result = mo.solve(scene, "compliant")
    told = values_of(result, Code.LEVEL)
    assert told == {"steps": len(result.history), "folds": 0, "deep_fall": None, "peak": None}
    assert result.end == result.expected == result.load_factor
    assert result.load_factor == pytest.approx(ray, rel=1e-4)
    assert result.associative is not None


def test_a_stated_compliance_is_taken():
    soft, stiff = (solved(WALLS[1], "compliant", give=give) for give in (0.1, 1e-3))
    assert soft.load_factor < 0.5 * stiff.load_factor
    assert code(stiff) is Code.NO_PLATEAU


#: A block of weight 1, so wide and high, on a floor: over what a mean contact gives under half the weight, a
#: force through its centroid moves it by twice the force along the joint, and as it turns by (h/b)² times it.
WIDE, HIGH = 1.0, 2.0
SOFT = 2 + (HIGH / WIDE) ** 2


@pytest.mark.parametrize(("friction", "moves"), [(0.3, "sliding"), (0.7, "opening")])
def test_a_block_is_elastic_and_then_slides_or_rocks(friction, moves):
    result = solved(block_on_floor(WIDE, HIGH, friction), "compliant", curve=True)
    curve, collapse = result.curve, min(friction, WIDE / HIGH)
    expected = np.minimum(curve["displacement"] / SOFT, collapse)
    assert 0 < (expected < collapse).sum() < len(curve)
    np.testing.assert_allclose(curve["load_factor"], expected, rtol=1e-7)
    still = "opening" if moves == "sliding" else "sliding"
    assert (curve[moves] == (expected == collapse)).all()
    assert not curve[still].any()
    (first,) = np.flatnonzero(curve[f"starts_{moves}"])
    assert first == (expected < collapse).sum()
    assert curve[f"starts_{moves}"][first] == [["A", "floor"]]


def test_a_curve_starts_from_where_the_weight_has_brought_the_load():
    """A load aslant: what it did as the block settled is past."""
    across, down = 1.0, 0.25
    curve = solved(block_on_floor(WIDE, HIGH, 0.3, live=(across, -down)), "compliant", curve=True).curve
    way = np.hypot(across, down) * curve["displacement"]
    collapse = 0.3 / (across - 0.3 * down)
    expected = np.minimum(way / (across**2 * SOFT + down**2), collapse)
    assert 0 < expected[0] < 0.5 * collapse
    np.testing.assert_allclose(curve["load_factor"], expected, rtol=1e-7)


def test_a_curve_ends_in_the_load_to_expect():
    plain, result = (solved(WALLS[0], "compliant", **given) for given in ({}, {"curve": True}))
    curve = result.curve
    assert plain.curve is None
    assert result.load_factor == plain.load_factor
    assert curve["load_factor"].iloc[-1] == pytest.approx(plain.load_factor, rel=1e-5)
    assert curve["displacement"].to_numpy() == pytest.approx(1 / curve["give"])
    told = values_of(result, Code.CURVE)
    assert (told["states"], told["left_out"]) == (len(curve), 0)
    for column, moves in (("starts_sliding", "sliding"), ("starts_opening", "opening")):
        started = [tuple(pair) for pairs in curve[column] for pair in pairs]
        assert len(started) == len(set(started)) >= curve[moves].max()
    assert "does not fall" in result.summary


@pytest.mark.parametrize("name", ["turned by 37°", "in millimetres"])
def test_a_curve_is_unmoved(name):
    """On other axes its states are others, which begin in the same branch, straight to some parts in 10⁴."""
    base = small_wall(6, 4)
    one, other = (solved(scene, "compliant", curve=True).curve for scene in (base, SAME[name](base)))
    soft = [curve["load_factor"] / curve["displacement"] for curve in (one, other)]
    np.testing.assert_allclose(soft[0][:3], soft[1][:3], rtol=1e-3)
    if name != "turned by 37°":
        np.testing.assert_allclose(one["displacement"], other["displacement"], rtol=1e-12)
        np.testing.assert_allclose(one["load_factor"], other["load_factor"], rtol=1e-6)
        assert one[["sliding", "opening"]].equals(other[["sliding", "opening"]])


def test_a_curve_softens():
    """A heap that clings, and slips off."""
    result = solved(random_scene("tessellation", 5), "compliant", curve=True)
    told = values_of(result, Code.CURVE)
    assert told["peak"] == result.curve["load_factor"].max() > 5 * told["last"]
    assert told["states"] + told["left_out"] == len(result.history) - 1
    assert "falls from " in result.message


@pytest.mark.parametrize(
    "scene",
    [
        pytest.param(mo.load(WALLS[1]), id="wall_2", marks=pytest.mark.slow),
        # It slips under the dead load; exact states from 1.3 on.
        pytest.param(mo.load(CASES / "closed_forms" / "pulled_stone.toml"), id="pulled_stone"),
        # With an exact state at a seventh of what it carries from rest.
        pytest.param(random_scene("wall", 77006), id="77006", marks=pytest.mark.slow),
    ],
)
def test_contact_dynamics_carries_it_to_a_hundredth(scene):
    load_factor = solved(scene, "compliant").load_factor
    assert collapse_load(scene, 1.3 * load_factor, QUICK) == pytest.approx(load_factor, rel=0.01)


@pytest.mark.parametrize("method", ["compliant", "mcp", "nonassociative"])
def test_nothing_weighs_anything(method):
    """Without weight and cohesion the least load moves a block: λ is 0."""
    result = mo.solve(block_on_floor(weight=0.0), method)
    assert abs(result.load_factor) < 1e-6

"""The load to expect: plateaus, closed forms, contact dynamics, and what does not move it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from contact_dynamics import load_carried
from mappings import SAME
from residuals import residuals
from scenes import CASES, KINDS_OF_JOINTS, WALLS, block_on_floor, small_wall, solved, values_of

import masonry_opt as mo
from masonry_opt.answer.acceptance import LIMITS, Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.methods.mcp.compliant import unit_compliance
from masonry_opt.methods.mcp.edge_form import EdgeForm
from masonry_opt.models.pyomo_mcp import PyomoMcp
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.state import State

#: By an independent program over the same matrices, contacts alike whatever their length, at the plateau.
ALIKE = {1: 0.64154, 2: 0.56401, 3: 0.35582, 4: 0.26374, 5: 0.21439, 6: 0.2964}
#: What stiffness by length in place of alike changes, as that program found it.
STIFFNESS = 1e-3
#: A wall with an exact state at a seventh of what it carries from rest.
OTHER = 77006
#: Joints of half the length are half as stiff, each.
SPLIT = 1e-3


def code(result):
    return result.reasons[0].code


@pytest.mark.parametrize("number", ALIKE)
def test_walls_come_to_the_plateau_of_another_program(number):
    result = solved(WALLS[number - 1], "compliant")
    assert code(result) is Code.PLATEAU
    assert result.load_factor == pytest.approx(ALIKE[number], rel=STIFFNESS)
    assert result.load_factor < result.associative
    steps = result.history.groupby("attempt").size()
    assert steps.max() <= 65


@pytest.mark.parametrize("name", KINDS_OF_JOINTS)
def test_the_certificate_is_of_contacts_that_give(name):
    """The declared equations with E q, in Pyomo, leave nothing; without it they leave just E q."""
    result = mo.solve(KINDS_OF_JOINTS[name], "compliant", give=0.01)
    problem, found = result.assembly.problem, result.solution.found
    assert not LIMITS[Kind.COMPLIANT].failing(result.solution.answer.residuals)
    assert not result.exact
    unit = unit_compliance(problem, EdgeForm(problem).least_forces)
    soft = replace(problem, compliance=0.01 * unit)
    p = soft.rates(found.d, soft.dilatancy, found.q)
    left = residuals(PyomoMcp(soft), State(result.load_factor, found.q, found.d, p))
    np.testing.assert_allclose(left.compatibility, 0, atol=1e-8 * np.abs(found.d).max())
    given = residuals(PyomoMcp(problem), State(result.load_factor, found.q, found.d, p)).compatibility
    np.testing.assert_allclose(given, -soft.compliance * found.q, atol=1e-8 * np.abs(found.d).max())


@pytest.mark.parametrize("name", ["two_leaves", "pulled_stone", "dam_slides", "dam_overturns", "buttress"])
def test_closed_forms_where_forces_are_determinate(name):
    result = solved(CASES / "closed_forms" / f"{name}.toml", "compliant")
    known = result.assembly.scene.reference
    expected = known.get("coulomb", known["associative"]).value
    assert result.load_factor == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("name", SAME)
def test_the_load_to_expect_is_unmoved(name):
    """By moving, turning, mirroring, other units, another order, and a vertex in the middle of an edge."""
    base = small_wall(6, 4)
    one, other = (solved(scene, "compliant") for scene in (base, SAME[name](base)))
    assert other.load_factor == pytest.approx(
        one.load_factor, rel=SPLIT if name == "supports split" else 1e-6
    )
    assert code(one) is code(other) is Code.PLATEAU


def test_nothing_collapses_where_the_load_presses_blocks_down():
    scene = random_scene("wall", 77010)
    assert solved(scene, "compliant").load_factor is None


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
    assert 5 < (expected < collapse).sum() < len(curve) == 21
    np.testing.assert_allclose(curve["load_factor"], expected, rtol=1e-7)
    still = "opening" if moves == "sliding" else "sliding"
    assert (curve[moves] == (expected == collapse)).all()
    assert not curve[still].any()
    (first,) = np.flatnonzero(curve[f"starts_{moves}"])
    assert first == (expected < collapse).sum()
    assert curve[f"starts_{moves}"][first] == [["A", "floor"]]


def test_a_curve_starts_from_where_the_weight_has_brought_the_load():
    """A load aslant does work as the block settles: states before that, with λ < 0, are none of a push."""
    across, down = 1.0, 0.25
    curve = solved(block_on_floor(WIDE, HIGH, 0.3, live=(across, -down)), "compliant", curve=True).curve
    way = np.hypot(across, down) * curve["displacement"]
    collapse = 0.3 / (across - 0.3 * down)
    expected = np.minimum((way - down) / (across**2 * SOFT + down**2), collapse)
    assert 0 < expected[0] < 0.1
    np.testing.assert_allclose(curve["load_factor"], expected, rtol=1e-7)


@pytest.mark.parametrize("number", [1, 2])
def test_a_curve_ends_in_the_load_to_expect(number):
    plain, result = (solved(WALLS[number - 1], "compliant", **given) for given in ({}, {"curve": True}))
    curve = result.curve
    assert plain.curve is None
    assert result.load_factor == plain.load_factor == curve["load_factor"].iloc[-1]
    assert values_of(result, Code.PLATEAU)["give"] == curve["give"].iloc[-1]
    assert curve["displacement"].to_numpy() == pytest.approx(1 / curve["give"])
    told = values_of(result, Code.CURVE)
    assert (told["states"], told["left_out"]) == (len(curve), 0)
    for column, moves in (("starts_sliding", "sliding"), ("starts_opening", "opening")):
        started = [tuple(pair) for pairs in curve[column] for pair in pairs]
        assert len(started) == len(set(started)) >= curve[moves].max()
    assert "does not fall" in result.summary


@pytest.mark.parametrize("name", [name for name in SAME if name != "supports split"])
def test_a_curve_is_unmoved(name):
    """On other axes its states are others, which begin in the same elastic branch."""
    base = small_wall(6, 4)
    one, other = (solved(scene, "compliant", curve=True).curve for scene in (base, SAME[name](base)))
    soft = [curve["load_factor"] / curve["displacement"] for curve in (one, other)]
    np.testing.assert_allclose(soft[0][:3], soft[1][:3], rtol=1e-6)
    if name != "turned by 37°":
        np.testing.assert_allclose(one["displacement"], other["displacement"], rtol=1e-12)
        np.testing.assert_allclose(one["load_factor"], other["load_factor"], rtol=1e-6)
        assert one[["sliding", "opening"]].equals(other[["sliding", "opening"]])


@pytest.mark.slow
def test_a_curve_softens_and_tells_how_many_states_it_lacks():
    """A heap that clings, and slips off."""
    result = solved(random_scene("tessellation", 5), "compliant", curve=True)
    told = values_of(result, Code.CURVE)
    assert told["peak"] == result.curve["load_factor"].max() > 5 * told["last"]
    passes = result.history["attempt"].nunique()
    assert told["states"] + told["left_out"] == passes == 29
    assert told["left_out"] > 0
    assert f"({told['left_out']} more were not found), falls from " in result.message


@pytest.mark.parametrize(
    "scene",
    [
        *(pytest.param(mo.load(WALLS[i]), id=WALLS[i].stem, marks=pytest.mark.slow) for i in range(4)),
        *(
            pytest.param(
                random_scene("wall", seed), id=str(seed), marks=[] if seed == OTHER else pytest.mark.slow
            )
            for seed in (77000, 77001, 77002, 77003, 77004, 77005, OTHER, 77007, 77008, 77009, 77011)
        ),
    ],
)
def test_contact_dynamics_carries_it(scene):
    expected = solved(scene, "compliant").load_factor
    carried = load_carried(assemble(scene).problem, expected / 8, 4e-3)
    assert carried == pytest.approx(expected, rel=0.01)


def test_a_wall_pushed_from_rest_does_not_come_to_the_least_state():
    found = solved(random_scene("wall", OTHER), "mcp")
    assert found.exact
    assert found.load_factor < 0.2 * solved(random_scene("wall", OTHER), "compliant").load_factor

"""Method "mpec" and the search of the default: relations between their answers, and their failures."""

import math

import pytest
from scenes import CASES, WALLS, pressed_down, small_wall, solved, values_of

import masonry_opt as mo
from masonry_opt.methods.exact.refiner import Refiner
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Code

WEDGES = CASES / "livesley" / "wedges.toml"
TWO_BLOCKS = CASES / "gilbert" / "two_blocks.toml"

#: Largest residual of an exact state.
EXACT = 1e-8


@pytest.mark.slow
def test_a_search_is_exact_stationary_not_above_the_loop_and_the_lowest_known():
    path = WALLS[0]
    loop, searched = solved(path, "nonassociative"), solved(path, "coulomb", search=0.5)
    assert searched.load_factor <= 0.638983
    assert searched.status is mo.Status.CONVERGED
    assert searched.certificate.worst < EXACT
    assert searched.stationary
    assert searched.load_factor <= loop.load_factor + 1e-7
    assert searched.load_factor <= solved(path, "static").load_factor


@pytest.mark.slow
def test_a_search_from_a_result_handed_in_counts_only_its_own_solves():
    loop = solved(WALLS[0], "nonassociative")
    searched = mo.solve(WALLS[0], "coulomb", start=loop)
    assert searched.load_factor <= loop.load_factor + 1e-7
    assert searched.history["origin"].iloc[0] == "start"
    others = {"dead load": ["newton"], "incremental analysis": ["newton"], "associative": ["highs"]}
    assert searched.solvers == others | {"refinement": ["highs"]}
    no_forces = solved(pressed_down())
    for scene, start in ((WALLS[1], loop), (WALLS[0], "mpec"), (pressed_down(), no_forces)):
        with pytest.raises(mo.OptionError, match="'start'"):
            mo.solve(scene, "coulomb", start=start)


@pytest.mark.slow
def test_mpec_reaches_the_published_value_and_refinement_goes_no_higher():
    """The MPEC reproduces the value of Ferris & Tin-Loi for wall 1, in the case file, to 1e-4.

    A search from its state ends no higher. Walls 2 to 6 are compared in the tests of Table 1.
    """
    scene = mo.load(WALLS[0])
    mpec = solved(scene, "mpec")
    assert mpec.load_factor == pytest.approx(scene.reference["mpec"].value, rel=1e-4)
    assert mpec.certificate.worst < 1e-7
    assert mpec.nlp_solves == len(mpec.history) > 5
    steps = mpec.history
    assert (steps["largest_product"] <= steps["epsilon"] * 1.001 + 1e-12).all()
    assert steps["epsilon"].is_monotonic_decreasing
    searched = mo.solve(scene, "coulomb", start=mpec, incremental=False)
    assert searched.load_factor <= mpec.load_factor + 1e-7
    assert searched.nlp_solves == 0


@pytest.mark.slow
def test_a_relaxation_that_cannot_be_followed_is_a_status_and_what_is_kept_is_called_what_it_is():
    """IPOPT reaches its iteration limit from a cold start on wall 5: the result has a status, no answer."""
    result = mo.solve(WALLS[4], "mpec", start="cold", incremental=False)
    assert result.status is mo.Status.HOMOTOPY
    assert result.load_factor is None
    assert result.certificate is None
    assert values_of(result, Code.RELAXATION_STOPPED)["word"] == "Maximum_Iterations_Exceeded"
    assert values_of(result, Code.NOTHING_SOLVED) == {}
    assert math.isnan(result.history["load_factor"].iloc[-1])


@pytest.mark.parametrize("path", [TWO_BLOCKS, WEDGES], ids=lambda path: path.stem)
def test_the_mpec_ends_at_closed_forms_of_coulomb_friction(path):
    """The MPEC ends at closed forms, to 1e-6: 1.5 μ (two blocks), 1 + (t9 - t1) / (t9 + t19) (Livesley)."""
    scene = mo.load(path)
    result = solved(scene, "mpec")
    assert result.load_factor == pytest.approx(scene.reference["coulomb"].value, abs=1e-6)


def test_where_simplex_finds_no_state_the_default_s_answer_comes_back_as_such(failing):
    failing("highs")
    of_pass = mo.solve(WALLS[0], "coulomb")
    result = mo.solve(WALLS[0], "coulomb", start=of_pass)
    assert result.load_factor == of_pass.load_factor
    assert result.kind is of_pass.kind
    assert values_of(result, Code.NOT_FOUND) == {}
    assert result.stationary is None


def test_the_lowest_state_is_not_above_an_exact_incremental_state():
    """The lowest state counts the exact state at the end of the load history, which exists on both walls.

    From associative forces, method "coulomb" ends above this state on wall 3, and finds no state on wall 4.
    """
    for wall, has_state in ((WALLS[2], True), (WALLS[3], False)):
        result = mo.solve(wall, "coulomb", start=solved(wall, "static"))
        assert result.exact is has_state
        assert result.at_incremental.exact
        assert result.lowest == pytest.approx(result.incremental, rel=1e-9)
        assert result.lowest < 0.9 * result.load_factor
        assert result.range[1] == result.lowest
        assert f"incremental    {result.incremental:.6g}" in result.summary
        assert ("the search found no exact state" in result.summary) is not has_state


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpec", "coulomb"])
@pytest.mark.parametrize(
    ("friction", "joints"),
    [(0.65, {"cohesion": 0.05}), (0.65, {"dilatancy": 0.1}), (float("inf"), {})],
    ids=["cohesion", "dilatant", "no sliding"],
)
def test_joints_of_every_kind(friction, joints, method):
    """The answer obeys its flow rule, and is at or below the associative load factor, to 1e-6."""
    scene = small_wall(3, 2, friction, **joints)
    result = solved(scene, method)
    assert result.certificate.worst < (EXACT if method == "coulomb" else 1e-6)
    assert result.load_factor <= solved(scene, "static").load_factor + 1e-6


def test_a_state_with_residuals_is_not_called_exact():
    """A search that starts from a state with residuals and finds no exact state returns the start, not exact.

    Joints that contract could slide in both senses at once, which no exact state allows.
    """
    scene = small_wall(4, 3, 0.3, dilatancy=-0.2)
    rough = solved(scene, "nonassociative", finish=False)
    assert rough.certificate.worst > 1e-3
    result = mo.solve(scene, "coulomb", start=rough)
    assert values_of(result, Code.NOT_FOUND) == {}
    assert not result.exact
    assert result.load_factor == rough.load_factor


@pytest.mark.slow
def test_an_exact_end_of_the_loop_is_refined_where_a_rough_one_is_not():
    """A wall with negative dilatancy has an exact state at λ = μ = 0.3, to 1e-9.

    The bottom course slides as a whole, so that no joint contracts.
    """
    result = solved(small_wall(4, 3, 0.3, dilatancy=-0.05), "coulomb")
    assert result.exact
    assert result.kind is Kind.EXACT
    assert result.load_factor == pytest.approx(0.3, rel=1e-9)
    assert result.certificate.worst < EXACT


def searched_from_more_friction(number, more):
    """Return the result of a search on a wall, from the loop's state with ``more`` times the friction."""
    wall = mo.load(WALLS[number - 1])
    stiffer = wall.model_copy(update={"joints": mo.JointDefaults(friction=more * 0.65)})
    return mo.solve(wall, "coulomb", start=mo.solve(stiffer, "nonassociative", incremental=False))


@pytest.mark.slow
def test_a_start_without_exact_statics_is_repaired(watched):
    """A start that violates the statics of wall 2 is repaired, and the search ends at an exact state.

    The start is the loop's state with 20 % more friction.
    """
    asked = watched(Refiner, "_forces_at")
    result = searched_from_more_friction(2, 1.2)
    # A call with three arguments asks for the forces of least energy with no face fixed at yield.
    assert any(len(given) == 3 for given in asked)
    assert result.certificate.worst < EXACT
    assert result.load_factor < 0.557417


@pytest.mark.slow
def test_what_a_failed_series_keeps_is_called_what_it_is(failing):
    """If IPOPT gives up below ε = 1e-4, the result has no load factor, and the history ends at ε = 3e-4."""
    failing("ipopt", lambda _, epsilon: epsilon < 1e-4)
    result = mo.solve(WALLS[0], "mpec")
    assert result.status is mo.Status.HOMOTOPY
    assert result.load_factor is None
    assert values_of(result, Code.RELAXATION_STOPPED)["word"] == "Gave_Up"
    kept = result.history.dropna(subset="load_factor").iloc[-1]
    assert kept["epsilon"] == pytest.approx(3e-4)
    assert kept["gap"] > 1e-6
    assert result.joints["n"].notna().all()


def test_mpec_without_its_extra_says_what_to_install(without):
    without("casadi")
    with pytest.raises(mo.OptionError, match=r"\[mpec\]"):
        mo.solve(WALLS[0], "mpec")

"""The default method: an exact state near the incremental load factor, at or below the associative λ."""

import warnings

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from scenes import CASES, WALLS, block_on_floor, irregular, small_wall, solved, two_blocks, values_of

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.alternation import Alternation
from masonry_opt.solution.acceptance import LIMITS, Kind
from masonry_opt.solution.reasons import Code

WEDGES = CASES / "livesley" / "wedges.toml"
ARCH = CASES / "casapulla_lauro" / "arch.toml"
#: Largest residual of an exact state.
EXACT = 1e-8
#: Residual of complementarity of the interior-point programs, relative to λ.
ALTERNATED = 1e-6
#: Relative difference of two linear programs, each solved to about 1e-9 of its largest value.
ASSOCIATIVE = 1e-8
#: Relative difference to a closed form. On these scenes, programs are solved to about 1e-12 of λ.
CLOSED_FORM = 1e-9

SCENES = {
    **{path.stem: path for path in WALLS},
    "wedges": WEDGES,
    "arch": ARCH,
    "two blocks": two_blocks(),
    "irregular": irregular(),
    "small wall": small_wall(),
    "cohesion": small_wall(cohesion=0.05),
}
#: Scenes of this file. Walls 2 to 6 are left out, because the tests of Table 1 check the same claims on them.
ASKED = [name for name in SCENES if name not in [path.stem for path in WALLS[1:]]]


def scene_of(name):
    found = SCENES[name]
    return found if isinstance(found, mo.Scene) else mo.load(found)


def dilating(scene, share):
    """Return the scene with the dilatancy of every joint equal to a share of the default friction."""
    return scene.replace(joints={"dilatancy": share * scene.joints.friction})


def codes(result):
    return [reason.code for reason in result.reasons]


def assert_exact(result):
    assert result.status is mo.Status.CONVERGED
    # On small scenes the result may include a proof that no state is lower.
    assert codes(result) in ([Code.STATES_MET], [Code.STATES_MET, Code.PROVEN])
    assert result.exact
    assert result.solution.kind is Kind.EXACT
    assert result.certificate.worst <= EXACT


@pytest.fixture
def no_ray(certificates):
    """Let no load history end in an exact state."""
    certificates(1.0)


@pytest.fixture
def no_simplex(failing):
    """Let all HiGHS programs fail, so that interior-point programs are used, as on large scenes."""
    failing("highs")


# The state at the end -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", ASKED)
def test_a_state_that_meets_every_condition_at_or_below_the_associative(name):
    """The state is exact and at or below the associative load factor.

    The method has the load history of method "incremental", which ends at most 2 % below its load factor.
    """
    scene = scene_of(name)
    result, incremental = solved(scene), solved(scene, "incremental")
    assert_exact(result)
    assert result.load_factor <= solved(scene, "static").load_factor * (1 + ASSOCIATIVE)
    assert result.history.equals(incremental.history)
    assert 0.98 * incremental.incremental <= result.history["load_factor"].iloc[-1] <= incremental.incremental


@pytest.mark.slow
@pytest.mark.parametrize(
    ("share", "expected", "near"),
    [(0.0, 0.15, CLOSED_FORM), (-0.5, 0.15, CLOSED_FORM), (1e-7, 0.25, 1e-5)],
)
def test_two_blocks_end_at_the_least_of_their_states(share, expected, near):
    """Two blocks end at their least closed-form load factor λ = μ (1 + 2 n), Fig. 6d of the paper.

    Without dilatancy, B may press on A with any n from 0.25 to 0.75. With any positive dilatancy, B rises as
    A slides and turns about the far end of its support, so that n = 0.75.
    """
    result, proven = (solved(dilating(two_blocks(), share), method) for method in ("coulomb", "global"))
    assert_exact(result)
    assert [result.load_factor, proven.load_factor] == pytest.approx([expected] * 2, rel=near)


@pytest.mark.parametrize("friction", [0.8, float("inf")])
def test_a_step_to_the_boundary_divides_by_no_zero(friction):
    """A tipping column has λ = 0.5 without a warning; the force at its first end vanishes in one step."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        assert mo.solve(block_on_floor(1, 2, friction)).load_factor == pytest.approx(0.5, rel=1e-8)


def test_shears_that_nothing_determines_stall_no_pass():
    """A block on two rough floors side by side overturns at λ = w/h = 2, to 1e-9.

    Equilibrium does not determine how the two floors share its shear.
    """
    scene = mo.Scene(
        joints=mo.JointDefaults(friction=float("inf")),
        blocks=[
            mo.Block(name="A", vertices=[(0, 0), (2, 0), (2, 1), (0, 1)], weight=1, live=(1, 0)),
            mo.Block(name="left", vertices=[(-1, -1), (1, -1), (1, 0), (-1, 0)], fixed=True),
            mo.Block(name="right", vertices=[(1, -1), (3, -1), (3, 0), (1, 0)], fixed=True),
        ],
    )
    assert_exact(solved(scene))
    assert solved(scene).load_factor == pytest.approx(2.0, rel=1e-9)


# Dilatancy ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["wedges", "two blocks", "irregular"])
def test_dilatancy_equal_to_friction_is_the_associative_problem(name):
    scene = scene_of(name)
    result = solved(dilating(scene, 1.0))
    assert_exact(result)
    assert result.load_factor == pytest.approx(solved(scene, "static").load_factor, rel=ASSOCIATIVE)


@pytest.mark.parametrize("name", ["two blocks", pytest.param("wall_1", marks=pytest.mark.slow)])
def test_dilatancy_between_has_load_factors_between(name):
    """On these scenes λ rises with the dilatancy, up to the associative load factor.

    No theorem guarantees this rise, because the method finds one of several states.
    """
    scene = scene_of(name)
    results = [solved(dilating(scene, share)) for share in (0.0, 0.25, 0.5, 1.0)]
    for result in results:
        assert_exact(result)
    factors = np.array([result.load_factor for result in results])
    assert (np.diff(factors) >= -1e-8 * factors[-1]).all(), factors
    assert factors[0] < 0.999 * factors[-1]
    assert (factors <= solved(scene, "static").load_factor * (1 + ASSOCIATIVE)).all()


def test_dilatancy_that_falls_with_stress_is_for_the_loop():
    scene = two_blocks().replace(joints={"dilatancy": 0.1, "dilatancy_stress": (0.05, 0.1)})
    result, loop = solved(scene), solved(scene, "nonassociative")
    assert result.status is loop.status is mo.Status.CONVERGED
    assert result.load_factor == loop.load_factor == pytest.approx(0.15, rel=1e-6)
    assert codes(result) == codes(loop)
    assert len(result.history) == len(loop.history)
    assert (result.model, result.solver) == (loop.model, loop.solver) == ("cvxpy", "clarabel")


# Steps that lead to a state -------------------------------------------------------------------------------


def test_where_no_load_history_ends_statics_lead_to_a_state(no_ray, no_simplex):
    result = mo.solve(WALLS[0], incremental=False)
    assert (codes(result), result.exact) == ([], True)
    assert result.certificate.worst <= EXACT
    assert result.load_factor <= result.associative == pytest.approx(0.64286, abs=5e-6)


def test_further_starts_answer_on_small_scenes_where_no_load_history_ends(no_ray):
    result = mo.solve(two_blocks(), incremental=False)
    assert_exact(result)
    assert result.load_factor == pytest.approx(0.15, rel=CLOSED_FORM)


def test_the_first_state_will_do_if_asked_for():
    """Without descent, two blocks have one candidate; the whole method tries further starts."""
    first, whole = solved(two_blocks(), descent=False), solved(two_blocks())
    assert values_of(first, Code.STATES_MET)["candidates"] == 1
    assert values_of(whole, Code.STATES_MET)["candidates"] > 1
    assert_exact(first)


def test_without_descent_no_lower_state_is_looked_for():
    """On wall 2 the first exact state is 0.6 % above the state at which the descent ends."""
    first, lowest = solved(WALLS[1], descent=False), solved(WALLS[1])
    assert_exact(first)
    assert first.load_factor == pytest.approx(0.560896, abs=1e-6)
    assert lowest.load_factor == pytest.approx(0.557416, abs=1e-6)
    assert first.lp_solves < lowest.lp_solves


@pytest.mark.parametrize("name", ["wedges", "irregular"])
def test_interior_points_in_turn_end_near_where_simplex_does(name):
    """Interior-point programs find a state from the last forces of a load history.

    The state is exact except for its complementarity. Its load factor is that of simplex, to 1e-6.
    """
    simplex, loaded = solved(scene_of(name)), solved(scene_of(name), "incremental")
    state = loaded.solution.answer
    found = Alternation(loaded.assembly.problem, Effort()).state_near(state.q, state.d)
    left = found.certificate
    assert max(left.equilibrium, left.yield_, left.flow) <= EXACT
    assert left.complementarity <= ALTERNATED * found.load_factor
    assert found.load_factor == pytest.approx(simplex.load_factor, rel=ALTERNATED)


def test_where_simplex_takes_long_programs_lead_lower_than_the_load_history(no_simplex):
    result = mo.solve(irregular())
    assert (codes(result), result.exact) == ([], True)
    assert result.certificate.worst <= EXACT
    assert result.load_factor <= result.end * (1 + 1e-9)
    assert result.end == pytest.approx(mo.solve(irregular(), "incremental").load_factor, rel=1e-9)


@pytest.mark.slow
def test_a_state_above_its_limits_is_no_answer(monkeypatch, no_simplex):
    """States whose residuals exceed all limits are no answer, from the load history or from the loop."""
    never = dict.fromkeys(vars(LIMITS[Kind.NEARLY_COMPLEMENTARY]), -1.0)
    for kind in (Kind.NEARLY_COMPLEMENTARY, Kind.EXACT, Kind.LOOP, Kind.INCREMENTAL):
        monkeypatch.setitem(LIMITS, kind, type(LIMITS[kind])(**never))
    result = mo.solve(two_blocks(), incremental=False, descent=False)
    assert (result.status, result.load_factor) == (mo.Status.SOLVER_FAILED, None)


# No load factor -------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_joints_that_press_ever_harder_carry_any_load():
    """A wall whose response is linear while the load grows a thousandfold is jammed without a load factor.

    The search for a proof that no load factor exists has its default limit of 3750 programs. It ends without
    a proof.
    """
    result = solved(random_scene("wall", 70003), incremental=True)
    assert (result.status, result.load_factor, result.incremental) == (mo.Status.JAMMED, None, None)
    assert codes(result)[:2] == [Code.UNBOUNDED, Code.CARRIES_ANY]
    assert not result.infeasibility.proven

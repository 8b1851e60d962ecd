"""The lower bound of method "global": its assumptions, and the scenes on which it reaches the load factor."""

from dataclasses import replace

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from scenes import CASES, WALLS, small_wall, solved, two_blocks, values_of

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.bounds.products import distances
from masonry_opt.methods.bounds.settings import SETTINGS
from masonry_opt.methods.bracket import bracket
from masonry_opt.methods.bracket.relaxation import BoundStep, bounds_of, relaxed, tightened
from masonry_opt.methods.coulomb.search import LowerState
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.reasons import Code

WEDGES = CASES / "livesley" / "wedges.toml"
TWO_BLOCKS = CASES / "gilbert" / "two_blocks.toml"

#: Largest residual of an exact state.
EXACT = 1e-8
#: Largest relative difference between the two ends of a closed bracket.
CLOSED = 1.1e-5


@pytest.mark.parametrize("path", [TWO_BLOCKS, WEDGES], ids=lambda path: path.stem)
def test_small_scenes_are_proved_without_any_assumption(no_proof, path):
    result = mo.solve(path, "global", incremental=False)
    assert result.status is mo.Status.OPTIMAL
    assert result.bound == pytest.approx(result.load_factor, rel=CLOSED)
    assert result.bound <= mo.load(path).reference["coulomb"].value + 1e-9
    proven = values_of(result, Code.PROVEN)
    assert (proven["bound"], proven["load_factor"]) == (result.bound, result.load_factor)
    assert (proven["rates"], proven["forces"]) == (None, False)
    assert result.range == (result.bound, result.load_factor)
    assert result.certificate.worst < EXACT


def test_a_proof_of_the_default_needs_no_programs_of_products():
    """For a running bond, the default's proof provides a bound that does not assume limits on rates."""
    result = solved(small_wall(4, 1), "global")
    assert result.status is mo.Status.OPTIMAL
    assert result.load_factor == pytest.approx(0.479263, abs=1e-6)
    assert result.range == (result.bound, result.load_factor)
    assert result.bound == pytest.approx(result.load_factor, rel=CLOSED)
    assert "products" not in result.solvers


@pytest.fixture
def no_vertex(monkeypatch):
    """Solve no relaxation to a vertex, as on scenes with many products."""
    monkeypatch.setattr("masonry_opt.methods.bracket.relaxation.SETTINGS", replace(SETTINGS, most_products=0))


@pytest.mark.slow
def test_the_bracket_of_a_running_bond_closes_without_an_assumption(no_proof):
    """Kinematics do not limit the rates of a running bond, but the proof by products needs no limit."""
    scene = small_wall(4, 1)
    result = mo.solve(scene, "global", incremental=False)
    assert result.status is mo.Status.OPTIMAL
    assert result.load_factor == pytest.approx(0.479263, abs=1e-6)
    assert result.range == (result.bound, result.load_factor)
    assert values_of(result, Code.PROVEN)["rates"] is None
    assert result.proof.relaxations
    assert mo.check_proof(scene, result.proof).holds


@pytest.mark.slow
def test_the_bracket_of_a_running_bond_closes_below_the_rates_assumed(no_proof, no_vertex):
    result = mo.solve(small_wall(4, 1), "global", time_limit=300.0, incremental=False)
    assert result.load_factor == pytest.approx(0.479263, abs=1e-6)
    assert result.bound == pytest.approx(result.load_factor, rel=CLOSED)
    assert result.status is mo.Status.CONVERGED
    said = values_of(result, Code.WITHIN_IMPOSED)
    assert not said["forces"]
    assert said["rates"] == pytest.approx(max(100.0, 10 * _sum_of_rates(result)))
    # A bound that assumes limits is not an end of the range.
    assert result.range == (None, result.load_factor)


def test_limits_of_forces_that_are_assumed_leave_nothing_proven(no_proof, failing):
    """If HiGHS fails in the programs of force bounds, the limits on forces are assumed and nothing is proven.

    Only these programs have no time limit, which is how the fixture selects them.
    """
    failing("highs", lambda _, seconds: seconds == np.inf)
    result = mo.solve(TWO_BLOCKS, "global", incremental=False)
    assert values_of(result, Code.WITHIN_IMPOSED)["forces"]
    assert result.bound == pytest.approx(result.load_factor, rel=CLOSED)
    assert result.range == (None, result.load_factor)


@pytest.mark.slow
def test_a_wall_is_bracketed_in_the_time_given():
    """After 2 s, method "global" reports a bound below its state, and the assumption on rates.

    Each program takes a little less than a second.
    """
    result = solved(WALLS[0], "global", time_limit=2)
    assert result.status is mo.Status.CONVERGED
    assert result.load_factor == pytest.approx(0.638982, abs=1e-6)
    assert 0 <= result.bound < result.load_factor
    said = values_of(result, Code.OUT_OF_TIME_WITHIN_IMPOSED)
    assert (said["time_limit"], said["forces"]) == (2.0, False)
    assert said["rates"] == pytest.approx(10 * _sum_of_rates(result))
    assert said["bound"] == result.bound


def _sum_of_rates(result):
    """Return the sum of all slips, and of the openings at both ends of all joints, without dilatancy."""
    problem = result.assembly.problem
    first, second, slip = (problem.B.T @ result.solution.d).reshape(3, -1)
    return np.abs(slip).sum() + first.sum() + second.sum()


@pytest.mark.slow
def test_an_answer_that_exceeds_the_assumed_rates_is_not_bounded(no_proof, no_vertex):
    """An answer whose rates exceed the assumed limit of 0.01 has the bound 0.

    Bonds of one block in width can slide to both sides, so kinematics do not limit the rates.
    """
    result = mo.solve(small_wall(4, 1), "global", rate_bound=0.01, incremental=False)
    assert result.status is mo.Status.CONVERGED
    assert values_of(result, Code.TOUCHES_IMPOSED)["rates"] == 0.01
    assert result.bound == 0.0


@pytest.mark.slow
def test_an_answer_that_exceeds_the_assumed_forces_is_not_bounded():
    """An answer whose forces exceed the assumed limits has the bound 0.

    A block is clamped between two fixed blocks. Statics allow any clamping force, and a small friction needs
    a large clamping force to carry the weight.
    """
    blocks = [
        mo.Block(name="left", vertices=[(-1, 0), (0, 0), (0, 1), (-1, 1)], fixed=True),
        mo.Block(name="right", vertices=[(1, 0), (2, 0), (2, 1), (1, 1)], fixed=True),
        mo.Block(name="clamped", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=1.0),
        mo.Block(name="on it", vertices=[(0, 1), (1, 1), (1, 2), (0, 2)], weight=1.0, live=(1.0, 0.0)),
    ]
    exceptions = [mo.Joint(between=("clamped", side), friction=0.02) for side in ("left", "right")]
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.3), blocks=blocks, exceptions=exceptions)
    result = solved(scene, "global", time_limit=5)
    assert result.load_factor == pytest.approx(0.3, abs=1e-8)
    # Both sides carry the weight of both blocks: 2 ≤ 2 μ n.
    assert result.joints["n"].max() >= 50 * (1 - 1e-9)
    assert values_of(result, Code.TOUCHES_IMPOSED)["forces"]
    assert result.bound == 0.0


def test_a_search_that_is_interrupted_ends_the_bracket_too():
    """An interrupt of the search, with which the bracket begins above 60 joints, also ends the bracket."""

    def interrupt(step):
        if isinstance(step, LowerState):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mo.solve(small_wall(6, 6), "global", progress=interrupt)


@pytest.mark.slow
def test_every_program_is_told_and_begins_where_the_last_ended():
    """Each program reports one step, and starts from the bound of the program before it.

    Products of the forces and velocities of neighbouring blocks leave a gap. Above the last bound the forces
    have tighter limits, so each program raises the bound.
    """
    steps = []
    result = mo.solve(small_wall(3, 2, cohesion=0.05), "global", progress=steps.append)
    assert len(result.history) == sum(isinstance(step, BoundStep) for step in steps) > 0
    assert (result.history["bound"] <= result.load_factor).all()
    assert result.history["bound"].max() == pytest.approx(result.bound)
    assert result.history["products"].is_monotonic_increasing
    assert (result.history["rates_within"] == 0).all()
    assert result.history["velocities_within"].tolist()[:2] == [1, 1]
    bounds = result.history["bound"].to_numpy()
    np.testing.assert_array_equal(result.history["lowest"], [0.0, *np.maximum.accumulate(bounds)[:-1]])
    assert (np.diff(bounds) > 0).all()


@pytest.mark.slow
def test_no_bound_exceeds_a_known_state():
    """The bound of "global" does not exceed the default's load factor, computed independently, to 1e-9."""
    scene = random_scene("stack", 1)
    known, result = solved(scene, "coulomb"), solved(scene, "global", time_limit=10.0)
    assert result.bound is not None
    assert result.bound <= known.load_factor * (1 + 1e-9)
    assert result.bound <= result.load_factor


@pytest.fixture
def rough_start(monkeypatch):
    """Let the bracket of the wedges start from the loop's state, whose sliding joints contract slightly."""
    loop = mo.solve(WEDGES, "nonassociative", incremental=False)
    assert loop.certificate.flow > 1e-5
    monkeypatch.setattr(bracket, "coulomb", lambda _: loop.solution)


@pytest.mark.slow
def test_a_start_that_is_not_exact_is_replaced_by_the_state_of_a_program(rough_start):
    """A start that is not exact must neither become the answer nor exclude the exact state."""
    least = mo.load(WEDGES).reference["coulomb"].value
    result = mo.solve(WEDGES, "global", incremental=False)
    assert result.load_factor == pytest.approx(least, rel=1e-6)
    assert result.certificate.worst < EXACT
    assert result.bound == pytest.approx(least, rel=CLOSED)
    assert result.bound <= least * (1 + 1e-9)


@pytest.mark.slow
def test_a_bound_without_a_state_is_no_answer(rough_start, failing):
    failing("highs", lambda session, _: "q" in session.lp.columns)  # the programs that make states exact
    result = mo.solve(WEDGES, "global", incremental=False)
    assert result.load_factor is None
    assert result.reasons[0].code is Code.NO_EXACT_STATE
    assert result.bound > 0


@pytest.mark.slow
def test_forces_have_less_room_above_a_bound_and_every_known_state_keeps_its_own():
    scene = small_wall(3, 2)
    states = [solved(scene, name) for name in ("static", "nonassociative", "coulomb")]
    problem, highest = states[0].assembly.problem, states[0].load_factor
    of = bounds_of(problem, highest, 100.0, Effort())
    lowest = 0.99 * min(state.load_factor for state in states)
    assert of.forces_derived
    lower = bounds_of(problem, 0.5 * highest, 100.0, Effort())
    assert (lower.normal <= of.normal + 1e-9).all()
    assert lower.normal.sum() < of.normal.sum()
    above = tightened(of, problem, lowest, highest, Effort())
    assert above.normal.sum() < 0.9 * of.normal.sum()
    assert (above.forces <= of.forces).all()
    for state in states:
        n = problem.normal_forces(state.solution.q)
        assert (n <= above.normal + 1e-4 * above.normal.max()).all()


def test_where_lower_states_are_left_out_the_same_products_prove_more():
    problem, least = assemble(small_wall(4, 1)).problem, 0.479263
    highest, effort = least * 1.0001, Effort()
    of = bounds_of(problem, highest, 100.0, effort)
    kept = tuple(away <= 0 for away in distances(problem))
    first = relaxed(problem, highest, of, kept, 10.0, effort)[0]
    above = tightened(of, problem, 0.5 * least, highest, effort)
    second = relaxed(problem, highest, above, kept, 10.0, effort)[0]
    assert first + 0.05 * least < second <= least


def test_limits_that_would_be_assumed_do_not_replace_those_proven(failing):
    problem = assemble(small_wall(3, 2)).problem
    of = bounds_of(problem, 0.5, 100.0, Effort())
    failing("highs")
    assert tightened(of, problem, 0.4, 0.5, Effort()) == replace(of, lowest=0.4)


def test_rates_are_derived_where_kinematics_bound_them():
    problem = assemble(two_blocks()).problem
    assert bounds_of(problem, 0.2, 100.0, Effort()).rates_derived
    dilatancy = np.full(len(problem.sliding), -0.01)
    contracting = replace(problem, law=replace(problem.law, dilatancy=dilatancy))
    of = bounds_of(contracting, 0.2, 100.0, Effort())
    assert (of.rates_derived, of.rates) == (False, 100.0)


def test_a_face_is_at_rest_only_where_a_ray_says_so(failing):
    """HiGHS finds programs of the two blocks infeasible, but its infeasibility certificate is too small.

    Without a valid certificate the rates are not derived from kinematics.
    """
    problem = assemble(two_blocks()).problem
    failing("ray")
    assert not bounds_of(problem, 0.2, 100.0, Effort()).rates_derived


def test_a_load_factor_of_zero_has_no_proof_by_products():
    """A block whose centroid is above the edge of its support tips at λ = 0, so that no bound is positive."""
    blocks = [
        mo.Block(name="floor", vertices=[(0, -1), (1, -1), (1, 0), (0, 0)], fixed=True),
        mo.Block(name="block", vertices=[(0, 0), (2, 0), (2, 1), (0, 1)], weight=1.0, live=(1.0, 0.0)),
    ]
    result = mo.solve(mo.Scene(joints=mo.JointDefaults(friction=0.7), blocks=blocks), "global")
    assert result.load_factor == pytest.approx(0.0, abs=1e-8)
    assert result.proof is None

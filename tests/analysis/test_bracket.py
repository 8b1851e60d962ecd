"""Method "global": what its lower bound claims, and on which scenes the bracket closes."""

from dataclasses import replace

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from scenes import CASES, WALLS, small_wall, solved, two_blocks, values_of

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.bracket import bracket
from masonry_opt.methods.bracket.relaxation import BoundStep, bounds_of, distances, relaxed, tightened
from masonry_opt.methods.coulomb.search import LowerState
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.reasons import Code

WEDGES = CASES / "livesley" / "wedges.toml"
TWO_BLOCKS = CASES / "gilbert" / "two_blocks.toml"

#: What "exact" means: every part of the certificate; and how near a closed bracket's ends are.
EXACT, CLOSED = 1e-8, 1.1e-5


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
    """The bond's least load factor is then proven without an assumption on rates."""
    result = solved(small_wall(4, 1), "global")
    assert result.status is mo.Status.OPTIMAL
    assert result.load_factor == pytest.approx(0.479263, abs=1e-6)
    assert result.range == (result.bound, result.load_factor)
    assert result.bound == pytest.approx(result.load_factor, rel=CLOSED)
    assert "products" not in result.solvers


@pytest.mark.slow
def test_the_bracket_of_a_running_bond_closes_below_the_rates_assumed(no_proof):
    result = mo.solve(small_wall(4, 1), "global", time_limit=300.0, incremental=False)
    assert result.load_factor == pytest.approx(0.479263, abs=1e-6)
    assert result.bound == pytest.approx(result.load_factor, rel=CLOSED)
    assert result.status is mo.Status.CONVERGED
    said = values_of(result, Code.WITHIN_IMPOSED)
    assert not said["forces"]
    assert said["rates"] == pytest.approx(max(100.0, 10 * _sum_of_rates(result)))
    # What assumes anything is no end of the range.
    assert result.range == (None, result.load_factor)


def test_limits_of_forces_that_are_assumed_leave_nothing_proven(no_proof, failing):
    """As where HiGHS fails in programs of bounds, which alone have no limit of time."""
    failing("highs", lambda _, seconds: seconds == np.inf)
    result = mo.solve(TWO_BLOCKS, "global")
    assert values_of(result, Code.WITHIN_IMPOSED)["forces"]
    assert result.bound == pytest.approx(result.load_factor, rel=CLOSED)
    assert result.range == (None, result.load_factor)


@pytest.mark.slow
def test_a_wall_is_bracketed_in_the_time_given():
    """Hardly a second a program: what is proven by then is below the state, its assumption is told."""
    result = solved(WALLS[0], "global", time_limit=2)
    assert result.status is mo.Status.CONVERGED
    assert result.load_factor == pytest.approx(0.638982, abs=1e-6)
    assert 0 <= result.bound < result.load_factor
    said = values_of(result, Code.OUT_OF_TIME_WITHIN_IMPOSED)
    assert (said["time_limit"], said["forces"]) == (2.0, False)
    assert said["rates"] == pytest.approx(10 * _sum_of_rates(result))
    assert said["bound"] == result.bound


def _sum_of_rates(result):
    """Of slips and of openings of both edges of all joints that do not dilate."""
    problem = result.assembly.problem
    first, second, slip = (problem.B.T @ result.solution.d).reshape(3, -1)
    return np.abs(slip).sum() + first.sum() + second.sum()


@pytest.mark.slow
def test_an_answer_that_exceeds_the_assumed_rates_is_not_bounded(no_proof):
    """One-wide bonds can slide to and fro, so kinematics bound no rate; the answer's own is above 0.01."""
    result = mo.solve(small_wall(4, 1), "global", rate_bound=0.01, incremental=False)
    assert result.status is mo.Status.CONVERGED
    assert values_of(result, Code.TOUCHES_IMPOSED)["rates"] == 0.01
    assert result.bound == 0.0


@pytest.mark.slow
def test_an_answer_that_exceeds_the_assumed_forces_is_not_bounded():
    """A block clamped between two fixed ones: statics carry any clamping, and little friction needs much of
    it to bear the weight."""
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
    """Above 60 joints the bracket begins with a search."""

    def interrupt(step):
        if isinstance(step, LowerState):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mo.solve(small_wall(6, 6), "global", progress=interrupt)


@pytest.mark.slow
def test_every_program_is_told_and_begins_where_the_last_ended():
    """Forces with a joint's own blocks and the next leave a gap: above it forces have less room, and they
    prove more."""
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


def test_no_bound_exceeds_a_known_state():
    """The default ends in a state of its own, which the bracket has not seen."""
    scene = random_scene("stack", 1)
    known, result = solved(scene, "coulomb"), solved(scene, "global", time_limit=10.0)
    assert result.bound is not None
    assert result.bound <= known.load_factor * (1 + 1e-9)
    assert result.bound <= result.load_factor


@pytest.fixture
def rough_start(monkeypatch):
    """Of a bracket of the wedges: the loop's state, whose sliding contracts a little."""
    loop = mo.solve(WEDGES, "nonassociative")
    assert loop.certificate.flow > 1e-5
    monkeypatch.setattr(bracket, "coulomb", lambda _: loop.solution)


def test_a_start_that_is_not_exact_is_replaced_by_the_state_of_a_program(rough_start):
    """It must not pass for the answer, nor cut one off."""
    least = mo.load(WEDGES).reference["coulomb"].value
    result = mo.solve(WEDGES, "global")
    assert result.load_factor == pytest.approx(least, rel=1e-6)
    assert result.certificate.worst < EXACT
    assert result.bound == pytest.approx(least, rel=CLOSED)
    assert result.bound <= least


@pytest.mark.slow
def test_a_bound_without_a_state_is_no_answer(rough_start, failing):
    failing("highs", lambda session, _: "q" in session.lp.columns)  # what makes states exact
    result = mo.solve(WEDGES, "global")
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
    """HiGHS finds programs of the two blocks infeasible: its word alone proves nothing."""
    problem = assemble(two_blocks()).problem
    failing("ray")
    assert not bounds_of(problem, 0.2, 100.0, Effort()).rates_derived

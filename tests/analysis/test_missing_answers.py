"""Scenes on which an earlier version ended with "solver failed" although parts of the answer were known.

The comment at the top of each case file says what is known of the scene.
"""

from functools import partial
from math import inf
from pathlib import Path

import numpy as np
import pytest
from contact_dynamics import QUICK, collapse_load_of
from loads.settling_programs import exact_load_factors, reactions
from scenes import values_of
from second_program import bounds, random_of_any_kind

import masonry_opt as mo
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.reasons import Code, Status

FOLDER = Path(__file__).parent / "missing_answers"


def test_a_stack_that_the_live_load_lifts_and_a_fill_pushes_aside():
    """A stack under a fill collapses at λ = 23.38086, the associative value of a linear program.

    Neither the live load nor the dead load does work in the mechanism. The active pressure of the fill does.
    """
    result = mo.solve(FOLDER / "lifted_stack_under_fill.toml", load_case="c")
    assert result.status is Status.CONVERGED
    assert values_of(result, Code.NO_WORK) is not None
    assert result.load_factor == pytest.approx(23.38086, abs=5e-6)
    assert result.exact
    problem = result.assembly.problem
    assert problem.unbalanced(result.load_factor, result.solution.q) == pytest.approx(0, abs=1e-8)
    assert problem.slacks(result.solution.q).min() >= -1e-8
    # The work of the live load vanishes against the work of the pressures.
    assert abs(problem.live @ result.solution.d) <= 1e-7 * abs(result.pressures["lengthens"]).max()
    # The search for a proof excludes states with work of the live load only, so the details claim no proof.
    assert "proof of the least" in result.details
    assert "not proven to be the least" in result.details
    assert "proven by" not in result.details


@pytest.mark.slow
def test_rubble_that_carries_any_multiple_by_statics(monkeypatch, few_cuts):
    """Rubble that carries any multiple of its load by statics is jammed, without a proven infeasibility.

    Neither the load history nor the load factor of the loop has a limit. The history stops after 40
    increments instead of 656, where it would be undecided as well. Its length does not affect other steps.
    The search for a proof of infeasibility ends after 111 programs. It would also end without a proof after
    1333 programs, the default limit for this scene.
    """
    short = partial(IncrementalSettings, increments=40)
    monkeypatch.setattr("masonry_opt.methods.incremental.analysis.IncrementalSettings", short)
    scene = mo.load(FOLDER / "rubble_that_carries_any_load.toml")
    assert bounds(assemble(scene)).outside == inf
    result = mo.solve(scene)
    assert result.status is Status.JAMMED
    assert result.load_factor is None
    assert result.at_incremental.reasons[0].code is Code.UNDECIDED
    assert values_of(result, Code.GROWS) is not None
    assert values_of(result, Code.CARRIES_ANY) is not None
    assert not result.infeasibility.proven


@pytest.mark.parametrize(
    ("seed", "load_factor"),
    [pytest.param(1400437, 9.4690644611, marks=pytest.mark.slow), (1400488, 3.5184944221)],
)
def test_states_of_scenes_whose_statics_carry_any_multiple(seed, load_factor):
    """The default finds the state of a scene whose load history has no limit, to 1e-9.

    The expected load factors come from a mixed-integer program (``claims.other_state``). Neither the load
    history nor the associative load factor leads to the state, so the proof of the least finds it.
    """
    result = mo.solve(random_of_any_kind(seed))
    assert result.at_incremental.reasons[0].code is Code.UNBOUNDED
    assert result.exact
    assert result.load_factor == pytest.approx(load_factor, rel=1e-9)


@pytest.mark.slow
def test_a_pier_that_settles_below_zero():
    scene, direction = mo.load(FOLDER / "beam_on_three_piers.toml"), (0.647493, -0.002044)
    found = mo.settle(scene, "p1", direction)
    assert found.least.associative == pytest.approx(-1.238499, abs=5e-7)
    assert found.least.associative == pytest.approx(reactions(scene, ["p1"], found.direction)[0], abs=1e-7)
    assert found.least.answered_by == "incremental"
    assert found.least.associative < found.least.reaction < found.at_rest
    # Contact dynamics holds the pier as rigidly across its direction. If the pier could give way as a joint
    # does, the reaction would be 10 % larger.
    result = found.least.result
    dynamics = collapse_load_of(result.assembly, 1.5 * result.incremental, QUICK)
    assert result.incremental == pytest.approx(dynamics, rel=1e-2)
    # The pier is released in one direction and carries its reaction, so the scene is in equilibrium at λ = 0.
    problem = found.least.result.assembly.problem
    assert np.abs(problem.unbalanced(0.0, problem.settled)).max() < 1e-9
    assert exact_load_factors(found.least.result.assembly.problem, 1e-5, 10.0) is None
    assert found.usable
    (across,) = found.as_dict()["warnings"]
    assert (across["code"], across["end"]) == ("state across rest", "least")
    assert across["reaction"] == pytest.approx(found.least.across_rest)
    assert across["at_rest"] == found.at_rest < across["reaction"]


@pytest.mark.slow
def test_a_pier_whose_load_history_ends_nearer_to_rest():
    """A warning says that the load history of a pier pulled sideways ends nearer to rest than the state.

    The state is at -1.016, and the load history ends at -0.671.
    """
    found = mo.settle(FOLDER / "beam_on_three_piers.toml", "p0", (1, 0))
    codes = [warning["code"] for warning in found.as_dict()["warnings"]]
    assert codes == ["history ends nearer", "state across rest"]
    nearer = found.warning_records[0]
    assert found.least.reaction < nearer["incremental"] < found.at_rest

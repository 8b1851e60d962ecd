"""What the loop tries after a failure: order, limits, and what it says of it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from scenes import CASES

import masonry_opt as mo
from masonry_opt.analysis import nonassociative
from masonry_opt.answer.status import Status
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.loop.remedies import REMEDIES, Attempt, Doubt
from masonry_opt.solvers.registry import find_solver
from masonry_opt.studies.atlas.small_scenes import confined, ferris_tinloi
from masonry_opt.studies.atlas.solver_failures import STEPPED, TWO_PATHS

WALL_6 = CASES / "ferris_tinloi" / "wall_6.toml"
FIRST = Attempt(LoopOptions().parameters(joints=1), find_solver("cvxpy", None))
FAST = Attempt(LoopOptions(pace="fast").parameters(joints=1), find_solver("cvxpy", None))


def series(failure, attempt):
    """The words of the remedies for a failure, each taken on the one before."""
    words = []
    for remedy in REMEDIES[failure]:
        following = remedy(attempt)
        if following is not None:
            attempt = following
            words.append(attempt.remedy)
    return words


def test_order_of_the_remedies():
    slopes = ["with alpha = 0.1", "with alpha = 0.033", "with alpha = 0.011"]
    room = ["with c0 = 1e-03", "from a cohesive start", "with beta = 0.3"]
    more = ["with c0 = 1e-02", "with beta = 0.15", "with solver highs-ipm"]
    less = ["with alpha = 0.0037", "with alpha = 0.0012", "with alpha = 0.00041"]
    assert series(Status.NO_STATE, FIRST) == [*slopes, *room, *more, *less]
    damped = ["with beta = 0.3", "with c0 = 1e-03", "with beta = 0.15", "from a cohesive start"]
    for failure in (Status.CYCLING, Status.ITERATION_LIMIT):
        assert series(failure, FIRST) == damped
    assert series(Doubt.INEXACT, FIRST) == [
        "from a cohesive start",
        "with beta = 0.3",
        "with c0 = 1e-03",
        "with solver highs-ipm",
    ]
    roomy = replace(FIRST, parameters=replace(FIRST.parameters, c0=1e-3))
    assert series(Doubt.INEXACT, roomy)[:3] == ["with c0 = 1e-04", "from a cohesive start", "with c0 = 1e-05"]
    assert series(Status.SOLVER_FAILED, FIRST) == [
        "with tolerance 1e-07",
        "with solver highs-ipm",
        "from a cohesive start",
    ]
    assert series(Status.LOCKED, FIRST) == ["from a cohesive start"]


def test_rough_sub_problems_are_first_solved_accurately():
    """What a rough run could not do proves little; and no rough answer ends early."""
    for failure in (Status.CYCLING, Status.SOLVER_FAILED, Doubt.ROUGH):
        assert series(failure, FAST)[0] == "with accurately solved sub-problems"
        accurate = REMEDIES[failure][0](FAST)
        assert accurate.parameters == replace(FAST.parameters, tolerance=None, early=False)
        assert REMEDIES[failure][0](FIRST) is None


#: A scene that each remedy rescues: the way the first run fails, the options, and the last remedy's words.
RESCUED = {
    "less slope": (ferris_tinloi(6), {"beta": 0.2}, Status.NO_STATE, "with alpha = 0.033"),
    "less damping": (
        TWO_PATHS,
        {"beta": 1.0, "finish": False, "alpha_min": 1e-4},
        Status.CYCLING,
        "with beta = 0.5",
    ),
    "cohesive start": (confined(0.5), {}, Status.LOCKED, "from a cohesive start"),
    "more cohesion": (STEPPED, {"solver": "highs-ipm"}, Status.NO_STATE, "with c0 = 1e-03"),
    "looser solver": (
        ferris_tinloi(6),
        {"model": "pyomo", "solver": "highs"},
        Status.SOLVER_FAILED,
        "with tolerance 1e-07",
    ),
    "another solver": (
        ferris_tinloi(1, friction=1e5),
        {},
        Status.SOLVER_FAILED,
        "with solver highs-ipm",
    ),
}


@pytest.mark.parametrize("name", RESCUED)
def test_each_remedy_rescues_a_scene(name):
    build, options, failure, words = RESCUED[name]
    scene = build(CASES)
    raw = mo.solve(scene, **(options | {"remedies": "none"}))
    assert raw.status is failure
    assert raw.load_factor is None
    assert "began again" not in raw.message
    result = mo.solve(scene, **options)
    assert result.status is Status.CONVERGED
    assert result.message.startswith(f"the first run ended '{failure}', so the loop began again ")
    assert f"{words}; " in result.message
    if not result.history.empty:
        last = result.history.iloc[-1]
        assert last["attempt"] > 1
        assert last["remedy"] == words
        assert (result.history.query("attempt == 1")["remedy"] == "").all()
    # μ = 1e5 costs solvers digits.
    assert result.load_factor <= associative(scene) * (1 + 1e-5)
    assert max(result.certificate.complementarity, result.certificate.flow) < 1e-3


def associative(scene):
    return mo.solve(scene, "static", solver="highs").load_factor or float("inf")


def test_slope_alone_is_tried_if_asked_for():
    result = mo.solve(STEPPED(CASES), solver="highs-ipm", remedies="slope")
    assert result.status is Status.NO_STATE
    assert set(result.history["remedy"][result.history["attempt"] > 1]) <= {
        f"with alpha = {0.3 / 3**step:.2g}" for step in range(1, 7)
    }
    cycling = mo.solve(TWO_PATHS(CASES), beta=1.0, finish=False, remedies="slope")
    assert cycling.status is Status.CYCLING
    assert (cycling.history["attempt"] == 1).all()


def test_what_was_tried_in_vain_is_said_and_each_entry_is_tried_once():
    result = mo.solve(WALL_6, max_iterations=2)
    assert result.status is Status.ITERATION_LIMIT
    assert result.load_factor is None
    tried = list(dict.fromkeys(result.history["remedy"]))[1:]
    assert tried == series(Status.ITERATION_LIMIT, FIRST)
    assert result.message.endswith(
        f"(the first run ended '{Status.ITERATION_LIMIT}', so the loop began again "
        f"{', then '.join(tried)}: in vain)"
    )
    assert result.lp_solves >= len(result.history) == 2 * (1 + len(tried))


def test_runs_are_limited(monkeypatch):
    monkeypatch.setattr(nonassociative, "_MOST_RUNS", 3)
    result = mo.solve(WALL_6, max_iterations=2)
    assert result.history["attempt"].max() == 3
    assert result.message.count("with ") == 2


def test_a_load_factor_without_an_exact_state_is_not_taken(monkeypatch):
    """Where λ stands still far from any exact state the loop goes on; if all is in vain it is given, with
    what its certificate leaves."""
    monkeypatch.setattr("masonry_opt.methods.loop.steps.exact_finish", lambda *_: (None, 1))
    monkeypatch.setattr("masonry_opt.methods.loop.steps._PATIENCE", 1)
    raw = mo.solve(WALL_6, tol=1e-3, finish=False)
    assert raw.certificate.complementarity > 1e-3
    result = mo.solve(WALL_6, tol=1e-3)
    assert result.status is Status.CONVERGED
    assert result.history["attempt"].max() > 1
    assert str(Doubt.INEXACT) in result.message


def test_a_cycle_with_an_exact_state_says_both():
    result = mo.solve(WALL_6, alpha=0.0, alpha_min=0.0, beta=1.0)
    assert result.status is Status.CONVERGED
    low, high = sorted(result.history["load_factor"].iloc[-2:])
    assert f"every 2 iterations, between load factors {low:.6g} and {high:.6g}" in result.message
    assert result.message.endswith("and this state is exact")
    assert max(result.certificate.equilibrium, result.certificate.yield_) < 1e-8
    assert result.certificate.complementarity < 1e-6
    # The exact state is near the swing, and not above it.
    assert low - 1e-3 < result.load_factor < high


def test_a_cycle_without_an_exact_state_says_what_of_it_is_certified():
    result = mo.solve(WALL_6, alpha=0.0, alpha_min=0.0, beta=1.0, finish=False, remedies="none")
    assert result.status is Status.CYCLING
    low, high = sorted(result.history["load_factor"].iloc[-2:])
    assert f"between load factors {low:.6g} and {high:.6g}" in result.message
    assert result.message.endswith("none of the load factors met is certified")


def test_the_lowest_certified_load_factor_of_a_loop_without_end_is_said():
    """Wall 4 comes to its load factor, but a tolerance beyond the solver's is never met."""
    wall_4 = CASES / "ferris_tinloi" / "wall_4.toml"
    result = mo.solve(wall_4, tol=1e-14, max_iterations=25, finish=False, remedies="none")
    assert result.status is Status.ITERATION_LIMIT
    assert result.load_factor is None
    low, high = (f"{end(result.history['load_factor'].iloc[-6:]):.6g}" for end in (min, max))
    assert f"of late between {low} and {high}" in result.message
    said = float(result.message.rpartition("the lowest certified load factor met is ")[2])
    assert said in {float(f"{value:.6g}") for value in result.history["load_factor"]}
    # Published MPEC; certified to 1e-3.
    assert said == pytest.approx(0.263736, rel=1e-3)

"""The time limit of an analysis: when methods end, and the answer and messages that they then return."""

import subprocess
import sys
import time
import warnings

import pytest
from scenes import CASES, block_on_floor, run_command, small_wall
from sources import ROOT

import masonry_opt as mo
from masonry_opt.deadline import TimeLimitReached, check_time, limited, seconds_left, unlimited
from masonry_opt.effort import Effort
from masonry_opt.errors import LongAnalysisWarning, OptionError, TimeLimitError
from masonry_opt.methods.exact.search import Search
from masonry_opt.methods.loop.run import Iteration
from masonry_opt.methods.mpec import CasadiIpopt, RelaxationStep
from masonry_opt.models.pyomo_mpec import PyomoMpec, PyomoRelaxed
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.reasons import Code

WALL = ROOT / "cases" / "ferris_tinloi" / "wall_1.toml"

#: A wall whose analysis takes minutes with every method.
LARGE = """
[joints]
friction = 0.65
[wall]
block = [0.25, 0.065]
courses = [{courses}]
repeat = 40
unit_weight = 18
live_per_weight = [1, 0]
""".format(courses=", ".join(str(row) for row in ([1] * 60, [0.5] + [1] * 59 + [0.5])))

#: Methods that check the time limit at the same places as the default.
METHODS = ("coulomb", "static", "kinematic", "nonassociative", "incremental")


def test_the_earlier_of_two_limits_applies():
    with limited(100.0):
        with limited(1000.0):
            assert 99.0 < seconds_left() <= 100.0
        with limited(1.0):
            assert seconds_left() <= 1.0
            with unlimited():
                assert seconds_left() == float("inf")
        assert seconds_left() > 99.0
    assert seconds_left() == float("inf")


def test_after_the_limit_the_next_phase_does_not_begin():
    with limited(1e-9), pytest.raises(TimeLimitReached, match="1e-09 s"):
        Effort().begins("further starts")
    check_time()


@pytest.mark.slow
@pytest.mark.parametrize(
    "method",
    METHODS,
)
def test_every_method_ends_soon_after_its_limit(method, tmp_path):
    """Every method ends within a minute with a time limit of 4 s on a wall of 4,860 blocks.

    Parts of a method that do not check the time, such as compiling, may take some seconds longer.
    """
    path = tmp_path / "large.toml"
    path.write_text(LARGE)
    began = time.perf_counter()
    result = mo.solve(path, method, time_limit=4.0)
    assert time.perf_counter() - began < 60
    assert result.status is mo.Status.TIME_LIMIT
    assert result.time_limit_reached
    assert result.load_factor is None
    assert result.as_dict()["time_limit_reached"] is True
    assert "the time limit of 4 s ended the analysis" in result.message


def test_the_lowest_state_by_then_is_the_answer(monkeypatch):
    """A search that the time limit stops in its fifth start returns the lowest exact state so far.

    The load factor is below that of the complementarity problem in Table 1 of the paper, 0.64285.
    """
    start = Search.start

    def stopped(search, q):
        if search.met.candidates == 4:
            raise TimeLimitReached(7.0)
        return start(search, q)

    monkeypatch.setattr(Search, "start", stopped)
    result = mo.solve(WALL, search=60.0)
    assert result.time_limit_reached
    assert result.usable
    assert result.exact
    assert 0.6 < result.load_factor < 0.64285
    assert result.reasons[0].code is Code.TIME_LIMIT
    assert "the time limit of 7 s ended" in result.summary


def test_a_limit_that_is_not_reached_changes_nothing():
    without, within = mo.solve(WALL), mo.solve(WALL, time_limit=500.0)
    assert within.load_factor == without.load_factor
    assert within.incremental == without.incremental
    assert within.associative == pytest.approx(without.associative, rel=1e-12)
    assert not within.time_limit_reached


@pytest.mark.parametrize("method", ["coulomb", "incremental", "nonassociative"])
def test_the_associative_load_factor_is_known_if_the_limit_ends_the_first_steps(method):
    """The load factor of Table 1 of the paper for associative flow is known although the method is not.

    The table of load factors labels it as an upper bound.
    """

    def stop(_):
        raise TimeLimitReached(500.0)

    result = mo.solve(WALL, method, time_limit=500.0, progress=stop)
    assert result.status is mo.Status.TIME_LIMIT
    assert result.time_limit_reached
    assert result.load_factor is None
    assert result.associative == pytest.approx(0.64286, abs=1e-5)
    assert result.as_dict()["associative"] == result.associative
    assert "other load factors λ\n  associative    0.642859   upper bound" in result.summary


@pytest.mark.parametrize("limit", [None, 500.0])
def test_the_associative_load_factor_comes_first_only_with_a_limit(limit):
    phases = []
    mo.solve(WALL, descent=False, time_limit=limit, phases=phases.append)
    associative = [number for number, phase in enumerate(phases) if "associative load factor" in phase]
    history = [number for number, phase in enumerate(phases) if "incremental analysis" in phase]
    assert len(associative) == 1
    assert (associative < history) == (limit is not None)


def test_no_load_factor_is_known_if_the_limit_ends_the_associative_program(monkeypatch):
    def stop(_):
        raise TimeLimitReached(500.0)

    monkeypatch.setattr("masonry_opt.methods.associative._by_simplex", stop)
    result = mo.solve(WALL, time_limit=500.0)
    assert result.status is mo.Status.TIME_LIMIT
    assert result.associative is None
    assert "(in step: associative load factor)" in result.message


def test_a_load_above_the_associative_load_factor_is_not_carried(monkeypatch):
    """A search for the least friction is decided although the limit ends each run below this friction.

    The block slides at λ = μ, so that λ = 0.3 needs a friction of 0.3.
    """

    def stop(_, assembly, *__):
        if assembly.problem.friction.max() < 0.3:
            raise TimeLimitReached(500.0)

    monkeypatch.setattr("masonry_opt.analysis.Session._solve_incremental", stop)
    found = mo.least(lambda mu: block_on_floor(friction=mu), 0.05, 1, load=0.3, samples=2, time_limit=500.0)
    assert found.value == pytest.approx(0.3, rel=1e-6)
    assert found.fails.result.status is mo.Status.TIME_LIMIT
    assert found.fails.number == found.fails.result.associative < 0.3


def test_the_command_prints_the_associative_load_factor_with_exit_code_1(monkeypatch, capsys):
    def stop(*_):
        raise TimeLimitReached(500.0)

    monkeypatch.setattr("masonry_opt.analysis.Session._solve_incremental", stop)
    code, printed, _ = run_command(monkeypatch, capsys, "solve", WALL, "--time-limit", "500")
    assert code == 1
    assert "stopped by the time limit" in printed
    assert "associative    0.642859   upper bound" in printed


@pytest.mark.parametrize("limit", [0, -1.0, float("inf"), float("nan"), "20", True])
def test_a_wrong_limit_is_refused(limit):
    with pytest.raises(OptionError, match="time_limit must be a number of seconds above 0"):
        mo.solve(WALL, time_limit=limit)


@pytest.mark.slow
def test_a_limit_that_is_over_at_once_is_an_error_of_the_package():
    """A time limit that is over at once raises TimeLimitError; users never see a KeyboardInterrupt."""
    with pytest.raises(TimeLimitError, match="use a longer time limit"):
        mo.solve(WALL, time_limit=1e-9)


@pytest.mark.slow
def test_the_command_reports_progress_and_ends_with_exit_code_1(tmp_path):
    path = tmp_path / "large.toml"
    path.write_text(LARGE)
    program = "from masonry_opt.cli.app import main; main()"
    command = [sys.executable, "-c", program, "solve", str(path), "--time-limit", "12"]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert ran.returncode == 1
    assert "stopped by the time limit" in ran.stdout
    assert "10 s: large.toml: " in ran.stderr


def test_a_long_analysis_is_announced_before_it_begins(monkeypatch):
    """A warning announces that the default will take many minutes on a scene with many joints.

    Methods of classical limit analysis, and analyses with a time limit, give no warning.
    """
    monkeypatch.setattr("masonry_opt.methods.running._MOST_JOINTS_IN_MINUTES", 80)

    with pytest.warns(LongAnalysisWarning, match="83 joints.*'coulomb' will take many minutes.*'static'"):
        mo.solve(WALL, descent=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mo.solve(WALL, "static")
        mo.solve(WALL, time_limit=500.0, descent=False)


@pytest.mark.slow
@pytest.mark.parametrize(("method", "phase"), [("nonassociative", "sub-problem 3"), ("mpec", "relaxation")])
def test_a_step_is_not_the_answer_if_the_time_is_over(method, phase):
    """If the time is over after the third step of the loop or of the relaxation, the step is no answer.

    The message states the load factor of this step.
    """
    record = RelaxationStep if method == "mpec" else Iteration
    steps = []

    def stop(step):
        steps.extend([step] * isinstance(step, record))
        if len(steps) == 3:
            raise TimeLimitReached(7.0)

    result = mo.solve(WALL, method, incremental=False, progress=stop)
    assert result.status is mo.Status.TIME_LIMIT
    assert result.time_limit_reached
    assert result.load_factor is None
    assert f"the time limit of 7 s ended the analysis (in step: {phase}" in result.message
    assert f"λ = {steps[-1].load_factor:.6g}, an intermediate value, not a result" in result.message


def test_ipopt_ends_at_the_time_limit():
    """An IPOPT solver that is compiled after the time limit ends with TimeLimitReached.

    IPOPT refuses a time limit of zero, so the solver receives a small positive limit.
    """
    model = PyomoRelaxed(PyomoMpec(assemble(block_on_floor()).problem))
    with limited(1e-9):
        ipopt = CasadiIpopt(model)
        with pytest.raises(TimeLimitReached):
            ipopt.solve(1e-3)


def test_a_bracket_has_no_answer_if_no_state_is_known_by_then(monkeypatch):
    """Method "global" has no answer if its first start of the search takes longer than the time limit."""

    def waits(*_):
        time.sleep(1.0)
        check_time()

    monkeypatch.setattr(Search, "start", waits)
    result = mo.solve(small_wall(2, 2), "global", incremental=False, time_limit=1.0)
    assert result.status is mo.Status.TIME_LIMIT
    assert result.time_limit_reached
    assert result.load_factor is None
    assert "the time limit of 1 s ended the analysis" in result.message


@pytest.mark.parametrize(
    "arguments",
    [("directions",), ("settle", "--support", "support", "--direction", "0,-1"), ("capacity",)],
    ids=lambda arguments: arguments[0],
)
def test_a_study_that_the_limit_ends_has_exit_code_1(arguments, monkeypatch, capsys):
    command, *options = arguments
    case = CASES / "gilbert" / "two_blocks.toml"
    code, printed, errors = run_command(monkeypatch, capsys, command, case, *options, "--time-limit", "1e-6")
    assert code == 1
    assert "two_blocks.toml" in printed + errors
    assert "time limit" in printed + errors

"""A comparison from the command line to its report: interruption, continuation, limits and the page."""

import re
from functools import partial

import pytest
from scenes import CASES, two_blocks
from typer.testing import CliRunner

import masonry_opt as mo
from masonry_opt.cli.app import app
from masonry_opt.studies.compare import comparison
from masonry_opt.studies.compare.comparison import compare, run_plan, write_report
from masonry_opt.studies.compare.judge import FAILED
from masonry_opt.studies.compare.page import charts, page
from masonry_opt.studies.compare.runs import RunLimits, find_scenes, plan
from masonry_opt.studies.runner import CRASHED, DIED, FINISHED, TIME_LIMIT, TaskEnd
from masonry_opt.studies.writing import JOURNAL

TWO_BLOCKS = CASES / "gilbert" / "two_blocks.toml"
PLAN = plan(["static"], ["cvxpy"], ["clarabel", "highs"], [1e-4, 1e-8])
LIMITS = RunLimits(time=30, memory=4000, repeats=1)

VALUE = {
    "status": "optimal",
    "kind": "associative",
    "load_factor": 0.25,
    "load_factor_unit": 1.0,
    "wall": 0.5,
    "scene_seconds": 0.1,
    "blocks": 2,
    "joints": 3,
    **dict.fromkeys(("equilibrium", "yield", "flow", "complementarity"), 0.0),
}
#: Modules that draw charts.
CHARTING = ("studies.charts", "studies.compare.page")

BOUNDS = TaskEnd(FINISHED, value={"lower": 0.25, "upper": 0.25})


class Machine:
    """Replaces the processes of runs: records the runs, and raises an interrupt before run ``stop``."""

    def __init__(self, stop: int | None = None, end: TaskEnd | None = None) -> None:
        self.runs, self.stop = [], stop
        self.end = end or TaskEnd(FINISHED, value=VALUE, seconds=0.6, peak=100.0)

    def __call__(self, task, time_limit, memory_limit):
        if task.func is comparison.runs.bound_scene:
            return BOUNDS
        if len(self.runs) == self.stop:
            raise KeyboardInterrupt
        self.runs.append(task.args[1])
        return self.end


@pytest.fixture
def runs_by(monkeypatch):
    """Return a function that replaces ``run_alone``, which starts the processes of runs."""
    return partial(monkeypatch.setattr, comparison, "run_alone")


def run(folder, runs_by, *, case=TWO_BLOCKS, limits=LIMITS, **machine):
    made = Machine(**machine)
    runs_by(made)
    return made, run_plan(find_scenes([case]), PLAN, limits, folder, lambda _: None)


def test_an_interrupted_comparison_reports_and_continues(tmp_path, runs_by):
    machine, first = run(tmp_path, runs_by, stop=3)
    assert (len(machine.runs), len(first.summary), first.interrupted) == (3, 3, True)
    assert "interrupted" in str(first)
    machine, second = run(tmp_path, runs_by)
    assert machine.runs == [PLAN.pairs[3]]
    assert (len(second.summary), second.interrupted) == (4, False)
    machine, _ = run(tmp_path, runs_by)
    assert machine.runs == []


def test_repeats_come_last(tmp_path, runs_by):
    machine, _ = run(tmp_path, runs_by, limits=RunLimits(time=30, memory=4000, repeats=2))
    assert machine.runs == [*PLAN.pairs] * 2


def test_a_changed_scene_is_run_again(tmp_path, runs_by):
    case = tmp_path / "made" / "up.toml"
    case.parent.mkdir()
    for friction, runs in ((0.1, 4), (0.1, 0), (0.2, 4)):
        mo.save(two_blocks(friction), case)
        machine, _ = run(tmp_path, runs_by, case=case)
        assert len(machine.runs) == runs


def test_a_raised_limit_runs_again_what_it_killed(tmp_path, runs_by):
    killed = TaskEnd(TIME_LIMIT, "over 30 s", seconds=30.0, peak=100.0)
    _, result = run(tmp_path, runs_by, end=killed)
    assert set(result.summary["reason"]) == {"time limit: over 30 s"}
    assert charts(result.summary) == []  # failures alone have no accuracy
    machine, _ = run(tmp_path, runs_by)
    assert machine.runs == []
    machine, _ = run(tmp_path, runs_by, limits=RunLimits(time=60, memory=4000, repeats=1))
    assert len(machine.runs) == 4


def test_a_run_that_died_is_made_again(tmp_path, runs_by):
    """A run whose process was killed is repeated, because the cause may be elsewhere; a crash is not."""
    for how, again in ((DIED, 4), (CRASHED, 0)):
        run(tmp_path / how, runs_by, end=TaskEnd(how))
        machine, _ = run(tmp_path / how, runs_by)
        assert len(machine.runs) == again


def test_a_comparison_without_any_result_says_why_and_fails(tmp_path, runs_by, without):
    def crash(task, *limits):
        reason = "" if task.func is comparison.runs.bound_scene else f"of\n{task.args[1].solver}"
        return TaskEnd(CRASHED, reason)

    without("altair", *CHARTING)
    runs_by(crash)
    arguments = [str(TWO_BLOCKS), "--methods", "static", "--solvers", "clarabel,highs"]
    arguments += ["--tolerances", "1e-9", "--repeats", "1", "--out", str(tmp_path)]
    result = CliRunner().invoke(app, ["compare", *arguments])
    assert isinstance(result.exception, mo.MasonryError)
    assert result.exception.exit_code == 1
    assert "crashed: of highs" in str(result.exception)  # two of the three runs used HiGHS
    assert "\n" not in str(result.exception)
    assert (tmp_path / "summary.csv").exists()


def test_the_python_function_returns_what_it_judged(tmp_path, runs_by, without):
    without("altair", *CHARTING)
    runs_by(Machine())
    asked = {"methods": ["static"], "solvers": ["highs"], "tolerances": [1e-9]}
    found = compare(["two_blocks"], **asked, repeats=1, out=tmp_path, cases=CASES)
    assert list(found.summary["load_factor"]) == [0.25, 0.25]  # one run in CVXPY, one in Pyomo
    assert (tmp_path / "summary.csv").exists()
    with pytest.raises(mo.OptionError):
        compare(["two_blocks"], repeats=0, out=tmp_path, cases=CASES)


def test_a_folder_of_something_else_is_refused(tmp_path, runs_by):
    (tmp_path / JOURNAL).write_text('{"study": "another"}\n')
    with pytest.raises(mo.OptionError, match="another folder"):
        run(tmp_path, runs_by)


@pytest.mark.slow
def test_the_page_works_offline_and_escapes_what_cases_say(tmp_path, runs_by):
    evil = "<script>alert(1)</script><img src=x onerror=alert(2)>"
    case = tmp_path / "a<b>" / "c<i>.toml"
    case.parent.mkdir()
    mo.save(two_blocks(), case)
    _, result = run(tmp_path, runs_by, case=case)
    result.summary.loc[0, ["verdict", "reason", "message"]] = [FAILED, f"crashed: {evil}", evil]
    html = page(result, charts(result.summary))
    assert "alert(1)" in html
    for part in ("<script>alert", "<img src=x", "a<b>", "c<i>"):
        assert part not in html
    tags = r'<(?:script|link|img|iframe)[^>]*(?:src|href)\s*=\s*["\']?(?:https?:)?//[^>]*'
    assert re.findall(tags, html) == []
    assert html.count("<script") == 3  # the drawing library, the charts, and the tables


@pytest.mark.parametrize("missing", [None, "altair", "vl_convert"])
def test_report_files(tmp_path, runs_by, without, missing):
    """The report writes tables without an extra, and charts only if both drawing libraries are installed."""
    if missing:
        without(missing, *CHARTING)
    _, result = run(tmp_path, runs_by)
    names = {path.name for path in write_report(result, tmp_path)}
    charted = {"report.html", "time_error_associative.png", "time_error_associative.svg"}
    assert names == {"results.csv", "summary.csv"} | (set() if missing else charted)
    assert all((tmp_path / name).stat().st_size > 100 for name in names)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.toml"], "no such file"),
        (["nowhere"], "no case file in cases/ has this name"),
        ([], "name case files"),
        ([str(TWO_BLOCKS), "--tolerances", "small"], "numbers separated by commas"),
        ([str(TWO_BLOCKS), "--solvers", "nix"], "solver 'nix' is unknown"),
    ],
)
def test_wrong_arguments_are_one_clear_error(arguments, message):
    result = CliRunner().invoke(app, ["compare", *arguments])
    assert isinstance(result.exception, mo.MasonryError)
    assert message in str(result.exception)

"""Tests of warnings: on standard error and in JSON, in studies without a solved run, and of damaged
journals."""

import json
import pickle
from contextlib import redirect_stderr

import numpy as np
import pandas as pd
import pytest
from many.tables import same, sampled
from scenes import axles_on_a_beam, block_on_floor
from screens import Screen

import masonry_opt as mo
from masonry_opt.errors import NoLoadFactorError, NoRunSolvedError
from masonry_opt.studies.many.run_warnings import recorded_warnings, warnings_of_rows
from masonry_opt.studies.writing import JOURNAL, Journal, run_line

#: Warning about a friction coefficient of 31, which would be 0.601 if 31 were meant in degrees.
IN_DEGREES = (
    "the friction coefficient 31 of [joints] is higher than in dry joints of masonry: is it in degrees? "
    "tan 31° = 0.601"
)
#: The record of this warning in JSON.
RECORD = {"sentence": IN_DEGREES, "code": "friction high", "friction": 31.0, "pairs": []}
STATIC = ("--method", "static")
SAMPLED = ("--sample", "joints.friction=uniform:0.3:0.4", "-n", "2")


@pytest.fixture
def doubtful(tmp_path):
    """Return a folder of case files whose friction was written in degrees: a pushed block, and a beam with
    axles."""
    mo.save(block_on_floor(friction=31), tmp_path / "block.toml")
    mo.save(axles_on_a_beam(31), tmp_path / "axles.toml")
    return tmp_path


COMMANDS = {
    "solve": ("block.toml",),
    "capacity": ("block.toml",),
    "directions": ("block.toml",),
    "settle": ("block.toml", "--support", "floor", "--direction", "0,-1"),
    "least": ("block.toml", "--most", "--vary", "block.A.live.x=0.1:2", "--load", "1", "--samples", "0"),
    "crossing": ("axles.toml",),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_says_what_looks_unintended(doubtful, command, name):
    case, *options = COMMANDS[name]
    asked = (name, doubtful / case, *options, *STATIC)
    for more in ((), ("--json",)):
        assert command.warned(*asked, *more) == [IN_DEGREES]
    assert RECORD in command.json(*asked)["warnings"]


def test_a_search_without_a_threshold_says_what_looks_unintended(doubtful, command):
    """The friction, written in degrees, may be the reason why the block carries the load at both ends."""
    asked = ("--vary", "block.A.weight=10:20", "--load", "0.1", "--samples", "0", *STATIC)
    error = command.refused("least", doubtful / "block.toml", *asked)
    assert error.startswith(f"warning: {IN_DEGREES}\nerror: no threshold was found")
    assert error.count("warning: ") == 1
    with pytest.raises(mo.OptionError, match="no threshold was found") as caught:
        mo.least(lambda weight: block_on_floor(friction=31), 10, 20, load=0.1, samples=0, method="static")
    assert caught.value.warnings == (IN_DEGREES,)
    assert str(caught.value) == f"{caught.value.message}; warning: {IN_DEGREES}"


@pytest.mark.parametrize("asked", [("solve", "--quiet"), ("capacity",), ("check",)])
def test_a_command_without_a_load_factor_says_what_looks_unintended(tmp_path, command, asked):
    """The live load presses the block down, so that no multiple of it is too large."""
    name, *options = asked
    case = tmp_path / "pressed.toml"
    mo.save(block_on_floor(friction=31, live=(0, -1)), case)
    error = command.refused(name, case, *options, code=1)
    assert error.startswith(f"warning: {IN_DEGREES}\nerror: {case}: unlimited")
    assert error.count("warning: ") == 1


def test_an_error_of_a_worker_process_keeps_its_warnings():
    error = NoLoadFactorError("no load factor", [IN_DEGREES, IN_DEGREES])
    copy = pickle.loads(pickle.dumps(error))
    assert (str(copy), copy.message, copy.warnings) == (str(error), "no load factor", (IN_DEGREES,))


def test_warnings_are_yellow_on_a_terminal_and_whole_in_a_pipe(doubtful, command, terminal):
    with redirect_stderr(Screen(terminal=True)) as screen:
        command("solve", doubtful / "block.toml", *STATIC)
    assert f"33mwarning: {IN_DEGREES}" in screen.getvalue()
    long = [*STATIC, "--verbose"]
    assert command.warned("solve", doubtful / "block.toml", *long) == [IN_DEGREES]


def test_commands_that_do_not_solve_warn_on_standard_error(doubtful, command):
    assert command.warned("draw", doubtful / "block.toml", doubtful / "block.svg") == [IN_DEGREES]
    assert command.warned("export", doubtful / "block.toml", doubtful / "block.lp") == [IN_DEGREES]
    mo.save(mo.extrude(block_on_floor(friction=31), 1.0), doubtful / "solid.toml")
    asked = ("export", doubtful / "solid.toml", doubtful / "solid.obj", *STATIC)
    assert command.warned(*asked) == [IN_DEGREES]
    assert command.warned("check", doubtful / "block.toml") == [IN_DEGREES]


def test_convert_warns_as_draw_does(doubtful, command):
    drawing, case = doubtful / "block.dxf", doubtful / "drawn.toml"
    assert command.warned("convert", doubtful / "block.toml", drawing) == [IN_DEGREES]
    properties = ("--friction", "31", "--unit-weight", "2", "--live", "1,0")
    assert command.warned("convert", drawing, case, *properties) == [IN_DEGREES]
    assert command.warned("draw", case, doubtful / "drawn.svg") == [IN_DEGREES]


def test_shapes_of_a_scene_that_cannot_be_solved_are_written_with_a_warning(tmp_path, command):
    """In one scene two blocks overlap, and in the other scene, a block floats 1 above the other block."""
    scene = block_on_floor()
    block = next(block for block in scene.blocks if not block.fixed)
    for name, rise in (("overlapping", 0.5), ("floating", 3.0)):
        vertices = [(x, y + rise) for x, y in block.vertices]
        changed = scene.replace(blocks=[*scene.blocks, mo.Block(name="B", vertices=vertices, weight=1)])
        mo.save(changed, tmp_path / f"{name}.toml")
        mo.save(mo.extrude(changed, 1.0), tmp_path / f"{name}_solid.toml")
        for case, out in ((name, "dxf"), (f"{name}_solid", "obj")):
            verb = "convert" if out == "dxf" else "export"
            (sentence,) = command.warned(verb, tmp_path / f"{case}.toml", tmp_path / f"{name}.{out}")
            assert "overlap" in sentence if name == "overlapping" else "touches no other block" in sentence
            assert (tmp_path / f"{name}.{out}").exists()


def test_commands_without_analysis_do_not_say_that_axles_are_ignored(tmp_path, command):
    case = tmp_path / "axles.toml"
    mo.save(axles_on_a_beam(0.5), case)
    assert command.warned("draw", case, tmp_path / "axles.svg") == []
    assert command.warned("convert", case, tmp_path / "axles.dxf") == []


@pytest.mark.slow
def test_a_report_says_what_looks_unintended(doubtful, command):
    page = doubtful / "report.html"
    for case in ("block.toml", "axles.toml"):
        assert command.warned("report", doubtful / case, *STATIC, "--out", page) == [IN_DEGREES]
        assert IN_DEGREES in page.read_text("utf-8")


def test_a_page_of_a_study_says_what_looks_unintended(doubtful):
    found = mo.settle(doubtful / "block.toml", "floor", (0, -1), method="static")
    found.save(doubtful / "settle.html")
    assert f"warning: {IN_DEGREES}" in (doubtful / "settle.html").read_text("utf-8")


@pytest.mark.usefixtures("without_charts")
def test_a_sweep_says_what_looks_unintended_and_where(doubtful, command):
    asked = (doubtful / "block.toml", *STATIC, "--workers", "1", "--vary")
    sentences = command.warned("sweep", *asked, "joints.friction=0.3,31,40", "--out", doubtful / "friction")
    assert sentences == [f"{IN_DEGREES} (at joints.friction = 31 and 1 more run)"]
    # All runs have this warning: it is printed once, without a place.
    sentences = command.warned("sweep", *asked, "block.A.live.x=1,2", "--out", doubtful / "live")
    assert sentences == [IN_DEGREES]


@pytest.mark.usefixtures("without_charts")
def test_a_sample_says_what_looks_unintended(doubtful, command):
    asked = ("--sample", "block.A.live.x=uniform:1:2", "-n", "2", *STATIC, "--workers", "1")
    sentences = command.warned("sweep", doubtful / "block.toml", *asked, "--out", doubtful / "out")
    assert sentences == [IN_DEGREES]
    drawn = {"block.A.live.x": ("uniform", 1.0, 2.0)}
    found = mo.sample(doubtful / "block.toml", drawn, n=2, method="static", workers=1)
    assert found.as_dict()["warnings"] == [RECORD | {"runs": 2}]
    assert found.table["warnings"].tolist() == [IN_DEGREES] * 2


def test_each_code_is_told_once():
    high, low = mo.solve(block_on_floor(friction=31), "static"), mo.solve(block_on_floor(), "static")
    rows = [recorded_warnings(result.warning_records) for result in (low, high, high)]
    points = [{"x": float(number)} for number in range(3)]
    first, everywhere = warnings_of_rows(rows, points), warnings_of_rows(rows[1:], points[1:])
    assert [record["sentence"] for record in first] == [f"{IN_DEGREES} (at x = 1 and 1 more run)"]
    assert [record["sentence"] for record in everywhere] == [IN_DEGREES]
    assert [*warnings_of_rows(rows[:1], points[:1])] == []


def test_a_load_factor_that_falls_with_the_strength_drawn_is_told():
    """A sample of 20 runs warns if the load factor falls as friction grows.

    There is no warning for a thickness, for a rising load factor, or for a method of statics.
    """
    friction = pd.DataFrame({"joints.friction": np.linspace(0.3, 0.6, 20)})
    falling = np.linspace(2.0, 1.0, 20)
    (sentence,) = sampled(falling, friction).warning_sentences
    assert sentence.startswith("the load factor falls as joints.friction grows (rank correlation -1.000)")
    by_statics = sampled(falling, friction)
    by_statics.table.attrs["method"] = "static"
    assert by_statics.warning_sentences == ()
    assert sampled(falling[::-1], friction).warning_sentences == ()
    assert sampled(falling, friction.rename(columns={"joints.friction": "thickness"})).warning_sentences == ()


def through_the_beam():
    return axles_on_a_beam(0.6).replace(axles={"cart": {"road": [(-1, 0.5), (1, 0.5)]}})


@pytest.mark.usefixtures("without_charts")
@pytest.mark.parametrize("asked", [("--vary", "joints.friction=0.3,0.4"), SAMPLED])
def test_a_study_of_which_nothing_was_solved_says_why(doubtful, command, asked):
    """A road through the beam cannot be crossed: both runs are refused, and the error states the reason."""
    out = doubtful / "out"
    mo.save(through_the_beam(), doubtful / "low.toml")
    error = command.refused("sweep", doubtful / "low.toml", *asked, "--workers", "1", "--out", out, code=1)
    assert "no run was solved: status 'refused' in 2 of 2 runs:" in error
    assert "the road of axles 'cart'" in error
    assert len(error.strip().splitlines()) == 1
    assert not out.exists()


def test_runs_refused_for_reasons_with_different_values_are_counted_together():
    """Each run has a reason of its own, which names its value: the error counts all runs."""
    with pytest.raises(NoRunSolvedError, match=r"in 3 of 3 runs: for example joints\.friction = -"):
        mo.sweep(block_on_floor(), {"joints.friction": [-1, -2, -3]}, method="static", workers=1)


@pytest.mark.usefixtures("without_charts")
def test_a_folder_stays_as_it_was_if_no_run_is_solved(doubtful, command):
    """If all runs of a second study are refused, the journal of two runs and their table do not change."""
    out, case = doubtful / "out", doubtful / "block.toml"
    asked = ("sweep", case, *STATIC, "--workers", "1", "--out", out, "--force", "--vary")
    command(*asked, "joints.friction=0.3,0.4")
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    assert "no run was solved" in command.refused(*asked, "joints.friction=-1,-2", code=1)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_a_study_that_ends_before_its_first_run_leaves_nothing(tmp_path):
    def scene(friction):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        mo.sweep(scene, {"friction": [0.1]}, method="static", workers=1, out=tmp_path / "new" / "out")
    assert not (tmp_path / "new").exists()


def test_a_study_in_python_of_which_nothing_was_solved_raises():
    with pytest.raises(NoRunSolvedError, match="the road of axles 'cart'"):
        mo.sweep(through_the_beam(), {"joints.friction": [0.3, 0.4]}, method="static", workers=1)


def test_axles_are_not_compared(doubtful, command):
    """No method has a load factor for moving axles: the command refuses, and names the command to use."""
    error = command.refused("compare", doubtful / "axles.toml", "--out", doubtful / "out")
    assert "use 'crossing'" in error
    assert not (doubtful / "out").exists()


@pytest.mark.usefixtures("without_charts")
def test_a_damaged_line_of_a_journal_is_named_and_its_run_made_again(tmp_path, command):
    """A journal line that is not JSON, not text, incomplete or edited by hand is named in a warning.

    The run of the line is repeated.
    """
    mo.save(block_on_floor(), tmp_path / "block.toml")
    out = tmp_path / "out"
    asked = ("sweep", tmp_path / "block.toml", *STATIC, "--workers", "1", "--out", out)
    command(*asked, "--vary", "joints.friction=0.2,0.3,0.4,0.5,0.6")
    before = pd.read_csv(out / "runs.csv")
    path = out / JOURNAL
    lines = path.read_bytes().splitlines()
    lines[2], lines[3], lines[4] = lines[2][: len(lines[2]) // 2], b"\xff\xfe", b'{"key": "a"}'
    lines[5] = lines[5].replace(b"0.6", b'"x"')
    path.write_bytes(b"\n".join(lines) + b"\n")
    warned = command.warned(*asked, "--vary", "joints.friction=0.2,0.3,0.4,0.5,0.6")
    named = [line.removeprefix(f"{path}: ").partition(" is damaged")[0] for line in warned]
    assert named == ["line 3", "line 4", "line 5", "line 6"]
    assert len(path.read_bytes().splitlines()) == 6 + 4  # Four runs were repeated, and one was reused.
    same(pd.read_csv(out / "runs.csv"), before)


@pytest.mark.slow
@pytest.mark.parametrize(("limit", "load_factor"), [(5.0, 9.0), (50.0, 0.2)])
def test_a_run_that_the_time_limit_ended_is_repeated_with_a_longer_limit(tmp_path, limit, load_factor):
    """The journal says that a limit of 5 s ended the run with λ = 9. With more time λ = μ = 0.2."""

    def sweep(seconds):
        options = {"method": "static", "workers": 1, "out": tmp_path, "time_limit": seconds}
        return mo.sweep(block_on_floor(), {"joints.friction": [0.2]}, **options)

    sweep(5.0)
    path = tmp_path / JOURNAL
    head, run = path.read_text("utf-8").splitlines()
    line = json.loads(run)
    line["row"] |= {"load_factor": 9.0, "time_limit_reached": True, "time_limit": 5.0}
    path.write_bytes(f"{head}\n".encode() + run_line(line["key"], line["row"]))
    assert sweep(limit)["load_factor"].tolist() == pytest.approx([load_factor])


def test_a_journal_without_its_first_line_is_refused(tmp_path):
    Journal(tmp_path, {"scene": "a"}).add("key", {"x": 1})
    (tmp_path / JOURNAL).write_text('damaged\n{"key": "key", "row": {"x": 1}}\n', "utf-8")
    with pytest.raises(mo.OptionError, match="not a journal of runs"):
        Journal(tmp_path, {"scene": "a"})

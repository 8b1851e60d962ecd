"""Tests of the table of a sweep: closed forms, order, failing runs, interruptions, lost workers and its
folder."""

import pickle
from functools import partial

import hogs
import pandas as pd
import pytest
from many.tables import same
from pydantic import BaseModel
from scenes import CASES, block_on_floor

import masonry_opt as mo
from masonry_opt.files import RECORD
from masonry_opt.methods.registry import HowToSolve
from masonry_opt.studies.many.parameters import Parameters
from masonry_opt.studies.many.runs import Study, row, run_many, run_scene
from masonry_opt.studies.many.sweep import grid, summary_text
from masonry_opt.studies.run_columns import RUN_COLUMNS
from masonry_opt.studies.runner import Workers
from masonry_opt.studies.writing import JOURNAL

FRICTIONS = [0.2, 0.3, 0.45, 0.6, 0.8]
VARY = {"joints.friction": FRICTIONS, "block.A.live.x": [1.0, 2.0]}
SERIAL = {"method": "static", "workers": 1}


def sweep(vary=VARY, **keys):
    return mo.sweep(block_on_floor(), vary, **({"method": "static", "workers": 1} | keys))


@pytest.fixture(scope="module")
def swept():
    return sweep()


def test_load_factors_are_those_by_hand(swept):
    """A block twice as high as wide slides at μ and overturns at 0.5, each divided by the live load."""
    assert list(swept) == [*VARY, *RUN_COLUMNS]
    assert swept["joints.friction"].tolist() == [mu for mu in FRICTIONS for _ in range(2)]
    assert swept["block.A.live.x"].tolist() == [1.0, 2.0] * 5
    by_hand = swept["joints.friction"].clip(upper=0.5) / swept["block.A.live.x"]
    assert swept["load_factor"].to_numpy() == pytest.approx(by_hand.to_numpy(), abs=1e-8)
    assert swept["mechanism"].tolist() == ["sliding"] * 6 + ["hinging"] * 4
    assert swept[["slides", "hinges"]].to_numpy().tolist() == [[1, 0]] * 6 + [[0, 1]] * 4
    assert (swept["status"] == "optimal").all()
    assert swept[["equilibrium", "yield", "flow", "complementarity"]].max(axis=None) < 1e-6


def test_the_incremental_load_factor_is_a_column(swept):
    """The incremental load factor of a single block is its load factor; associative methods have none."""
    assert swept["incremental"].isna().all()
    friction = {"joints.friction": [0.3]}
    computed_table, off = (
        sweep(friction, method="coulomb", incremental=computed) for computed in (True, False)
    )
    assert computed_table["incremental"].tolist() == pytest.approx([0.3], rel=1e-6)
    assert off["incremental"].isna().all()
    # Method "coulomb" begins with the load history in any case, so that only two columns differ.
    differ = ["incremental", "message"]
    same(off.drop(columns=differ), computed_table.drop(columns=differ))


def test_order_and_workers_change_nothing(swept):
    same(sweep(workers=2), swept)
    points = grid(VARY)[::-1]
    make = Parameters(block_on_floor()).at
    frame = run_many(Study(HowToSolve("static"), make), points, by=(2, None))
    same(frame[::-1].reset_index(drop=True), swept)


@pytest.mark.usefixtures("without_charts")
def test_an_interrupted_sweep_goes_on(swept, tmp_path):
    def interrupt(done, of):
        if done == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(out=tmp_path, progress=interrupt)
    kept = tmp_path / JOURNAL
    assert len(kept.read_text().splitlines()) == 1 + 4
    assert not (tmp_path / "runs.csv").exists()
    with kept.open("a") as stream:
        stream.write('{"key": "torn')  # The line is torn, as after a power failure.
    same(sweep(out=tmp_path), swept)
    assert len(kept.read_text().splitlines()) == 1 + 10
    before = kept.read_text()
    same(sweep(out=tmp_path), swept)
    assert kept.read_text() == before  # No run was repeated.
    numbers = ("load_factor", "incremental", "spread_lower", "spread_upper", "states")
    empty = {name: [""] for name in numbers}
    written = pd.read_csv(tmp_path / "runs.csv", keep_default_na=False, na_values=empty)
    same(written.astype(swept.dtypes.to_dict()), swept)


@pytest.mark.usefixtures("without_charts")
def test_a_folder_of_something_else_is_refused(tmp_path):
    vary = {"joints.friction": [0.3]}
    sweep(vary, out=tmp_path)
    # Tables need no optional package.
    assert {path.name for path in tmp_path.iterdir()} == {"runs.csv", JOURNAL, RECORD}
    for changed in ({"method": "kinematic"}, {"solver": "highs"}):
        with pytest.raises(mo.OptionError, match="other method"):
            sweep(vary, out=tmp_path, **changed)
    with pytest.raises(mo.OptionError, match="other scene"):
        mo.sweep(block_on_floor(width=1.1), vary, method="static", workers=1, out=tmp_path)


@pytest.mark.usefixtures("without_charts")
def test_what_may_end_otherwise_is_made_again(tmp_path):
    """A crash, such as one for lack of memory, is not recorded, so that its run is repeated; a refusal is
    recorded."""

    def made(friction):
        scene = block_on_floor(live=(friction, 0.0))
        return BaseModel.model_copy(scene, update={"joints": None}) if friction == 0.1 else scene

    frame = mo.sweep(made, {"friction": [0.0, 0.1, 0.2]}, method="static", workers=1, out=tmp_path)
    assert frame["status"].tolist() == ["refused", "crashed", "optimal"]
    assert len((tmp_path / JOURNAL).read_text().splitlines()) == 1 + 2


def test_an_error_of_a_function_keeps_the_runs_before(tmp_path):
    def breaks(friction):
        return block_on_floor(friction=1 / (0.4 - friction) - 2)

    with pytest.raises(ZeroDivisionError):
        mo.sweep(breaks, {"friction": [0.0, 0.1, 0.4, 0.2]}, method="static", workers=1, out=tmp_path)
    assert len((tmp_path / JOURNAL).read_text().splitlines()) == 1 + 2


def test_runs_that_fail_are_rows():
    frame = mo.sweep(block_on_floor(dead=(0.3, 0.0)), {"joints.friction": [0.2, 0.5, -1.0]}, **SERIAL)
    assert frame["status"].tolist() == ["unstable under dead load", "optimal", "refused"]
    assert frame["reason"].tolist()[0] == "falls"
    assert frame["load_factor"].isna().tolist() == [True, False, True]
    assert frame["load_factor"][1] == pytest.approx(0.2, abs=1e-8)


@pytest.mark.usefixtures("without_charts")
def test_a_function_of_numbers_is_varied_too(tmp_path):
    def tower(width, friction):
        return block_on_floor(width=width, friction=friction)

    vary = {"width": [0.5, 1.0], "friction": [0.3, 0.6]}
    frame = mo.sweep(tower, vary, out=tmp_path, **SERIAL)
    assert frame["load_factor"].tolist() == pytest.approx([0.25, 0.25, 0.3, 0.5], abs=1e-8)
    same(mo.sweep(tower, vary, out=tmp_path, **SERIAL), frame)
    # Another function makes other scenes, so that no run of the journal is used.
    frame = mo.sweep(lambda width, friction: tower(width, friction / 2), vary, out=tmp_path, **SERIAL)
    assert frame["load_factor"][2:4].tolist() == pytest.approx([0.15, 0.3], abs=1e-8)


@pytest.mark.parametrize(
    ("scene", "vary", "said"),
    [
        (block_on_floor(), {}, "vary"),
        (block_on_floor(), {"joints.friction": []}, "at least one"),
        (block_on_floor(), {"joints.friction": ["much"]}, "list of numbers"),
        (block_on_floor(), {"joints.friction": 0.3}, "list of numbers"),
        (block_on_floor(), {"joints.friction": [0.3, 0.3]}, "twice"),
        (block_on_floor(), {"joints.frictoin": [0.3]}, "joints.friction"),
        (lambda width: width, {"height": [1.0]}, "missing a required argument: .width"),
        (lambda width: width, {"width": [1.0]}, "must return a Scene"),
        (lambda status: block_on_floor(), {"status": [1.0]}, "is a column"),
    ],
)
def test_what_cannot_be_varied_is_told(scene, vary, said):
    with pytest.raises(mo.OptionError, match=said):
        mo.sweep(scene, vary, method="static", workers=1)


@pytest.mark.parametrize("option", [{"bta": 0.5}, {"revise": lambda *_: None}])
def test_options_are_refused_before_the_first_run(option):
    with pytest.raises(mo.OptionError, match=f"option '{next(iter(option))}'"):
        mo.sweep(block_on_floor(), VARY, method="nonassociative", **option)


@pytest.mark.slow
def test_the_command_writes_table_and_charts(command, tmp_path):
    case, out = CASES / "gilbert" / "two_blocks.toml", tmp_path / "new" / "swept"
    asked = ["--vary", "joints.friction=0.1:0.2:2", "--vary", "block.A.weight=1,2", "--method", "static"]
    asked += ["--workers", "1", "--out", out]
    text = command("sweep", case, *asked)
    assert text.startswith("4 runs, 4 with a load factor")
    assert "joints.friction = 0.1, block.A.weight = 1" in text
    assert pd.read_csv(out / "runs.csv")["joints.friction"].tolist() == [0.1, 0.1, 0.2, 0.2]
    for name in ("load_factor.png", "load_factor.svg", "heat_map.png", "heat_map.svg"):
        assert (out / name).stat().st_size > 5000


def test_a_sweep_says_where_the_least_is_and_where_there_is_none():
    names = ["joints.friction", "width"]
    points = [(0.2, 1), (0.2, 2), (0.4, 1), (0.4, 2), (0.6, 1), (0.6, 2)]
    frame = pd.DataFrame(points, columns=names).assign(load_factor=[0.3, 0.1, 0.1 + 1e-12, None, None, 0.2])
    frame["status"] = ["optimal"] * 3 + ["refused"] * 2 + ["optimal"]
    frame = frame.assign(state_from="", message=[""] * 3 + ["too thin"] * 2 + [""], which="associative")
    lines = summary_text(frame, names).splitlines()
    assert len(lines) == 5
    assert "0.100000" in lines[1]
    assert lines[2] == "λ is associative (upper bounds, by classical limit analysis)"
    assert "joints.friction = 0.2, width = 2" in lines[3]
    assert "1 more run" in lines[3]
    assert lines[4].startswith("2 refused")
    assert "joints.friction = 0.4, width = 2" in lines[4]
    assert lines[4].endswith(": too thin")
    assert len(summary_text(frame[3:5], names).splitlines()) == 2


NO_VALUES = ("", "=", "=0:1", "=0:1:0", "=0:1:1e9", "=a,b")


@pytest.mark.parametrize("vary", ["=1,2", *(f"joints.friction{values}" for values in NO_VALUES)])
def test_the_command_says_how_values_are_written(command, tmp_path, vary):
    case = CASES / "gilbert" / "two_blocks.toml"
    assert "NAME=FROM:TO:COUNT" in command.refused("sweep", case, "--vary", vary, "--out", tmp_path)


SOLVE = partial(run_scene, pickle.dumps(HowToSolve("static")))
VALUES = [{"joints.friction": 0.1 + 0.05 * number} for number in range(12)]
RUNS = [block_on_floor(friction=values["joints.friction"]) for values in VALUES]


def rows(ends):
    return {number: row(VALUES[number], end) | {"seconds": None} for number, end in ends}


@pytest.fixture(scope="module")
def alone():
    without = dict.fromkeys(RUN_COLUMNS) | {"state_from": ""}
    return {number: VALUES[number] | without | SOLVE(run) for number, run in enumerate(RUNS)}


@pytest.mark.slow
def test_a_lost_worker_costs_nothing_but_time(alone, tmp_path):
    tasks = [partial(hogs.die_thrice, tmp_path, partial(SOLVE, run)) for run in RUNS]
    with Workers(2) as workers:
        assert rows(workers.map(enumerate(tasks))) == alone
    assert len(list(tmp_path.iterdir())) >= 3  # Two workers may die at once.

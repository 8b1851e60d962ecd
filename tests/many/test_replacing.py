"""Tests of files in the folder of a study: a study replaces its own files, and a table only if no run is
lost."""

import csv
import json
import re

import pandas as pd
import pytest
from scenes import CASES, block_on_floor, run_command, two_blocks

import masonry_opt as mo
from masonry_opt.errors import OptionError, OutputError
from masonry_opt.files import RECORD, write_folder
from masonry_opt.studies.many.runs import StudyOutput

pytestmark = pytest.mark.usefixtures("without_charts")

FRICTIONS = [0.1, 0.2, 0.3, 0.30000000000000004]


def swept(out, of, **keys):
    return mo.sweep(block_on_floor(), {"joints.friction": of}, method="static", workers=1, out=out, **keys)


def sampled(out, n, **keys):
    drawn = {"joints.friction": ("uniform", 0.3, 0.5)}
    return mo.sample(block_on_floor(), drawn, n=n, method="static", workers=1, out=out, **keys)


def frictions_in(out):
    with (out / "runs.csv").open(encoding="utf-8", newline="") as stream:
        return [float(row["joints.friction"]) for row in csv.DictReader(stream)]


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("others", [[0.1], [0.5, *FRICTIONS[:3]], [0.5, 0.6, 0.7, 0.8, 0.9]])
def test_a_table_does_not_lose_runs_to_another(tmp_path, others):
    """A table is replaced neither by a smaller sweep, nor by a larger one without some of its runs."""
    swept(tmp_path, FRICTIONS)
    before = contents(tmp_path)
    with pytest.raises(OptionError, match=r"runs\.csv.* another folder.*--force"):
        swept(tmp_path, others)
    assert contents(tmp_path) == before
    swept(tmp_path, others, force=True)
    assert frictions_in(tmp_path) == others
    # The table that was replaced by force is made again from the journal, without a run.
    journal = (tmp_path / "journal.jsonl").read_bytes()
    swept(tmp_path, FRICTIONS, force=True)
    assert frictions_in(tmp_path) == FRICTIONS
    assert (tmp_path / "journal.jsonl").read_bytes() == journal


def test_a_table_is_replaced_by_one_with_all_of_its_runs(tmp_path):
    swept(tmp_path, FRICTIONS[1:3])
    swept(tmp_path, FRICTIONS[1:3])
    swept(tmp_path, [*reversed(FRICTIONS), 7])
    assert frictions_in(tmp_path) == [*reversed(FRICTIONS), 7]


def test_a_table_is_replaced_by_one_with_its_parameters_in_another_order(tmp_path):
    values = {"joints.friction": [0.2, 0.3], "gravity.x": [0.0, 0.1]}
    for names in (list(values), [*reversed(values)]):
        ordered = {name: values[name] for name in names}
        mo.sweep(block_on_floor(), ordered, method="static", workers=1, out=tmp_path)
        assert [*pd.read_csv(tmp_path / "runs.csv").columns[:2]] == names


def test_a_sample_is_replaced_by_a_larger_one_alone(tmp_path):
    sampled(tmp_path, 2)
    sampled(tmp_path, 4)
    before = contents(tmp_path)
    with pytest.raises(OptionError, match="--force"):
        sampled(tmp_path, 2)
    with pytest.raises(OptionError, match="--force"):
        swept(tmp_path, FRICTIONS)
    assert contents(tmp_path) == before
    assert sampled(tmp_path, 2, force=True).runs == 2
    assert len(frictions_in(tmp_path)) == 2


@pytest.mark.parametrize("content", ["", "date,miles\nmonday,3\n", '"', "\udcff"])
def test_a_table_of_someone_else_is_kept(tmp_path, content):
    (tmp_path / "runs.csv").write_bytes(content.encode("utf-8", "surrogateescape"))
    before = contents(tmp_path)
    with pytest.raises(OptionError, match=r"runs\.csv.*--force"):
        swept(tmp_path, FRICTIONS)
    assert contents(tmp_path) == before
    swept(tmp_path, FRICTIONS, force=True)
    assert frictions_in(tmp_path) == FRICTIONS


def test_no_zero_of_a_table_has_a_sign(tmp_path):
    """Without friction the block collapses at λ = 0, which solvers compute with either sign; tables have
    no -0.0."""
    frame = swept(tmp_path, [-0.0, 0.5])
    assert "-0.0" not in (tmp_path / "runs.csv").read_text()
    assert "-0.0" not in frame.to_csv()


#: Names of files that the studies write, in addition to their journals.
SWEPT = ["runs.csv", "load_factor.png", "load_factor.svg", "charts.html"]
SAMPLED = ["quantiles.csv", "fragility.csv", "sensitivity.png", "fragility.svg", "charts.html"]
COMPARED = [
    "results.csv",
    "summary.csv",
    "report.html",
    "time_error_associative.png",
    "time_error_coulomb.svg",
]
FOREIGN = b"mine, by hand\n"


def compared(out, **keys):
    asked = {"methods": "static", "models": "cvxpy", "solvers": "highs", "tolerances": [1e-9], "repeats": 1}
    return mo.compare("two_blocks", **asked, out=out, cases=CASES, **keys)


STUDIES = {
    "sweep": (lambda out, **keys: swept(out, FRICTIONS, **keys), SWEPT),
    "sample": (lambda out, **keys: sampled(out, 2, **keys), SAMPLED),
    "compare": (compared, COMPARED),
}


@pytest.mark.parametrize(
    ("study", "name"), [(study, name) for study, (_, names) in STUDIES.items() for name in names]
)
def test_a_file_of_someone_else_is_refused_before_anything_is_solved(tmp_path, study, name):
    run, _ = STUDIES[study]
    (tmp_path / name).write_bytes(FOREIGN)
    with pytest.raises(OptionError, match=rf"{re.escape(name)}: .*--force") as refused:
        run(tmp_path, progress=lambda *_: pytest.fail("something was solved"))
    assert refused.value.exit_code == 2
    assert contents(tmp_path) == {name: FOREIGN}


@pytest.mark.parametrize("study", STUDIES)
def test_force_replaces_files_of_someone_else_and_a_study_its_own(tmp_path, study):
    run, names = STUDIES[study]
    table = names[0]
    (tmp_path / table).write_bytes(FOREIGN)
    run(tmp_path, force=True)
    written = (tmp_path / table).read_bytes()
    assert FOREIGN not in written
    run(tmp_path)
    assert (tmp_path / table).read_bytes() == written


@pytest.mark.parametrize("study", STUDIES)
def test_a_table_that_was_changed_is_refused(tmp_path, study):
    """The table has an additional column with remarks of a user."""
    run, names = STUDIES[study]
    run(tmp_path)
    path = tmp_path / names[0]
    changed = path.read_bytes().replace(b"\n", b",remark\n")
    path.write_bytes(changed)
    with pytest.raises(OptionError, match=rf"{path.name}: .*--force"):
        run(tmp_path)
    assert path.read_bytes() == changed


def test_a_folder_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    write_folder(tmp_path, {"a.csv": "old\n", "b.csv": "old\n"})
    before = {name: content for name, content in contents(tmp_path).items() if name != RECORD}
    write_bytes = type(tmp_path).write_bytes
    full = OSError(28, "No space left on device")

    def fails_on_the_second(path, data):
        if data == b"second\n":
            raise full
        return write_bytes(path, data)

    monkeypatch.setattr(type(tmp_path), "write_bytes", fails_on_the_second)
    with pytest.raises(OutputError, match=r"b\.csv: cannot be written: No space left"):
        write_folder(tmp_path, {"a.csv": "first\n", "b.csv": "second\n"})
    assert {name: content for name, content in contents(tmp_path).items() if name != RECORD} == before
    monkeypatch.undo()
    # The package still recognises the old files and the new ones as its own.
    for content in ("third\n", "fourth\n"):
        write_folder(tmp_path, {"a.csv": content, "b.csv": content})


def test_files_of_an_earlier_run_go_but_none_that_was_changed(tmp_path):
    """A new run removes the files of an earlier run of the study, but not files of other names or changed
    files."""
    names = {"heat_map.png": b"1", "load_factor_12.svg": b"2", "quantiles.csv": b"3", "charts.html": b"4"}
    write_folder(tmp_path, names | {"fig8.csv": b"5"})
    (tmp_path / "charts.html").write_bytes(FOREIGN)
    StudyOutput(tmp_path, [], force=False).write(pd.DataFrame({"x": [1]}), {"load_factor.png": b"6"})
    kept = {"runs.csv", "load_factor.png", "fig8.csv", "charts.html", RECORD}
    assert set(contents(tmp_path)) == kept


def test_a_sweep_leaves_no_chart_of_an_earlier_one(tmp_path):
    drawn = write_folder(tmp_path, {"heat_map.svg": "old\n", "sensitivity.png": "old\n"})
    swept(tmp_path, FRICTIONS)
    assert not any(path.exists() for path in drawn)


def test_a_record_of_someone_else_is_no_leave_to_replace(tmp_path):
    (tmp_path / RECORD).write_text(json.dumps({"files": {"runs.csv": []}}))
    with pytest.raises(OptionError, match=rf"{RECORD}: .*--force"):
        swept(tmp_path, FRICTIONS)


def test_a_folder_in_the_place_of_a_file_is_refused_whatever_is_forced(tmp_path):
    (tmp_path / "summary.csv").mkdir()
    with pytest.raises(OptionError, match=r"summary\.csv: .*a folder has this name"):
        compared(tmp_path, force=True)


@pytest.mark.parametrize("name", ["fig8.csv", "fig8_a.png"])
def test_reproduce_refuses_files_of_someone_else_before_it_begins(monkeypatch, capsys, tmp_path, name):
    (tmp_path / name).write_bytes(FOREIGN)
    code, _, err = run_command(monkeypatch, capsys, "reproduce", "fig8", "--out", tmp_path)
    assert code == 2
    assert f"{name}: " in err
    assert "--force" in err
    assert contents(tmp_path) == {name: FOREIGN}


def test_commands_refuse_before_they_solve(monkeypatch, capsys, tmp_path):
    """The commands end with exit code 2, and print nothing on standard output."""
    case, file = tmp_path / "case.toml", tmp_path / "mine"
    mo.save(two_blocks(), case)
    for end, command in (
        (".png", ["solve", case, "--plot"]),
        (".html", ["report", case, "--out"]),
        (".obj", ["export", case, "--method", "static"]),
        (".png", ["draw", case]),
        (".dxf", ["convert", case]),
        (".png", ["capacity", case, "--plot"]),
        (".html", ["settle", case, "--support", "base", "--direction", "0,-1", "--plot"]),
    ):
        path = file.with_suffix(end)
        path.write_bytes(FOREIGN)
        code, out, err = run_command(monkeypatch, capsys, *command, path)
        assert (code, out) == (2, "")
        assert f"{path}: " in err
        assert "--force" in err
        assert path.read_bytes() == FOREIGN


def test_a_journal_of_someone_else_is_kept(tmp_path):
    path = tmp_path / "journal.jsonl"
    path.write_bytes(b"dear diary")
    with pytest.raises(OptionError, match="is not a journal of runs"):
        swept(tmp_path, FRICTIONS)
    assert contents(tmp_path) == {"journal.jsonl": b"dear diary"}

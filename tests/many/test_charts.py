"""Tests of the charts of a sweep, and of its files: written whole or not at all, with the same numbers in
each."""

import re
import shutil

import numpy as np
import pandas as pd
import pytest
from many.tables import same
from scenes import block_on_floor
from screens import full_from

import masonry_opt as mo
from masonry_opt.errors import OutputError
from masonry_opt.studies.charts import pictures
from masonry_opt.studies.many.charts import drawings, heat_map, off_axis
from masonry_opt.studies.writing import JOURNAL

NAME = "joints.friction"


def frame(mechanisms, load_factors):
    """Return the table of a sweep over friction with the given mechanisms and load factors."""
    friction = [0.1 * number for number in range(1, len(mechanisms) + 1)]
    status = ["optimal" if value == value else "unstable under dead load" for value in load_factors]
    columns = {NAME: friction, "load_factor": load_factors, "mechanism": mechanisms, "status": status}
    return pd.DataFrame(columns).assign(incremental=np.nan, which="lowest found")


def test_the_page_of_a_sweep_has_the_title_of_the_scene_and_no_empty_layers(tmp_path):
    scene = block_on_floor().replace(title="A  block")
    mo.sweep(scene, {NAME: [0.3, 0.4]}, method="static", out=tmp_path, workers=1)
    assert "<h1>Sweep of A block</h1>" in (tmp_path / "charts.html").read_text("utf-8")
    assert all(len(rows) for _, rows, _ in layers(against(frame(["sliding", "hinging"], [0.3, 0.4]))))


def against(swept):
    (drawing,) = drawings(swept, [NAME])
    return drawing


def layers(drawing):
    """Return the kind of mark, the rows and the specification of each layer."""
    whole = drawing.on_page()
    own = whole.get("data", {}).get("name")
    rows = [whole["datasets"][layer.get("data", {"name": own})["name"]] for layer in whole["layer"]]
    kinds = [layer["mark"]["type"] for layer in whole["layer"]]
    return list(zip(kinds, map(pd.DataFrame, rows), whole["layer"], strict=True))


def marks(drawing):
    """Return the points, their positions on the axis of λ, and the ends of this axis."""
    found = [(rows, layer["encoding"]) for _, rows, layer in layers(drawing) if "shape" in layer["encoding"]]
    places = [encoding["y"] for _, encoding in found]
    return pd.concat([rows for rows, _ in found]), places, places[0]["scale"]["domain"]


def test_points_are_marked_by_mechanism():
    swept = frame(["sliding"] * 3 + ["mixed"] + ["hinging"] * 3, [0.1, 0.2, 0.3, 0.35, 0.4, 0.4, 0.4])
    drawing = against(swept)
    points, *_ = marks(drawing)
    assert points["series"].tolist() == swept["mechanism"].tolist()
    assert drawing.notes.endswith("λ: lowest found")
    assert points[["at", "λ"]].to_numpy() == pytest.approx(swept[[NAME, "load_factor"]].to_numpy())


def test_lines_that_coincide_are_named():
    """The last line that is drawn hides the other one, unless a run of one of them has no load factor."""
    rows = frame(["hinging"] * 8, [0.1, 0.2, 0.3, 0.2, 0.1, 0.4, 0.3, 0.4])
    rows = rows.assign(**{NAME: [0.5, 0.5, 0.5, 0.5, 0.7, 0.7, 0.7, 0.7], "b": [1.0, 2.0, 3.0, 4.0] * 2})
    (chart, _) = drawings(rows, [NAME, "b"])
    assert "equal lines: b = 2, 4" in chart.notes
    rows.loc[3, "load_factor"] = np.nan
    (chart, _) = drawings(rows, [NAME, "b"])
    assert "equal lines" not in chart.notes


@pytest.mark.slow
@pytest.mark.parametrize("statuses", [1, 4])
def test_runs_without_a_load_factor_stand_below_all_values(statuses):
    swept = frame(["sliding"] * 6, [0.1, 0.4] + [np.nan] * 4)
    swept.loc[2:, "status"] = [f"status {number % statuses}" for number in range(4)]
    drawing = against(swept)
    points, places, (low, high) = marks(drawing)
    assert points["series"][points["λ"].isna()].nunique() == statuses
    assert (low, high) == (0.1, 0.4)
    assert layers(drawing)[0][2]["encoding"]["y"]["scale"]["padding"] > 0
    assert "height" in places[1]["value"]["expr"]
    # If no run has a load factor, there is still a chart, without numbers on its axis.
    assert not layers(against(swept[2:]))[0][2]["encoding"]["y"]["axis"]["labels"]


def test_a_load_factor_that_does_not_change_is_not_drawn_as_if_it_did():
    swept = frame(["hinging"] * 4, [0.25, 0.25 + 1e-10, 0.25 - 1e-10, np.nan])
    *_, (low, high) = marks(against(swept))
    assert 0.004 <= high - low <= 0.01
    assert low < 0.25 - 1e-10
    assert high > 0.25 + 1e-10
    drawing = heat_map(swept.assign(b=[1.0, 1.0, 2.0, 2.0], a=[1.0, 2.0] * 2), "a", "b")
    least, greatest = scale_of(drawing)
    assert greatest - least == pytest.approx(0.005, abs=1e-8)


def scale_of(drawing):
    """Return the ends of the colour scale of a map."""
    (found,) = (layer["encoding"]["fill"] for *_, layer in layers(drawing) if "fill" in layer["encoding"])
    return found["scale"]["domain"]


def test_a_heat_map_has_a_cell_for_each_run():
    load_factors = [1.0, 2.0, 3.0, np.nan]
    swept = pd.DataFrame({"a": [1.0, 1.0, 2.0, 2.0], "b": [1.0, 3.0] * 2, "load_factor": load_factors})
    drawing = heat_map(swept.assign(status="optimal", which="associative"), "a", "b")
    (_, every, _), (_, cells, _), (_, ring, _) = layers(drawing)
    assert every[["x", "y"]].to_numpy().tolist() == [[1, 1], [1, 3], [2, 1], [2, 3]]
    assert cells[["x", "y", "λ"]].to_numpy().tolist() == [[1, 1, 1], [1, 3, 2], [2, 1, 3]]
    assert scale_of(drawing) == [1, 3]
    assert ring[["x", "y"]].to_numpy().tolist() == [[1, 1]]


#: Load factors of a sweep, and the indices of those that its axis leaves out.
OFF = {
    "one a hundred times the others": ([0.2, 0.3, 25.0, 0.25, 0.4], [2]),
    "two of eight": ([0.2, 0.3, 25.0, 0.25, 0.4, 0.3, 80.0, 0.3], [2, 6]),
    "of three": ([0.25, 0.25, 30.0], [2]),
    "growing steadily": ([0.1, 0.4, 1.0, 2.5, 6.0, 15.0], []),
    "most of them large": ([0.2, 30.0, 25.0, 28.0, 0.3], []),
    "below": ([-25.0, 0.2, 0.3, 0.2], []),
    "zero but for rounding": ([1e-13, 2e-13, 0.0, 0.5], []),
    "two values": ([0.2, 30.0], []),
    "among runs without any": ([0.2, np.nan, 0.3, 30.0], [3]),
    "none": ([np.nan, np.nan, np.nan], []),
}


@pytest.mark.parametrize("kind", OFF)
def test_what_would_press_the_others_together_is_left_off_the_axis(kind):
    values, off = OFF[kind]
    assert np.flatnonzero(off_axis(values)).tolist() == off


@pytest.mark.slow
def test_a_value_off_the_axis_stands_at_its_head():
    swept = frame(["sliding"] * 6, [0.2, 0.3, 25.0, 0.25, np.nan, 0.4])
    drawing = against(swept)
    points, places, ends = marks(drawing)
    assert ends == [0.2, 0.4]
    assert points["λ"].max() == 25
    assert places[2]["value"] < layers(drawing)[0][2]["encoding"]["y"]["scale"]["padding"]
    kind, written, _ = layers(drawing)[-1]
    assert (kind, written["λ"].tolist(), written["at"].tolist()) == ("text", [25], [pytest.approx(0.3)])


def test_a_value_above_the_scale_of_a_map_is_told():
    values = [0.2, 0.3, 25.0, 0.25, 0.3, 0.4]
    swept = pd.DataFrame({"a": [1.0, 1.0, 1.0, 2.0, 2.0, 2.0], "b": [1.0, 2.0, 3.0] * 2})
    swept = swept.assign(load_factor=values, status="optimal", which="associative")
    drawing = heat_map(swept, "a", "b")
    assert scale_of(drawing) == [0.2, 0.4]
    assert "last colour" in drawing.notes
    assert "last colour" not in heat_map(swept.drop(2), "a", "b").notes


@pytest.mark.slow
def test_the_incremental_load_factor_is_dashed():
    swept = frame(["sliding"] * 3, [0.2, 0.3, np.nan]).assign(incremental=[0.25, 0.4, 0.6])
    (line, *_) = (of for of in layers(against(swept)) if "strokeDash" in of[2]["mark"])
    assert line[1]["incremental"].tolist() == [0.25, 0.4, 0.6]
    assert marks(against(swept))[2][1] == 0.6
    assert "dashes" in against(swept).notes
    assert "dashes" not in against(swept.assign(incremental=swept["load_factor"])).notes


@pytest.mark.slow
def test_the_least_is_ringed_and_all_of_a_plateau():
    for values, least in (([0.3, 0.2, 0.25], [0.2]), ([0.2, 0.3, 0.2 + 1e-12], [0.1, 0.3]), ([0.2] * 3, [])):
        points, *_ = marks(against(frame(["sliding"] * 3, values)))
        assert points["at"][points["least"]].tolist() == pytest.approx(least)


@pytest.mark.parametrize("friction", [0.5, np.inf])
def test_a_map_is_drawn_of_finite_values_alone(friction):
    names = [NAME, "arch.thickness"]
    swept = pd.DataFrame([(0.3, 1.0), (0.3, 2.0), (friction, 1.0), (friction, 2.0)], columns=names)
    swept = swept.assign(
        load_factor=1.0, incremental=1.0, status="optimal", mechanism="sliding", which="associative"
    )
    drawn = drawings(swept, names)
    assert [drawing.name for drawing in drawn] == ["load_factor", "heat_map"][: 1 + np.isfinite(friction)]
    assert all(drawing.on_page()["layer"] for drawing in drawn)
    # With more than two parameters, each parameter has a chart.
    assert len(drawings(swept.assign(b=swept[NAME]), [*names, "b"])) == 3


@pytest.mark.slow
def test_ticks_are_labelled_with_the_load_factors_they_stand_at():
    """Labels of ticks have enough digits: rounded to one digit, 0.32 and 0.28 would both read 0.3."""
    drawing = against(frame(["sliding"] * 6, [0.28, 0.4, 0.5, 0.6, 0.66, 0.71]))
    picture = pictures([drawing])["load_factor.svg"]
    upwards = picture.split('aria-label="Y-axis')[1].split("role-axis-title")[0]
    labels = [float(text) for text in re.findall(r">(-?\d*\.?\d+)</text>", upwards)]
    assert len(labels) > 3
    # Labels are at equal distances, as the ticks are.
    assert np.diff(labels, 2) == pytest.approx(0, abs=1e-9)


VARY = {"joints.friction": [0.1, 0.2, 0.3, 0.4, -1.0]}


def sweep(**keys):
    return mo.sweep(block_on_floor(), VARY, method="static", workers=1, **keys)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Return a table, and the folder to which it was written."""
    out = tmp_path_factory.mktemp("swept")
    return sweep(out=out), out


@pytest.mark.slow
@pytest.mark.parametrize("full", [JOURNAL, "runs.csv", "load_factor.png"])
def test_a_full_disk_keeps_what_was_made(swept, tmp_path, full):
    frame, folder = swept
    lines = (folder / JOURNAL).read_bytes().splitlines(keepends=True)
    if full == JOURNAL:
        # The disk is full in the middle of the third run's line, after two runs that are kept. The times of
        # runs decide how long lines are.
        (tmp_path / JOURNAL).write_bytes(b"".join(lines[:3]))
        size, whole = sum(map(len, lines[:3])) + 20, 1 + 2
    else:
        # The disk had just enough space for the last run. Pictures are longer than the journal.
        sweep(out=tmp_path)
        size, whole = (tmp_path / full).stat().st_size - 20, len(lines)
        for file in (full, "load_factor.png"):
            (tmp_path / file).unlink(missing_ok=True)
    with full_from(size), pytest.raises(OutputError, match="cannot be written") as failed:
        sweep(out=tmp_path)
    assert str(tmp_path / full) in str(failed.value)
    kept = (tmp_path / JOURNAL).read_bytes()
    assert len([line for line in kept.splitlines(keepends=True) if line.endswith(b"\n")]) == whole
    assert not list(tmp_path.glob(".writing*"))
    assert not (tmp_path / "load_factor.png").exists()
    same(sweep(out=tmp_path), frame)
    assert len((tmp_path / JOURNAL).read_bytes().splitlines()) == len(lines)
    assert (tmp_path / "load_factor.png").read_bytes() == (folder / "load_factor.png").read_bytes()


@pytest.mark.slow
def test_csv_is_the_table_to_the_last_digit(swept, tmp_path):
    frame, folder = swept
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)  # With the journal, no run is repeated.
    sweep(out=tmp_path)
    assert (tmp_path / "runs.csv").read_bytes() == (folder / "runs.csv").read_bytes()
    written = pd.read_csv(tmp_path / "runs.csv", dtype=str, keep_default_na=False)
    for name in ("joints.friction", "load_factor", "equilibrium", "yield", "seconds"):
        digits = ["" if pd.isna(value) else repr(float(value)) for value in frame[name]]
        assert written[name].tolist() == digits

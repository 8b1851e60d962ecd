"""Tests of samples of a block's load factor, min(μ, b/h), against its distribution, and of draws for
joints."""

import json
import math

import numpy as np
import pandas as pd
import pytest
from many.tables import sampled
from scenes import CASES, block_on_floor, small_wall
from scipy import stats

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.studies.charts import chart_contents
from masonry_opt.studies.many.draws import Draws, lognormal
from masonry_opt.studies.run_columns import RUN_COLUMNS

FRICTION = lognormal(0.4, 0.1)
SLENDER = 0.5
ASKED = {"method": "static", "seed": 1}

UNLIMITED = [("nonassociative", {"preset": "paper"}, 2), ("static", {}, 0)]


def uncertain(n, **more):
    return mo.sample(
        block_on_floor(1.0, 2.0),
        {"joints.friction": ("lognormal", 0.4, "25%"), "joints.cohesion": ("uniform", 0.0, 1e-9)},
        n=n,
        **(ASKED | more),
    )


@pytest.fixture(scope="module")
def block():
    return uncertain(48, workers=1)


def test_every_run_is_the_closed_form(block):
    drawn = block.table["joints.friction"].to_numpy()
    np.testing.assert_allclose(block.table["load_factor"], np.minimum(drawn, SLENDER), rtol=1e-7)
    assert block.table.columns.tolist() == ["joints.friction", "joints.cohesion", *RUN_COLUMNS]
    assert (block.falling, block.unlimited, block.undecided) == (0, 0, 0)


def test_quantiles_and_fragility_hold_those_of_the_distribution(block):
    for row in block.quantiles([0.05, 0.25, 0.5, 0.75, 0.95]).to_dict("records"):
        known = min(FRICTION.ppf(row["probability"]), SLENDER)
        lower = -math.inf if math.isnan(row["lower"]) else row["lower"]
        upper = math.inf if math.isnan(row["upper"]) else row["upper"]
        assert lower - 1e-7 <= known <= upper + 1e-7
    loads = [0.25, 0.3, 0.35, 0.4, 0.45, 0.499, 0.501]
    curve = block.fragility(loads)
    known = np.where(np.array(loads) < SLENDER, FRICTION.cdf(loads), 1.0)
    assert ((curve["lower"] <= known) & (known <= curve["upper"])).all()
    # If the number of points is a power of two, every interval [0, u) has its share of a scrambled net to
    # within one point. 48 is the sum of two powers of two.
    assert np.abs(curve["probability"] - known).max() <= 2 / 48 + 1e-12


def test_what_matters_is_the_friction(block):
    found = block.sensitivity().set_index("parameter")
    assert found["rank_correlation"]["joints.friction"] > 0.98  # Runs in which the block overturns are ties.
    assert found["lower"]["joints.cohesion"] < 0 < found["upper"]["joints.cohesion"]
    read = json.loads(block.to_json())
    assert read["runs"] == 48
    assert read["distributions"]["joints.friction"] == "lognormal(0.4, 0.1)"
    assert [row["probability"] for row in read["quantiles"]] == [0.05, 0.5, 0.95]


def test_of_a_block_that_slides_both_loads_are_the_friction():
    """The load factor and the incremental load factor of a block that slides are both its friction.

    The block is pushed at half its height, and slides at λ = μ below its slenderness. Its stiffness has no
    influence, and it has no self-stress.
    """
    given = {"joints.friction": ("uniform", 0.2, 0.4)}
    found = mo.sample(block_on_floor(1.0, 2.0), given, n=4, method="incremental", spread=2, workers=1)
    loads = found.table[["load_factor", "incremental", "spread_lower", "spread_upper"]]
    assert loads.sub(found.table["joints.friction"], axis=0).abs().to_numpy().max() < 1e-7
    (row,) = json.loads(found.to_json())["sensitivity"]
    assert (row["rank_correlation"], row["incremental_rank_correlation"]) == pytest.approx((1, 1))
    assert "by 0.0% (median of the runs)" in str(found)
    assert str(found).count("; incremental the same") == 4


def test_quantiles_that_no_load_factor_has_are_stated_as_shares_of_runs():
    """A quantile that is not a load factor is printed as the share of runs that fall or carry any load."""
    printed = str(sampled([*[-np.inf] * 2, *range(1, 17), *[np.inf] * 2])).splitlines()
    assert "at least 5% of the runs are unstable under their dead load" in printed
    assert "at least 5% of the runs carry any load" in printed
    assert any(line.startswith("50%    of the load factors are below 8.00000 (") for line in printed)
    assert not any("below none" in line or "below any" in line for line in printed)


@pytest.mark.slow
def test_incremental_load_factors_stand_beside_the_lowest_found():
    """Incremental load factors have quantiles, correlations and charts next to those of the lowest found.

    Here the lowest load factor falls where the incremental one grows. One run has no incremental load factor,
    and therefore no rank.
    """
    found = sampled(np.linspace(0.3, 0.2, 21), which="lowest found")
    assert found.quantiles()[["incremental_value", "incremental_lower"]].isna().all(axis=None)
    found.table["incremental"] = [*np.linspace(0.31, 0.5, 20), np.nan]
    assert "1 (4.8%) without an incremental λ" in found.counted
    row = found.sensitivity().loc[0]
    assert (row["rank_correlation"], row["incremental_rank_correlation"]) == pytest.approx((-1, 1))
    assert "-1.000 (-1.000 to -1.000); incremental +1.000 (" in str(found)
    curve = found.fragility([0.0, 0.305, 0.6])
    assert curve["incremental_probability"].tolist() == pytest.approx([0, 0, 1])
    assert curve["incremental_upper"][0] == pytest.approx(stats.binomtest(1, 21).proportion_ci(0.95).high)
    for kind in ("fragility", "sensitivity"):
        drawn = found.drawing(kind).chart.to_dict()
        rows = [row for rows in drawn["datasets"].values() for row in rows]
        assert {row["of"] for row in rows} == {"lowest found", "incremental"}


@pytest.mark.slow
def test_a_number_that_does_not_matter_is_drawn_too():
    """A parameter without influence is drawn too: the chart of sensitivities has no marks, and no legend."""
    found = sampled([0.3, 0.3, 0.3, 0.3])
    assert found.sensitivity()["rank_correlation"].isna().all()
    files = chart_contents("Sample", [found.drawing("sensitivity")])
    assert "no parameter has an influence" in files["sensitivity.svg"]


def test_undecided_runs_widen_the_limits_and_refused_ones_count_nowhere():
    """Undecided runs widen the limits, and refused runs do not count.

    Of 11 runs, 6 collapse at 1 to 6, 1 is unstable, 1 carries any load, 2 are undecided and 1 is refused. The
    limits are those of Clopper & Pearson, by SciPy's binomial test. For the lower limit no undecided run has
    collapsed, and for the upper limit all have.
    """
    statuses = ["optimal"] * 6 + [str(mo.Status.UNSTABLE)] + [str(mo.Status.JAMMED)] * 2
    proven = [False] * 7 + [True, False, False, False]
    statuses += ["refused", "crashed"]
    found = sampled([*range(1, 7), *[np.nan] * 5], status=statuses, any_load=proven, message="why")
    assert (found.falling, found.unlimited, found.undecided) == (1, 1, 2)
    assert (found.refused, found.failed) == (1, 1)
    curve = found.fragility([0.0, 3.0, 10.0])
    assert curve["probability"].tolist() == pytest.approx([1 / 8, 4 / 8, 7 / 8])
    for row, collapsed in zip(curve.to_dict("records"), (1, 4, 7), strict=True):
        lower, upper = (
            stats.binomtest(count, 10).proportion_ci(0.95) for count in (collapsed, collapsed + 2)
        )
        assert (row["lower"], row["upper"]) == pytest.approx((lower.low, upper.high))
    median = found.quantiles([0.5]).loc[0]
    assert median["value"] == 3
    assert median["lower"] <= 2 < 5 <= median["upper"]
    assert "2 (18.2%) undecided" in found.counted
    assert "1 (9.1%) refused, left out" in found.counted
    assert "fallen" not in str(found)
    left_out, jammed, crashed = found.as_dict()["warnings"]
    assert left_out == {
        "sentence": "1 run left out (refused): why",
        "code": "runs left out",
        "status": "refused",
        "count": 1,
        "message": "why",
    }
    assert [one["status"] for one in (jammed, crashed)] == [str(mo.Status.JAMMED), "crashed"]
    assert {one["code"] for one in (jammed, crashed)} == {"runs undecided"}


def test_a_sample_of_undecided_runs_alone_has_no_numbers():
    found = sampled([np.nan] * 4, status="crashed")
    assert found.undecided == 4
    assert found.quantiles()["value"].isna().all()
    assert found.fragility()["probability"].isna().all()
    assert "unknown" in str(found)


@pytest.mark.parametrize(("method", "options", "undecided"), UNLIMITED)
def test_a_status_is_no_proof_that_any_load_is_carried(method, options, undecided):
    """The status "locked" does not prove that any load is carried.

    A keystone that is pulled up collapses at λ = 1, its weight (by hand). If friction exceeds the inclination
    of its faces, the paper's loop ends as "locked", which proves nothing. With associative flow, the keystone
    is locked.
    """
    scene = CASES / "closed_forms" / "keystone.toml"
    rough = {"joints.friction": ("uniform", 0.6, 0.75)}
    found = mo.sample(scene, rough, n=2, method=method, workers=1, **options)
    assert set(found.table["status"]) == {str(mo.Status.LOCKED)}
    assert (found.undecided, found.unlimited) == (undecided, 2 - undecided)
    # If both of two runs carry any load, the upper limit p satisfies (1 − p)² = 0.025.
    row = found.fragility([1.5]).loc[0]
    known = [math.nan] * 2 if undecided else [0.0, 1 - math.sqrt(0.025)]
    assert [row["probability"], row["upper"]] == pytest.approx(known, nan_ok=True)


@pytest.mark.slow
def test_all_kinds_of_samples_are_drawn():
    for values in ([1.0], [2.0] * 5, [np.nan] * 3):
        found = sampled(values)
        for kind in ("fragility", "sensitivity"):
            assert found.plot(kind).to_dict()
        assert str(found)
    with pytest.raises(mo.OptionError, match="histogram"):
        found.plot("histogram")


def test_a_load_factor_that_does_not_change_is_drawn_as_one():
    found = sampled((0.5 + 1e-10 * np.arange(20)).tolist())
    load = found.plot("fragility").data["load"]
    assert (load.min(), load.max()) == pytest.approx((0.4945, 0.5055), abs=1e-8)
    assert found.plot("sensitivity").data.empty


@pytest.mark.parametrize(
    ("distributions", "asked", "found"),
    [
        ({"joints.frictoin": ("normal", 0.6, 0.01)}, {}, "joints.friction"),
        ({}, {}, "uncertain"),
        ({"joints.friction": ("normal", 0.6, 0.01)}, {"by": "stone"}, "Choose from: scene, course, joint"),
        ({"joints.friction": ("normal", 0.6, 0.01)}, {"correlation": 0.5}, "correlation"),
        ({"joints.friction": ("normal", 0.6, 0.01)}, {"n": 0}, "1 or more"),
        ({"joints.friction": ("normal", 0.1, 0.1)}, {"n": 64}, "15.8 % of the values are below 0"),
        ({"joints.friction": ("normal", -1, 0.1)}, {"n": 64}, "all values are below 0"),
        ({"block.A.weight": ("normal", 1, 0.01)}, {"by": "course"}, "joints.friction"),
    ],
)
def test_what_is_wrong_is_said(distributions, asked, found):
    with pytest.raises(mo.OptionError, match=found):
        mo.sample(block_on_floor(), distributions, **asked)


def draws_of(scene, by="course", names=("friction",)):
    return Draws(scene, {f"joints.{name}": ("normal", 0.6, 0.06) for name in names}, by)


def test_courses_are_joints_at_one_height():
    """A wall of 4 courses of 1.75 has bed joints below each course, and head joints at half the height of
    a course."""
    scene = small_wall(courses=4, length=3)
    joints = assemble(scene).joints
    columns = draws_of(scene).columns
    assert [column.name for column in columns] == [f"course.{k}.friction" for k in range(1, 9)]
    assert sum(len(column.pairs) for column in columns) == len(joints.first)
    heights = np.unique(joints.middle[:, 1].round(6))
    np.testing.assert_allclose(np.diff(heights), 0.875)


@pytest.mark.parametrize("by", ["course", "joint"])
def test_each_has_its_own_but_where_an_exception_gives_it(by):
    scene = small_wall(courses=3, length=2)
    own = assemble(scene)
    first, second = own.names(own.joints.first[:1]) + own.names(own.joints.second[:1])
    scene = scene.model_copy(update={"exceptions": [mo.Joint(between=(second, first), friction=0.123)]})
    draws = draws_of(scene, by, names=("friction", "cohesion"))
    pairs = [len(column.pairs) for column in draws.columns]
    assert (max(pairs) == 1) == (by == "joint")
    assert sum(pairs) == 2 * len(own.joints.first) - 1
    values = {column.name: 0.5 + 0.001 * number for number, column in enumerate(draws.columns)}
    joints = assemble(draws.scene(values)).joints
    assert joints.friction[0] == 0.123
    drawn = np.r_[joints.friction[1:], joints.cohesion]
    np.testing.assert_allclose(np.sort(drawn), np.repeat([*values.values()], pairs))


def test_a_sample_by_course_is_run_with_what_was_drawn():
    scene = small_wall(courses=2, length=2)
    name = next(block.name for block in scene.blocks if not block.fixed)
    given = {"joints.friction": ("lognormal", 0.5, "10%"), f"block.{name}.weight": ("uniform", 1.0, 1.1)}
    found = mo.sample(scene, given, n=2, by="course", method="static", workers=1)
    draws = Draws(scene, given, "course")
    for values, row in zip(draws.table(2, 0).to_dict("records"), found.table.to_dict("records"), strict=True):
        assert {name: row[name] for name in values} == values
        alone = mo.solve(draws.scene(values), "static")
        assert row["load_factor"] == pytest.approx(alone.load_factor, rel=1e-9)


@pytest.mark.usefixtures("without_charts")
def test_a_sample_is_written_and_told(case, tmp_path, command):
    asked = ("--sample", "joints.friction=lognormal:0.4:25%", "-n", "4", "--seed", "3", "--method", "static")
    output = command("sweep", case, *asked, "--workers", "1", "--out", tmp_path / "out")
    assert "rank correlation" in output
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"quantiles.csv", "fragility.csv", "sensitivity.csv"} <= written
    kept = pd.read_csv(tmp_path / "out" / "runs.csv")
    pd.testing.assert_series_equal(
        kept["load_factor"], kept["joints.friction"].clip(upper=0.5), check_names=False, rtol=1e-7
    )


@pytest.mark.parametrize(
    "asked",
    [
        (),
        ("--sample", "joints.friction=gamma:1:2"),
        ("--sample", "joints.friction=normal:0.1:1"),
        ("--sample", "joints.friction=normal:1:0.01", "--vary", "joints.friction=0.3,0.4"),
        ("--sample", "joints.friction=normal:1:0.01", "--by", "stone"),
        ("--vary", "joints.friction=0.3,0.4", "--runs", "128"),
        ("--vary", "joints.friction=0.3,0.4", "--seed", "0"),
        ("--vary", "joints.friction=0.3,0.4", "--by", "course"),
        ("--vary", "joints.friction=0.3,0.4", "-o", "out=elsewhere"),
        ("--sample", "joints.friction=normal:1:0.01", "--method", "coulomb", "-o", "seed=1"),
    ],
)
def test_what_is_wrong_with_the_command_is_said(case, asked, tmp_path, command):
    assert command.refused("sweep", case, *asked, "--out", tmp_path / "out").startswith("error: ")
    assert not (tmp_path / "out").exists()

"""Tests of distributions as a user writes them, of drawn points, and of intervals against their
definitions."""

import math
import re

import numpy as np
import pandas as pd
import pytest
from many.tables import sampled
from scipy import stats
from speeds import slow

from masonry_opt.errors import OptionError
from masonry_opt.studies.many.draws import distribution, lognormal, parse, points


def quantiles(values, probabilities, confidence):
    return sampled(values).quantiles(probabilities, confidence)


def sensitivity(drawn, values, confidence):
    return sampled(values, drawn).sensitivity(confidence)


@pytest.mark.parametrize("n", [60, 71, 72, *slow(199, 1000)])
@pytest.mark.parametrize("p", [0.05, 0.5, 0.95])
@pytest.mark.parametrize("confidence", [0.9, 0.95])
def test_ranks_of_a_quantile_cover_it(n, p, confidence):
    """The ranks of an interval cover the quantile with the confidence asked, and no narrower ranks do.

    The number K of values below the quantile is binomial. The quantile lies between the ranks l and u if
    l ≤ K < u. One rank nearer on either side would not suffice. The least of n values lies above the 5 %
    quantile with probability 0.95ⁿ, which is below 2.5 % from n = 72 on. For fewer values there is no lower
    limit.
    """
    row = quantiles(np.arange(1.0, n + 1), [p], confidence).iloc[0]
    below, beside = stats.binom(n, p), (1 - confidence) / 2
    first = 0 if math.isnan(row["lower"]) else int(row["lower"])
    last = n + 1 if math.isnan(row["upper"]) else int(row["upper"])
    assert below.cdf(first - 1) <= beside < below.cdf(first)
    assert below.sf(last - 1) <= beside < below.sf(last - 2)
    assert row["lower"] <= row["value"] <= row["upper"] or math.isnan(row["lower"] + row["upper"])
    assert row["value"] == math.ceil(n * p)


def test_quantiles_count_what_has_no_load_factor():
    values = np.concatenate([np.full(10, -math.inf), np.arange(80.0), np.full(10, math.inf)])
    found = quantiles(values, [0.05, 0.5, 0.95], 0.95)
    assert found["value"].tolist() == [-math.inf, 39.0, math.inf]


def test_probability_of_collapse_has_clopper_and_pearsons_interval():
    values = np.concatenate([[0.0], np.linspace(0.1, 0.9, 28), [5.0]])
    loads = [-1.0, 0.0, 0.1, 0.5, 0.9, 2.0, 5.0]
    found = sampled(values).fragility(loads, 0.9)
    for load, row in zip(loads, found.to_dict("records"), strict=True):
        collapsed = int((values <= load).sum())
        interval = stats.binomtest(collapsed, 30).proportion_ci(0.9, method="exact")
        assert row["probability"] == collapsed / 30
        assert (row["lower"], row["upper"]) == pytest.approx((interval.low, interval.high))


def test_load_factors_that_differ_by_rounding_errors_have_one_probability():
    """In each run the load factor exceeds the equal incremental load factor by a rounding error."""
    incremental = np.array([0.1, 0.2, 0.3, 0.4])
    found = sampled(incremental * (1 + 4e-16), incremental=incremental)
    curve = found.fragility()
    assert curve["load"].tolist() == pytest.approx([0.085, 0.1, 0.2, 0.3, 0.4, 0.415])
    assert curve["probability"].tolist() == [0.0, 0.25, 0.5, 0.75, 1.0, 1.0]
    assert curve["incremental_probability"].tolist() == curve["probability"].tolist()
    assert found.fragility([0.3])["probability"].tolist() == [0.75]


def test_one_number_instead_of_a_list():
    answer = sampled(np.arange(1.0, 11.0))
    assert answer.quantiles(0.5).equals(answer.quantiles([0.5]))
    assert answer.fragility(3).equals(answer.fragility([3.0]))
    for wrong in ("a", [[1.0]], [math.nan], None):
        with pytest.raises(OptionError, match="probabilities must be a number or a list of numbers"):
            answer.quantiles(wrong)
    for wrong in ("half", "0.5", True):
        with pytest.raises(OptionError, match=rf"loads must be .* \(found {wrong!r}\)"):
            answer.fragility(wrong)


def test_rank_correlation():
    rng = np.random.default_rng(5)
    drawn = pd.DataFrame({"idle": rng.random(200), "strong": rng.random(200), "fixed": np.ones(200)})
    values = np.exp(drawn["strong"].to_numpy()) + 0.2 * rng.random(200)
    values[:5] = -math.inf
    found = sensitivity(drawn, values, 0.95)
    assert found["parameter"].tolist() == ["strong", "idle", "fixed"]
    for row in found.head(2).to_dict("records"):
        known = stats.spearmanr(drawn[row["parameter"]], values).statistic
        assert row["rank_correlation"] == pytest.approx(known)
        half = stats.norm.ppf(1 - 0.05 / 3 / 2) * math.sqrt((1 + known**2 / 2) / 197)
        assert math.atanh(row["upper"]) - math.atanh(row["lower"]) == pytest.approx(2 * half)
        assert row["lower"] < known < row["upper"]
    assert found.iloc[2].drop("parameter").isna().all()


def test_rounding_follows_nothing():
    """Load factors that differ only by the solver's last digits count as ties, although their order is
    that of x."""
    drawn = pd.DataFrame({"x": np.arange(30.0)})
    for level in (0.5, 0.0):
        values = np.r_[-math.inf, level + 1e-10 * np.arange(29) * level]
        found = sensitivity(drawn, values, 0.95)["rank_correlation"][0]
        ties = stats.spearmanr(drawn["x"], np.r_[0.0, np.ones(29)]).statistic
        assert found == pytest.approx(ties)
        assert math.isnan(sensitivity(drawn[1:], values[1:], 0.95)["rank_correlation"][0])


def test_a_lognormal_has_the_mean_and_deviation_given():
    law = lognormal(0.65, 0.0975)
    assert (law.mean(), law.std()) == pytest.approx((0.65, 0.0975))
    # The logarithm of a lognormal variable is normal: the median is the mean over the root of 1 + (deviation
    # / mean)².
    assert law.median() == pytest.approx(0.65 / math.sqrt(1 + 0.15**2))


@pytest.mark.parametrize(
    ("given", "same"),
    [
        (("lognormal", 0.6, "75%"), stats.lognorm(math.sqrt(math.log(1.5625)), scale=0.6 / 1.25)),
        (("normal", 2.0, "10 %"), stats.norm(2.0, 0.2)),
        (("normal", 2.0, 0.3), stats.norm(2.0, 0.3)),
        (("normal", 0.0, 3.0), stats.norm(0.0, 3.0)),
        (("normal", -2.0, "150%"), stats.norm(-2.0, 3.0)),
        (["uniform", 1, 3], stats.uniform(1, 2)),
        (stats.expon(scale=2), stats.expon(scale=2)),
    ],
)
def test_quantiles(given, same):
    law = distribution("x", given)
    at = np.array([0.05, 0.5, 0.9])
    np.testing.assert_allclose(law.frozen.ppf(at), same.ppf(at), rtol=1e-7)
    assert law.frozen.cdf(1.5) == pytest.approx(same.cdf(1.5), rel=1e-6)


@pytest.mark.parametrize(
    "given",
    [
        *("lognormal", 0.6, ("lognormal", 0.6), ("gamma", 1, 2), ("lognormal", 0.0, 0.1)),
        *(("normal", 1, 0), ("normal", 1, math.nan), ("normal", "1", 1), ("normal", -1, 1.5)),
        *(("uniform", 2, 1), ("uniform", 1, "15%")),
    ],
)
def test_what_is_no_distribution_is_refused(given):
    with pytest.raises(OptionError, match=r"'joints\.friction'"):
        distribution("joints.friction", given)


@pytest.mark.parametrize("kind", ["lognormal", "normal"])
def test_per_cent_given_as_a_number_are_told_from_it(kind):
    """A deviation of 15 is refused: the message offers 15%, and a percentage that means a deviation of 15."""
    with pytest.raises(OptionError) as refused:
        distribution("x", (kind, 0.65, 15))
    meant, as_it_stands = re.findall(r"'([\d.]+%)'", str(refused.value))
    assert meant == "15%"
    law = distribution("x", (kind, 0.65, as_it_stands))
    expected = lognormal(0.65, 15) if kind == "lognormal" else stats.norm(0.65, 15)
    assert law.frozen.ppf(0.9) == pytest.approx(expected.ppf(0.9), rel=1e-4)
    assert distribution("x", (kind, 0.65, 0.65)).text == f"{kind}(0.65, 0.65)"


def test_a_distribution_as_text():
    assert parse("joints.friction=lognormal:0.65:15%") == ("joints.friction", ("lognormal", 0.65, "15%"))
    assert parse("block.A.weight=uniform:1:2") == ("block.A.weight", ("uniform", 1.0, 2.0))
    for wrong in ("joints.friction", "joints.friction=normal:1", "=normal:1:2"):
        with pytest.raises(OptionError, match="NAME="):
            parse(wrong)


@pytest.mark.parametrize("dimensions", [2, 83])
def test_more_points_begin_with_the_same(dimensions):
    few, many = (points(count, dimensions, 7) for count in (10, 16))
    np.testing.assert_array_equal(few, many[:10])
    assert not np.array_equal(few, points(10, dimensions, 8))


@pytest.mark.parametrize("dimensions", [6, 12])
def test_points_are_even_and_independent(dimensions):
    """Correlations of n independent points have the standard deviation 1 / √n; four times this value is
    allowed."""
    drawn = points(2048, dimensions, 3)
    assert min(stats.kstest(column, "uniform").pvalue for column in drawn.T) > 1e-3
    assert np.abs(np.corrcoef(drawn, rowvar=False) - np.eye(dimensions)).max() < 4 / math.sqrt(2048)


def test_few_numbers_are_spread_more_evenly_than_chance():
    """Each of 256 equal intervals contains one of 256 points of a scrambled net."""
    for column in points(256, 2, 1).T:
        assert sorted(np.floor(256 * column).astype(int)) == list(range(256))


def test_of_many_numbers_no_two_move_as_one():
    """No two of 83 parameters are correlated more than chance allows.

    Correlations of n independent points have the standard deviation 1/√n. The largest of 3403 is about four
    times this value; five times is allowed.
    """
    found = np.corrcoef(stats.norm.ppf(points(128, 83, 0)), rowvar=False) - np.eye(83)
    assert np.abs(found).max() < 5 / math.sqrt(128)

"""What a user writes as a distribution, and points drawn from several."""

import math
import re

import numpy as np
import pytest
from scipy import stats

from masonry_opt.errors import OptionError
from masonry_opt.studies.many.draws import distribution, lognormal, parse, points


def test_a_lognormal_has_the_mean_and_deviation_given():
    law = lognormal(0.65, 0.0975)
    assert (law.mean(), law.std()) == pytest.approx((0.65, 0.0975))
    # Its logarithm is normal: the median is the mean over the root of 1 + (deviation / mean)².
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
        "lognormal",
        ("lognormal", 0.6),
        ("gamma", 1, 2),
        ("lognormal", 0.0, 0.1),
        ("normal", 1, 0),
        ("normal", 1, math.nan),
        ("normal", "1", 1),
        ("normal", -1, 1.5),
        ("uniform", 2, 1),
        ("uniform", 1, "15%"),
        0.6,
    ],
)
def test_what_is_no_distribution_is_refused(given):
    with pytest.raises(OptionError, match=r"'joints\.friction'"):
        distribution("joints.friction", given)


@pytest.mark.parametrize("kind", ["lognormal", "normal"])
def test_per_cent_given_as_a_number_are_told_from_it(kind):
    """Of 15 for 15 per cent; what it says to write in its place is what it says."""
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
    """The deviation of a correlation of independent points is 1 / √n."""
    drawn = points(2048, dimensions, 3)
    assert min(stats.kstest(column, "uniform").pvalue for column in drawn.T) > 1e-3
    assert np.abs(np.corrcoef(drawn, rowvar=False) - np.eye(dimensions)).max() < 4 / math.sqrt(2048)


def test_few_numbers_are_spread_more_evenly_than_chance():
    """Of 256 points of a scrambled net each of 256 equal intervals has one."""
    for column in points(256, 2, 1).T:
        assert sorted(np.floor(256 * column).astype(int)) == list(range(256))


def test_of_many_numbers_no_two_move_as_one():
    """Independent points of n runs have correlations of deviation 1/√n; the largest of 3403 is some four."""
    found = np.corrcoef(stats.norm.ppf(points(128, 83, 0)), rowvar=False) - np.eye(83)
    assert np.abs(found).max() < 5 / math.sqrt(128)

"""Tests of kinematic checks: a rocking block and a column of two masses by hand, and wrong input."""

import math
from functools import cache

import numpy as np
import pytest
from scenes import block_on_floor, on_floor

import masonry_opt as mo
from masonry_opt.errors import OptionError
from masonry_opt.finite_motion.kinematic_check import _strut_changes, activation
from masonry_opt.finite_motion.struts import StrutPath
from masonry_opt.problem.limited_forces import Role
from masonry_opt.scene.blocks import rectangle
from masonry_opt.solution.reasons import Code

SPECTRUM = [(0.0, 0.2), (0.15, 0.5), (0.5, 0.5), (1.0, 0.25), (2.0, 0.125), (4.0, 0.03125)]


@cache
def rocking(b: float = 1.0, h: float = 2.0, **options: int) -> mo.Capacity:
    return mo.capacity(mo.solve(block_on_floor(b, h, friction=3.0), "static"), **options)


@pytest.mark.slow
def test_the_kinematic_check_of_a_rocking_block():
    """The check of a rocking block agrees with hand calculation: one mass has e* = 1 and M* = W/g.

    After the centroid has moved by d, the acceleration is (b/2 − d)/√(R² − (b/2 − d)²).
    """
    b, h, g, FC = 0.6, 3.0, 9.81, 1.35
    check = rocking(b, h, steps=60).check(SPECTRUM)
    assert check.mass_fraction == pytest.approx(1)
    assert check.mass == pytest.approx(1 / g)
    assert check.acceleration == pytest.approx(b / h / FC)
    assert check.displacement == pytest.approx(b / 2)
    assert (check.ultimate, check.secant) == pytest.approx((0.2 * b, 0.08 * b))
    left = b / 2 - 0.08 * b
    at_secant = left / math.sqrt((b / 2) ** 2 + (h / 2) ** 2 - left**2) / FC
    assert check.secant_acceleration == pytest.approx(at_secant, rel=1e-5)
    period = 2 * math.pi * math.sqrt(0.08 * b / (at_secant * g))
    assert check.period == pytest.approx(period, rel=1e-5)
    spectral = np.interp(period, *np.transpose(SPECTRUM))
    assert check.demand_displacement == pytest.approx(spectral * g * (period / 2 / math.pi) ** 2, rel=1e-5)
    assert check.demand_acceleration == 0.1
    assert (check.linear, check.complete) == (True, True)
    assert check.non_linear == (0.2 * b >= check.demand_displacement)


@pytest.mark.slow
def test_the_mass_that_takes_part_and_the_oscillator():
    """The participating mass and the displacement of the oscillator agree with hand calculation.

    Two equal masses at h/4 and 3h/4 have e* = (1 + 3)²/(2 (1 + 9)) = 0.8. The displacement d* is d (1 + 9)/(3
    (1 + 3)) if d is that of the upper centroid, and d/e* if d is the mean.
    """
    h = 4.0
    masses = [
        mo.Block(name=str(k), vertices=rectangle(0, 0.5, y, y + h / 2), weight=2, live=(2, 0))
        for k, y in enumerate((0, h / 2))
    ]
    result = mo.solve(on_floor(*masses, friction=2.0), "static")
    mean, upper = mo.capacity(result), mo.capacity(result, block="1")
    one, other = mean.check(SPECTRUM), upper.check(SPECTRUM)
    assert one.mass_fraction == pytest.approx(0.8)
    assert one.mass == pytest.approx(0.8 * 4 / 9.81)
    assert one.acceleration == pytest.approx(result.load_factor / 0.8 / 1.35)
    assert one.displacement == pytest.approx(mean.displacement / 0.8)
    assert other.displacement == pytest.approx(upper.displacement * 10 / 12)


@pytest.mark.slow
def test_the_check_of_2018_of_a_rocking_block():
    """The check of a rocking block by NTC 2018 agrees with C8.7.1.2.1.6 to C8.7.1.2.1.8.

    d_SLV = 0.4 d_0 has the period T = 1.68 π √(d/a), and d_SLC = 0.6 d_0 has T = 1.56 π √(d/a).
    """
    b, h, g, FC = 0.6, 3.0, 9.81, 1.35
    curve = rocking(b, h, steps=60)
    spectrum = [(0.0, 0.2), (0.15, 0.5), (0.5, 0.5), (1.0, 0.25), (2.0, 0.125), (9.0, 0.03)]
    for state, share, factor in (("SLV", 0.4, 1.68), ("SLC", 0.6, 1.56)):
        check = curve.check(spectrum, code=f"NTC 2018 {state}")
        limit = share * b / 2
        assert (check.ultimate, check.secant) == pytest.approx((limit, limit))
        left = b / 2 - limit
        at_limit = left / math.sqrt((b / 2) ** 2 + (h / 2) ** 2 - left**2) / FC
        assert check.secant_acceleration == pytest.approx(at_limit, rel=1e-5)
        period = factor * math.pi * math.sqrt(limit / (at_limit * g))
        assert check.period == pytest.approx(period, rel=1e-5)
        spectral = np.interp(period, *np.transpose(spectrum))
        assert check.demand_displacement == pytest.approx(
            spectral * g * (period / 2 / math.pi) ** 2, rel=1e-5
        )
        assert (check.onset, check.acceleration) == pytest.approx((b / h, b / h / FC))
        linear = (0.1, True) if state == "SLV" else (None, None)
        assert (check.demand_acceleration, check.linear) == linear
        assert f"NTC 2018 {state}" in str(check)


def test_the_demand_of_2018_is_the_largest_of_all_shorter_periods():
    """The demand is that at T = 1.1667 s, a shorter period than that of the block.

    The spectrum falls from 1 g at 1 s to 0.2 g at 1.6 s. S T² is largest where 3 T = 2 · 1.75, at T = 1.1667
    s, with S = 1 − 0.1667/0.6 · 0.8 = 0.7778 g.
    """
    spectrum = [(0.0, 0.2), (1.0, 1.0), (1.6, 0.2), (9.0, 0.01)]
    check = rocking(0.6, 3.0, steps=60).check(spectrum, code="NTC 2018 SLV")
    assert check.period > 1.6
    expected = 0.777778 * 9.81 * (1.166667 / (2 * math.pi)) ** 2
    assert check.demand_displacement == pytest.approx(expected, rel=1e-5)
    of_2008 = rocking(0.6, 3.0, steps=60).check(spectrum, ultimate=0.4, secant=1.0)
    assert of_2008.demand_displacement < expected


@pytest.mark.slow
def test_masses_at_rest_do_not_take_part():
    """A block that does not move takes no part: e* is 1, as for the overturning block alone.

    The right block overturns. The left block is four times as wide and stays at rest.
    """
    blocks = [
        mo.Block(name=name, vertices=rectangle(*ends, 0, 2), unit_weight=1, live_per_weight=(1, 0))
        for name, ends in (("wide", (-4, 0)), ("slim", (1, 2)))
    ]
    curve = mo.capacity(mo.solve(on_floor(*blocks, friction=2.0), "static"))
    check = curve.check([(0, 0.1), (9, 0.1)])
    assert check.mass_fraction == pytest.approx(1)
    assert check.mass == pytest.approx(2 / 9.81)
    assert check.acceleration == pytest.approx(0.5 / 1.35)
    assert check.displacement == pytest.approx(0.5)


def test_accelerations_of_earthquakes_from_all_sides():
    """Accelerations of earthquakes in both directions agree with hand calculation.

    Two equal masses are at h/4 and 3h/4 above the toe: λ = b/h and e* = (1 + 3)²/(2 (1 + 9)) = 0.8.
    """
    h = 4.0
    masses = [
        mo.Block(name=str(k), vertices=rectangle(0, 0.5, y, y + h / 2), weight=2)
        for k, y in enumerate((0, 2))
    ]
    scene = on_floor(*masses, friction=2.0)
    table = mo.directions(scene, "static").table
    for row in table[["a_0", "mass_fraction", "a_star_0"]].to_numpy():
        np.testing.assert_allclose(row, [0.125, 0.8, 0.125 / 0.8 / 1.35], rtol=1e-6)
    tilted = mo.directions(scene, "static", vertical=0.3)
    assert tilted.table["a_star_0"].isna().all()
    assert tilted.as_dict()["directions"][0]["a_0"] is None
    tenth = scene.replace(earthquake={"direction": "right", "coefficient": 0.1})
    activated = activation(mo.solve(tenth, "static"))
    assert (activated.acceleration, activated.mass_fraction) == pytest.approx((0.125, 0.8), rel=1e-6)
    assert activation(mo.solve(block_on_floor(friction=3.0), "static")) is None


@pytest.mark.slow
@pytest.mark.parametrize("part", [{"coefficient": 0.15}, {"vertical": 0.3}])
def test_an_earthquake_of_a_part_of_the_weights_is_not_checked(part):
    """An earthquake whose forces are not the weights of the masses is refused: M* and a*_0 would be wrong."""
    shaken = block_on_floor(friction=3.0, live=(0, 0)).replace(earthquake={"direction": "right"} | part)
    curve = mo.capacity(mo.solve(shaken, "static"))
    with pytest.raises(OptionError, match="coefficient"):
        curve.check(SPECTRUM)


@pytest.mark.slow
@pytest.mark.parametrize("live", [(0.1, 0.0), (1.0, 0.1), (3.0, 0.0)])
def test_a_live_load_that_is_not_the_weight_is_not_checked(live):
    curve = mo.capacity(mo.solve(block_on_floor(friction=3.0, live=live), "static"))
    with pytest.raises(OptionError, match="live_per_weight"):
        curve.check(SPECTRUM)


@pytest.mark.parametrize("given", ["a.toml", block_on_floor()])
def test_a_curve_is_of_a_result(given):
    with pytest.raises(OptionError, match=r"mo\.solve"):
        mo.capacity(given)


@pytest.mark.slow
def test_wrong_spectra_and_values_are_refused():
    curve = rocking()
    for spectrum in ("none", [(0, 1)], [(0, 1), (0, 2)], [(0.1, 1), (4, 2)], [(0, 1), (4, -2)]):
        with pytest.raises(OptionError, match="the spectrum must be a list of pairs"):
            curve.check(spectrum)
    with pytest.raises(OptionError, match=r"the spectrum ends at .*: add longer periods"):
        curve.check([(0, 1), (0.01, 1)])
    with pytest.raises(OptionError, match="no secant period exists"):
        curve.check(SPECTRUM, ultimate=1.0, secant=1.0)
    with pytest.raises(OptionError, match="unknown code 'NTC 2018': choose from 'NTC 2008', 'NTC 2018 SLV'"):
        curve.check(SPECTRUM, code="NTC 2018")
    for name, value in {"gravity": 0, "ultimate": 1.1, "behaviour_factor": "2"}.items():
        with pytest.raises(OptionError, match=name):
            curve.check(SPECTRUM, **{name: value})


def slender(length: float) -> mo.Capacity:
    """Return the curve of a block of 0.3 m × 3 m, in a unit of length of which a metre has ``length``."""
    return pushed(0.3 * length, 3 * length)


@cache
def pushed(width: float, height: float) -> mo.Capacity:
    """Return the curve of a block that is pushed by its weight."""
    block = mo.Block(name="A", vertices=rectangle(0, width, 0, height), weight=1, live=(1, 0))
    floor = mo.Block(name="floor", vertices=rectangle(-width, 2 * width, -width, 0), fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.7), blocks=[block, floor])
    return mo.capacity(mo.solve(scene, "static"), steps=10)


@pytest.mark.parametrize(
    ("length", "gravity", "warned"),
    [
        (1.0, 9.81, False),
        (1e3, 9.81, True),
        (1e3, 9810.0, False),
        (1e2, 9.81, True),
        (1e2, 981.0, False),
        (1.0, 9810.0, True),
    ],
)
def test_a_gravity_of_another_unit_of_length_is_warned_of(length, gravity, warned):
    """A block of 0.3 m × 3 m, in different units of length, has the same verdict only with the right gravity.

    ``length`` is the number of units in a metre.
    """
    spectrum = [*SPECTRUM, (100.0, 0.00005)]
    right = slender(1.0).check(spectrum, code="NTC 2018 SLV")
    check = slender(length).check(spectrum, code="NTC 2018 SLV", gravity=gravity)
    assert not right.non_linear
    assert [warning.code for warning in check.warnings] == [Code.GRAVITY_DIFFERS] * warned
    assert ("warning: gravity" in str(check)) == ("if the gravity is correct" in str(check)) == warned
    assert [warning["gravity"] for warning in check.as_dict()["warnings"]] == [gravity] * warned
    if not warned:
        assert check.period == pytest.approx(right.period)
        assert check.non_linear == right.non_linear
        unit = {9.81: "metres", 981.0: "centimetres", 9810.0: "millimetres"}[gravity]
        assert f"{gravity:g}: lengths are in {unit}" in str(check)


@pytest.mark.parametrize(
    ("width", "height", "gravity", "ratios", "warned"),
    [
        (4, 45, 9.81, {"code": "NTC 2018 SLC"}, False),
        (0.3, 3, 9.81, {"ultimate": 1.0, "secant": 0.95}, False),
        (60, 300, 9.81, {}, True),
        (60, 300, 981.0, {}, False),
    ],
)
def test_a_long_secant_period_is_no_wrong_gravity(width, height, gravity, ratios, warned):
    """T_s exceeds 10 s for a tower of 4 m × 45 m, and for a block whose d*_s is close to d*_0.

    A block of 60 cm × 300 cm with the gravity of metres is higher than any tower. If the spectrum is too
    short, the error advises longer periods for a correct gravity, and another gravity for a wrong one.
    """
    curve = pushed(width, height)
    check = curve.check([*SPECTRUM, (100.0, 0.00005)], gravity=gravity, **ratios)
    assert (check.period > 10) == (gravity == 9.81)
    assert bool(check.warnings) == warned
    advice = "seem to use different units of length" if warned else "add longer periods"
    with pytest.raises(OptionError, match=advice):
        curve.check([(0.0, 1.0), (0.01, 1.0)], gravity=gravity, **ratios)


def test_the_change_of_a_tie_is_the_largest_on_the_way():
    """A tie that is longest halfway to d*_u is reported with its largest extension."""
    tie = StrutPath(Role.TIE, "rod", 2.0, np.array([0.0, 0.5, 0.1, 0.9]))
    slack = StrutPath(Role.TIE, "slack", 2.0, np.array([0.0, -0.5, -0.1, 0.9]))
    (change,) = _strut_changes([tie, slack], 2.0, np.array([0.0, 1.0, 2.0, 3.0]))
    assert (change.name, change.change, change.share) == ("rod", 0.5, 0.25)


def test_a_spectrum_too_short_for_a_wrong_gravity_leads_to_the_gravity():
    with pytest.raises(OptionError, match=r"ends at 4 s, before T_s = .* s: gravity 9\.81 .*--gravity"):
        slender(1000.0).check(SPECTRUM)


@pytest.mark.parametrize(
    ("method", "words", "known", "proven"),
    [
        ("static", "λ = 0.5 (associative): upper bound", "not proven to be the least", False),
        ("coulomb", "λ = 0.5 (least, proven): exact", "no other λ above zero is possible", True),
    ],
)
def test_a_check_says_on_which_load_factor_it_rests(method, words, known, proven):
    """The check quotes how its load factor is known: λ = 1/2 of a block half as wide as high, pushed by
    its weight. A λ that is proven to be the least is not followed by a remark on lower states."""
    block = mo.Block(name="A", vertices=[(0, 0), (1, 0), (1, 2), (0, 2)], weight=1, live=(1, 0))
    floor = mo.Block(name="floor", vertices=[(-1, -1), (2, -1), (2, 0), (-1, 0)], fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.9), blocks=[block, floor])
    check = mo.capacity(mo.solve(scene, method), steps=10).check(SPECTRUM)
    assert check.rests_on.startswith(words)
    assert known in check.rests_on
    assert ("if a collapse state with a lower λ exists" in check.rests_on) != proven
    assert f"rests on         {check.rests_on}\n" in str(check)

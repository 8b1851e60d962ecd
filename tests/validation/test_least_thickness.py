"""Least thickness of a semicircular arch of n voussoirs that cannot slide: Milankovitch (1907), Heyman."""

import math

import numpy as np
import pytest
from continuous_arch import least_thickness_ratio

import masonry_opt as mo
from masonry_opt.studies.many.standing import standing


def closed_form(voussoirs: int) -> float:
    """t/R for an even number of voussoirs, which have a joint at the crown."""
    return least_thickness_ratio("sector", math.pi / voussoirs * np.arange(1, voussoirs // 2))


def arch(voussoirs: int, thickness: float) -> mo.Scene:
    made = mo.Arch(radius=1, angles=(180, 0), thickness=thickness, voussoirs=voussoirs, unit_weight=1)
    return mo.Scene(joints=mo.JointDefaults(friction=math.inf), blocks=made.blocks())


@pytest.mark.parametrize("voussoirs", [8, 30])
def test_least_thickness_of_so_many_voussoirs(voussoirs):
    found = mo.least(lambda thickness: arch(voussoirs, thickness), 0.03, 0.3, samples=2)
    assert found.value == pytest.approx(closed_form(voussoirs), rel=1e-7)
    lower, upper = found.interval
    assert upper <= lower * (1 + 1e-6)
    assert found.fails.number < 0 < found.holds.number + 1e-9
    assert not found.jump


def test_voussoirs_come_to_milankovitchs_thickness_from_below():
    """With more joints there are more at which the thrust might leave: 0.1075."""
    ratios = [closed_form(voussoirs) for voussoirs in (8, 30, 240, 2400)]
    assert all(ratio <= least_thickness_ratio("sector") for ratio in ratios)
    assert ratios[-1] == pytest.approx(0.1075, abs=5e-5)
    assert ratios[-1] == pytest.approx(least_thickness_ratio("sector"), rel=1e-5)


def test_a_long_arch_has_a_margin_next_to_its_least_thickness():
    """Its thrust is some 250 voussoir weights, beside which a margin of zero is to be found."""
    thickness = closed_form(500)
    margins = [standing(arch(500, thickness * factor)).margin for factor in (1 - 1e-6, 1 + 1e-6)]
    assert margins[0] < 0 < margins[1]

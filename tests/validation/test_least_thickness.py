"""Tests of the least thickness of a semicircular arch that cannot slide: Milankovitch (1907), Heyman."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from speeds import slow

import masonry_opt as mo
from masonry_opt.studies.many.standing import standing


def least_ratio(joints: np.ndarray, weights_at: float = 1 / 12) -> float:
    """Return t/R of the thinnest arch with joints at the given angles from the crown.

    The thrust line passes through the extrados at the crown and the springings, at R + t/2. It touches the
    intrados, r = R − t/2, at one of the joints between. Let R = 1, η = t/R, and let the weight be 1 per
    angle.

    The part between the crown and a joint at the angle β weighs β. Its moment about the joint's intrados is β
    r sin β − ℓ (1 − cos β), where ℓ = 1 + ``weights_at`` η² is the distance of the weights from the centre.
    The thrust at the crown has the lever 1 + η/2 − r cos β about this point. By equilibrium about the
    extrados of the springing, the thrust is π/2 − ℓ / (1 + η/2).
    """

    def surplus(eta: float) -> float:
        inner, outer, lever = 1 - eta / 2, 1 + eta / 2, 1 + weights_at * eta**2
        moment = joints * inner * np.sin(joints) - lever * (1 - np.cos(joints))
        needed = (moment / (outer - inner * np.cos(joints))).max()
        return math.pi / 2 - lever / outer - float(needed)

    return float(brentq(surplus, 0.02, 0.3, xtol=1e-13))


def closed_form(voussoirs: int) -> float:
    """Return t/R for an even number of voussoirs, which have a joint at the crown."""
    return least_ratio(math.pi / voussoirs * np.arange(1, voussoirs // 2))


def arch(voussoirs: int, thickness: float) -> mo.Scene:
    made = mo.Arch(radius=1, angles=(180, 0), thickness=thickness, voussoirs=voussoirs, unit_weight=1)
    return mo.Scene(joints=mo.JointDefaults(friction=math.inf), blocks=made.blocks())


@pytest.mark.parametrize("voussoirs", [8, *slow(30)])
def test_least_thickness_of_so_many_voussoirs(voussoirs):
    found = mo.least(lambda thickness: arch(voussoirs, thickness), 0.03, 0.3, samples=2)
    assert found.value == pytest.approx(closed_form(voussoirs), rel=1e-7)
    lower, upper = found.interval
    assert upper <= lower * (1 + 1e-6)
    assert found.fails.number < 0 < found.holds.number + 1e-9
    assert not found.jump


def test_voussoirs_come_to_milankovitchs_thickness_from_below():
    """With more voussoirs, the least thickness grows to Milankovitch's 0.1075.

    More joints are more places at which the thrust line might leave the arch. With weights on the centreline,
    the limit is 0.107426 (Cocchetti & Rizzi 2020).
    """
    anywhere = np.linspace(0.05, 1.5, 200_001)
    known = least_ratio(anywhere)
    assert known == pytest.approx(0.107478, abs=6e-7)
    assert least_ratio(anywhere, weights_at=0.0) == pytest.approx(0.107426, abs=6e-7)
    ratios = [closed_form(voussoirs) for voussoirs in (8, 30, 240, 2400)]
    assert max(ratios) == ratios[-1] <= known
    assert ratios[-1] == pytest.approx(known, rel=1e-5)


@pytest.mark.slow
def test_a_long_arch_has_a_margin_next_to_its_least_thickness():
    """The margin changes its sign at the least thickness, although the thrust is some 250 voussoir
    weights."""
    thickness = closed_form(500)
    margins = [standing(arch(500, thickness * factor)).margin for factor in (1 - 1e-6, 1 + 1e-6)]
    assert margins[0] < 0 < margins[1]

"""Generated scenes in space compared with an arch, with a closed form, and with a program of one sector."""

from math import cos, pi

import pytest
from space.dome_sector import load_on_key
from speeds import slow

import masonry_opt as mo


def dome(thickness, rings, voussoirs, bond, friction):
    """Return a dome with a downward live load on its key."""
    keys = {"radius": 1, "thickness": thickness, "rings": rings, "voussoirs": voussoirs, "bond": bond}
    blocks = mo.Dome(**keys, unit_weight=1).blocks()
    return mo.Scene(
        joints={"friction": friction}, blocks=blocks, loads=[mo.Load(block="key", live=(0, 0, -1))]
    )


@pytest.mark.parametrize(
    "keys", [{}, {"stone": 1.0, "bond": "stacked"}, *slow({"stone": 1.0}, {"skewbacks": 0.5})]
)
def test_a_barrel_carries_what_its_arch_does(keys):
    """A barrel vault has the associative load factor of its arch, to 1e-6.

    The forces of the arch are in equilibrium in each slice of the barrel. The mechanism of the arch moves the
    whole barrel.
    """
    arch = {"span": 4.0, "rise": 1.0, "thickness": 0.4, "voussoirs": 9, "unit_weight": 1.0}
    arch |= {"skewbacks": keys["skewbacks"]} if "skewbacks" in keys else {}
    flat = mo.Scene(joints={"friction": 0.7}, blocks=mo.Arch(**arch, live_per_weight=(1, 0)).blocks())
    barrel = mo.Barrel(**arch | keys, length=3.0, live_per_weight=(1, 0, 0))
    deep = mo.Scene(joints={"friction": 0.7}, blocks=barrel.blocks())
    # The mechanism has hinges with friction 0.7, and slips with friction 0.3.
    for friction in (0.7, 0.3):
        one, other = (mo.solve(scene.replace(friction=friction), "static") for scene in (flat, deep))
        assert other.load_factor == pytest.approx(one.load_factor, abs=1e-6)


@pytest.mark.slow
def test_a_groin_vault_carries_as_much_from_either_side():
    keys = {
        "span": 4,
        "rise": 1.2,
        "thickness": 0.4,
        "voussoirs": 6,
        "bay": 6,
        "stone": 0.8,
        "unit_weight": 1,
    }
    vaults = [mo.Groin(**keys, live_per_weight=push) for push in ((1, 0, 0), (0, 1, 0), (-1, 0, 0))]
    found = [mo.solve(mo.Scene(joints={"friction": 0.7}, blocks=of.blocks()), "static") for of in vaults]
    assert found[0].certificate.worst < 1e-6
    for other in found[1:]:
        assert other.load_factor == pytest.approx(found[0].load_factor, rel=1e-6)


@pytest.mark.parametrize(("sides", "drums"), [(4, 1), (16, 6)])
def test_a_shaft_overturns_about_a_side_of_its_foot(sides, drums):
    """A shaft pushed at half its height by λ times its weight overturns at λ = d cos(π/n)/h, to 1e-7."""
    made = mo.Shaft(diameter=1, sides=sides, height=5, drums=drums, unit_weight=1, live_per_weight=(1, 0, 0))
    found = mo.solve(mo.Scene(joints={"friction": 0.7}, blocks=made.blocks()), "static")
    assert found.load_factor == pytest.approx(cos(pi / sides) / 5, abs=1e-7)


@pytest.mark.parametrize(("thickness", "friction"), [(0.1, 0.7), (0.15, 0.4)])
def test_a_dome_carries_on_its_key_what_a_sector_does(thickness, friction):
    found = mo.solve(dome(thickness, 5, 8, "meridians", friction), "static")
    expected = load_on_key(1, thickness, 5, 8, friction)
    assert found.load_factor == pytest.approx(expected, rel=1e-6)
    assert found.certificate.worst < 1e-6


def test_slices_of_an_orange_stand_from_the_thickness_known():
    """A hemispherical dome without hoop forces is stable from t/R = 0.042 on, to 2.5 %.

    The value is that of Heyman (1967), "On shell solutions for masonry domes".
    """
    low, high = 0.01, 0.1
    while high - low > 1e-5:
        middle = (low + high) / 2
        stands = load_on_key(1, middle, 40, 100, 0.9, hoops=False) is not None
        low, high = (low, middle) if stands else (middle, high)
    assert high == pytest.approx(0.042, rel=0.025)

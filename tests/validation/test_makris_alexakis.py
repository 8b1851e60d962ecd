"""Tests of Makris & Alexakis (2013): a semicircular arch with vertical cuts needs 0.1095 of its radius.

The thrust H acts at the extrados of the crown, R₂ above the springing. M(x) is the moment about the vertical
at x of the masonry between x and the crown. The thrust line passes x at the height R₂ - M(x)/H.

This height is not below the intrados, so that H is at least M(x) / (R₂ - y₁(x)). The thrust line meets the
springing within the extrados, so that H is at most M(R₂) / R₂. At the least thickness, the largest of the
lower limits equals the upper limit.
"""

import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hinges import four_hinge_load_factors
from scenes import CASES, solved
from scipy.optimize import brentq, minimize_scalar

import masonry_opt as mo

PATH = CASES / "makris_alexakis" / "vertical_cuts.toml"


def under_circle(radius: float, x: float) -> float:
    """Return the moment about the vertical at x of the area below a circle from 0 to x: ∫ (x - u) √(R² - u²)
    du."""
    left = math.sqrt(max(radius**2 - x**2, 0.0))
    area = (x * left + radius**2 * math.asin(x / radius)) / 2
    return x * area - (radius**3 - left**3) / 3


def spare_thrust(thickness: float) -> float:
    """Return the largest H that the springing allows, less the least H that the intrados requires."""
    inner, outer = 1 - thickness / 2, 1 + thickness / 2

    def least(x: float) -> float:
        moment = under_circle(outer, x) - under_circle(inner, x)
        return moment / (outer - math.sqrt(inner**2 - x**2))

    needed = minimize_scalar(lambda x: -least(x), bounds=(0.3, inner - 1e-9), method="bounded")
    void = math.pi * inner**2 / 4 * outer - inner**3 / 3  # Moment of the quarter circle about R₂.
    return (under_circle(outer, outer) - void) / outer + needed.fun


@cache
def least_thickness() -> float:
    return float(brentq(spare_thrust, 0.05, 0.3, xtol=1e-12))


def ring(cuts: int, thickness: float) -> mo.Scene:
    """Return stones between vertical cuts, the middle one of which is at the crown, and a foot on either
    side."""
    inner, outer = 1 - thickness / 2, 1 + thickness / 2

    def on_circle(radius: float, x: float) -> tuple[float, float]:
        return x, math.sqrt(max(radius**2 - x**2, 0.0))

    loads, stones = {"unit_weight": 1, "live": (1, 0)}, []
    for number, (a, b) in enumerate(pairwise(np.linspace(-inner, inner, cuts).tolist()), 1):
        corners = [on_circle(*of) for of in ((inner, a), (inner, b), (outer, b), (outer, a))]
        stones.append(mo.Block(name=f"v{number}", vertices=corners, **loads))
    back = [on_circle(outer, x) for x in np.linspace(outer, inner, 9).tolist()]
    for side, name in ((1, "right"), (-1, "left")):
        foot = [(side * x, y) for x, y in [(inner, 0.0), *back]]
        stones.append(mo.Block(name=f"{name} foot", vertices=foot, **loads))
        springing = [(side * x, y) for x, y in [(inner, -0.5), (2.0, -0.5), (2.0, 0.0), (inner, 0.0)]]
        stones.append(mo.Block(name=f"{name} springing", vertices=springing, fixed=True))
    return mo.Scene(joints=mo.JointDefaults(friction=math.inf), blocks=stones)


def test_the_closed_form_is_the_published_thickness():
    assert least_thickness() == pytest.approx(0.1095, abs=5e-5)


@pytest.mark.slow
def test_many_cuts_begin_to_stand_at_the_closed_form():
    """An arch with 401 cuts becomes stable at the closed form, to 5e-4.

    With fewer cuts, the hinge at the intrados is farther from its place in the closed form.
    """
    found = mo.least(lambda thickness: ring(401, thickness), 0.1, 0.12, samples=0, tolerance=1e-4)
    assert found.value == pytest.approx(least_thickness(), rel=5e-4)
    assert found.fails.number < 0 < found.holds.number


def by_enumeration() -> float:
    stones = [block.corners() for block in mo.load(PATH).blocks if not block.fixed]
    weight = np.array([shapely.Polygon(stone).area for stone in stones])
    at = np.array([shapely.Polygon(stone).centroid.coords[0] for stone in stones])
    # Cuts have their intrados first. Stones are drawn from there counter-clockwise, and the left foot
    # clockwise.
    joints = [stones[0][[0, 1]], *(stone[[0, 3]] for stone in stones[1:]), stones[-1][[0, 1]]]
    found = four_hinge_load_factors(np.array(joints), weight, at)
    np.testing.assert_allclose(found, found[0], rtol=1e-9)
    return float(found[0])


@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_load_factor_of_the_case(method):
    """The load factor agrees with an enumeration of hinges; the file has twelve digits of coordinates and
    weights."""
    assert solved(PATH, method).load_factor == pytest.approx(by_enumeration(), rel=1e-8)


def test_vertical_cuts_need_more_friction_than_stone_has():
    """Friction of 1.8 is needed at the cut where the intrados ends.

    The thrust at the crown is largest if its line passes through the intrados there and through the extrados
    at the springing. The cut carries all of the weight but that of the foot by friction.
    """
    scene = mo.load(PATH)
    inner, outer = 0.94, 1.06
    right = [shapely.Polygon(block.corners()) for block in scene.blocks if not block.fixed][9:]
    weight = sum(stone.area for stone in right)
    lever = sum(stone.area * (outer - stone.centroid.x) for stone in right)
    needed = (weight - right[-1].area) / (lever / inner)
    assert needed == pytest.approx(1.8, abs=0.05)
    smoother = scene.model_copy(update={"joints": mo.JointDefaults(friction=0.999 * needed)})
    assert solved(smoother, "static").status is mo.Status.UNSTABLE

"""Tests of earthquakes against closed forms: vertical components, masses that are no weights, and space.

A block of weight W, base b and height h is on a plane. It is pushed by λ W sideways and by r λ W along
gravity, so that the normal force on its base is N = W (1 + r λ). It turns about an edge if λ W h/2 = N b/2,
and slides if λ W = μ N. Its load factor is therefore

    λ = min(b / (h − r b), μ / (1 − r μ))

A mass m that is no dead load, at height y above the middle of the base, adds to the push:

    λ (W h/2 + m y − r (W + m) b/2) = W b/2
"""

import math

import numpy as np
import pytest
from scenes import block_on_floor
from scenes_in_space import box_on_floor, corner_wall
from scipy.spatial.transform import Rotation
from space.mappings_in_space import mapped

import masonry_opt as mo


def quake(scene: mo.Scene, method: str = "static", **keys: object) -> float:
    return mo.solve(scene.shaken(mo.Earthquake(**keys)), method, incremental=False).required()


def test_an_angle_along_an_axis_is_exactly_this_axis():
    """cos 90° is 6e-17 in floating-point arithmetic, which may lead to another collapse state."""
    axes = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)]
    for turns in (-1, 0, 2):
        found = [mo.Earthquake(direction=360 * turns + 90 * number).towards for number in range(4)]
        assert found == axes
    assert mo.Earthquake(direction=-1e-16).towards == axes[0]  # -1e-16 modulo 360 is 360
    half = math.sqrt(0.5)
    assert mo.Earthquake(direction=-45).towards == pytest.approx((half, -half, 0.0), rel=1e-15)


@pytest.mark.parametrize(("side", "vertical"), [("left", -0.5), ("right", 0.4)])
@pytest.mark.parametrize(("width", "height", "friction"), [(1.0, 3.0, 0.6), (4.0, 1.0, 0.6)])
@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_a_block_on_a_plane(method, width, height, friction, vertical, side):
    scene = block_on_floor(width, height, friction)
    turns = width / (height - vertical * width) if height > vertical * width else math.inf
    slides = friction / (1 - vertical * friction)
    found = quake(scene, method, direction=side, vertical=vertical)
    assert found == pytest.approx(min(turns, slides), rel=1e-9)


def test_a_design_coefficient_makes_the_load_factor_one_on_it():
    scene = block_on_floor(1.0, 3.0)
    assert quake(scene, direction="left", coefficient=0.15) == pytest.approx(1 / 3 / 0.15, rel=1e-9)


@pytest.mark.parametrize("vertical", [-0.3, 0.3])
def test_a_mass_that_is_no_dead_load(vertical):
    width, height, mass, at = 1.0, 3.0, 0.7, 2.5
    load = mo.Load(block="A", mass=mass, at=(width / 2, at))
    scene = block_on_floor(width, height).model_copy(update={"loads": [load]})
    resisted = width / 2
    driven = height / 2 + mass * at - vertical * (1 + mass) * width / 2
    assert quake(scene, direction="right", vertical=vertical) == pytest.approx(resisted / driven, rel=1e-9)


@pytest.mark.parametrize(
    ("load", "mass"),
    [
        # By default, the component along gravity is mass.
        (mo.Load(block="A", dead=(0.2, -2.0), at=(0.5, 3.0)), 2.0),
        (mo.Load(block="A", dead=(0.2, -2.0), at=(0.5, 3.0), mass=0.0), 0.0),
        (mo.Load(block="A", dead=(0.2, -2.0), at=(0.5, 3.0), mass=0.8), 0.8),
        (mo.EdgeLoad(start=(0, 3), end=(1, 3), force=(0.2, -2.0)), 2.0),
        (mo.EdgeLoad(start=(0, 3), end=(1, 3), force=(0.2, -2.0), mass=0.8), 0.8),
        (mo.EdgeLoad(start=(0, 3), end=(1, 3), pressure=2.0), 0.0),  # Pressure of water or earth has no mass.
        (mo.EdgeLoad(start=(0, 3), end=(1, 3), pressure=2.0, mass=0.8), 0.8),
    ],
)
def test_dead_loads_that_are_mass_and_those_that_are_none(load, mass):
    """A dead load counts as mass by its weight or by its key `mass`; a pressure does not unless it has this
    key.

    The block turns about its right edge: λ (W h/2 + m h) = (W + F) b/2 − H h, where F and H are the vertical
    and the horizontal component of the load.
    """
    key = "loads" if isinstance(load, mo.Load) else "edge_loads"
    scene = block_on_floor(1.0, 3.0).model_copy(update={key: [load]})
    aside = 0.0 if getattr(load, "pressure", None) else 0.2
    found = quake(scene, direction="right")
    assert found == pytest.approx((1.5 - 3 * aside) / (1.5 + 3 * mass), rel=1e-9)


@pytest.mark.parametrize(
    ("given", "mass"),
    [
        ({"block": (0.2, -2.0)}, 0.0),
        ({"load": mo.Load(block="A", dead=(0.2, -2.0), at=(0.5, 1.5))}, 0.0),
        ({"load": mo.Load(block="A", dead=(0.2, -2.0), at=(0.5, 1.5), mass=0.8)}, 0.8),
        ({"line": mo.EdgeLoad(start=(0, 3), end=(1, 3), force=(0.1, -2.0))}, 0.0),
    ],
)
def test_dead_forces_without_mass(given, mass):
    """With `dead_as_mass` false, a dead force is a mass only if the load states one.

    The block has b = 1, h = 3 and W = 1. The force (0.2, -2) acts at its middle, or (0.1, -2) acts on its
    top, with the same moment. By hand, λ (W + m) h/2 = (W + 2) b/2 - 0.2 h/2. If the force counts as mass, as
    by default, m is 2.
    """
    scene = block_on_floor(1.0, 3.0, friction=3.0, live=(0.0, 0.0), dead=given.get("block", (0.0, 0.0)))
    loads = {key: [given[of]] for key, of in (("loads", "load"), ("edge_loads", "line")) if of in given}
    scene = scene.replace(**loads, earthquake={"direction": "right", "dead_as_mass": False})
    assert mo.solve(scene, "static").required() == pytest.approx(1.2 / (1.5 * (1 + mass)), rel=1e-6)
    (right,) = mo.directions(scene, "static").table.query("direction == 'right'")["load_factor"]
    assert right == pytest.approx(1.2 / (1.5 * (1 + mass)), rel=1e-6)
    if "block" in given:
        counts = mo.solve(scene.replace(dead_as_mass=True), "static").required()
        assert counts == pytest.approx(1.2 / (1.5 * 3), rel=1e-6)


@pytest.mark.parametrize("kind", ["block", "load", "line"])
def test_a_dead_force_against_gravity_has_no_mass(kind):
    """The block has b = 1, h = 3 and W = 1, and the force F = 0.4 lifts it: λ W h/2 = (W - F) b/2."""
    lifts = (0.0, 0.4)
    scene = block_on_floor(1.0, 3.0, live=(0.0, 0.0), dead=lifts if kind == "block" else (0.0, 0.0))
    if kind == "load":
        scene = scene.replace(loads=[mo.Load(block="A", dead=lifts, at=(0.5, 3.0))])
    if kind == "line":
        scene = scene.replace(edge_loads=[mo.EdgeLoad(start=(0, 3), end=(1, 3), force=lifts)])
    assert quake(scene, direction="right") == pytest.approx(0.2, rel=1e-9)


def over_direction(size, friction, vertical, degrees):
    """Return the closed-form λ of a box that an earthquake pushes in a horizontal direction.

    The box turns about one of the edges towards which it is pushed. With N = W (1 + r λ), the resultant meets
    the base at λ W h/2 / N from its middle. Therefore λ = bᵢ / (h |eᵢ| − r bᵢ) about the edge across eᵢ.
    """
    a, b, height = size
    angle = math.radians(degrees)
    levers = ((a, abs(math.cos(angle))), (b, abs(math.sin(angle))))
    turns = [w / (height * e - vertical * w) for w, e in levers if height * e > vertical * w + 1e-9]
    return min(friction / (1 - vertical * friction), *turns)


@pytest.mark.slow
def test_the_polar_chart_of_a_box(tmp_path):
    size, friction = (2.0, 1.0, 3.0), 0.55
    found = mo.directions(
        box_on_floor(size, friction), "static", every=45, vertical=(0.0, -0.3), solver="clarabel"
    )
    assert len(found.table) == 16
    assert "direction (°)" in str(found)
    for row in found.table.itertuples():
        expected = over_direction(size, friction, row.vertical, row.direction)
        assert row.load_factor == pytest.approx(expected, rel=1e-6), row
    assert found.to_draw.assembly.scene.shaken_by == mo.Earthquake(direction=90.0, vertical=-0.3)
    axes = found.plot().axes[0]
    drawn = np.array(axes.lines[0].get_data())
    assert axes.name == "polar"
    assert drawn[:, -1] == pytest.approx(drawn[:, 0])  # The curve is closed.
    assert drawn[1, :-1] == pytest.approx(found.table["load_factor"][:8].to_numpy())
    found.save(tmp_path / "polar.png")


def test_a_scene_turned_in_plan_with_its_earthquake_has_the_same_coefficient():
    degrees = 37.0
    scene, turn = corner_wall(1, 1, 2), Rotation.from_euler("z", degrees, degrees=True).as_matrix()
    turned = mapped(scene, turn)
    for push in (20.0, 110.0):
        before = quake(scene, "static", direction=push, vertical=-0.2)
        assert quake(turned, "static", direction=push + degrees, vertical=-0.2) == pytest.approx(
            before, rel=1e-7
        )
        vector = tuple((turn @ [math.cos(math.radians(push)), math.sin(math.radians(push)), -0.4]).tolist())
        after = quake(turned, "static", direction=vector, vertical=-0.2)
        # The component of the vector along gravity does not count.
        assert after == pytest.approx(before, rel=1e-7)

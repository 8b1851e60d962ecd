"""Relations that hold whatever the load factor is."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scenes import CASES, small_wall

import masonry_opt as mo

#: A linear program solved to 1e-9, twice.
EXACT = 1e-7
#: The loop's own tolerance is 1e-5 on λ, and rounding may choose another optimal state on the way.
LOOP = 5e-4


def mapped(scene, point, force=lambda v: v, weight=1.0, order=None):
    """The scene with its points, forces and weights transformed, and its blocks in another order."""

    def moved(block):
        return mo.Block(
            name=block.name,
            vertices=[point(v) for v in block.vertices],
            weight=None if block.weight is None else weight * block.weight,
            live=tuple(weight * f for f in force(block.live)),
            fixed=block.fixed,
        )

    blocks = [moved(block) for block in scene.blocks]
    if order is not None:
        blocks = [blocks[index] for index in order]
    return mo.Scene(joints=scene.joints, gravity=force(scene.gravity), blocks=blocks)


def turned(angle):
    c, s = math.cos(angle), math.sin(angle)
    return lambda v: (c * v[0] - s * v[1], s * v[0] + c * v[1])


def mirrored(v):
    return (-v[0], v[1])


BASE = small_wall(6, 4)
SHUFFLED = np.random.default_rng(7).permutation(len(BASE.blocks))
SAME = {
    "moved": mapped(BASE, lambda v: (v[0] + 31.7, v[1] - 12.9)),
    "moved far": mapped(BASE, lambda v: (v[0] + 1e5, v[1] - 1e5)),
    "turned by 37°": mapped(BASE, turned(math.radians(37)), turned(math.radians(37))),
    "turned by 90°": mapped(BASE, turned(math.pi / 2), turned(math.pi / 2)),
    "mirrored": mapped(BASE, mirrored, mirrored),
    "in millimetres": mapped(BASE, lambda v: (1e3 * v[0], 1e3 * v[1])),
    "in newtons": mapped(BASE, lambda v: v, weight=2.3e4),
    "renumbered": mapped(BASE, lambda v: v, order=SHUFFLED),
}


@pytest.mark.parametrize("name", SAME)
@pytest.mark.parametrize("method", ["static", "kinematic"])
def test_associative_load_factor_is_unmoved(name, method):
    assert mo.solve(SAME[name], method).load_factor == pytest.approx(
        mo.solve(BASE, method).load_factor, rel=EXACT
    )


@pytest.mark.parametrize("name", SAME)
def test_loop_is_unmoved(name):
    assert mo.solve(SAME[name]).load_factor == pytest.approx(mo.solve(BASE).load_factor, rel=LOOP)


def test_mirrored_wall_has_the_mirrored_mechanism():
    one, other = mo.solve(BASE, "static").blocks, mo.solve(SAME["mirrored"], "static").blocks
    np.testing.assert_allclose(one["vx"], -other["vx"], atol=1e-6)
    np.testing.assert_allclose(one["vy"], other["vy"], atol=1e-6)
    np.testing.assert_allclose(one["omega"], -other["omega"], atol=1e-6)


def test_results_come_in_the_units_of_the_case():
    metres, millimetres = mo.solve(BASE, "static"), mo.solve(SAME["in millimetres"], "static")
    np.testing.assert_allclose(millimetres.joints["length"], 1e3 * metres.joints["length"])
    np.testing.assert_allclose(millimetres.joints["n"], metres.joints["n"], atol=1e-6)
    np.testing.assert_allclose(millimetres.joints["m"], 1e3 * metres.joints["m"], atol=1e-3)
    newtons = mo.solve(SAME["in newtons"], "static")
    np.testing.assert_allclose(newtons.joints["n"], 2.3e4 * metres.joints["n"], atol=1e-2)


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_scaling_the_live_load_divides_the_load_factor(factor):
    wall = small_wall(4, 3)
    blocks = [
        block.model_copy(update={"live": (factor * block.live[0], factor * block.live[1])})
        for block in wall.blocks
    ]
    scaled = mo.Scene(joints=wall.joints, blocks=blocks)
    expected = mo.solve(wall, "static").load_factor / factor
    assert mo.solve(scaled, "static").load_factor == pytest.approx(expected, rel=EXACT)


def test_less_friction_never_helps_when_flow_is_associative():
    factors = [mo.solve(small_wall(friction=mu), "static").load_factor for mu in (0.2, 0.4, 0.6, 0.8, 1.0)]
    assert all(np.diff(factors) >= -1e-9)
    assert factors[0] < factors[-1]


def arch(voussoirs, friction):
    """Semicircle of radii 4 and 5, live load downwards on the third voussoir from the right."""
    angles = np.linspace(0, math.pi, voussoirs + 1)
    ring = [
        mo.Block(
            name=f"v{k}",
            vertices=[(r * math.cos(a), r * math.sin(a)) for r, a in ((4, a0), (5, a0), (5, a1), (4, a1))],
            unit_weight=20,
            live=(0, -1) if k == 2 else (0, 0),
        )
        for k, (a0, a1) in enumerate(pairwise(angles))
    ]
    feet = [
        mo.Block(name=name, vertices=[(x, -1), (x + 1, -1), (x + 1, 0), (x, 0)], fixed=True)
        for name, x in (("left", -5), ("right", 4))
    ]
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[*ring, *feet])


@pytest.mark.parametrize("voussoirs", [9, 13])
@pytest.mark.parametrize("friction", [0.35, 0.42, 0.6])
def test_arches_have_no_load_factor_above_the_associative_one(voussoirs, friction):
    """Section 5.2: for many single ring arches the flow rule has no influence."""
    associative = mo.solve(arch(voussoirs, friction), "static").load_factor
    assert mo.solve(arch(voussoirs, friction)).load_factor == pytest.approx(associative, rel=1e-3)
    assert mo.solve(arch(voussoirs, friction)).load_factor <= associative


@pytest.mark.parametrize("number", range(1, 7))
def test_loop_ends_at_or_below_the_associative_load_factor(number):
    path = CASES / "ferris_tinloi" / f"wall_{number}.toml"
    assert mo.solve(path).load_factor <= mo.solve(path, "static").load_factor + 1e-9

"""Tests of bridges that were loaded to collapse: Page (1987, 1988, 1989) and Hendry, Davies & Royles (1985).

Load factors are compared with an independent program, not with the loads of the experiments. The guide, page
"Bridges loaded to collapse", discusses the experiments; its numbers are checked here too.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from arch_under_fill import ArchUnderFill
from scenes import CASES, solved
from speeds import slow_after

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.fill import Road
from masonry_opt.solution.motion import joint_motion

SPREAD = math.tan(math.radians(30))
#: Rankine's coefficients at φ = 30°, and the share of the passive coefficient that the cases count on.
ACTIVE = 1 / 3
PASSIVE = 3.0
MOBILISED = 0.33


def arch(span, rise, thickness, cover, width, **keys):
    return ArchUnderFill(span, rise, thickness, cover, width, 22, 18, load_at=-span / 4, **keys)


BRIDGES = {
    "hendry_davies_royles/bridgemill": arch(18.29, 2.84, 0.711, 0.203, 8.3, parabolic=True, steps=60),
    "page/prestwood": arch(6.55, 1.428, 0.22, 0.165, 3.8, steps=100),
    "page/torksey": arch(4.90, 1.15, 0.343, 0.246, 7.8, steps=60),
    "page/shinafoot": arch(6.16, 1.19, 0.542, 0.215, 7.03, steps=50),
    "page/strathmashie": arch(9.42, 2.99, 0.6, 0.41, 5.81, steps=50),
}
#: Collapse loads of the guide in kN. The first four add up effects: no fill, its weight, its spread, 0.33 of
#: its passive pressure. Then follow all of the passive pressure, and 0.33 of it with masonry of 5 N/mm².
GUIDE = {
    "hendry_davies_royles/bridgemill": (1730, 2800, 2990, 3170, 3720, 2000),
    "page/prestwood": (47.6, 102, 113, 134, 177, 118),
    "page/torksey": (344, 679, 832, 965, 1300, 818),
    "page/shinafoot": (2230, 3570, 4530, 4900, 5680, 2450),
    "page/strathmashie": (471, 1020, 1190, 1680, 2730, 1430),
}
#: Strength in kN/m².
STRENGTH = 5000


def read(name: str) -> mo.Scene:
    return mo.load(CASES / f"{name}.toml")


def changed(scene: mo.Scene, **keys: object) -> mo.Scene:
    return scene.model_copy(update={"fills": [scene.fills[0].model_copy(update=keys)]})


def load_found(scene: mo.Scene) -> float:
    """Return the collapse load in kN by associative flow: λ times the live load."""
    return -sum(load.live[1] for load in scene.loads) * solved(scene, "static").load_factor


def on_the_road(scene: mo.Scene) -> mo.Scene:
    """Return the scene with its load on the road, from where it spreads, in place of the load on a block."""
    road = scene.fills[0].road
    bare = scene.model_copy(update={"loads": []})
    shapes = assemble(bare).geometry
    at, load = np.array([scene.loads[0].at[0]]), -np.array([scene.loads[0].live[1]])
    loads = []
    for block, (_, down, moment) in enumerate(Road(bare, shapes, road).on_blocks(at, load)):
        if down:
            x, y = shapes.centroid[block] + shapes.origin
            name, x = scene.blocks[block].name, x + moment / down
            loads.append(mo.Load(block=name, live=(0.0, float(down)), at=(float(x), float(y))))
    return bare.model_copy(update={"loads": loads})


@pytest.mark.parametrize("name", BRIDGES)
def test_geometry(name):
    """The ring, the road and the width have the dimensions of the source, and the load is at a quarter of
    the span."""
    scene, stated = read(name), BRIDGES[name]
    ring = np.array([block.vertices for block in scene.blocks if not block.fixed])
    assert len(ring) == stated.steps
    corners = ring.reshape(-1, 2)
    assert corners[:, 1].min() == pytest.approx(0, abs=1e-9)
    feet = np.abs(corners[np.abs(corners[:, 1]) < 1e-9, 0])
    np.testing.assert_allclose(feet, stated.span / 2, rtol=1e-9)
    assert corners[:, 1].max() == pytest.approx(stated.rise + stated.thickness, rel=1e-9)
    assert scene.fills[0].road[0][1] == pytest.approx(stated.road, rel=1e-9)
    assert scene.thickness == stated.width
    assert scene.loads[0].at[0] == pytest.approx(-stated.span / 4, rel=1e-9)
    # The joints are perpendicular to the intrados, as in the independent program.
    joints = np.array([stated.intrados[0], stated.back])
    nearest = np.abs(corners[:, None, None] - joints).max(axis=-1).min(axis=(1, 2))
    np.testing.assert_allclose(nearest, 0, atol=2e-7)


@pytest.mark.parametrize("name", slow_after(2, BRIDGES))
def test_hinges_at_the_same_joints(name):
    """Load factors agree to 1e-3 with those of the independent program.

    The arch is bare, or under the weight of the fill, or also under its pressure. The scene has straight
    edges and one force per piece of an edge; the program has curves and a depth that varies.
    """
    scene, fill = read(name), BRIDGES[name]
    pressing = replace(fill, active=ACTIVE, passive=MOBILISED * PASSIVE)
    bare = scene.model_copy(update={"fills": []})
    for made, independent in (
        (bare, replace(fill, fill_weight=0.0)),
        (changed(scene, pressure=False), fill),
        (scene, pressing),
        (changed(scene, mobilised=1.0), replace(pressing, passive=PASSIVE)),
    ):
        assert load_found(made) == pytest.approx(independent.load_factor(), rel=1e-3)
    test = scene.reference["collapse_load"].value
    assert scene.loads[0].live == (0, -test)
    reference = scene.reference["associative"]
    assert reference.value == pytest.approx(pressing.load_factor() / test, rel=1e-5)
    assert solved(scene, "static").load_factor == pytest.approx(reference.value, rel=reference.tolerance)


@pytest.mark.parametrize("name", ["page/torksey", "page/strathmashie"])
def test_backing_over_the_haunches(name):
    """Load factors with backing agree to 1e-3 with those of the independent program.

    The backing reaches up to the extrados of a joint. It is heavier than the fill, and has all of the passive
    pressure of φ = 40°. Backing with the properties of the fill changes nothing.
    """
    scene, fill = read(name), BRIDGES[name]
    passive = math.tan(math.radians(65)) ** 2
    pressing = replace(fill, active=ACTIVE, passive=MOBILISED * PASSIVE)
    stated = replace(
        pressing,
        backing=float(fill.back[fill.steps // 4, 1]),
        backing_weight=23,
        backing_active=1 / passive,
        backing_passive=passive,
    )
    line = [(x, stated.backing) for x in (-fill.span, fill.span)]
    heavy = mo.Backing(line=line, unit_weight=23, friction_angle=40, mobilised=1)
    found = load_found(changed(scene, backing=heavy))
    assert found == pytest.approx(stated.load_factor(), rel=1e-3)
    assert found > 1.1 * load_found(scene)
    none = mo.Backing(line=line, unit_weight=18)
    assert load_found(changed(scene, backing=none)) == pytest.approx(load_found(scene), rel=1e-3)


@pytest.mark.parametrize("name", slow_after(2, BRIDGES))
def test_nothing_slides(name):
    """Nothing slides, so that the flow rule has no influence: both load factors agree to 1e-6."""
    made = changed(read(name), pressure=False)
    assert solved(made).load_factor == pytest.approx(solved(made, "static").load_factor, rel=1e-6)


def fine(stated: ArchUnderFill, voussoirs: int, **fill: object) -> mo.Scene:
    ring = {"span": stated.span, "rise": stated.rise, "thickness": stated.thickness, "unit_weight": 22}
    end = stated.back[-1, 0]
    earth = {"unit_weight": 18, "friction_angle": 30, "mobilised": MOBILISED, "spread": 30} | fill
    return mo.Scene(
        joints=mo.JointDefaults(friction=math.inf),
        thickness=stated.width,
        blocks=mo.Arch(voussoirs=voussoirs, **ring).blocks(stated.width),
        fills=[mo.Fill(road=[(-end, stated.road), (end, stated.road)], **earth)],
        loads=[mo.Load(block="v1", live=(0, -1), at=(stated.load_at, 0))],
    )


@pytest.mark.parametrize(
    ("name", "mobilised"),
    [
        ("torksey", MOBILISED),
        pytest.param("prestwood", None, marks=pytest.mark.slow),
        pytest.param("strathmashie", 1.0, marks=pytest.mark.slow),
    ],
)
def test_hinges_anywhere_with_the_load_spread(name, mobilised):
    """With more voussoirs, λ falls to that of the smooth arch: within 1e-3 at 240 voussoirs.

    Hinges form at joints, and more voussoirs have more joints.
    """
    stated = replace(BRIDGES[f"page/{name}"], spread=SPREAD, steps=1200)
    fill: dict[str, object] = {"pressure": False}
    if mobilised is not None:
        stated, fill = replace(stated, active=ACTIVE, passive=mobilised * PASSIVE), {"mobilised": mobilised}
    expected = stated.load_factor()
    scenes = [on_the_road(fine(stated, voussoirs, **fill)) for voussoirs in (60, 240)]
    coarse, found = map(load_found, scenes)
    assert found == pytest.approx(expected, rel=1e-3)
    assert abs(found - expected) < 0.5 * abs(coarse - expected)


@pytest.mark.slow
def test_worst_position_of_a_line_load():
    """The worst position of one axle on Torksey agrees with that on the smooth arch.

    λ is within 1e-3 of the least over 31 positions, and the position is within a hundredth of the span.
    """
    stated = replace(
        BRIDGES["page/torksey"], spread=SPREAD, active=ACTIVE, passive=MOBILISED * PASSIVE, steps=600
    )
    places = np.linspace(-0.35, -0.2, 31)
    found = [replace(stated, load_at=place * stated.span).load_factor() for place in places]
    worst = int(np.argmin(found))
    assert 0 < worst < 30
    axle = mo.Axles(name="line", loads=[500], width=stated.width / 2)
    crossed = mo.crossing(fine(stated, 120).model_copy(update={"loads": []}), axle, method="static")
    assert 1000 * crossed.load_factor == pytest.approx(found[worst], rel=1e-3)
    assert -abs(crossed.position) / stated.span == pytest.approx(places[worst], abs=0.01)


@pytest.mark.slow
def test_prestwood_hinges_as_in_the_test():
    """Page reports a mechanism of four hinges."""
    result = solved(read("page/prestwood"))
    motion = joint_motion(result.assembly, result.solution)
    assert motion.hinges.sum() == 4
    assert result.exact


@pytest.mark.slow
@pytest.mark.parametrize("name", BRIDGES)
def test_numbers_of_the_guide(name):
    """The numbers of the guide are rounded to three digits."""
    scene = read(name)
    silent, loaded = changed(scene, pressure=False), on_the_road(scene)
    crushing = mo.JointDefaults(friction_angle=33, strength=STRENGTH)
    scenes = [
        scene.model_copy(update={"fills": []}),
        silent,
        on_the_road(silent),
        loaded,
        on_the_road(changed(scene, mobilised=1.0)),
        loaded.model_copy(update={"joints": crushing}),
    ]
    found = [load_found(made) for made in scenes]
    np.testing.assert_allclose(found, GUIDE[name], rtol=5e-3)

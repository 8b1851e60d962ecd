"""Collapse in which the live load does no work, but reduces normal forces until blocks are pushed aside.

The load factors are calculated by hand. A push P slides a block with the normal force n if n ≤ P / μ, or
n ≤ (P - C) / μ with the cohesion C. The live load reduces n by λ.
"""

import re
import warnings
from dataclasses import replace
from math import cos, inf, sin, sqrt

import numpy as np
import pytest
from mappings import mapped, turned
from scenes import WALLS, block_on_floor, values_of
from second_program import bounds

import masonry_opt as mo
from masonry_opt.methods import no_work
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.blocks import rectangle
from masonry_opt.solution.reasons import Code, reason

FRICTION = 0.5
#: Coulomb methods apart from the loop, which has a test on all scenes.
COULOMB = ("coulomb", "incremental", "mpec", "global")


def scene(*blocks: mo.Block | mo.Solid, **joints: float) -> mo.Scene:
    if any(isinstance(block, mo.Solid) for block in blocks):
        ground = mo.Solid(name="ground", box=[[-5, 9], [-5, 9], [-1, 0]], fixed=True)
    else:
        ground = mo.Block(name="ground", vertices=rectangle(-5, 9, -1, 0), fixed=True)
    return mo.Scene(joints=mo.JointDefaults(friction=FRICTION, **joints), blocks=[ground, *blocks])


def stone(
    name: str = "A",
    x: tuple[float, float] = (0, 1),
    y: tuple[float, float] = (0, 1),
    weight: float = 10.0,
    push: float = 0.0,
    live: tuple[float, float] = (0, 0),
) -> mo.Block:
    """Return a rectangular block with a dead push along the ground and a live load."""
    return mo.Block(name=name, vertices=rectangle(*x, *y), weight=weight, dead=(push, 0), live=live)


def sloping(flat: mo.Scene) -> mo.Scene:
    """Return the scene turned by an angle, with vertical gravity."""
    turn = turned(SLOPE)
    return mapped(flat, turn, turn).replace(gravity=flat.gravity)


def solid(
    name: str, z: tuple[float, float], weight: float, push: tuple[float, float], lifted: bool
) -> mo.Solid:
    dead, live = (*push, 0), (0, 0, 1 if lifted else 0)
    return mo.Solid(name=name, box=[[0, 2], [0, 2], list(z)], weight=weight, dead=dead, live=live)


UP = (0, 1)
SLOPE = 0.2
PUSHED = scene(stone(push=2, live=UP))
LINTEL = scene(
    stone("left", (0, 1), (0, 1), weight=20),
    stone("right", (3, 4), (0, 1), weight=6, push=4, live=UP),
    stone("lintel", (0, 4), (1, 1.5), weight=9),
)

BY_HAND = {
    "pushed": (PUSHED, 10 - 2 / 0.5),
    "cohesion": (scene(stone(push=2, live=UP), cohesion=0.3), 10 - (2 - 0.3) / 0.5),
    "strength": (scene(stone(x=(0, 3), push=2, live=UP), strength=30), 10 - 2 / 0.5),
    # The push is 2 - λ / 10.
    "against the live load": (scene(stone(push=2, live=(-0.1, 1))), (0.5 * 10 - 2) / (0.5 - 0.1)),
    # Friction resists the part of the weight along the slope; n is the part across the slope less λ.
    "slope": (sloping(scene(stone(live=UP))), 10 * cos(SLOPE) - 10 * sin(SLOPE) / 0.5),
    "upper of two": (scene(stone("A"), stone("B", y=(1, 1.5), weight=5, push=1, live=UP)), 5 - 1 / 0.5),
    "lower of two": (
        scene(stone("A", (0, 3), live=UP), stone("B", (0, 3), (1, 1.5), weight=5, push=2)),
        15 - 2 / 0.5,
    ),
    # Both blocks slide together, for any force between them.
    "two in a row": (
        scene(stone("A", push=2.5, weight=4), stone("B", x=(1, 2), weight=6, live=UP)),
        10 - 2.5 / 0.5,
    ),
    "space": (scene(solid("A", (0, 1), 10, (1.2, 1.6), lifted=True)), 10 - 2 / 0.5),
    "two in space": (
        scene(solid("A", (0, 1), 10, (0, 0), lifted=True), solid("B", (1, 1.5), 5, (1, 1), lifted=False)),
        15 - sqrt(2) / 0.5,
    ),
    # The lintel rests on the inner edge of the left pier and the outer edge of the right pier, whose force is
    # 9 / 3. Friction above and below the right pier resists its push: 4 = 0.5 (6 + 3 - λ) + 0.5 · 3.
    "lintel": (LINTEL, 6 + 2 * 9 / 3 - 4 / 0.5),
}


def pulled_by_a_rod(prestress: float, dead: float = 0.0) -> mo.Scene:
    """Return a stone that the live load lifts and a prestressed rod pulls along the ground."""
    rod = mo.Tie(between=("A", "ground"), at=((0.5, 0.5), (5.0, 0.5)), prestress=prestress, strength=9.0)
    return scene(stone(push=dead, live=UP)).replace(ties=[rod])


def pushed_by_a_fill(height: float) -> mo.Scene:
    """Return a stone of height 2 that the live load lifts, with a fill up to a height on its left."""
    fill = mo.Fill(road=[(-5, height), (0, height)], unit_weight=1.5, friction_angle=30, mobilised=0.9)
    return scene(stone(y=(0, 2), live=UP)).replace(fills=[fill])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "push", "method"),
    [
        (pulled_by_a_rod(2.0), 2.0, "coulomb"),
        (pulled_by_a_rod(2.0), 2.0, "nonassociative"),
        (pulled_by_a_rod(2.0, dead=-0.5), 1.5, "coulomb"),
        # The push is K_a γ h²/2, with K_a = 1/3 for a friction angle of 30°.
        (pushed_by_a_fill(2.0), 1.5 / 3 * 2.0**2 / 2, "coulomb"),
        (pushed_by_a_fill(2.0), 1.5 / 3 * 2.0**2 / 2, "nonassociative"),
        # Only the default is tested, because a sub-problem of the loop has no state here.
        (pushed_by_a_fill(1.2), 1.5 / 3 * 1.2**2 / 2, "coulomb"),
    ],
)
def test_prestress_and_earth_pressure_drive_the_mechanism(given: mo.Scene, push: float, method: str) -> None:
    """A stone slides when n = 10 - λ falls to P / μ, where P is a prestress or an earth pressure.

    Neither the live nor the dead load does work.
    """
    result = mo.solve(given, method, incremental=False)
    assert values_of(result, Code.NO_WORK) is not None
    assert result.load_factor == pytest.approx(10 - push / FRICTION, rel=1e-6)
    problem, load_factor, q = result.assembly.problem, result.load_factor, result.solution.q
    assert problem.unbalanced(load_factor, q) == pytest.approx(0, abs=1e-6)
    assert problem.slacks(q).min() >= -1e-6


def random_stack(seed: int) -> mo.Scene:
    """Return a random stack of up to six stones next to a fill, lifted by the live load, with a tie."""
    rng = np.random.default_rng([20, seed])
    width, top, stones = float(rng.uniform(0.6, 1.4)), 0.0, []
    for number in range(rng.integers(1, 7)):
        high = top + float(rng.uniform(0.25, 0.9))
        live = (0.0, float(rng.uniform(0.01, 0.2)))
        corners = rectangle(0, width, top, high)
        stones.append(mo.Block(name=f"s{number}", vertices=corners, unit_weight=2.2, live=live))
        top = high
    road = [(-2.0, top * float(rng.uniform(0.4, 1.1))), (0.0, top * float(rng.uniform(0.2, 0.9)))]
    angle, mobilised = float(rng.uniform(20, 40)), float(rng.uniform(0.5, 1.0))
    fill = mo.Fill(
        road=road, unit_weight=float(rng.uniform(0.4, 1.0)), friction_angle=angle, mobilised=mobilised
    )
    at = ((width / 2, top - 0.1), (width / 2 + 3.0, float(rng.uniform(0.5, 1.0)) * top))
    rod = mo.Tie(
        between=(stones[-1].name, "ground"), at=at, prestress=0.02, strength=float(rng.uniform(1, 4))
    )
    ground = mo.Block(name="ground", vertices=rectangle(-5, 9, -1, 0), fixed=True)
    friction = float(rng.uniform(0.4, 0.8))
    return mo.Scene(
        joints=mo.JointDefaults(friction=friction), blocks=[*stones, ground], fills=[fill], ties=[rod]
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_random_stacks_under_a_fill_that_the_live_load_lifts(seed: int) -> None:
    """The default finds an exact state for each random stack, at or below an independent linear program."""
    given = random_stack(seed)
    most = bounds(assemble(given)).outside
    result = mo.solve(given, incremental=False)
    assert result.load_factor is not None
    assert 0 < result.load_factor <= most * (1 + 1e-6)
    assert result.exact


@pytest.mark.parametrize("name", BY_HAND)
def test_load_factor_by_hand(name: str) -> None:
    """The loop reproduces each load factor by hand, to 1e-6; its programs are solved to 1e-9."""
    given, by_hand = BY_HAND[name]
    result = mo.solve(given, "nonassociative", incremental=False)
    assert result.status is mo.Status.CONVERGED
    assert result.load_factor == pytest.approx(by_hand, rel=1e-6)
    values = values_of(result, Code.NO_WORK)
    assert values is not None
    assert values["against"] == (name == "against the live load")
    assert values["fixed"] == (name not in ("two in a row", "space", "two in space", "lintel"))
    assert result.solution.is_only_state == values["fixed"]


@pytest.mark.slow
@pytest.mark.parametrize("method", COULOMB)
@pytest.mark.parametrize("name", ["cohesion", "against the live load", "slope", "two in space", "lintel"])
def test_every_coulomb_method_gives_it(name: str, method: str) -> None:
    """Every Coulomb method reproduces the load factor by hand, to 1e-6 in the plane.

    - IPOPT ends at ε = 3e-9 for each product.
    - In space, "incremental" and "mpec" are compared to 1e-2. Their friction polygon lies up to 0.86 % inside
      the cone, which changes P / μ.
    - Elastic contacts of equal stiffness share the weight of the lintel evenly, so "incremental" differs.
    """
    given, by_hand = BY_HAND[name]
    if method == "global" and given.dimension == 3:
        pytest.skip("the bracket knows no solids")
    result = mo.solve(given, method, incremental=False)
    assert values_of(result, Code.NO_WORK) is not None
    if (method, name) == ("incremental", "lintel"):
        by_hand += 2 * (9 / 2 - 9 / 3)
    loose = method in ("incremental", "mpec") and given.dimension == 3
    assert result.load_factor == pytest.approx(by_hand, rel=1e-2 if loose else 1e-6)


@pytest.mark.parametrize("name", ["pushed", "against the live load", "cohesion"])
def test_default_is_an_exact_state_and_so_is_its_certificate(name: str) -> None:
    """The default's state satisfies all conditions, recomputed from the matrices, to 1e-8.

    The live load does no work in the mechanism. The analysis gives no warning.
    """
    given, by_hand = BY_HAND[name]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = mo.solve(given)
    assert result.load_factor == pytest.approx(by_hand, rel=1e-8)
    assert result.incremental == pytest.approx(by_hand, rel=1e-6)
    assert result.associative == pytest.approx(by_hand, rel=1e-6)
    assert result.exact
    assert result.certificate.worst <= 1e-8
    assert "equilibrium alone fixes all forces, so no other λ above zero is possible" in result.summary
    problem, q, d = result.assembly.problem, result.solution.q, result.solution.d
    load = problem.dead + result.load_factor * problem.live
    assert problem.B @ q + load == pytest.approx(0, abs=1e-8)
    z, p = problem.slacks(q), problem.rates(d, problem.dilatancy)
    assert z.min() >= -1e-8
    assert problem.B.T @ d - problem.D(problem.dilatancy) @ p == pytest.approx(0, abs=1e-8)
    assert z @ p == pytest.approx(0, abs=1e-8)
    assert problem.dead @ d == pytest.approx(problem.live_norm)
    assert problem.live @ d <= 1e-8


def test_what_indeterminate_forces_allow_is_told_apart() -> None:
    """If forces are indeterminate, the least and the incremental load factor differ.

    Equal elastic contacts share the weight of the lintel evenly, so that 9 / 2 replaces 9 / 3. The reason
    does not claim that equilibrium fixes the forces.
    """
    result, by_hand = mo.solve(LINTEL), BY_HAND["lintel"][1]
    assert result.load_factor == pytest.approx(by_hand, rel=1e-8)
    assert result.incremental == pytest.approx(by_hand + 2 * (9 / 2 - 9 / 3), rel=1e-6)
    assert result.associative >= result.incremental * (1 - 1e-8)
    assert values_of(result, Code.NO_WORK) == {"fixed": False, "against": False}


@pytest.mark.parametrize("dilatancy", [0.1, 0.5])
def test_joints_that_open_as_they_slide_let_the_load_work(dilatancy: float) -> None:
    result = mo.solve(scene(stone(push=2, live=UP), dilatancy=dilatancy), incremental=False)
    assert result.load_factor == pytest.approx(6, rel=1e-7)
    assert values_of(result, Code.NO_WORK) is None
    assert result.exact


def test_nothing_is_claimed_where_the_live_load_works() -> None:
    """A loop that is stopped early has no load factor, and the summary still states the associative one."""
    result = mo.solve(WALLS[0], "nonassociative", max_iterations=2, remedies="none")
    assert (result.load_factor, values_of(result, Code.NO_WORK)) == (None, None)
    assert re.search(r"^  associative +0\.642859 ", result.summary, re.MULTILINE)


def test_what_barely_stands_is_not_wedged() -> None:
    """A block whose push is 2e-4 below its limit μ W is stable and has the load factor by hand, to 1e-8.

    Elastic contacts barely carry this push, but equilibrium fixes the forces.
    """
    result = mo.solve(scene(stone(push=4.999, live=UP)), "incremental")
    assert result.status is mo.Status.CONVERGED
    assert result.load_factor == pytest.approx(10 - 4.999 / 0.5, abs=1e-8)


def test_a_state_below_zero_of_loads_that_vanish_is_no_number() -> None:
    """A state in which the loads vanish has no load factor of the scene, so ``below_zero`` is ``inf``.

    The loads grow by half of the dead load from λ = 1 on, so that they are zero at λ = -1.
    """
    result = mo.solve(block_on_floor(), incremental=False)
    below_zero = reason(Code.BELOW_ZERO, load_factor=0.0)
    below = replace(result.solution, reasons=(below_zero,), below_zero=-1.0)
    of_scene = no_work._as_of_scene(below, result.solution.answer, alike=True, at=1.0, share=0.5)
    assert of_scene.below_zero == inf

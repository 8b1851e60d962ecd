"""Relations that hold whatever the load factor is, on random scenes and on one wall.

Of associative flow they are theorems (λ is the optimum of one linear program): asserted to the accuracy
of the solver. The loop is a heuristic: its λ depends on which of many optimal states a solver returns.
The scene tessellation 121 ends at 0.0240 as it is and at 0.0124 turned by 37° or with its support split.
So on random scenes only its equilibrium and its bound are asserted. The refined answer is a state that
meets every Coulomb condition: that it does is asserted, and that none exceeds the associative one.

Scenes are made from the seeds in the tests' names: ``random_scene("wall", 7)`` is the scene of [wall-7].
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scenes import CASES, WALLS, small_wall

import masonry_opt as mo
from masonry_opt.answer.acceptance import LIMITS, SMALLEST, Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.status import Status
from masonry_opt.studies.atlas.random_scenes import KINDS, random_scene

#: Programs solved to 1e-9, twice. Random scenes have sliver cells and light blocks, which cost digits.
EXACT, RANDOM = 1e-7, 1e-6
#: The loop's own tolerance is 1e-5 on λ, and rounding may choose another optimal state on the way.
LOOP = 5e-4
#: By how much an exact state may lie above the loop's: the most in 250 random scenes is 1e-2.
NEARLY = 3e-2

FAST = [(kind, seed) for kind in KINDS for seed in range(2)]
SLOW = [(kind, seed) for kind in KINDS for seed in range(100, 135)]

#: What the loop may end as where there is an associative load factor: it is a heuristic.
LOOP_GIVES_UP = {
    Status.CYCLING,
    Status.ITERATION_LIMIT,
    Status.NO_STATE,
    Status.SOLVER_FAILED,
    Status.UNSTABLE,  # a dead load that wedging alone carries
}
Vector = Callable[[tuple[float, float]], tuple[float, float]]


def as_is(v):
    return v


def mapped(
    scene: mo.Scene,
    point: Vector = as_is,
    force: Vector = as_is,
    *,
    dead: float = 1.0,
    live: float = 1.0,
    length: float = 1.0,
    order: np.ndarray | None = None,
) -> mo.Scene:
    """The scene with its points mapped, its forces turned, dead and live loads and lengths scaled, and
    its blocks in another order."""

    def moved(block: mo.Block) -> mo.Block:
        return mo.Block(
            name=block.name,
            vertices=[point(v) for v in block.vertices],
            weight=None if block.weight is None else dead * block.weight,
            live=tuple(live * f for f in force(block.live)),
            live_at=None if block.live_at is None else point(block.live_at),
            fixed=block.fixed,
        )

    blocks = [moved(block) for block in scene.blocks]
    if order is not None:
        blocks = [blocks[index] for index in order]
    joints = scene.joints.model_copy(update={"cohesion": scene.joints.cohesion * dead / length})
    return mo.Scene(joints=joints, gravity=force(scene.gravity), blocks=blocks, exceptions=scene.exceptions)


def turned(angle: float) -> Vector:
    c, s = math.cos(angle), math.sin(angle)
    return lambda v: (c * v[0] - s * v[1], s * v[0] + c * v[1])


def mirrored(v):
    return (-v[0], v[1])


def shuffled(scene: mo.Scene) -> mo.Scene:
    return mapped(scene, order=np.random.default_rng(7).permutation(len(scene.blocks)))


def with_split_supports(scene: mo.Scene) -> mo.Scene:
    """Each fixed block cut in two across its first edge. What rests on the cut has two joints in place
    of one, which together carry the same forces."""
    blocks: list[mo.Block] = []
    for block in scene.blocks:
        if not block.fixed:
            blocks.append(block)
            continue
        a, b, c, d = block.vertices
        e, f = (tuple(0.6 * p + 0.4 * q for p, q in zip(*ends, strict=True)) for ends in ((a, b), (d, c)))
        blocks.append(mo.Block(name=f"{block.name} 1", vertices=[a, e, f, d], fixed=True))
        blocks.append(mo.Block(name=f"{block.name} 2", vertices=[e, b, c, f], fixed=True))
    return scene.model_copy(update={"blocks": blocks})


#: What leaves λ as it is.
SAME: dict[str, Callable[[mo.Scene], mo.Scene]] = {
    "moved": lambda scene: mapped(scene, lambda v: (v[0] + 31.7, v[1] - 12.9)),
    "moved far": lambda scene: mapped(scene, lambda v: (v[0] + 1e5, v[1] - 1e5)),
    "turned by 37°": lambda scene: mapped(scene, turned(math.radians(37)), turned(math.radians(37))),
    "turned by 90°": lambda scene: mapped(scene, turned(math.pi / 2), turned(math.pi / 2)),
    "mirrored": lambda scene: mapped(scene, mirrored, mirrored),
    "in millimetres": lambda scene: mapped(scene, lambda v: (1e3 * v[0], 1e3 * v[1]), length=1e3),
    "in newtons": lambda scene: mapped(scene, dead=2.3e4, live=2.3e4),
    "renumbered": shuffled,
    "supports split": with_split_supports,
}
BASE = small_wall(6, 4)


def same(one: mo.Result, other: mo.Result, tolerance: float, factor: float = 1.0) -> None:
    """The other result has the same status, and ``factor`` times the load factor."""
    assert other.status == one.status
    if one.load_factor is None:
        assert other.load_factor is None
    else:
        expected = factor * one.load_factor
        assert other.load_factor == pytest.approx(expected, rel=tolerance, abs=tolerance)


def no_more(one: mo.Result, other: mo.Result) -> None:
    """The other result, of a scene with less friction somewhere, carries no more than the first."""
    if one.status is Status.UNSTABLE:
        assert other.status is Status.UNSTABLE
    elif one.load_factor is not None:
        # None at all is less: what stood may fall. Unlimited would be more.
        assert other.load_factor is not None or other.status is Status.UNSTABLE
        assert (other.load_factor or 0.0) <= one.load_factor + RANDOM


def check_theorems(kind: str, seed: int) -> None:
    """What holds of every scene under associative flow."""
    scene = random_scene(kind, seed)
    static = mo.solve(scene, "static")
    same(static, mo.solve(scene, "kinematic"), RANDOM)
    if static.load_factor is not None:
        certificate = static.certificate
        assert certificate.equilibrium < 1e-9
        assert max(certificate.yield_, certificate.flow) < 1e-7
    for change in SAME.values():
        same(static, mo.solve(change(scene), "static"), RANDOM)
    same(static, mo.solve(mapped(scene, live=2.5), "static"), RANDOM, factor=1 / 2.5)
    rng = np.random.default_rng(seed)
    joint = static.joints.iloc[rng.integers(len(static.joints))]
    slippery = mo.Joint(between=(joint["first"], joint["second"]), friction=0.5 * scene.joints.friction)
    no_more(static, mo.solve(scene.model_copy(update={"exceptions": [slippery]}), "static"))
    everywhere = scene.joints.model_copy(update={"friction": 0.8 * scene.joints.friction})
    no_more(static, mo.solve(scene.model_copy(update={"joints": everywhere}), "static"))


def check_order(kind: str, seed: int) -> None:
    """Refined, loop and associative, on every scene that has a load factor."""
    scene = random_scene(kind, seed)
    associative = mo.solve(scene, "static").load_factor
    if associative is None:
        return
    loop, refined = mo.solve(scene, "nonassociative"), mo.solve(scene, "refined")
    if loop.load_factor is None:
        assert loop.status in LOOP_GIVES_UP
        assert loop.reasons
    else:
        # The loop's sub-problems violate the true law a little; no λ reported exceeds the bound.
        assert loop.load_factor <= associative + RANDOM
        # The forces are in equilibrium with the load factor reported beside them.
        problem = loop.assembly.problem
        residual = problem.B @ loop.solution.q + loop.load_factor * problem.live + problem.dead
        assert np.abs(residual).max() < 1e-8 * np.abs(problem.dead).sum()
    if refined.load_factor is None:
        assert loop.load_factor is None
        return
    assert refined.certificate.worst < 1e-8
    # A state with equilibrium and yield: a theorem.
    assert refined.load_factor <= associative + RANDOM
    # Not one: the loop's state obeys the law nearly, and the least exact state near it may lie higher. (What
    # a pass leads to may lie in another valley: 7 and 8 % higher on tessellations 118 and 128.)
    if loop.load_factor is not None:
        from_loop = mo.solve(scene, "refined", start=loop)
        assert from_loop.load_factor <= loop.load_factor * (1 + NEARLY) + RANDOM


@pytest.mark.parametrize(("kind", "seed"), FAST)
def test_theorems_of_associative_flow(kind, seed):
    check_theorems(kind, seed)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), SLOW)
def test_theorems_of_associative_flow_on_many_scenes(kind, seed):
    check_theorems(kind, seed)


@pytest.mark.parametrize(("kind", "seed"), FAST)
def test_refined_is_exact_and_below_the_loop_and_the_loop_below_associative(kind, seed):
    check_order(kind, seed)


def check_one_pass(kind: str, seed: int) -> None:
    """Exact and at or below the associative λ, on every scene that has one; a few are the loop's."""
    scene = random_scene(kind, seed)
    associative, result = mo.solve(scene, "static"), mo.solve(scene, "mcp")
    if associative.load_factor is None:
        # Without dilatancy a scene that locks may move.
        assert result.status is associative.status or associative.status is Status.LOCKED
        return
    assert result.status.usable or result.status in LOOP_GIVES_UP
    if result.load_factor is None:
        assert result.reasons[0].code in (Code.LOOP_TOOK_OVER, Code.WEDGED)
        return
    assert result.load_factor <= associative.load_factor + RANDOM
    if result.reasons[0].code is Code.ONE_PASS:
        left = result.certificate
        assert max(left.equilibrium, left.yield_, left.flow) <= 1e-8
        assert left.complementarity <= 1e-6 * max(abs(result.load_factor), SMALLEST)
        if result.solution.kind is Kind.EXACT:
            assert left.complementarity <= 1e-8
        for name in ("moved", "mirrored", "renumbered"):
            other = mo.solve(SAME[name](scene), "mcp")
            assert other.load_factor <= associative.load_factor + RANDOM, name


@pytest.mark.parametrize(("kind", "seed"), FAST)
def test_one_pass_is_exact_and_below_associative(kind, seed):
    check_one_pass(kind, seed)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), SLOW)
def test_one_pass_is_exact_and_below_associative_on_many_scenes(kind, seed):
    check_one_pass(kind, seed)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), SLOW)
def test_order_of_the_load_factors_on_many_scenes(kind, seed):
    check_order(kind, seed)


@pytest.mark.slow
def test_loop_with_remedies_certifies_nearly_every_random_scene():
    """Of 240 scenes; each ends in a certified answer or a status that says why not."""
    scenes = [random_scene(kind, seed) for seed in range(100, 160) for kind in KINDS]
    missed, known = [], 0
    for scene in scenes:
        result = mo.solve(scene, "nonassociative")
        left = result.certificate
        if left and max(left.equilibrium, left.yield_) < 1e-6 and left.complementarity < 1e-3:
            assert left.flow < LIMITS[Kind.LOOP].flow, scene.title
            known += 1
        elif mo.solve(scene, "static").load_factor is not None and result.status is not Status.UNSTABLE:
            missed.append(f"{scene.title}: {result.status}")
        assert result.status.usable or result.reasons, scene.title
    print(f"{known} certified; not: {missed}")
    assert known >= 0.99 * (known + len(missed)), missed


@pytest.mark.parametrize("kind", KINDS)
def test_random_scenes_are_worth_solving(kind):
    """Most stand and have a load factor, few of them zero; a seed gives its scene."""
    assert random_scene(kind, 3) == random_scene(kind, 3)
    factors = [mo.solve(random_scene(kind, seed), "static").load_factor for seed in range(20, 30)]
    assert sum(factor is not None and factor > 1e-3 for factor in factors) >= 6


@pytest.mark.parametrize("name", SAME)
@pytest.mark.parametrize("method", ["static", "kinematic"])
def test_associative_load_factor_of_a_wall_is_unmoved(name, method):
    assert mo.solve(SAME[name](BASE), method).load_factor == pytest.approx(
        mo.solve(BASE, method).load_factor, rel=EXACT
    )


@pytest.mark.parametrize("name", SAME)
def test_loop_is_unmoved(name):
    assert mo.solve(SAME[name](BASE), "nonassociative").load_factor == pytest.approx(
        mo.solve(BASE, "nonassociative").load_factor, rel=LOOP
    )


#: What changes rounding or nothing: a pass goes the same way, to 1e-11 on this wall and 2e-7 on wall 6.
SAME_WAY = 1e-8
#: What changes the way: another state of many, up to 3e-4 apart on the walls of Table 1.
OTHER_WAY = {"supports split": 1e-3}
#: The exact state below is on the same mechanism, whichever way the pass went: 4e-15 apart on these walls.
DESCENDED = 1e-10


@pytest.mark.parametrize("descent", [False, True])
@pytest.mark.parametrize("name", SAME)
@pytest.mark.parametrize(
    "wall",
    [BASE, *(pytest.param(path, marks=pytest.mark.slow, id=path.stem) for path in WALLS[:5])],
    ids=lambda wall: "wall",
)
def test_one_pass_is_unmoved(wall, name, descent):
    scene = wall if isinstance(wall, mo.Scene) else mo.load(wall)
    one, other = (mo.solve(each, "mcp", descent=descent) for each in (scene, SAME[name](scene)))
    codes = [Code.ONE_PASS, Code.EXACT] if descent else [Code.ONE_PASS]
    for result in (one, other):
        assert [reason.code for reason in result.reasons] == codes
    same(one, other, descended(wall) if descent else OTHER_WAY.get(name, SAME_WAY))


def descended(wall):
    """Of many mechanisms that cost nothing rounding picks one: wall 2 ends at 0.55742 or at 0.55831."""
    return 2e-3 if wall == WALLS[1] else DESCENDED


def test_one_pass_of_a_wall_that_slides_at_many_joints_is_nearly_unmoved():
    """Wall 6: rounding is magnified to 3e-6 of λ in some 20 steps, and the descent may end in either of two
    states as near to each other."""
    scene = mo.load(WALLS[5])
    for descent in (False, True):
        one = mo.solve(scene, "mcp", descent=descent)
        for name in ("moved", "turned by 37°", "turned by 90°", "mirrored", "renumbered"):
            same(one, mo.solve(SAME[name](scene), "mcp", descent=descent), 1e-5)


@pytest.mark.parametrize("path", [None, WALLS[0], WALLS[5]], ids=["wall", "wall_1", "wall_6"])
def test_one_pass_in_units_twice_as_large_is_the_same_to_the_bit(path):
    """Forces and lengths are measured in medians of the scene's own: powers of two change no digit."""
    scene = BASE if path is None else mo.load(path)
    larger = mapped(scene, lambda v: (1024 * v[0], 1024 * v[1]), dead=2.0, live=2.0, length=1024.0)
    for descent in (False, True):
        one, other = (mo.solve(each, "mcp", descent=descent) for each in (scene, larger))
        assert other.load_factor == one.load_factor


def test_mirrored_wall_has_the_mirrored_mechanism():
    one, other = mo.solve(BASE, "static").blocks, mo.solve(SAME["mirrored"](BASE), "static").blocks
    np.testing.assert_allclose(one["vx"], -other["vx"], atol=1e-6)
    np.testing.assert_allclose(one["vy"], other["vy"], atol=1e-6)
    np.testing.assert_allclose(one["omega"], -other["omega"], atol=1e-6)


def test_results_come_in_the_units_of_the_case():
    metres, millimetres = mo.solve(BASE, "static"), mo.solve(SAME["in millimetres"](BASE), "static")
    np.testing.assert_allclose(millimetres.joints["length"], 1e3 * metres.joints["length"])
    np.testing.assert_allclose(millimetres.joints["n"], metres.joints["n"], atol=1e-6)
    np.testing.assert_allclose(millimetres.joints["m"], 1e3 * metres.joints["m"], atol=1e-3)
    newtons = mo.solve(SAME["in newtons"](BASE), "static")
    np.testing.assert_allclose(newtons.joints["n"], 2.3e4 * metres.joints["n"], atol=1e-2)


@pytest.mark.parametrize("factor", [1e-7, 0.5, 3.0, 1e6])
@pytest.mark.parametrize("method", ["static", "kinematic", "nonassociative"])
def test_scaling_the_live_load_divides_the_load_factor(factor, method):
    wall = small_wall(4, 3)
    expected = mo.solve(wall, method).load_factor / factor
    tolerance = LOOP if method == "nonassociative" else EXACT
    assert mo.solve(mapped(wall, live=factor), method).load_factor == pytest.approx(expected, rel=tolerance)


@pytest.mark.parametrize("factor", [1e-7, 1e-4, 0.5, 3.0, 1e2, 1e6])
@pytest.mark.parametrize("wall", [small_wall(4, 3), BASE], ids=["small", "wall"])
@pytest.mark.parametrize("descent", [False, True])
def test_scaling_the_live_load_divides_the_load_factor_of_one_pass(wall, factor, descent):
    expected = mo.solve(wall, "mcp", descent=descent).load_factor / factor
    result = mo.solve(mapped(wall, live=factor), "mcp", descent=descent)
    assert result.reasons[0].code is Code.ONE_PASS
    assert result.load_factor == pytest.approx(expected, rel=SAME_WAY, abs=0)


def test_less_friction_never_helps_when_flow_is_associative():
    factors = [mo.solve(small_wall(friction=mu), "static").load_factor for mu in (0.2, 0.4, 0.6, 0.8, 1.0)]
    assert all(np.diff(factors) >= -1e-9)
    assert factors[0] < factors[-1]


def semicircle(voussoirs, friction):
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
    associative = mo.solve(semicircle(voussoirs, friction), "static").load_factor
    loop = mo.solve(semicircle(voussoirs, friction), "nonassociative").load_factor
    assert loop == pytest.approx(associative, rel=1e-3)
    assert loop <= associative * (1 + 1e-8)  # what solvers leave, asked for 1e-9


@pytest.mark.parametrize("number", range(1, 7))
def test_loop_ends_at_or_below_the_associative_load_factor(number):
    path = CASES / "ferris_tinloi" / f"wall_{number}.toml"
    assert mo.solve(path, "nonassociative").load_factor <= mo.solve(path, "static").load_factor + 1e-9

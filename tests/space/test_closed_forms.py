"""Blocks in space compared with load factors by hand: blocks that slide, turn or overturn, and stacks."""

from itertools import pairwise
from math import cos, hypot, inf, radians, sin

import numpy as np
import pytest
from scenes_in_space import box_on_floor, pushed_box
from speeds import slow, slow_after

import masonry_opt as mo

#: Absolute error of load factors from programs that are solved to 1e-9.
EXACT = 1e-6
#: Methods with Coulomb friction, and all methods that use the cone.
COULOMB = ["nonassociative", "incremental", "coulomb"]
CONES = ["static", "kinematic", *COULOMB]
#: All methods; the default is slow. Only the test of a pushed box runs the default among the fast tests.
DEFAULT_SLOW = [*(method for method in CONES if method != "coulomb"), *slow("coulomb")]

#: Size, friction and angle of a box that slides at an angle, or overturns about an edge along y or x.
PUSHED = [((1.0, 2.0, 3.0), 0.2, 52.0), ((1.0, 2.0, 3.0), 0.8, 75.0), ((2.0, 1.0, 3.0), 0.6, -100.0)]


def overturning(size: tuple[float, float, float], angle: float) -> float:
    """Return the λ at which a box overturns that is pushed at its centroid by λ W (cos θ, sin θ).

    The box turns about an edge of its base if the moment λ W |cos θ| h/2 is W a/2, or λ W |sin θ| h/2 is
    W b/2.
    """
    a, b, h = size
    along, across = abs(cos(radians(angle))), abs(sin(radians(angle)))
    return min(a / (h * along) if along > EXACT else inf, b / (h * across) if across > EXACT else inf)


@pytest.mark.parametrize(
    ("method", "size", "friction", "angle"),
    [(method, *box) for method in CONES for box in PUSHED[: 1 if method == "coulomb" else 3]],
)
def test_a_box_slides_or_overturns(method, size, friction, angle):
    """A box slides or overturns at λ = min(μ, a/(h |cos θ|), b/(h |sin θ|)), to 1e-6.

    If the box slides without rotation, friction resists with μ W against the slip. This resistance does not
    depend on the direction or on the distribution of the weight.
    """
    found = mo.solve(pushed_box(size, friction, angle), method, **_alone(method))
    assert found.load_factor == pytest.approx(min(friction, overturning(size, angle)), abs=EXACT)
    assert found.certificate.worst < 1e-6


@pytest.mark.parametrize("method", DEFAULT_SLOW)
def test_a_box_that_is_turned_about_the_vertical(method):
    """A box that is turned about the vertical slides at the moment μ W √(a² + b²)/2, to 1e-6.

    Its four corners are √(a² + b²)/2 from the middle and slip along a circle. The moment does not depend on
    the distribution of the weight.
    """
    size = (1.0, 2.0, 3.0)
    scene = box_on_floor(size, 0.6, live=(0.0, 0.0, 0.0), live_moment=(0.0, 0.0, 1.0))
    found = mo.solve(scene, method, **_alone(method))
    assert found.load_factor == pytest.approx(0.6 * hypot(*size[:2]) / 2, abs=EXACT)


def test_cohesion_acts_on_the_whole_face():
    """A box with cohesion slides at λ = μ + c a b / W, here with W = 1; it would overturn at λ = 8."""
    found = mo.solve(pushed_box((2.0, 2.0, 0.25), 0.3, 20.0).replace(cohesion=0.05), "static")
    assert found.load_factor == pytest.approx(0.3 + 0.05 * 4, abs=EXACT)


@pytest.mark.parametrize("method", DEFAULT_SLOW)
def test_a_block_before_a_wall_overturns_more_easily_than_associative_flow_lets_it(method):
    """A block in front of a wall tips about its front edge at λ (H/2 + u) = t/2 + v, to 1e-6.

    The block has the thickness t and the height H, and its back slides up the wall. Under associative flow,
    a unit of rotation also moves the block out by u and up by v. These are v = μ u on the ground and
    u = μ (v + t) at the back, so that u = μ t/(1 − μ²). With Coulomb friction, u = v = 0.
    """
    t, height, friction = 0.5, 3.0, 0.6
    block = mo.box("block", (0, 4), (0, t), (0, height), unit_weight=1, live_per_weight=(0, -1, 0))
    wall = mo.box("wall", (0, 4), (t, 2), (0, height), fixed=True)
    ground = mo.box("ground", (-1, 5), (-1, 2), (-1, 0), fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[block, wall, ground])
    out = 0.0 if method in COULOMB else friction * t / (1 - friction**2)
    found = mo.solve(scene, method, **_alone(method))
    expected = (t / 2 + friction * out) / (height / 2 + out)
    assert found.load_factor == pytest.approx(expected, abs=EXACT)


#: Boxes of a stack: least x and y, lengths in x and y, and height.
STACK = [((0.0, 0.0), (2.0, 2.0), 1.0), ((0.4, 0.2), (2.0, 2.5), 0.5), ((0.5, 0.7), (2.2, 2.4), 0.8)]


def stack(live: tuple[float, float, float], *, at_the_tip: bool) -> mo.Scene:
    """Return a stack of boxes with a weight of 1 per volume, each of which overhangs the box below.

    The live force acts on the top corner of the last box, or on all boxes in proportion to their weight.
    """
    blocks, bottom = [], 0.0
    for number, ((x, y), (a, b), h) in enumerate(STACK):
        where = ((x, x + a), (y, y + b), (bottom, bottom + h))
        bottom += h
        keys: dict[str, object] = {"live_per_weight": live}
        if at_the_tip:
            tip = tuple(end for _, end in where)
            keys = {"live": live, "live_at": tip} if number == len(STACK) - 1 else {}
        blocks.append(mo.box(f"box {number}", *where, unit_weight=1, **keys))
    ground = mo.box("ground", (0, 2), (0, 2), (-1, 0), fixed=True)
    return mo.Scene(joints=mo.JointDefaults(friction=0.9), blocks=[*blocks, ground])


def levels() -> list[tuple[np.ndarray, np.ndarray, float]]:
    """Return for each bed of the stack its extent in x and y, and centroid and weight of the boxes above.

    The centroid is relative to the height of the bed.
    """
    boxes = [((np.array(at)), np.array(at) + size, height) for at, size, height in STACK]
    weight = np.array([np.prod(high - low) * height for low, high, height in boxes])
    base = np.concatenate([[0.0], np.cumsum([height for *_, height in boxes])])
    middle = np.array([[*(low + high) / 2, 0] for low, high, _ in boxes])
    middle[:, 2] = (base[:-1] + base[1:]) / 2
    found = []
    below = [(np.zeros(2), np.full(2, 2.0), 0.0), *boxes]
    for bed, (one, other) in enumerate(pairwise(below)):
        centroid = weight[bed:] @ middle[bed:] / weight[bed:].sum() - [0, 0, base[bed]]
        edges = np.stack([np.maximum(one[0], other[0]), np.minimum(one[1], other[1])])
        found.append((edges, centroid, weight[bed:].sum()))
    return found


@pytest.mark.parametrize("method", slow_after(1, ["static", "coulomb"]))
def test_a_cantilever_of_boxes_pushed_down_at_its_tip(method):
    """A stack pushed down at its tip has the least λ = W (x_edge − x)/(x_tip − x_edge) of all beds, 1.634.

    On each bed, the resultant of the weight W above and of λ at the tip must lie within the bed, that is,
    (W x + λ x_tip)/(W + λ) ≤ x_edge. The same condition applies in y.
    """
    tip = np.array(STACK[-1][0]) + STACK[-1][1]
    expected = min(
        float((weight * (edges[1] - at[:2]) / (tip - edges[1])).min()) for edges, at, weight in levels()
    )
    assert expected == pytest.approx(1.634)
    found = mo.solve(stack((0.0, 0.0, -1.0), at_the_tip=True), method, **_alone(method))
    assert found.load_factor == pytest.approx(expected, abs=EXACT)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_a_stack_that_is_tilted(method):
    """A stack pushed by λ times its weight overturns or slides at the λ by hand, to 1e-6.

    The push moves the resultant of the boxes above a bed by λ z, where z is the height of their centroid
    above the bed. λ is the friction, or the least distance from a centroid to an edge along the push, over z.
    """
    direction = (0.6, 0.8)
    room = [((edges[1] - at[:2]) / direction / at[2]).min() for edges, at, _ in levels()]
    expected = min(0.9, *room)
    found = mo.solve(stack((*direction, 0.0), at_the_tip=False), method, **_alone(method))
    assert found.load_factor == pytest.approx(expected, abs=EXACT)


def _alone(method: str) -> dict[str, bool]:
    """Return options that leave the incremental load factor out of the default method."""
    return {"incremental": False} if method == "coulomb" else {}

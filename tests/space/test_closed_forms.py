"""Blocks in space by hand: what slides, turns or overturns alone, and what stands on it."""

from itertools import pairwise
from math import cos, hypot, inf, radians, sin

import numpy as np
import pytest
from scenes_in_space import box_on_floor, pushed_box

import masonry_opt as mo

#: What programs leave that are solved to 1e-9.
EXACT = 1e-6
#: Methods whose joints slide without opening, and all that are told by the cone.
COULOMB = ["nonassociative", "incremental", "coulomb"]
CONES = ["static", "kinematic", *COULOMB]

#: Size, friction, angle: slides askew, overturns about either edge; negative components.
PUSHED = [((1.0, 2.0, 3.0), 0.2, 52.0), ((1.0, 2.0, 3.0), 0.8, 75.0), ((2.0, 1.0, 3.0), 0.6, -100.0)]


def overturning(size: tuple[float, float, float], angle: float) -> float:
    """λ at which a box overturns. Pushed at its centroid, at h/2, by λ W (cos θ, sin θ), it turns about an
    edge of its base when the moment λ W |cos θ| h/2 is W a/2, or λ W |sin θ| h/2 is W b/2."""
    a, b, h = size
    along, across = abs(cos(radians(angle))), abs(sin(radians(angle)))
    return min(a / (h * along) if along > EXACT else inf, b / (h * across) if across > EXACT else inf)


@pytest.mark.parametrize(("size", "friction", "angle"), PUSHED)
@pytest.mark.parametrize("method", CONES)
def test_a_box_slides_or_overturns(method, size, friction, angle):
    """λ = min(μ, a/(h |cos θ|), b/(h |sin θ|)): sliding without rotation resists with μ W against the slip,
    whatever its direction and however the weight is shared."""
    found = mo.solve(pushed_box(size, friction, angle), method, **_alone(method))
    assert found.load_factor == pytest.approx(min(friction, overturning(size, angle)), abs=EXACT)
    assert found.certificate.worst < 1e-6


@pytest.mark.parametrize("method", CONES)
def test_a_box_that_is_turned_about_the_vertical(method):
    """Four corners at √(a² + b²)/2 from the middle, where they all slip along a circle: μ W √(a² + b²)/2,
    however they share the weight."""
    size = (1.0, 2.0, 3.0)
    scene = box_on_floor(size, 0.6, live=(0.0, 0.0, 0.0), live_moment=(0.0, 0.0, 1.0))
    found = mo.solve(scene, method, **_alone(method))
    assert found.load_factor == pytest.approx(0.6 * hypot(*size[:2]) / 2, abs=EXACT)


def test_cohesion_acts_on_the_whole_face():
    """μ W + c a b resists sliding, here with W = 1; the flat box overturns at 8."""
    found = mo.solve(pushed_box((2.0, 2.0, 0.25), 0.3, 20.0).replace(cohesion=0.05), "static")
    assert found.load_factor == pytest.approx(0.3 + 0.05 * 4, abs=EXACT)


@pytest.mark.parametrize("method", CONES)
def test_a_block_before_a_wall_overturns_more_easily_than_associative_flow_lets_it(method):
    """A block of thickness t and height H, its back to a wall, tips about its front edge: its back slides up
    the wall. Where sliding opens by μ it must also move out by u and up by v: v = μ u on the ground, and
    u = μ (v + t) a unit of rotation at the back, so u = μ t/(1 − μ²). Work of the push, λ (H/2 + u), is that
    against the weight, t/2 + v. Without dilatancy u = v = 0."""
    t, height, friction = 0.5, 3.0, 0.6
    block = mo.box("block", (0, 4), (0, t), (0, height), unit_weight=1, live_per_weight=(0, -1, 0))
    wall = mo.box("wall", (0, 4), (t, 2), (0, height), fixed=True)
    ground = mo.box("ground", (-1, 5), (-1, 2), (-1, 0), fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[block, wall, ground])
    out = 0.0 if method in COULOMB else friction * t / (1 - friction**2)
    found = mo.solve(scene, method, **_alone(method))
    expected = (t / 2 + friction * out) / (height / 2 + out)
    assert found.load_factor == pytest.approx(expected, abs=EXACT)


#: Each box of a stack: where it begins in x and y, its lengths, its height.
STACK = [((0.0, 0.0), (2.0, 2.0), 1.0), ((0.4, 0.2), (2.0, 2.5), 0.5), ((0.5, 0.7), (2.2, 2.4), 0.8)]


def stack(live: tuple[float, float, float], *, at_the_tip: bool) -> mo.Scene:
    """Boxes of unit weight per volume, each over the edges of the last: the live force on the top corner of
    the last one, or on all by their weight."""
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
    """Of each bed of the stack: its least and greatest x and y; the centroid of what stands on it, above it;
    its weight."""
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


@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_a_cantilever_of_boxes_pushed_down_at_its_tip(method):
    """On each bed the resultant of the weight W above, at its centroid, and of λ down at the tip must lie in
    the rectangle that the boxes share: (W x + λ x_tip)/(W + λ) ≤ x_edge, and so in y. λ is the least
    W (x_edge − x)/(x_tip − x_edge) of all beds, here 1.634."""
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
    """A push by λ times the weight moves the resultant of what is above a bed by λ z, z the height of its
    centroid above the bed: λ is the least distance of the centroid from an edge, along the push, over z, or
    the friction."""
    direction = (0.6, 0.8)
    room = [((edges[1] - at[:2]) / direction / at[2]).min() for edges, at, _ in levels()]
    expected = min(0.9, *room)
    found = mo.solve(stack((*direction, 0.0), at_the_tip=False), method, **_alone(method))
    assert found.load_factor == pytest.approx(expected, abs=EXACT)


def _alone(method: str) -> dict[str, bool]:
    """The default is asked for its state alone."""
    return {"incremental": False} if method == "coulomb" else {}

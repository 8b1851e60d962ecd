"""The small scenes of the failure atlas."""

from collections.abc import Callable
from math import inf
from pathlib import Path
from typing import Any

from masonry_opt.scene.blocks import Block
from masonry_opt.scene.case_file import load
from masonry_opt.scene.joints import Joint, JointDefaults
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.walls import Wall

Builder = Callable[[Path], Scene]


def rectangle(name: str, left: float, bottom: float, right: float, top: float, **keys: Any) -> Block:
    """Return a rectangular block, which is a support if no weight is passed."""
    corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
    fixed = "weight" not in keys and "unit_weight" not in keys
    return Block(name=name, vertices=corners, fixed=fixed, **keys)


def of_blocks(title: str, blocks: list[Block], friction: float, **keys: Any) -> Builder:
    scene = Scene(title=title, joints=JointDefaults(friction=friction), blocks=blocks, **keys)
    return lambda _: scene


def ferris_tinloi(number: int, friction: float | None = None) -> Builder:
    """Return a wall of Table 1 of the paper, with another friction if ``friction`` is not None."""

    def build(cases: Path) -> Scene:
        scene = load(cases / "ferris_tinloi" / f"wall_{number}.toml")
        if friction is None:
            return scene
        return scene.model_copy(update={"joints": JointDefaults(friction=friction), "reference": {}})

    return build


def bonded(
    courses: list[list[float]], block: tuple[float, float], friction: float, shift: float = 0.0
) -> Builder:
    """Return a small wall pushed to the right by its weight, moved by (shift, -shift).

    Negative lengths in a course are gaps.
    """
    wall = Wall(block=block, weight=1, live=(1, 0), courses=courses)
    moved = [
        built.model_copy(update={"vertices": [(x + shift, y - shift) for x, y in built.rings[0]]})
        for built in wall.blocks()
    ]
    return of_blocks("small wall", moved, friction)


def block(width: float, height: float, friction: float, **keys: Any) -> Builder:
    """Return a block of weight 1 on a floor, pushed to the right by its weight."""
    loads = {"weight": 1.0, "live": (1.0, 0.0)} | keys
    return of_blocks(
        "block on a floor",
        [rectangle("A", 0, 0, width, height, **loads), rectangle("floor", -width, -1, 2 * width, 0)],
        friction,
    )


def confined(friction: float) -> Builder:
    """Return a block of weight 1 between a fixed floor and a fixed ceiling, pushed along them."""
    blocks = [
        rectangle("A", 0, 0, 4, 1, weight=1, live=(1, 0)),
        rectangle("floor", -2, -1, 6, 0),
        rectangle("ceiling", -2, 1, 6, 2),
    ]
    return of_blocks("confined block", blocks, friction)


def clamped_h(friction: float, clamp: float) -> Builder:
    """Return an H of three blocks: a web of weight 1 that only friction supports between two flanges.

    Dead forces clamp the flanges against the web, and fixed walls prevent them from spreading. The live load
    pushes the web down.
    """
    sides = {
        "left": (rectangle, -1, 0, (clamp, 0), (-3, -1), -0.5),
        "right": (rectangle, 4, 5, (-clamp, 0), (5, 7), 4.5),
    }
    blocks = [rectangle("web", 0, 1, 4, 2, weight=1, live=(0, -1)), rectangle("floor", -3, -1, 7, 0)]
    smooth = []
    for side, (make, left, right, force, wall, middle) in sides.items():
        blocks.append(make(f"{side} flange", left, 0, right, 3, weight=1, dead=force, dead_at=(middle, 1.5)))
        blocks.append(make(f"{side} wall", wall[0], 0, wall[1], 3))
        smooth += [
            Joint(between=(f"{side} flange", other), friction=0.0) for other in ("floor", f"{side} wall")
        ]
    return of_blocks("clamped H", blocks, friction, exceptions=smooth)


def two_blocks(friction: float) -> Builder:
    """Return Fig. 6 of the paper: A is pushed out from under B, which also rests on a rough support."""
    blocks = [
        rectangle("A", 2, 0, 5, 1, weight=1, live=(1, 0)),
        rectangle("B", 0, 1, 3, 2, weight=1),
        rectangle("floor", 1, -1, 9, 0),
        rectangle("support", 0, 0, 1, 1),
    ]
    rough = [Joint(between=("B", "support"), friction=inf)]
    return of_blocks("two blocks", blocks, friction, exceptions=rough)


def overhanging() -> Builder:
    """Return a block B on a block A; the centroid of B is beyond the edge of A."""
    blocks = [
        rectangle("A", 0, 0, 2, 1, weight=1, live=(1, 0)),
        rectangle("B", 1.5, 1, 4.5, 2, weight=1),
        rectangle("floor", -2, -1, 4, 0),
    ]
    return of_blocks("overhanging block", blocks, 0.5)


def chute() -> Builder:
    """Return a block between smooth walls that can only move up, pushed sideways."""
    blocks = [
        rectangle("A", 0, 0, 1, 1, weight=1, live=(1, 0)),
        rectangle("floor", 0, -1, 1, 0),
        rectangle("left", -1, -1, 0, 2),
        rectangle("right", 1, -1, 2, 2),
    ]
    return of_blocks("block in a chute", blocks, 0.0)


def groove() -> Builder:
    """Return a square on its corner in a smooth V of fixed blocks, pushed to the right."""
    blocks = [
        Block(name="A", vertices=[(0, 0), (1, 1), (0, 2), (-1, 1)], weight=1, live=(1, 0)),
        Block(name="right", vertices=[(0, 0), (2, 2), (2, 0)], fixed=True),
        Block(name="left", vertices=[(0, 0), (-2, 0), (-2, 2)], fixed=True),
    ]
    return of_blocks("smooth groove", blocks, 0.0)


def short_bearing(length: float, tolerance: float | None) -> Builder:
    """Return a slab of length 4 on two supports; the right bearing has the given length."""
    blocks = [
        rectangle("slab", 0, 0, 4, 1, weight=1, live=(1, 0)),
        rectangle("left", 0, -1, 1, 0),
        rectangle("right", 4 - length, -1, 6, 0),
    ]
    return of_blocks("short bearing", blocks, 0.5, tolerance=tolerance)


def pebble(side: float, push_both: bool) -> Builder:
    """Return a square of side 1 on a square of the given side, with equal unit weights.

    The live load of the pebble, and of the boulder with ``push_both``, is its weight to the right.
    """
    weight = side * side
    blocks = [
        rectangle("boulder", 0, 0, side, side, weight=weight, live=(weight if push_both else 0, 0)),
        rectangle("pebble", side / 2, side, side / 2 + 1, side + 1, weight=1, live=(1, 0)),
        rectangle("floor", -side, -side, 2 * side, 0),
    ]
    return of_blocks("pebble on a boulder", blocks, 0.4)


def apart(gap: float, tolerance: float) -> Builder:
    """Return two flat blocks, one above the other, with a gap between them (an overlap if negative)."""
    blocks = [
        rectangle("A", 0, 0, 4, 1, weight=1, live=(1, 0)),
        rectangle("B", 0, 1 + gap, 4, 2 + gap, weight=1, live=(1, 0)),
        rectangle("floor", -4, -1, 8, 0),
    ]
    return of_blocks("gap or overlap", blocks, 0.65, tolerance=tolerance)


def four_in_a_point(friction: float) -> Builder:
    """Return two adjacent columns of two unit squares each, whose four inner corners meet in a point."""
    corners = {"A": (0, 0), "B": (1, 0), "C": (0, 1), "D": (1, 1)}
    cubes = [rectangle(name, x, y, x + 1, y + 1, weight=1, live=(1, 0)) for name, (x, y) in corners.items()]
    return of_blocks("four in a point", [*cubes, rectangle("floor", -1, -1, 3, 0)], friction)


def slabs(count: int, friction: float) -> Builder:
    """Return a low pile of equal slabs, each pushed to the right by its weight."""
    pile = [rectangle(f"{n + 1}", 0, n / 5, 4, (n + 1) / 5, weight=1, live=(1, 0)) for n in range(count)]
    return of_blocks("pile of slabs", [*pile, rectangle("floor", -4, -1, 8, 0)], friction)

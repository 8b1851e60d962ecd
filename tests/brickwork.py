"""Masonry drawn without its mortar: walls on footings with arches over openings, and rings of voussoirs.

Lengths are in metres, and the weight of a stone is its area. Bricks are 250 × 65 mm by default, with gaps of
10 mm between them. The bricks of arches are rectangles too, so that the gaps between them are wedges.
"""

import math
import re
from dataclasses import dataclass

import numpy as np
import shapely

import masonry_opt as mo

LENGTH = 0.25
HEIGHT = 0.065
MORTAR = 0.01

#: Thickness of the thinnest cut brick; thinner cuts are left out.
THINNEST = 0.03


@dataclass(frozen=True)
class Arch:
    """Semicircular arch of rectangular bricks over an opening that reaches down to the footings."""

    x: float  #: abscissa of the centre
    courses: int  #: number of courses below the springing
    radius: float  #: radius of the intrados
    bricks: int  #: number of bricks of the ring
    thick: float = 0.12  #: thickness of the ring

    @property
    def centre(self) -> np.ndarray:
        """Centre of the arch, in the middle of a bed joint."""
        return np.array([self.x, self.courses * (HEIGHT + MORTAR) + MORTAR / 2])

    def void(self) -> shapely.Polygon:
        """Return the region without bricks of the wall: the opening, the ring and the mortar round it."""
        half = math.pi / self.bricks / 2
        reach = (self.radius + self.thick + MORTAR) / math.cos(half)
        upper = [self.centre + reach * axes(angle)[1] for angle in 2 * half * np.arange(self.bricks + 1)]
        below = shapely.box(self.x - self.radius, -1, self.x + self.radius, self.centre[1])
        return shapely.union_all([shapely.Polygon(upper), below])

    def ring(self) -> list[shapely.Polygon]:
        """Return the bricks of the ring, from left to right."""
        angles = math.pi * (np.arange(self.bricks) + 0.5) / self.bricks
        return [rectangle(self.centre, angle, self.radius, self.thick) for angle in angles]


def axes(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit vectors along and out of an arch, at an angle from its left springing."""
    up = np.array([-math.cos(angle), math.sin(angle)])
    return np.array([up[1], -up[0]]), up


def rectangle(
    centre: np.ndarray, angle: float, radius: float, thick: float, brick: float = HEIGHT
) -> shapely.Polygon:
    """Return a brick of a ring: ``brick`` along the ring and ``thick`` across it."""
    along, up = axes(angle)
    signs = (-1, 0), (1, 0), (1, 1), (-1, 1)
    return shapely.Polygon(
        [centre + up * (radius + out * thick) + along * side * brick / 2 for side, out in signs]
    )


def stone(name: str, polygon: shapely.Polygon, fixed: bool = False, **keys: object) -> mo.Block:
    """Return a stone that is pushed to the right by its weight, or a support."""
    corners = [tuple(corner) for corner in shapely.get_coordinates(polygon)[:-1].tolist()]
    if fixed:
        return mo.Block(name=name, vertices=corners, fixed=True)
    return mo.Block(name=name, vertices=corners, live_per_weight=(1, 0), **(keys or {"unit_weight": 1}))


def facade(
    columns: int, courses: int, arches: tuple[Arch, ...] = (), length: float = LENGTH, **keys: object
) -> mo.Scene:
    """Return a wall in running bond, with arches, on one footing under each pier."""
    pitch, width = length + MORTAR, columns * (length + MORTAR) - MORTAR
    void = shapely.union_all([arch.void() for arch in arches])
    blocks = []
    for course in range(courses):
        low = MORTAR + course * (HEIGHT + MORTAR)
        shift = pitch / 2 * (course % 2)
        for column in range(columns + course % 2):
            left, right = max(column * pitch - shift, 0), min(column * pitch - shift + length, width)
            cut = shapely.get_parts(shapely.box(left, low, right, low + HEIGHT).difference(void))
            thick = [piece for piece in cut if not piece.buffer(-THINNEST / 2).is_empty]
            blocks += [stone(f"{course}-{column}-{part}", piece) for part, piece in enumerate(thick)]
    for number, arch in enumerate(arches):
        blocks += [stone(f"arch-{number}-{brick}", polygon) for brick, polygon in enumerate(arch.ring())]
    ends = [-0.5, *(arch.x + side * arch.radius for arch in arches for side in (-1, 1)), width + 0.5]
    for pier, (left, right) in enumerate(zip(ends[::2], ends[1::2], strict=True)):
        blocks.append(stone(f"footing-{pier}", shapely.box(left, -0.3, right, 0), fixed=True))
    return mo.Scene(**{"joints": {"friction": 0.6}, "blocks": blocks} | keys)


def drawn_to_touch(scene: mo.Scene, gap: float = MORTAR) -> mo.Scene:
    """Return rectangles that grow by half a gap into the gaps, with the same weights and centroids.

    The outline of the wall does not change, except at its foot.
    """
    stones = {block.name: shapely.Polygon(block.vertices) for block in scene.blocks}
    movable = [stones[block.name] for block in scene.blocks if not block.fixed]
    left, low, right, high = shapely.total_bounds(movable)
    wall = shapely.box(left, low - gap / 2, right, high)
    blocks = []
    for block in scene.blocks:
        polygon = stones[block.name]
        grown = polygon.buffer(gap / 2, join_style="mitre")
        at = polygon.centroid.coords[0]
        outline = grown if block.fixed else grown.intersection(wall)
        blocks.append(stone(block.name, outline, block.fixed, weight=polygon.area, weight_at=at))
    return mo.Scene(joints=scene.joints, blocks=blocks)


def voussoirs(count: int, gap: float, inner: float = 1.0, outer: float = 1.3, **keys: object) -> mo.Scene:
    """Return a semicircular ring on two springers, whose joints are opened in parallel by a gap.

    Each stone has the weight 1. The points at which the weights act do not depend on the gap.
    """
    pitch, blocks = math.pi / count, []
    for number in range(-1, count + 1):
        (before, start), (after, end) = axes(number * pitch), axes((number + 1) * pitch)
        corners = [start * inner, start * outer, end * outer, end * inner]
        off = [before * gap / 2, before * gap / 2, -after * gap / 2, -after * gap / 2]
        fixed = number in (-1, count)
        middle = tuple(axes((number + 0.5) * pitch)[1] * (inner + outer) / 2)
        polygon = shapely.Polygon(np.add(corners, off))
        blocks.append(stone(f"v{number}", polygon, fixed, weight=1, weight_at=middle))
    return mo.Scene(**{"joints": {"friction": 0.6}, "blocks": blocks} | keys)


def brick_ring(
    radius: float, thick: float, count: int, brick: float, *, touching: bool = False, **keys: object
) -> mo.Scene:
    """Return a semicircular ring of rectangular bricks, or of voussoirs that fill the gaps between them.

    The stones have the weight 1 at the middle of the bricks. Both springers are fixed.
    """
    centre, blocks = np.zeros(2), []
    for number in range(-1, count + 1):
        angle = math.pi * (number + 0.5) / count
        along, up = axes(angle)
        polygon = rectangle(centre, angle, radius, thick, brick)
        if touching:
            half = math.tan(math.pi / count / 2)
            inner, outer = radius, radius + thick
            signs = (-1, inner), (1, inner), (1, outer), (-1, outer)
            polygon = shapely.Polygon([up * at + along * side * at * half for side, at in signs])
        fixed = number in (-1, count)
        middle = tuple(up * (radius + thick / 2))
        blocks.append(stone(f"v{number}", polygon, fixed, weight=1, weight_at=middle))
    return mo.Scene(**{"joints": {"friction": 0.7}, "blocks": blocks} | keys)


def advised(message: str) -> tuple[float, int, int]:
    """Return the contact tolerance that a message advises, and its predicted numbers of joints and blocks."""
    pattern = r"'contact_tolerance' to ([\d.e-]+)\D.*makes (\d+) joints?.*connects (\d+) blocks?"
    found = re.search(pattern, message)
    assert found, message
    return float(found[1]), int(found[2]), int(found[3])


def upright_stone(name: str, x: tuple[float, float], y: tuple[float, float], fixed: bool = False) -> mo.Block:
    """Return a rectangular stone, or a rectangular support, with level beds."""
    return stone(name, shapely.box(x[0], y[0], x[1], y[1]), fixed)


def scene_of(*blocks: mo.Block, **keys: object) -> mo.Scene:
    return mo.Scene(**{"joints": {"friction": 0.6}, "blocks": blocks} | keys)


FLOOR = upright_stone("floor", (-2, 6), (-1, 0), fixed=True)

#: Ten courses of two bricks of 240 × 65 mm. STATIC is the load factor of the bricks as solids, whose contacts
#: are found by other code.
WALL = facade(2, 10, length=0.24)
STATIC = 0.57919


def static(scene: mo.Scene) -> float:
    """Return the static load factor."""
    return mo.solve(scene, "static").required()

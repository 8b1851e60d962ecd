"""Brickwork drawn without its mortar: walls on footings with brick arches over their openings.

Lengths are in metres, the weight of a brick is its area. Bricks are 250 × 65 mm with gaps of 10 mm between
them. The bricks of arches are rectangles too, so that the gaps between these bricks are wedges.
"""

import math
from dataclasses import dataclass

import numpy as np
import shapely

import masonry_opt as mo

LENGTH, HEIGHT, MORTAR = 0.25, 0.065, 0.01

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

    def ring(self) -> list[shapely.Polygon]:
        """Return the bricks of the ring, from left to right."""
        return [
            shapely.Polygon(
                [
                    self.centre + up * (self.radius + out * self.thick) + along * side * HEIGHT / 2
                    for side, out in ((-1, 0), (1, 0), (1, 1), (-1, 1))
                ]
            )
            for along, up in map(axes, math.pi * (np.arange(self.bricks) + 0.5) / self.bricks)
        ]

    def void(self) -> shapely.Polygon:
        """Return the region without bricks of the wall: the opening, the ring and the mortar round it."""
        half = math.pi / self.bricks / 2
        reach = (self.radius + self.thick + MORTAR) / math.cos(half)
        upper = [self.centre + reach * axes(angle)[1] for angle in 2 * half * np.arange(self.bricks + 1)]
        below = shapely.box(self.x - self.radius, -1, self.x + self.radius, self.centre[1])
        return shapely.union_all([shapely.Polygon(upper), below])


def axes(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit vectors along and out of an arch, at an angle from its left springing."""
    up = np.array([-math.cos(angle), math.sin(angle)])
    return np.array([up[1], -up[0]]), up


def block(name: str, polygon: shapely.Polygon, fixed: bool = False) -> mo.Block:
    """Return a brick, pushed to the right by its weight, or a footing."""
    corners = [tuple(corner) for corner in shapely.get_coordinates(polygon)[:-1].tolist()]
    if fixed:
        return mo.Block(name=name, vertices=corners, fixed=True)
    return mo.Block(name=name, vertices=corners, unit_weight=1, live_per_weight=(1, 0))


def facade(columns: int, courses: int, arches: tuple[Arch, ...] = (), **keys: object) -> mo.Scene:
    """Return a wall in running bond, with arches, on one footing under each pier."""
    pitch, width = LENGTH + MORTAR, columns * (LENGTH + MORTAR) - MORTAR
    void = shapely.union_all([arch.void() for arch in arches])
    blocks = []
    for course in range(courses):
        low = MORTAR + course * (HEIGHT + MORTAR)
        shift = pitch / 2 * (course % 2)
        for column in range(columns + course % 2):
            left, right = max(column * pitch - shift, 0), min(column * pitch - shift + LENGTH, width)
            cut = shapely.get_parts(shapely.box(left, low, right, low + HEIGHT).difference(void))
            thick = [piece for piece in cut if not piece.buffer(-THINNEST / 2).is_empty]
            blocks += [block(f"{course}-{column}-{part}", piece) for part, piece in enumerate(thick)]
    for number, arch in enumerate(arches):
        blocks += [block(f"arch-{number}-{brick}", polygon) for brick, polygon in enumerate(arch.ring())]
    ends = [-0.5, *(arch.x + side * arch.radius for arch in arches for side in (-1, 1)), width + 0.5]
    for pier, (left, right) in enumerate(zip(ends[::2], ends[1::2], strict=True)):
        blocks.append(block(f"footing-{pier}", shapely.box(left, -0.3, right, 0), fixed=True))
    return mo.Scene(**{"joints": {"friction": 0.6}, "blocks": blocks} | keys)

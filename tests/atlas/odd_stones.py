"""Random scenes with unusual stones: notched stones, stones that touch at a corner, joints that crush."""

import numpy as np
import shapely
from atlas.random_scenes import Points, Rng, assembled

from masonry_opt.scene.blocks import rectangle
from masonry_opt.scene.scene import Scene

#: Least strength, as a multiple of the mean pressure below all stones.
_WEAKEST = 4.0
#: Greatest strength, as a multiple of the mean pressure below all stones.
_STRONGEST = 100.0


def odd_scene(seed: int) -> Scene:
    """Return the scene of a seed, which is the same in every release.

    A slab rests on stones, some of which support it with a corner. Cells of a tessellation lie on the slab,
    and some cells are united. The joints of two scenes in three have a strength.
    """
    rng = np.random.default_rng([7, seed])
    feet, width, height = _feet(rng)
    slab = float(rng.uniform(0.2, 0.5))
    box = shapely.box(0.0, height + slab, width, height + slab + float(rng.uniform(0.8, 2.0)))
    outlines = [*feet, _corners(shapely.box(0.0, height, width, height + slab)), *_stones(rng, box)]
    scene = assembled(rng, outlines, {"base": rectangle(-1.0, width + 1, -1.0, 0.0)})
    strength = None
    if rng.random() < 2 / 3:
        pressure = sum(shapely.Polygon(outline).area for outline in outlines) / width
        strength = pressure * float(np.exp(rng.uniform(np.log(_WEAKEST), np.log(_STRONGEST))))
    return scene.replace(joints={"strength": strength}, title=f"odd stones {seed}")


def _feet(rng: Rng) -> tuple[list[Points], float, float]:
    """Return stones of equal height, pointed or flat, with their total width and their height."""
    height, x = float(rng.uniform(0.6, 1.5)), 0.0
    outlines: list[Points] = []
    for number in range(int(rng.integers(3, 7))):
        wide = float(rng.uniform(0.5, 1.2))
        if number and rng.random() < 0.5:
            tip = x + wide * float(rng.uniform(0.3, 0.7))
            outlines.append([(x, 0.0), (x + wide, 0.0), (tip, height)])
        else:
            outlines.append(rectangle(x, x + wide, 0.0, height))
        x += wide + float(rng.uniform(0.0, 0.4))
    return outlines, x, height


def _stones(rng: Rng, box: shapely.Polygon) -> list[Points]:
    """Return the cells of a tessellation of the box, with up to a third of them united with a neighbour."""
    left, low, right, high = box.bounds
    points = rng.uniform([left, low], [right, high], size=(int(rng.integers(5, 18)), 2))
    cells = shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(points), extend_to=box))
    stones = [cell for cell in shapely.intersection(cells, box) if cell.area > 1e-3]
    for _ in range(len(stones) // 3):
        first = int(rng.integers(len(stones)))
        shared = shapely.length(shapely.intersection(stones[first], stones))
        shared[first] = 0.0
        second = int(np.argmax(shared))
        united = shapely.union(stones[first], stones[second], grid_size=1e-9)
        if united.geom_type == "Polygon" and not united.interiors:
            stones = [stone for number, stone in enumerate(stones) if number not in (first, second)]
            stones.append(united)
    return [_corners(stone) for stone in stones]


def _corners(stone: shapely.Polygon) -> Points:
    return [(float(x), float(y)) for x, y in shapely.get_coordinates(stone.exterior)[:-1]]

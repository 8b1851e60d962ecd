"""Large random scenes, of some 20 to 2,000 stones, each from its number of stones and its seed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import shapely

from masonry_opt.scene.blocks import Block, JointDefaults, rectangle
from masonry_opt.scene.scene import Scene

Points = list[tuple[float, float]]

#: Coordinates are rounded to so many digits, far below what joints are found with: what library drew them
#: leaves no trace.
_DIGITS = 9


def large_scene(family: str, stones: int, seed: int) -> Scene:
    """The scene of a family (a key of ``LARGE``), of so many stones, and a seed."""
    return LARGE[family](stones, seed)


def _rng(family: str, stones: int, seed: int) -> np.random.Generator:
    return np.random.default_rng([list(LARGE).index(family), stones, seed])


def _scene(title: str, outlines: list[Points], friction: float, feet: dict[str, Points]) -> Scene:
    """Blocks of unit weight per area on supports, all pushed to the right by their weights."""
    areas = shapely.area([shapely.Polygon(outline) for outline in outlines]).tolist()
    blocks = [
        Block(name=f"b{index}", vertices=outline, weight=area, live=(area, 0.0))
        for index, (outline, area) in enumerate(zip(outlines, areas, strict=True))
    ]
    supports = [Block(name=name, vertices=outline, fixed=True) for name, outline in feet.items()]
    return Scene(title=title, joints=JointDefaults(friction=friction), blocks=[*blocks, *supports])


def rubble(stones: int, seed: int) -> Scene:
    """A wall of irregular convex stones, longer than high: Voronoi cells of scattered points."""
    rng = _rng("rubble", stones, seed)
    aspect, squash = float(rng.uniform(1, 1.5)), float(rng.uniform(1.4, 2))
    height = float(np.sqrt(stones / aspect))
    width = stones / height
    # Cells are drawn in a wall higher by the squash, and flattened with it.
    box = shapely.box(0, 0, width, squash * height)
    points = rng.uniform([0, 0], [width, squash * height], size=(stones, 2))
    cells = _cells(points, box)
    for _ in range(rng.integers(4, 12)):
        # Lloyd's step: cells become more alike in size, and rounder.
        cells = _cells(shapely.get_coordinates(shapely.centroid(cells)), box)
    outlines = []
    for cell in cells:
        corners = np.round(shapely.get_coordinates(cell)[:-1] / [1, squash], _DIGITS)
        outlines.append([(x, y) for x, y in corners.tolist()])
    base = rectangle(-1, width + 1, -1, 0)
    return _scene(f"rubble {stones} {seed}", outlines, 0.6, {"base": base})


def _cells(points: np.ndarray, box: shapely.Polygon) -> np.ndarray:
    """The Voronoi cells of points in a box."""
    drawn = shapely.voronoi_polygons(shapely.MultiPoint(points), extend_to=box)
    return shapely.intersection(shapely.get_parts(drawn), box)


LARGE: dict[str, Callable[[int, int], Scene]] = {"rubble": rubble}

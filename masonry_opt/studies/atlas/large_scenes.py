"""Large random scenes, of 20 to 2,000 stones: rubble walls.

Each comes from its number of stones, which it has to within 10 %, and its seed. They are made to stand under
their own weight; of some thousands that were checked all do.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import shapely

from masonry_opt.errors import OptionError
from masonry_opt.scene.blocks import Block, JointDefaults, rectangle
from masonry_opt.scene.scene import Scene

Points = list[tuple[float, float]]

_FRICTION = 0.6

#: Fewer stones are no wall.
_FEWEST = 20

#: Coordinates are rounded to so many digits, far below what joints are found with, so that cells that meet
#: have the same corners.
_DIGITS = 9


def large_scene(family: str, stones: int, seed: int) -> Scene:
    """The scene of a family (a key of ``LARGE``), of so many stones, and a seed.

    Raises
    ------
    OptionError
        If there are to be fewer than 20 stones.
    """
    return LARGE[family](stones, seed)


def rubble(stones: int, seed: int) -> Scene:
    """A wall of irregular convex stones, longer than high: Voronoi cells of scattered points."""
    rng = _rng("rubble", stones, seed)
    aspect, squash = float(rng.uniform(1, 1.5)), float(rng.uniform(1.4, 2))
    height = math.sqrt(stones / aspect)
    width = stones / height
    # Cells are drawn in a wall higher by the squash, and flattened with it.
    box = shapely.box(0, 0, width, squash * height)
    points = rng.uniform([0, 0], [width, squash * height], size=(stones, 2))
    cells = _cells(points, box)
    steps = int(rng.integers(4, 12))
    # Nothing but friction holds a stone at a side of the wall: it must not lie too steep.
    while steps > 0 or _steepest_at_sides(cells, width) > 0.95 * _FRICTION * squash:
        # Lloyd's step: cells become more alike in size, rounder, and perpendicular to the sides.
        cells = _cells(shapely.get_coordinates(shapely.centroid(cells)), box)
        steps -= 1
    outlines = [_corners(shapely.get_coordinates(cell)[:-1] / [1, squash]) for cell in cells]
    return _scene(f"rubble {stones} {seed}", outlines, rectangle(-1, width + 1, -1, 0))


LARGE: dict[str, Callable[[int, int], Scene]] = {"rubble": rubble}


def _rng(family: str, stones: int, seed: int) -> np.random.Generator:
    if stones < _FEWEST:
        raise OptionError(f"a large scene has {_FEWEST} stones or more (found {stones})")
    return np.random.default_rng([list(LARGE).index(family), stones, seed])


def _scene(title: str, outlines: list[Points], base: Points) -> Scene:
    """Blocks of unit weight per area on a base, all pushed to the right by their weights."""
    areas = shapely.area([shapely.Polygon(outline) for outline in outlines]).tolist()
    blocks = [
        Block(name=f"b{index}", vertices=outline, weight=area, live=(area, 0.0))
        for index, (outline, area) in enumerate(zip(outlines, areas, strict=True))
    ]
    return Scene(
        title=title,
        joints=JointDefaults(friction=_FRICTION),
        blocks=[*blocks, Block(name="base", vertices=base, fixed=True)],
    )


def _corners(outline: np.ndarray) -> Points:
    return [(x, y) for x, y in np.round(outline, _DIGITS).tolist()]


def _cells(points: np.ndarray, box: shapely.Polygon) -> np.ndarray:
    """The Voronoi cells of points in a box."""
    drawn = shapely.voronoi_polygons(shapely.MultiPoint(points), extend_to=box)
    return shapely.intersection(shapely.get_parts(drawn), box)


def _steepest_at_sides(cells: np.ndarray, width: float) -> float:
    """The steepest slope, down and outwards, of the edges that end at either side of a wall."""
    corners, owner = shapely.get_coordinates(cells, return_index=True)
    edges = np.stack([corners[:-1], corners[1:]], axis=1)[owner[:-1] == owner[1:]]
    edges = np.concatenate([edges, edges[:, ::-1]])
    at_side = np.isclose(np.abs(edges[..., 0] - width / 2), width / 2)
    outer, inner = edges[at_side[:, 0] & ~at_side[:, 1]].transpose(1, 0, 2)
    return float(((inner[:, 1] - outer[:, 1]) / np.abs(inner[:, 0] - outer[:, 0])).max())

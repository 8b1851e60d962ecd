"""Large random scenes with 20 to 2,000 stones: rubble walls, walls with openings, arches on piers.

A scene depends on its number of stones, which it has to within 10 %, and on its seed. The scenes are designed
to be stable under their own weight. Some thousands of scenes were checked, and all are stable.
"""

import math
from collections.abc import Callable
from itertools import chain, pairwise

import numpy as np
import shapely

from masonry_opt.errors import OptionError
from masonry_opt.scene.blocks import Block, rectangle
from masonry_opt.scene.joints import JointDefaults
from masonry_opt.scene.scene import Scene

Rng = np.random.Generator
Points = list[tuple[float, float]]

#: ``Piece`` is left end, right end and course of a stone; ``Opening`` is left, right, bottom and top of an
#: opening. Units are half blocks and courses.
Piece = tuple[int, int, int]
Opening = tuple[int, int, int, int]

_FRICTION = 0.6

#: Smallest number of stones; a smaller wall is too small for an opening.
_FEWEST = 20

#: Decimal places of rounded coordinates, so that adjacent cells share their corners. The rounding is far
#: smaller than the tolerance with which joints are found.
_DIGITS = 9


def large_scene(family: str, stones: int, seed: int) -> Scene:
    """Return the scene of a family (a key of ``LARGE``) with a number of stones and a seed.

    Raises
    ------
    OptionError
        If ``stones`` is less than 20.
    """
    return LARGE[family](stones, seed)


def rubble(stones: int, seed: int) -> Scene:
    """Return a wall, longer than high, of irregular convex stones: Voronoi cells of random points."""
    rng = _rng("rubble", stones, seed)
    aspect, squash = float(rng.uniform(1, 1.5)), float(rng.uniform(1.4, 2))
    height = math.sqrt(stones / aspect)
    width = stones / height
    # Cells are drawn in a wall that is higher by the factor ``squash``, and then flattened by this factor.
    box = shapely.box(0, 0, width, squash * height)
    points = rng.uniform([0, 0], [width, squash * height], size=(stones, 2))
    cells = _cells(points, box)
    steps = int(rng.integers(4, 12))
    # Only friction retains a stone at a side of the wall, so its bed must not be too steep.
    while steps > 0 or _steepest_at_sides(cells, width) > 0.95 * _FRICTION * squash:
        # Lloyd's step makes cells more equal in size and rounder, and their edges perpendicular to the sides.
        cells = _cells(shapely.get_coordinates(shapely.centroid(cells)), box)
        steps -= 1
    outlines = [_corners(shapely.get_coordinates(cell)[:-1] / [1, squash]) for cell in cells]
    return _scene(f"rubble {stones} {seed}", outlines, rectangle(-1, width + 1, -1, 0))


def openings(stones: int, seed: int) -> Scene:
    """Return a wall in running bond with windows and doors, each under a lintel.

    Lintels rest on their two ends, and all other stones rest on their whole length. The weight above is
    therefore carried straight down.
    """
    rng = _rng("openings", stones, seed)
    ratio = float(rng.uniform(1.8, 3))
    while True:
        whole = stones / (1 - rng.uniform(0.15, 0.3))
        courses = max(5, round(math.sqrt(whole * ratio / rng.uniform(1, 2))))
        length = _length(whole, courses)
        cut = _cut(rng, stones, length, courses)
        pieces = _pieces(length, courses, cut)
        if cut and abs(len(pieces) - stones) <= 0.05 * stones:
            break
    outlines = [rectangle(left * ratio / 2, right * ratio / 2, row, row + 1) for left, right, row in pieces]
    return _scene(f"openings {stones} {seed}", outlines, rectangle(-1, length * ratio / 2 + 1, -1, 0))


def piers(stones: int, seed: int) -> Scene:
    """Return an arch of inner radius 1, semicircular or segmental, on two piers in running bond."""
    rng = _rng("piers", stones, seed)
    half_angle = math.pi / 2 if rng.random() < 0.5 else float(rng.uniform(1.15, 1.5))
    thickness, height = float(rng.uniform(0.2, 0.3)), float(rng.uniform(0.8, 1.6))
    # The piers are wide enough for the thrust of the arch and for its springing.
    width = float(rng.uniform(0.4, 0.6)) * math.sqrt(height)
    # Voussoirs are two to four times as deep as wide. At most 20 to 35 % of the stones are voussoirs.
    depths = 2 * half_angle * (1 + thickness / 2) / thickness
    voussoirs = round(min(rng.uniform(2, 4) * depths, rng.uniform(0.2, 0.35) * stones))
    courses, length = _courses(rng, (stones - voussoirs - 2) / 2, width / height)
    course, inner, outer = height / courses, math.sin(half_angle), math.sin(half_angle) + width
    side = [
        rectangle(
            inner + width * left / length, inner + width * right / length, row * course, (row + 1) * course
        )
        for row in range(courses)
        for left, right in pairwise(_bond(length, row))
    ]
    angles = np.linspace(math.pi / 2 - half_angle, math.pi / 2 + half_angle, voussoirs + 1)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    centre = [0, height + course - math.cos(half_angle)]
    soffit, back = (ring + centre).tolist(), ((1 + thickness) * ring + centre).tolist()
    # Each pier has a springer on top, which is as long as the pier.
    side.append([(inner, height), (outer, height), (outer, back[0][1]), back[0], soffit[0]])
    outlines = [
        *(np.array(outline) * [way, 1] for way in (-1, 1) for outline in side),
        *(np.array([soffit[i], back[i], back[i + 1], soffit[i + 1]]) for i in range(voussoirs)),
    ]
    base = rectangle(-outer - 1, outer + 1, -1, 0)
    return _scene(f"piers {stones} {seed}", [_corners(outline) for outline in outlines], base)


LARGE: dict[str, Callable[[int, int], Scene]] = {"rubble": rubble, "openings": openings, "piers": piers}


def _rng(family: str, stones: int, seed: int) -> Rng:
    if stones < _FEWEST:
        raise OptionError(f"a large scene has {_FEWEST} stones or more (found {stones})")
    return np.random.default_rng([list(LARGE).index(family), stones, seed])


def _scene(title: str, outlines: list[Points], base: Points) -> Scene:
    """Return blocks with a weight of 1 per area on a base, all pushed to the right by their weights."""
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
    drawn = shapely.voronoi_polygons(shapely.MultiPoint(points), extend_to=box)
    return shapely.intersection(shapely.get_parts(drawn), box)


def _steepest_at_sides(cells: np.ndarray, width: float) -> float:
    """Return the steepest slope, down and outwards, of the edges that end at a side of the wall."""
    corners, owner = shapely.get_coordinates(cells, return_index=True)
    edges = np.stack([corners[:-1], corners[1:]], axis=1)[owner[:-1] == owner[1:]]
    edges = np.concatenate([edges, edges[:, ::-1]])
    at_side = np.isclose(np.abs(edges[..., 0] - width / 2), width / 2)
    outer, inner = edges[at_side[:, 0] & ~at_side[:, 1]].transpose(1, 0, 2)
    return float(((inner[:, 1] - outer[:, 1]) / np.abs(inner[:, 0] - outer[:, 0])).max())


def _bond(length: int, course: int) -> list[int]:
    """Return the ends of the blocks of a course, in half blocks; every other course is shifted by one."""
    return sorted({0, *range(course % 2, length, 2), length})


def _length(stones: float, courses: int) -> int:
    """Return the length, in half blocks, of a wall in running bond with about the given number of stones."""
    return max(2, round(2 * stones / courses) - 1)


def _courses(rng: Rng, stones: float, aspect: float) -> tuple[int, int]:
    """Return the number of courses of a pier with about the given number of stones, and its length.

    The length is in half blocks, at least one block.
    """
    wanted = round(math.sqrt(rng.uniform(1.8, 3) * stones / aspect))
    wanted = min(wanted, int(stones / 1.5))
    # One course more or less may give a number of stones nearer to the wanted number.
    near = [(courses, _length(stones, courses)) for courses in range(max(2, wanted - 1), wanted + 2)]
    return min(near, key=lambda pier: abs(pier[0] * (pier[1] + 1) // 2 - stones))


def _cut(rng: Rng, stones: int, length: int, courses: int) -> list[Opening]:
    """Return openings at random places of a wall, until the wall has at most the wanted number of stones.

    The function gives up after ten attempts for each stone.
    """
    cut: list[Opening] = []
    for _ in range(10 * stones):
        across, upwards = rng.integers(2, 9, size=2).tolist()
        # A block remains at each end of the wall, one and a half blocks remain between openings, and a course
        # remains above each lintel.
        if across > length - 4 or upwards > courses - 2:
            continue
        left = int(rng.integers(2, length - across - 1))
        bottom = int(rng.integers(0, courses - upwards - 1))
        right, top = left + across, bottom + upwards
        if any(
            left < other[1] + 3 and other[0] < right + 3 and bottom < other[3] + 2 and other[2] < top + 2
            for other in cut
        ):
            continue
        cut.append((left, right, bottom, top))
        if len(_pieces(length, courses, cut)) <= stones:
            break
    return cut


def _pieces(length: int, courses: int, cut: list[Opening]) -> list[Piece]:
    """Return the stones of a wall with openings; a lintel rests on half a block at each end."""
    pieces: list[Piece] = []
    for row in range(courses):
        gaps = [(left, right) for left, right, bottom, top in cut if bottom <= row < top]
        lintels = [(left - 1, right + 1) for left, right, _, top in cut if top == row]
        ends = sorted({*_bond(length, row), *chain(*gaps), *chain(*lintels)})
        pieces += [
            (left, right, row)
            for left, right in pairwise(ends)
            if not any(begin <= left < end for begin, end in gaps + lintels)
        ]
        pieces += [(left, right, row) for left, right in lintels]
    return pieces

"""Measure three limits with which messages and readers tell errors of a drawing from its intended shape.

    python benchmarks/drawing_limits.py --scenes 8 --first 8440000

For each limit, the script makes random drawings with and without the mistake that the limit should detect:

- ``_WIDE_MORTAR``: arches of bricks, walls and tessellations without their mortar, which is 0.1 to 0.9 times
  as wide as a stone. The advised tolerance should make all joints. In other scenes the upper part is drawn
  too high, by 0.3 to 1.5 of the least thickness. A message should then advise no tolerance.
- ``_FLATNESS``: ground planes of triangles with rounded coordinates, which should be supports. Bent surfaces
  and thin plates should not count as flat polygons.
- ``_WIDEST_ERROR``: outlines whose ends miss each other by 0.01 % to 5 % of the outline's length. The message
  should advise a tolerance only. For polylines without the flag "closed", and for outlines of lines without
  their last side, the message should advise other remedies too.

Drawings with a mistake and the expected outcome are hits. Other drawings with this outcome are false alarms.
The script counts both with the limit as set, three times smaller, three times larger, without the limit, and
with a limit of zero, which switches the rule off.
"""

import argparse
import math
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import NamedTuple

import ezdxf
import numpy as np
import shapely

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from brickwork import brick_ring, stone  # noqa: E402
from changed_constants import changed  # noqa: E402
from drawing_warnings import KINDS, Drawing, drawn, exact_scene, messages, outcome, pairs_of  # noqa: E402
from meshes import box, obj, prism  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402
from masonry_opt.scene.contacts import mortar  # noqa: E402
from masonry_opt.scene.drawings import loops, meshes  # noqa: E402

#: Number of drawings of each group for each seed.
EACH = 4


class Sample(NamedTuple):
    """A random drawing, and a function that returns True if the package reads it as a limit decides."""

    group: str
    is_hit: bool  #: True if the outcome is right
    has_outcome: Callable[[], bool]


def without_tolerances(_mortar: float, _error: float) -> tuple[None, None]:
    return None, None


UNTOLERATED = Drawing("without tolerances", 0.0, 0.0, without_tolerances, is_correct=False)


def of_wide_mortar(seed: int) -> Iterator[Sample]:
    """Yield drawings with empty gaps instead of mortar, and drawings whose upper part is lifted."""
    for number in range(EACH * seed, EACH * (seed + 1)):
        rng = rng_of(73, number)
        arch, pairs = brick_arch(rng)
        yield Sample("arches of bricks without mortar", True, partial(is_bridged, arch, pairs))
        exact = exact_scene(KINDS[number % len(KINDS)], number)
        yield Sample("upper part too high", False, partial(has_advice, too_high(exact, number)))
        try:
            wide = drawn(exact, UNTOLERATED._replace(mortar=rng.uniform(0.1, 0.47)), number)
        except mo.CaseError:
            continue  # small stones vanish between wide mortar joints
        yield Sample("other scenes without mortar", True, partial(is_bridged, wide, pairs_of(exact)))


def rng_of(*numbers: int) -> np.random.Generator:
    return np.random.default_rng(numbers)


def brick_arch(rng: np.random.Generator) -> tuple[mo.Scene, set[frozenset[str]]]:
    """Return a semicircular arch of bricks with empty gaps, and the pairs of blocks that have a joint.

    Half of the arches begin at level springers.
    """
    count, brick = int(rng.integers(7, 30)), float(rng.uniform(0.06, 0.25))
    spacing = brick * (1 + rng.uniform(0.1, 0.9))
    thick = float(rng.uniform(0.5, 2.0)) * brick
    radius = spacing * count / math.pi - thick / 2
    scene = brick_ring(radius, thick, count, brick)
    blocks = [block for block in scene.blocks if not block.fixed]
    names = ["v-1", *(block.name for block in blocks), f"v{count}"]
    if rng.random() < 0.5:
        for name, x in ((names[0], -1), (names[-1], 1)):
            middle = x * (radius + thick / 2)
            ground = shapely.box(middle - thick, -thick, middle + thick, 0)
            blocks.append(stone(name, ground, fixed=True))
        scene = scene.replace(blocks=blocks)
    return scene, {frozenset(pair) for pair in pairwise(names)}


def too_high(scene: mo.Scene, seed: int) -> mo.Scene:
    """Return a scene whose upper blocks are lifted by 0.3 to 1.5 times the thickness of the thinnest."""
    rng = rng_of(79, seed)
    shapes = assemble(scene).geometry
    heights = shapes.centroid[~scene.fixed, 1]
    level = float(np.quantile(heights, rng.uniform(0.1, 0.9)))
    distance = float(rng.uniform(0.3, 1.5) * shapes.thickness()[~scene.fixed].min())
    lifted = np.flatnonzero(~scene.fixed & (shapes.centroid[:, 1] >= level - 1e-9))
    changes = {}
    for index in lifted.tolist():
        block = scene.blocks[index]
        corners = [(x, y + distance) for x, y in block.vertices]
        changes[block.name] = {"vertices": corners, "live_at": None, "weight_at": None}
    return scene.replace(blocks=changes)


def is_bridged(scene: mo.Scene, expected: set[frozenset[str]]) -> bool:
    """Return True if the advised tolerances make all expected joints."""
    return outcome(scene, UNTOLERATED, expected) == "right"


def has_advice(scene: mo.Scene) -> bool:
    """Return True if a message advises a tolerance."""
    return any("tolerance' to" in message for message in messages(scene))


def of_flat_meshes(seed: int) -> Iterator[Sample]:
    """Yield triangulated ground planes whose coordinates are rounded, bent surfaces, and thin plates."""
    for number in range(EACH):
        rng = rng_of(83, seed, number)
        # Coordinates have at least five significant digits. Far from the origin, fewer digits remain for the
        # shape.
        rounding = 10 ** rng.uniform(-7, -4)
        ground = tilted(rounded(triangulated(rng, 0.0), rounding, rng), rng)
        yield Sample("rounded ground planes", True, partial(is_support, *ground))
        bent = tilted(triangulated(rng, 10 ** rng.uniform(-4, -1)), rng)
        yield Sample("bent surfaces", False, partial(is_support, *bent))
        outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        plate = tilted(prism(outline, 10 ** rng.uniform(-4, -2)), rng)
        yield Sample("thin plates", False, partial(is_one_face, *plate))


Surface = tuple[np.ndarray, list[tuple[int, ...]]]


def triangulated(rng: np.random.Generator, height: float) -> Surface:
    """Return a square that is divided into triangles. Its corners have random heights up to ``height``."""
    inner = rng.uniform(0.05, 0.95, (int(rng.integers(0, 12)), 2))
    flat = np.array([(0, 0), (1, 0), (1, 1), (0, 1), *inner], dtype=float)
    parts = shapely.get_parts(shapely.delaunay_triangles(shapely.multipoints(flat)))
    faces = [
        tuple(int(np.hypot(*(flat - corner).T).argmin()) for corner in part.exterior.coords[:3])
        for part in parts
    ]
    return np.column_stack([flat, height * rng.uniform(-1, 1, len(flat))]), faces


def rounded(surface: Surface, rounding: float, rng: np.random.Generator) -> Surface:
    """Return a surface with errors up to half a unit of the last digit."""
    corners, faces = surface
    return corners + rng.uniform(-rounding / 2, rounding / 2, corners.shape), faces


def tilted(surface: Surface, rng: np.random.Generator) -> Surface:
    """Tilt a surface by a random slope of at most 0.4, and move it below the stone of the drawing."""
    corners, faces = surface
    angle = rng.uniform(-0.4, 0.4)
    cos, sin = math.cos(angle), math.sin(angle)
    turn = np.array([(cos, 0, sin), (0, 1, 0), (-sin, 0, cos)])
    return 10 * (corners - [0.5, 0.5, 0.5]) @ turn.T, faces


def is_support(corners: np.ndarray, faces: list[tuple[int, ...]]) -> bool:
    """Return True if the package reads a surface as a support."""
    blocks = {"stone": box((0, 1), (0, 1), (3, 4)), "fixed": (corners, faces)}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "stones.obj"
        path.write_bytes(obj(blocks, digits=12))
        try:
            mo.read_mesh(path, friction=0.6, unit_weight=1.0)
        except mo.CaseError:
            return False
    return True


def is_one_face(corners: np.ndarray, faces: list[tuple[int, ...]]) -> bool:
    """Return True if a mesh counts as a flat polygon."""
    return meshes.with_one_face(meshes.Mesh("plate", corners, [list(face) for face in faces])).flat


def of_open_outlines(seed: int) -> Iterator[Sample]:
    """Yield drawings with one open outline: its ends miss each other, or its last side is not drawn."""
    scene = exact_scene(KINDS[seed % len(KINDS)], seed)
    movable = [number for number, block in enumerate(scene.blocks) if not block.fixed]
    for number in range(EACH):
        rng = rng_of(89, seed, number)
        index = int(rng.choice(movable))
        corners = np.roll(np.array(scene.blocks[index].vertices), int(rng.integers(20)), axis=0)
        length = float(np.hypot(*(np.roll(corners, -1, axis=0) - corners).T).sum())
        miss = length * 10 ** rng.uniform(-4, math.log10(0.05))
        side = corners[0] - corners[-1]
        end = corners[0] - side * min(miss / np.hypot(*side), 0.9)
        sides = [corners[pair : pair + 2] for pair in range(len(corners) - 1)]
        cases = (
            ("ends that miss each other", True, [np.vstack([corners, end])]),
            ("polylines without the flag", False, [corners]),
            ("a side is missing", False, sides),
        )
        for group, is_hit, chains in cases:
            yield Sample(group, is_hit, partial(raises_only, scene, index, chains))


def raises_only(scene: mo.Scene, index: int, chains: list[np.ndarray]) -> bool:
    """Return True if the message about an open outline advises to raise the tolerance, and nothing else."""
    document = ezdxf.new()
    space = document.modelspace()
    for number, block in enumerate(scene.blocks):
        layer = {"layer": "fixed" if block.fixed else "stones"}
        for chain in chains if number == index else [block.vertices]:
            space.add_lwpolyline([tuple(corner) for corner in chain], close=number != index, dxfattribs=layer)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "stones.dxf"
        document.saveas(path)
        try:
            mo.read_dxf(path, friction=0.6, unit_weight=1.0)
        except mo.CaseError as error:
            others = "set the flag 'closed'|draw the missing sides"
            return "raise 'outline_tolerance'" in str(error) and not re.search(others, str(error))
    return False


LIMITS: dict[str, tuple[ModuleType, Callable[[int], Iterator[Sample]]]] = {
    "_WIDE_MORTAR": (mortar, of_wide_mortar),
    "_FLATNESS": (meshes, of_flat_meshes),
    "_WIDEST_ERROR": (loops, of_open_outlines),
}


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", type=int, default=8, help="number of seeds")
    parser.add_argument("--first", type=int, default=8_440_000, help="first seed")
    asked = parser.parse_args()
    print("limit,value,group,drawings,outcome,expected")
    for name, (module, make) in LIMITS.items():
        samples = [sample for seed in range(asked.scenes) for sample in make(asked.first + seed)]
        groups = {sample.group: sample.is_hit for sample in samples}
        total = Counter(sample.group for sample in samples)
        value = getattr(module, name)
        values = {"as set": value, "/ 3": value / 3, "x 3": 3 * value, "none": math.inf, "zero": 0.0}
        for label, other in values.items():
            with changed([module], name, other):
                count = Counter(sample.group for sample in samples if sample.has_outcome())
            for group, is_hit in groups.items():
                expected = total[group] if is_hit else 0
                print(name, label, group, total[group], count[group], expected, sep=",", flush=True)


if __name__ == "__main__":
    main()

"""Draw scenes with several joints on a side, from errors of a survey or on purpose, as random scenes.

The sides of surveyed drawings have several joints that should be one joint. Sides that are curved on purpose
have several joints too, which no warning should name.
"""

import math
import sys
from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.odd_stones import odd_scene  # noqa: E402
from atlas.random_scenes import random_scene  # noqa: E402
from input_warnings import own_samples  # noqa: E402
from meshes import obj, prism  # noqa: E402
from realistic_scenes import built, correct_scene  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.problem.assembly import Assembly, assemble  # noqa: E402

#: Errors of corners, relative to the mean width of a block.
ERRORS = (1e-3, 5e-3, 2e-2)
#: Number of arches of several rings for each seed.
OF_RINGS = 4
#: Number of stacks with curved beds for each seed.
OF_CURVED = 10
#: Number of correct scenes of every kind (``realistic_scenes.py``) for each seed.
OF_CORRECT = 5


def width_of(scene: mo.Scene) -> float:
    """Return the mean width of the movable blocks."""
    return float(assemble(scene).geometry.width[~scene.fixed].mean())


def traced(scene: mo.Scene, seed: int, error: float) -> mo.Scene:
    """Return a plane scene whose outlines have three corners on each side, with errors.

    The contact tolerance closes the gaps. Supports have errors too.
    """
    rng, blocks, error = np.random.default_rng([59, seed]), [], error * width_of(scene)
    for block in scene.blocks:
        corners = np.array(block.vertices)
        sides = np.roll(corners, -1, axis=0) - corners
        outline = (corners[:, None] + sides[:, None] * np.array([[0], [1 / 3], [2 / 3]])).reshape(-1, 2)
        outline = outline + rng.uniform(-error, error, outline.shape)
        blocks.append(block.replace(vertices=outline.tolist(), live_at=None))
    return scene.replace(blocks=blocks, tolerance=None, contact_tolerance=4 * error or None)


def meshed(scene: mo.Scene, seed: int, error: float) -> mo.Scene:
    """Return a plane scene as meshes of triangles, twice as thick as a block is wide, with errors."""
    width = width_of(scene)
    rng, solids = np.random.default_rng([61, seed]), {}
    for block in scene.blocks:
        corners, faces = prism([tuple(corner) for corner in block.vertices], 2 * width)
        fans = [(face[0], *edge) for face in faces for edge in pairwise(face[1:])]
        solids[block.name] = (corners + rng.uniform(-1, 1, corners.shape) * error * width, fans)
    fixed = [block.name for block in scene.blocks if block.fixed]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "stones.obj"
        path.write_bytes(obj(solids))
        contact = 4 * error * width or None
        return mo.read_mesh(path, friction=0.6, unit_weight=1.0, fixed=fixed, contact_tolerance=contact)


def curved(seed: int) -> mo.Scene:
    """Return a stack of layers, of which a random share of the beds is curved.

    The directions of a curved bed change by 0.1 to 2 rad from end to end, in 2 to 40 chords.
    """
    rng = np.random.default_rng([67, seed])
    half, chords = math.exp(rng.uniform(math.log(0.05), 0)), int(rng.integers(2, 41))
    layers, share = int(rng.integers(2, 20)), rng.random()
    x = np.linspace(-0.5, 0.5, chords + 1)
    rise = np.sqrt((0.5 / math.sin(half)) ** 2 - x**2) - 0.5 / math.tan(half)
    high, beds = 0.2 + rise.max(), []
    for number in range(layers + 1):
        is_flat = rng.random() >= share
        bed = np.column_stack([x, high * number + (0.0 if is_flat else 1.0) * rise])
        beds.append(bed[::chords] if is_flat else bed)
    blocks = [mo.Block(name="base", vertices=[*beds[0].tolist(), (0.5, -1), (-0.5, -1)], fixed=True)]
    for number in range(layers):
        outline = [*beds[number].tolist(), *beds[number + 1][::-1].tolist()]
        blocks.append(mo.Block(name=f"layer {number}", vertices=outline, unit_weight=1))
    return mo.Scene(joints={"friction": 0.6}, blocks=blocks)


def rings(seed: int) -> mo.Scene:
    """Return a semicircular arch of two to four rings, which touch along two, four or six chords a stone.

    Radial joints of neighbouring rings are on one line, or staggered by half a stone.
    """
    rng = np.random.default_rng([71, seed])
    count, chords, number = int(rng.integers(8, 41)), 2 * int(rng.integers(1, 4)), int(rng.integers(2, 5))
    staggered = rng.random() < 0.5
    angle, blocks = np.pi / count, []

    def arc(radius: float, start: float, end: float) -> np.ndarray:
        along = np.linspace(start, end, max(1, round((end - start) / angle * chords)) + 1)
        return radius * np.column_stack([np.cos(along), np.sin(along)])

    ground = [(-2.5, -0.2), (2.5, -0.2), (2.5, 0.0), (-2.5, 0.0)]
    blocks.append(mo.Block(name="ground", vertices=ground, fixed=True))
    for ring in range(number):
        low, high = 1 + 0.2 * ring, 1.2 + 0.2 * ring
        ends = angle * np.arange(count + 1.0)
        if staggered and ring % 2:
            ends = np.array([0.0, *(ends[:-1] + angle / 2), np.pi])
        for stone, (start, end) in enumerate(pairwise(ends)):
            outline = [*arc(high, start, end), *arc(low, start, end)[::-1]]
            vertices = np.array(outline).tolist()
            blocks.append(mo.Block(name=f"{ring}-{stone}", vertices=vertices, unit_weight=1))
    return mo.Scene(joints={"friction": 0.6}, blocks=blocks)


def groups(first: int, count: int, exact: Callable[[int], mo.Scene]) -> Iterator[tuple[str, bool, Assembly]]:
    """Yield the name of each group with its scenes, and if a warning about uneven sides is right.

    The function ``exact`` returns the exact drawing of a seed. Scenes that are refused are left out.
    """
    for _, assembly in own_samples():
        yield "case files and atlas", False, assembly
    for group, is_survey, make in _made(first, count, exact):
        try:
            yield group, is_survey, assemble(make())
        except mo.CaseError:
            continue


def _made(
    first: int, count: int, exact: Callable[[int], mo.Scene]
) -> Iterator[tuple[str, bool, Callable[[], mo.Scene]]]:
    """Yield the name of each group, if a warning is right, and a function that returns a scene."""
    drawings = (
        ("outlines", traced, exact),
        ("outlines of odd stones", traced, odd_scene),
        ("outlines of stacks", traced, lambda seed: random_scene("stack", seed)),
        ("meshes", meshed, exact),
    )
    for seed in range(first, first + count):
        for name, draw, scene in drawings:
            for error in (0.0, *ERRORS):
                group = f"{name}, error {error:g}" if error else "exact outlines and meshes"
                yield group, error > 0, partial(draw, scene(seed), seed, error)
        yield from (("rings", False, partial(rings, OF_RINGS * seed + each)) for each in range(OF_RINGS))
        yield from (
            ("curved beds", False, partial(curved, OF_CURVED * seed + each)) for each in range(OF_CURVED)
        )
        for each in range(OF_CORRECT):
            yield "scenes of every kind", False, partial(_correct, OF_CORRECT * seed + each)


def _correct(seed: int) -> mo.Scene:
    return built(correct_scene(seed))

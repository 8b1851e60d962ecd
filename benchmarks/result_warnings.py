"""Count false alarms and hits of the warnings about results, which need a solution.

    python benchmarks/result_warnings.py --scenes 8 --first 7950000

There are three tables, each with other values of its thresholds:

- Nearly parallel joints, and states far below the incremental load factor: exact drawings and surveys of
  random scenes, solved with the default method. The gaps of a survey are closed, but joints remain wedges.
- Jumps of a load factor: the least friction at which random scenes carry a load, with method "static". The
  load factor is continuous, or the friction jumps.
- Gravity of a kinematic check: stacks and arches of 2 to 60 m, with the units of length and of gravity mixed.
"""

import argparse
import math
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.random_scenes import random_scene  # noqa: E402
from changed_constants import changed  # noqa: E402
from drawing_warnings import KINDS, Drawing, drawn, exact_scene  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.finite_motion import kinematic_check  # noqa: E402
from masonry_opt.scene.typical_sizes import GRAVITY_BY_UNIT  # noqa: E402
from masonry_opt.solution import wedges  # noqa: E402
from masonry_opt.solution.motion import moving_blocks  # noqa: E402
from masonry_opt.solution.reasons import Code, Reason  # noqa: E402
from masonry_opt.studies.many import jumps  # noqa: E402
from masonry_opt.studies.many.least import Threshold  # noqa: E402

#: Factors of the thresholds.
FACTORS = (1 / 3, 1.0, 3.0)
#: Errors of the surveys, relative to the mean width of a block.
ERRORS = (1e-4, 1e-3)
#: Spectrum that does not end before any secant period.
SPECTRUM = [(0.0, 0.2), (1e6, 0.2)]


def nearly_parallel(result: mo.Result, factor: float) -> Reason | None:
    """Return the warning about nearly parallel joints with a multiple of the usual angle."""
    with changed([wedges], "_NEARLY_PARALLEL_ANGLE", factor * wedges._NEARLY_PARALLEL_ANGLE):
        found = list(wedges.wedges(result.assembly, result.solution))
    return next((each for each in found if each.code is Code.NEARLY_PARALLEL), None)


def print_drawings(first: int, count: int) -> None:
    """Print the warnings about nearly parallel joints, and the load factors far below the incremental one."""
    print("scene,blocks,error,load factor,incremental,moving,warned at / 3,at 1,at x 3,pairs,scatter")
    for seed in range(first, first + count):
        kind = KINDS[seed % len(KINDS)]
        scene = exact_scene(kind, seed)
        if kind == "bond":
            pushed = {block.name: {"live_per_weight": (1, 0)} for block in scene.blocks if not block.fixed}
            scene = scene.replace(blocks=pushed)
        scene = scene.replace(blocks={block.name: {"live_at": None} for block in scene.blocks})
        for error in (0.0, *ERRORS):
            closed = Drawing("", 0.0, error, lambda _, e: (None, 4 * e or None), is_correct=False)
            try:
                result = mo.solve(drawn(scene, closed, seed), time_limit=15)
            except mo.CaseError:
                continue
            said = [nearly_parallel(result, factor) for factor in FACTORS]
            values = said[1].values if said[1] else {"pairs": [], "scatter": math.nan}
            moves = result.solution.d is not None
            moving = len(moving_blocks(result.assembly, result.solution.d)) if moves else 0
            numbers = f"{result.load_factor},{result.incremental},{moving}"
            warned = ",".join("yes" if each else "no" for each in said)
            ends = f"{len(values['pairs'])},{values['scatter']:.2f}"
            print(f"{kind} {seed}", result.size.blocks, error, numbers, warned, ends, sep=",", flush=True)


def thresholds(first: int, count: int) -> Iterator[tuple[bool, Threshold, float]]:
    """Yield thresholds of friction with the required load, and if the friction jumps at the threshold."""
    for seed in range(first, first + count):
        scene = random_scene(("wall", "arch", "stack")[seed % 3], seed)
        solved = mo.solve(scene.replace(friction=0.5), "static")
        if solved.load_factor is None or not 0.01 < solved.load_factor < 1e3:
            continue
        for step in (0.0, 0.2):

            def make(friction: float, scene: mo.Scene = scene, step: float = step) -> mo.Scene:
                return scene.replace(friction=friction + step * (friction > 0.42))

            for tolerance in (1e-2, 1e-4):
                asked = {"load": solved.load_factor, "method": "static", "tolerance": tolerance, "samples": 2}
                try:
                    yield step > 0, mo.least(make, 0.2, 0.9, **asked), solved.load_factor
                except mo.MasonryError:
                    continue


def print_jumps(first: int, count: int) -> None:
    """Print how many thresholds are called jumps, for values of the least ratio of a jump."""
    found, usual = list(thresholds(first, count)), jumps._STEEPER
    print("least ratio,continuous,of them called jumps,jumping,of them called jumps")
    for ratio in (0.0, usual / 3, usual, 3 * usual):
        jumps._STEEPER = ratio
        called: Counter[bool] = Counter()
        for is_jump, threshold, load in found:
            named = jumps.jump_between(threshold.holds, threshold.fails, threshold.trials, load)
            called[is_jump] += named is not None
        total = Counter(is_jump for is_jump, _, _ in found)
        print(f"{ratio:g}", total[False], called[False], total[True], called[True], sep=",")
    jumps._STEEPER = usual


class Mechanism(NamedTuple):
    """Largest dimension of a scene, and height of the rocking block with the same capacity curve."""

    extent: float
    height: float


def mechanisms(first: int, count: int) -> Iterator[Mechanism]:
    """Yield the mechanisms of stacks and arches under a horizontal load, each in four sizes."""
    for seed in range(first, first + count):
        scene = random_scene(("stack", "arch")[seed % 2], seed)
        pushed = {"live": (0, 0), "live_at": None, "live_per_weight": (1, 0)}
        blocks = [block if block.fixed else block.replace(**pushed) for block in scene.blocks]
        try:
            result = mo.solve(mo.Scene(joints={"friction": 3.0}, blocks=blocks), "static")
            check = mo.capacity(result, steps=20).check(SPECTRUM)
        except mo.MasonryError:
            continue
        height = kinematic_check._rocking_height(check.displacement, check.onset / check.mass_fraction)
        extent = float(result.assembly.geometry.extent_of(result.assembly.movable).max())
        rng = np.random.default_rng([53, seed])
        for size in np.exp(rng.uniform(math.log(2), math.log(60), 4)).tolist():
            yield Mechanism(size, size * height / extent)


def print_gravity(first: int, count: int) -> None:
    """Print how many checks are warned about for each unit of the drawing and of the gravity."""
    found, usual = list(mechanisms(first, count)), kinematic_check._HIGHEST_ROCKING_BLOCK
    print("highest rocking block (m),drawing,gravity,checks,warned")
    for highest in (math.inf, *(factor * usual for factor in FACTORS)):
        kinematic_check._HIGHEST_ROCKING_BLOCK = highest
        for unit, own in GRAVITY_BY_UNIT.items():
            scale = own / GRAVITY_BY_UNIT["metres"]
            for other, gravity in GRAVITY_BY_UNIT.items():
                warned = sum(
                    bool(
                        kinematic_check._gravity_warnings(
                            gravity, scale * each.extent, scale * each.height, 1.0
                        )
                    )
                    for each in found
                )
                print(f"{highest:g}", unit, other, len(found), warned, sep=",")
    kinematic_check._HIGHEST_ROCKING_BLOCK = usual


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", type=int, default=8, help="number of seeds")
    parser.add_argument("--first", type=int, default=7_900_000, help="first seed")
    asked = parser.parse_args()
    print_jumps(asked.first, asked.scenes)
    print_gravity(asked.first, asked.scenes)
    print_drawings(asked.first, asked.scenes)


if __name__ == "__main__":
    main()

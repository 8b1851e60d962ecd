"""Count false alarms and hits of the warnings about results, which need a solution.

    python benchmarks/result_warnings.py --scenes 8 --first 7950000
    python benchmarks/result_warnings.py --self-stress --scenes 40 --first 8410000

There are three tables, each with other values of its thresholds:

- Nearly parallel joints: exact drawings and surveys of random scenes, solved with the default method. The
  gaps of a survey are closed, but joints remain wedges.
- Jumps of a load factor: the least friction at which random scenes carry a load, with method "static". The
  load factor is continuous, or the friction jumps.
- Gravity of a kinematic check: stacks and arches of 2 to 60 m, with the units of length and of gravity mixed.

With --self-stress, the only table is about the line ``self-stress`` of a summary, which explains a low load
factor. The explanation is right if the exact state at the end of the load history has a load factor nearer to
the incremental one than to the lowest. If this state has a lower load factor, the explanation is wrong: the
load factor is low because the blocks have moved. If the load history ends without an exact state, it is not
known if the explanation is right, so these scenes are counted apart.
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
from atlas.random_scenes_in_space import KINDS as KINDS_IN_SPACE  # noqa: E402
from atlas.random_scenes_in_space import random_scene_in_space  # noqa: E402
from changed_constants import changed  # noqa: E402
from drawing_warnings import KINDS, Drawing, drawn, exact_scene  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.finite_motion import kinematic_check  # noqa: E402
from masonry_opt.reporting import summary  # noqa: E402
from masonry_opt.scene.typical_sizes import GRAVITY_BY_UNIT  # noqa: E402
from masonry_opt.solution import wedges  # noqa: E402
from masonry_opt.solution.motion import moving_blocks  # noqa: E402
from masonry_opt.solution.reasons import Code, Reason  # noqa: E402
from masonry_opt.studies.many import jumps  # noqa: E402
from masonry_opt.studies.many.threshold import Threshold  # noqa: E402

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
    """Print the warnings about nearly parallel joints."""
    print("scene,blocks,error,load factor,warned at / 3,at 1,at x 3,pairs,scatter")
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
            warned = ",".join("yes" if each else "no" for each in said)
            ends = f"{len(values['pairs'])},{values['scatter']:.2f}"
            cells = f"{kind} {seed}", result.size.blocks, error, result.load_factor, warned, ends
            print(*cells, sep=",", flush=True)


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
    found, usual = list(thresholds(first, count)), jumps._JUMP_RATIO
    print("least ratio,continuous,of them called jumps,jumping,of them called jumps")
    for ratio in (0.0, usual / 3, usual, 3 * usual):
        jumps._JUMP_RATIO = ratio
        called: Counter[bool] = Counter()
        for is_jump, threshold, load in found:
            named = jumps.jump_between(threshold.holds, threshold.fails, threshold.trials, load)
            called[is_jump] += named is not None
        total = Counter(is_jump for is_jump, _, _ in found)
        print(f"{ratio:g}", total[False], called[False], total[True], called[True], sep=",")
    jumps._JUMP_RATIO = usual


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


class LowState(NamedTuple):
    """A result whose lowest load factor is below the incremental one."""

    result: mo.Result
    #: True if self-stress is the cause; None if the load history ends without an exact state.
    is_due_to_self_stress: bool | None


def low_states(first: int, count: int) -> Iterator[LowState]:
    """Yield the results of random scenes in space whose load factor is below the incremental one.

    A row is printed for each result. The default proves no load factor of these scenes to be the least.
    """
    kinds = list(KINDS_IN_SPACE)
    print("scene,load factor,state of the load history,incremental,moving,blocks")
    for seed in range(first, first + count):
        kind = kinds[seed % len(kinds)]
        result = mo.solve(random_scene_in_space(kind, seed))
        with changed([summary], "_FAR_BELOW", 1.0), changed([summary], "_FEW_BLOCKS", 1.0):
            if not summary._self_stress(result):
                continue
        lowest, highest, history = result.load_factor, result.incremental, result.at_incremental
        assert lowest is not None
        assert highest is not None
        state = history and history.load_factor
        is_due_to_self_stress = None if state is None else highest - state < state - lowest
        moving = len(moving_blocks(result.assembly, result.solution.d))
        print(f"{kind} {seed}", lowest, state, highest, moving, result.size.blocks, sep=",", flush=True)
        yield LowState(result, is_due_to_self_stress)


def print_self_stress(first: int, count: int) -> None:
    """Print how many load factors the summary explains by self-stress, for values of both limits."""
    found = list(low_states(first, count))
    print("limit,value,explained,of them rightly,of them without exact state")
    for name in ("_FAR_BELOW", "_FEW_BLOCKS"):
        usual = getattr(summary, name)
        # A limit of 1 has no effect, so three times the value is the same as no limit.
        for value in (usual / 3, usual, 1.0):
            with changed([summary], name, value):
                explained = [each for each in found if summary._self_stress(each.result)]
            count_of = Counter(each.is_due_to_self_stress for each in explained)
            print(name, f"{value:.3g}", len(explained), count_of[True], count_of[None], sep=",")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", type=int, default=8, help="number of seeds")
    parser.add_argument("--first", type=int, default=7_900_000, help="first seed")
    parser.add_argument("--self-stress", action="store_true", help="only the line about self-stress")
    asked = parser.parse_args()
    if asked.self_stress:
        print_self_stress(asked.first, asked.scenes)
        return
    print_jumps(asked.first, asked.scenes)
    print_gravity(asked.first, asked.scenes)
    print_drawings(asked.first, asked.scenes)


if __name__ == "__main__":
    main()

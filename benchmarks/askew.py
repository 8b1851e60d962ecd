"""Measure how load factors depend on small errors of a drawing, with walls whose corners have known errors.

    python benchmarks/askew.py
    python benchmarks/askew.py --space 6
    python benchmarks/askew.py --dynamics

The walls are random walls and running bonds with openings (tests/atlas) on which the flow rule matters: the
lowest load factor is below 0.97 of the associative load factor. In each copy, every coordinate of every block
has a random error of up to 1e-5, 1e-4 or 1e-3 of the mean size of a block. The tolerance of the copy is three
times the error.

The table has a row for each copy. It contains the largest rotation of a joint, and the lowest and the
incremental load factor of the copy, divided by those of the exact drawing. The last lines count the copies
within 5 %, and contain the largest changes of both load factors.

--dynamics compares the incremental load factor with explicit dynamics of the exact drawing, which takes some
minutes.
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import count
from math import nan
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.large_scenes import openings  # noqa: E402
from atlas.random_scenes import random_scene  # noqa: E402
from atlas.random_scenes_in_space import random_scene_in_space  # noqa: E402
from contact_dynamics import DEFAULTS, DynamicsSettings, collapse_load  # noqa: E402
from drawing_errors import with_errors  # noqa: E402

import masonry_opt as mo  # noqa: E402

#: First seed of the walls, above all seeds that were used for tuning.
FIRST = 1_250_000
#: Errors of the coordinates, over the mean size of a block.
ERRORS = (1e-5, 1e-4, 1e-3)
#: The flow rule matters if the lowest load factor is below this share of the associative load factor.
MATTERS = 0.97
#: Load factors of a copy and of the exact drawing agree within this share.
AGREE = 0.05
#: Explicit dynamics raise the load up to this multiple of the incremental load factor. A scene that carries
#: this load has no value.
HIGHEST = 1.5


def walls(make: Callable[[int], mo.Scene], number: int) -> Iterator[tuple[mo.Scene, mo.Result]]:
    """Yield the first walls on which the flow rule matters, with their results."""
    found = 0
    for seed in count(FIRST):
        if found == number:
            return
        scene = make(seed)
        try:
            result = mo.solve(scene)
        except mo.CaseError:
            continue
        known = result.load_factor, result.incremental, result.associative
        if None in known or min(known) < 0.01 or result.load_factor > MATTERS * result.associative:
            continue
        found += 1
        yield scene, result


def patient(load_factor: float) -> DynamicsSettings:
    """Return settings that limit forces out of balance relative to the weight.

    The default settings limit them relative to the largest load, which is the live load if the load factor
    exceeds one. The load would then increase before the blocks come to rest, and would be too high by up to a
    third.
    """
    share = 1 / max(1.0, load_factor)
    settings = {name: share * getattr(DEFAULTS, name) for name in ("gain", "waiting", "rest")}
    return replace(DEFAULTS, **settings)


def ratio(value: float | None, exact: float) -> float:
    """Return a load factor divided by that of the exact drawing, or NaN if the copy has no load factor."""
    return nan if value is None else value / exact


def main() -> None:
    """Solve the walls and their copies, and print the table."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("--walls", type=int, default=12)
    options.add_argument("--openings", type=int, default=11)
    options.add_argument("--space", type=int, default=0)
    options.add_argument("--copies", type=int, default=2)
    options.add_argument("--dynamics", action="store_true")
    asked = options.parse_args()
    found = [
        *walls(lambda seed: random_scene("wall", seed), asked.walls),
        *walls(lambda seed: openings(40, seed), asked.openings),
        *walls(lambda seed: random_scene_in_space("boxes", seed), asked.space),
    ]
    expected = [result.incremental for _, result in found]
    if asked.dynamics:
        print("scene,incremental,dynamics")
        for number, (scene, result) in enumerate(found):
            expected[number] = collapse_load(scene, HIGHEST * result.incremental, patient(result.incremental))
            print(scene.title, f"{result.incremental:.5f}", f"{expected[number]:.5f}", sep=",", flush=True)
    print("scene,error,copy,turn,lowest,lowest/exact,incremental/exact", flush=True)
    agree = {error: np.zeros(3, dtype=int) for error in ERRORS}
    largest = {error: np.zeros(2) for error in ERRORS}
    for (scene, exact), load in zip(found, expected, strict=True):
        for error in ERRORS:
            for copy in range(asked.copies):
                result = mo.solve(with_errors(scene, error, copy))
                turn = result.assembly.joints.turn.max()
                ratios = ratio(result.load_factor, exact.load_factor), ratio(result.incremental, load)
                agree[error] += [1, *(abs(value - 1) <= AGREE for value in ratios)]
                largest[error] = np.fmax(largest[error], np.abs(np.subtract(ratios, 1)))
                numbers = f"{turn:.1e},{exact.load_factor:.5f},{ratios[0]:.4f},{ratios[1]:.4f}"
                print(scene.title, error, copy, numbers, sep=",", flush=True)
    for error, (copies, lowest, incremental) in agree.items():
        changes = ", ".join(f"{change:.2%}" for change in largest[error])
        print(
            f"error {error:g}: within 5 % of {copies}: lowest {lowest}, incremental {incremental}; "
            f"largest changes {changes}"
        )


if __name__ == "__main__":
    main()

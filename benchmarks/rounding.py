"""Measure how load factors depend on the last digits of coordinates, with copies of random walls.

    python benchmarks/rounding.py --first 710000 --walls 50 --copies 10

In each copy, every corner is moved by up to 1e-8 of the size of its block. The script prints a row for each
wall. It contains the number of load factors among the original and its copies, and their largest relative
difference; then both numbers for the incremental load factor.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from analysis.test_small_scenes import moved
from atlas.random_scenes import random_scene

import masonry_opt as mo


def apart(found: list[float | None]) -> str:
    """Return the number of values that are not None, and the relative difference of largest and least."""
    known = [value for value in found if value is not None]
    return f"{len(known)},{max(known) / min(known) - 1:.2g}" if known else "0,"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--first", type=int, default=710_000)
    parser.add_argument("--walls", type=int, default=50)
    parser.add_argument("--copies", type=int, default=10)
    asked = parser.parse_args()
    print("seed,lowest,apart,incremental,apart", flush=True)
    for seed in range(asked.first, asked.first + asked.walls):
        wall = random_scene("wall", seed)
        results = [mo.solve(scene) for scene in (wall, *(moved(wall, copy) for copy in range(asked.copies)))]
        rows = ([getattr(result, name) for result in results] for name in ("load_factor", "incremental"))
        print(seed, *map(apart, rows), sep=",", flush=True)


if __name__ == "__main__":
    main()

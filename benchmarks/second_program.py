"""Are verdicts and load factors of random scenes of every kind and load those of a second program?

    python benchmarks/second_program.py --scenes 1000 --first 900000

A line for each scene that is wrong or open, and the sums. Exit code 1: one is wrong.
"""

import argparse
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from second_program import random_of_any_kind, told_of

from masonry_opt.errors import CaseError


def told(seed: int) -> tuple[int, str]:
    """The seed, and what is told of its scene, which may hang in the air."""
    try:
        return seed, told_of(random_of_any_kind(seed))
    except CaseError:
        return seed, "refused"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--first", type=int, default=900_000)
    asked = parser.parse_args()
    ends: Counter[str] = Counter()
    with ProcessPoolExecutor(2) as pool:
        for seed, said in pool.map(told, range(asked.first, asked.first + asked.scenes)):
            ends[said.partition(":")[0]] += 1
            if said not in ("agrees", "on the edge", "refused"):
                print(f"{seed}: {said}", flush=True)
    print("; ".join(f"{count} {end}" for end, count in ends.most_common()))
    sys.exit(bool(ends["wrong"]))


if __name__ == "__main__":
    main()

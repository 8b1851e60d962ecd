"""Compare verdicts, load factors and reactions of random scenes with those of an independent second program.

    python benchmarks/second_program.py --scenes 1000 --first 900000 --save findings/

The script prints a line for each scene that is wrong or undecided ("open"), and counts the verdicts. --save
writes these scenes as case files. The exit code is 1 if a scene is wrong.
"""

import argparse
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from claims import wrong_reactions
from second_program import random_of_any_kind, verdict_on

import masonry_opt as mo
from masonry_opt.errors import CaseError

#: If this number divides the seed, the reactions of a support that settles are also compared.
SETTLING = 4


def verdict(seed: int) -> tuple[int, str]:
    """Return a seed and the verdict on its scene.

    The verdict is "refused" if the scene has an error, such as a block without joints.
    """
    try:
        scene = random_of_any_kind(seed)
        outcome = verdict_on(scene)
        if outcome != "agrees" or seed % SETTLING:
            return seed, outcome
        wrong = wrong_reactions(scene, seed)
        return seed, f"wrong: {'; '.join(wrong)}" if wrong else outcome
    except CaseError as error:
        return seed, f"refused: {error}"
    except Exception as error:  # a crash counts as wrong
        return seed, f"wrong: {type(error).__name__}: {error}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--first", type=int, default=900_000)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--save", type=Path, help="folder for scenes that are wrong or open")
    asked = parser.parse_args()
    ends: Counter[str] = Counter()
    with ProcessPoolExecutor(asked.processes) as pool:
        for seed, outcome in pool.map(verdict, range(asked.first, asked.first + asked.scenes)):
            end = outcome.partition(":")[0]
            ends[end] += 1
            if end in ("wrong", "open"):
                print(f"{seed}: {outcome}", flush=True)
                if asked.save:
                    asked.save.mkdir(parents=True, exist_ok=True)
                    mo.save(random_of_any_kind(seed), asked.save / f"{seed}.toml")
    print("; ".join(f"{count} {end}" for end, count in ends.most_common()))
    sys.exit(bool(ends["wrong"]))


if __name__ == "__main__":
    main()

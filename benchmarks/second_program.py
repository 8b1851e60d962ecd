"""Compare verdicts, load factors and claims on random scenes of every kind and load with a second program.

    python benchmarks/second_program.py --scenes 1000 --first 900000 --save findings/

Prints a line for each scene that is wrong or open, and the sums; --save writes these scenes as case files.
Exit code 1: one is wrong.
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

#: One scene of so many has a support that settles: its reactions are compared too.
SETTLING = 4


def verdict(seed: int) -> tuple[int, str]:
    """Return a seed and the verdict on its scene; "refused" where a block hangs in the air, say."""
    try:
        scene = random_of_any_kind(seed)
        said = verdict_on(scene)
        if said != "agrees" or seed % SETTLING:
            return seed, said
        wrong = wrong_reactions(scene, seed)
        return seed, f"wrong: {'; '.join(wrong)}" if wrong else said
    except CaseError as error:
        return seed, f"refused: {error}"
    except Exception as error:  # a crash is a finding
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
        for seed, said in pool.map(verdict, range(asked.first, asked.first + asked.scenes)):
            end = said.partition(":")[0]
            ends[end] += 1
            if end in ("wrong", "open"):
                print(f"{seed}: {said}", flush=True)
                if asked.save:
                    asked.save.mkdir(parents=True, exist_ok=True)
                    mo.save(random_of_any_kind(seed), asked.save / f"{seed}.toml")
    print("; ".join(f"{count} {end}" for end, count in ends.most_common()))
    sys.exit(bool(ends["wrong"]))


if __name__ == "__main__":
    main()

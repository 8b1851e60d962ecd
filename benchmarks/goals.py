"""What does the default find on scenes that nothing was tuned on, and how long does it take?

    python benchmarks/goals.py --stones 60 200 600 --seeds 20
    python benchmarks/goals.py --stones --small 125

Rubble walls of so many stones, and small random scenes of the four kinds of tests/atlas: how many have a load
to expect, on its plateau or not; how many a state, and how exact; what ended without one; and processor time
over the associative program's, scene by scene in one run.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from atlas.large_scenes import rubble
from atlas.random_scenes import KINDS, random_scene

import masonry_opt as mo
from masonry_opt.answer.reasons import Code

#: First seed of the scenes: nothing was tuned above.
FIRST_SEED = 20_000


def timed(scene: mo.Scene, **options: Any) -> tuple[mo.Result, float]:
    began = time.process_time()
    result = mo.solve(scene, **options)
    return result, time.process_time() - began


def how_exact(result: mo.Result) -> str:
    """The kind of state, by what its certificate leaves of complementarity over λ."""
    if result.load_factor is None or result.certificate is None:
        return f"none: {result.status}"
    left = result.certificate.complementarity / max(abs(result.load_factor), 1e-2)
    return next((f"state to {most:.0e}" for most in (1e-8, 1e-6, 1e-5) if left <= most), "state, rough")


def tell(name: str, scenes: Iterable[tuple[str, mo.Scene]], verbose: bool) -> None:
    ends: Counter[str] = Counter()
    expected: Counter[str] = Counter()
    ratios, steps = [], []
    for called, scene in scenes:
        _, associative = timed(scene, method="static")
        result, seconds = timed(scene)
        end = how_exact(result)
        if result.load_factor is None and not result.solution.proven_none:
            end += ", not proven"
        ends[end] += 1
        codes = [said.code for said in result.expected_reasons]
        told = "plateau" if Code.PLATEAU in codes else "no plateau"
        expected[told if result.expected is not None else "none"] += 1
        ratios.append(seconds / associative)
        steps.append(result.iterations)
        if verbose:
            print(f"    {called}: {end}; {told}; {result.load_factor} {result.expected} {seconds:.1f} s")
    median, most = np.median(ratios), max(ratios)
    print(
        f"{name}: {dict(ends)}; to expect: {dict(expected)}; time × {median:.1f}, at most {most:.0f}",
        flush=True,
    )


def main(asked: argparse.Namespace) -> None:
    for stones in asked.stones:
        seeds = range(FIRST_SEED, FIRST_SEED + asked.seeds)
        tell(f"rubble of {stones}", ((str(seed), rubble(stones, seed)) for seed in seeds), asked.verbose)
    seeds = range(FIRST_SEED, FIRST_SEED + asked.small)
    for kind in KINDS if asked.small else ():
        tell(kind, ((str(seed), random_scene(kind, seed)) for seed in seeds), asked.verbose)


if __name__ == "__main__":
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("--stones", type=int, nargs="*", default=[60, 200], help="sizes of rubble walls")
    parser.add_argument("--seeds", type=int, default=20, help="walls of each size")
    parser.add_argument("--small", type=int, default=0, help="small random scenes of each kind")
    parser.add_argument("--verbose", "-v", action="store_true", help="a line a scene")
    main(parser.parse_args())

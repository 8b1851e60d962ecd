"""Measure the answers of the default on random scenes with ties, props and fill, and the duality gap.

    python benchmarks/held.py --scenes 140 --in-space 60 --first 300000

The script prints a line for each scene without an exact state, or with a duality gap above 1e-8, with its
reasons. The last lines count the scenes that are exact, that are certified, or whose status says that there
is no load factor. They also state the largest duality gap between the static and kinematic programs in CVXPY
and Pyomo.
"""

import argparse
import sys
from collections import Counter
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.held_scenes import held  # noqa: E402
from atlas.random_scenes import KINDS  # noqa: E402
from atlas.random_scenes_in_space import KINDS as KINDS_IN_SPACE  # noqa: E402

import masonry_opt as mo  # noqa: E402


def duality_gap(scene: mo.Scene) -> float | None:
    """Return the largest difference of the four associative load factors, or None without load factors.

    The difference is divided by the largest load factor, or by 1 if this is larger.
    """
    try:
        found = mo.check(scene).table["load_factor"].to_numpy(float)
    except mo.MasonryError:
        return None
    return float(np.ptp(found) / max(1.0, np.abs(found).max()))


def ended(result: mo.Result) -> str:
    """Return the outcome of a scene: "exact", "certified", or words that begin with "named" or "wrong"."""
    if result.load_factor is None:
        return f"named: {result.status}"
    if result.associative is not None and result.assembly.problem.load_factor_scale.is_lower(
        result.associative, result.load_factor
    ):
        return "wrong: above the associative load factor"
    return "exact" if result.exact else "certified"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", type=int, default=140, help="how many in the plane")
    parser.add_argument("--in-space", type=int, default=60, help="how many in space")
    parser.add_argument("--first", type=int, default=300_000, help="first seed")
    asked = parser.parse_args()
    ends: Counter[str] = Counter()
    gaps = []
    of_plane = [(kind, False) for kind in (*KINDS, "filled")]
    of_space = [(kind, True) for kind in KINDS_IN_SPACE]
    for count, kinds in ((asked.scenes, of_plane), (asked.in_space, of_space)):
        for seed in range(asked.first, asked.first + count):
            kind, space = kinds[seed % len(kinds)]
            scene = held(kind, seed, space)
            gap, result = duality_gap(scene), mo.solve(scene)
            gaps += [] if gap is None else [gap]
            ends[end := ended(result)] += 1
            if end != "exact" or (gap or 0) > 1e-8:
                codes_text = ", ".join(str(reason.code) for reason in result.reasons)
                print(f"{kind} {seed}: {end} ({codes_text}), duality gap {gap}", flush=True)
    print("; ".join(f"{count} {end}" for end, count in ends.most_common()))
    print(f"duality gap at most {max(gaps):.1e}, of {len(gaps)} scenes with an associative load factor")


if __name__ == "__main__":
    main()

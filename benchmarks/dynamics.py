"""Compare incremental load factors with the loads that bring scenes down in contact dynamics.

    python benchmarks/dynamics.py --damping 0.98

The scenes are 60 random ones whose load history jumps, or loses load at its end, and 20 that do neither
(tests/atlas; seeds from 910000 on, the first of each family). The compiled program tests/contact_dynamics.py
raises the load of one scene in each process. The script prints a row for each scene: joints, jumps, the load
factors between which equilibrium is lost, the incremental load factor, and the load factor at which the load
brings the scene down.
"""

import argparse
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.held_scenes import held  # noqa: E402
from atlas.large_scenes import large_scene  # noqa: E402
from atlas.random_scenes import random_scene  # noqa: E402
from contact_dynamics import DEFAULTS, DynamicsSettings, collapse_load  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.errors import CaseError  # noqa: E402
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis, IncrementalResult  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402
from masonry_opt.problem.problem import Problem  # noqa: E402

#: By family, numbers of scenes that jump or lose load, and of others.
FAMILIES = {
    "tessellation": (29, 6),
    "wall": (1, 4),
    "arch": (0, 3),
    "held wall": (1, 2),
    "held filled": (0, 1),
    "openings 40": (2, 1),
    "piers 40": (0, 1),
    "rubble 40": (9, 1),
    "rubble 50": (9, 1),
    "rubble 60": (9, 0),
}
FIRST = 910_000
#: Least incremental load factor of a scene. If smaller, the accuracy of dynamics does not suffice.
LEAST = 1e-3
#: Highest load factor of contact dynamics, over the incremental one. If larger, dynamics take longer.
UP_TO = 1.3


def scene_of(family: str, seed: int) -> mo.Scene:
    """A random scene."""
    kind, _, of = family.partition(" ")
    if kind == "held":
        return held(of, seed)
    return large_scene(kind, int(of), seed) if of else random_scene(kind, seed)


def scenes() -> Iterator[tuple[str, int, Problem, IncrementalResult]]:
    """Yield the family, seed, problem and incremental result of each scene."""
    for family, numbers in FAMILIES.items():
        left = list(numbers)
        for seed in count(FIRST):
            try:
                problem = assemble(scene_of(family, seed)).problem
            except CaseError:
                continue
            result = IncrementalAnalysis(problem).run()
            if result.load_factor is None or result.load_factor < LEAST:
                continue
            is_smooth = result.history.jumps == 0 and result.state is not None
            if left[is_smooth]:
                left[is_smooth] -= 1
                yield family, seed, problem, result
            if not any(left):
                break


def fall(scene: tuple[str, int, float], settings: DynamicsSettings) -> float:
    """Return the load factor under which the scene of a family and a seed falls; NaN if undecided.

    The third value is the incremental load factor.
    """
    family, seed, load_factor = scene
    try:
        return collapse_load(scene_of(family, seed), UP_TO * load_factor, settings)
    except ArithmeticError:
        return float("nan")


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--damping", type=float, default=DEFAULTS.damping)
    options.add_argument(
        "--steps", type=int, default=DEFAULTS.patience, help="steps that a load waits for rest"
    )
    options.add_argument("--processes", type=int, default=2)
    chosen = options.parse_args()
    settings = replace(DEFAULTS, damping=chosen.damping, patience=chosen.steps)
    print("family,seed,joints,jumps,carried,not carried,incremental,dynamics", flush=True)
    chosen_scenes = sorted(scenes(), key=lambda scene: scene[2].joints)
    asked = [(family, seed, result.load_factor) for family, seed, _, result in chosen_scenes]
    with ProcessPoolExecutor(chosen.processes) as pool:
        falls = pool.map(partial(fall, settings=settings), asked)
        for (family, seed, problem, result), load_factor in zip(chosen_scenes, falls, strict=True):
            values = (result.carried, result.not_carried, result.load_factor, load_factor)
            numbers = ",".join(f"{value:.5f}" for value in values)
            print(f"{family},{seed},{problem.joints},{result.history.jumps},{numbers}", flush=True)


if __name__ == "__main__":
    main()

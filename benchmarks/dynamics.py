"""Compare incremental load factors with the loads that bring scenes down in contact dynamics.

    python benchmarks/dynamics.py --damping 0.98 --first 910000
    python benchmarks/dynamics.py --damping 0.98 --cases cases/ferris_tinloi/wall_1.toml
    python benchmarks/dynamics.py --damping 0.98 --scene "rubble 40" 940007 --far 1e7 --steps 20000000

There are 80 random scenes in the plane and 20 in space (tests/atlas): the first scenes of each family with
seeds from ``--first`` on. A scene is hard if its load history jumps, or if it has no exact collapse state.
The compiled program tests/contact_dynamics.py raises the load of one scene in each process.

With --scene, the script analyses one random scene, given by its family and seed. With --far and --steps,
blocks may slide further and longer before the scene counts as collapsed in contact dynamics.

With --cases, the script analyses these case files instead. Case files that are refused, or whose incremental
load factor is too small for contact dynamics, are named and left out.

The script prints a row for each scene: the numbers of joints and jumps, whether the collapse state is exact,
the load factors between which equilibrium is lost, the incremental load factor, and the load factor at which
the scene collapses in contact dynamics.
"""

import argparse
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.held_scenes import held  # noqa: E402
from atlas.large_scenes import large_scene  # noqa: E402
from atlas.random_scenes import random_scene  # noqa: E402
from atlas.random_scenes_in_space import KINDS as KINDS_IN_SPACE  # noqa: E402
from atlas.random_scenes_in_space import random_scene_in_space  # noqa: E402
from contact_dynamics import DEFAULTS, DynamicsSettings, collapse_load  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.errors import CaseError  # noqa: E402
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis, IncrementalResult  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402
from masonry_opt.problem.problem import Problem  # noqa: E402

#: Number of scenes of each family. Load histories of tessellations and rubble often jump; most others do not.
FAMILIES = {
    "tessellation": 36,
    "wall": 5,
    "arch": 3,
    "held wall": 3,
    "held filled": 1,
    "openings 40": 3,
    "piers 40": 1,
    "rubble 40": 10,
    "rubble 50": 9,
    "rubble 60": 9,
    **{f"space {kind}": 5 for kind in KINDS_IN_SPACE},
}
#: Least incremental load factor of a scene. Contact dynamics is not accurate for smaller load factors.
LEAST = 1e-3
#: Highest load factor of contact dynamics over the incremental load factor. A larger value takes longer.
UP_TO = 1.3


def scene_of(family: str, seed: int) -> mo.Scene:
    """Return the random scene of a family and a seed, or the scene of a case file.

    ``family`` is a key of ``FAMILIES``, or the path of a case file.
    """
    if family not in FAMILIES:
        return mo.load(family)
    kind, _, variant = family.partition(" ")
    if kind == "held":
        return held(variant, seed)
    if kind == "space":
        return random_scene_in_space(variant, seed)
    return large_scene(kind, int(variant), seed) if variant else random_scene(kind, seed)


class Solved(NamedTuple):
    """Scene whose incremental load factor is large enough for contact dynamics."""

    family: str  #: family of a random scene, or path of a case file
    seed: int  #: seed of a random scene; 0 for a case file
    problem: Problem
    result: IncrementalResult


def solved(family: str, seed: int) -> Solved | None:
    """Return the scene with its incremental result, or None if its load factor is below ``LEAST`` or None.

    A scene that is refused raises CaseError.
    """
    problem = assemble(scene_of(family, seed)).problem
    result = IncrementalAnalysis(problem).run()
    if result.load_factor is None or result.load_factor < LEAST:
        return None
    return Solved(family, seed, problem, result)


def random_scenes(first: int) -> Iterator[Solved]:
    """Yield the random scenes of all families, with seeds from ``first`` on."""
    for family, number in FAMILIES.items():
        yielded = 0
        for seed in count(first):
            if yielded == number:
                break
            try:
                scene = solved(family, seed)
            except CaseError:
                continue
            if scene is not None:
                yielded += 1
                yield scene


def single_scene(family: str, seed: str) -> Iterator[Solved]:
    """Yield one random scene. Nothing is yielded if its load factor is below ``LEAST`` or None."""
    scene = solved(family, int(seed))
    if scene is not None:
        yield scene


def cases(paths: list[str]) -> Iterator[Solved]:
    """Yield the scenes of case files. Print the name of each file that is left out, and the reason."""
    for path in paths:
        try:
            scene = solved(path, 0)
        except CaseError as error:
            print(f"{path} is left out: {error}", file=sys.stderr)
            continue
        if scene is None:
            print(f"{path} is left out: no incremental load factor above {LEAST:g}", file=sys.stderr)
        else:
            yield scene


def fall(scene: tuple[str, int, float], settings: DynamicsSettings) -> float:
    """Return the load factor at which a scene collapses in contact dynamics, or NaN if it does not collapse.

    ``scene`` is a tuple of the family, the seed and the incremental load factor.
    """
    family, seed, load_factor = scene
    try:
        return collapse_load(scene_of(family, seed), UP_TO * load_factor, settings)
    except ArithmeticError:
        return float("nan")


def main() -> None:
    """Analyse the scenes by both methods, and print the table."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--damping", type=float, default=DEFAULTS.damping)
    options.add_argument(
        "--steps", type=int, default=DEFAULTS.patience, help="steps that a load waits for rest"
    )
    options.add_argument("--first", type=int, default=910_000, help="first seed of each family")
    options.add_argument("--far", type=float, default=DEFAULTS.far, help="displacement that is a collapse")
    options.add_argument("--scene", nargs=2, metavar=("FAMILY", "SEED"), help="a single random scene")
    options.add_argument("--cases", nargs="+", help="case files to analyse instead of random scenes")
    options.add_argument("--processes", type=int, default=2)
    chosen = options.parse_args()
    settings = replace(DEFAULTS, damping=chosen.damping, patience=chosen.steps, far=chosen.far)
    print("family,seed,joints,jumps,exact,carried,not carried,incremental,dynamics", flush=True)
    if chosen.cases:
        asked_for = cases(chosen.cases)
    elif chosen.scene:
        asked_for = single_scene(*chosen.scene)
    else:
        asked_for = random_scenes(chosen.first)
    scenes = sorted(asked_for, key=lambda scene: scene.problem.joints)
    asked = [(scene.family, scene.seed, scene.result.load_factor) for scene in scenes]
    with ProcessPoolExecutor(chosen.processes) as pool:
        falls = pool.map(partial(fall, settings=settings), asked)
        for (family, seed, problem, result), load_factor in zip(scenes, falls, strict=True):
            values = (result.carried, result.not_carried, result.load_factor, load_factor)
            numbers = ",".join(f"{value:.5f}" for value in values)
            is_exact = result.state is not None
            print(f"{family},{seed},{problem.joints},{result.history.jumps},{is_exact},{numbers}", flush=True)


if __name__ == "__main__":
    main()

"""Compare the load that brings a scene down in contact dynamics with the path of its push.

    python benchmarks/dynamics.py --damping 0.98

The scenes are 60 random ones whose path folds and 20 whose path does not (tests/atlas; seeds from 910000 on,
the first of each family). The compiled program tests/contact_dynamics.py pushes each by a growing load, one
scene in each process. The script prints a row for each scene: joints, λ at the ray, highest λ of the path,
the deepest fall before it, λ from which the path first falls by a tenth, and λ at which the load brings the
scene down.
"""

import argparse
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.held_scenes import held  # noqa: E402
from atlas.large_scenes import large_scene  # noqa: E402
from atlas.random_scenes import random_scene  # noqa: E402
from contact_dynamics import DEFAULTS, DynamicsSettings, collapse_load  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.errors import CaseError  # noqa: E402
from masonry_opt.methods.push.push import Elastic, Pushed  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402

#: By family, scenes that fold and that do not.
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
#: λ on the way over the ray's, and a fall on the way over the highest λ before, of a path that folds; a fall
#: that is deep; and the highest λ before, over that of the path, below which none is one.
HIGHER, FALL, DEEP, TRIFLE = 0.01, 0.02, 0.1, 0.01
#: Highest load factor of contact dynamics, over the highest of the path.
UP_TO = 1.3


def scene_of(family: str, seed: int) -> mo.Scene:
    """A random scene."""
    kind, _, of = family.partition(" ")
    if kind == "held":
        return held(of, seed)
    return large_scene(kind, int(of), seed) if of else random_scene(kind, seed)


def on_the_way(found: Pushed) -> tuple[float, float, float]:
    """Highest λ of a path, the deepest fall before it, and λ from which it first falls by a tenth."""
    path = np.array([0.0, *(step.load_factor for step in found.steps)])
    highest = np.maximum.accumulate(path)
    fallen = np.where(highest > TRIFLE * highest[-1], (highest - path) / np.maximum(highest, 1e-9), 0.0)
    deep = highest[np.argmax(fallen > DEEP)] if fallen.max() > DEEP else highest[-1]
    return found.peak or 0.0, float(fallen[: path.argmax() + 1].max()), float(deep)


def scenes() -> Iterator[tuple[str, int, Elastic, Pushed]]:
    """Yield the family, seed, elastic contacts and push of each scene."""
    for family, numbers in FAMILIES.items():
        left = list(numbers)
        for seed in count(FIRST):
            try:
                elastic = Elastic(assemble(scene_of(family, seed)).problem)
            except CaseError:
                continue
            found = elastic.pushed()
            if found.answer is None:
                continue
            (highest, fall, _), ray = on_the_way(found), found.answer.load_factor
            folds = highest > ray + HIGHER * abs(ray) or fall > FALL
            if highest > 1e-3 and left[not folds]:
                left[not folds] -= 1
                yield family, seed, elastic, found
            if not any(left):
                break


def fall(of: tuple[str, int, float], settings: DynamicsSettings) -> float:
    """Return the load factor under which the scene of a family and a seed falls; NaN if dynamics do not tell.

    The third value is the highest load factor on the path.
    """
    family, seed, highest = of
    try:
        return collapse_load(scene_of(family, seed), UP_TO * highest, settings)
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
    print("family,seed,joints,ray,highest,fall,deep,onset", flush=True)
    of_all = sorted(scenes(), key=lambda of: of[2].problem.joints)
    paths = [on_the_way(found) for *_, found in of_all]
    asked = [(family, seed, path[0]) for (family, seed, *_), path in zip(of_all, paths, strict=True)]
    with ProcessPoolExecutor(chosen.processes) as pool:
        falls = pool.map(partial(fall, settings=settings), asked)
        for (family, seed, elastic, found), path, load_factor in zip(of_all, paths, falls, strict=True):
            numbers = ",".join(f"{number:.5f}" for number in (found.answer.load_factor, *path, load_factor))
            print(f"{family},{seed},{elastic.problem.joints},{numbers}", flush=True)


if __name__ == "__main__":
    main()

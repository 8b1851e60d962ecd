"""Measure how often, and by how much, a search finds a state below the default's lowest load factor.

    python benchmarks/lowest.py plane --scenes 200 --first 1210000 --search 3 --orders 2 --out plane.csv
    python benchmarks/lowest.py space ties --scenes 60 --first 1230000 --without-starts --out space.csv

Each scene is a row of the CSV file, written as soon as the scene is solved. The command continues an
interrupted file: existing rows are not computed again. The table at the end compares the default with the
least load factor in the columns ``default``, ``search``, ``orders`` and ``without``. The option
``--against OTHER.csv`` also uses the load factors of another file, for example of an earlier version. With
``--without-starts``, the default without further starts in space is also compared with the least.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.held_scenes import held  # noqa: E402
from atlas.random_scenes import KINDS, random_scene  # noqa: E402
from atlas.random_scenes_in_space import KINDS as KINDS_IN_SPACE  # noqa: E402
from atlas.random_scenes_in_space import random_scene_in_space  # noqa: E402
from csv_rows import append_rows, read_rows, rows_to_continue  # noqa: E402
from mappings import mapped, mirrored  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.solution.reasons import Code  # noqa: E402

#: Least and largest number of joints of a scene in the plane.
JOINTS = (8, 25)
#: Largest number of contacts of a scene in space. On larger scenes a search of some seconds finds few states.
MOST_CONTACTS = 200
#: The default counts as above the least known load factor if the relative difference exceeds this value.
HIGHER = 1e-4
#: The flow rule lowers λ if the least known load factor is below the associative one by this relative value.
MATTERS = 1e-3
#: Load factors at or below this value belong to scenes that are about to collapse under their own weight.
NO_LOAD = 1e-6
COLUMNS = (
    *("family", "kind", "seed", "joints", "status", "default", "starts", "incremental", "associative"),
    *("seconds", "search", "orders", "proven", "without", "seconds_without"),
)
#: Settings of the default without further starts in space.
WITHOUT_STARTS = mo.SearchSettings(starts_in_space=0, steps_in_space=())


def scenes(family: str, first: int, count: int) -> Iterator[tuple[str, int, mo.Scene]]:
    """Yield the kind, the seed and the scene of ``count`` random scenes of a family."""
    seed, yielded = first, 0
    while yielded < count:
        kinds = list(KINDS if family == "plane" else KINDS_IN_SPACE)
        kind = kinds[seed % len(kinds)]
        if family == "plane":
            scene = random_scene(kind, seed)
            counts = JOINTS[0] <= mo.assemble(scene).problem.joints <= JOINTS[1]
        else:
            scene = held(kind, seed, space=True) if family == "ties" else random_scene_in_space(kind, seed)
            counts = mo.assemble(scene).problem.joints <= MOST_CONTACTS
        if counts:
            yielded += 1
            yield kind, seed, scene
        seed += 1


def lowest_of(scene: mo.Scene, method: str = "coulomb", **options: Any) -> float | None:
    """Return the load factor of a method, or None if the method has no load factor."""
    try:
        return mo.solve(scene, method, **options).load_factor
    except mo.MasonryError:
        return None


def least(load_factors: Iterator[float | None]) -> float | None:
    """Return the least of the load factors that are not None."""
    return min((one for one in load_factors if one is not None), default=None)


def measured(family: str, kind: str, seed: int, scene: mo.Scene, asked: argparse.Namespace) -> dict[str, Any]:
    """Solve a scene by the default, and by the searches that were asked for, and return its row."""
    row: dict[str, Any] = {"family": family, "kind": kind, "seed": seed}
    began = time.process_time()
    try:
        result = mo.solve(scene)
    except mo.MasonryError as error:
        return row | {"status": type(error).__name__}
    row["seconds"] = round(time.process_time() - began, 3)
    starts = [reason.values for reason in result.reasons if reason.code is Code.STATES_MET]
    row |= {"joints": result.assembly.problem.joints, "status": str(result.status)}
    row |= {"default": result.load_factor, "starts": starts[0]["candidates"] if starts else 0}
    row |= {"incremental": result.incremental, "associative": result.associative}
    row["proven"] = result.proof is not None
    if result.load_factor is None:
        return row
    if asked.search:
        row["search"] = lowest_of(scene, "coulomb", search=float(asked.search))
    if asked.without_starts:
        began = time.process_time()
        row["without"] = lowest_of(scene, "coulomb", settings=WITHOUT_STARTS)
        row["seconds_without"] = round(time.process_time() - began, 3)
    if asked.orders and family == "plane":
        rng = np.random.default_rng(seed)
        orders = [rng.permutation(len(scene.blocks)) for _ in range(asked.orders)]
        others = [mapped(scene, mirrored, mirrored), *(mapped(scene, order=order) for order in orders)]
        row["orders"] = least(lowest_of(other) for other in others)
    return row


def summed_up(rows: list[dict[str, str]], against: list[dict[str, str]]) -> None:
    """Print, for each family, how often and by how much the default is above the least load factor known."""
    keys = ("family", "kind", "seed")
    known: dict[tuple[str, ...], list[float]] = {}
    for row in (*rows, *against):
        found = known.setdefault(tuple(row[key] for key in keys), [])
        # The file ``--against`` may be of an earlier version, which had fewer columns.
        load_factors = (row.get(name) for name in ("default", "search", "orders", "without"))
        found += [float(load_factor) for load_factor in load_factors if load_factor]
    for family in dict.fromkeys(row["family"] for row in rows):
        of_family = [row for row in rows if row["family"] == family and row["default"]]
        least_of = {id(row): min(known[tuple(row[key] for key in keys)]) for row in of_family}
        loaded = [row for row in of_family if least_of[id(row)] > NO_LOAD]
        lowers = [
            row
            for row in loaded
            if row["associative"] and least_of[id(row)] < float(row["associative"]) * (1 - MATTERS)
        ]
        proven = sum(row["proven"] == "True" for row in lowers)
        print(f"{family}: {len(loaded)} scenes with λ > 0; the flow rule lowers λ by more than {MATTERS:g}")
        print(f"  on {len(lowers)}, and the default proves {proven} of these load factors")
        for column, clock in (("default", "seconds"), ("without", "seconds_without")):
            both = [row for row in loaded if row[column]]
            over = [
                (float(row[column]) / least_of[id(row)] - 1, f"{row['kind']} {row['seed']}") for row in both
            ]
            high = sorted((one for one in over if one[0] > HIGHER), reverse=True)
            if not both:
                continue
            seconds = [float(row[clock]) for row in both]
            print(f"  {column} above the least known by more than {HIGHER:g}: {len(high)} of {len(both)}")
            print("  " + ", ".join(f"{name}: {100 * share:.2g} %" for share, name in high))
            print(f"  processor seconds: median {np.median(seconds):.2f}, sum {sum(seconds):.1f}")


def main() -> None:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("families", nargs="+", choices=("plane", "space", "ties"))
    parser.add_argument("--scenes", type=int, default=60, help="how many scenes of each family")
    parser.add_argument("--first", type=int, default=1_210_000, help="first seed")
    parser.add_argument("--search", type=float, default=10, help="seconds of each search; 0 for none")
    parser.add_argument("--orders", type=int, default=0, help="further orders of the blocks, in the plane")
    parser.add_argument("--without-starts", action="store_true", help="also no further starts in space")
    parser.add_argument("--out", type=Path, default=Path("lowest.csv"), help="the CSV file")
    parser.add_argument("--against", type=Path, help="a CSV file of the same scenes")
    asked = parser.parse_args()
    done = {(row["family"], row["kind"], int(row["seed"])) for row in rows_to_continue(asked.out, COLUMNS)}
    rows = (
        measured(family, kind, seed, scene, asked)
        for family in asked.families
        for kind, seed, scene in scenes(family, asked.first, asked.scenes)
        if (family, kind, seed) not in done
    )
    append_rows(asked.out, COLUMNS, rows)
    summed_up(read_rows(asked.out), read_rows(asked.against) if asked.against else [])


if __name__ == "__main__":
    main()

"""Count the small scenes whose least load factor is proven, and measure the processor time of the proofs.

    python benchmarks/proofs.py random --each 15 --first 1821000 --programs 100000 --out proofs.csv
    python benchmarks/proofs.py bonds --programs 400000 --out bonds.csv
    python benchmarks/proofs.py arches --first 7800000 --each 12 --programs 13500 --out arches.csv
    python benchmarks/proofs.py bonds --bounds 20

Each scene is a row of the CSV file, written as soon as the scene is solved. Every proof is checked in exact
arithmetic. For each range of joints, the table at the end contains the share of scenes that are proven within
some seconds of processor time. A second table counts the scenes that are proven by some numbers of linear
programs; a proof that would need more than --programs linear programs is not counted. Below the tables are
the scenes on which the default's lowest load factor is above the least load factor.

With --set NAME=VALUE, a setting of the proof has another value. With most_products=0, all proofs are by
conflicts, without relaxations by products. With --bounds, the script instead prints the lower bounds by
method "global" within some seconds.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.random_scenes import KINDS, arch, random_scene  # noqa: E402
from atlas.small_scenes import bonded  # noqa: E402
from csv_rows import append_rows, read_rows, rows_to_continue  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.methods.bounds.least import prove_least  # noqa: E402
from masonry_opt.methods.bounds.settings import SETTINGS, ProofSettings  # noqa: E402
from masonry_opt.methods.task import Task  # noqa: E402
from masonry_opt.solution.answer import Answer  # noqa: E402

#: Ranges of the number of joints, including both ends.
RANGES = ((8, 13), (14, 20), (21, 25), (26, 30))
#: Stretchers in each course and number of courses of the running bonds, on which the method was first tried.
BONDS = ((1, 4), (1, 6), (1, 8), (2, 3), (2, 4), (3, 3), (2, 5), (2, 6), (3, 4), (3, 5))
BOND_FRICTION = 0.65
#: Time limit of each search, in seconds. The limit of linear programs always ends the search earlier.
LONG = 1e5
#: Seconds of processor time of the columns of the table.
WITHIN = (0.2, 1, 5, 20, 60, 300)
#: Ranges of the number of joints in the table of budgets.
BUDGET_RANGES = ((8, 15), (16, 25), (26, 60))
#: Numbers of linear programs in the table of budgets.
BUDGETS = (1500, 4500, 13_500)
#: Smallest and largest number of voussoirs of the arches.
VOUSSOIRS = (16, 38)
#: Setting of a default that tries no proof.
NO_PROOF = mo.ProofBudget(most_joints=0)
#: The default counts as above the least load factor if the relative difference exceeds this value.
HIGHER = 1e-3
#: Name of the step of the default that tries a proof.
PROOF_STEP = "proof of the least"
#: Load factors at or below this value belong to scenes that are about to collapse under their own weight.
NO_LOAD = 1e-6
COLUMNS = (
    *("name", "joints", "associative", "before", "default", "default_proven", "default_seconds"),
    *("proof_seconds", "least", "proven", "why", "seconds", "programs"),
    *("conflicts", "products", "checked", "check_seconds", "cpu_seconds", "cpu_without_proof"),
)


def running_bond(width: int, height: int) -> mo.Scene:
    """Return a running bond of ``height`` courses, each as long as ``width`` stretchers."""
    full, half = [1.0] * width, [0.5, *[1.0] * (width - 1), 0.5]
    courses = [half if course % 2 == 0 else full for course in range(height)]
    return bonded(courses, (4.0, 1.75), BOND_FRICTION)(None)


def bonds(_: argparse.Namespace) -> Iterator[tuple[str, mo.Scene]]:
    """Yield the names and the scenes of the running bonds."""
    for width, height in BONDS:
        yield f"bond {width}x{height}", running_bond(width, height)


def random_scenes(asked: argparse.Namespace) -> Iterator[tuple[str, mo.Scene]]:
    """Yield names and scenes from the first seed on, until each range of joints has ``asked.each`` scenes."""
    missing = dict.fromkeys(RANGES, asked.each)
    kinds = list(KINDS)
    seed = asked.first
    while any(missing.values()):
        kind = kinds[seed % len(kinds)]
        scene = random_scene(kind, seed)
        try:
            joints = mo.assemble(scene).problem.joints
        except mo.CaseError:
            joints = 0
        for limits in RANGES:
            if limits[0] <= joints <= limits[1] and missing[limits]:
                missing[limits] -= 1
                yield f"{kind} {seed}", scene
        seed += 1


def arches(asked: argparse.Namespace) -> Iterator[tuple[str, mo.Scene]]:
    """Yield the names and the scenes of ``asked.each`` random arches of many voussoirs."""
    for seed in range(asked.first, asked.first + asked.each):
        yield f"arch {seed}", arch(np.random.default_rng(seed), *VOUSSOIRS)


FAMILIES = {"random": random_scenes, "bonds": bonds, "arches": arches}


def timed(scene: mo.Scene, **options: Any) -> tuple[mo.Result, float]:
    """Solve a scene by the default, and return the result and the processor time."""
    began = time.process_time()
    result = mo.solve(scene, **options)
    return result, round(time.process_time() - began, 3)


def with_values(settings: ProofSettings, entries: list[str]) -> ProofSettings:
    """Return settings in which each entry NAME=VALUE replaces the value of a field."""
    for entry in entries:
        name, _, value = entry.partition("=")
        kind = type(getattr(settings, name))
        settings = replace(settings, **{name: kind(value)})
    return settings


def measured(name: str, scene: mo.Scene, settings: ProofSettings) -> dict[str, Any]:
    """Return the row of a scene. The number of programs of the settings ends the search, on any machine."""
    problem = mo.assemble(scene).problem
    row: dict[str, Any] = {"name": name, "joints": problem.joints}
    try:
        result, row["cpu_seconds"] = timed(scene)
    except mo.MasonryError as error:
        return row | {"why": type(error).__name__}
    row["cpu_without_proof"] = timed(scene, budget=NO_PROOF)[1]
    answer = result.solution.answer
    if answer is None or not answer.exact or answer.load_factor <= NO_LOAD:
        return row | {"why": str(result.status)}
    row |= {"associative": result.associative, "default": answer.load_factor}
    return row | _proof_by_default(result) | proof_columns(scene, answer, settings)


def proof_columns(scene: mo.Scene, answer: Answer, settings: ProofSettings) -> dict[str, Any]:
    """Return the columns of a proof that starts from an exact state of a scene; times are processor times."""
    began = time.process_time()
    found = prove_least(Task(mo.assemble(scene).problem), answer, LONG, settings=settings)
    row = {"seconds": round(time.process_time() - began, 3), "programs": found.programs}
    row |= {"proven": found.proof is not None, "why": found.why}
    if found.best is not None:
        row["least"] = found.best.load_factor
    if found.proof is not None:
        began = time.process_time()
        check = mo.check_proof(scene, found.proof)
        row |= {"conflicts": len(found.proof.conflicts), "products": found.proof.product_count}
        row |= {"checked": check.holds}
        row["check_seconds"] = round(time.process_time() - began, 3)
    return row


def _proof_by_default(result: mo.Result) -> dict[str, Any]:
    """Return the columns of the proof that the default itself tries; times are wall-clock times."""
    log = {entry.step: (number, entry) for number, entry in enumerate(result.solution.log)}
    seconds = sum(entry.seconds for entry in result.solution.log)
    row: dict[str, Any] = {"default_proven": result.proof is not None, "proof_seconds": 0.0}
    row["default_seconds"] = round(seconds, 3)
    if PROOF_STEP in log:
        number, entry = log[PROOF_STEP]
        row |= {"proof_seconds": round(entry.seconds, 3)}
        row |= {"before": result.solution.log[number - 1].load_factor}
    return row


def summed_up(rows: list[dict[str, str]]) -> None:
    """Print the share of scenes that are proven within some seconds, for each range of joints."""
    solved = [row for row in rows if row["default"]]
    shares = "".join(f"≤ {seconds:<6g}" for seconds in WITHIN)
    print(f"joints     scenes  {shares} median s   wrong   by default")
    for low, high in (*RANGES, (31, 99)):
        own = [row for row in solved if low <= int(row["joints"]) <= high]
        if not own:
            continue
        proven = np.array([float(row["seconds"]) for row in own if row["proven"] == "True"])
        shares = "".join(f"{(proven <= seconds).sum() / len(own):<8.0%}" for seconds in WITHIN)
        wrong = sum(row["checked"] == "False" for row in own)
        median = f"{np.median(proven):.2f}" if len(proven) else "-"
        print(f"{low}–{high:<8} {len(own):<7} {shares} {median:<10} {wrong:<7} {_slower(own)}")
    budgets(solved)
    for row in solved:
        for name in ("before", "default"):
            if row[name] and float(row[name]) > float(row["least"]) * (1 + HIGHER):
                print(f"  {row['name']}: {name} {row[name]}, least {row['least']} ({row['joints']} joints)")
    for row in solved:
        if row["proven"] != "True":
            print(f"  {row['name']}: {row['joints']} joints, not proven: {row['why']}")


def budgets(rows: list[dict[str, str]]) -> None:
    """Print how many scenes are proven by some numbers of linear programs, and the time of the default."""
    words = [f"{most:,}" for most in BUDGETS]
    print(f"joints     scenes  programs: {', '.join(words)}   default, time over that without proof")
    for low, high in BUDGET_RANGES:
        own = [row for row in rows if low <= int(row["joints"]) <= high]
        if not own:
            continue
        needed = np.array([float(row["programs"]) if row["proven"] == "True" else np.inf for row in own])
        with_proof, without = (
            np.array([float(row[name]) for row in own]) for name in ("cpu_seconds", "cpu_without_proof")
        )
        proven = [int((needed <= most).sum()) for most in BUDGETS]
        ratios = with_proof / without
        ratio_text = f"median {np.median(ratios):.2f}, most {ratios.max():.2f}"
        print(f"{low}–{high:<8} {len(own):<7} {', '.join(map(str, proven)):<20} {ratio_text}")


def _slower(rows: list[dict[str, str]]) -> str:
    """Return the share of scenes that the default proves, and the median extra time of its proof."""
    proven = np.mean([row["default_proven"] == "True" for row in rows])
    own = np.array([[float(row["proof_seconds"]), float(row["default_seconds"])] for row in rows])
    slower = np.median(own[:, 0] / np.maximum(own[:, 1] - own[:, 0], 1e-3))
    return f"{proven:.0%} proven, {slower:+.0%} time"


def print_bounds(named: Iterator[tuple[str, mo.Scene]], seconds: float) -> None:
    """Print the bound of each scene by method "global", and the sum of rates that the bound assumes."""
    print("| scene | joints | λ | bound | assumes Σ rates | time (s) |")
    print("|---" * 6 + "|")
    for name, scene in named:
        result, spent = timed(scene, method="global", time_limit=seconds)
        rates = next((r.values["rates"] for r in result.reasons if "rates" in r.values), None)
        assumed = f"≤ {rates:.4g}" if rates else "nothing"
        load_factor = "–" if result.load_factor is None else f"{result.load_factor:.6f}"
        bound = "–" if result.bound is None else f"{result.bound:.7f}"
        cells = (name, result.size.joints, load_factor, bound, assumed, f"{spent:.1f}")
        print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def parser_of(description: str | None) -> argparse.ArgumentParser:
    """Return a parser of the arguments that select scenes, limit their proofs and name the CSV file."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=description, formatter_class=raw)
    parser.add_argument("families", nargs="+", choices=list(FAMILIES))
    parser.add_argument("--each", type=int, default=20, help="random scenes of each range of joints")
    parser.add_argument("--first", type=int, default=1_820_000, help="first seed")
    parser.add_argument("--programs", type=int, default=100_000, help="linear programs of each search")
    parser.add_argument("--out", type=Path, default=Path("proofs.csv"), help="the CSV file")
    return parser


def main() -> None:
    parser = parser_of(__doc__)
    help_of_set = "set a field of ProofSettings, for example most_products=0 (may be repeated)"
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=help_of_set)
    parser.add_argument("--bounds", type=float, metavar="SECONDS", help="only bounds by method 'global'")
    asked = parser.parse_args()
    if asked.bounds:
        for family in asked.families:
            print_bounds(FAMILIES[family](asked), asked.bounds)
        return
    settings = with_values(replace(SETTINGS, most_programs=asked.programs), asked.set)
    done = {row["name"] for row in rows_to_continue(asked.out, COLUMNS)}
    rows = (
        measured(name, scene, settings)
        for family in asked.families
        for name, scene in FAMILIES[family](asked)
        if name not in done
    )
    append_rows(asked.out, COLUMNS, rows)
    summed_up(read_rows(asked.out))


if __name__ == "__main__":
    main()

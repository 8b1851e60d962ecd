"""Measure what each setting of the proofs by products is worth, on scenes not used to choose it.

    python benchmarks/proof_settings.py random --each 6 --first 8700000 --programs 25000 --out settings.csv
    python benchmarks/proof_settings.py bonds --programs 100000 --out settings.csv

The least load factor of each scene is proven with the default settings, and again with one setting made
smaller or larger, or switched off. All proofs start from the default's lowest state. Scenes with at most 13
joints are left out, because they are proven before the first relaxation.

Each proof is a row of the CSV file. The table at the end has a row for each setting: the numbers of scenes
that are proven within some seconds of processor time, the total time, and how many scenes are proven with one
of the two values only. An unsuccessful proof counts with the time until its end.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "benchmarks"))

from csv_rows import append_rows, read_rows, rows_to_continue  # noqa: E402
from proofs import FAMILIES, NO_LOAD, parser_of, proof_columns  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.methods.bounds.settings import SETTINGS  # noqa: E402

#: Each changed setting and its other values. With ``worth_repeating`` 1 no relaxation is repeated, because it
#: would have to close more than the whole gap.
CHANGES: dict[str, tuple[float, ...]] = {
    "first_products": (500, 8000),
    "products_growth": (2.0, 25.0),
    "most_products": (0, 4000, 36_000),
    "worth_repeating": (0.15, 1.0),
    "least_share": (0.0, 0.8),
}
UNCHANGED = "default"
#: Scenes with fewer joints are proven before the first relaxation.
LEAST_JOINTS = 14
#: Seconds of processor time of the columns of the table.
WITHIN = (1, 5, 20, 60)
COLUMNS = (
    *("name", "joints", "setting", "least", "proven", "why", "seconds", "programs"),
    *("conflicts", "products", "checked", "check_seconds"),
)


def settings_to_compare(programs: int) -> Iterator[tuple[str, Any]]:
    """Yield the name and the settings of each proof of a scene, which all end after ``programs`` programs."""
    settings = replace(SETTINGS, most_programs=programs)
    yield UNCHANGED, settings
    for name, values in CHANGES.items():
        for value in values:
            yield f"{name} {value:g}", replace(settings, **{name: value})


def rows_of(name: str, scene: mo.Scene, programs: int) -> Iterator[dict[str, Any]]:
    """Yield the row of each proof of a scene; none if the default finds no exact state."""
    joints = mo.assemble(scene).problem.joints
    if joints < LEAST_JOINTS:
        return
    try:
        answer = mo.solve(scene).solution.answer
    except mo.MasonryError:
        return
    if answer is None or not answer.exact or answer.load_factor <= NO_LOAD:
        return
    for setting, settings in settings_to_compare(programs):
        columns = proof_columns(scene, answer, settings)
        yield {"name": name, "joints": joints, "setting": setting} | columns


def summed_up(rows: list[dict[str, str]]) -> None:
    """Print the table of all settings."""
    by_setting: dict[str, dict[str, dict[str, str]]] = {}
    for row in rows:
        by_setting.setdefault(row["setting"], {})[row["name"]] = row
    default = by_setting[UNCHANGED]
    print("| setting | scenes |" + "".join(f" ≤ {seconds} s |" for seconds in WITHIN), end="")
    print(" proven | lost | gained | time (s) | median time × | wrong |")
    print("|---" * (len(WITHIN) + 8) + "|")
    for setting, own in by_setting.items():
        proven = {name for name, row in own.items() if row["proven"] == "True"}
        seconds = {name: float(row["seconds"]) for name, row in own.items()}
        before = {name for name in own if default[name]["proven"] == "True"}
        ratios = [seconds[name] / float(default[name]["seconds"]) for name in own]
        wrong = sum(row["checked"] == "False" for row in own.values())
        cells = [setting, len(own), *(sum(seconds[name] <= most for name in proven) for most in WITHIN)]
        cells += [len(proven), len(before - proven), len(proven - before)]
        cells += [f"{sum(seconds.values()):.0f}", f"{np.median(ratios):.2f}", wrong]
        print("| " + " | ".join(map(str, cells)) + " |")


def main() -> None:
    parser = parser_of(__doc__)
    parser.set_defaults(each=6, first=8_700_000, programs=25_000, out=Path("proof_settings.csv"))
    asked = parser.parse_args()
    done = {row["name"] for row in rows_to_continue(asked.out, COLUMNS)}
    rows = (
        row
        for family in asked.families
        for name, scene in FAMILIES[family](asked)
        if name not in done
        # All rows of a scene are written together, so that an interrupted scene is measured again.
        for row in list(rows_of(name, scene, asked.programs))
    )
    append_rows(asked.out, COLUMNS, rows)
    summed_up(read_rows(asked.out))


if __name__ == "__main__":
    main()

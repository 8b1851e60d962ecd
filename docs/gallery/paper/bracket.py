"""
Beyond the paper: the least load factor of the six walls, from above and below
==============================================================================

The upper limit is the lowest exact state that a search finds in 10 s. The lower limit is the bound that
method ``global`` certifies within 300 s. The bound is valid for all states whose slips and edge openings sum
to at most the number in the table. The example takes a quarter of an hour on two cores.

The guide does not run this example. ``masonry-opt reproduce bracket`` saves its tables and pictures.
"""

# sphinx_gallery_thumbnail_path = "bracket.png"

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder
from masonry_opt.studies.runner import Workers

SECONDS = 300.0
WALLS = {n: mo.load(case_folder() / "ferris_tinloi" / f"wall_{n}.toml") for n in range(1, 7)}
RUNS = {
    "search": {"search": 10.0},
    "global": {"method": "global", "time_limit": SECONDS},
}

parts = [(wall, run) for wall in WALLS for run in RUNS]
solves = [partial(mo.solve, WALLS[wall], **RUNS[run]) for wall, run in parts]
with Workers() as workers:
    results = {part: end.result for part, end in workers.map(zip(parts, solves, strict=True))}

# %%
# The table lists the lowest load factor found and the bound of each wall. Rates (slips and edge openings) are
# divided by the mean velocity of the live load.
rows, steps = [], []
for wall in WALLS:
    search, ends = results[wall, "search"], results[wall, "global"]
    lowest = min(search.required(), ends.required())
    rows.append(
        {
            "wall": wall,
            "joints": ends.size.joints,
            "lowest λ found": lowest,
            "bound": ends.bound,
            "bound / λ": ends.bound / lowest,
            "assumes Σ rates ≤": ends.reasons[0].values.get("rates"),
            "associative λ": ends.associative,
        }
    )
    found = search.history.assign(wall=wall, end="λ", value=search.history["load_factor"])
    bounds = ends.history.assign(wall=wall, end="bound", value=ends.history["bound"].cummax())
    steps += [of[["wall", "seconds", "end", "value"]] for of in (found, bounds)]
table = pd.DataFrame(rows)
table_steps = pd.concat(steps)
print(table.to_string(index=False))
assert (table["bound"] <= table["lowest λ found"]).all()
assert (table["bound"] >= 0).all()
assert (table["lowest λ found"] < table["associative λ"]).all()
for (_, end), of in table_steps.groupby(["wall", "end"]):
    assert of["value"].is_monotonic_decreasing if end == "λ" else of["value"].is_monotonic_increasing

# %%
# The picture shows the lowest load factor found and the bound of each wall over time:
figure = Figure(figsize=(9, 6), layout="constrained")
ends = {
    "λ": ("lowest exact state found", "#D55E00"),
    "bound": ("lower bound, for states with a limited sum of rates", "#0072B2"),
}
for axes, row in zip(figure.subplots(2, 3, sharex=True).flat, rows, strict=True):
    of_wall = table_steps[table_steps["wall"] == row["wall"]]
    for end, (label, colour) in ends.items():
        of = of_wall[of_wall["end"] == end]
        seconds = [0.05, *of["seconds"].clip(lower=0.05), 1.2 * SECONDS]
        values = [np.nan if end == "λ" else 0, *of["value"], *of["value"].tail(1)]
        axes.step(seconds, values, where="post", color=colour, linewidth=1.8, label=label)
    axes.axhline(row["associative λ"], color="black", linewidth=1, linestyle=":", label="associative λ")
    axes.set(xscale="log", xlim=(0.05, 1.2 * SECONDS), ylim=(0, 1.1 * row["associative λ"]))
    axes.set_title(f"wall {row['wall']}", loc="left", fontsize=10)
    axes.grid(color="#EEEEEE")
figure.supxlabel("time (s)")
figure.supylabel("load factor λ")
figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize=9)
figure

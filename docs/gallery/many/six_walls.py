"""
For which of the six walls is the value of friction important?
==============================================================

Gilbert, Casapulla & Ahmed (2006, Table 1) solve the six walls of Ferris & Tin-Loi (2001) for a friction of
0.65. How much does each load factor change if the friction is 0.5 or 0.8?
"""

from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

FRICTIONS = [0.5, 0.65, 0.8]
WALLS = {n: case_folder() / "ferris_tinloi" / f"wall_{n}.toml" for n in range(1, 7)}

# %%
# These shell commands solve each wall for 31 values of friction::
#
#     for n in 1 2 3 4 5 6; do
#         masonry-opt sweep cases/ferris_tinloi/wall_$n.toml --out results/wall_$n \
#             --vary joints.friction=0.5:0.8:31
#     done
#
# The example solves each wall for three values:
runs = {n: mo.sweep(wall, {"joints.friction": FRICTIONS}, workers=1) for n, wall in WALLS.items()}
for n, table in runs.items():
    low, middle, high = table["load_factor"]
    print(f"wall {n}: λ = {low:.4f}, {middle:.4f}, {high:.4f}; {', '.join(table['mechanism'])}")

# %%
# Walls 3 and 4 rock, and friction does not change their load factor. At a friction of 0.5 walls 1 and 2
# slide, and the load factor of both equals the friction coefficient. At 0.65 they also rock, and at 0.8 wall
# 1 rocks without sliding, so their load factors increase less. Walls 5 and 6 slide and rock at the same time.
#
# On wall 6 the load factors at 0.5 and 0.8 differ by 8 %, on wall 5 by 1 %. The load factor of wall 5 even
# decreases from 0.65 to 0.8: friction also permits more self-stress, with some of which the wall carries
# less.
# The default finds the lowest of a few states, and the option ``search`` finds a lower state at 0.65.
figure = Figure(figsize=(7, 3.8), layout="constrained")
axes = figure.add_subplot(xlabel="load factor λ", xlim=(0, 0.7), ylim=(6.6, 0.4))
axes.set_yticks(list(WALLS), [f"wall {n}" for n in WALLS])
axes.grid(axis="x", color="0.9")
for n, table in runs.items():
    axes.plot(table["load_factor"], [n] * len(FRICTIONS), color="#0072B2", linewidth=7, alpha=0.35)
for friction, marker in zip(FRICTIONS, "<|>", strict=True):
    at_friction = [
        table.loc[table["joints.friction"] == friction, "load_factor"].item() for table in runs.values()
    ]
    axes.plot(at_friction, list(runs), marker, color="black", label=f"friction {friction:g}")
figure.legend(loc="outside lower center", ncols=3)
changes = {n: table["load_factor"].max() / table["load_factor"].min() - 1 for n, table in runs.items()}
assert max(changes[3], changes[4]) < 1e-6
assert abs(changes[6] - 0.08) < 0.005
assert abs(changes[5] - 0.01) < 0.005
assert runs[1].iloc[-1]["mechanism"] == "hinging"
for n in (1, 2):
    first = runs[n].iloc[0]
    assert first["mechanism"] == "sliding"
    assert abs(first["load_factor"] - 0.5) < 1e-6
figure

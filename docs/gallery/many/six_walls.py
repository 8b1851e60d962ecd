"""
For which of the six walls is the value of friction important?
==============================================================

Gilbert, Casapulla & Ahmed (2006, Table 1) solve the six walls of Ferris & Tin-Loi (2001) for a friction of
0.65. If friction has the mean 0.65 and a coefficient of variation of 15 %, how much does each load factor
vary?
"""

from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

FRICTION = {"joints.friction": ("lognormal", 0.65, "15%")}
WALLS = {n: case_folder() / "ferris_tinloi" / f"wall_{n}.toml" for n in range(1, 7)}

# %%
# Each wall is solved ten times, with the same ten values of friction. These shell commands make a thousand
# runs for each wall::
#
#     for n in 1 2 3 4 5 6; do
#         masonry-opt sweep cases/ferris_tinloi/wall_$n.toml --out results/wall_$n \
#             --sample joints.friction=lognormal:0.65:15% -n 1000
#     done
samples = {n: mo.sample(wall, FRICTION, n=10, workers=1) for n, wall in WALLS.items()}
for n, known in samples.items():
    low, median, high = known.quantiles()["value"]
    mechanisms = known.table["mechanism"].value_counts().to_dict()
    print(f"wall {n}: λ = {low:.4f}, {median:.4f}, {high:.4f} (5, 50, 95 %); {mechanisms}")

# %%
# Walls 3 and 4 rock, and friction does not change their load factor. Walls 5 and 6 slide and rock at the
# same time, and 90 % of their load factors are in a range of 2 and 8 % of the median. At low friction walls 1
# and 2 slide, and the load factor of both equals the friction coefficient. At high friction walls 1 and 2
# also rock, and their load factors increase little.
figure = Figure(figsize=(7, 3.8), layout="constrained")
axes = figure.add_subplot(xlabel="load factor λ", xlim=(0, 0.7), ylim=(6.6, 0.4))
axes.set_yticks(list(WALLS), [f"wall {n}" for n in WALLS])
axes.grid(axis="x", color="0.9")
for n, known in samples.items():
    low, median, high = known.quantiles()["value"]
    axes.plot(
        [low, high],
        [n, n],
        color="#0072B2",
        linewidth=7,
        alpha=0.35,
        solid_capstyle="butt",
        label="5 % to 95 %",
    )
    axes.plot(known.load_factors, [n] * known.runs, ".", color="black", markersize=4, label="a run")
    axes.plot(median, n, "|", color="#D55E00", markersize=18, markeredgewidth=2, label="median")
figure.legend(*(found[:3] for found in axes.get_legend_handles_labels()), loc="outside lower center", ncols=3)
for n, share in ((5, 0.02), (6, 0.08)):
    low, median, high = samples[n].quantiles()["value"]
    assert abs((high - low) / median - share) < 0.005
spread = {n: known.load_factors.max() - known.load_factors.min() for n, known in samples.items()}
assert max(spread[3], spread[4]) < 1e-6 < 1e-3 < min(spread[n] for n in (1, 2, 5, 6))
for n in (1, 2):
    slides = samples[n].table.query("mechanism == 'sliding'")
    assert len(slides)
    assert (slides["load_factor"] - slides["joints.friction"]).abs().max() < 1e-6
figure

"""
How much friction does an arch on piers need?
=============================================

The friction of a pointed arch on buttressed piers is not known well: anything between 0.2 and 0.8 has been
measured for such stones. How far does its load factor, the sideways acceleration that brings it down as a
share of gravity, depend on that, and on the joints' not opening as they slide?
"""

from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

CASE = case_folder() / "examples" / "arch_on_piers.toml"
FRICTIONS = [round(0.2 + 0.05 * step, 2) for step in range(13)]

# %%
# One call a method: the joints are found once, the programs are compiled once, and each run is certified
# like any other. A run that fails is a row too, with its status.
columns = ["joints.friction", "load_factor", "status", "mechanism", "slides", "hinges"]
frames = {
    method: mo.sweep(CASE, {"joints.friction": FRICTIONS}, method=method) for method in ("static", "coulomb")
}
print(frames["coulomb"][columns].to_string(index=False, float_format="{:.4f}".format))

# %%
# At 0.2 the arch does not stand. Up to 0.5 friction helps, and beyond that next to nothing, unless sliding is
# taken to open joints (dashed): then every joint that slides lifts what it bears, the more the rougher it
# is, and the load factor seems to rise on and on. (Steps down by up to a hundredth are no effect of friction:
# of the many states of Coulomb friction the lowest of a few is taken, and the option ``search`` finds
# lower ones at 0.55 and 0.65.)
figure = Figure(figsize=(7, 4.2), layout="constrained")
axes = figure.add_subplot()
for method, label, line, colour in (
    ("static", "sliding opens joints (associative)", "--", "#D55E00"),
    ("coulomb", "Coulomb friction", "-", "#0072B2"),
):
    frame = frames[method]
    axes.plot(frame["joints.friction"], frame["load_factor"], line, marker="o", color=colour, label=label)
axes.set(xlabel="friction μ = tan φ", ylabel="load factor λ", xlim=(0.18, 0.82), ylim=(0, None))
axes.legend(loc="lower right", frameon=False)
axes.grid(color="0.9")
both = (
    frames["static"]
    .merge(frames["coulomb"], on="joints.friction", suffixes=("_static", "_coulomb"))
    .dropna(subset=["load_factor_coulomb"])
)
assert (both["load_factor_coulomb"] <= both["load_factor_static"] * (1 + 1e-7)).all()
known = both["load_factor_coulomb"]
assert (known.cummax() / known).max() < 1.01
figure  # noqa: B018

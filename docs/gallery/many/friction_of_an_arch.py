"""
How much friction does an arch on piers need?
=============================================

The friction of a pointed arch on buttressed piers is not well known: values between 0.2 and 0.8 have been
measured for similar stones. The load factor is the horizontal acceleration at collapse, in g. How much does
it depend on friction, and on the assumption that sliding joints open?
"""

from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

CASE = case_folder() / "examples" / "arch_on_piers.toml"
FRICTIONS = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]

# %%
# The example calls ``mo.sweep`` once for each method. A sweep detects the joints and compiles the programs
# once, and certifies every run. A run without a load factor is also a row of the table, with its status.
columns = ["joints.friction", "load_factor", "status", "mechanism", "slides", "hinges"]
frames = {
    method: mo.sweep(CASE, {"joints.friction": FRICTIONS}, method=method) for method in ("static", "coulomb")
}
print(frames["coulomb"][columns].to_string(index=False, float_format="{:.4f}".format))

# %%
# At a friction of 0.2 the arch is unstable. Up to 0.5 the load factor increases with friction, and above 0.5
# it is almost constant. With associative flow (dashed) the load factor keeps increasing, because every
# sliding joint lifts the blocks above it, and the more so the higher the friction.
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
assert known.iloc[-1] / known.iloc[-4] < 1.06 < known.iloc[-4] / known.iloc[-5]
figure

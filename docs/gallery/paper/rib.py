"""
Section 5.2: the arch rib of Pippard & Ashby
============================================

According to the paper, the associative and the Coulomb load factors of the rib coincide for friction above
about 0.11. The paper does not state the geometry of the rib. With the geometry assumed in the case file, both
load factors also coincide below 0.11, down to the friction at which the rib becomes unstable under its own
weight.

The guide does not run this example. ``masonry-opt reproduce rib`` saves its tables and pictures.
"""

import pandas as pd
from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

RIB = mo.load(case_folder() / "pippard_ashby" / "rib.toml")
CLAIMED = RIB.reference["coincide_above"].value
FRICTIONS = (0.066, 0.07, 0.08, 0.09, 0.1, 0.105, 0.11, 0.115, 0.12, 0.14, 0.16, 0.2)
FRICTIONS += (0.25, 0.3, 0.4, 0.6, 0.8)
#: Values of friction for which method ``global`` also looks for a lower Coulomb load factor.
SEARCHED = (0.07, 0.08, 0.1, 0.12)


def rib(friction: float) -> mo.Scene:
    """Return the rib with the given friction in all joints."""
    return RIB.replace(friction=friction)


# %%
# First, the friction below which the rib is unstable under its own weight is computed.
stands = mo.least(rib, 1e-3, 1.0, samples=0)
print(stands)
assert stands.value < CLAIMED
assert mo.solve(rib(stands.value - 1e-4), "static").status is mo.Status.UNSTABLE
assert 0 < mo.solve(rib(stands.value + 1e-4), "static").required() < 0.01

# %%
# The table contains load factors in voussoir weights. The loop agrees with the associative load factor to the
# tolerance of the loop, and exact states agree to the tolerance of the solver.
rows = []
for mu in FRICTIONS:
    scene = rib(mu)
    found = mo.solve(scene, "global", time_limit=5, incremental=False) if mu in SEARCHED else None
    rows.append(
        {
            "μ": mu,
            "associative": mo.solve(scene, "static").required(),
            "loop": mo.solve(scene, "nonassociative", incremental=False, always=True).required(),
            "coulomb": mo.solve(scene, search=0.5, incremental=False).required(),
            "global": found.required() if found else None,
        }
    )
table = pd.DataFrame(rows)
print(table.to_string(index=False))
apart = table[["loop", "coulomb", "global"]].div(table["associative"], axis=0).sub(1).abs().max()
print(f"largest relative difference from the associative load factor:\n{apart.to_string()}")
assert apart["loop"] < 2e-5
assert apart["coulomb"] < 1e-7
assert apart["global"] < 1e-4

# %%
# The picture shows all load factors over friction:
figure = Figure(figsize=(7, 4.2), layout="constrained")
axes = figure.add_subplot(xlabel="friction μ = tan φ", ylabel="load factor λ (voussoir weights)")
axes.plot(table["μ"], table["associative"], color="#0072B2", label="associative")
axes.plot(table["μ"], table["loop"], "o", color="#D55E00", fillstyle="none", label="loop")
axes.plot(table["μ"], table["coulomb"], "x", color="black", markersize=5, label="exact Coulomb")
axes.axvline(CLAIMED, color="#777777", linestyle="--", label=f"μ = {CLAIMED:g}: equal above, as published")
axes.axvspan(0, stands.value, color="#DDDDDD", zorder=0, label="unstable under dead load")
axes.set(xlim=(0, 0.82), ylim=(0, None))
axes.legend(loc="lower right")
figure

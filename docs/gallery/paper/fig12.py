"""
Fig. 12: potential energy and energy of sliding, wall 6
=======================================================

At each iteration of the paper's loop, the work of the live load raises weights or is dissipated in sliding,
18.2 % at the end (section 5.3). The *actual* energy of sliding is computed with the shear limits of the
sub-problem, and the *corrected* energy with Coulomb's shear limits. In the paper both differ by at most 0.1 %
of the total.
"""

from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

scene = mo.load(case_folder() / "ferris_tinloi" / "wall_6.toml")
result = mo.solve(scene, "nonassociative", preset="paper")
columns = ["iteration", "load_factor", "raising", "sliding", "coulomb_sliding", "seconds"]
table = result.history[columns].rename(columns={"load_factor": "λ", "coulomb_sliding": "corrected"})
table["actual (%)"] = 100 * table["sliding"] / table["λ"]
table["corrected (%)"] = 100 * table["corrected"] / table["λ"]
print(table.to_string(index=False, float_format="{:.5g}".format))

# %%
# λ equals the sum of both energies, to the accuracy of the solver. In the first, associative program sliding
# dissipates no energy. Step 6 of the loop subtracts the energy of its small cohesion from λ, because this
# energy is not friction. Without the energy of the small cohesion, the actual and the corrected energy differ
# by less than 0.1 %, as published.
last = table.iloc[-1]
cohesion = 100 * (1 - result.required() / last["λ"])
print(f"λ = {result.required():.5f}; small cohesion: {cohesion:.3f} % of the energy")
assert abs(result.required() / scene.reference["nonassociative"].value - 1) < 3e-4
assert ((table["raising"] + table["sliding"]) / table["λ"] - 1).abs().max() < 1e-6
assert table["sliding"][0] == 0
for share in ("actual (%)", "corrected (%)"):
    assert abs(last[share] / 18.2 - 1) < 0.01, (share, last[share])
assert abs(last["actual (%)"] - cohesion - last["corrected (%)"]) < 0.1

# %%
# The upper diagram shows both energies, and the lower diagram the share of sliding:
figure = Figure(figsize=(7.5, 6.5), layout="constrained")
total, share = figure.subplots(2, 1, sharex=True, height_ratios=[1.5, 1])
k = table["iteration"]
total.bar(k, table["raising"], color="#56B4E9", label="increase in potential energy")
total.bar(k, table["sliding"], bottom=table["raising"], color="#D55E00", hatch="//", label="sliding friction")
total.set(ylabel="total energy (load factor λ)", ylim=(0, 0.5))
total.legend(loc="upper right", frameon=False, ncols=2)
share.plot(k, table["actual (%)"], "o-", color="#D55E00", label="actual: the sub-problem's own shear limit")
share.plot(k, table["corrected (%)"], "x--", color="black", label="corrected: Coulomb's shear limit")
share.axhline(18.2, color="#777777", linewidth=1, linestyle=":", label="published at the end: 18.2 %")
share.set(ylabel="energy in sliding (%)", xlabel="iteration", xticks=k)
share.legend(fontsize=8)
figure

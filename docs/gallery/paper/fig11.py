"""
Fig. 11: convergence of the loop on wall 6
==========================================

The example shows the load factors of the loop's sub-problems for several starting conditions, α and β
(section 5.3). According to the paper, all answers are equal or very close to 0.29649. The loop takes 85
sub-problems with β = 0.2, and does not converge with β = 1.

The guide does not run this example. ``masonry-opt reproduce fig11`` saves its tables and pictures.
"""

import pandas as pd
from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.drawing.colours import SERIES
from masonry_opt.scene.case_file import case_folder

scene = mo.load(case_folder() / "ferris_tinloi" / "wall_6.toml")
PUBLISHED = scene.reference["nonassociative"].value
#: For each panel and run, the options that differ from the paper's settings; trial cohesions are in block
#: weights. The run with α = 0 throughout also has α_min = 0, so that nothing reduces the normal forces to
#: their least values.
PANELS = {
    "(a) starting conditions": {"associative": {}}
    | {f"trial cohesion {c:g}": {"start": "cohesive", "trial_cohesion": c} for c in (0.5, 1.0, 5.0)},
    "(b) α": {"α = 0 throughout": {"alpha": 0.0, "alpha_min": 0.0}}
    | {f"α = {alpha:g}": {"alpha": alpha} for alpha in (0.0, 0.1, 0.3, 0.6)},
    "(c) β": {f"β = {beta:g}": {"beta": beta} for beta in (0.2, 0.4, 0.6, 0.8, 1.0)},
}
runs = {
    run: mo.solve(scene, "nonassociative", preset="paper", incremental=False, **options)
    for panel in PANELS.values()
    for run, options in panel.items()
}
#: Histories of the runs. If a sub-problem had no state, the loop starts again with smaller slopes of the
#: limits, and only the last attempt is shown.
histories = {run: r.history[r.history["attempt"] == r.history["attempt"].max()] for run, r in runs.items()}

# %%
# The table compares each run with the published load factor.
table = pd.DataFrame(
    {
        "run": run,
        "status": str(result.status),
        "λ": result.load_factor,
        "diff %": 100 * (result.load_factor / PUBLISHED - 1) if result.load_factor else None,
        "sub-problems": len(histories[run]),
        "LPs": result.lp_solves,
        "time (s)": sum(result.seconds.values()),
    }
    for run, result in runs.items()
)
print(table.to_string(index=False))
by_run = table.set_index("run")
assert runs["β = 1"].status is mo.Status.CYCLING
converged = by_run.drop("β = 1")
assert (converged["status"] == "converged").all()
assert converged.drop("α = 0 throughout")["diff %"].abs().max() < 0.1
assert by_run.loc["β = 0.2", "sub-problems"] > 3 * by_run.loc["β = 0.4", "sub-problems"]

# %%
# A dot marks the end of a run that converged, and a cross the end of a run that did not converge. The dotted
# line is the published load factor.
figure = Figure(figsize=(8, 10.5), layout="constrained")
ends = {"(d) the same, λ magnified": {"β = 0.2": {}, "β = 1": {}}}
panels = figure.subplots(len(PANELS) + 1, 1)
for axes, (title, names) in zip(panels, (PANELS | ends).items(), strict=True):
    for run, colour in zip(names, SERIES, strict=False):
        k, load_factor = histories[run]["iteration"], histories[run]["load_factor"]
        usable = runs[run].status.usable
        label = f"{run}: {len(k)} sub-problems" if usable else f"{run}: {runs[run].status}"
        axes.plot(k, load_factor, color=colour, linewidth=1.4, label=label)
        axes.plot(k.iloc[-1], load_factor.iloc[-1], "o" if usable else "X", color=colour)
    axes.axhline(PUBLISHED, color="black", linewidth=1, linestyle=":", zorder=0)
    axes.set(ylabel="load factor λ", xlim=(0, 40), ylim=(0 if "(a)" in title else 0.2, 0.43))
    axes.set_title(title, loc="left", fontsize=10)
    axes.grid(color="#EEEEEE")
    axes.legend(fontsize=8, ncols=2, loc="lower right")
panels[-1].set(xlabel="sub-problem", xlim=(0, None), ylim=(0.286, 0.312))
figure

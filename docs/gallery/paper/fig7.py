"""
Fig. 7: two blocks, forces at each iteration
============================================

The example follows the forces between two blocks during the loop. The shear limits do not contract in panel
(a), with α = 0, and contract in panel (b), with α = 0.3 at first. Without contraction every load factor from
1.5 μ to 2.5 μ is a solution. The loop then ends at a value that depends on the solver (section 4.1: 1.9535 μ,
with MOSEK 2.5). With contraction the loop ends at 1.5 μ.
"""

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

scene = mo.load(case_folder() / "gilbert" / "two_blocks.toml")
MU = scene.joints.friction
MOSEK = 1.9535
PANELS = {"(a) α = 0": {"alpha": 0.0, "alpha_min": 0.0}, "(b) α = 0.3": {}}
SOLVERS = [("cvxpy", "clarabel"), ("cvxpy", "highs-ipm"), ("cvxpy", "highs"), ("pyomo", "highs")]

# %%
# The table lists the load factor at which the loop ends with each solver. The tolerance of 1e-4 allows for
# the small cohesion of the limits, which is 1e-5 of the largest normal force.
ends = {
    (f"{solver} ({model})", panel): mo.solve(
        scene, "nonassociative", model=model, solver=solver, preset="paper", **options
    )
    for model, solver in SOLVERS
    for panel, options in PANELS.items()
}
table = pd.DataFrame(
    {"solver": solver, "panel": panel, "λ/μ": result.required() / MU, "sub-problems": len(result.history)}
    for (solver, panel), result in ends.items()
)
print(table.to_string(index=False))
flat, contracts = (table.loc[table["panel"] == panel, "λ/μ"] for panel in PANELS)
assert 1.5 * (1 - 1e-4) < flat.min() < flat.max() < 2.5 * (1 + 1e-4)
assert np.diff(np.sort(flat.round(4).unique())).min() > 0.05 < flat.max() - flat.min()  # solvers differ
assert (contracts / 1.5 - 1).abs().max() < 1e-3


# %%
# The loop is followed at the joint between A and B: its forces n and s, and the limit c + slope n on s.
def followed(**options: float) -> pd.DataFrame:
    """Return the forces and the shear limit of the joint at each iteration of the loop, by Clarabel."""
    steps = []
    result = mo.solve(
        scene, "nonassociative", preset="paper", incremental=False, progress=steps.append, **options
    )
    problem, joints = result.assembly.problem, result.joints
    (joint,) = np.flatnonzero([{"A", "B"} == set(pair) for pair in joints[["first", "second"]].to_numpy()])
    at = list(problem.sliding).index(joint)
    rows = []
    for step in steps:
        q = problem.force_unit * step.solved.state.q
        n, s = problem.normal_forces(q)[joint], problem.shears(q)[0, joint]
        slope, c = step.solved.limits.slope[at], problem.force_unit * step.solved.limits.cohesion[at]
        rows.append({"λ/μ": step.load_factor / MU, "n": n, "s": abs(s), "slope": slope, "c": c})
    return pd.DataFrame(rows, index=range(1, len(rows) + 1))


paths = {panel: followed(**options) for panel, options in PANELS.items()}
table_steps = pd.concat(paths, names=["panel", "iteration"]).reset_index()
print(table_steps.to_string(index=False, float_format="{:.5f}".format))
assert (table_steps["s"] < table_steps["c"] + table_steps["slope"] * table_steps["n"] + 1e-7).all()
falls = paths["(b) α = 0.3"]["n"]
assert abs(falls.iloc[0] - 0.75) < 1e-6  # by hand, if B rises
assert abs(falls.iloc[-1] - 0.25) < 1e-4  # by hand, if B sinks
# At n of the first iteration the second limit equals Coulomb's limit, except for the small cohesion (1e-5 of
# 1.75).
second = paths["(b) α = 0.3"].iloc[1]
assert abs(second["c"] + second["slope"] * falls.iloc[0] - MU * falls.iloc[0]) < 2e-5
assert abs(second["slope"] + 0.3 * MU) < 1e-9

# %%
# Dots are forces, and lines are the limits of the iteration with the same colour. The first limit is
# Coulomb's.
figure = Figure(figsize=(8, 7.2), layout="constrained")
above, below = figure.subfigures(2, 1, height_ratios=[1.5, 1])
for axes, (panel, path) in zip(above.subplots(1, 2), paths.items(), strict=True):
    n = np.array([0.0, 1.1])
    colours = mpl.colormaps["viridis"](np.linspace(0, 0.92, len(path)))
    for (number, step), colour in zip(path.iterrows(), colours, strict=True):
        axes.plot(n, step["c"] + step["slope"] * n, color=colour, linewidth=1.3)
        label = f"{number}: λ = {step['λ/μ']:.4f} μ"
        axes.plot(step["n"], step["s"], "o", color=colour, markeredgecolor="white", zorder=3, label=label)
    axes.set(xlim=(0, 1.1), ylim=(0, 0.16), title=panel)
    axes.set(xlabel="normal force n (block weights)", ylabel="shear force |s| (block weights)")
    axes.legend(fontsize=8, loc="upper left", ncols=2, title="iteration", frameon=False)
axes = below.subplots()
axes.axvspan(1.5, 2.5, color="#EEEEEE", label="admissible: 1.5 μ to 2.5 μ")
axes.axvline(MOSEK, color="#D55E00", linestyle="--", label=f"published, MOSEK: {MOSEK} μ")
axes.plot(flat, range(len(flat)), "o", color="#0072B2", markersize=8)
axes.set_yticks(range(len(flat)), [f"{model}: {solver}" for model, solver in SOLVERS])
axes.set(xlim=(1.4, 3), ylim=(3.5, -0.5), xlabel="λ / μ where the loop ends", title="(c) α = 0, by solver")
axes.legend(fontsize=8, loc="upper right")
figure

"""
Do the methods agree?
=====================

Three methods solve wall 1 of Ferris & Tin-Loi (2001). The published load factors are 0.64286 (associative),
0.63982 (the loop of linear programs of Gilbert, Casapulla & Ahmed 2006) and 0.63898 (an MPEC).
"""

import pandas as pd

import masonry_opt as mo

bond = mo.Wall(
    block=(4, 1.75),
    weight=1,
    live_per_weight=(1, 0),
    courses=["halves", "whole"],
    repeat=3,
    course={"halves": [0.5, 1, 1, 1, 1, 0.5], "whole": [1, 1, 1, 1, 1]},
)
scene = mo.Scene(
    title="wall 1 of Ferris & Tin-Loi", joints=mo.JointDefaults(friction=0.65), blocks=bond.blocks()
)

# %%
# Method ``static`` is classical limit analysis, and ``nonassociative`` is the loop of the paper. Method
# ``coulomb`` returns the lowest of several exact collapse states.
published = {"static": 0.64286, "nonassociative": 0.63982, "coulomb": 0.63898}
results = {method: mo.solve(scene, method) for method in published}
for method, result in results.items():
    assert abs(result.required() / published[method] - 1) < 3e-4
columns = ["load_factor", "exact", "lp_solves", "iterations"]
pd.DataFrame({name: [getattr(r, name) for r in results.values()] for name in columns}, index=list(results))

# %%
# Many exact Coulomb states of this wall exist. The default method finds the lowest known state:
results["coulomb"].plot()

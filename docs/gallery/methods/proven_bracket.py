"""
Is there a lower load factor?
=============================

A Coulomb scene may have many collapse states, and an analysis finds only some of them. The safety depends on
the least load factor of all states. For small scenes the program can prove that no state is lower.
"""

import masonry_opt as mo

# %%
# The scene is a stack of four courses in running bond, one stone wide:
bond = mo.Wall(block=(4, 1.75), weight=1, live_per_weight=(1, 0), courses=[[0.5, 0.5], [1], [0.5, 0.5], [1]])
scene = mo.Scene(title="four courses", joints=mo.JointDefaults(friction=0.65), blocks=bond.blocks())
result = mo.solve(scene, "global", time_limit=20)
print(result.message)

# %%
# The proof of this scene covers forces and motions up to a million times the loads. On larger scenes, method
# ``global`` may assume that the slips and openings of a mechanism sum to at most a smaller number, which
# ``result.reasons`` contains:
print(f"{result.bound:.6f} ≤ λ ≤ {result.required():.6f}")
assert 0 <= result.required() - result.bound < 1e-5
assert abs(result.required() - 0.479263) < 1e-6
result.plot()

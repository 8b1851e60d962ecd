"""
Which earthquake brings an arch down?
=====================================

An arch of seven voussoirs over 157.5°, of thickness 0.15 of its radius, is shaken sideways. At which
acceleration does it become a mechanism? Oppenheim (1992, *The masonry arch as a four-link mechanism under
base motion*) gives 0.370 g.
"""

import masonry_opt as mo

# %%
# The live load is the weight of each voussoir, sideways: the load factor is the acceleration in g. Joints
# that cannot slide have an infinite friction.
arch = mo.Arch(
    radius=10, angles=(168.75, 11.25), thickness=1.5, voussoirs=7, unit_weight=1, live_per_weight=(1, 0)
)
scene = mo.Scene(
    title="Oppenheim's arch", joints=mo.JointDefaults(friction=float("inf")), blocks=arch.blocks()
)
result = mo.solve(scene)
print(f"acceleration {result.load_factor:.6f} g")
assert abs(result.required() - 0.370) < 5e-4

# %%
# Four hinges, in turns at the intrados and the extrados:
result.plot()

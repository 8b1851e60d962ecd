"""
Which earthquake brings an arch down?
=====================================

An arch has seven voussoirs over 157.5°, and its thickness is 0.15 of its radius. At which horizontal
acceleration does the arch become a mechanism? Oppenheim (1992, *The masonry arch as a four-link mechanism
under base motion*) gives 0.370 g.
"""

import masonry_opt as mo

# %%
# The live load is the weight of each voussoir, applied sideways, so the load factor is the acceleration in g.
# The friction is infinite, so that joints cannot slide.
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
# The mechanism has four hinges, alternately at the intrados and at the extrados:
result.plot()

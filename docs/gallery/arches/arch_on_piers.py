"""
How tall may the piers of an arch be?
=====================================

An arch thrusts its piers apart. An arch that is stable on low piers may collapse on high piers. Which
horizontal acceleration, in g, can an arch withstand on piers of 1 m, 2 m and 3 m?
"""

from itertools import pairwise

import masonry_opt as mo


def arch_on_piers(height: float) -> mo.Scene:
    """Return a semicircular arch of 4 m span and 0.5 m thickness on piers 1 m wide."""
    keys = {"unit_weight": 22, "live_per_weight": (1, 0)}
    arch = mo.Arch(at=(0, height), span=4, rise=2, thickness=0.5, voussoirs=15, abutments=False, **keys)
    drums = int(height / 0.5)
    pier = {"width": 1.0, "height": height, "drums": drums} | keys
    left = mo.Column(name="left", at=(-2.75, 0), **pier)
    right = mo.Column(name="right", at=(1.75, 0), **pier)
    blocks = [*arch.blocks(), *left.blocks(), *right.blocks()]
    return mo.Scene(title="arch on piers", joints=mo.JointDefaults(friction_angle=33), blocks=blocks)


# %%
# Each further metre of height reduces the load factor by more than a third:
results = {height: mo.solve(arch_on_piers(height)) for height in (1.0, 2.0, 3.0)}
for height, result in results.items():
    print(f"piers of {height:g} m: load factor {result.required():.4f}")
load_factors = [result.required() for result in results.values()]
assert all(higher < 2 / 3 * lower for lower, higher in pairwise(load_factors))
result.plot("thrust")

"""
How far may a bracket reach out?
================================

Stones have notches, holes and several parts. A corbel carries a balcony: an L of two parts, with a hole
for the railing, lies on a wall and is held down by nothing but its own tail. How much load does its tip
take?
"""

import masonry_opt as mo

UNIT_WEIGHT = 25.0  # kN/m³

# %%
# Tail and slab are one rigid stone. The live load is 1 kN at the tip, so the load factor is what it
# carries.
corbel = mo.Block(
    name="corbel",
    parts=[[(-1, 0), (1, 0), (1, 0.3), (-1, 0.3)], [(-1, 0.3), (-0.4, 0.3), (-0.4, 0.9), (-1, 0.9)]],
    holes=[[(0.7, 0.1), (0.9, 0.1), (0.9, 0.2), (0.7, 0.2)]],
    unit_weight=UNIT_WEIGHT,
    live=(0, -1),
    live_at=(1, 0.3),
)
wall = mo.Block(name="wall", vertices=[(-1, -1), (0, -1), (0, 0), (-1, 0)], fixed=True)
scene = mo.Scene(
    title="a corbel", joints=mo.JointDefaults(friction=0.6), blocks=[corbel, wall], thickness=0.5
)
result = mo.solve(scene)

# %%
# By hand, moments about the edge of the wall: slab (centred on it), tail, and what the hole lacks.
slab, tail, hole = 2 * 0.3 * 0.0, 0.6 * 0.6 * 0.7, 0.2 * 0.1 * 0.8
by_hand = UNIT_WEIGHT * 0.5 * (slab + tail + hole) / 1.0
print(f"the tip carries {result.load_factor:.3f} kN, by hand {by_hand:.3f} kN")
assert abs(result.required() - by_hand) < 1e-5
result.plot()

"""
How far may a bracket reach out?
================================

Stones may have notches, holes and several parts. A corbel that carries a balcony has two parts in the shape
of an L, and a hole for the railing. The corbel lies on a wall, and only the weight of its tail prevents it
from tipping. How much load does its tip carry?
"""

import masonry_opt as mo

UNIT_WEIGHT = 25.0  # kN/m³

# %%
# Tail and slab are one rigid stone. The live load is 1 kN at the tip, so the load factor is the load in kN
# that the tip carries.
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
# By hand, from moments about the edge of the wall. The slab is centred on the edge and has no moment. The
# tail has a resisting moment, and the missing weight of the hole adds to it.
slab, tail, hole = 2 * 0.3 * 0.0, 0.6 * 0.6 * 0.7, 0.2 * 0.1 * 0.8
by_hand = UNIT_WEIGHT * 0.5 * (slab + tail + hole) / 1.0
print(f"the tip carries {result.load_factor:.3f} kN, by hand {by_hand:.3f} kN")
assert abs(result.required() - by_hand) < 1e-5
result.plot()

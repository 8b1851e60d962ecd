"""
How far can an arch lean before it falls?
=========================================

An arch that an earthquake pushes begins to move at some load factor, but does not fall yet: λ over
displacement says how far it may go. On the way its hinges move to other joints.
"""

import masonry_opt as mo

ring = mo.Arch(
    radius=4, angles=(157.5, 22.5), thickness=0.6, voussoirs=15, unit_weight=20, live_per_weight=(1, 0)
)
scene = mo.Scene(title="arch of 15 voussoirs", joints=mo.JointDefaults(friction=0.9), blocks=ring.blocks())
curve = mo.capacity(mo.solve(scene))
print(curve)

# %%
# The blocks half way, to scale:
half_way = curve.plot(row=len(curve.table) // 2)

# %%
# The check of a code, with its spectrum: periods in s, accelerations in g.
check = curve.check([(0, 0.2), (0.15, 0.5), (0.5, 0.5), (1, 0.25), (2, 0.125), (4, 0.03)])
print(check)
assert curve.reaches_zero
assert check.non_linear

# %%
# Where a joint opens, another closes: the stretch between goes back, and a real fall passes by it.
curve.plot()

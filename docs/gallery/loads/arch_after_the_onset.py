"""
How far can an arch lean before it falls?
=========================================

Under an earthquake an arch begins to move at its load factor, but it does not collapse immediately. The
capacity curve, λ over the displacement, shows how far the arch can move. During the motion the hinges move to
other joints.
"""

import masonry_opt as mo

ring = mo.Arch(
    radius=4, angles=(157.5, 22.5), thickness=0.6, voussoirs=15, unit_weight=20, live_per_weight=(1, 0)
)
scene = mo.Scene(title="arch of 15 voussoirs", joints=mo.JointDefaults(friction=0.9), blocks=ring.blocks())
curve = mo.capacity(mo.solve(scene))
print(curve)

# %%
# The picture shows the displaced blocks halfway along the curve, to scale:
half_way = curve.plot(row=len(curve.table) // 2)

# %%
# The displacement capacity is compared with a response spectrum, with periods in s and accelerations in g:
check = curve.check([(0, 0.2), (0.15, 0.5), (0.5, 0.5), (1, 0.25), (2, 0.125), (4, 0.03)])
print(check)
assert curve.reaches_zero
assert check.non_linear

# %%
# While one joint opens and another closes, the curve turns back to smaller displacements. A real structure
# does not follow this part of the curve.
curve.plot()

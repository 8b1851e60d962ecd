"""
From which side does an earthquake bring a corner down first?
=============================================================

Two walls meet in a toothed corner, 4 m high. Codes require earthquakes along both walls. How low is the load
factor in directions between the walls, and how much does a vertical force reduce it?
"""

import masonry_opt as mo

plan = mo.Plan(
    block=(2, 1),
    thickness=1,
    courses=4,
    walls=[
        mo.PlanWall(name="x", axis=[(0.5, 0.5), (6, 0.5)]),
        mo.PlanWall(name="y", axis=[(0.5, 0.5), (0.5, 4)]),
    ],
    unit_weight=20,
)
joints = mo.JointDefaults(friction=0.6)
corner = mo.Scene(title="corner of two walls", joints=joints, blocks=plan.blocks())

# %%
# The horizontal push grows from rest, on elastic contacts, until equilibrium is lost (the incremental load
# factor). After that, the moving blocks may carry only a lower load factor. λ is this lower load factor, as a
# horizontal seismic coefficient. It is computed for every 15° in plan.
found = mo.directions(corner, "incremental", every=15)
around = found.table.set_index("direction")["load_factor"]
print(f"along the walls: {around[[0, 90, 180, 270]].min():.3f}")
print(f"the least of all: {around.min():.3f}, {found.governing}")
assert around.min() < around[[0, 90, 180, 270]].min()

# %%
# A simultaneous upward force of 0.3 times the horizontal force reduces the normal forces, and therefore the
# friction, of all joints that slide. The example compares eight directions, 45° apart:
upwards = mo.directions(corner, "incremental", every=45, vertical=-0.3)
print(f"the least of eight, horizontal push: {around[::3].min():.3f}")
print(f"with 0.3 of the push upwards: {upwards.to_draw.required():.3f}, {upwards.governing}")
assert upwards.to_draw.required() < around[::3].min()

# %%
# In the weakest direction, the earthquake is not exactly normal to either wall:
found.plot()

"""
Where does a bogie stand worst on an arch bridge?
=================================================

Two axles cross an arch of 3 m span under fill. The second may hold down what the first lifts, so they are
moved along the road, and the load factor is followed.
"""

import masonry_opt as mo

# A strip 1 m wide, in m and kN: the arch on its abutments, and fill up to the road.
ring = mo.Arch(span=3, rise=0.75, thickness=0.3, voussoirs=14, unit_weight=22, abutments=False)
bank = [(1.5, -1), (4, -1), (4, 0.18), (1.74, 0.18), (1.5, 0)]
ground = [
    mo.Block(name="left", vertices=[(-x, y) for x, y in bank], fixed=True),
    mo.Block(name="right", vertices=bank, fixed=True),
]
fill = mo.Fill(road=[(-4, 1.35), (4, 1.35)], unit_weight=19, friction_angle=35, mobilised=0.2)
scene = mo.Scene(
    title="bogie over an arch",
    joints=mo.JointDefaults(friction_angle=33),
    blocks=[*ring.blocks(), *ground],
    fills=[fill],
)

# %%
# A double axle bogie of the British code, of which a strip of 1 m carries 0.4. It runs on the road of the
# fill, through which its loads spread.
bogie = mo.Axles(name="bogie", set="CS 454 double 1.3 m", factor=0.4)
crossed = mo.crossing(scene, bogie, method="static")
print(crossed)

# %%
# With associative flow nothing is missed between the positions solved: no position has a load factor below
# the bound.
assert crossed.bound > 0.997 * crossed.required()

# %%
# Coulomb friction is asked where it may be less. Here it is not: the arch hinges.
coulomb = mo.crossing(scene, bogie)
print(f"{coulomb.required():.3f}, {len(coulomb.table)} positions asked")
assert abs(coulomb.required() / crossed.required() - 1) < 2e-3

# %%
# Load factor by position, and below it, in the same scale, the mechanism at the worst:
crossed.plot()

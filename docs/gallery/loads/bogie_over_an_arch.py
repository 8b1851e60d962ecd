"""
Which position of a bogie on an arch bridge is the worst?
=========================================================

A bogie with two axles crosses an arch of 3 m span under fill. The second axle may press down the part of the
arch that the first axle lifts. The example therefore computes the load factor for many positions along the
road.
"""

import masonry_opt as mo

# The scene is a strip 1 m wide, in m and kN: the arch between its abutments, and fill up to the road.
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
# The load is a double-axle bogie of the British code CS 454, of which a strip of 1 m carries 0.4. The bogie
# moves along the road, and the fill spreads its loads.
bogie = mo.Axles(name="bogie", set="CS 454 double 1.3 m", factor=0.4)
crossed = mo.crossing(scene, bogie, method="static")
print(crossed)

# %%
# With associative flow, no position along the road has a load factor below the bound. This includes the
# positions between the solved positions.
assert crossed.bound > 0.997 * crossed.required()

# %%
# With Coulomb friction, only positions that may have a lower load factor are solved. For this arch the load
# factor is not lower, because the arch collapses by hinges.
coulomb = mo.crossing(scene, bogie)
print(f"{coulomb.required():.3f}, {len(coulomb.table)} positions solved")
assert abs(coulomb.required() / crossed.required() - 1) < 2e-3

# %%
# The picture shows the load factor over the position, and below it, to the same scale, the mechanism at the
# worst position:
crossed.plot()

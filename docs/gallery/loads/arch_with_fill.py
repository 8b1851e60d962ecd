"""
How does fill change the load factor of an arch bridge?
=======================================================

Fill between an arch and its road loads the arch with its weight, and resists by earth pressure where the arch
moves into the fill. Which of both effects increases the load factor more, and how much does the load factor
depend on the passive pressure?
"""

import masonry_opt as mo


def bridge(**fill: float | bool) -> mo.Scene:
    """Return a strip 1 m wide of an arch of 3 m span on piers, with 1 kN near a quarter of its span."""
    load = mo.PointLoad(voussoir=13, force=(0, -1))
    ring = {"span": 3, "rise": 0.75, "thickness": 0.3, "voussoirs": 40, "unit_weight": 22}
    arch = mo.Arch(at=(0, 1.5), skewbacks=0.9, abutments=False, point_loads=[load], **ring)
    pier = {"width": 0.9, "height": 1.5, "drums": 5, "unit_weight": 22, "base": False}
    left = mo.Column(name="left", at=(-2.4, 0), **pier)
    right = mo.Column(name="right", at=(1.5, 0), **pier)
    ground = mo.Block(name="ground", vertices=[(-5, -0.5), (5, -0.5), (5, 0), (-5, 0)], fixed=True)
    earth = {"unit_weight": 19, "friction_angle": 35, "mobilised": 0.4} | fill
    return mo.Scene(
        title="arch with fill",
        joints=mo.JointDefaults(friction_angle=33),
        blocks=[*arch.blocks(), *left.blocks(), *right.blocks(), ground],
        fills=[mo.Fill(road=[(-5, 2.85), (5, 2.85)], **earth)],
    )


# %%
# The scenes have only the weight of the fill, only its pressure, or both with an increasing share of the
# passive pressure:
parts = {
    "its weight alone": bridge(pressure=False),
    "its pressure alone": bridge(weight=False),
    "both, m = 0.1": bridge(mobilised=0.1),
    "both, m = 0.4": bridge(mobilised=0.4),
    "both, m = 1": bridge(mobilised=1.0),
}
results = {words: mo.solve(scene) for words, scene in parts.items()}
for words, result in results.items():
    print(f"{words}: {result.required():.1f} kN")

# %%
# The mechanism must lift the weight of the fill, and the earth pressure supports the half of the arch that
# rises. On faces that move into the fill, the pressure reaches the mobilised share of the passive pressure.
# On faces that move away from the fill, the pressure is the active pressure.
both = [result.required() for words, result in results.items() if words.startswith("both")]
assert both == sorted(both)
table = results["both, m = 0.4"].pressures
print(f"{table['yields'].sum()} of {len(table)} faces meet the passive limit")
results["both, m = 0.4"].plot("thrust")

# %%
# The last picture shows the mechanism:
results["both, m = 0.4"].plot()

"""
Round or pointed: which arch carries more load at its crown?
============================================================

Two arches have the same span, thickness and stone; one is semicircular, the other pointed. Both are loaded at
the crown, where a semicircular arch is weakest and a pointed arch is strong.
"""

import masonry_opt as mo

SPAN = 4.0
VOUSSOIRS = 16


def arch(rise: float) -> mo.Scene:
    """Return an arch with a live load of 0.5 kN on each of the two voussoirs at its crown."""
    crown = [
        mo.PointLoad(voussoir=number, force=(0, -0.5)) for number in (VOUSSOIRS // 2, VOUSSOIRS // 2 + 1)
    ]
    ring = mo.Arch(
        span=SPAN, rise=rise, thickness=0.4, voussoirs=VOUSSOIRS, unit_weight=22, point_loads=crown
    )
    return mo.Scene(
        title=f"arch of rise {rise:g}", joints=mo.JointDefaults(friction=0.7), blocks=ring.blocks()
    )


# %%
# The load factor is the load in kN, for a width of 1 m out of the plane. The pointed arch carries more than
# three times the load of the semicircular arch.
round_arch = mo.solve(arch(SPAN / 2))
pointed = mo.solve(arch(0.75 * SPAN))
print(f"semicircular {round_arch.required():.2f} kN, pointed {pointed.required():.2f} kN")
assert pointed.required() > 3 * round_arch.required()
round_arch.plot()

# %%
# The picture shows the mechanism of the pointed arch:
pointed.plot()

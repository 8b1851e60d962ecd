"""
Round or pointed: which arch bears more at its crown?
=====================================================

Two arches of the same span, thickness and stone, one semicircular, one pointed. A load is put on the
crown. A semicircle is loaded down the middle at its weakest; a pointed arch is made for it.
"""

import masonry_opt as mo

SPAN, VOUSSOIRS = 4.0, 16


def arch(rise: float) -> mo.Scene:
    """An arch with half of 1 kN on each of the two voussoirs at its crown."""
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
# The load factor is the load in kN, for 1 m out of the plane: the pointed one bears more than three times
# as much.
round_arch = mo.solve(arch(SPAN / 2))
pointed = mo.solve(arch(0.75 * SPAN))
print(f"semicircular {round_arch.required():.2f} kN, pointed {pointed.required():.2f} kN")
assert pointed.required() > 3 * round_arch.required()
round_arch.plot()

# %%
pointed.plot()

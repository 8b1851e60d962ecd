"""
By how much does a tie rod strengthen an arch?
==============================================

An arch thrusts its piers apart, and an earthquake along the span adds to the thrust. The usual remedy is an
iron rod between the springings. By how much does the rod raise the load factor, and above which strength of
the rod does the load factor not increase further?
"""

import masonry_opt as mo

PIER = 3.0  # m


def arch_on_piers(strength: float | None = None) -> mo.Scene:
    """Return a semicircular arch of 4 m span on piers, with a rod of the given strength in kN, if any."""
    keys = {"unit_weight": 22, "live_per_weight": (1, 0)}
    arch = mo.Arch(at=(0, PIER), span=4, rise=2, thickness=0.5, voussoirs=15, abutments=False, **keys)
    pier = {"width": 1.0, "height": PIER, "drums": 6} | keys
    left = mo.Column(name="left", at=(-2.75, 0), **pier)
    right = mo.Column(name="right", at=(1.75, 0), **pier)
    blocks = [*arch.blocks(), *left.blocks(), *right.blocks()]
    anchors = (-2.5, PIER - 0.25), (2.5, PIER - 0.25)
    rod = mo.Tie(between=("left d6", "right d6"), at=anchors, strength=strength, name="rod")
    return mo.Scene(
        title="arch on piers",
        joints=mo.JointDefaults(friction_angle=33),
        blocks=blocks,
        ties=[rod] if strength else [],
    )


# %%
# The scene is solved without a rod, and with rods of increasing strength:
bare = mo.solve(arch_on_piers())
results = {strength: mo.solve(arch_on_piers(strength)) for strength in (5.0, 10.0, 20.0, 40.0)}
print(f"no rod: load factor {bare.required():.4f}")
for strength, result in results.items():
    rod = result.ties.loc[0]
    print(
        f"rod of {strength:g} kN: load factor {result.required():.4f}, "
        f"it {'yields at' if rod['yields'] else 'carries'} {rod['force']:.2f} kN"
    )

# %%
# While the rod yields, the load factor increases in proportion to its strength. When another mechanism
# governs, in which the rod does not yield, a stronger rod does not raise the load factor.
load_factors = [bare.required(), *(result.required() for result in results.values())]
assert load_factors == sorted(load_factors)
results[10.0].plot()

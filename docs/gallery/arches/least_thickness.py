"""
How thin can a semicircular arch be?
====================================

Under its own weight a semicircular arch of rough stone stands down to a thickness of 0.1075 of its radius
(Milankovitch 1907; Makris & Alexakis 2013). How smooth may its joints be before they slide at a thickness
that would do?
"""

import masonry_opt as mo


def arch(thickness: float, friction: float) -> mo.Scene:
    """An arch of radius 1; any live load will do to ask whether it stands."""
    ring = mo.Arch(radius=1, angles=(180, 0), thickness=thickness, voussoirs=60, unit_weight=1, live=(1, 0))
    return mo.Scene(
        title="semicircular arch", joints=mo.JointDefaults(friction=friction), blocks=ring.blocks()
    )


def least(friction: float, falls: float = 0.08, stands: float = 0.3) -> float:
    """The least thickness at which it stands, by bisection."""
    while stands - falls > 1e-4:
        middle = (falls + stands) / 2
        if mo.solve(arch(middle, friction), "static").status is mo.Status.UNSTABLE:
            falls = middle
        else:
            stands = middle
    return stands


# %%
# From a friction of 0.4 on, only hinges matter; below it sliding asks for more thickness, or for more
# friction.
thickness = {friction: least(friction) for friction in (0.35, 0.4, 0.7)}
for friction, value in thickness.items():
    print(f"friction {friction}: thickness {value:.4f} of the radius")
assert abs(thickness[0.7] - 0.1075) < 3e-4

# %%
# A little thinner than the least, it falls: the picture shows how.
mo.solve(arch(0.105, 0.7)).plot()

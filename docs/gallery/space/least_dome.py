"""
How thin may a dome be?
=======================

A hemispherical dome that has cracked along its meridians consists of slices like those of an orange. Each
slice forms an arch with the opposite slice. Heyman (1967, *On shell solutions for masonry domes*) gives a
least thickness of t = 0.042 R. How thin may the dome be if its stones are laid in bond?
"""

import masonry_opt as mo


def dome(thickness: float, friction: float, bond: str) -> mo.Scene:
    """Return a dome of radius 1 with eight rings of twelve voussoirs, and with the live load on its key."""
    made = mo.Dome(radius=1, thickness=thickness, rings=8, voussoirs=12, bond=bond, unit_weight=1)
    return mo.Scene(
        title="dome",
        joints=mo.JointDefaults(friction=friction),
        blocks=made.blocks(),
        loads=[mo.Load(block="key", live=(0, 0, -1))],
    )


# %%
# First the vertical joints are continuous, so that the dome consists of slices. At the upper end of the
# interval a state of equilibrium exists. At the lower end a mechanism exists on which the weight does work.
# An independent linear program of one sector (``tests/space/dome_sector.py``) computes 0.04211 for these 97
# stones.
roughly = {"samples": 0, "tolerance": 1e-3}
slices = mo.least(lambda thickness: dome(thickness, 0.7, "meridians"), 0.03, 0.06, **roughly)
print(slices)
assert abs(slices.value - 0.04211) < 1e-4
assert abs(slices.value / 0.042 - 1) < 0.01

# %%
# In running bond, adjacent slices can separate only by sliding on their bed joints. The friction of the bed
# joints acts like a hoop. A dome with a third of the thickness is then stable if the friction exceeds about
# 0.15:
rough = mo.least(lambda friction: dome(0.014, friction, "running"), 0.05, 0.7, **roughly)
print(f"friction {rough.value:.3f}")
assert 0.14 < rough.value < 0.16

# %%
# The picture shows the mechanism of a dome of slices that is slightly thicker than necessary, under a load on
# its key. The linear program of one sector computes the load factor 0.012339.
result = mo.solve(dome(0.05, 0.7, "meridians"), "static")
assert abs(result.required() - 0.012339) < 1e-6
result.plot(view=(-60, 25))

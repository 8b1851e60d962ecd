"""
Does a wall carry less in space than in the plane?
==================================================

A plane analysis computes the load factor of a wall that is loaded in its own plane. A wall in space could
also twist or lean out of its plane. The example loads wall 1 of Table 1 of Gilbert, Casapulla & Ahmed (2006)
first in its plane and then out of its plane.
"""

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

THICKNESS = 0.7
HEIGHT = 10.5
FRICTION = 0.65

# %%
# In its plane the wall has the same load factors in space, for any thickness. The associative load factor is
# the 0.64286 of Table 1. The lowest Coulomb state found is the lowest state known in the plane, 0.638982.
flat = mo.load(case_folder() / "ferris_tinloi" / "wall_1.toml")
for scene in (flat, mo.extrude(flat, THICKNESS), mo.extrude(flat, HEIGHT)):
    along = mo.solve(scene, incremental=False)
    print(f"along the wall: associative {along.associative:.5f}, lowest found {along.required():.5f}")
    assert abs(along.associative - 0.64286) < 1e-5
    assert abs(along.required() - 0.638982) < 4e-6


# %%
# A plane analysis cannot load the wall out of its plane. Out of its plane a wall of thickness t and height h
# overturns at λ = t / h, or slides if friction is smaller than t / h.
def across(thickness: float) -> mo.Scene:
    """Return the wall with the given thickness. The live load is its weight, applied out of its plane."""
    thick = mo.extrude(flat, thickness)
    turned = [one if one.fixed else one.replace(live_per_weight=(0, 1, 0)) for one in thick.blocks]
    return thick.replace(title="wall 1, pushed across", blocks=turned)


for thickness in (HEIGHT, THICKNESS):
    result = mo.solve(across(thickness), incremental=False)
    print(f"across, {thickness} thick: {result.required():.5f}")
    assert abs(result.required() - min(FRICTION, thickness / HEIGHT)) < 1e-6
result.plot()

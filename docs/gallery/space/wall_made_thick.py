"""
Does a wall carry less in space than in the plane?
==================================================

A plane analysis says what a wall carries along its own plane. Made thick it might twist, or lean out. Wall 1
of Table 1 of Gilbert, Casapulla & Ahmed (2006) is pushed along its plane, and then across.
"""

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

THICKNESS, HEIGHT, FRICTION = 0.7, 10.5, 0.65

# %%
# Along the wall nothing is lost, however thick it is: the associative load factor in space is the 0.64286 of
# Table 1, and the Coulomb state that is found is the lowest that is known in the plane, 0.638982.
flat = mo.load(case_folder() / "ferris_tinloi" / "wall_1.toml")
for scene in (flat, mo.extrude(flat, THICKNESS), mo.extrude(flat, HEIGHT)):
    along = mo.solve(scene, incremental=False)
    print(f"along the wall: associative {along.associative:.5f}, lowest found {along.required():.5f}")
    assert abs(along.associative - 0.64286) < 1e-5
    assert abs(along.required() - 0.638982) < 4e-6


# %%
# Across it the plane knows nothing: the wall falls over its foot at t / h, up to where it slides.
def across(thickness: float) -> mo.Scene:
    """Its weight, sideways, out of the plane."""
    thick = mo.extrude(flat, thickness)
    turned = [one if one.fixed else one.replace(live_per_weight=(0, 1, 0)) for one in thick.blocks]
    return thick.replace(title="wall 1, pushed across", blocks=turned)


for thickness in (HEIGHT, THICKNESS):
    result = mo.solve(across(thickness), incremental=False)
    print(f"across, {thickness} thick: {result.required():.5f}")
    assert abs(result.required() - min(FRICTION, thickness / HEIGHT)) < 1e-6
result.plot()

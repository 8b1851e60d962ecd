"""
What force drives a wedge under a stone?
========================================

A wedge of 8° is driven under a stone of 400 lb next to a wall. The friction coefficient of all faces
is 0.35 (Beer & Johnston, *Vector Mechanics for Engineers: Statics*, sample problem 8.4). The textbook gives a
force of 423 lb.
"""

from math import atan, radians, tan

import masonry_opt as mo

FRICTION = 0.35
WEIGHT = 400
LEAN = radians(8)


def on_the_wedge(x: float) -> tuple[float, float]:
    """Return the point of the sloping face of the wedge at x."""
    return x, 2 - x * tan(LEAN)


# %%
# The wedge has no weight; the live load is 1 lb on its end, so the load factor is the force.
wedge = mo.Block(
    name="wedge", vertices=[(0, 0), (10, 0), on_the_wedge(10), (0, 2)], weight=0, live=(1, 0), live_at=(0, 1)
)
stone = mo.Block(name="stone", vertices=[on_the_wedge(2), on_the_wedge(8), (8, 8), (2, 8)], weight=WEIGHT)
floor = mo.Block(name="floor", vertices=[(-2, -1), (14, -1), (14, 0), (-2, 0)], fixed=True)
wall = mo.Block(name="wall", vertices=[(8, 2.5), (9, 2.5), (9, 9), (8, 9)], fixed=True)
scene = mo.Scene(
    title="Beer & Johnston's wedge",
    joints=mo.JointDefaults(friction=FRICTION),
    blocks=[wedge, stone, floor, wall],
)
result = mo.solve(scene)

# %%
# By hand, with the friction angle φ on three faces, the force is W tan(8° + 2 φ).
by_hand = WEIGHT * tan(LEAN + 2 * atan(FRICTION))
print(f"force {result.load_factor:.3f} lb, by hand {by_hand:.3f} lb")
assert abs(result.required() / by_hand - 1) < 1e-6
result.plot()

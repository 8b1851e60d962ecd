"""
What bolt holds a slope of toppling columns?
============================================

Rock in steep columns topples like books on a shelf (Goodman & Bray 1976). A bolt through the lowest
column is to hold sixteen of them. How strong must it be?
"""

from math import cos, radians, sin

import masonry_opt as mo

BOLT = 10_000.0  # kN, at half the height of column 1, 4° below the horizontal: more than enough


# %%
# Axes run along and normal to the base, which dips 30° in steps of 1 m.
def slope(friction: float) -> mo.Scene:
    """The bolt is a dead load, and its opposite the live load: what is needed is (1 − λ) of it."""
    along = (BOLT * cos(radians(34)), -BOLT * sin(radians(34)))
    blocks = []
    for number in range(1, 17):
        left, base = 10 * (number - 1), number - 1
        height = 4 * number if number <= 10 else 40 - 6 * (number - 10)
        corners = [(left, base), (left + 10, base), (left + 10, base + height), (left, base + height)]
        bolted = {"dead": along, "live": (-along[0], -along[1]), "dead_at": (0, 2), "live_at": (0, 2)}
        loads = bolted if number == 1 else {}
        blocks.append(mo.Block(name=f"column {number}", vertices=corners, unit_weight=25, **loads))
        step = [(left, base - 1), (left + 10, base - 1), (left + 10, base), (left, base)]
        blocks.append(mo.Block(name=f"step {number}", vertices=step, fixed=True))
    gravity = (-sin(radians(30)), -cos(radians(30)))
    return mo.Scene(
        title="toppling columns", joints=mo.JointDefaults(friction=friction), gravity=gravity, blocks=blocks
    )


# %%
# Below the associative answer, 236.6 kN, no state of equilibrium exists: the slope falls whatever joints
# do. The textbook's limit equilibrium asks for 2010 kN, and Coulomb states of collapse are known up to
# 4555 kN.
result = mo.solve(slope(0.65))
least, found = (BOLT * (1 - value) for value in (result.associative, result.required()))
print(f"needed whatever joints do: {least:.1f} kN; a Coulomb state of collapse: {found:.0f} kN")
assert abs(least - 236.6) < 0.1
assert found >= 2010
result.plot()

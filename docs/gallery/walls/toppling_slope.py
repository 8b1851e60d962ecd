"""
Which bolt force stabilises a slope of toppling columns?
========================================================

Rock in steep columns topples like books on a shelf (Goodman & Bray 1976). A bolt through the lowest of
sixteen columns prevents their collapse. How large must the force of the bolt be?
"""

from math import cos, radians, sin

import masonry_opt as mo

BOLT = 10_000.0  # kN, at half the height of column 1, 4° below the horizontal: larger than needed


# %%
# The axes of the model are parallel and normal to the base of the slope, which dips at 30° and has steps
# of 1 m.
def slope(friction: float) -> mo.Scene:
    """Return the slope with the bolt force as dead load, and its opposite as live load.

    The bolt force at collapse is therefore (1 − λ) times ``BOLT``.
    """
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
# Below the associative bolt force, 236.6 kN, no state of equilibrium exists, and the slope collapses under
# any flow rule. The limit equilibrium of the textbook requires 2010 kN. Coulomb collapse states are known up
# to 4555 kN.
result = mo.solve(slope(0.65))
least, found = (BOLT * (1 - value) for value in (result.associative, result.required()))
print(f"needed under any flow rule: {least:.1f} kN; a Coulomb state collapses at: {found:.0f} kN")
assert abs(least - 236.6) < 0.1
assert found >= 2010
result.plot()

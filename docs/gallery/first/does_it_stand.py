"""
Does it stand?
==============

Four bricks of length 1 are stacked like stairs, each shifted by the same distance beyond the one below it.
How far can they be shifted before the stack falls under its own weight, and which bricks fall?
"""

import masonry_opt as mo

LENGTH, HEIGHT, COUNT = 1.0, 0.25, 4


def stairs(shift: float) -> mo.Scene:
    """Four bricks of weight 1, each shifted to the right; live load: their weights, to the right."""
    bricks = []
    for number in range(COUNT):
        left, low = number * shift, number * HEIGHT
        right, top = left + LENGTH, low + HEIGHT
        corners = [(left, low), (right, low), (right, top), (left, top)]
        bricks.append(mo.Block(name=f"brick {number + 1}", vertices=corners, weight=1, live=(1, 0)))
    ground = mo.Block(name="ground", vertices=[(-1, -0.3), (2, -0.3), (2, 0), (-1, 0)], fixed=True)
    title = f"four bricks, each shifted by {shift:g}"
    return mo.Scene(title=title, joints=mo.JointDefaults(friction=0.6), blocks=[*bricks, ground])


# %%
# By hand: the three upper bricks have their common centre of gravity in the middle of brick 3, two shifts
# beyond the middle of brick 1. They are stable on brick 1 if two shifts are at most half its length: up to a
# shift of 1/4. Every analysis first decides if the scene is stable under its dead load.
for shift in (0.2, 0.24, 0.26):
    result = mo.solve(stairs(shift))
    print(f"shift {shift:g}: {'falls' if result.status is mo.Status.UNSTABLE else 'stands'}")
    assert (result.status is mo.Status.UNSTABLE) is (shift > LENGTH / 4)

# %%
# The message says which bricks fall, and the picture shows how:
print(result.message)
result.plot()

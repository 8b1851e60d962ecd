"""
Does it stand?
==============

Four bricks of length 1 are stacked like stairs, each shifted by the same distance beyond the one below it.
How far can they be shifted before the stack falls under its own weight, and which bricks fall?
"""

import masonry_opt as mo

LENGTH = 1.0
HEIGHT = 0.25
COUNT = 4


def stairs(shift: float) -> mo.Scene:
    """Return four bricks of weight 1, each shifted to the right, without live load."""
    bricks = []
    for number in range(COUNT):
        left, low = number * shift, number * HEIGHT
        right, top = left + LENGTH, low + HEIGHT
        corners = [(left, low), (right, low), (right, top), (left, top)]
        bricks.append(mo.Block(name=f"brick {number + 1}", vertices=corners, weight=1))
    ground = mo.Block(name="ground", vertices=[(-1, -0.3), (2, -0.3), (2, 0), (-1, 0)], fixed=True)
    title = f"four bricks, each shifted by {shift:g}"
    return mo.Scene(title=title, joints=mo.JointDefaults(friction=0.6), blocks=[*bricks, ground])


# %%
# By hand: the common centre of the three upper bricks lies two shifts beyond the centre of brick 1. The three
# bricks are stable while this distance is at most half the length of brick 1: up to a shift of 1/4. A scene
# without live load asks this question: is the scene stable under its dead load?
for shift in (0.2, 0.24, 0.26):
    result = mo.solve(stairs(shift))
    print(f"shift {shift:g}: {result.status}")
    assert (result.status is mo.Status.STABLE) is (shift < LENGTH / 4)

# %%
# The message names the bricks that fall, and the picture shows how they fall:
print(result.message)
result.plot()

# %%
# A stable scene has margins of safety. The worst joint is the joint whose resultant is nearest to its edge:
# here the joint above brick 1. By hand, its resultant acts two shifts from the centre of brick 1, and
# therefore 1/2 − 2 · 0.2 from the edge. Equilibrium alone fixes the forces of a stack, so no other forces are
# possible.
stable = mo.solve(stairs(0.2))
worst = stable.stability.worst_joint
print(f"nearest to its edge: joint '{worst.first}'–'{worst.second}', {worst.distance:.3f} from the edge")
assert stable.stability.unique
assert abs(worst.distance - (LENGTH / 2 - 2 * 0.2)) < 1e-6

# %%
# The line of thrust joins the resultants of the joints:
stable.plot("thrust")

"""
Between which reactions of a settling pier is a wall stable?
============================================================

The foundation under the right end of a wall softens. Which reaction of the pier is necessary to keep the wall
stable, and what is the mechanism if the reaction is smaller?
"""

import masonry_opt as mo

# %%
# Two lintels rest on three piers, and carry a wall in running bond. The unit weight is 20 kN/m³, and forces
# are per metre of thickness.
PIERS = {"left": (0.0, 0.8), "middle": (2.6, 3.4), "right": (5.2, 6.0)}
COURSES = [[0, 3, 6], [0, 0.75, 1.75, 2.75, 3.75, 4.75, 6], [0, 1.25, 2.25, 3.25, 4.25, 5.25, 6]]


def rectangle(name: str, left: float, right: float, bottom: float, top: float, **keys: object) -> mo.Block:
    return mo.Block(name=name, vertices=[(left, bottom), (right, bottom), (right, top), (left, top)], **keys)


blocks = [rectangle(name, *ends, 0.0, 1.0, fixed=True) for name, ends in PIERS.items()]
for row, ends in enumerate([*COURSES, COURSES[1], COURSES[2]]):
    bottom = 1.0 + 0.5 * row
    for number, left in enumerate(ends[:-1]):
        right = ends[number + 1]
        blocks.append(rectangle(f"{row}-{number}", left, right, bottom, bottom + 0.5, unit_weight=20))
wall = mo.Scene(title="wall on three piers", joints=mo.JointDefaults(friction=0.6), blocks=blocks)

# %%
# The pier moves vertically downwards. Its reaction is the force with which the ground presses the pier
# against the wall.
settling = mo.settle(wall, "right", (0, -1))
print(settling)
assert settling.usable
settling.plot("least")

# %%
# The wall follows the pier downwards at the least reaction. If the pier is pushed upwards, it lifts the wall
# at the greatest reaction:
settling.plot("greatest")

# %%
# In the horizontal direction the pier needs no support. Its least reaction is negative, because friction on
# its top resists a pull of this size. The friction is proportional to the normal force, which depends on the
# self-stress. The least reactions of Coulomb friction, of the incremental analysis and of associative flow
# therefore differ widely.
leaning = mo.settle(wall, "right", (1, 0))
print(leaning)
assert leaning.least.reaction < leaning.at_rest < leaning.greatest.reaction
leaning.plot("least")

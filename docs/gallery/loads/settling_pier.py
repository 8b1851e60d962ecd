"""
Between which reactions does a settling pier hold?
==================================================

The foundation under the right end of a wall softens. How much must it still bear, so that the wall
stands, and what moves once it bears less?
"""

import masonry_opt as mo

# %%
# Two lintels on three piers, and a wall in bond above; 20 kN/m³, per metre of thickness.
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
# The pier moves straight down; its reaction is the force with which the ground presses it against the wall.
settling = mo.settle(wall, "right", (0, -1))
print(settling)
assert settling.usable
settling.plot("least")

# %%
# Below the least reaction the wall follows its pier down. Pushed up, the pier lifts the wall at the greatest:
settling.plot("greatest")

# %%
# Aside the pier needs no hold: its least reaction is below zero, for friction on its top holds it up to that
# pull. How much friction bears there depends on the normal force, which other self-stress changes: Coulomb's
# lowest found, the incremental and the associative reaction lie far apart.
leaning = mo.settle(wall, "right", (1, 0))
print(leaning)
assert leaning.least.reaction < leaning.at_rest < leaning.greatest.reaction
leaning.plot("least")

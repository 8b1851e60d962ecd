"""
How much of a façade's associative load factor is real?
=======================================================

A façade is toothed into its two return walls and pushed outwards. At collapse the stones of the teeth slide
out. Classical (associative) limit analysis assumes that sliding joints open, which jams the teeth and raises
the load factor. How much of the associative load factor is available with Coulomb friction?
"""

import masonry_opt as mo

LENGTH = 8  # in thicknesses of the wall
DEPTH = 3  # in thicknesses of the wall
COURSES = 4


def facade(friction: float) -> mo.Scene:
    """Return a front and two return walls of blocks 2 × 1 × 1, pushed outwards by λ times their weight."""
    left, right = 0.5, LENGTH - 0.5
    axes = {
        "front": [(left, 0.5), (right, 0.5)],
        "left": [(left, 0.5), (left, DEPTH)],
        "right": [(right, 0.5), (right, DEPTH)],
    }
    walls = [mo.PlanWall(name=name, axis=axis) for name, axis in axes.items()]
    plan = mo.Plan(
        block=(2, 1), thickness=1, courses=COURSES, walls=walls, unit_weight=1, live_per_weight=(0, -1, 0)
    )
    return mo.Scene(title="façade", joints=mo.JointDefaults(friction=friction), blocks=plan.blocks())


# %%
# The result has three load factors: that of the lowest exact collapse state found, the incremental load
# factor with elastic contacts, and the associative load factor of classical limit analysis.
result = mo.solve(facade(0.6))
print(result)

# %%
# An independent program for contact dynamics (``tests/contact_dynamics.py``) loads the same blocks from rest
# until they collapse, at 0.379. The incremental load factor agrees with this value, and is a ninth below the
# associative load factor. The lowest state found is at little more than half of the associative load factor.
# In this state no forces press on the teeth. By hand, 4, 6, 8 and 10 half blocks of the courses, from the
# bottom up, rotate about the foot as if there were no friction.
halves, arms, heights = (4, 6, 8, 6, 4), (0.5, 0.5, 0.5, 0.5, 1), (0.5, 1.5, 2.5, 3.5, 3.5)
moments = [sum(w * at for w, at in zip(halves, place, strict=True)) for place in (arms, heights)]
promised, expected, lowest = result.associative, result.incremental, result.required()
print(f"associative {promised:.3f}, incremental {expected:.3f}, lowest found {lowest:.4f}")
assert abs(expected - 0.379) < 0.002
assert abs(promised / expected - 1.12) < 0.01
assert abs(lowest - moments[0] / moments[1]) < 1e-6
result.plot(view=(-50, 25))

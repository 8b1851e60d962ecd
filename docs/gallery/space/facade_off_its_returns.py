"""
How much of a façade's strength is there?
=========================================

A façade is toothed into its two returns and pushed outwards. Stones of the teeth must slide out. Classical
(associative) limit analysis lets joints open as they slide, which wedges the teeth and presses on them: how
much of what it promises is there?
"""

import masonry_opt as mo

LENGTH, DEPTH, COURSES = 8, 3, 4  # in thicknesses of the wall


def facade(friction: float) -> mo.Scene:
    """Blocks 2 × 1 × 1 of a front and two returns, pushed outwards by λ times their weight."""
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
# Three numbers: the lowest exact collapse state that was found; the incremental load factor, with elastic
# contacts; and the associative load factor of classical limit analysis.
result = mo.solve(facade(0.6))
print(result)

# %%
# Contact dynamics, another program (``tests/contact_dynamics.py``), pushes the same blocks from rest
# until they fall: at 0.379. A ninth of the promise is not there. The least state lies at little more than
# half of it: nothing presses on the teeth, and what leaves, by hand, 4, 6, 8 and 10 half blocks from the foot
# up, turns about the foot as if there were no friction.
halves, arms, heights = (4, 6, 8, 6, 4), (0.5, 0.5, 0.5, 0.5, 1), (0.5, 1.5, 2.5, 3.5, 3.5)
moments = [sum(w * at for w, at in zip(halves, place, strict=True)) for place in (arms, heights)]
promised, expected, lowest = result.associative, result.incremental, result.required()
print(f"associative {promised:.3f}, incremental {expected:.3f}, lowest found {lowest:.4f}")
assert abs(expected - 0.379) < 0.002
assert abs(promised / expected - 1.12) < 0.01
assert abs(lowest - moments[0] / moments[1]) < 1e-6
result.plot(view=(-50, 25))

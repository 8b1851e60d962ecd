"""
At which angle does a column fall from a tilted table?
======================================================

The cheapest test of a model: build it on a board, and raise the board's end until it falls. The tangent
of that angle is the horizontal acceleration, in g, which it would just bear.
"""

from math import atan, degrees

import masonry_opt as mo


def on_a_board(friction_angle: float) -> mo.Scene:
    """Five drums, 0.3 m wide and 1 m high in all, on a board that is tilted to the right."""
    column = mo.Column(width=0.3, height=1.0, drums=5, unit_weight=20)
    return mo.Scene(
        title="a column on a board",
        joints=mo.JointDefaults(friction_angle=friction_angle),
        blocks=column.blocks(),
        tilt="right",
    )


# %%
# Rough drums tip as one about the foot, at atan(0.3 / 1); smooth ones slide before, at their friction
# angle.
for friction_angle in (12, 33):
    result = mo.solve(on_a_board(friction_angle))
    print(f"φ = {friction_angle}°: falls at {result.tilt_angle:.2f}°")
    assert abs(result.tilt_angle - min(friction_angle, degrees(atan(0.3)))) < 1e-4

# %%
# So a friction angle above 16.7° makes no difference to this column:
result.plot()

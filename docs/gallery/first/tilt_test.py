"""
At which tilt angle does a column collapse?
===========================================

A tilt test is the cheapest test of a model: the model is built on a board, and one end of the board is raised
until the model collapses. The tangent of the tilt angle at collapse is the horizontal acceleration, in g, at
which the model collapses on level ground.
"""

from math import atan, degrees

import masonry_opt as mo


def on_a_board(friction_angle: float) -> mo.Scene:
    """Return five drums, 0.3 m wide and 1 m high in total, on a board that is tilted to the right."""
    column = mo.Column(width=0.3, height=1.0, drums=5, unit_weight=20)
    return mo.Scene(
        title="a column on a board",
        joints=mo.JointDefaults(friction_angle=friction_angle),
        blocks=column.blocks(),
        tilt="right",
    )


# %%
# Rough drums tip together about the foot, at atan(0.3 / 1). Smooth drums slide at a smaller angle, which is
# their friction angle.
for friction_angle in (12, 33):
    result = mo.solve(on_a_board(friction_angle))
    print(f"φ = {friction_angle}°: falls at {result.tilt_angle:.2f}°")
    assert abs(result.tilt_angle - min(friction_angle, degrees(atan(0.3)))) < 1e-4

# %%
# A friction angle above 16.7° therefore does not change the tilt angle at which this column collapses:
result.plot()

"""
How far is a retaining wall from sliding and overturning?
=========================================================

Earth or water presses on a wall of rough stones with a pressure that increases with depth. The load factor is
the factor of safety: the number by which the pressure must be multiplied to make the wall collapse.
"""

import masonry_opt as mo

WIDTH = 1.2
HEIGHT = 3.0
UNIT_WEIGHT = 22.0
FRICTION = 0.65
PRESSURE = 18.0  # kN/m² at the foot


def wall(friction: float) -> mo.Scene:
    """Return a wall of six courses under a triangular pressure from the left."""
    courses = mo.Column(width=WIDTH, height=HEIGHT, drums=6, unit_weight=UNIT_WEIGHT).blocks()
    earth = mo.EdgeLoad(start=(0, HEIGHT), end=(0, 0), pressure=(0, PRESSURE), kind="live")
    return mo.Scene(
        title="retaining wall", joints=mo.JointDefaults(friction=friction), blocks=courses, edge_loads=[earth]
    )


# %%
# By hand, at the foot, with the weight W and the width b of the wall: the wall slides at μ W divided by the
# thrust. It overturns at W b/2 divided by the moment of the thrust about the toe. The thrust acts at a third
# of the height.
weight, thrust = UNIT_WEIGHT * WIDTH * HEIGHT, PRESSURE * HEIGHT / 2
slides, overturns = FRICTION * weight / thrust, weight * WIDTH / 2 / (thrust * HEIGHT / 3)
result = mo.solve(wall(FRICTION))
print(f"load factor {result.required():.4f}; by hand slides at {slides:.4f}, overturns at {overturns:.4f}")
assert abs(result.required() - min(slides, overturns)) < 1e-5
result.plot()

# %%
# With smoother joints (friction 0.4) the wall slides instead of overturning:
smooth = mo.solve(wall(0.4))
print(f"friction 0.4: load factor {smooth.required():.4f}")
assert abs(smooth.required() - 0.4 * weight / thrust) < 1e-5
smooth.plot()

"""
When does a wall stop sliding and start to rock?
================================================

A small wall is pushed sideways. Its friction coefficient is not known exactly. Up to which friction does the
load factor depend on friction, and at which friction does the mechanism change?
"""

import masonry_opt as mo


def wall(friction: float) -> mo.Scene:
    """Return six courses of running bond, two stones wide. The live load is the weight, applied sideways."""
    bond = mo.Wall(
        block=(4, 1.75),
        weight=1,
        live_per_weight=(1, 0),
        courses=["halves", "whole"],
        repeat=3,
        course={"halves": [0.5, 1, 0.5], "whole": [1, 1]},
    )
    return mo.Scene(title="running bond", joints=mo.JointDefaults(friction=friction), blocks=bond.blocks())


# %%
# Each row names the kind of mechanism: "sliding", "hinging", or "mixed".
frame = mo.sweep(wall, {"friction": [0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0]}, workers=1)
frame[["friction", "load_factor", "associative", "mechanism"]].round(4)

# %%
# Up to a friction of 0.545 the wall slides, and the load factor equals the friction coefficient. At higher
# friction the stones above a stepped crack rock about the foot of the wall, and the load factor is constant.
# The associative load factor increases further, and is 37 % higher at a friction of 1.
sliding = frame["mechanism"] == "sliding"
assert (frame["load_factor"] - frame["friction"])[sliding].abs().max() < 1e-6
assert (frame["load_factor"] - 0.545055)[~sliding].abs().max() < 1e-6
mo.solve(wall(0.6)).plot()

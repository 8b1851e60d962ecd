"""
Does the block slide or tip?
============================

A block stands on the ground. A horizontal force at half its height, like that of an earthquake, pushes the
block. At which fraction of its weight does the block move, and does the block slide or tip?
"""

import masonry_opt as mo

WIDTH = 1.0
FRICTION = 0.6


def pushed(height: float) -> mo.Scene:
    """Return a block of weight 1 on the floor. The live load is the weight of the block, applied sideways."""
    block = mo.Block(
        name="block", vertices=[(0, 0), (WIDTH, 0), (WIDTH, height), (0, height)], weight=1, live=(1, 0)
    )
    floor = mo.Block(name="floor", vertices=[(-2, -0.5), (3, -0.5), (3, 0), (-2, 0)], fixed=True)
    return mo.Scene(
        title="a block on the floor", joints=mo.JointDefaults(friction=FRICTION), blocks=[block, floor]
    )


# %%
# A low block slides when the horizontal force reaches tan φ times the weight. A slender block tips when the
# force reaches width / height times the weight. The load factor is the smaller of both ratios.
for height in (1.0, 1.5, 2.0, 3.0):
    result = mo.solve(pushed(height))
    print(f"height {height:g}: load factor {result.load_factor:.4f}")
    assert abs(result.required() - min(FRICTION, WIDTH / height)) < 1e-6

# %%
# The last block, of height 3, tips at 1/3 of its weight:
result.plot()

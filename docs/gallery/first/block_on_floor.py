"""
Does the block slide or tip?
============================

A block stands on the ground and is pushed sideways at half its height, as by an earthquake. At which
share of its weight does it move, and how?
"""

import masonry_opt as mo

WIDTH, FRICTION = 1.0, 0.6


def pushed(height: float) -> mo.Scene:
    """A block of weight 1 on the floor; live load: its weight, sideways."""
    block = mo.Block(
        name="block", vertices=[(0, 0), (WIDTH, 0), (WIDTH, height), (0, height)], weight=1, live=(1, 0)
    )
    floor = mo.Block(name="floor", vertices=[(-2, -0.5), (3, -0.5), (3, 0), (-2, 0)], fixed=True)
    return mo.Scene(
        title="a block on the floor", joints=mo.JointDefaults(friction=FRICTION), blocks=[block, floor]
    )


# %%
# A low block slides as soon as the push reaches tan φ, a slender one tips when it reaches width / height:
# the smaller of the two is the load factor.
for height in (1.0, 1.5, 2.0, 3.0):
    result = mo.solve(pushed(height))
    print(f"height {height:g}: load factor {result.load_factor:.4f}")
    assert abs(result.required() - min(FRICTION, WIDTH / height)) < 1e-6

# %%
# The last one tips, at 1/3 of its weight:
result.plot()

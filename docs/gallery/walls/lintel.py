"""
Does a heavy lintel make a portal safer?
========================================

Two columns carry a beam, as in a temple. In an earthquake a heavier beam applies a larger horizontal force,
but also presses the columns down. Makris & Vassiliou (2013) showed that both effects cancel: the frame
uplifts at the acceleration b/h of a single column, for any weight of the beam.
"""

import masonry_opt as mo

WIDTH = 1.0
HEIGHT = 4.0


def upright(name: str, x: float) -> mo.Block:
    """Return a column of weight 1, whose live load is its weight, applied sideways."""
    corners = [(x, 0), (x + WIDTH, 0), (x + WIDTH, HEIGHT), (x, HEIGHT)]
    return mo.Block(name=name, vertices=corners, weight=1, live=(1, 0))


def portal(beam: float) -> mo.Scene:
    """Return two columns and a beam of the given weight; the live loads are the weights, sideways."""
    blocks = [
        upright("left", 0),
        upright("right", 5),
        mo.Block(name="beam", vertices=[(0, 4), (6, 4), (6, 5), (0, 5)], weight=beam, live=(beam, 0)),
        mo.Block(name="ground", vertices=[(-2, -1), (8, -1), (8, 0), (-2, 0)], fixed=True),
    ]
    return mo.Scene(title="portal", joints=mo.JointDefaults(friction=0.6), blocks=blocks)


# %%
# The load factor is b/h = 1/4 for beams of half the weight, twice the weight and ten times the weight of a
# column.
for beam in (0.5, 2.0, 10.0):
    result = mo.solve(portal(beam))
    print(f"beam of {beam:g} columns' weight: load factor {result.required():.4f}")
    assert abs(result.required() - WIDTH / HEIGHT) < 1e-6
result.plot()

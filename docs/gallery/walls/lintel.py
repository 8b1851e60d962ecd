"""
Does a heavy lintel make a portal safer?
========================================

Two columns carry a beam, as at a temple. In an earthquake a heavier beam pushes harder, but also weighs
the columns down. Makris & Vassiliou (2013) found that the two cancel: the frame uplifts at the
acceleration b/h of a single column, whatever the beam weighs.
"""

import masonry_opt as mo

WIDTH, HEIGHT = 1.0, 4.0


def upright(name: str, x: float) -> mo.Block:
    """A column of weight 1."""
    corners = [(x, 0), (x + WIDTH, 0), (x + WIDTH, HEIGHT), (x, HEIGHT)]
    return mo.Block(name=name, vertices=corners, weight=1, live=(1, 0))


def portal(beam: float) -> mo.Scene:
    """Two columns and a beam of that weight, shaken sideways."""
    blocks = [
        upright("left", 0),
        upright("right", 5),
        mo.Block(name="beam", vertices=[(0, 4), (6, 4), (6, 5), (0, 5)], weight=beam, live=(beam, 0)),
        mo.Block(name="ground", vertices=[(-2, -1), (8, -1), (8, 0), (-2, 0)], fixed=True),
    ]
    return mo.Scene(title="portal", joints=mo.JointDefaults(friction=0.6), blocks=blocks)


# %%
for beam in (0.5, 2.0, 10.0):
    result = mo.solve(portal(beam))
    print(f"beam of {beam:g} columns' weight: load factor {result.required():.4f}")
    assert abs(result.required() - WIDTH / HEIGHT) < 1e-6
result.plot()

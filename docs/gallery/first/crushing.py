"""
How much does crushing of the stone reduce the load factor?
===========================================================

A rigid block tips about a sharp edge. Real stone crushes at this edge, and the centre of rotation moves
inwards until the weight rests on a strip at the compressive strength of the stone.
"""

import masonry_opt as mo

WIDTH = 1.0  # m
HEIGHT = 4.0  # m
WEIGHT = 80.0  # kN, for 1 m out of the plane


def pier(strength: float | None) -> mo.Scene:
    """Return a pier that is pushed sideways at half its height; ``strength`` is in kN/m²."""
    stone = mo.Block(
        name="pier",
        vertices=[(0, 0), (WIDTH, 0), (WIDTH, HEIGHT), (0, HEIGHT)],
        weight=WEIGHT,
        live=(WEIGHT, 0),
    )
    ground = mo.Block(name="ground", vertices=[(-1, -0.5), (2, -0.5), (2, 0), (-1, 0)], fixed=True)
    return mo.Scene(
        title="a pier that crushes",
        joints=mo.JointDefaults(friction=0.7, strength=strength),
        blocks=[stone, ground],
    )


# %%
# By hand, for a block of weight W, width b and height h: at the strength f, the weight rests on a strip of
# width W / f at the edge. Moments about the middle of the strip give λ = (b − W / f) / h.
for strength in (None, 2000.0, 800.0, 400.0):
    result = mo.solve(pier(strength), "static")
    strip = WEIGHT / strength if strength else 0.0
    limit = f"strength {strength:g} kN/m²" if strength else "no limit of strength"
    print(f"{limit}: load factor {result.load_factor:.5f}")
    assert abs(result.required() - (WIDTH - strip) / HEIGHT) < 1e-5

# %%
# At 400 kN/m² the strip takes a fifth of the width, and the load factor is a fifth lower than without
# crushing:
result.plot()

"""
How much does it matter that stone can crush?
=============================================

A rigid block tips about a sharp edge. Real stone crushes there, and the turning point moves inwards,
until the weight stands on a strip that just bears it.
"""

import masonry_opt as mo

WIDTH, HEIGHT, WEIGHT = 1.0, 4.0, 80.0  # m and kN, for 1 m out of the plane


def pier(strength: float | None) -> mo.Scene:
    """A pier that is pushed sideways at half its height; strength in kN/m²."""
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
# By hand: the weight W stands on a strip of width W / f_c at the edge, so that λ = (b − W / f_c) / h.
for strength in (None, 2000.0, 800.0, 400.0):
    result = mo.solve(pier(strength), "static")
    strip = WEIGHT / strength if strength else 0.0
    print(f"strength {strength}: load factor {result.load_factor:.5f}")
    assert abs(result.required() - (WIDTH - strip) / HEIGHT) < 1e-5

# %%
# At 400 kN/m² a fifth of the width is lost, and a fifth of the load factor with it:
result.plot()

"""
How much thrust does a flying buttress carry?
=============================================

A vault thrusts against the top of a high pier. A flyer, which is a quarter of a circular arch, transfers part
of the thrust to a buttress outside. By how much does the flyer increase the thrust that the pier carries?
"""

import masonry_opt as mo

HEIGHT = 8.0
WIDTH = 1.0
UNIT_WEIGHT = 22.0
THRUST_AT = (6.9, 7.1)  # m above the ground


def pier(flyer: bool) -> mo.Scene:
    """Return a pier under a thrust of 1 kN to the left, alone or with a flyer and its buttress."""
    blocks = mo.Column(name="pier", width=WIDTH, height=HEIGHT, drums=16, unit_weight=UNIT_WEIGHT).blocks()
    if flyer:
        arch = mo.Arch(
            name="flyer",
            at=(0, 4),
            radius=3,
            angles=(180, 90),
            thickness=0.4,
            voussoirs=10,
            unit_weight=UNIT_WEIGHT,
            abutments=False,
        )
        buttress = mo.Column(
            name="buttress", at=(-4, 0), width=1.6, height=4, drums=8, unit_weight=UNIT_WEIGHT
        )
        blocks += [*arch.blocks(), *buttress.blocks()]
    low, high = THRUST_AT
    thrust = mo.EdgeLoad(start=(WIDTH, low), end=(WIDTH, high), force=(-1 / (high - low), 0), kind="live")
    return mo.Scene(
        title="pier and flying buttress",
        joints=mo.JointDefaults(friction=0.7),
        blocks=blocks,
        edge_loads=[thrust],
    )


# %%
# Without the flyer, the pier overturns about its outer edge at W b/2 = λ y, with the weight W and the width b
# of the pier, and the height y of the thrust.
alone = mo.solve(pier(flyer=False))
by_hand = UNIT_WEIGHT * WIDTH * HEIGHT * WIDTH / 2 / 7.0
assert abs(alone.required() / by_hand - 1) < 1e-5

# %%
# With the flyer the pier carries more than two and a half times this thrust:
propped = mo.solve(pier(flyer=True))
print(f"alone {alone.required():.2f} kN, with a flying buttress {propped.required():.2f} kN")
assert propped.required() > 2.5 * alone.required()
propped.plot("thrust")

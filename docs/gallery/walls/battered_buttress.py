"""
How much should a buttress taper?
=================================

A vault thrusts against a buttress. A wide foot increases the resistance to overturning, but stone at the foot
does not press on the joints above, which may slide. Which taper of a given amount of stone carries the
largest thrust?
"""

import masonry_opt as mo

HEIGHT = 4.0
UNIT_WEIGHT = 22.0
FRICTION = 0.75
LOW = 1.5  # m above ground: the vault thrusts against the drum between LOW and HIGH
HIGH = 2.0  # m above ground


def buttress(foot: float, top: float) -> mo.Scene:
    """Return a buttress of drums with a vertical right side, under a thrust of 1 kN to the left."""
    batter = "both" if foot == top else "left"
    drums = mo.Column(
        width=(foot, top), height=HEIGHT, drums=8, batter=batter, unit_weight=UNIT_WEIGHT
    ).blocks()
    thrust = mo.EdgeLoad(start=(foot, LOW), end=(foot, HIGH), force=(-1 / (HIGH - LOW), 0), kind="live")
    return mo.Scene(
        title="buttress", joints=mo.JointDefaults(friction=FRICTION), blocks=drums, edge_loads=[thrust]
    )


def by_hand(foot: float, top: float) -> tuple[float, float]:
    """Return the thrusts in kN at which the buttress overturns, and slides below the loaded drum."""
    sloping = foot - top
    moment = UNIT_WEIGHT * HEIGHT * (top * (foot - top / 2) + sloping**2 / 3)
    width = foot - sloping * LOW / HEIGHT
    above = UNIT_WEIGHT * (width + top) / 2 * (HEIGHT - LOW)
    return moment / ((LOW + HIGH) / 2), FRICTION * above


# %%
# Without taper the buttress overturns, and with a large taper it slides. A taper between both carries the
# largest thrust:
results = {}
for foot, top in ((1.2, 1.2), (1.5, 0.9), (1.8, 0.6)):
    results[foot] = mo.solve(buttress(foot, top))
    overturns, slides = by_hand(foot, top)
    print(
        f"{foot} m to {top} m: {results[foot].required():.2f} kN (turns {overturns:.2f}, slides {slides:.2f})"
    )
    assert abs(results[foot].required() / min(overturns, slides) - 1) < 1e-5
results[1.5].plot()

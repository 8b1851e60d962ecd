"""
How thin may an arch be?
========================

A semicircular arch is stable under its own weight if it contains a line of thrust that its joints can
transmit. The least thickness also depends on friction, and below a certain friction no thickness is enough.
The example repeats Fig. 9 of Gilbert, Casapulla & Ahmed (2006).
"""

import math

from matplotlib.figure import Figure

import masonry_opt as mo

ARCH = {"radius": 10, "angles": (180, 0), "voussoirs": 27, "unit_weight": 1}


def arch(thickness: float, friction: float) -> mo.Scene:
    """Return an arch of 27 voussoirs between abutments, with a centreline radius of 10 m."""
    made = mo.Arch(thickness=thickness, **ARCH)
    return mo.Scene(title="arch", joints=mo.JointDefaults(friction=friction), blocks=made.blocks())


# %%
# ``mo.least`` returns the least thickness and an interval that contains it. At the upper end of the interval
# a state of equilibrium exists. At the lower end a mechanism exists on which the weight does work.
found = mo.least(lambda thickness: arch(thickness, 0.7), 0.5, 3)
print(found)

# %%
# Below a certain friction, an arch of any thickness collapses:
roughly = {"samples": 0, "tolerance": 1e-4}
least_friction = mo.least(lambda mu: arch(10, mu), 0.2, 0.5, **roughly)
print(f"μ = {least_friction.value:.4f}")
assert math.isclose(least_friction.value, 0.31, rel_tol=5e-3)  # the paper: 0.31

# %%
# The least thickness depends on friction. From a friction of 0.4 on the arch collapses by hinges alone, and
# more friction does not reduce the thickness. With less friction joints also slide, and the arch must be
# thicker.
frictions = (0.312, 0.32, 0.335, 0.36, 0.38, 0.4, 0.5, 0.7)
thicknesses = [mo.least(lambda t, mu=mu: arch(t, mu), 0.9, 2.5, **roughly).value for mu in frictions]
figure = Figure(figsize=(6, 3.6), layout="constrained")
axes = figure.add_subplot(xlabel="friction μ = tan φ", ylabel="least thickness (m)", ylim=(0, 2.5))
axes.plot(frictions, thicknesses, "o-", color="#0072B2")
assert math.isclose(thicknesses[-1], 1.068, rel_tol=5e-4)  # the paper: 10.68 % of the radius
figure

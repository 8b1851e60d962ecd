"""
How thin may an arch be?
========================

A semicircular arch stands under its own weight if a line of thrust fits into it. How thick it must be
for that depends on friction as well: below some friction no thickness is enough. This is Fig. 9 of
Gilbert, Casapulla & Ahmed (2006).
"""

import math

from matplotlib.figure import Figure

import masonry_opt as mo

ARCH = {"radius": 10, "angles": (180, 0), "voussoirs": 27, "unit_weight": 1}


def arch(thickness: float, friction: float) -> mo.Scene:
    """27 voussoirs between abutments, centreline radius 10 m."""
    made = mo.Arch(thickness=thickness, **ARCH)
    return mo.Scene(title="arch", joints=mo.JointDefaults(friction=friction), blocks=made.blocks())


# %%
# The least thickness comes with both ends of the interval in which it lies: at one a state of
# equilibrium exists, at the other a mechanism that the weight drives.
found = mo.least(lambda thickness: arch(thickness, 0.7), 0.5, 3)
print(found)

# %%
# Against friction: from 0.4 on the arch hinges, and more friction is of no use. With less it slides as well,
# and must be thicker.
frictions = (0.312, 0.32, 0.335, 0.36, 0.38, 0.4, 0.5, 0.7)
roughly = {"samples": 0, "tolerance": 1e-4}
thicknesses = [mo.least(lambda t, mu=mu: arch(t, mu), 0.9, 2.5, **roughly).value for mu in frictions]
figure = Figure(figsize=(6, 3.6), layout="constrained")
axes = figure.add_subplot(xlabel="friction μ = tan φ", ylabel="least thickness (m)", ylim=(0, 2.5))
axes.plot(frictions, thicknesses, "o-", color="#0072B2")

# %%
# The friction below which the arch falls however thick it is:
least_friction = mo.least(lambda mu: arch(10, mu), 0.2, 0.5, **roughly)
print(f"μ = {least_friction.value:.4f}")
assert math.isclose(thicknesses[-1], 1.068, rel_tol=5e-4)  # the paper's 10.68 % of the radius
assert math.isclose(least_friction.value, 0.31, rel_tol=5e-3)  # the paper's
figure  # noqa: B018

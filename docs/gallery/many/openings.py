"""
Do wide windows or narrow piers weaken a façade?
================================================

A façade with two windows is loaded in its own plane by the weight of each stone, applied sideways. The
windows are one to three blocks wide, the piers have two widths, and the friction is 0.4 or 0.7. Which of
these parameters governs the load factor, and does the façade slide or rock?
"""

from matplotlib.figure import Figure

import masonry_opt as mo


def facade(opening: int, jamb: int, friction: float) -> mo.Scene:
    """Return a façade with two windows, three courses high.

    The outer piers are ``jamb`` blocks wide, and the middle pier is twice as wide.
    """
    bond = mo.Facade(
        openings=(2, 1),
        block=(1.0, 0.5),
        jamb=jamb,
        opening=(opening, 3),
        sill=2,
        spandrel=2,
        unit_weight=20,
        live_per_weight=(1, 0),
    )
    return mo.Scene(title="façade", joints=mo.JointDefaults(friction=friction), blocks=bond.blocks())


# %%
# A function returns the scene for given parameters. Each combination of parameters is one run, and every run
# is certified.
frame = mo.sweep(facade, {"opening": [1, 2, 3], "jamb": [1, 2], "friction": [0.4, 0.7]}, workers=1)
frame[["opening", "jamb", "friction", "load_factor", "status", "mechanism"]].round(4)

# %%
# The width of the piers governs. Wider windows increase the load factor slightly, because they remove stones
# and their live load. With a friction of 0.4 and wide piers the whole façade slides, and the load factor
# equals the friction coefficient.
figure = Figure(figsize=(6, 3.6), layout="constrained")
axes = figure.add_subplot(xlabel="width of a window (blocks)", ylabel="load factor λ", xticks=[1, 2, 3])
for (jamb, friction), runs in frame.groupby(["jamb", "friction"]):
    label = f"outer piers of {jamb:g} block{'s' if jamb > 1 else ''}, μ = {friction}"
    axes.plot(runs["opening"], runs["load_factor"], "o-" if jamb == 1 else "s--", label=label)
axes.set_ylim(0, 0.65)
axes.legend(frameon=False)
slides = frame["mechanism"] == "sliding"
assert (frame["load_factor"] - frame["friction"])[slides].abs().max() < 1e-6
assert slides.sum() == 3
by_jamb = frame.pivot(index=["opening", "friction"], columns="jamb", values="load_factor")
assert (by_jamb[2] > by_jamb[1]).all()
figure

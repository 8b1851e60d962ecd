"""
Do wide windows or narrow piers weaken a façade?
================================================

A façade of two windows is pushed in its own plane, each stone by its weight. Windows of one to three blocks,
piers of two widths, friction of 0.4 and 0.7: what decides, and is it by sliding or by rocking?
"""

from matplotlib.figure import Figure

import masonry_opt as mo


def facade(opening: int, jamb: int, friction: float) -> mo.Scene:
    """Two windows, three courses high; outer piers ``jamb`` blocks wide, the one between twice that."""
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
# The scene is a function of what varies; every combination is one run, certified like any other.
frame = mo.sweep(facade, {"opening": [1, 2, 3], "jamb": [1, 2], "friction": [0.4, 0.7]}, workers=1)
frame[["opening", "jamb", "friction", "load_factor", "status", "mechanism"]].round(4)

# %%
# Piers decide. Wider windows even help a little: they take away stones, which would push. Where friction is
# 0.4 and piers are wide everything slides, at a load factor that is the friction itself.
figure = Figure(figsize=(6, 3.6), layout="constrained")
axes = figure.add_subplot(xlabel="width of a window (blocks)", ylabel="load factor λ", xticks=[1, 2, 3])
for (jamb, friction), runs in frame.groupby(["jamb", "friction"]):
    label = f"outer piers of {jamb} block{'s' if jamb > 1 else ''}, μ = {friction}"
    axes.plot(runs["opening"], runs["load_factor"], "o-" if jamb == 1 else "s--", label=label)
axes.set_ylim(0)
axes.legend(frameon=False)
slides = frame["mechanism"] == "sliding"
assert (frame["load_factor"] - frame["friction"])[slides].abs().max() < 1e-6
assert slides.sum() == 3
by_jamb = frame.pivot(index=["opening", "friction"], columns="jamb", values="load_factor")
assert (by_jamb[2] > by_jamb[1]).all()
figure  # noqa: B018

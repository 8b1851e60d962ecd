"""
Fig. 9: the least thickness of a semicircular arch
==================================================

The arch has 27 voussoirs and a centreline radius of 10 m, and is loaded by its own weight (section 5.2). It
collapses in one of three modes:

- mode I, by hinges alone, if friction is above 0.396
- mode II, by hinges and sliding, if friction is between 0.31 and 0.396
- mode III, by sliding alone, if friction is below 0.31; an arch of any thickness is then unstable

Cocchetti & Rizzi (2020, doi 10.3221/IGF-ESIS.51.26) give the limits for many voussoirs.

The guide does not run this example. ``masonry-opt reproduce fig9`` saves its tables and pictures.
"""

import math

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

KNOWN = mo.load(case_folder() / "casapulla_lauro" / "arch.toml").reference
ARCH = mo.Arch(radius=10, angles=(180, 0), thickness=1, voussoirs=27, unit_weight=1)
FRICTIONS = (0.32, 0.33, 0.34, 0.35, 0.36, 0.37, 0.38, 0.39, 0.4, 0.45, 0.5, 0.6, 0.8)


def scene(arch: mo.Arch, friction: float, thickness: float | None = None) -> mo.Scene:
    """Return the scene of an arch, with another thickness if ``thickness`` is not None."""
    made = arch if thickness is None else arch.replace(thickness=thickness)
    return mo.Scene(title="arch", joints=mo.JointDefaults(friction=friction), blocks=made.blocks())


def thinnest(arch: mo.Arch, friction: float):
    """Return the least thickness at which the arch is stable, and an interval that contains it."""
    return mo.least(lambda t: scene(arch, friction, t), 0.01, 19.9, tolerance=1e-6, samples=0)


def transitions(arch: mo.Arch) -> tuple[float, float, float]:
    """Return the least thickness in mode I, and μ at the transitions from mode I to II and from II to III.

    At the least thickness in mode I the thrust line is unique, and mode I requires |s| ≤ μ n in every joint.
    The work of the weight on a sliding mechanism is proportional to the thickness. Its sign can therefore be
    determined for a thick arch, whose thickness equals its radius.
    """
    hinged = thinnest(arch, math.inf)
    forces = hinged.holds.result.joints
    thick = arch.replace(thickness=arch.radius)
    slides = mo.least(lambda mu: scene(thick, mu), 1e-3, 1.0, tolerance=1e-6, samples=0)
    return hinged.value, float((forces["s"].abs() / forces["n"]).max()), slides.value


def opened(friction: float, thickness: float) -> mo.Scene:
    """Return the arch under an outward pressure as live load, applied as one point load per voussoir.

    The pressure reduces the normal force of every joint by the weight of one voussoir. The load factor is the
    margin of stability.
    """
    step = math.pi / ARCH.voussoirs
    outward = 2 * math.sin(step / 2) * step * ARCH.radius * thickness
    angles = [math.pi - step * (number + 0.5) for number in range(ARCH.voussoirs)]
    loads = [
        mo.PointLoad(voussoir=number, force=(outward * math.cos(angle), outward * math.sin(angle)))
        for number, angle in enumerate(angles, start=1)
    ]
    return scene(ARCH.replace(point_loads=loads), friction, thickness)


# %%
# The table lists the transitions between the modes. They are also computed with the weights of voussoirs with
# straight edges, and for 501 voussoirs whose weights act on the centreline, as in Cocchetti & Rizzi.
hinging, one_to_two, two_to_three = transitions(ARCH)
straight = transitions(ARCH.replace(weights="straight"))
many = transitions(ARCH.replace(weights="centreline", voussoirs=501))
checks = [
    ("least thickness (m), mode I", KNOWN["least_thickness"].value, hinging, 5e-4),
    ("the same, annular sectors", KNOWN["least_thickness_sector"].value, hinging, 5e-6),
    ("the same, straight edges", KNOWN["least_thickness_straight"].value, straight[0], 5e-5),
    ("μ from mode I to II", KNOWN["mode_I_to_II"].value, one_to_two, 5e-3),
    ("μ from mode II to III", KNOWN["mode_II_to_III"].value, two_to_three, 5e-3),
    ("least thickness (m), 501 voussoirs", 1.07426, many[0], 1e-4),
    ("μ from mode I to II, 501 voussoirs", 0.395832, many[1], 1e-4),
    ("μ from mode II to III, 501 voussoirs", 0.309215, many[2], 1e-5),
]
table_transitions = pd.DataFrame(checks, columns=["what", "published", "ours", "tolerance"])
print(table_transitions.to_string(index=False, float_format="{:.6g}".format))
missed = table_transitions.query("abs(ours / published - 1) > tolerance")
assert missed.empty, missed

# %%
# The next table contains the least thickness for each friction. Below the least thickness no state of
# equilibrium exists under any flow rule. At 5 % above it, exact Coulomb states have the same margin as
# associative flow, so Coulomb's flow rule does not change the curve.
rows = []
for mu in sorted([*FRICTIONS, two_to_three + 1e-4, one_to_two - 1e-4, one_to_two + 1e-4]):
    found = thinnest(ARCH, mu)
    moving = found.fails.result.joints
    slip, turn = moving["slip"].abs().max(), (moving["rotation"].abs() * moving["length"] / 2).max()
    thicker = opened(mu, 1.05 * found.value)
    margins = [mo.solve(thicker, method, incremental=False).load_factor for method in ("static", "coulomb")]
    mode = "I" if slip < 1e-5 * turn else "II" if turn > 1e-5 * slip else "III"
    rows.append((mu, mode, found.value, found.value / ARCH.radius, *margins))
names = ["μ", "mode", "thickness (m)", "over radius", "margin, associative", "margin, Coulomb"]
table = pd.DataFrame(rows, columns=names)
print(table.to_string(index=False, float_format="{:.6g}".format))
assert (table["mode"] == np.where(table["μ"] > one_to_two, "I", "II")).all()
mixed = table[table["μ"] > 0.31]  # in pure sliding the pressure does no work
assert (mixed["margin, Coulomb"] / mixed["margin, associative"] - 1).abs().max() < 1e-6
falls = [mo.solve(opened(mu, 19.9), "static").status for mu in (0.2, 0.3, two_to_three - 1e-4)]
assert set(falls) == {mo.Status.UNSTABLE}

# %%
# The diagram shows the least thickness over friction, and the pictures show the three modes.
figure = Figure(figsize=(7, 4.2), layout="constrained")
axes = figure.add_subplot(xlabel="friction μ = tan φ", ylabel="least thickness (m)", xlim=(0.2, 0.8))
for mode, text in (("II", "mode II: mixed"), ("I", f"mode I: hinging, μ > {one_to_two:.4f}")):
    part = table[table["mode"] == mode]
    axes.plot(part["μ"], part["thickness (m)"], "o-", markersize=3.5, label=text)
thickest, text = table["thickness (m)"].max(), f"mode III: sliding, μ = {two_to_three:.4f}"
axes.plot([two_to_three] * 2, [thickest, 5], label=text)
axes.axvspan(0.2, two_to_three, color="#EEEEEE", zorder=0, label="unstable at every thickness")
axes.set_ylim(0, 5)
axes.secondary_yaxis("right", functions=(lambda t: 10 * t, lambda t: t / 10)).set_ylabel("% of the radius")
axes.legend()

# The pressure does no work in pure sliding, so mode III is computed with a load on the crown.
loop = {"method": "nonassociative", "incremental": False, "always": True}
figure_mode_i = mo.solve(opened(0.5, 1.0002 * hinging), **loop).plot()
figure_mode_ii = mo.solve(opened(0.35, 1.05 * thinnest(ARCH, 0.35).value), "nonassociative").plot()
crown, rougher = mo.PointLoad(voussoir=14, force=(0, -1)), two_to_three + 0.005
pushed = ARCH.replace(point_loads=[crown], thickness=1.1 * thinnest(ARCH, rougher).value)
sliding = mo.solve(scene(pushed, rougher), **loop)
figure_mode_iii = sliding.plot()
assert sliding.joints["rotation"].abs().max() < 1e-5 * sliding.joints["slip"].abs().max()
figure

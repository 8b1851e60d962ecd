"""
Fig. 6: two blocks, and the jump of the load factor with the angle of dilatancy
===============================================================================

The example compares computed load factors with a closed form. The face between A and B rises at the angle ψ
in the direction in which A is pushed. B has weight 1 in the middle of its span (0 ≤ x ≤ 3), and rests on a
rough support that is collinear with the face.

A moves by (1, tan φ₀). B rotates about one end of its support and touches A at one end of the face. If B
rises, it rotates about x = 0 and touches A at x = 2. If B sinks, it rotates about x = 1 and touches A at x =
3.

The shear force of the face passes through the hinge. Moments about the hinge therefore give the normal force
n = κ cos ψ, with κ = 1.5 / 2 if B rises and 0.5 / 2 if B sinks. The face acts on A with the force
n (cos ψ + μ sin ψ) downwards and n (μ cos ψ - sin ψ) against the motion::

    λ = μ (1 + n (cos ψ + μ sin ψ)) + n (μ cos ψ - sin ψ) = μ + κ cos² ψ (2 μ - (1 - μ²) tan ψ)

For ψ = 0 this gives 2.5 μ and 1.5 μ. With t = tan φ₀, the contact point of B moves along the normal of the
face by 2 t cos ψ - (1 - t²) sin ψ. This is the opening of the face due to its slip, plus the motion of A
along the normal. It changes its sign where tan 2φ₀ = tan ψ, so the load factor jumps at φ₀ = ψ / 2 (footnote
2 of the paper).

The guide does not run this example. ``masonry-opt reproduce fig6`` saves its tables and pictures.
"""

# sphinx_gallery_thumbnail_path = "fig6.png"

from math import atan, cos, degrees, radians, tan

import pandas as pd
from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.drawing.pictures import draw_mechanism
from masonry_opt.scene.case_file import case_folder

MU = 0.1
#: The case file and the angle ψ of the face in degrees, by the name of the variant.
VARIANTS = {
    "flat": ("two_blocks", 0.0),
    "contracting wedge": ("wedge_blocks", 4.0),
    "expanding wedge": ("wedge_blocks_expanding", -4.0),
}
ANGLES = (-5, -4, -3, -2.5, -1.5, -1, -0.5, 0.5, 1, 1.5, 2.5, 3, 4, 5)
SCENES = {name: mo.load(case_folder() / "gilbert" / f"{file}.toml") for name, (file, _) in VARIANTS.items()}


def by_hand(face: float, rises: bool) -> float:
    """Return λ by the closed form for a face at the angle ψ in degrees, if B rises or sinks."""
    psi, kappa = radians(face), 0.75 if rises else 0.25
    return MU + kappa * cos(psi) ** 2 * (2 * MU - (1 - MU**2) * tan(psi))


def dilatant(name: str, angle: float) -> mo.Scene:
    """Return the variant with one angle of dilatancy, in degrees, in every joint except the rough joint."""
    joints = mo.JointDefaults(friction=MU, dilatancy=tan(radians(angle)))
    return SCENES[name].replace(joints=joints)


def least(name: str, angle: float) -> mo.Result:
    """Return the result of method ``global`` for a variant and an angle of dilatancy in degrees."""
    return mo.solve(dilatant(name, angle), "global", incremental=False)


def jump(name: str, face: float) -> float:
    """Return the angle of dilatancy at which the least λ jumps, by bisection to 0.0005°."""
    low, high = max(a for a in ANGLES if a < face / 2), min(a for a in ANGLES if a > face / 2)
    between = (by_hand(face, False) + by_hand(face, True)) / 2
    for _ in range(11):
        middle = (low + high) / 2
        low, high = (low, middle) if least(name, middle).required() > between else (middle, high)
    return (low + high) / 2


# %%
# At every angle, λ is computed by hand, by method ``global``, and by the paper's loop.
table = pd.DataFrame(
    {
        "variant": name,
        "φ₀ (°)": angle,
        "by hand": by_hand(face, rises=angle > face / 2),
        "least λ": (found := least(name, angle)).required(),
        "proven": found.status is mo.Status.OPTIMAL,
        "loop": mo.solve(
            dilatant(name, angle), "nonassociative", preset="paper", incremental=False
        ).required(),
    }
    for name, (_, face) in VARIANTS.items()
    for angle in ANGLES
)
table_jump = pd.DataFrame(
    {"variant": name, "face ψ (°)": face, "published jump (°)": face / 2, "jump (°)": jump(name, face)}
    for name, (_, face) in VARIANTS.items()
)
print(table.to_string(index=False), table_jump.to_string(index=False), sep="\n\n")
assert table.loc[table["φ₀ (°)"] >= 0, "proven"].all()  # if joints do not contract
assert (table["least λ"] / table["by hand"] - 1).abs().max() < 1e-8  # case files have twelve digits
assert (table["loop"] / table["by hand"] - 1).abs().max() < 1e-5  # tolerance of the loop
assert (table_jump["jump (°)"] - table_jump["published jump (°)"]).abs().max() < 7e-4
for name, (_, face) in VARIANTS.items():
    assert abs(mo.solve(SCENES[name], "static").required() / by_hand(face, rises=True) - 1) < 1e-6

# %%
# In (b) A slides and lifts B, and in (c) B sinks. The lower diagrams show the load factor over φ₀.
figure = Figure(figsize=(8, 5.6), layout="constrained")
above, below = figure.subfigures(2, 1, height_ratios=[1, 2])
mechanisms = {
    "(b) φ₀ = φ: expands": mo.solve(SCENES["flat"], "static"),
    "(c) φ₀ = -5°: contracts": mo.solve(dilatant("flat", -5), "global"),
    "ψ = 4°, φ₀ = 0: contracts": mo.solve(SCENES["contracting wedge"], "global"),
}
for axes, (title, result) in zip(above.subplots(1, 3), mechanisms.items(), strict=True):
    draw_mechanism(result, axes)
    axes.set_title(f"{title}\nλ = {result.required() / MU:.4g} μ", fontsize=10)
    axes.set_axis_off()
    for x, y, block in result.blocks[["x", "y", "block"]].itertuples(index=False):
        axes.annotate(block, (x, y), ha="center", va="center")
for axes, (name, (_, face)) in zip(below.subplots(1, 3, sharey=True), VARIANTS.items(), strict=True):
    low, high, limit = by_hand(face, False) / MU, by_hand(face, True) / MU, degrees(atan(MU))
    axes.plot([-limit, face / 2, face / 2, limit], [low, low, high, high], color="#777777", label="by hand")
    points = table[table["variant"] == name]
    axes.plot(points["φ₀ (°)"], points["least λ"] / MU, "o", color="#0072B2", label="least λ")
    axes.plot(points["φ₀ (°)"], points["loop"] / MU, ".", color="#E69F00", label="loop")
    axes.axvline(face / 2, color="#D55E00", linewidth=1, linestyle="--", zorder=0, label="φ₀ = ψ / 2")
    axes.annotate(f"{low:.4g} μ", (-limit, low), xytext=(0, 7), textcoords="offset points")
    axes.annotate(f"{high:.4g} μ", (limit, high), xytext=(0, 7), textcoords="offset points", ha="right")
    axes.set(xlabel="dilatancy φ₀ (°)", ylim=(1, 3.3), xticks=[-4, -2, 0, 2, 4])
    axes.set_title(f"{name}, ψ = {face:g}°", fontsize=10)
    axes.grid(color="#EEEEEE")
below.axes[0].set_ylabel("load factor λ / μ")
below.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
figure

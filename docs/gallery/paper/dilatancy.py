"""
Section 6.5: dilatancy that decreases with normal stress
========================================================

A joint has its full dilatancy up to half of a stress σ₀, and no dilatancy above σ₀ (``none`` in the code).

By hand, for the two blocks of Fig. 6: the joint between A and B has length 1 and normal force n. The joint
below A has length 3 and normal force 1 + n. The load factor is λ = μ (1 + 2 n).

- B rises, with n = 0.75, if one of both joints dilates.
- B sinks, with n = 0.25, only if both joints contract.
- B is at rest, with any n in between, if neither joint dilates: if n and (1 + n) / 3 are at least σ₀.

The least n is therefore max(σ₀, 3 σ₀ - 1), but at least 0.25 and at most 0.75. The load factor does not jump
as it does at φ₀ = 0 with constant dilatancy. It increases continuously from σ₀ = 0.25 to σ₀ = 1.75 / 3.

The guide does not run this example. ``masonry-opt reproduce dilatancy`` saves its tables and pictures.
"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

BLOCKS = mo.load(case_folder() / "gilbert" / "two_blocks.toml")
WALL = mo.load(case_folder() / "ferris_tinloi" / "wall_1.toml")
#: Values of the stress σ₀ above which joints do not dilate, in block weights per unit of length.
LEVELS = (1e-4, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.55, 0.7, 1, 2, 3, 10, 100)
#: Scenes by name, each with the dilatancy at low stress and the least σ₀ of its sweep. Real joints dilate
#: little, hence 0.05. With a dilatancy of μ, the loop finds no answer if σ₀ is below 0.5. Its runs without an
#: answer take hundreds of sub-problems, so the sweep starts at 0.3.
SWEEPS = {
    "two blocks": (BLOCKS, 0.1, 0.0),
    "wall 1, dilatancy 0.05": (WALL, 0.05, 0.0),
    "wall 1, dilatancy μ": (WALL, 0.65, 0.3),
}


def with_joints(scene: mo.Scene, **properties) -> mo.Scene:
    """Return the scene with new default properties of joints; exceptions of single joints remain."""
    return scene.replace(joints=properties)


def by_hand(none: float) -> float:
    """Return the least load factor of the two blocks if joints do not dilate above the stress ``none``."""
    return 0.1 * (1 + 2 * min(max(none, 3 * none - 1, 0.25), 0.75))


# %%
# The loop is compared with its two limits: no dilatancy, and the same dilatancy at any stress. Where the
# dilatancy changes with stress, the loop may find no answer. A joint that dilates attracts force, so that it
# stops dilating and loses the force again, and the iterations do not converge. If the loop finds an answer,
# its λ need not be the least.
limits = {
    name: (
        mo.solve(scene, "nonassociative", incremental=False),
        mo.solve(with_joints(scene, dilatancy=most), "nonassociative", incremental=False),
    )
    for name, (scene, most, _) in SWEEPS.items()
}
rows = []
for name, (scene, most, least) in SWEEPS.items():
    for none in (level for level in LEVELS if level >= least):
        law = with_joints(scene, dilatancy=most, dilatancy_stress=(none / 2, none))
        result = mo.solve(law, "nonassociative", incremental=False)
        hand = by_hand(none) if name == "two blocks" else None
        flow = result.certificate.flow if result.load_factor else None
        rows.append((name, none, hand, result.load_factor, len(result.history), flow, str(result.status)))
columns = ["scene", "none from", "by hand", "λ", "sub-problems", "flow", "status"]
table = pd.DataFrame(rows, columns=columns)
print(table.to_string(index=False))
for name, of in table.groupby("scene"):
    low, high = (limit.required() for limit in limits[name])
    found = of["λ"].dropna()
    assert abs(of["λ"].iloc[-1] / high - 1) < 1e-3, name
    # A joint without any force dilates for every σ₀ > 0, so that λ of the wall stays above that of Coulomb
    # friction.
    assert ((1 - 1e-3) * low < found).all(), name
    assert (found < (1 + 1e-3) * high).all(), name
    assert found.diff().dropna().min() > -1e-3 * high, name  # λ increases with σ₀
blocks = table[table["scene"] == "two blocks"].dropna(subset="λ")
assert abs(blocks["λ"].iloc[0] / limits["two blocks"][0].required() - 1) < 1e-3
assert (blocks["λ"] > blocks["by hand"] * (1 - 1e-3)).all()  # the value by hand is the least load factor
assert ((blocks["λ"] / blocks["by hand"] - 1).abs() < 1e-3).sum() >= 10
assert table["flow"].max() < 1e-2

# %%
# The dashed line is λ without dilatancy, the dotted line is λ with the same dilatancy at any stress, and a
# cross marks a run without an answer.
figure = Figure(figsize=(8, 9), layout="constrained")
for axes, (name, (lower, upper)) in zip(figure.subplots(3, 1, sharex=True), limits.items(), strict=True):
    of = table[table["scene"] == name]
    axes.semilogx(of["none from"], of["λ"], "o", color="#0072B2", label="loop")
    axes.axhline(lower.required(), color="black", linewidth=1, linestyle="--", label="Coulomb")
    axes.axhline(upper.required(), color="black", linewidth=1, linestyle=":", label="at any stress")
    if name == "two blocks":
        stress = np.geomspace(LEVELS[0], LEVELS[-1], 2000)
        axes.plot(stress, [by_hand(none) for none in stress], color="#777777", label="by hand: the least")
    missing = of.loc[of["λ"].isna(), "none from"]
    axes.plot(missing, [lower.required()] * len(missing), "x", color="#D55E00", label="no answer")
    axes.set_title(name, loc="left", fontsize=10)
    axes.set_ylabel("load factor λ")
    axes.legend(fontsize=8, loc="center right")
axes.set_xlabel("stress at which dilatancy vanishes (block weights per unit of length)")
figure

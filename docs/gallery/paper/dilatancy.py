"""
Section 6.5: dilatancy that falls with normal stress
====================================================

Dilatancy is whole up to half of a stress "none", and gone from none on. Two blocks by hand: in the face
between A and B (length 1, normal force n) and under A (length 3, normal force 1 + n), λ = μ (1 + 2 n). B
rises, n = 0.75, while either dilates; it sinks, n = 0.25, only if both contract; it rests, with any n in
between, where neither does: where n and (1 + n) / 3 are at least none. The least is
n = max(none, 3 none - 1), but at least 0.25 and at most 0.75: what was a jump at φ₀ = 0 is a rise from
none = 0.25 to none = 1.75 / 3.
"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

BLOCKS = mo.load(case_folder() / "gilbert" / "two_blocks.toml")
WALL = mo.load(case_folder() / "ferris_tinloi" / "wall_1.toml")
#: Block weights per unit of length.
LEVELS = (1e-4, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.55, 0.7, 1, 2, 3, 10, 100)
#: Real joints dilate little: 0.05, beside a dilatancy of friction's 0.65.
SWEEPS = {
    "two blocks": (BLOCKS, 0.1),
    "wall 1, dilatancy 0.05": (WALL, 0.05),
    "wall 1, dilatancy μ": (WALL, 0.65),
}


def with_joints(scene: mo.Scene, **properties) -> mo.Scene:
    """The scene with other properties in all joints that have none of their own."""
    return scene.replace(joints=properties)


def by_hand(none: float) -> float:
    """Least load factor of the two blocks."""
    return 0.1 * (1 + 2 * min(max(none, 3 * none - 1, 0.25), 0.75))


# %%
# The loop, and its two limits: no dilatancy, and the same at any stress. Where the law is neither whole nor
# zero, the loop may find no answer: a joint that dilates takes up force and so stops dilating, then loses it
# again, and no blend settles between. Where it finds one λ need not be the least.
limits = {
    name: (
        mo.solve(scene, "nonassociative", incremental=False),
        mo.solve(with_joints(scene, dilatancy=most), "nonassociative", incremental=False),
    )
    for name, (scene, most) in SWEEPS.items()
}
rows = []
for name, (scene, most) in SWEEPS.items():
    for none in LEVELS:
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
    # A joint without any force dilates, however low the level: on the wall λ stays above Coulomb's.
    assert ((1 - 1e-3) * low < found).all(), name
    assert (found < (1 + 1e-3) * high).all(), name
    assert found.diff().dropna().min() > -1e-3 * high, name  # rises with the stress
blocks = table[table["scene"] == "two blocks"].dropna(subset="λ")
assert abs(blocks["λ"].iloc[0] / limits["two blocks"][0].required() - 1) < 1e-3
assert (blocks["λ"] > blocks["by hand"] * (1 - 1e-3)).all()  # by hand: the least
assert ((blocks["λ"] / blocks["by hand"] - 1).abs() < 1e-3).sum() >= 10
assert table["flow"].max() < 1e-2

# %%
# Dashed: no dilatancy; dotted: the same at any stress; a cross: no answer.
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
figure  # noqa: B018

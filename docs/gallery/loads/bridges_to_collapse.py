"""
How do load tests of bridges compare with limit analysis?
=========================================================

Five arch bridges were loaded to collapse by a line load across the road, at a quarter of the span. Which
fraction of the collapse load does limit analysis compute, if more and more effects of the fill are included?
"""

from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

NAMES = ["hendry_davies_royles/bridgemill"]
NAMES += [f"page/{name}" for name in ("prestwood", "torksey", "shinafoot", "strathmashie")]


def under_line_load(scene: mo.Scene) -> mo.Scene:
    """Return a bridge under the load of its test, which is an axle at a fixed position, spread by the fill.

    The road of the axle is a tenth of a millimetre long. ``mo.crossing`` puts the load on the blocks.
    """
    (x, _), (_, top) = scene.loads[0].at, scene.fills[0].road[0]
    test = scene.reference["collapse_load"].value
    line = mo.Axles(name="line", loads=[test], road=[(x - 5e-5, top), (x + 5e-5, top)])
    return mo.crossing(scene.replace(loads=[]), line, method="static").worst.assembly.scene


def ratio(loaded: mo.Scene, strength: float | None = None, **fill: object) -> float:
    """Return the computed collapse load divided by that of the test, with associative flow."""
    joints = mo.JointDefaults(friction_angle=33, strength=strength)
    made = loaded.replace(joints=joints, fills=[loaded.fills[0].replace(**fill)])
    return mo.solve(made, "static").required()


scenes = {name.split("/")[1]: under_line_load(mo.load(case_folder() / f"{name}.toml")) for name in NAMES}
counted_on = {
    "weight and load spread of the fill": {"pressure": False},
    "also a third of its passive pressure": {},
    "also its full passive pressure": {"mobilised": 1.0},
    "a third; masonry crushes at 5 N/mm²": {"strength": 5000.0},
}
found = {words: [ratio(scene, **keys) for scene in scenes.values()] for words, keys in counted_on.items()}
print(", ".join(scenes))
for words, ratios in found.items():
    print(f"{words}: {', '.join(f'{ratio:.2f}' for ratio in ratios)}")

# %%
# More passive pressure increases the computed load, and crushing of the masonry reduces it. No choice fits
# all five bridges. The behaviour of the soil, the contribution of spandrels and backing, and the condition of
# the rings are not known.
weight, third, full, crushing = found.values()
assert all(a < b < c for a, b, c in zip(weight, third, full, strict=True))
assert all(a < b for a, b in zip(crushing, third, strict=True))
assert min(third) < 0.6
assert max(third) > 1.9

# %%
# The picture shows the computed load divided by the load of the test. If the ratio is above 1, limit analysis
# overestimates the collapse load of the bridge.
figure = Figure(figsize=(7, 3.2), layout="constrained")
axes = figure.subplots()
for (words, ratios), marker in zip(found.items(), ["v", "s", "^", "x"], strict=True):
    axes.plot(ratios, [name.capitalize() for name in scenes], marker, label=words)
axes.axvline(1, color="0.4", linewidth=1)
axes.set(xlim=(0, None), xlabel="computed load / load of the test")
axes.margins(y=0.12)
axes.invert_yaxis()
axes.legend(fontsize="small")
figure

"""
Which acceleration does an assembly from COMPAS withstand?
==========================================================

Users of COMPAS have their blocks as an assembly in a JSON file. The example reads an assembly of a vault with
seven voussoirs in its section, and computes the acceleration along the span at which the vault collapses. It
then writes the assembly with the forces at its interfaces. For the section of the vault, Oppenheim (1992,
*The masonry arch as a four-link mechanism under base motion*) gives 0.37 g.
"""

import json
from math import radians, sin
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import masonry_opt as mo

folder = TemporaryDirectory()
path, solved = Path(folder.name, "vault.json"), Path(folder.name, "solved.json")

# %%
# The example writes its own input file: an assembly of compas_assembly whose abutments have the attribute
# ``is_support``.
keys = {"radius": 10, "angles": (168.75, 11.25), "thickness": 1.5, "voussoirs": 7}
vault = mo.Barrel(**keys, length=4, stone=2, unit_weight=1)
written = mo.export(mo.Scene(joints=mo.JointDefaults(friction=0.75), blocks=vault.blocks()), path)

# %%
# Friction, unit weight and live load are arguments. A live load with three components makes a scene in space.
# Voussoirs of a solid vault have straight edges, so that their weights differ slightly from those of
# Oppenheim's curved ring. The load factor equals that of a plane arch with the weights of straight voussoirs,
# and is within 1 % of Oppenheim's value.
scene = mo.read_compas(path, friction=0.75, unit_weight=1, live=(1, 0, 0))
result = mo.solve(scene)
print(result.summary.split("\n", 1)[1])  # without the path of the file
arch = mo.Arch(**keys, weights="straight", unit_weight=1, live_per_weight=(1, 0)).blocks()
straight = mo.solve(mo.Scene(joints=mo.JointDefaults(friction=0.75), blocks=arch), "static").required()
assert abs(result.required() - straight) < 1e-6
assert abs(result.required() / 0.37 - 1) < 0.01

# %%
# The exported assembly has forces at each contact point of an interface. They act on the first block of the
# interface, along the axes of the interface. The resultant of the abutments balances λ times the weight
# horizontally, and the weight vertically.
mo.export(result, solved)
pushed = np.zeros(3)
for first, others in json.loads(solved.read_text())["data"]["graph"]["data"]["edge"].items():
    for second, interfaces in others.items():
        on_supports = ("abutment" in second) - ("abutment" in first)
        for interface in (each["data"] for each in interfaces["interfaces"]):
            x, y = (np.array(interface["frame"]["data"][axis]) for axis in ("xaxis", "yaxis"))
            for force in interface["forces"]:
                normal = (force["c_np"] - force["c_nn"]) * np.cross(x, y)
                pushed += on_supports * (normal + force["c_u"] * x + force["c_v"] * y)
weight = 7 * sin(radians(157.5 / 7)) * (10.75**2 - 9.25**2) / 2 * 4
print(f"forces of the abutments: {pushed.round(3)}, weight {weight:.3f}")
assert np.allclose(pushed, [-result.required() * weight, 0, weight], atol=1e-4)
result.plot(view=(-70, 20))

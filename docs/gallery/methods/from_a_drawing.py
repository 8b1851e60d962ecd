"""
Can a wall be read from a drawing?
==================================

A survey is often a DXF file with the outline of every stone. The example writes a wall to a DXF file and
reads the file. The load factor of the scene that was read equals the load factor of the original scene.
"""

import tempfile
from pathlib import Path

import masonry_opt as mo

bond = mo.Wall(
    block=(0.6, 0.3), unit_weight=20, live_per_weight=(1, 0), courses=[[0.5, 1, 0.5], [1, 1]], repeat=2
)
typed = mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=bond.blocks())

# %%
# A drawing contains the shapes of stones and supports; shapes on a layer named "fixed" are supports.
# Friction, unit weight and live load are arguments of ``mo.read_dxf``. The live load is a multiple of each
# stone's weight.
with tempfile.TemporaryDirectory() as folder:
    drawing = Path(folder, "wall.dxf")
    mo.write_dxf(typed, drawing)
    read = mo.read_dxf(drawing, friction=0.6, unit_weight=20, live=(1, 0))
print(f"{len(read.blocks)} stones and supports: {', '.join(block.name for block in read.blocks[:4])}, ...")

# %%
# Both scenes have the same load factor:
result = mo.solve(read)
print(f"load factor {result.required():.6f}")
assert abs(result.required() / mo.solve(typed).required() - 1) < 1e-6
result.plot()

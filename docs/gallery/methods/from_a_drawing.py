"""
Can a wall be read from a drawing?
==================================

A survey often is a DXF file with the outline of every stone. Here a wall is drawn, read back from the
drawing, and gives the same load factor.
"""

import tempfile
from pathlib import Path

import masonry_opt as mo

bond = mo.Wall(
    block=(0.6, 0.3), unit_weight=20, live_per_weight=(1, 0), courses=[[0.5, 1, 0.5], [1, 1]], repeat=2
)
typed = mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=bond.blocks())

# %%
# A drawing has shapes and supports (what is on a layer named "fixed"); friction, unit weight and live
# load, as a multiple of each stone's weight, are given beside it.
with tempfile.TemporaryDirectory() as folder:
    drawing = Path(folder, "wall.dxf")
    mo.write_dxf(typed, drawing)
    read = mo.read_dxf(drawing, friction=0.6, unit_weight=20, live=(1, 0))
print(f"{len(read.blocks)} stones and supports: {', '.join(block.name for block in read.blocks[:4])}, ...")

# %%
result = mo.solve(read)
print(f"load factor {result.required():.6f}")
assert abs(result.required() / mo.solve(typed).required() - 1) < 1e-6
result.plot()

"""
Can I use my own solver?
========================

The program of a method can be written to a file, or built as a model of Pyomo. In this example HiGHS computes
the associative load factor of a wall (0.64286; Ferris & Tin-Loi 2001) from a file and from a model. Both
times HiGHS is called directly, not through this package.
"""

import tempfile
from pathlib import Path

import highspy
import pyomo.environ as pyo

import masonry_opt as mo
from masonry_opt.models.pyomo_static import PyomoStatic
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import ShearLimits

bond = mo.Wall(
    block=(4, 1.75),
    weight=1,
    live_per_weight=(1, 0),
    courses=["halves", "whole"],
    repeat=3,
    course={"halves": [0.5, 1, 1, 1, 1, 0.5], "whole": [1, 1, 1, 1, 1]},
)
scene = mo.Scene(
    title="wall 1 of Ferris & Tin-Loi", joints=mo.JointDefaults(friction=0.65), blocks=bond.blocks()
)

# %%
# First from a file in the format LP, MPS or NL. Rows and columns are named after joints and blocks. The
# column of λ is named ``load_factor``.
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "wall.lp")
    mo.export(scene, file, method="static")
    highs = highspy.Highs()
    highs.silent()
    highs.readModel(str(file))
highs.run()
_, column = highs.getColByName("load_factor")
by_file = highs.getSolution().col_value[column]

# %%
# Then from a model, with any solver that Pyomo supports:
problem = assemble(scene).problem
program = PyomoStatic(problem, ShearLimits.true(problem)).program
pyo.SolverFactory("appsi_highs").solve(program)
by_model = pyo.value(program.load_factor)
print(f"by file {by_file:.5f}, by model {by_model:.5f}")
assert abs(by_file - 0.64286) < 1e-5
assert abs(by_model - by_file) < 1e-7
mo.solve(scene, "static", solver="highs").plot()

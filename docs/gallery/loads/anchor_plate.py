"""
What is an anchor plate for?
============================

A tie anchors the outer leaf of a wall. If the tie ends in one stone, it holds this stone only, and other
stones may slide off. An anchor plate spreads the force of the tie over several stones. In the model a plate
is a thin block without weight, in which the tie ends. Joints connect the plate to the stones.
"""

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

# %%
# Six stones are pushed outwards by λ times their weight. The strength of the tie is half of the weight. The
# plate presses on the upper four stones.
plate = mo.load(case_folder() / "closed_forms/anchor_plate.toml")
stones = [block for block in plate.blocks if block.name != "plate"]
rod = mo.Tie(name="rod", between=("leaf d5", "ground"), at=((0.3, 1.8), (-1.2, 1.8)), strength=3)
bare = mo.Scene(title="The same tie in one stone", joints=plate.joints, blocks=stones, ties=[rod])

# %%
# Anchored in one stone, the tie does not yield: the stone above the tie slides off at λ = μ. With the plate
# the leaf overturns as one body, and the tie yields. By hand, λ = b/H + 2 T y/(W H), with the weight W, the
# width b and the height H of the leaf, and the strength T and the height y of the tie.
in_one_stone, with_plate = mo.solve(bare), mo.solve(plate)
for name, result in (("in one stone", in_one_stone), ("with a plate", with_plate)):
    force, yields = result.ties.loc[0, ["force", "yields"]]
    print(f"{name}: λ = {result.required():.3f}, tie {'yields at' if yields else 'carries'} {force:.2f}")
assert abs(in_one_stone.required() - 0.6) < 1e-6
assert abs(with_plate.required() - (0.6 / 2.4 + 2 * 3 * 1.8 / (6 * 2.4))) < 1e-6

# %%
# The first picture shows the mechanism without a plate:
in_one_stone.plot()

# %%
# The second picture shows the mechanism with the plate:
with_plate.plot()

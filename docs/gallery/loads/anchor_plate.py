"""
What is an anchor plate for?
============================

A tie holds the outer leaf of a wall. Anchored in one stone it holds that stone, and the others may leave it;
a plate bears on several. A plate is a block of its own, thin and without weight, with joints to the stones
that it bears on: the tie ends in it.
"""

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

# %%
# Six stones pushed outwards by a part of their weight, under a tie that bears half of it. The
# plate bears on the upper four.
plate = mo.load(case_folder() / "closed_forms/anchor_plate.toml")
stones = [block for block in plate.blocks if block.name != "plate"]
rod = mo.Tie(name="rod", between=("leaf d5", "ground"), at=((0.3, 1.8), (-1.2, 1.8)), strength=3)
bare = mo.Scene(title="The same tie in one stone", joints=plate.joints, blocks=stones, ties=[rod])

# %%
# In one stone the tie does not yield: the stone above slides off at λ = μ. With the
# plate the leaf overturns as one, and the tie yields: λ = b/H + 2 T y/(W H), by hand.
in_one_stone, with_plate = mo.solve(bare), mo.solve(plate)
for name, result in (("in one stone", in_one_stone), ("with a plate", with_plate)):
    force, yields = result.ties.loc[0, ["force", "yields"]]
    print(f"{name}: λ = {result.required():.3f}, tie {'yields at' if yields else 'carries'} {force:.2f}")
assert abs(in_one_stone.required() - 0.6) < 1e-6
assert abs(with_plate.required() - (0.6 / 2.4 + 2 * 3 * 1.8 / (6 * 2.4))) < 1e-6

# %%
in_one_stone.plot()

# %%
with_plate.plot()

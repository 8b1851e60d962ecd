"""
What if friction is not known?
==============================

The friction of masonry is known to about 15 %. How much does the load factor of a wall vary with it? The
example solves wall 5 of Ferris & Tin-Loi (2001) for random values of friction from a lognormal distribution
with a mean of 0.65. Each run computes the lowest load factor found and the incremental load factor.
"""

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

wall = case_folder() / "ferris_tinloi" / "wall_5.toml"

# %%
# Twenty runs determine the median to a few per cent. They provide no lower confidence limit of the 5 %
# quantile, which requires 72 runs. Repeated samples with the same seed contain the same values.
uncertain = {"joints.friction": ("lognormal", 0.65, "15%")}
known = mo.sample(wall, uncertain, n=20, seed=0, workers=1)
print(str(known).split("\n", 1)[1])  # without the path of the file
assert (known.falling, known.unlimited, known.undecided) == (0, 0, 0)

# %%
# The picture shows the probability of collapse as a function of the load. The 5 % quantile is the load that
# 95 % of such walls carry. The wall hinges more than it slides, so 15 % more or less friction changes its
# load factor little.
fragility = known.plot("fragility")
lower, median, upper = known.quantiles()["incremental_value"]
print(f"Incremental: 5 % collapse below λ = {lower:.4f}, half below {median:.4f}")
assert lower < 0.21532 < upper  # the incremental load factor at a friction of 0.65

# %%
# The incremental load factor increases with friction, and their rank correlation is above 0.9. The lowest
# load factor found decreases with friction. Friction also permits more self-stress, and with some of these
# self-stresses the wall carries less load.
correlation = known.sensitivity().loc[0]
assert correlation["incremental_rank_correlation"] > 0.9
assert correlation["upper"] < 0

# %%
# If the friction of each course is an independent random value, two courses govern the load factor. A course
# consists of the joints at one height. Courses are counted from the bottom, and bed joints and head joints
# alternate. Twenty runs cannot show whether the other courses have an influence.
by_course = mo.sample(wall, uncertain, n=20, seed=0, by="course", workers=1)
matters = by_course.sensitivity().query("incremental_lower > 0 or incremental_upper < 0")
columns = ["parameter", "incremental_rank_correlation", "incremental_lower", "incremental_upper"]
print(matters[columns].to_string(index=False))
assert matters["parameter"].tolist() == ["course.18.friction", "course.16.friction"]
by_course.plot("sensitivity")

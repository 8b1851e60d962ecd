"""
What if friction is not known?
==============================

Friction of masonry is known to some 15 %. How far does the load factor of a wall scatter with it? Wall 5 of
Ferris & Tin-Loi (2001) is solved for frictions drawn from a lognormal distribution with a mean of 0.65: for
the lowest of its states that are found, and for the incremental load factor.
"""

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder

wall = case_folder() / "ferris_tinloi" / "wall_5.toml"

# %%
# Of so few runs the median is known within some per cent, and of the 5 % quantile no lower limit: for that
# there must be 72. The same seed gives the same runs.
uncertain = {"joints.friction": ("lognormal", 0.65, "15%")}
known = mo.sample(wall, uncertain, n=20, seed=0, workers=1)
print(known)
assert (known.falling, known.unlimited, known.undecided) == (0, 0, 0)

# %%
# The probability of collapse at a load, and the load that 95 % of such walls bear. The wall hinges more than
# it slides: 15 % more or less friction changes its load factor little.
fragility = known.plot("fragility")
lower, median, upper = known.quantiles()["incremental_value"]
print(f"Incremental: 5 % collapse below λ = {lower:.4f}, half below {median:.4f}")
assert lower < 0.21451 < upper  # where friction is 0.65

# %%
# The incremental load factor rises with friction: the ranks of both are nearly the same. The lowest found
# falls where friction is high: friction also clamps, and with other forces at rest the wall then bears less.
correlation = known.sensitivity().loc[0]
assert correlation["incremental_rank_correlation"] > 0.9
assert correlation["upper"] < 0

# %%
# If every course has a friction of its own, two of them decide (a course: the joints at one height, counted
# from below, bed joints and head joints by turns). Of the others as few runs cannot tell whether they matter.
by_course = mo.sample(wall, uncertain, n=20, seed=0, by="course", workers=1)
matters = by_course.sensitivity().query("incremental_lower > 0 or incremental_upper < 0")
print(matters)
assert matters["parameter"].tolist() == ["course.18.friction", "course.16.friction"]
by_course.plot("sensitivity")

"""Thresholds above which motions and differences are reported in messages, plots and tables.

The limits that decide if an answer is accepted are in :mod:`~masonry_opt.solution.acceptance`. The
tolerances for comparing load factors are in :mod:`~masonry_opt.problem.load_factor_scale`.
"""

#: A block counts as at rest if its fastest corner is slower than this fraction of the largest speed in the
#: scene. The loop of linear programs, which is inexact, computes the fraction 1.0e-3 for a block at rest
#: (``closed_forms/pulled_stone``). With a smaller value, this block would count as moving. A hand calculation
#: yields 5e-3 for the slowest moving block (``closed_forms/two_leaves``). With a larger value, this block
#: would count as at rest.
MOVES = 2e-3

#: A joint counts as sliding if it slips faster than this fraction of the largest speed in the scene. With a
#: smaller value, joints between blocks at rest could count as sliding. The loop of linear programs, which is
#: inexact, computes slip speeds of up to 0.002 μ times the largest speed for such joints.
SLIDES = MOVES

#: A joint counts as hinging if rotation opens one of its edges faster than this fraction of the speed of the
#: fastest corner.
HINGES = MOVES

#: A joint counts as separating if it opens at all of its contact points, faster than this fraction of the
#: speed of the fastest corner.
SEPARATES = MOVES

#: A joint of limited strength counts as crushing if one of its edges closes faster than this fraction of the
#: speed of the fastest corner.
CRUSHES = MOVES

#: A limited force, such as a tie force, counts as yielding under two conditions. The force is larger than
#: this fraction of its upper limit, and the mechanism works against it: a tie lengthens, or a prop shortens.
AT_HIGHEST = 1 - MOVES

#: A load counts as driving a mechanism if its net power exceeds this value. Dead loads are measured in median
#: block weights, and the live load is scaled to Σ|f| = 1. Velocities are between −1 and 1. Solvers return up
#: to 1e-9 for a power of zero.
DRIVING_POWER = 1e-7

#: A force, slip or rotation counts as zero below this fraction of the largest value in the scene. For
#: example, a joint counts as free of force if its normal force is below this fraction of the largest one.
NEGLIGIBLE_SHARE = 1e-6

#: Messages about locking list the joints whose departure from associative flow exceeds this fraction of the
#: largest departure. Messages about self-stress list the joints whose normal force exceeds this fraction of
#: the largest normal force.
LISTED_JOINT_SHARE = 1e-2

#: A message says that a collapse state with a lower load factor may exist if the search for exact states made
#: fewer starts than this number. The message appears only if the lowest, the incremental and the associative
#: load factor agree.
FEW_STARTS = 8

#: A message states that the mechanism moves against the live load if the live load's work is negative and
#: large enough. Its magnitude must exceed this fraction of the dead load's work.
LEAST_OPPOSING_WORK = 1e-2

#: A change of the load factor in a narrow interval of a varied parameter counts as a jump only if it exceeds
#: this fraction of the largest load factor.
JUMP = 1e-3

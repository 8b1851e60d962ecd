"""The parameters of passes, in one table, and the rules that are tried one after another."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf


@dataclass(frozen=True)
class Rules:
    """What decides how a pass goes on from step to step; ``gap`` is z·p over the live load's work
    |λ| Σ|f_L|.

    Attributes
    ----------
    contraction: sliding contracts by α μ of its slip, α = contraction · min(1, √gap): what the loop does
        between programs (section 4.2), here between Newton steps.
    least_contraction, dilates_truly: α is no less than the first while the gap is above the second, and zero
        below: the joints' own flow rule.
    blend, blend_above: share θ of the true friction in the Newton matrix's statics, the rest being the flow
        rule's slope, while the gap is above the second; below it the matrix is Newton's (θ = 1). At θ = 0 the
        matrix is that of an associative program, as in the loop.
    ladder: whether θ instead steps down after a short step, and up after a long one. The path of solutions
        over the gap has folds, at which the determinant of Newton's matrix changes sign; a smaller θ passes.
    brake: the gap falls no faster than this share of what the residuals weigh; 0: no brake.
    exact: error of a step's linear equations at which their refinement ends.
    patience, most_short_steps: a pass is given up when the gap has not halved in so many steps, or after so
        many steps in a row that are shorter than ``SHORTEST``.
    """

    contraction: float = 0.3
    least_contraction: float = 1e-3
    dilates_truly: float = 1e-5
    blend: float = 0.7
    blend_above: float = 1e-2
    ladder: bool = False
    brake: float = 0.0
    exact: float = 1e-12
    patience: int = 15
    most_short_steps: int = 6


#: First the rules that end soonest and lowest on walls; refinement beyond 1e-9 takes them a third of their
#: time and leaves their steps as they are. Where they stall, those that pass folds (rubble), with less
#: contraction: chosen on scenes of 60 to 600 stones, each ending where another stalls.
ATTEMPTS = (
    Rules(exact=1e-9),
    Rules(
        contraction=0.07,
        least_contraction=1e-4,
        dilates_truly=1e-4,
        ladder=True,
        brake=0.3,
        patience=30,
        most_short_steps=13,
    ),
    Rules(
        contraction=0.07,
        dilates_truly=1e-4,
        blend=0.4,
        blend_above=1e-4,
        brake=0.3,
        patience=40,
        most_short_steps=13,
    ),
)

#: The rules where contacts give: no contraction, and Newton's matrix, from which only the ladder departs.
#: Chosen on rubble walls of 200 stones with seeds 100 to 115.
GIVING = Rules(
    contraction=0.0,
    least_contraction=0.0,
    dilates_truly=inf,
    ladder=True,
    blend_above=inf,
    brake=1.0,
    patience=40,
    most_short_steps=13,
)

#: The rules for scenes of more than 8000 joints: the second, which pass folds, with the patience that walls
#: of 10,000 blocks take.
OF_LARGE = replace(ATTEMPTS[1], exact=1e-9, patience=60)

#: The rungs of θ, and the highest that is used while the gap is above ``Rules.blend_above``; below the last
#: gap θ is 1 and the brake is off.
RUNGS, HIGHEST_AT_FIRST, NEWTON_BELOW = (1.0, 0.9, 0.7, 0.4, 0.0), 2, 1e-4

#: Steps shorter than the first are short, longer than the second long; the third counts towards giving up.
SHORT, LONG, SHORTEST = 0.1, 0.3, 0.05

#: The end, which is no gate (the state must meet its kind's limits): gap, residual of statics and yield (over
#: the largest dead load, one at least), residual of kinematics (over the largest velocity, one at least;
#: projections at the end take off what is left of it), and how far below the gap the centre is set at most.
GAP, STATICS, KINEMATICS, OVERSHOOT = 1e-9, 1e-9, 1e-6, 0.3

#: Steps of a pass at most.
MOST_STEPS = 300

#: Beyond this gap (or so many times that of the start, which is large where what carries the load weighs next
#: to nothing), or this work of the live load over the sum of dead loads (one at least), a pass has left what
#: can be an answer.
LOST_GAP, LOST_GROWTH, LOST_LOAD = 1e9, 1e3, 1e8

#: Joints up to which a pass is tried before the loop: on façades of more (3 × 9 openings) it lingers.
PASSES_UP_TO = 8000

#: By number of the loop's sub-problem, energy by which its sliding joints are off the true law, over λ, from
#: which on a pass takes a larger scene over. Façades of up to 10 × 30 openings leave 0.04, and end after
#: eight at most; solid walls of 2,900 blocks leave 0.04 and 0.08, and end after 24; of 5,000 blocks 0.05 and
#: 0.16, and end after 46; of 10,000 blocks 0.10, and are farther off after fourteen.
FAR = {2: 0.07, 12: 0.12}

#: Gap up to which the last iterate of such a pass is brought to exact forces, as the loop's sub-problems are.
NEARLY = 5e-3

#: Joints up to which an exact state is sought from a pass's: beyond, the linear programs for it take longer
#: than the pass.
DESCENT_UP_TO = 500

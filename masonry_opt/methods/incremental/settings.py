"""Settings of the incremental analysis."""

from dataclasses import dataclass


@dataclass(frozen=True)
class IncrementalSettings:
    """Numbers that control the incremental analysis. Most users need the first three at most.

    The mean contact force is that under the dead load. An *elastic displacement* is the closing of a joint of
    mean length, in space of mean area, under the mean contact force.
    """

    #: Gap between the load that is carried and the load that is not, where no exact state lies between them,
    #: and increment after a damped motion; both are relative to the load factor. If smaller, the search takes
    #: more steps; if larger, the range is wider.
    tolerance: float = 1e-3
    #: Change of the contact forces in one load increment, relative to their mean. If smaller, there are more
    #: increments; if larger, contacts that slip to and fro may lead to another equilibrium.
    increment: float = 0.1
    #: Displacement beyond which the blocks have collapsed, in elastic displacements, and under loads larger
    #: than the mean contact force in proportion to them. If smaller, a long slide to a new equilibrium counts
    #: as a collapse; if larger, joints that are not quite parallel may jam first.
    far: float = 1e4

    #: Joints, in space contacts, up to which other methods compute the incremental load factor too. If
    #: larger, scenes take many minutes for a number that was not asked for.
    most_joints: int = 3000

    #: Smallest increment, relative to the load factor; an exact state within so narrow a range ends the
    #: search. If smaller, there are more increments near collapse; if larger, the path is less accurate
    #: there.
    smallest_increment: float = 1e-2
    #: Number of increments at most. If smaller, loads without any limit end sooner, but long histories may
    #: too.
    increments: int = 2000
    #: Factor by which the load must grow without any event to prove that it has no limit. Loads larger than
    #: this multiple of the mean contact force are not raised further without such a proof. If smaller, an
    #: event at a very high load may be missed; if larger, wedged scenes without a proof take longer.
    unbounded: float = 1e5

    #: Force out of balance at equilibrium, relative to the mean contact force, or to the load if that is
    #: larger. If smaller, Newton's method takes more iterations; if larger, errors add up over the history.
    equilibrium: float = 1e-9
    #: Iterations of Newton's method at most. If smaller, the damped motion begins more often; if larger,
    #: solves that fail take longer.
    newton_iterations: int = 20
    #: Halvings of a Newton step at most, in search of a smaller residual, and of a step in time that is too
    #: long. If smaller, the damped motion begins more often; if larger, solves that fail take longer.
    halvings: int = 4

    #: Factor by which the damping falls after a whole step in time, and grows after a part of one. If
    #: smaller, the motion takes more steps; if larger, more of them are too long.
    acceleration: float = 4.0
    #: Linear solves of a motion at most. If it ends neither at rest nor beyond ``far``, its load is
    #: undecided. If smaller, slow slides remain undecided; if larger, they take longer.
    motion_solves: int = 1000
    #: Solves for the exact state at a collapse at most, each ``far`` along the motion. If smaller, more
    #: collapses in space, where directions of slip turn, have no exact state; if larger, those without one
    #: take longer.
    exact_solves: int = 4
    #: Share of the forces out of balance that no contact resists, even if all contacts stick, above which
    #: blocks move without moving any joint. If smaller, rounding may look like such a motion; if larger, the
    #: motion of a few small blocks may be missed.
    unresisted: float = 1e-3
    #: Change of the forces out of balance along the motion up to ``far``, relative to them, of a motion
    #: without end. If smaller, such motions are recognised later; if larger, a contact that stops the blocks
    #: may be missed.
    steady: float = 1e-2
    #: Relative rounding. Within it of the friction limit a joint slides, a force is zero, relative to the
    #: mean contact force, and a motion of the blocks moves no joint. If smaller, rounding errors count; if
    #: larger, joints near their limit slide too early.
    rounding: float = 1e-9
    #: Stiffness that is added to the diagonal of matrices, and damping that always remains, relative to the
    #: elastic stiffness. If smaller, matrices of free blocks are singular to rounding; if larger, mechanisms
    #: are less exact.
    regularisation: float = 1e-14
    #: Half-bandwidth up to which matrices are factorised as banded ones, as in the plane. Wider ones are
    #: factorised as sparse matrices. The choice affects times alone.
    narrow_band: int = 200
    #: Standard deviation of the logarithm of a contact's stiffness, in the draws of option "spread". If
    #: larger, the contacts differ more.
    stiffness_deviation: float = 0.5

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
    equilibrium: float = 1e-7
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

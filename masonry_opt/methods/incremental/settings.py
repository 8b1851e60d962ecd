"""Settings of the incremental analysis."""

from dataclasses import dataclass

from masonry_opt.methods.settings import Settings, above_one, zero_or_more


@dataclass(frozen=True)
class IncrementalSettings(Settings):
    """Settings of the incremental analysis. Most users need only the first three settings.

    The mean contact force is that under the dead load. An *elastic displacement* is the closing of a joint of
    mean length (in space: mean area) under the mean contact force.
    """

    #: Largest difference between a load factor with equilibrium and a load factor without, if there is no
    #: exact state between them, relative to the load factor. The value is also twice the distance from an
    #: exact state at which loads below and above it are tested. The increment after a damped motion begins at
    #: this size, doubles with each further motion in a row, and is at most ``smallest_increment``. If this
    #: value is smaller, the search takes more steps; if it is larger, the range is wider, and the exact state
    #: may be missed.
    tolerance: float = 1e-3
    #: Change of the contact forces in one load increment, relative to their mean. With a smaller value there
    #: are more increments; with a larger value contacts that slip back and forth may lead to another
    #: equilibrium.
    increment: float = 0.1
    #: Displacement beyond which the blocks count as collapsed, in elastic displacements. For loads that
    #: exceed the mean contact force, the displacement is multiplied by their ratio. If this value is smaller,
    #: a long slide to a new equilibrium counts as collapse; if it is larger, joints that are not quite
    #: parallel may jam first.
    far: float = 1e4

    #: Largest number of joints (in space: contacts) of scenes for which other methods also compute the
    #: incremental load factor. On larger scenes the computation would take many minutes. Other methods
    #: always use the default, so that passing another value has no effect.
    most_joints: int = 3000

    #: Smallest increment, relative to the load factor. The search also ends if there is an exact state in a
    #: range of this width. If this value is smaller, there are more increments near collapse; if it is
    #: larger, the load history is less accurate near collapse.
    smallest_increment: float = 1e-2
    #: Largest number of increments. With a smaller number an analysis without a limit of the load ends
    #: earlier, but long load histories may remain undecided.
    increments: int = 2000
    #: The load counts as unlimited if it can grow by this factor without a change at any contact. Otherwise
    #: the load is raised up to this multiple of the mean contact force. If the factor is smaller, a change
    #: under a very large load may be missed; if it is larger, the analysis of wedged scenes may take longer.
    unbounded: float = 1e5

    #: Largest unbalanced force at equilibrium, relative to the mean contact force or to the load, whichever
    #: is larger. With a smaller value Newton's method takes more iterations; with a larger value errors
    #: accumulate over the load history.
    equilibrium: float = 1e-9
    #: Largest number of iterations of Newton's method. With fewer iterations the method fails more often, and
    #: a slower damped motion replaces it; with more iterations unsuccessful solves take longer.
    newton_iterations: int = 20
    #: Largest number of halvings of a Newton step that does not reduce the residual, and of a time step that
    #: is too long. With fewer halvings Newton's method fails more often, and a slower damped motion replaces
    #: it; with more halvings unsuccessful solves take longer.
    halvings: int = zero_or_more(4)

    #: Factor by which the damping decreases after a complete time step, and increases after a shortened one.
    #: With a smaller factor the motion takes more steps; with a larger factor more steps must be shortened.
    acceleration: float = above_one(4.0)
    #: Largest number of linear solves of a damped motion. If the blocks are then neither at rest nor beyond
    #: ``far``, the analysis cannot decide between equilibrium and collapse. With a smaller number slow slides
    #: remain undecided; with a larger number they take longer.
    motion_solves: int = 4000
    #: Largest number of solves for the exact state of a collapse, each after a displacement of ``far``. With
    #: fewer solves an exact state is found for fewer collapses in space, where directions of slip change;
    #: with more solves collapses without an exact state take longer.
    exact_solves: int = zero_or_more(4)
    #: Blocks count as free to move without moving any joint if more than this share of the unbalanced forces
    #: remains when all contacts stick. With a smaller share rounding errors may look like a free motion; with
    #: a larger share the motion of a few small blocks may be missed.
    unresisted: float = 1e-3
    #: A motion counts as endless if the unbalanced forces change by less than this share along the motion up
    #: to ``far``. With a smaller share endless motions are recognised later; with a larger share a contact
    #: that stops the blocks may be missed.
    steady: float = 1e-2
    #: Relative size of rounding errors of three quantities: the distance of a joint from its friction limit,
    #: a force (relative to the mean contact force), and the motion of joints (relative to that of the
    #: blocks). If this value is smaller, rounding errors affect the result; if it is larger, joints near
    #: their friction limit slide too early.
    rounding: float = 1e-9
    #: Stiffness that is added to the diagonal of matrices, and smallest damping, both relative to the elastic
    #: stiffness. The share also applies to the matrix that determines the mean force. If this value is
    #: smaller, matrices of free blocks are nearly singular; if it is larger, mechanisms are less exact.
    regularisation: float = 1e-14
    #: Largest half-bandwidth of matrices that are factorised as banded matrices, which are typical of plane
    #: scenes. Matrices with a larger half-bandwidth are factorised as sparse matrices. The choice affects
    #: only the time.
    narrow_band: int = zero_or_more(200)
    #: Standard deviation of the logarithm of a contact's stiffness in the random draws of option "spread".
    #: With a larger value the contacts differ more.
    stiffness_deviation: float = zero_or_more(0.5)

"""Settings of the incremental analysis."""

from dataclasses import dataclass

from masonry_opt.methods.settings import Settings, above_one, zero_or_more


@dataclass(frozen=True)
class IncrementalSettings(Settings):
    """Settings of the incremental analysis. Most users need only the first three settings.

    The guide explains each field: page "The incremental analysis", section "Settings". The source file of
    this class has the same text in the comment above each field.

    The mean contact force is that under the dead load. An *elastic displacement* is the closing of a joint of
    mean length (in space: mean area) under the mean contact force.
    """

    #: If no exact state is found, the load history ends with a range of possible collapse loads. This setting
    #: is the largest width of the range, relative to the load factor. With a smaller value, the search takes
    #: more steps. With a larger value, the exact state may be missed.
    #:
    #: The setting has three further effects:
    #:
    #: - If an exact state is found, two load factors are tested: the load factor of the state, reduced and
    #:   increased by half of this fraction.
    #: - After a damped motion, the first load increment has this size, relative to the load factor. With each
    #:   consecutive damped motion the increment doubles, until it reaches ``smallest_increment``.
    #: - Forces that hold a settling support are stiffer than a tie by the factor 1 / ``tolerance``.
    tolerance: float = 1e-3
    #: Change of the contact forces in the first trial of a load increment, relative to the forces. The trial
    #: is at least ``smallest_increment``, and at most twice the last increment. It is then doubled as long as
    #: no contact opens, closes, slips or sticks. With a smaller value, there are more increments. With a
    #: larger value, contacts that slip back and forth may lead to a different equilibrium.
    increment: float = 0.1
    #: Displacement beyond which the blocks count as collapsed, as a multiple of an elastic displacement: the
    #: one under the mean contact force or the one under the applied load, whichever is larger. With a smaller
    #: value, a long slide that would stop counts as collapse. With a larger value, nearly parallel joints may
    #: jam during the long motion, and motions of large scenes in space may remain undecided.
    far: float = 3e3

    #: Coulomb methods other than "incremental" compute the incremental load factor on scenes of up to this
    #: number of joints (in space: contact points). Larger scenes would take many minutes. These methods
    #: always use the default value.
    most_joints: int = 3000

    #: Smallest load increment, relative to the load factor. The load history also ends if a range of load
    #: factors of this width contains an exact state. With a smaller value, the history is more accurate near
    #: collapse, but has more increments.
    smallest_increment: float = 1e-2
    #: Largest number of load increments in a load history. With a smaller number, analyses of unlimited loads
    #: end earlier, but analyses that need many increments end undecided.
    increments: int = 2000
    #: The load counts as unlimited if it can grow by this factor without a change at any contact. The
    #: analysis ends undecided if the load exceeds this multiple of the mean contact force. With a smaller
    #: factor, changes under very large loads may be missed. With a larger factor, wedged scenes may take
    #: longer.
    unbounded: float = 1e5

    #: Largest unbalanced force at equilibrium, relative to the mean contact force or to the load, whichever
    #: is larger. With a smaller value Newton's method takes more iterations. With a larger value errors
    #: accumulate over the load history.
    equilibrium: float = 1e-9
    #: Largest number of Newton iterations for one equilibrium, and for the slip of joints under trial forces.
    #: Without convergence, the slower damped motion replaces Newton's method. With more iterations,
    #: unsuccessful solves take longer.
    newton_iterations: int = 20
    #: Largest number of times that a Newton step, or a time step of a damped motion, is halved. With fewer
    #: halvings, Newton's method fails more often, and the slower damped motion replaces it. With more
    #: halvings, unsuccessful solves take longer.
    halvings: int = zero_or_more(4)

    #: Factor by which the damping decreases after a complete time step and increases after a shortened time
    #: step. With a smaller factor the motion takes more steps. With a larger factor more steps are shortened.
    acceleration: float = above_one(4.0)
    #: Largest number of linear solves in a damped motion. If the blocks still move after this number of
    #: solves, but by less than ``far``, the motion is undecided. With a smaller number more slow slides
    #: remain undecided. With a larger number slow slides take longer.
    motion_solves: int = 4000
    #: Largest number of solves for the exact state of a collapse. With fewer solves, fewer exact states are
    #: found in space. With more solves, collapses without an exact state take longer. With 0, the load
    #: history uses no exact states, and even plane analyses usually end with a range of the collapse load.
    exact_solves: int = zero_or_more(4)
    #: Blocks count as free to move without resistance if more than this fraction of the unbalanced forces
    #: remains even though all contacts stick. With a smaller fraction rounding errors may look like a free
    #: motion. With a larger fraction the motion of a few small blocks may be missed.
    unresisted: float = 1e-3
    #: A motion counts as collapse if the unbalanced forces change by less than this fraction along the motion
    #: up to ``far``. With a smaller fraction collapse is recognised later. With a larger fraction a contact
    #: that stops the blocks may be missed.
    steady: float = 1e-2
    #: Relative tolerance for rounding errors in forces, in motions of joints, and in distances from the
    #: friction limit. With a smaller value, rounding errors affect the result. With a larger value, joints
    #: near their friction limit slide too early.
    rounding: float = 1e-9
    #: Each stiffness matrix is regularised: this fraction of the elastic stiffness matrix is added to the
    #: matrix. This fraction of the largest entry of the elastic stiffness matrix is also added to the
    #: diagonal. In the matrix for the mean contact force, the diagonal is increased by this fraction. With a
    #: smaller value, matrices of free blocks are nearly singular. With a larger value, mechanisms are less
    #: exact.
    regularisation: float = 1e-14
    #: Largest half-bandwidth of stiffness matrices that are factorised as banded matrices. Other matrices are
    #: factorised as general sparse matrices. The value affects only the time.
    narrow_band: int = zero_or_more(200)
    #: Standard deviation of the logarithm of the contact stiffness in the random draws of option "spread".
    #: With a larger value the contacts differ more.
    stiffness_deviation: float = zero_or_more(0.5)

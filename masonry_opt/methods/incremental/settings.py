"""Settings of the incremental analysis."""

from dataclasses import dataclass

from masonry_opt.methods.settings import Settings, above_one, zero_or_more


@dataclass(frozen=True)
class IncrementalSettings(Settings):
    """Settings of the incremental analysis. Most users need only the first three settings.

    The guide explains each field: page "The incremental analysis", section "Settings". The source file of
    this class contains the explanations too, as comments above the fields.

    The *mean contact force* is computed under the dead load. The *elastic displacement* is the closing of a
    joint of mean length (in space: mean area) under the mean contact force.
    """

    #: If no exact state is found, the load history ends with a range of possible collapse loads. This setting
    #: is the largest width of the range, relative to the load factor. With a smaller value, the search takes
    #: more steps. With a larger value, the exact state may be missed.
    #:
    #: The setting has three further effects:
    #:
    #: - If an exact state is found, the search tests a slightly smaller and a slightly larger load. They
    #:   differ from the load of the state by the fraction ``tolerance`` / 2.
    #: - After a damped motion, the first load increment is the fraction ``tolerance`` of the load factor.
    #:   With each consecutive damped motion the increment doubles, until it reaches ``smallest_increment``.
    #: - Forces that hold a settling support are stiffer than a tie by the factor 1 / ``tolerance``.
    tolerance: float = 1e-3
    #: Relative change of the contact forces from which the size of a load increment is estimated. The
    #: estimate is raised to ``smallest_increment`` if it is smaller, and reduced to twice the last increment
    #: if it is larger. The increment is then doubled as long as no contact opens, closes, slips or sticks.
    #: With a smaller value, there are more increments. With a larger value, contacts that slip back and forth
    #: may lead to a different equilibrium.
    increment: float = 0.1
    #: Displacement beyond which the blocks count as collapsed, as a multiple of the elastic displacement. If
    #: the applied load is larger than the mean contact force, the limit grows in proportion to the load. With
    #: a smaller value, a long slide that would stop counts as collapse. With a larger value, nearly parallel
    #: joints may jam during the long motion, and motions of large scenes in space may remain undecided.
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
    #: The load counts as unlimited if it can grow by this factor and no contact opens, closes, slips or
    #: sticks. The analysis ends undecided if the live load exceeds this multiple of the mean contact force.
    #: With a smaller factor, contacts that open or slip only under a very large load may be missed. With a
    #: larger factor, wedged scenes may take longer.
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
    #: To test whether blocks move without resistance, all contacts are assumed to stick and to take tension.
    #: If more than this fraction of the unbalanced forces is then still not balanced, the blocks move without
    #: resistance. With a smaller fraction rounding errors may look like a free motion. With a larger fraction
    #: the motion of a few small blocks may be missed.
    unresisted: float = 1e-3
    #: A motion counts as collapse if the unbalanced forces change by less than this fraction along the motion
    #: up to ``far``. With a smaller fraction collapse is recognised later. With a larger fraction a contact
    #: that stops the blocks may be missed.
    steady: float = 1e-2
    #: Relative tolerance for rounding errors in forces, in motions of joints, and in distances from the
    #: friction limit. With a smaller value, rounding errors affect the result. With a larger value, joints
    #: near their friction limit slide too early.
    rounding: float = 1e-9
    #: Each stiffness matrix is regularised, because it is singular if blocks can move freely. This fraction
    #: of the elastic stiffness matrix is added to the matrix. This fraction of the largest entry of the
    #: elastic stiffness matrix is also added to each diagonal entry. The matrix from which the mean contact
    #: force is computed is regularised too: each diagonal entry is increased by this fraction. With a smaller
    #: value, matrices of free blocks are nearly singular. With a larger value, mechanisms are less exact.
    regularisation: float = 1e-14
    #: Largest half-bandwidth of stiffness matrices that are factorised as banded matrices. Other matrices are
    #: factorised as general sparse matrices. The value affects only the time.
    narrow_band: int = zero_or_more(200)
    #: Standard deviation of the logarithm of the contact stiffness in the random draws of option "spread".
    #: With a larger value the contacts differ more.
    stiffness_deviation: float = zero_or_more(0.5)

"""Define the settings of the search for exact states with a lower load factor."""

from dataclasses import dataclass

from masonry_opt.methods.settings import Settings, zero_or_more


@dataclass(frozen=True)
class SearchSettings(Settings):
    """Settings of the search for exact states with a lower λ.

    The guide explains each field: page "The method", section "Settings of the default method". The source
    file of this class has the same text in the comment above each field.

    ``benchmarks/lowest.py`` measures how often the lowest load factor with the default settings exceeds the
    lowest load factor that is known.
    """

    #: Range of load factors at which random forces are drawn as starts, relative to the lowest known load
    #: factor. With smaller values, starts lead to a greater variety of states, but a larger share of the
    #: starts leads to no state.
    load_shares: tuple[float, float] = (0.5, 1.0)

    #: Range of the fraction of yield conditions that is chosen at random when random forces are drawn. The
    #: forces minimise the slacks of the chosen conditions. With larger fractions, the forces are more similar
    #: to each other.
    yielding_shares: tuple[float, float] = (0.02, 0.3)

    #: On small plane scenes, the default method ends its search after this number of successive starts
    #: without a lower λ. With a larger number, rarer states are found, and the search takes proportionally
    #: longer.
    starts_in_vain: int = 100

    #: If λ is proven to be the least, the search ends after this number of successive starts without a lower
    #: λ. The starts look only for negative load factors, which the proof does not cover. With a larger
    #: number, the search takes proportionally longer.
    starts_after_proof: int = 20

    #: Positions of the load steps whose forces are the first starts of the search in space: 0.5 is the step
    #: halfway through the load history. Early steps lead to other states than the collapse state of the
    #: history.
    steps_in_space: tuple[float, ...] = zero_or_more((0.9, 0.5))

    #: Number of random starts of the search in space, after the starts from load steps. With more starts,
    #: states with a lower λ are found more often, and the search takes proportionally longer.
    starts_in_space: int = zero_or_more(6)

    #: In space, the default method uses random starts on scenes with at most this number of contact points.
    #: On larger scenes they would take too long: one start from the state with the lowest λ replaces them.
    most_contacts: int = zero_or_more(250)

    #: Largest number of joints of a plane scene whose linear programs are solved by the simplex method. On
    #: larger scenes interior-point methods are faster.
    simplex_up_to: int = zero_or_more(500)

    #: A start near the state with the lowest λ releases this fraction of the state's active yield conditions,
    #: but at least one. With a larger fraction, starts lead to a greater variety of states.
    released_share: float = zero_or_more(0.02)

    #: Largest number of linear programs in a fixed-point iteration, which is one kind of start of the search.
    #: More programs seldom change the state.
    fixed_point_iterations: int = 15

    #: Largest number of joints of "small" plane scenes, on which the default method tries further starts. On
    #: larger scenes, further starts would take longer than all other steps together. The limit
    #: ``simplex_up_to`` also applies.
    small: int = 60

    #: Rates of yield conditions up to this value count as zero. They are relative to the mean velocity of the
    #: points at which the live load acts. With a smaller value, rounding errors count as motion. With a
    #: larger value, slow parts of a mechanism are ignored.
    at_rest: float = 1e-9

    #: In the search for exact states, a condition counts as at yield if its slack is at most this value, in
    #: median block weights. With a smaller value, rounding errors may hide conditions at yield. With a larger
    #: value, conditions that are not at yield may have nonzero rates.
    at_yield: float = 1e-7

    #: A start may lead to no exact state. The search is then repeated from corrected forces, which are nearer
    #: to a collapse state. This is the largest number of repetitions. More of them seldom lead to a lower λ.
    repairs: int = zero_or_more(2)

    #: Time limit of a linear program of the search, in seconds per joint. Without a limit, HiGHS may never
    #: end. A program that reaches the limit counts as undecided.
    seconds_per_joint: float = 0.2

    #: Weight of the energy z·p (slacks times rates), relative to λ Σ|f_L|, when forces are computed for an
    #: approximate collapse mechanism. With a smaller weight, the final energy z·p is larger. With a larger
    #: weight, λ is higher.
    weight: float = 30.0

    #: Weights of the energy z·p (slacks times rates) for scenes in the plane, relative to λ Σ|f_L|. The
    #: alternation between mechanisms and forces uses the weights in this order. With smaller weights, λ is
    #: lower. With larger weights, the final energy z·p is closer to zero.
    weights_in_plane: tuple[float, ...] = (1e3, 1e4)

    #: Series of weights of the energy z·p for scenes in space, used like ``weights_in_plane``. The first
    #: series leads to a lower λ than the second. If the first series finds no state, the second is tried. The
    #: large weights of the second series keep the forces near the start, which helps in rings of wedge-shaped
    #: blocks. The step "further starts" uses only the first series.
    weight_series_in_space: tuple[tuple[float, ...], ...] = (
        (3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 1e4),
        (*5 * [1e4], *2 * [1e5, 1e6]),
    )

    #: Tolerances of the interior-point solver. In space, they are tried in this order until the solver
    #: reaches one of them. In the plane, only the first tolerance is used, because on façades a tolerance of
    #: 1e-10 already permits violations of yield conditions by 3e-8.
    tolerances: tuple[float, ...] = (1e-11, 1e-10, 1e-9)

    #: Tolerance of z·p, as a fraction of the work λ f_L·d of the live load. The alternation between
    #: mechanisms and forces discards states with a larger z·p. With a larger tolerance, states are less
    #: exact. With a smaller tolerance, more starts lead to no state.
    largest_energy: float = 1e-5


#: Default settings of the search in method "coulomb". They apply whether or not its option ``search`` is set.
SEARCH = SearchSettings()

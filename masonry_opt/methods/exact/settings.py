"""Define the settings of the search for lower exact states."""

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

    #: Range of load factors at which random forces are drawn as starts of the search, relative to the lowest
    #: known load factor. With smaller values the starts lead to a larger number of different states, but more
    #: starts lead to no state.
    load_shares: tuple[float, float] = (0.5, 1.0)

    #: Range of the fraction of yield conditions that is chosen at random when random forces are drawn. The
    #: drawn forces minimise the slacks of the chosen conditions. With larger fractions the drawn forces are
    #: more similar to each other.
    yielding_shares: tuple[float, float] = (0.02, 0.3)

    #: Number of successive starts without a lower λ after which the default method ends its search on small
    #: scenes in the plane. With more starts the search takes proportionally longer, and rarer states are
    #: found.
    starts_in_vain: int = 100

    #: Number of successive starts without a lower λ after which the search ends if λ is already proven to be
    #: the least. These starts look only for negative load factors, which the proof does not cover. With more
    #: starts the search takes proportionally longer.
    starts_after_proof: int = 20

    #: Steps of the load history whose forces are the first starts of the search in space. Each number is the
    #: position of a step in the load history: 0.5 is the step halfway through the history. Forces of early
    #: steps lead to states that differ from the collapse state of the load history.
    steps_in_space: tuple[float, ...] = zero_or_more((0.9, 0.5))

    #: Number of random starts of the search in space, after the starts from load steps. With more starts,
    #: states with a lower λ are found more often, and the search takes proportionally longer.
    starts_in_space: int = zero_or_more(6)

    #: Largest number of contact points of a scene in space on which the search uses random starts. On scenes
    #: with more contact points, random starts would take longer than all other steps, so the search uses a
    #: single start, from the forces of the state with the lowest λ.
    most_contacts: int = zero_or_more(250)

    #: Largest number of joints of a plane scene whose linear programs are solved by the simplex method. On
    #: larger scenes interior-point methods are faster.
    simplex_up_to: int = zero_or_more(500)

    #: A start near the state with the lowest λ releases this fraction of the active yield conditions of the
    #: state, but at least one condition. With a larger fraction the starts lead to a larger number of
    #: different states.
    released_share: float = zero_or_more(0.02)

    #: Fractions of the strength of ties and other forces with two limits. Each round of starts begins with
    #: one start for each fraction, in which these forces are limited to the fraction of their strength. With
    #: more fractions, states in which ties do not yield are found more often.
    strength_shares: tuple[float, ...] = (0.75, 0.5, 0.25)

    #: Largest number of linear programs in a fixed-point iteration, which is one kind of start of the search.
    #: More programs seldom change the state.
    fixed_point_iterations: int = 15

    #: Largest number of joints of a "small" plane scene. In the plane, the default method tries further
    #: starts only on small scenes, because on larger scenes further starts would take longer than all other
    #: steps together. Further starts in the plane also need the simplex method, see ``simplex_up_to``.
    small: int = 60

    #: Largest rate of a yield condition in a mechanism that counts as zero. With a smaller value rounding
    #: errors count as motion. With a larger value slow parts of a mechanism are ignored.
    at_rest: float = 1e-9

    #: Slack below which a yield condition counts as at yield in the search for exact states. With a smaller
    #: value rounding errors may hide conditions at yield. With a larger value conditions that are not at
    #: yield may have nonzero rates.
    at_yield: float = 1e-7

    #: If the search finds no exact state from the forces of a start, it replaces these forces by forces
    #: nearer to a collapse state, and searches again. This setting is the largest number of replacements for
    #: each start. More replacements seldom lead to a lower λ.
    repairs: int = zero_or_more(2)

    #: Time limit of a linear program of the search, in seconds per joint of the scene, because HiGHS may
    #: never end without a limit. A program that reaches the limit counts as undecided.
    seconds_per_joint: float = 0.2

    #: Weight of the energy z·p (slacks times rates), relative to λ Σ|f_L|, in the program that computes the
    #: forces if the mechanism is known only roughly. With a smaller weight more energy remains: with weight
    #: 10, 50 % more on façades. With a larger weight λ is higher: with weight 100, by up to 0.2 %.
    weight: float = 30.0

    #: Weights of the energy z·p (slacks times rates) in the plane. The alternation between mechanisms and
    #: forces minimises λ Σ|f_L| plus a weight times this energy, for one weight after the other. With smaller
    #: weights λ is lower. With larger weights less energy remains.
    weights_in_plane: tuple[float, ...] = (1e3, 1e4)

    #: Series of weights of the energy z·p (slacks times rates) in space. The alternation between mechanisms
    #: and forces minimises λ Σ|f_L| plus a weight times this energy, for one weight of a series after the
    #: other. If no state is found, the alternation starts again with the next series. Further starts of a
    #: search use only the first series, whose weights increase slowly and lead to a lower λ. The large
    #: weights of the second series keep the forces near the start, which helps on many rings of wedges.
    weight_series_in_space: tuple[tuple[float, ...], ...] = (
        (3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 1e4),
        (*5 * [1e4], *2 * [1e5, 1e6]),
    )

    #: Tolerances of the interior-point solver in the search for exact states. In space, the next tolerance is
    #: tried if the solver does not reach a tolerance. In the plane only the first tolerance is used: on
    #: façades, a tolerance of 1e-10 already permits violations of yield conditions by 3e-8.
    tolerances: tuple[float, ...] = (1e-11, 1e-10, 1e-9)

    #: Largest energy z·p, relative to λ, of a state that the alternation between mechanisms and forces may
    #: return. Other states are discarded. With a larger limit states are less exact. With a smaller limit
    #: more starts lead to no state.
    largest_energy: float = 1e-5


#: Default settings of method "coulomb", with and without its option ``search``.
SEARCH = SearchSettings()

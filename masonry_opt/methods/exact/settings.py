"""Define the settings of the search for lower exact states."""

from dataclasses import dataclass

#: Weight of the energy z·p relative to λ if a mechanism is known approximately. A smaller weight leaves more
#: energy: on façades 1.5 times as much with 10. A larger weight increases λ: by up to 0.2 % with 100.
WEIGHT = 30.0


@dataclass(frozen=True)
class SearchSettings:
    """Settings of the search for lower exact states.

    ``benchmarks/lowest.py`` measures how often the default's lowest load factor is above the least known.
    """

    #: Range of load factors of random forces, as shares of the lowest known load factor. Smaller shares lead
    #: to states that differ more, and more often lead to no state.
    load_shares: tuple[float, float] = (0.5, 1.0)

    #: Range of the share of yield conditions whose slacks a draw of random forces minimises. A larger share
    #: makes draws more similar.
    yielding_shares: tuple[float, float] = (0.02, 0.3)

    #: Number of successive starts without a lower state after which the default method ends its search of a
    #: small scene in the plane. More starts take proportionally longer and find rarer states.
    starts_in_vain: int = 100

    #: In space: load steps whose forces are the first additional starts of the default method, as shares of
    #: the number of steps. Forces of earlier steps lead to states other than the collapse state of the load
    #: history.
    steps_in_space: tuple[float, ...] = (0.9, 0.5)

    #: In space: number of random starts of the default method after the load steps. More starts find lower
    #: states more often and take proportionally longer.
    starts_in_space: int = 6

    #: In space: series of weights of the energy relative to λ for the additional starts of the default
    #: method. Fewer weights take proportionally less time. Faster rising weights lead to higher states.
    weights_in_space: tuple[float, ...] = (3.0, 10.0, 30.0, 1e2, 1e4)

    #: Number of contacts in space above which the default method takes only one additional start, from the
    #: forces of the lowest state. On larger scenes random forces take longer than all other steps.
    most_contacts: int = 250

    #: Largest number of joints in the plane for which linear programs are solved by the simplex method. On
    #: larger scenes interior-point methods are faster, and the simplex method takes longer than all other
    #: steps.
    simplex_up_to: int = 500

    #: Number of starts below which agreement of all load factors is reported as weak evidence.
    few_starts: int = 8

    #: A yield condition counts as active if its dual variable exceeds this share of the largest dual
    #: variable.
    holding_share: float = 1e-6

    #: Share of the active yield conditions that a start near the lowest state releases; at least one is
    #: released. A larger share leads to states that differ more.
    released_share: float = 0.02

    #: Share of the largest load of a load history at which forces of the history are taken as a start. A
    #: larger share leads to the history's own collapse state.
    history_share: float = 1.0

    #: Standard deviation of the logarithm of the random factors on the loads of each block, for starts of
    #: kind "loads".
    load_deviation: float = 0.5


#: Default settings of method "coulomb", with and without its option ``search``.
SEARCH = SearchSettings()

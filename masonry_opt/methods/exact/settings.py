"""Define the settings of the search for lower exact states."""

from dataclasses import dataclass

#: Weight of the energy z·p over λ if a mechanism is known roughly. If smaller, more energy is left: on
#: façades half as much again with 10. If larger, λ is higher: by up to 0.2 % with 100.
WEIGHT = 30.0


@dataclass(frozen=True)
class SearchSettings:
    """Settings of the search for lower exact states.

    ``benchmarks/lowest.py`` measures how often the default's lowest load factor is above the least known.
    """

    #: Range of the share of the lowest known load factor at which random forces are drawn. A lower start
    #: leads to states that lie further away, and more often to none.
    load_shares: tuple[float, float] = (0.5, 1.0)

    #: Range of the share of yield conditions that a draw of random forces brings to yield if it can. A larger
    #: share makes draws more alike.
    yielding_shares: tuple[float, float] = (0.02, 0.3)

    #: Number of starts in a row without a lower state after which the default ends its search of a small
    #: scene in the plane. More starts take proportionally longer, and find states that few starts lead to.
    starts_in_vain: int = 100

    #: Load steps whose forces are the first of the further starts of the default in space, as shares of the
    #: number of steps. The forces of earlier steps lead to other states than those at the collapse.
    steps_in_space: tuple[float, ...] = (0.9, 0.5)

    #: Number of other further starts of the default in space. More starts find lower states more often, and
    #: take proportionally longer.
    starts_in_space: int = 6

    #: Weights of the energy over λ, in turn, for the further starts of the default in space. Fewer weights
    #: take proportionally less time. Weights that rise faster lead to higher states.
    weights_in_space: tuple[float, ...] = (3.0, 10.0, 30.0, 1e2, 1e4)

    #: Number of contacts in space above which the default takes one further start alone, from the forces of
    #: the lowest state. On larger scenes random forces take longer than all steps before.
    most_contacts: int = 250

    #: Joints in the plane up to which linear programs are solved by the simplex method. On larger scenes the
    #: simplex method takes longer than all other steps together, and interior points are faster.
    simplex_up_to: int = 500

    #: Number of starts below which equal load factors are reported as little evidence.
    few_starts: int = 8

    #: Dual variable of a yield condition, as a share of the largest, above which the condition holds λ up.
    holding_share: float = 1e-6

    #: Share of the yield conditions that hold λ up which a neighbour releases, at least one. A larger share
    #: leads further away from the state.
    released_share: float = 0.02

    #: Share of the largest load of a load history under which its forces are taken as a start. A larger share
    #: leads to the collapse state of the history itself.
    history_share: float = 1.0

    #: Standard deviation of the logarithm of the factors by which a start changes the loads of each block.
    load_deviation: float = 0.5


#: Default settings, which method "coulomb" uses with and without its search.
SEARCH = SearchSettings()

"""Define the settings of the search for lower exact states."""

from dataclasses import dataclass

from masonry_opt.methods.settings import Settings, zero_or_more


@dataclass(frozen=True)
class SearchSettings(Settings):
    """Settings of the search for lower exact states.

    ``benchmarks/lowest.py`` measures how often the lowest load factor with the default settings exceeds the
    lowest load factor that is known.
    """

    #: Random forces are drawn at load factors in this range, relative to the lowest known load factor. With
    #: smaller values the states found differ more, and more starts find no state.
    load_shares: tuple[float, float] = (0.5, 1.0)

    #: Range from which a random share is drawn. Each draw of random forces minimises the slacks of this share
    #: of the yield conditions. With larger shares the draws are more similar.
    yielding_shares: tuple[float, float] = (0.02, 0.3)

    #: On small scenes in the plane the default method ends its search after this number of successive starts
    #: that do not lower λ. More starts take proportionally longer and find rarer states.
    starts_in_vain: int = 100

    #: Number of successive starts without a lower state after which the search ends if a proof shows that no
    #: state has a load factor between zero and the answer. These starts look for states with negative load
    #: factors, which the proof does not cover. More starts take proportionally longer.
    starts_after_proof: int = 20

    #: In space, the first further starts of the default method are the forces of these load steps, stated as
    #: shares of the number of steps. Forces of earlier steps lead to other states than the collapse state of
    #: the load history.
    steps_in_space: tuple[float, ...] = zero_or_more((0.9, 0.5))

    #: In space, number of random starts of the default method after the starts from load steps. More starts
    #: lower λ more often and take proportionally longer.
    starts_in_space: int = zero_or_more(6)

    #: Number of contacts in space above which the default method has only one further start, from the forces
    #: of the state with the lowest load factor. With more contacts, starts from random forces would take
    #: longer than all other steps.
    most_contacts: int = zero_or_more(250)

    #: Largest number of joints in the plane for which linear programs are solved by the simplex method. On
    #: larger scenes interior-point methods are faster, and the simplex method takes longer than all other
    #: steps.
    simplex_up_to: int = zero_or_more(500)

    #: Share of the active yield conditions that a start near the known state of lowest λ releases; at least
    #: one condition is released. With a larger share the states found differ more.
    released_share: float = zero_or_more(0.02)

    #: In the first starts, ties and other limited forces may use at most these shares of their strength, one
    #: share for each start. With more shares, states in which ties do not yield are found more often.
    strength_shares: tuple[float, ...] = (0.75, 0.5, 0.25)

    #: Largest number of linear programs in a fixed-point iteration. More programs seldom change the state.
    fixed_point_iterations: int = 15

    #: Largest number of joints of a "small" scene in the plane, on which the default method tries further
    #: starts, which need the simplex method. On larger scenes further starts would take longer than all other
    #: steps together.
    small: int = 60

    #: Rate above which a yield condition counts as moving. If this value is smaller, rounding errors count as
    #: motion; if it is larger, slow parts of a mechanism are ignored.
    at_rest: float = 1e-9

    #: Slack below which a condition counts as at yield. If this value is smaller, conditions at yield may be
    #: missed because of rounding errors; if it is larger, faces that are not at yield may move.
    at_yield: float = 1e-7

    #: Largest number of times that the forces of a start are replaced by forces nearer to a collapse state.
    #: More replacements seldom lower λ.
    repairs: int = zero_or_more(2)

    #: Time limit of a linear program, in seconds per joint. Without a limit HiGHS may never end.
    seconds_per_joint: float = 0.2

    #: Weight of the energy z·p relative to λ if a mechanism is known only roughly. With a smaller weight more
    #: energy remains: on façades 50 % more with 10. With a larger weight λ is higher: by up to 0.2 % with
    #: 100.
    weight: float = 30.0

    #: Weights of the energy z·p relative to λ, which the alternation between mechanisms and forces in the
    #: plane uses one after the other. With smaller weights λ is lower; with larger weights less energy
    #: remains.
    weights_in_plane: tuple[float, ...] = (1e3, 1e4)

    #: Series of weights of the alternation in space. If a series finds no state, the next series is tried;
    #: the further starts of the default method use only the first series. With slowly increasing weights λ is
    #: lower. Weights that are large from the beginning keep the forces near those of the start, which helps
    #: on many rings of wedges.
    weight_series_in_space: tuple[tuple[float, ...], ...] = (
        (3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 1e4),
        (*5 * [1e4], *2 * [1e5, 1e6]),
    )

    #: Tolerances of the interior-point solver in space. If the solver does not reach a tolerance, the next
    #: tolerance is tried; in the plane only the first tolerance is used. With larger tolerances yield
    #: conditions are violated more: at 1e-10 by 3e-8 on façades.
    tolerances: tuple[float, ...] = (1e-11, 1e-10, 1e-9)

    #: Largest energy z·p, relative to λ, of a state that the alternation may return. If this limit is larger,
    #: states are less exact; if it is smaller, more starts lead to no state.
    largest_energy: float = 1e-5


#: Default settings of method "coulomb", with and without its option ``search``.
SEARCH = SearchSettings()

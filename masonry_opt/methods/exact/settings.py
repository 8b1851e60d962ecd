"""Define the settings of the search for lower exact states."""

from dataclasses import dataclass


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

    #: The same number if it is proven that no state between zero and the answer exists. These starts look for
    #: states below zero, which the proof does not cover. More starts take proportionally longer.
    starts_after_proof: int = 20

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

    #: Share of the active yield conditions that a start near the lowest state releases; at least one is
    #: released. A larger share leads to states that differ more.
    released_share: float = 0.02

    #: Standard deviation of the logarithm of the random factors on the loads of each block, for starts of
    #: kind "loads".
    load_deviation: float = 0.5

    #: Shares of their strength that ties and other limited forces use at most, in the first starts of a scene
    #: with such forces. More shares find states in which ties do not yield more often.
    strength_shares: tuple[float, ...] = (0.75, 0.5, 0.25)

    #: Linear programs in a fixed-point iteration at most. More programs seldom change the state.
    fixed_point_iterations: int = 15

    #: Joints of a small scene in the plane at most, on which the default tries further starts. On larger
    #: scenes they take longer than all other steps together.
    small: int = 60

    #: Rate above which a yield condition is in the support of a mechanism. If smaller, rounding adds to the
    #: support; if larger, slow parts of a mechanism are left out.
    at_rest: float = 1e-9

    #: Slack below which a condition is at yield. If smaller, rounding hides conditions at yield; if larger,
    #: mechanisms move conditions that are not at yield.
    at_yield: float = 1e-7

    #: Size below which HiGHS drops entries of a program; its own default is 1e-9. If larger, rows of joints
    #: that are skew by less contradict each other; if smaller, rounding counts.
    smallest_entry: float = 1e-12

    #: Largest number of times that forces are replaced by nearer ones. More repairs seldom lead lower.
    repairs: int = 2

    #: Time limit of a program, in seconds for each joint. Without a limit HiGHS may run for ever.
    seconds_per_joint: float = 0.2

    #: Weight of the energy z·p over λ if a mechanism is known roughly. If smaller, more energy is left: on
    #: façades half as much again with 10. If larger, λ is higher: by up to 0.2 % with 100.
    weight: float = 30.0

    #: Weights of the energy over λ, in turn, of the alternation in the plane. Smaller weights let λ fall
    #: further, and larger ones leave less energy.
    weights_in_plane: tuple[float, ...] = (1e3, 1e4)

    #: Series of weights of the alternation in space. The next series is tried if one leads to no state.
    #: Weights that rise slowly lead lower. Large weights from the start stay near the first forces, which
    #: helps on many rings of wedges.
    weight_series_in_space: tuple[tuple[float, ...], ...] = (
        (3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 1e4),
        (*5 * [1e4], *2 * [1e5, 1e6]),
    )

    #: Tolerances of the interior points in space; the next one is tried if the solver does not reach one. In
    #: the plane only the first one is tried. If larger, yield is violated more: at 1e-10 by 3e-8 on façades.
    tolerances: tuple[float, ...] = (1e-11, 1e-10, 1e-9)

    #: Largest energy of a state of the alternation, relative to λ. If larger, states are less exact; if
    #: smaller, more starts lead to none.
    largest_energy: float = 1e-5


#: Default settings of method "coulomb", with and without its option ``search``.
SEARCH = SearchSettings()

"""Tests of Goodman & Bray (1976), Toppling of rock slopes: the bolt that holds a slope of 16 columns.

Their limit equilibrium transfers forces downwards from column to column. Each column is stable, topples about
its lower corner or slides on its base, whichever needs the largest force from the next column. Every side
joint below the first column that moves has its full friction.

Their mechanism with these forces is one exact Coulomb state of the scene, and not the only one. Side joints
between columns that slide together have no slip, and need not have their full friction. Other columns may
slide or topple. The largest bolt belongs to the least load factor.

So two questions have two answers. The textbook's bolt is enough if the friction between columns without
relative slip is fully mobilised. If it is not, collapse is possible up to the largest bolt of any exact
state.

In the state of the largest bolt known at a friction of 0.65, columns 13 to 7 topple and 6 to 1 slide as one.
In the textbook, columns 13 to 5 topple and 4 to 1 slide.
"""

import math

import numpy as np
import pytest
from scenes import CASES, solved, values_of

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.refiner import Refiner
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.answer import certify
from masonry_opt.solution.reasons import Code

SLOPE = CASES / "goodman_bray" / "slope.toml"
LIMITING = CASES / "goodman_bray" / "slope_limiting.toml"

COLUMNS = 16
CREST = 10
WIDTH = 10.0
UNIT_WEIGHT = 25.0
RISE = 5.0
BOLT = 10_000.0


def height(column: int) -> float:
    return 4.0 * min(column, CREST) - 6.0 * max(column - CREST, 0)


def arms(column: int) -> tuple[float, float]:
    """Return the heights above a column's base at which the column above presses, and at which it presses on.

    Each force acts at the top of the lower of two columns. Tops rise and fall by 5 m from column to column.
    """
    from_above = height(column) if column < CREST else height(column) - RISE
    to_below = height(column) if column > CREST else height(column) - RISE
    return from_above, to_below


def limit_equilibrium(friction: float) -> tuple[float, dict[int, str]]:
    """Return the bolt, and the mode of each column that moves: "topples" or "slides".

    The equations are Goodman & Bray's, for the forces that prevent toppling and sliding, and for the bolt on
    column 1.
    """
    sin, cos = 0.5, math.sqrt(0.75)
    force, modes = 0.0, {}
    for column in range(COLUMNS, 1, -1):
        weight = UNIT_WEIGHT * WIDTH * height(column)
        from_above, to_below = arms(column)
        overturning = weight / 2 * (height(column) * sin - WIDTH * cos)
        toppling = (force * (from_above - friction * WIDTH) + overturning) / to_below
        sliding = force - weight * (friction * cos - sin) / (1 - friction**2)
        force = max(toppling, sliding, 0.0)
        if force > 0:
            modes[column] = "topples" if force == toppling else "slides"
    weight = UNIT_WEIGHT * WIDTH * height(1)
    plunge = math.radians(34)
    modes[1] = "slides"
    driving = force * (1 - friction**2) - weight * (friction * cos - sin)
    return driving / (friction * math.sin(plunge) + math.cos(plunge)), modes


def velocities(modes: dict[int, str], length_unit: float) -> np.ndarray:
    """Return the velocities of their mechanism.

    Columns that topple turn about their lower left corners, and push each other along. Columns that slide
    move as one.
    """
    d = np.zeros((COLUMNS, 3))
    pushed = 1.0
    for column in sorted(modes, reverse=True):
        if modes[column] == "topples":
            from_above, to_below = arms(column)
            turn = pushed / from_above
            d[column - 1] = -turn * height(column) / 2, turn * WIDTH / 2, turn * length_unit
            pushed = turn * to_below
        else:
            d[column - 1, 0] = -pushed
    return d.ravel()


@pytest.mark.parametrize(("friction", "published", "digits"), [(0.65, 2010.36, 0.01), (0.7855, 0.5, 0.05)])
def test_formulas_give_the_known_bolts(friction, published, digits):
    assert limit_equilibrium(friction)[0] == pytest.approx(published, abs=digits)


@pytest.mark.parametrize("path", [SLOPE, LIMITING], ids=["0.65", "0.7855"])
def test_the_textbook_gives_an_exact_coulomb_state(path):
    """Their mechanism has a single load factor, that of the textbook's bolt, and satisfies all Coulomb
    conditions.

    All side joints down to column 1 have full friction in this state.
    """
    scene = mo.load(path)
    assembly = assemble(scene)
    problem = assembly.problem
    bolt, modes = limit_equilibrium(scene.joints.friction)
    d = velocities(modes, problem.length_unit)
    d *= problem.live_norm / (problem.live @ d)
    p = problem.rates(d, problem.dilatancy)
    assert np.abs(problem.departure(d, p, problem.dilatancy)).max() < 1e-12 * np.abs(d).max()
    support = p > 1e-9
    refiner = Refiner(problem, Effort())
    # The largest bolt, with any friction between columns that slide together.
    largest = refiner.least(support, d)
    first, second = (assembly.names(end) for end in (assembly.joints.first, assembly.joints.second))
    pairs = [frozenset(pair) for pair in zip(first, second, strict=True)]
    k, slides_first = len(problem.sliding), max(n for n, mode in modes.items() if mode == "slides")

    def faces(column: int) -> np.ndarray:
        joint = pairs.index(frozenset((f"column {column}", f"column {column + 1}")))
        return np.flatnonzero(problem.sliding == joint) + np.array([0, k])

    sense = support[faces(slides_first + 1)]
    assert sense.sum() == 1
    for column in range(1, slides_first + 1):
        support[faces(column)[sense]] = True
    textbook = refiner.least(support, d)
    assert BOLT * (1 - textbook.load_factor) == pytest.approx(bolt, abs=1e-6)
    exact = certify(problem, textbook.load_factor, textbook.q, d, problem.dilatancy)
    assert exact.worst < 1e-9
    assert BOLT * (textbook.load_factor - largest.load_factor) > 1000
    assert scene.reference["mcp" if path == SLOPE else "textbook"].value == pytest.approx(
        1 - bolt / BOLT, rel=1e-9
    )


@pytest.mark.slow
def test_less_friction_needs_more_than_the_textbooks_bolt():
    """Method "coulomb" finds an exact state that needs a larger bolt than the textbook's.

    The associative bolt is the least of all.
    """
    coulomb, associative = solved(SLOPE), solved(SLOPE, "static")
    assert coulomb.certificate.worst < 1e-8
    assert BOLT * (1 - coulomb.load_factor) > limit_equilibrium(0.65)[0]
    assert BOLT * (1 - associative.load_factor) == pytest.approx(236.568, abs=0.05)


@pytest.mark.slow
def test_at_the_limiting_friction_a_bolt_is_needed_that_the_associative_state_does_not_need():
    """At the limiting friction, the incremental bolt is the textbook's 0.5 kN, but nearby exact states need
    more.

    The associative state needs no bolt and has 142 kN to spare. It is also an exact state of joints that do
    not dilate.
    """
    result = solved(LIMITING, incremental=True)
    assert BOLT * (1 - result.incremental) == pytest.approx(limit_equilibrium(0.7855)[0], abs=0.5)
    assert BOLT * (1 - result.associative) == pytest.approx(-142.13, abs=0.05)
    for each in (result, solved(LIMITING)):
        assert each.exact
        assert each.load_factor < 1
    assert values_of(result, Code.STATES_MET)["most"] == pytest.approx(result.associative, rel=1e-6)


@pytest.mark.slow
def test_the_default_finds_the_largest_bolt_known():
    """The default finds 4,555 kN where the textbook has 2,010 kN: its state does not have the least load
    factor.

    At the limiting friction, searches of minutes find 2,241 kN where the textbook has 0.5 kN.
    """
    found = solved(SLOPE, "coulomb")
    assert found.certificate.worst < 1e-8
    assert found.load_factor <= mo.load(SLOPE).reference["refined"].value * (1 + 1e-4)

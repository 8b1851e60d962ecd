"""Tests of Paterson & Zwick (2009), Overhang: how far stacks of smooth blocks of length 1 extend beyond a
table."""

import numpy as np
import pytest
from scenes import solved
from scipy.optimize import linprog

import masonry_opt as mo
from masonry_opt.scene.blocks import rectangle
from masonry_opt.solution.reasons import Code

HEIGHT = 0.25


def stone(name: str, left: float, row: int, length: float = 1.0, **loads: object) -> mo.Block:
    corners = rectangle(left, left + length, row * HEIGHT, (row + 1) * HEIGHT)
    return mo.Block(name=name, vertices=corners, weight=1, **loads)


def table(right: float = 0.0) -> mo.Block:
    return mo.Block(name="table", vertices=rectangle(-10, right, -1, 0), fixed=True)


def best_of_three(length: float, inward: float) -> mo.Scene:
    """Return two blocks of the given length side by side on a block of length 1."""
    loaded = {"live": (0, -1), "live_at": (length - inward, 2 * HEIGHT)}
    upper = stone("right", -inward, 1, length, **loaded), stone("left", -length - inward, 1, length)
    return mo.Scene(joints={"friction": 0.0}, blocks=[*upper, stone("base", -0.5 - inward, 0), table()])


def test_no_three_blocks_reach_farther_than_one():
    """Two blocks that are centred on the ends of the block below fall if they are longer, and do not if
    shorter."""
    assert solved(best_of_three(1 - 1e-4, 1e-4), "static").status is mo.Status.OPTIMAL
    assert solved(best_of_three(1 + 1e-4, 1e-4), "static").status is mo.Status.UNSTABLE


def diamond(size: int, friction: float = 0.0) -> mo.Scene:
    """Return rows of 1, 2, ..., size, ..., 2, 1 blocks on the table, loaded on the ends of the middle row."""
    rows = [size - abs(row - size + 1) for row in range(2 * size - 1)]
    blocks = [
        stone(f"{row}-{number}", number - count / 2, row, live=(0, -1 if count == size and end else 0))
        for row, count in enumerate(rows)
        for number in range(count)
        for end in [number in (0, size - 1)]
    ]
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[*blocks, table(right=1.0)])


def balance(size: int) -> float | None:
    """Return the largest multiple of the load on the two ends under which the diamond is in equilibrium.

    This is the paper's definition of balance as a linear program: vertical forces at the ends of every bed
    keep every block in equilibrium. Returns None if no forces do.
    """
    rows = [size - abs(row - size + 1) for row in range(2 * size - 1)]
    centre = {(r, i): i - (count - 1) / 2 for r, count in enumerate(rows) for i in range(count)}
    index = {block: k for k, block in enumerate(centre)}
    beds = [((0, 0), None, x) for x in (-0.5, 0.5)]
    beds += [
        (above, below, x)
        for above in centre
        for below in centre
        if above[0] == below[0] + 1 and abs(centre[above] - centre[below]) == 0.5
        for x in sorted((centre[above], centre[below]))
    ]
    # The end of a block is above the middle of another block: each half bed lies between the two centres.
    rows_of = np.zeros((2 * len(index), len(beds) + 1))
    held = np.zeros(2 * len(index))
    for bed, (above, below, x) in enumerate(beds):
        for block, sense in ((above, 1.0), (below, -1.0)):
            if block is not None:
                rows_of[2 * index[block], bed] += sense
                rows_of[2 * index[block] + 1, bed] += sense * (x - centre[block])
    held[::2] = 1.0
    for end in ((size - 1, 0), (size - 1, size - 1)):
        rows_of[2 * index[end], -1] = -1.0
    cost = np.zeros(len(beds) + 1)
    cost[-1] = -1.0
    found = linprog(cost, A_eq=rows_of, b_eq=held, method="highs")
    return None if found.status == 2 else float(found.x[-1])


@pytest.mark.slow
@pytest.mark.parametrize("size", [3, 4])
def test_diamonds_of_up_to_four_stand(size, short_motions):
    """The default and the static program agree with the balance of the paper, to 1e-8.

    The load history of the default is undecided, because smooth blocks move slowly without limit. Its motions
    are short here. The test of all cases solves the diamond of four with motions of full length.
    """
    expected = balance(size)
    assert expected == pytest.approx({3: 1.0, 4: 1 / 6}[size], rel=1e-9)
    for method in ("static", "coulomb"):
        result = mo.solve(diamond(size), method, incremental=False)
        assert result.load_factor == pytest.approx(expected, rel=1e-8)


def test_the_diamond_of_two_stands_whatever_it_carries():
    """The diamond of two carries any load, because the middle of either end rests on the end of the block
    below."""
    assert solved(diamond(2), "static").status is mo.Status.UNLIMITED


def test_the_diamond_of_five_falls():
    assert balance(5) is None
    for method in ("static", "coulomb"):
        assert solved(diamond(5), method).status is mo.Status.UNSTABLE


@pytest.mark.slow
def test_friction_holds_the_diamond_of_five():
    """With friction, the diamond of five is stable from rest, and carries as much as with associative flow.

    Rows lock where sliding lifts the blocks above. From rest they also lock without dilatancy. With the worst
    self-stress, friction does not hold the rows.
    """
    associative = solved(diamond(5, friction=0.5), "static").load_factor
    assert associative > 0.2
    result = mo.solve(diamond(5, friction=0.5))
    assert result.incremental == pytest.approx(associative, rel=1e-7)
    assert Code.BELOW_ZERO in [said.code for said in result.reasons]

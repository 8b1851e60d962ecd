"""The incremental load factor that every Coulomb method adds to its answer, computed once and optional."""

from importlib import import_module

import pandas as pd
import pytest
from atlas.random_scenes import random_scene
from atlas.small_scenes import confined
from scenes import (
    CASES,
    WALLS,
    block_on_floor,
    on_floor,
    pressed_down,
    small_wall,
    solved,
    two_blocks,
    values_of,
)
from second_program import bounds, random_of_any_kind

import masonry_opt as mo
from masonry_opt.methods import associative
from masonry_opt.methods.incremental import method as incremental_method
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.blocks import rectangle
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Code

TWO_BLOCKS = CASES / "gilbert" / "two_blocks.toml"


def column() -> mo.Scene:
    """Return a column of three cubes, which tips about its foot at λ = (3 · ½) / (½ + 1½ + 2½) = 1/3."""
    push = {"weight": 1, "live": (1, 0)}
    drums = [mo.Block(name=f"drum {y}", vertices=rectangle(0, 1, y, y + 1), **push) for y in range(3)]
    return on_floor(*drums)


@pytest.fixture
def asked(watched):
    """Return the list of calls of the incremental method, except the default's own calls.

    The default imports the function before it is replaced.
    """
    import_module("masonry_opt.methods.coulomb.method")
    return watched(incremental_method, "incremental")


@pytest.mark.parametrize(
    ("scene", "by_hand"),
    [(block_on_floor(friction=0.3), 0.3), (block_on_floor(friction=0.6), 0.5), (column(), 1 / 3)],
    ids=["slides", "tips", "column"],
)
def test_where_forces_are_determinate_all_three_are_one(scene, by_hand):
    result = mo.solve(scene)
    three = [result.load_factor, result.incremental, result.associative]
    assert three == pytest.approx([by_hand] * 3, rel=1e-6)
    assert result.incremental_reasons[0].code is Code.COLLAPSE


def test_on_a_wall_it_is_what_method_incremental_finds():
    result, alone = solved(WALLS[0], incremental=True), solved(WALLS[0], "incremental")
    assert result.incremental == result.end == alone.load_factor == alone.incremental == alone.end
    assert result.incremental_reasons == alone.reasons
    assert result.load_factor * (1 - 1e-6) <= result.incremental < result.associative
    state = result.at_incremental
    assert (state.kind, state.load_factor) == (Kind.INCREMENTAL, alone.load_factor)
    assert state.associative == result.associative
    pd.testing.assert_frame_equal(state.joints, alone.joints, check_exact=True)
    assert (state.iterations, alone.at_incremental) == (alone.iterations, alone)


@pytest.mark.slow
def test_blocks_move_on_under_a_lower_load():
    """The largest load factor of a history that then falls to less than half of it is reported.

    The value agrees with explicit dynamics to 1 % (tests/incremental/test_method.py).
    """
    result = mo.solve(random_scene("tessellation", 910061))
    assert result.incremental == pytest.approx(0.320973, rel=3e-3)
    assert result.end < 0.5 * result.incremental < result.associative
    assert result.at_incremental.exact
    assert (result.at_incremental.load_factor, result.at_incremental.incremental) == (
        result.end,
        result.incremental,
    )
    assert f"after the collapse begins, the moving blocks carry only λ = {result.end:.6g}" in result.summary


@pytest.mark.slow
def test_a_load_that_exceeds_the_weights_ten_thousandfold_stays_below_the_bound():
    """The incremental load factor is that of an independent linear program, to 1e-7.

    No slip occurs, so all load factors are equal. Unbalanced forces within the tolerance, which is relative
    to the load, could carry 1.00005 times this bound.
    """
    scene = random_of_any_kind(1_600_467)
    found = bounds(assemble(scene))
    assert found.inside == pytest.approx(found.outside, rel=1e-9)
    result = mo.solve(scene, "incremental")
    assert result.at_incremental.exact
    assert result.incremental == pytest.approx(found.inside, rel=1e-7)
    assert found.inside > 1e5


@pytest.mark.slow
def test_blocks_that_move_on_without_load_leave_the_largest_load():
    result = mo.solve(random_scene("tessellation", 910020), "incremental")
    assert (result.load_factor, result.end) == (None, None)
    assert 0.07 < result.incremental < result.associative
    assert "after the collapse begins, the blocks continue to move even without live load" in result.summary


@pytest.mark.parametrize("method", ["coulomb", "nonassociative", "mpec", "global"])
def test_every_coulomb_method_tells_it_and_its_answer_is_the_same(method, asked):
    """Each Coulomb method computes the incremental load factor once, and without it has the same answer.

    Steps and solves are counted without the incremental analysis. Methods that begin with a load history
    use the history of the incremental load factor.
    """
    steps, without = [], []
    result = mo.solve(two_blocks(), method, progress=steps.append)
    assert len(asked) == 1
    off = mo.solve(two_blocks(), method, incremental=False, progress=without.append)
    assert len(asked) == 1
    assert (off.incremental, off.at_incremental, off.incremental_reasons) == (None, None, ())
    assert result.incremental == pytest.approx(solved(two_blocks(), "incremental").incremental, rel=1e-9)
    assert off.seconds["incremental"] == 0 < result.seconds["incremental"]
    for name in ("load_factor", "exact", "associative"):
        assert getattr(result, name) == pytest.approx(getattr(off, name), rel=1e-12)
    assert len(steps) == len(without)
    if method in ("coulomb", "global"):
        return
    for name in ("iterations", "lp_solves", "nlp_solves"):
        assert getattr(result, name) == getattr(off, name)
    rows = [of.history.drop(columns="seconds", errors="ignore") for of in (result, off)]
    pd.testing.assert_frame_equal(*rows)


@pytest.mark.parametrize("method", ["static", "kinematic"])
def test_of_an_associative_answer_it_is_not_asked(method, asked):
    result = mo.solve(two_blocks(), method)
    assert (result.incremental, result.at_incremental, asked) == (None, None, [])


def comb(number: int) -> mo.Block:
    """Return a block with 20 feet on a floor."""
    left = 41 * number
    feet = [(left + foot + x, y) for foot in range(0, 40, 2) for x, y in ((0, 0), (1, 0), (1, 0.5), (2, 0.5))]
    corners = [*feet[:-2], (left + 39, 1), (left, 1)]
    return mo.Block(name=f"comb {number}", vertices=corners, weight=1, live=(1, 0))


@pytest.mark.slow
def test_where_there_is_none_the_reason_says_why(asked):
    endless = mo.solve(pressed_down())
    assert endless.incremental is None
    assert endless.incremental_reasons == tuple(endless.at_incremental.solution.reasons)
    assert endless.at_incremental.load_factor is None
    floor = mo.Block(name="floor", vertices=rectangle(-1, 41 * 151, -1, 0), fixed=True)
    combs = [comb(number) for number in range(151)]
    large = mo.solve(mo.Scene(joints={"friction": 0.6}, blocks=[*combs, floor]), "nonassociative")
    assert (large.incremental, len(asked)) == (None, 1)
    assert values_of(large.at_incremental, Code.NOT_COMPUTED) == {"joints": 151 * 20}
    stressed = small_wall(dilatancy=0.2, dilatancy_stress=(0.1, 1.0))
    falling = mo.solve(stressed, "nonassociative")
    assert [reason.code for reason in falling.incremental_reasons] == [Code.DILATANCY_FALLS]
    assert len(asked) == 1


def test_an_associative_load_factor_that_is_none_is_looked_for_once(watched, certificates):
    """An associative load factor that does not exist is computed only once.

    A block between floor and ceiling carries any multiple of its load by statics. No load history ends in an
    exact state here.
    """
    certificates(1.0)
    solved = watched(associative, "associative")
    result = mo.solve(confined(0.5)(CASES), incremental=False)
    assert (result.associative, len(solved)) == (None, 1)
    assert not result.solution.proven_none


def test_the_command_tells_it_and_leaves_it_out(command, tmp_path):
    said = [
        command.json("solve", TWO_BLOCKS, flag)["incremental"]
        for flag in ("--incremental", "--no-incremental")
    ]
    assert said == [pytest.approx(solved(two_blocks(), "incremental").incremental, rel=1e-9), None]
    mo.save(pressed_down(), case := tmp_path / "pressed.toml")
    command("solve", case, code=1)


@pytest.mark.slow
def test_the_command_draws_the_mechanism_of_either(command, tmp_path):
    """The option --mechanism draws the state of either load factor; wall 1 has two different mechanisms."""
    pages = {}
    for which in ("least", "incremental"):
        page = tmp_path / f"{which}.html"
        command("solve", WALLS[0], "--plot", page, "--mechanism", which)
        pages[which] = page.read_text("utf-8")
    solved(WALLS[0], incremental=True).at_incremental.save(alone := tmp_path / "alone.html")
    assert pages["incremental"] == alone.read_text("utf-8") != pages["least"]


@pytest.mark.parametrize(
    "options",
    [
        ["--mechanism", "incremental"],
        ["--plot", "a.png", "--mechanism", "most"],
        ["--plot", "a.png", "--mechanism", "incremental", "--no-incremental"],
        ["--plot", "a.png", "--mechanism", "incremental", "--method", "static"],
    ],
)
def test_a_mechanism_that_cannot_be_drawn_is_refused_before(command, asked, options):
    assert "--mechanism" in command.refused("solve", TWO_BLOCKS, *options)
    assert asked == []

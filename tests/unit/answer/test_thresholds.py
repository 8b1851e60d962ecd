"""One table of thresholds: every room of an answer counts the same blocks, joints and load factors."""

import re
from dataclasses import replace

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from scenes import CASES, values_of

import masonry_opt as mo
from masonry_opt.answer.answer import Found
from masonry_opt.answer.motion import joint_motion, moving_blocks
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.thresholds import MOVES, SAME, SLIDES, is_lower, same
from masonry_opt.studies.many.runs import mechanism


def side_by_side(*beyond):
    """Blocks 3 wide, each on a ledge of its own, with their centroids so far beyond its edge."""
    blocks = []
    for number, share in enumerate(beyond):
        x, name = 10 * number, chr(ord("A") + number)
        edge = x + 1.5 - share
        corners = [(x, 0), (x + 3, 0), (x + 3, 1), (x, 1)]
        ledge = [(x - 1, -1), (edge, -1), (edge, 0), (x - 1, 0)]
        blocks += [
            mo.Block(name=name, vertices=corners, weight=1, live=(1, 0)),
            mo.Block(name=f"under {name}", vertices=ledge, fixed=True),
        ]
    return mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=blocks)


@pytest.mark.parametrize("little", [0.0015, 0.003, 0.006, 0.02, 0.5])
def test_words_name_the_blocks_that_the_summary_counts(little):
    """The second block begins to fall the more slowly the less it overhangs: never in one line alone."""
    result = mo.solve(side_by_side(1.0, little))
    names = values_of(result, Code.FALLS)["blocks"]
    assert values_of(result, Code.NO_FRICTION_HOLDS)["blocks"] == names
    counted = re.search(r"^falls +(\d+) of 2 blocks", result.summary, re.MULTILINE)
    assert int(counted[1]) == len(names)
    speeds = result.blocks.set_index("block")[["vx", "vy"]].abs().max(axis=1)
    # Both turn about the edge of their ledge, so that corners are as much faster than centroids.
    assert names == (["A", "B"] if speeds["B"] > MOVES * speeds["A"] else ["A"])


@pytest.mark.parametrize("seed", [911, 914, 917])
def test_the_joints_that_more_friction_would_hold_are_those_that_slide_in_the_picture(seed):
    """Seeds of which some joints slip as they come apart: friction has nothing to hold there."""
    result = mo.solve(random_scene("tessellation", seed), "static")
    slides = joint_motion(result.assembly, result.solution).slides
    named = result.joints.loc[slides, ["first", "second"]].to_numpy().tolist()
    slips = result.joints["slip"].abs() > SLIDES * result.blocks[["vx", "vy"]].abs().to_numpy().max()
    assert slips.sum() > len(named) > 0
    assert sorted(values_of(result, Code.FRICTION_WOULD_HOLD)["pairs"]) == sorted(named)


@pytest.mark.parametrize(("share", "moves"), [(0.5, False), (2.0, True)])
def test_a_joint_slides_and_its_block_moves_from_the_same_share_on(share, moves):
    """Side by side, one fast and one slow: each slides on its ledge by what it is given, by hand."""
    result = mo.solve(side_by_side(0.0, 0.0), "static")
    slow = share * MOVES
    found = Found(d=np.array([1.0, 0, 0, slow, 0, 0]), slope=np.zeros(2))
    solution = replace(result.solution, found=found)
    assert list(moving_blocks(result.assembly, solution.d)) == ([0, 1] if moves else [0])
    motion = joint_motion(result.assembly, solution)
    assert motion.slides.tolist() == [True, moves]
    assert mechanism(result.assembly, solution)["slides"] == 1 + moves


def test_load_factors_of_one_state_are_the_same_and_of_two_are_not():
    """Wall 1: the linear program by two solvers; the loop's state and the default's, 1e-3 apart."""
    wall = CASES / "ferris_tinloi" / "wall_1.toml"
    one, other = (mo.solve(wall, "static", solver=solver).required() for solver in ("clarabel", "highs"))
    low, high = (mo.solve(wall, method).required() for method in ("mcp", "nonassociative"))
    assert same(one, other)
    assert not same(low, high)
    assert is_lower(low, high)
    assert not is_lower(high, low)


@pytest.mark.parametrize("size", [0.0, 1e-3, 1.0, 1e3])
def test_same_is_symmetric_and_relative_from_a_hundredth_on(size):
    far = SAME * max(size, 0.01)
    assert same(size, size + 0.9 * far)
    assert same(size + 0.9 * far, size)
    assert not same(size, size + 1.1 * far)

"""Scenes with ranks known by hand show whether equilibrium alone determines all joint forces."""

import numpy as np
import pytest
import scipy.sparse as sp
from scenes import block_on_floor, two_blocks
from scipy.sparse.csgraph import structural_rank
from speeds import slow
from touching_solids import FLOOR, hull

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.rank import has_independent_columns
from masonry_opt.solution.reasons import Code


def prism_on_its_edge() -> mo.Scene:
    """Return a triangular prism of weight 1, balanced on an edge along y and pushed along the edge by 0.12.

    The live load lifts the prism. By hand, the prism slides along the edge when friction μ (1 − λ) = 0.12.
    Equilibrium does not determine how the shear along the edge is divided between its two ends.
    """
    corners = [(off, y, z) for y in (-1.5, 1.5) for off, z in ((0, 0), (-1, 1), (1, 1))]
    loads = {"weight": 1.0, "dead": (0, 0.12, 0), "live": (0, 0, 1)}
    return mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=[hull("prism", corners, **loads), FLOOR])


def test_the_structural_rank_of_a_knife_edge_is_full_and_its_rank_is_not():
    problem = assemble(prism_on_its_edge()).problem
    assert structural_rank(problem.B) == problem.B.shape[1] == 6
    assert np.linalg.matrix_rank(problem.B.toarray()) == 5
    assert not problem.statics_fix_forces


@pytest.mark.parametrize("method", ["coulomb", *slow("nonassociative")])
def test_the_state_of_a_knife_edge_is_not_called_the_only_one(method):
    result = mo.solve(prism_on_its_edge(), method)
    assert result.load_factor == pytest.approx(1 - 0.12 / 0.6, rel=1e-6)
    assert [said.values["fixed"] for said in result.reasons if said.code is Code.NO_WORK] == [False]
    assert not result.solution.is_only_state
    assert "other state" not in result.summary
    assert "not proven to be the least" in result.summary


@pytest.mark.parametrize(("blocks", "fixed"), [(1, True), (30, True), (501, False)])
def test_a_stack_in_the_plane_is_statically_determinate(blocks, fixed):
    """The last stack is so large that its rank is not computed, and nothing is claimed for it."""
    stones = [
        mo.Block(name=f"{y}", vertices=[(0, y), (1, y), (1, y + 1), (0, y + 1)], weight=1, live=(1, 0))
        for y in range(blocks)
    ]
    ground = mo.Block(name="ground", vertices=[(-3, -1), (4, -1), (4, 0), (-3, 0)], fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=[*stones, ground])
    assert assemble(scene).problem.statics_fix_forces is fixed


def test_two_supports_make_a_block_statically_indeterminate():
    assert assemble(block_on_floor()).problem.statics_fix_forces
    assert not assemble(two_blocks()).problem.statics_fix_forces


@pytest.mark.parametrize("ratio", [1e-12, 1.0, 1e12])
def test_units_of_rows_and_columns_do_not_change_the_rank(ratio):
    """Scaling of a row and a column does not change the rank, which is full for the first matrix only."""
    units = np.array([1.0, ratio, 1.0])
    independent = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]])
    dependent = np.array([[1.0, 2.0, 3.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]])
    for matrix, full in ((independent, True), (dependent, False)):
        scaled = units[:, None] * matrix * units[::-1]
        assert has_independent_columns(sp.csr_array(scaled)) is full
